//! STATS: what the server and the instrument behind it have counted and learned.

use super::ChannelStats;
use crate::stream::line::{is_unknown, time, uncertainty, value};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// STATS: figures of the server and of the instrument behind it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "class", rename = "STATS")]
pub struct StatsLine {
    /// How many are connected.
    pub clients: u64,
    /// Readings that were published.
    pub published: u64,
    /// Lines that clients have lost, summed over the clients.
    pub lost: u64,
    /// What the daemon tells.
    #[serde(flatten)]
    pub instrument: InstrumentStats,
    /// What the last readings of each channel came to, by its id.
    #[serde(default)]
    pub channels: BTreeMap<String, ChannelStats>,
}

/// What the daemon tells of its instrument in STATS.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct InstrumentStats {
    /// The backend of `[gpio]`.
    pub backend: String,
    /// How readings are estimated.
    pub method: String,
    /// Whether the GPIO lines can be used at present.
    pub gpio_works: bool,
    /// Since the daemon was started, s.
    #[serde(serialize_with = "time")]
    pub uptime_s: f64,
    /// Cycles of the instrument.
    pub cycles: u64,
    /// Readings of every status.
    pub readings: u64,
    /// Readings with a number.
    pub ok: u64,
    /// Those of a sensor that changed while it was read.
    #[serde(default)]
    pub moving: u64,
    /// Readings above what the deadline resolves.
    pub open: u64,
    /// Readings that cannot be told from a short circuit.
    pub short: u64,
    /// Readings without a number, by the name of the fault.
    pub faults: BTreeMap<String, u64>,
    /// What on the board the faults look like, for people.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hint: Option<String>,
    /// The resistance of a leak beside the sensors, ohm.
    #[serde(serialize_with = "uncertainty", skip_serializing_if = "is_unknown")]
    pub leak_ohm: Option<f64>,
    /// The resistance of what feeds the nodes beside the chargers, as a pull-up does, ohm.
    #[serde(default, serialize_with = "uncertainty", skip_serializing_if = "is_unknown")]
    pub feed_ohm: Option<f64>,
    /// What capacitors absorb: by how much discharges are longer after a rest at V_DD, percent of their time.
    #[serde(default, serialize_with = "uncertainty", skip_serializing_if = "is_unknown")]
    pub absorbed_percent: Option<f64>,
    /// By how much later crossings are stamped after long waits, ns.
    #[serde(default, serialize_with = "uncertainty", skip_serializing_if = "is_unknown")]
    pub late_after_waits_ns: Option<f64>,
    /// How much longer calls that switch in the middle of a discharge take than those that start it, ns; negative: shorter.
    #[serde(default, serialize_with = "value", skip_serializing_if = "is_unknown")]
    pub unlike_calls_ns: Option<f64>,
    /// Discharges that were tried again.
    pub retried: u64,
    /// Whether the latency offset has been found or was given.
    pub offset_known: bool,
    /// The latency offset d, ns.
    #[serde(serialize_with = "value", skip_serializing_if = "is_unknown")]
    pub offset_ns: Option<f64>,
    /// 1 sigma, ns.
    #[serde(serialize_with = "uncertainty", skip_serializing_if = "is_unknown")]
    pub offset_u_ns: Option<f64>,
    /// The resistance of a driven pin, ohm.
    #[serde(serialize_with = "value", skip_serializing_if = "is_unknown")]
    pub r_o_ohm: Option<f64>,
    /// 1 sigma, ohm.
    #[serde(serialize_with = "uncertainty", skip_serializing_if = "is_unknown")]
    pub r_o_u_ohm: Option<f64>,
    /// How long before a planned switch the thread stops sleeping, ns.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spin_margin_ns: Option<u64>,
    /// How often lines were configured anew, because another program had made the kernel take them for inputs.
    #[serde(default)]
    pub lines_renewed: u64,
    /// How many things the backend cannot see.
    pub blind_spots: u64,
    /// Each wish of `[realtime]`, and what became of it, for people.
    pub realtime: BTreeMap<String, String>,
}
