//! Discharges beside the others, now and then, which look for what is wrong with the circuit.

use super::{Cycle, Step};
use crate::estimate::absorption::AbsorptionTest;
use crate::estimate::awake::{AwakeTest, resistor_of};
use crate::estimate::leak::{LeakTest, Lost};
use crate::estimate::limits::UNKNOWN_JITTER_NS;
use crate::estimate::look::Found;
use crate::estimate::noise::Covariance;
use crate::instrument::discharge::Outcome;
use crate::record::{CalibrationKind, Record};
use crate::units::Nanos;

/// The noise of crossings before it is known, ns².
const UNKNOWN: Covariance = Covariance {
    aa: UNKNOWN_JITTER_NS * UNKNOWN_JITTER_NS,
    bb: UNKNOWN_JITTER_NS * UNKNOWN_JITTER_NS,
    ab: 0.0,
};

/// What a discharge beside the others looks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Look {
    /// A leak: it is held on its way.
    Leak,
    /// The same, before the first reading, with a calibration of its own.
    First,
    /// What capacitors absorb: it comes after a rest at V_DD.
    Absorption,
    /// Whether stamps are later after long waits: the program wakes before it ends. 0: through R_1, 1: through R_2.
    Awake(usize),
}

impl Look {
    /// What a discharge that was one of them looked for.
    pub fn of(record: &Record, kind: Option<CalibrationKind>) -> Look {
        match record.switch {
            Some(_) if record.is_woken() => Look::Awake(kind.and_then(resistor_of).unwrap_or(1)),
            Some(_) => Look::Leak,
            None => Look::Absorption,
        }
    }
}

impl Cycle {
    /// What looks have found so far.
    pub fn found(&self) -> Found {
        Found {
            leak_siemens: self.leak.found(),
            leak_more_at_b: self.leak.found_at_b(),
            late_ns: self.estimator.awake().found(),
            absorbed: self.absorption.share(),
        }
    }

    /// Takes over what another one has [found](Self::found). Of leaks nothing is said where that tells nothing, until a look does.
    pub fn know(&mut self, found: &Found) {
        if let Some(awake) = found.late_ns.map(AwakeTest::known) {
            self.estimator.set_awake(awake);
        }
        if let Some(absorption) = found.absorbed.map(AbsorptionTest::known) {
            self.absorption = absorption;
            self.estimator.set_absorption(&self.absorption);
        }
        let Some(at_a) = found.leak_siemens else {
            self.estimator.ignore_leaks();
            return;
        };
        let is_dielectric = self.absorption.share().is_some();
        let [_, r2_ohm] = self.settings.r_ohm();
        let empty = LeakTest::new(self.settings.nodes(), r2_ohm);
        self.leak = empty.knows(at_a, found.leak_more_at_b, is_dielectric);
        self.estimator.set_leak(&self.leak);
    }

    /// Another length than an ordinary discharge through R_2 has. One that came to nothing tells nothing.
    pub(super) fn held_done(&mut self, look: Look, outcome: &Outcome, now: Nanos) {
        let resistor = if let Look::Awake(resistor) = look { resistor } else { 1 };
        let usual = self.estimator.calibration().map(|(c1, c2)| [c1, c2][resistor]);
        // The two discharges have their own noise each.
        let noise = usual.and_then(|usual| self.estimator.noise().covariance(usual));
        let variance = 2.0 * noise.unwrap_or(UNKNOWN).aa;
        let found = outcome.result.ok().zip(usual.and_then(|[a_ns, _]| a_ns));
        match look {
            Look::Leak | Look::First => {
                let lost = outcome.result.ok().and_then(|record| self.lost(&record));
                self.leak.add(lost, now);
                self.leak_done();
            }
            Look::Awake(_) => {
                let longer = found.and_then(|(record, usual)| {
                    let (a_ns, switch) = (record.a_ns?, record.switch?);
                    (a_ns > switch.on_ns).then_some([a_ns - usual, variance])
                });
                self.estimator.add_awake(resistor, longer, now);
            }
            Look::Absorption => {
                let longer = found.and_then(|(record, usual)| {
                    Some([(record.a_ns? - usual) / usual, variance / usual.powi(2)])
                });
                self.absorption.add(longer, now);
                self.estimator.set_absorption(&self.absorption);
                self.leak_done();
            }
        }
        self.step = match look {
            Look::First if self.leak.is_wanting() => self.next_calibration(None),
            Look::First => self.first_sensor(),
            // The first of each come at once.
            Look::Leak | Look::Absorption => self.before_start(now),
            Look::Awake(_) => Step::Start,
        };
    }

    /// Takes over what held discharges have shown so far.
    fn leak_done(&mut self) {
        self.leak.set_dielectric(self.absorption.share().is_some());
        if !self.leak.has_changed() {
            self.estimator.set_leak(&self.leak);
            return;
        }
        self.estimator.undo_leak(&self.leak);
        if let Some(split) = &mut self.split {
            split.clear();
        }
    }

    /// By how much a held discharge was shorter than one that is not.
    fn lost(&self, record: &Record) -> Option<Lost> {
        let (_, usual) = self.estimator.calibration()?;
        let (usual, switch) = (self.estimator.with_leak_ns(usual, CalibrationKind::Second), record.switch?);
        // Held too late, it has ended as usual: that is no leak.
        if switch.at_ns >= usual[0]? {
            return None;
        }
        let held_ns = switch.on_ns - switch.at_ns;
        let lost = [0, 1].map(|node| Some(usual[node]? + held_ns - record.crossings()[node]?));
        // The two discharges have their own noise each.
        let noise = self.estimator.noise().covariance(usual).unwrap_or(UNKNOWN);
        let more_to_b = lost[0].zip(lost[1]).map(|(a_ns, b_ns)| [b_ns - a_ns, 2.0 * noise.of(-1.0, 1.0)]);
        let [_, r_ohm] = self.estimator.paths_ohm();
        Some(Lost { to_a: [lost[0]?, 2.0 * noise.aa], more_to_b, held_ns, r_ohm })
    }
}
