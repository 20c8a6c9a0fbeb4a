//! From a checked configuration to what the instrument runs with.

use super::pairs;
use super::{Characteristic, Config};
use crate::circuit::Node;
use crate::instrument::settings::{OffsetSource, Settings};
use crate::sensor::{Channel, Force};
use crate::stream::tape::{Header, TapeCircuit};
use crate::units::Nanos;

/// Why a configuration that passes its check still cannot be run.
#[derive(Debug, thiserror::Error)]
#[error("channel {id:?}: force: {reason}")]
pub struct SettingsError {
    /// The channel whose force table is not usable.
    pub id: String,
    /// Why.
    pub reason: String,
}

impl Config {
    /// What the instrument runs with, of a configuration that has passed [`Config::check`].
    ///
    /// # Errors
    /// A force table that cannot be read or is not monotone.
    pub fn settings(&self) -> Result<Settings, SettingsError> {
        let circuit = &self.circuit;
        let channels = self.channels.iter().map(|channel| {
            let force = match &channel.force {
                Some(Characteristic::Given(force)) => Some(force.clone()),
                Some(Characteristic::File(file)) => {
                    let table = pairs::load_table(&self.path(file));
                    let failed = |reason| SettingsError { id: channel.id.clone(), reason };
                    Some(Force::Table { table: table.map_err(failed)? })
                }
                None => None,
            };
            Ok(Channel { id: channel.id.clone(), zero_ohm: channel.zero_ohm, force })
        });
        Ok(Settings {
            method: self.method(),
            kind: circuit.kind(),
            r_c_ohm: [circuit.r_c1.0, circuit.r_c2.0],
            nominal: Nanos::from_seconds(circuit.crossing(Node::A, circuit.r_c1).unwrap_or_default().0),
            drain: self.drain_time(),
            charge: self.charge_time(),
            settle: self.settle_time(),
            deadline: self.deadline(),
            period: self.measure.rate_hz.map(|hertz| Nanos::from_seconds(1.0 / hertz)),
            offset_ns: match self.offset() {
                OffsetSource::Auto => None,
                OffsetSource::Given(d_ns) => Some(d_ns),
            },
            resolution: self.measure.resolution.unwrap_or(Nanos(1)),
            tracked: self.is_tracked(),
            t_l: self.measure.t_l,
            switch_fraction: self.switch_fraction(),
            channels: channels.collect::<Result<_, _>>()?,
        })
    }
}

/// The header of what an instrument with these settings records. `found_ns`: the latency offset where it had to be found, and
/// has been.
pub fn tape_header(settings: &Settings, found_ns: Option<f64>) -> Header {
    let [r_c1_ohm, r_c2_ohm] = settings.r_c_ohm;
    let circuit = TapeCircuit { kind: settings.kind, r_c1_ohm, r_c2_ohm };
    Header::new(circuit, settings.offset_ns.or(found_ns), settings.channels.clone())
}
