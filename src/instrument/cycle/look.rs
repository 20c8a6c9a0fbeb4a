//! Discharges beside the others, now and then, which look for what is wrong with the circuit.

use super::{Cycle, Step};
use crate::estimate::absorption::AbsorptionTest;
use crate::estimate::awake::{AwakeTest, resistor_of};
use crate::estimate::leak::LeakTest;
use crate::estimate::limits::UNKNOWN_JITTER_NS;
use crate::estimate::look::Found;
use crate::instrument::discharge::Outcome;
use crate::record::{CalibrationKind, Record};
use crate::units::Nanos;

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
            late_ns: self.estimator.awake().found(),
            absorbed: self.absorption.share(),
        }
    }

    /// Takes over what another one has [found](Self::found). Of leaks nothing is said where that tells nothing, until a look does.
    pub fn know(&mut self, found: &Found) {
        match found.leak_siemens.map(LeakTest::known) {
            Some(leak) => {
                self.leak = leak;
                self.estimator.set_leak(&self.leak);
            }
            None => self.estimator.ignore_leaks(),
        }
        if let Some(awake) = found.late_ns.map(AwakeTest::known) {
            self.estimator.set_awake(awake);
        }
        if let Some(absorption) = found.absorbed.map(AbsorptionTest::known) {
            self.absorption = absorption;
            self.estimator.set_absorption(&self.absorption);
        }
    }

    /// Another length than an ordinary discharge through R_2 has. One that came to nothing tells nothing.
    pub(super) fn held_done(&mut self, look: Look, outcome: &Outcome, now: Nanos) {
        let resistor = if let Look::Awake(resistor) = look { resistor } else { 1 };
        let usual = self.estimator.calibration().map(|(c1, c2)| [c1, c2][resistor]);
        // The two discharges have their own noise each.
        let noise = usual.and_then(|usual| self.estimator.noise().covariance(usual));
        let variance = 2.0 * noise.map_or(UNKNOWN_JITTER_NS * UNKNOWN_JITTER_NS, |noise| noise.aa);
        let found = outcome.result.ok().zip(usual.and_then(|[a_ns, _]| a_ns));
        match look {
            Look::Leak | Look::First => {
                let lost = found.and_then(|(record, usual)| {
                    let (a_ns, switch) = (record.a_ns?, record.switch?);
                    // Held too late, it has ended as usual: that is no leak.
                    let is_held = switch.at_ns < usual;
                    is_held.then_some((usual + (switch.on_ns - switch.at_ns) - a_ns, variance))
                });
                self.leak.add(lost, self.settings.r_ohm()[1], now);
                self.estimator.set_leak(&self.leak);
                if self.leak.has_changed() {
                    self.estimator.begin_anew();
                }
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
}
