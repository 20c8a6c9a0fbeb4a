//! When nodes fall in discharges that are planned.

use super::{CalibrationKind, Cycle, Plan, Through};
use crate::instrument::discharge::{Call, Falls};
use crate::record::Crossings;
use crate::units::Nanos;

impl Cycle {
    /// A calibration discharge with what is known of when nodes cross and fall in it: as in the last ones, of which a plain one is expected to
    /// cross then.
    pub(super) fn of_calibration(&self, kind: CalibrationKind, plan: Plan) -> Plan {
        let Some((c1, c2)) = self.estimator.calibration() else { return plan };
        let with_leak = |crossings, kind| self.estimator.with_leak_ns(crossings, kind);
        let plain = [with_leak(c1, CalibrationKind::First), with_leak(c2, CalibrationKind::Second)];
        let alone = plain[usize::from(kind == CalibrationKind::Second)];
        let expected = match kind {
            CalibrationKind::Split => [None; 2],
            _ => alone.map(|ns| ns.map(|ns| Nanos(ns as i64))),
        };
        Plan { expected, falls: self.falls(alone, plain, &plan), ..plan }
    }

    /// When nodes fall in the discharge of a sensor that is where it was last. What leaks beside one shifts that by more than a tick lasts.
    pub(super) fn sensor_falls(&self, channel: usize, plan: &Plan) -> Falls {
        let leaks = self.leak.siemens().is_some();
        let known = self.through_sensor(channel).zip(self.estimator.calibration()).filter(|_| !leaks);
        let Some(((_, x_ns), (c1, c2))) = known else { return [None; 2] };
        let alone = [0, 1].map(|node| self.estimator.x_discharge_ns(x_ns[node]?, node));
        self.falls(alone, [c1, c2], plan)
    }

    /// Of a discharge that would cross so without its switch, beside plain ones through R_1 and R_2, all with d. A switch stops it for a
    /// call, and makes what is left as many times longer, and less certain, as the other resistor is slower: a line moves anywhere in its call.
    fn falls(&self, alone: Crossings, plain: [Crossings; 2], plan: &Plan) -> Falls {
        let d_ns = self.estimator.offset().d_ns;
        let call_ns = plan.calls[Call::Release as usize].map_or(0.0, |call| call.length.as_ns());
        [0, 1].map(|node| {
            let alone_ns = alone[node]? - d_ns;
            let (falls_ns, within_ns) = match plan.switch {
                Some((after, to)) if after.as_ns() < alone_ns => {
                    let slower = (plain[usize::from(to != Through::C1)][node]? - d_ns) / alone_ns;
                    (after.as_ns() + call_ns + slower * (alone_ns - after.as_ns()), slower * call_ns / 2.0)
                }
                _ => (alone_ns, 0.0),
            };
            // Until it is stamped.
            Some([falls_ns - within_ns, falls_ns + within_ns + d_ns.max(0.0)].map(|ns| Nanos(ns as i64)))
        })
    }
}
