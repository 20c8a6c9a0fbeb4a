//! What the instrument has counted and learned: the numbers behind STATS.

use crate::estimate::offset::Offset;
use crate::reading::{Fault, Status, Suspect};
use crate::units::Nanos;

/// Counts since the start.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Stats {
    /// Cycles finished.
    pub cycles: u64,
    /// Readings of all channels, whatever their status.
    pub readings: u64,
    /// Readings that are numbers.
    pub ok: u64,
    /// Those of a sensor that changed meanwhile.
    pub moving: u64,
    /// Readings above what the deadline resolves.
    pub open: u64,
    /// Readings that cannot be told from a short circuit.
    pub short: u64,
    /// Readings without a number, by fault, in the order of [`Fault::ALL`].
    pub faults: [u64; Fault::ALL.len()],
    /// Discharges taken again: calibrations that came to nothing, and sensors' whose calls were interrupted.
    pub retried: u64,
    /// The latency offset in force.
    pub offset: Offset,
    /// Whether it is given or found, not still being found.
    pub offset_is_known: bool,
    /// What leaks beside the resistors, siemens, if it shows.
    pub leak_siemens: Option<f64>,
    /// By which share of their time discharges are longer after a rest, if that shows: what capacitors absorb.
    pub absorbed: Option<f64>,
    /// By how much later stamps are after long waits, ns, if that shows.
    pub late_after_waits_ns: Option<f64>,
    /// How much longer calls that switch take than those that start a discharge, ns, if that shows; negative: shorter.
    pub unlike_calls_ns: Option<f64>,
    /// What the last fault looked like, until a reading is none.
    pub suspect: Option<Suspect>,
    /// How long before an instant the backend turns from sleeping to spinning, if it does.
    pub spin_margin: Option<Nanos>,
    /// How often the backend had to configure lines anew.
    pub renewed: u64,
    /// How many kinds of trouble the backend cannot notice.
    pub blind_spots: usize,
}

impl Stats {
    /// Counts one reading.
    pub fn count(&mut self, status: &Status) {
        self.readings += 1;
        match status {
            Status::Ok { is_moving, .. } => {
                self.ok += 1;
                self.moving += u64::from(*is_moving);
            }
            Status::Open { .. } => self.open += 1,
            Status::Short { .. } => self.short += 1,
            Status::Fault(fault) => self.faults[*fault as usize] += 1,
        }
    }
}
