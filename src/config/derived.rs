//! What the configuration leaves open, derived from the circuit.
//!
//! Every value here is meaningful only for a configuration without error findings.

use super::limits::{DEADLINE, DEADLINE_SHARE, DRAIN, FINISHED, LEAST_DEADLINE, SWITCH_FRACTION, TOGETHER};
use super::{Calibration, Config};
use crate::circuit::{Chargers, Node};
use crate::instrument::discharge::Charge;
use crate::instrument::settings::{Charges, OffsetSource};
use crate::reading::Method;
use crate::units::{Nanos, Ohm, Seconds};

impl Config {
    /// The method to use.
    pub fn method(&self) -> Method {
        self.measure.method.unwrap_or(Method::best(self.circuit.kind()))
    }

    /// Whether the calibration is followed instead of taken anew for each reading.
    pub fn is_tracked(&self) -> bool {
        self.method().is_tracked() || self.measure.calibration == Some(Calibration::Tracked)
    }

    /// The node whose crossing ends a discharge: B where the method times it.
    pub fn last_node(&self) -> Node {
        self.method().rules().last(self.circuit.kind())
    }

    /// How to charge before each discharge. A time that is given is that of A.
    pub fn charges(&self) -> Charges {
        let time = self.measure.charge_time.unwrap_or_else(|| self.shortest_charge(Chargers::OfA).into());
        let to_a = Charge::alone(time);
        let Some(tau) = self.circuit.charge_tau_b() else { return Charges::alike(to_a) };
        let together = Nanos::from_seconds(TOGETHER * tau.0);
        let anew = Charge::together(Nanos::from(self.shortest_charge(Chargers::All)).max(time));
        Charges { to_a, to_b: Charge { together, ..to_a }, anew }
    }

    /// How long A is charged.
    pub fn charge_time(&self) -> Nanos {
        self.charges().to_a.alone
    }

    /// How long the usual charge takes before a discharge that waits for the last node.
    pub fn usual_charge(&self) -> Nanos {
        let Charges { to_a, to_b, .. } = self.charges();
        if self.last_node() == Node::B { to_b.time() } else { to_a.time() }
    }

    /// The same before one that waits for node B, where any does.
    pub fn charge_for_b(&self) -> Option<Nanos> {
        (self.last_node() == Node::B).then(|| self.usual_charge())
    }

    /// How long charges take, in words: that of A, and the whole of it before a discharge that waits for B.
    pub fn charge_in_words(&self) -> String {
        let for_b = self.charge_for_b().map(|whole| format!(" (for B {:.3})", Seconds::from(whole)));
        format!("{:.3}{}", Seconds::from(self.charge_time()), for_b.unwrap_or_default())
    }

    /// How long R_1 takes to bring full capacitors to where discharges end, with room for their tolerance.
    pub fn drain_time(&self) -> Nanos {
        Nanos::from_seconds(DRAIN * self.discharge(self.circuit.r_c1).0)
    }

    /// The pause between charge and discharge; when none is given, what the calls between them take.
    pub fn settle_time(&self) -> Nanos {
        self.measure.settle_time.unwrap_or(Nanos::ZERO)
    }

    /// The longest discharge through a sensor: as given, or some of R_2, or fewer where a reading is wanted sooner and its discharge
    /// can be finished early.
    pub fn deadline(&self) -> Nanos {
        if let Some(given) = self.measure.deadline {
            return given;
        }
        let second = self.discharge(self.circuit.r_second()).0;
        let wanted = self.wanted_every().filter(|_| self.is_tracked());
        let channels = self.channels.len().max(1) as f64;
        let left = |every: Nanos| (DEADLINE_SHARE * every.as_seconds() - second) / channels;
        let longest = if self.method().is_tracked() { FINISHED } else { DEADLINE };
        let derived = wanted.map_or(f64::INFINITY, left).max(LEAST_DEADLINE * second).min(longest * second);
        Nanos::from_seconds(derived)
    }

    /// How often a reading of each channel is wanted; `None`: as often as may be.
    fn wanted_every(&self) -> Option<Nanos> {
        self.measure.average.or(self.measure.every())
    }

    /// From one cycle to the next, where the rate is to be no higher than wanted.
    pub fn period(&self) -> Option<Nanos> {
        self.measure.every().filter(|_| self.measure.idle || self.measure.average.is_some())
    }

    /// The time over which what is published is the mean: as given, or all that the wanted rate leaves.
    pub fn average(&self) -> Option<Nanos> {
        if self.measure.idle { self.measure.average } else { self.wanted_every() }
    }

    /// The latency offset.
    pub fn offset(&self) -> OffsetSource {
        self.measure.offset.unwrap_or(OffsetSource::Auto)
    }

    /// Where the planned switch comes, as a fraction of the predicted T_xA.
    pub fn switch_fraction(&self) -> f64 {
        self.measure.switch_fraction.unwrap_or(SWITCH_FRACTION)
    }

    /// The predicted full discharge through `r`, up to the last crossing that the method times; 0 where the
    /// circuit never crosses.
    pub fn discharge(&self, r: Ohm) -> Seconds {
        self.circuit.crossing(self.last_node(), r).unwrap_or_default()
    }

    /// The predicted time of one reading of every channel, calibration and charges included, when each x discharge takes `x`:
    /// at the least and at the most, which differ where a tracked calibration takes its discharges only as they pay. Without
    /// what the system's calls take.
    pub fn cycle(&self, x: Seconds) -> [Seconds; 2] {
        let channels = self.channels.len() as f64;
        let pause = self.usual_charge().as_seconds() + self.settle_time().as_seconds();
        let [first, second] =
            [self.circuit.r_c1, self.circuit.r_second()].map(|r| pause + self.discharge(r).0);
        let calibration = if self.is_tracked() { [0.0, second] } else { [first + second; 2] };
        calibration.map(|calibration| Seconds(calibration + channels * (pause + x.0)))
    }
}
