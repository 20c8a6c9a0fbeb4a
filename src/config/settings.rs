//! From a checked configuration to what the instrument runs with.

use super::Config;
use crate::circuit::Node;
use crate::config;
use crate::estimate::force::{Table, TableError};
use crate::instrument::settings::{Channel, OffsetSource, Settings};
use crate::units::Nanos;

/// Why a configuration that passes its check still cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum SettingsError {
    /// A force table is not usable.
    #[error("channel {id:?}: force: {source}")]
    Table {
        /// The channel.
        id: String,
        /// Why.
        source: TableError,
    },
}

impl Config {
    /// What the instrument runs with, of a configuration that has passed [`Config::check`].
    ///
    /// # Errors
    /// A force table that cannot be read or is not monotone.
    pub fn settings(&self) -> Result<Settings, SettingsError> {
        let config = self;
        let circuit = &config.circuit;
        let channels = config.channels.iter().map(|channel| {
            let force = channel.force.clone().map(|force| {
                force
                    .try_map(|file| Table::load(&config.path(&file)))
                    .map_err(|source| SettingsError::Table { id: channel.id.clone(), source })
            });
            let force = force.transpose()?;
            Ok(Channel { id: channel.id.clone(), zero_ohm: channel.zero_ohm, force })
        });
        Ok(Settings {
            method: config.method(),
            kind: circuit.kind(),
            r_c_ohm: [circuit.r_c1.0, circuit.r_c2.0],
            nominal: Nanos::from_seconds(circuit.crossing(Node::A, circuit.r_c1).unwrap_or_default().0),
            drain: config.drain_time(),
            charge: config.charge_time(),
            settle: config.settle_time(),
            deadline: config.deadline(),
            period: config.measure.rate_hz.map(|hertz| Nanos::from_seconds(1.0 / hertz)),
            offset: match config.offset() {
                config::Offset::Auto => OffsetSource::Auto,
                config::Offset::Fixed(d) => OffsetSource::Given(d.as_ns()),
            },
            resolution: config.measure.resolution.unwrap_or(Nanos(1)),
            tracked: config.is_tracked(),
            t_l: config.measure.t_l,
            switch_fraction: config.switch_fraction(),
            channels: channels.collect::<Result<_, _>>()?,
        })
    }
}
