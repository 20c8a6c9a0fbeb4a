//! When nodes fall in discharges that are planned.

use super::{CalibrationKind, Cycle, Through};
use crate::instrument::discharge::Call;
use crate::instrument::limits::TICK_LASTS;
use crate::units::Nanos;

impl Cycle {
    /// When a plain calibration discharge crosses: as the last one did.
    pub(super) fn expected(&self, kind: CalibrationKind) -> [Option<Nanos>; 2] {
        let of_kind = |(c1, c2)| match kind {
            CalibrationKind::First => Some(c1),
            CalibrationKind::Second => Some(c2),
            CalibrationKind::Split => None,
        };
        let crossings: [Option<f64>; 2] = self.estimator.calibration().and_then(of_kind).unwrap_or_default();
        self.estimator.with_leak_ns(crossings, kind).map(|ns| ns.map(|ns| Nanos(ns as i64)))
    }

    /// When each node falls in a discharge through a resistance, Ro not counted, that is switched like this, since its start, and give or
    /// take how much: after a switch, as many times what that may be late by as the other resistor is slower.
    pub(super) fn falls(&self, r_ohm: f64, switch: Option<(Nanos, Through)>) -> [Option<[Nanos; 2]>; 2] {
        let Some((c1, c2)) = self.estimator.calibration() else { return [None; 2] };
        let ([r1, r2], d_ns) = (self.settings.r_ohm(), self.estimator.offset().d_ns);
        let call_ns = self.calls.usual()[Call::Release as usize].map_or(0.0, |call| call.length.as_ns());
        [0, 1].map(|node| {
            let (c1_ns, c2_ns) = (c1[node]?, c2[node]?);
            let through_ns = |ohm: f64| c1_ns - d_ns + (ohm - r1) / (r2 - r1) * (c2_ns - c1_ns);
            let alone_ns = through_ns(r_ohm);
            let (falls_ns, within_ns) = match switch {
                Some((after, to)) if after.as_ns() < alone_ns => {
                    let slower = through_ns(if to == Through::C1 { r1 } else { r2 }) / alone_ns;
                    (after.as_ns() + slower * (alone_ns - after.as_ns()), slower * call_ns)
                }
                _ => (alone_ns, 0.0),
            };
            let [falls, within] = [falls_ns, within_ns].map(|ns| Nanos(ns as i64));
            (within <= TICK_LASTS).then_some([falls, within])
        })
    }
}
