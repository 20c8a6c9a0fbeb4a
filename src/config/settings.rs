//! From a checked configuration to what the instrument runs with.

use super::Config;
use super::pairs::{self, PairsError};
use crate::circuit::{Network, Node};
use crate::config;
use crate::estimate::force::{Force, Table};
use crate::instrument::settings::{Channel, OffsetSource, Settings};
use crate::pins::Drives;
use crate::stream::tape::{self, Header, TapeChannel, TapeCircuit, TapeForce};
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
        source: PairsError,
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
        let r_ohm = [circuit.r_c1.0, circuit.r_second().0];
        let channels = config.channels.iter().map(|channel| {
            let force = channel.force.as_ref().map(|force| load_force(config, force, r_ohm)).transpose();
            let force = force.map_err(|source| SettingsError::Table { id: channel.id.clone(), source })?;
            Ok(Channel { id: channel.id.clone(), zero_ohm: channel.zero_ohm, force })
        });
        Ok(Settings {
            method: config.method(),
            r_ohm,
            series: matches!(circuit.network, Network::SeriesCalibration { .. }),
            chargers: match circuit.network {
                Network::TwoCapacitor { .. } => Drives::CHARGE,
                _ => Drives::CHARGE_A,
            },
            nominal: Nanos::from_seconds(circuit.crossing(Node::A, circuit.r_c1).unwrap_or_default().0),
            last: config.last_node(),
            drain: config.drain_time(),
            charge: config.charge_time(),
            settle: config.settle_time(),
            deadline: config.deadline(),
            period: config.measure.rate_hz.map(|hertz| Nanos::from_seconds(1.0 / hertz)),
            offset: config.offset(),
            resolution: config.measure.resolution.unwrap_or(Nanos(1)),
            tracked: config.is_tracked(),
            t_l: config.measure.t_l,
            switch_fraction: config.switch_fraction(),
            channels: channels.collect::<Result<_, _>>()?,
        })
    }

    /// The header of what an instrument with this configuration records. An offset that is still to be found is absent.
    pub fn tape_header(&self, settings: &Settings) -> Header {
        let config = self;
        let kind = match config.circuit.network {
            Network::TwoCapacitor { .. } => tape::Kind::TwoCapacitor,
            Network::OneCapacitor { .. } => tape::Kind::OneCapacitor,
            Network::SeriesCalibration { .. } => tape::Kind::SeriesCalibration,
        };
        let channel = |channel: &config::ChannelTable| TapeChannel {
            id: channel.id.clone(),
            zero_ohm: channel.zero_ohm,
            force: match channel.force {
                Some(crate::config::Force::Calibrated { fc1, fc2 }) => {
                    Some(TapeForce::Pair { fc1_n: fc1.0, fc2_n: fc2.0 })
                }
                Some(crate::config::Force::Alpha(alpha)) => Some(TapeForce::Alpha { alpha_n_ohm: alpha.0 }),
                // A tape gives the ohms; forces by a table or power law are for the configuration to tell.
                Some(_) | None => None,
            },
        };
        let circuit = TapeCircuit { kind, r_c1_ohm: config.circuit.r_c1.0, r_c2_ohm: config.circuit.r_c2.0 };
        let offset_ns = match settings.offset {
            OffsetSource::Given(d_ns) => Some(d_ns),
            OffsetSource::Auto => None,
        };
        Header::new(circuit, offset_ns, config.channels.iter().map(channel).collect())
    }
}

fn load_force(config: &Config, force: &config::Force, r_ohm: [f64; 2]) -> Result<Force, PairsError> {
    Ok(match force {
        config::Force::Alpha(alpha) => Force::Alpha(alpha.0),
        config::Force::Calibrated { fc1, fc2 } => Force::Pair { r_ohm, f_n: [fc1.0, fc2.0] },
        config::Force::PowerLaw { at_1_kohm, exponent } => {
            Force::Power { scale: at_1_kohm.0 * 1000f64.powf(*exponent), exponent: *exponent }
        }
        config::Force::Table(file) => {
            let pairs = pairs::load(&config.path(file))?.iter().map(|pair| (pair.r_ohm, pair.f_n)).collect();
            Force::Table(Table::from_pairs(pairs)?)
        }
    })
}
