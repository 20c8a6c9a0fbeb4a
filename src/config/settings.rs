//! From a checked configuration to what the instrument runs with.

use super::Config;
use super::pairs::{self, PairsError};
use crate::circuit::Node;
use crate::estimate::force::Force;
use crate::instrument::settings::{Channel, OffsetSource, Settings};
use crate::stream::tape::{Header, TapeChannel, TapeCircuit, TapeForce};
use crate::units::Nanos;

/// Why a configuration that passes its check still cannot be run.
#[derive(Debug, thiserror::Error)]
#[error("channel {id:?}: force: {source}")]
pub struct SettingsError {
    /// The channel whose force table is not usable.
    pub id: String,
    /// Why.
    pub source: PairsError,
}

impl Config {
    /// What the instrument runs with, of a configuration that has passed [`Config::check`].
    ///
    /// # Errors
    /// A force table that cannot be read or is not monotone.
    pub fn settings(&self) -> Result<Settings, SettingsError> {
        let circuit = &self.circuit;
        let channels = self.channels.iter().map(|channel| {
            let force = channel.force.clone().map(|force| {
                force
                    .try_map(|file| pairs::load_table(&self.path(&file)))
                    .map_err(|source| SettingsError { id: channel.id.clone(), source })
            });
            let force = force.transpose()?;
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
    let channel = |channel: &Channel| TapeChannel {
        id: channel.id.clone(),
        zero_ohm: channel.zero_ohm,
        force: channel.force.as_ref().and_then(tape_force),
    };
    let offset_ns = settings.offset_ns.or(found_ns);
    let circuit = TapeCircuit { kind: settings.kind, r_c1_ohm, r_c2_ohm };
    Header::new(circuit, offset_ns, settings.channels.iter().map(channel).collect())
}

/// A tape gives the ohms; forces by a table or a power law are for the configuration to tell.
fn tape_force(force: &Force) -> Option<TapeForce> {
    match force {
        Force::Calibrated { fc1, fc2 } => Some(TapeForce::Pair { fc1_n: fc1.0, fc2_n: fc2.0 }),
        Force::Alpha(alpha) => Some(TapeForce::Alpha { alpha_n_ohm: alpha.0 }),
        Force::PowerLaw { .. } | Force::Table(_) => None,
    }
}
