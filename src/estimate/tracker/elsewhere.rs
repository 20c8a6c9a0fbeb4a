//! Split discharges that switch elsewhere than the others: does the law hold at an instant at which nothing was fitted?
//!
//! R_1, R_2 and a split in R_1 determine the state, and whatever the law leaves out is hidden in it, as an Ro and a d that nobody
//! has. A dielectric with a time constant of a discharge through R_1 lags behind in it and gives back after the switch: the
//! later that comes, the less is left of the way, and the more of what is left that is. Such discharges correct the state as long
//! as they agree with it.

use super::Tracker;
use crate::estimate::limits::{
    BY_ELSEWHERE, BY_ELSEWHERE_ABOVE, ELSEWHERE_EVERY, ELSEWHERE_FIRST, ELSEWHERE_REMEMBERED,
    ELSEWHERE_SHOWS, ELSEWHERE_YOUNG,
};
use crate::estimate::look::{Looks, beyond};
use crate::estimate::offset::{is_late, latest_ns};
use crate::record::{CalibrationKind, Record};

/// By how much node A crossed beside what the state says, ns, and how many split discharges there were.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Elsewhere {
    beside_ns: Looks<ELSEWHERE_REMEMBERED>,
    splits: u32,
    /// What the state's own uncertainty is of the last one, 1 sigma, ns.
    u_state_ns: f64,
}

impl Tracker {
    /// When the next split discharge is to switch, ns after its start, if that is elsewhere than the others; `pays`: it is there
    /// for what late ones show. No more than half of them are late, or the state would follow them and hide that.
    pub fn elsewhere_ns(&self, pays: bool) -> Option<f64> {
        let Elsewhere { beside_ns, splits, .. } = &self.elsewhere;
        let every = match beside_ns.taken() {
            taken if taken < ELSEWHERE_FIRST => 1,
            taken if pays || taken < ELSEWHERE_YOUNG => 2,
            _ => ELSEWHERE_EVERY,
        };
        let is_due = self.ready && !self.is_doubted() && splits % every == every - 1;
        self.latest_ns().filter(|_| is_due)
    }

    /// As late as noise lets it be before node A crosses; `None` where that is little later than the others.
    fn latest_ns(&self) -> Option<f64> {
        let [first_ns, _] = self.takes_ns();
        latest_ns(first_ns, &self.noise)
    }

    /// Takes a split discharge for what it shows; whether the state is to be corrected by it, `None` where it did not switch late.
    pub(super) fn takes_elsewhere(&mut self, kind: CalibrationKind, record: &Record) -> Option<bool> {
        // While there is doubt none is asked for: what is elsewhere by a state that may be of another circuit is as usual.
        let is_split = kind == CalibrationKind::Split && !self.is_doubted();
        let switch = record.switch.filter(|_| is_split)?;
        self.elsewhere.splits = self.elsewhere.splits.wrapping_add(1);
        if !is_late(switch.at_ns, self.takes_ns()[0]) {
            return None;
        }
        let (beside_ns, u_state_ns) = self.beside(kind, record).unzip();
        self.elsewhere.u_state_ns = u_state_ns.unwrap_or(self.elsewhere.u_state_ns);
        self.elsewhere.beside_ns.add(beside_ns, record.start);
        Some(!self.shown_elsewhere_ns().is_some_and(is_certain))
    }

    /// By how much node A crosses beside what the state says, and the uncertainty of that, 1 sigma, ns.
    fn shown_elsewhere_ns(&self) -> Option<[f64; 2]> {
        let Elsewhere { beside_ns, u_state_ns, .. } = &self.elsewhere;
        let is_known = beside_ns.taken() >= ELSEWHERE_FIRST;
        is_known.then(|| [beside_ns.median().abs(), beside_ns.noise().hypot(*u_state_ns)])
    }

    /// What the law leaves out does to a reading, 1 sigma, ohm, as far as noise does not explain what shows: little below R_1, more between
    /// R_1 and R_2, which are read as themselves.
    pub fn left_out_ohm(&self, r_ohm: f64) -> f64 {
        let Some([shown_ns, u_ns]) = self.shown_elsewhere_ns() else { return 0.0 };
        let below = BY_ELSEWHERE * self.r_ohm[0] / self.takes_ns()[1];
        below.max(self.left_out_above(r_ohm)) * beyond(shown_ns, u_ns)
    }

    /// What is left out of a reading above R_1 for each ns that shows, ohm/ns. It grows from R_1 on until the dielectric can follow.
    fn left_out_above(&self, r_ohm: f64) -> f64 {
        let [r1_ohm, r2_ohm] = self.r_ohm;
        if r_ohm <= r1_ohm {
            return 0.0;
        }
        let above_ohm = 1.0 / (1.0 / (r_ohm - r1_ohm) + 1.0 / r1_ohm + 1.0 / (r2_ohm - r_ohm).abs());
        BY_ELSEWHERE_ABOVE * above_ohm / self.takes_ns()[1]
    }

    /// The variance of a reading that late split discharges are too few to show, and by how much one more would lower it, ohm²;
    /// `None` where there are none.
    pub fn hidden_elsewhere(&self, r_ohm: f64) -> Option<[f64; 2]> {
        self.latest_ns()?;
        let beside_ns = &self.elsewhere.beside_ns;
        let taken = beside_ns.taken();
        if taken == 0 {
            return None;
        }
        let variance = (self.left_out_above(r_ohm) * beside_ns.noise()).powi(2);
        let lowered = if taken < ELSEWHERE_REMEMBERED { variance / (taken + 1) as f64 } else { 0.0 };
        Some([variance, lowered])
    }
}

/// Whether what shows is more than its uncertainty, 1 sigma, lets be chance.
fn is_certain([shown_ns, u_ns]: [f64; 2]) -> bool {
    shown_ns > ELSEWHERE_SHOWS * u_ns
}
