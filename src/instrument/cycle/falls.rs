//! When nodes fall in discharges that are planned.

use super::{CalibrationKind, Cycle, Through};
use crate::instrument::discharge::{Call, Falls};
use crate::record::Crossings;
use crate::units::Nanos;

impl Cycle {
    /// When a plain calibration discharge crosses: as the last one did.
    pub(super) fn expected(&self, kind: CalibrationKind) -> [Option<Nanos>; 2] {
        let crossings = match kind {
            CalibrationKind::Split => None,
            _ => self.plain_ns().map(|plain| plain[usize::from(kind == CalibrationKind::Second)]),
        };
        crossings.unwrap_or_default().map(|ns| ns.map(|ns| Nanos(ns as i64)))
    }

    /// When nodes cross on the board in plain discharges through R_1, and through R_2, ns.
    fn plain_ns(&self) -> Option<[Crossings; 2]> {
        let (c1, c2) = self.estimator.calibration()?;
        let with_leak = |crossings, kind| self.estimator.with_leak_ns(crossings, kind);
        Some([with_leak(c1, CalibrationKind::First), with_leak(c2, CalibrationKind::Second)])
    }

    /// When nodes fall in a calibration discharge that is switched like this.
    pub(super) fn calibration_falls(&self, kind: CalibrationKind, switch: Option<(Nanos, Through)>) -> Falls {
        let plain = self.plain_ns();
        let alone = |plain: [Crossings; 2]| plain[usize::from(kind == CalibrationKind::Second)];
        plain.map_or([None; 2], |plain| self.falls(alone(plain), plain, switch))
    }

    /// The same of a sensor that is where it was last. What leaks beside one shifts that by more than a tick lasts.
    pub(super) fn sensor_falls(&self, channel: usize, switch: Option<(Nanos, Through)>) -> Falls {
        let leaks = self.leak.siemens().is_some();
        let r_ohm = self.memory[channel].r_ohm().filter(|_| !leaks);
        let Some((r_ohm, (c1, c2))) = r_ohm.zip(self.estimator.calibration()) else { return [None; 2] };
        let [r1, r2] = self.settings.r_ohm();
        let alone = [0, 1].map(|node| {
            let (c1_ns, c2_ns) = (c1[node]?, c2[node]?);
            let x_ns = c1_ns + (r_ohm - r1) / (r2 - r1) * (c2_ns - c1_ns);
            self.estimator.x_discharge_ns(x_ns, node)
        });
        self.falls(alone, [c1, c2], switch)
    }

    /// Of a discharge that would cross so without its switch, beside plain ones through R_1 and R_2, all with d. A switch stops it for a
    /// call, and makes what is left as many times longer, and less certain, as the other resistor is slower: a line moves anywhere in its call.
    fn falls(&self, alone: Crossings, plain: [Crossings; 2], switch: Option<(Nanos, Through)>) -> Falls {
        let d_ns = self.estimator.offset().d_ns;
        let call_ns = self.calls.usual()[Call::Release as usize].map_or(0.0, |call| call.length.as_ns());
        [0, 1].map(|node| {
            let alone_ns = alone[node]? - d_ns;
            let (falls_ns, within_ns) = match switch {
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
