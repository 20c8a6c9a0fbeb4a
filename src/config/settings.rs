//! From a checked configuration to what the instrument runs with.

use super::pairs;
use super::{ChannelTable, Characteristic, Config, ForceSource, LawSource};
use crate::circuit::Node;
use crate::estimate::offset::Offset;
use crate::instrument::settings::{OffsetSource, Settings};
use crate::sensor::table::Tabled;
use crate::sensor::{Channel, Force, Law, Transducer};
use crate::stream::tape::{Header, PROTO_MAJOR, TapeCircuit, TapeLooks, TapeOffset};
use crate::units::Nanos;

/// Why a configuration that passes its check still cannot be run.
#[derive(Debug, thiserror::Error)]
#[error("channel {id:?}: {key}: {reason}")]
pub struct SettingsError {
    /// The channel whose table is not usable.
    pub id: String,
    /// "force" or "law".
    pub key: &'static str,
    /// Why.
    pub reason: String,
}

impl Config {
    /// What the instrument runs with, of a configuration that has passed [`Config::check`].
    ///
    /// # Errors
    /// A table that cannot be read or is not monotone.
    pub fn settings(&self) -> Result<Settings, SettingsError> {
        let circuit = &self.circuit;
        let channels = self.channels.iter().map(|channel| self.sensor(channel));
        Ok(Settings {
            method: self.method(),
            kind: circuit.kind(),
            r_c_ohm: [circuit.r_c1.0, circuit.r_c2.0],
            nominal: Nanos::from_seconds(circuit.crossing(Node::A, circuit.r_c1).unwrap_or_default().0),
            drain: self.drain_time(),
            charge: self.charges(),
            charge_ohm: self.measure.charge_time.is_none().then_some([circuit.r_charge.0, circuit.r_o.0]),
            settle: self.settle_time(),
            deadline: self.deadline(),
            period: self.period(),
            average: self.average(),
            offset_ns: match self.offset() {
                OffsetSource::Auto => None,
                OffsetSource::Given(d_ns) => Some(d_ns),
            },
            resolution: self.measure.resolution.unwrap_or(Nanos(1)),
            tracked: self.is_tracked(),
            t_l: self.measure.t_l,
            switch_fraction: self.switch_fraction(),
            every: self.channels.iter().map(|channel| channel.every).collect(),
            channels: channels.collect::<Result<_, _>>()?,
        })
    }

    /// A channel with its tables read.
    fn sensor(&self, channel: &ChannelTable) -> Result<Channel, SettingsError> {
        let failed = |key| move |reason| SettingsError { id: channel.id.clone(), key, reason };
        let force =
            channel.force.as_ref().map(|force| self.force(force)).transpose().map_err(failed("force"))?;
        let law = channel.law.as_ref().map(|law| self.law(law)).transpose().map_err(failed("law"))?;
        let ChannelTable { id, zero_ohm, scale, .. } = channel;
        Ok(Channel { id: id.clone(), zero_ohm: *zero_ohm, scale: *scale, force, law })
    }

    fn force(&self, Characteristic { law, u, range_n, tare_n }: &Characteristic) -> Result<Force, String> {
        let law = match law {
            ForceSource::Given(law) => law.clone(),
            ForceSource::File(file) => Law::Table { table: pairs::load_table(&self.base.join(file))? },
        };
        Ok(Force { law, u: *u, range_n: *range_n, tare_n: *tare_n })
    }

    fn law(&self, law: &LawSource) -> Result<Transducer, String> {
        Ok(match law {
            LawSource::Given(law) => law.clone(),
            LawSource::File { table, unit, u } => Transducer::Table(Tabled {
                table: pairs::load_values(&self.base.join(table))?,
                unit: unit.clone(),
                u: *u,
            }),
        })
    }
}

/// The header of what an instrument with these settings records. `found`: the latency offset where it had to be found, and
/// has been.
pub fn tape_header(settings: &Settings, found: Option<Offset>) -> Header {
    let [r_c1_ohm, r_c2_ohm] = settings.r_c_ohm;
    // Where it cancels and nobody has given it, it is not known.
    let is_known = |d_ns: f64| d_ns != 0.0 || settings.method.needs_offset();
    let found = found.filter(|found| is_known(found.d_ns));
    let offset = match settings.offset_ns.filter(|d_ns| is_known(*d_ns)) {
        Some(d_ns) => TapeOffset { offset_ns: Some(d_ns), ..TapeOffset::default() },
        None => found.map_or_else(TapeOffset::default, |found| TapeOffset {
            offset_ns: Some(found.d_ns),
            offset_u_ns: Some(found.u_d_ns),
            offset_by_switch: Some(found.by_switch),
            switch_u_ns: found.scatter.found_ns(),
            r_o_ohm: found.r_o_ohm.map(|(r_o_ohm, _)| r_o_ohm),
            r_o_u_ohm: found.r_o_ohm.map(|(_, u_ohm)| u_ohm),
        }),
    };
    Header {
        proto_major: PROTO_MAJOR,
        circuit: TapeCircuit { kind: settings.kind, r_c1_ohm, r_c2_ohm },
        resolution_ns: Some(settings.resolution.as_ns()),
        offset,
        looks: TapeLooks::default(),
        tracked: settings.tracked,
        channels: settings.channels.clone(),
    }
}
