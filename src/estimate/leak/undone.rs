//! What flows beside the resistors, taken out of the times of discharges: each crossing comes when it would without.
//!
//! A discharge goes on by K dt beside its dt/(R+Ro), so that A crosses by `(R+Ro) ∫ K dt` too early if R ends it, and B by
//! `(R+Ro) ∫ (K+J) dt`.
//!
//! Must not know: which method will use the times.

use super::beside::{Beside, TURNS, Ways};
use crate::estimate::limits::MOST_BESIDE;
use crate::record::{Record, Through};

/// What is undone.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Undone {
    /// By which conductance discharges seem to be shorter that were held early and late, siemens: until A crosses, and until B by how much
    /// more.
    lost: [[f64; 2]; 2],
}

impl Undone {
    /// From what seems to be lost at the places where discharges are [held](LEAK_HELD_AT).
    pub fn of(lost: [[f64; 2]; 2]) -> Undone {
        Undone { lost }
    }

    /// The same again.
    pub fn lost(&self) -> [[f64; 2]; 2] {
        self.lost
    }

    /// Whether it is anything.
    pub fn is_any(&self) -> bool {
        *self != Undone::default()
    }
}

impl Beside {
    /// A discharge as it would have been without. Of a sensor's that went [mostly](MOST_BESIDE) beside it, all that is left is that it
    /// has not ended by then.
    pub fn left_out_of(&self, record: &Record, ways: &Ways) -> Record {
        let discharge = Discharge { beside: self, record, ways };
        let without = [0, 1].map(|node| {
            record.crossings()[node].map(|ns| discharge.without(ns, node).filter(|ns| ns.is_finite()))
        });
        match without {
            [Some(None), _] | [_, Some(None)] => {
                let last = record.b_ns.or(record.a_ns);
                Record { a_ns: None, b_ns: None, waited_ns: last, ..*record }
            }
            [a, b] => {
                let waited_ns = record.waited_ns.map(|ns| discharge.waited(ns));
                Record { a_ns: a.flatten(), b_ns: b.flatten(), waited_ns, ..*record }
            }
        }
    }
}

/// One discharge.
struct Discharge<'a> {
    beside: &'a Beside,
    record: &'a Record,
    ways: &'a Ways,
}

impl Discharge<'_> {
    /// When a node would have crossed, ns; `None`: nearly all went beside the sensor.
    fn without(&self, ns: f64, node: usize) -> Option<f64> {
        let t_ns = ns - self.ways.d_ns;
        let Some(end) = self.end(node) else { return Some(ns) };
        let is_after = |on_ns: f64| on_ns < t_ns && !self.record.is_woken();
        let Some(switch) = self.record.switch.filter(|switch| is_after(switch.on_ns)) else {
            return Some(ns + self.plain(t_ns, node, end)?);
        };
        let Some((r_ohm, Some(whole_ns))) = self.known(switch.to, node) else { return Some(ns) };
        let rest_ns = t_ns - switch.on_ns;
        let from = end * (1.0 - rest_ns / whole_ns).max(0.0);
        let lost = |way: [f64; 2], ns: f64| self.beside.mean(node, way, |siemens| siemens) * ns * r_ohm;
        let before_ns = lost([0.0, from], switch.at_ns) + lost([from; 2], switch.on_ns - switch.at_ns);
        Some(ns + before_ns + rest_ns * (self.beside.longer(node, [from, end], r_ohm) - 1.0))
    }

    /// By how much longer an unswitched one would have taken, ns.
    fn plain(&self, t_ns: f64, node: usize, end: f64) -> Option<f64> {
        let longer = |r_ohm: f64| self.beside.longer(node, [0.0, end], r_ohm);
        if let Some((r_ohm, _)) = self.known(self.record.through, node) {
            return Some(t_ns * (longer(r_ohm) - 1.0));
        }
        // Its time tells the resistor with what is beside it.
        let Some((r2_ohm, Some(whole_ns))) = self.known(Through::C2, node) else { return Some(0.0) };
        let with_ohm = r2_ohm * t_ns / whole_ns;
        let part = with_ohm * self.beside.mean(node, [0.0, end], |siemens| siemens);
        let without_ohm = (0..TURNS).fold(with_ohm / (1.0 - part), |r_ohm, _| with_ohm * longer(r_ohm));
        (part < MOST_BESIDE).then_some(t_ns * (without_ohm / with_ohm - 1.0))
    }

    /// The same of a wait in vain: never longer, for a leak may have gone.
    fn waited(&self, ns: f64) -> f64 {
        let (node, t_ns) = (usize::from(self.record.a_ns.is_some()), ns - self.ways.d_ns);
        let longer = self.end(node).and_then(|end| self.plain(t_ns, node, end));
        ns + longer.unwrap_or(0.0).min(0.0)
    }

    /// Where a node crosses, in parts of A's way.
    fn end(&self, node: usize) -> Option<f64> {
        let own = self.record.a_ns.zip(self.record.b_ns).filter(|_| self.record.switch.is_none());
        let d_ns = self.ways.d_ns;
        self.ways.end(node).or_else(|| own.map(|(a_ns, b_ns)| (b_ns - d_ns) / (a_ns - d_ns)))
    }

    /// A resistor of calibration with Ro, ohm, and how long a node takes through it, ns.
    fn known(&self, through: Through, node: usize) -> Option<(f64, Option<f64>)> {
        let index = match through {
            Through::C1 => 0,
            Through::C2 | Through::C12 => 1,
            Through::X(_) | Through::XWithC12(_) => return None,
        };
        Some((self.ways.r_ohm[index], self.ways.whole_ns(index, node)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::leak::hold;
    use crate::estimate::limits::{FALLS, LEAK_HELD_AT};
    use crate::record::{Crossings, Switch};
    use crate::units::Nanos;

    const C_A: f64 = 2200.0;
    const C_B: f64 = 680.0;
    /// Thresholds in parts of V_DD: that of usual inputs, and a high one, with what is left of any crossing.
    const V_TH: [(f64, f64); 2] = [(1.0 / FALLS, 2e-3), (0.41, 4e-3)];
    const R_OHM: [f64; 2] = [510.0, 12_740.0];

    /// What flows out of nodes A and B at voltages in parts of V_DD, siemens.
    #[derive(Clone, Copy)]
    struct Flows {
        a: fn(f64) -> f64,
        b: fn(f64) -> f64,
    }

    const NONE: Flows = Flows { a: |_| 0.0, b: |_| 0.0 };

    /// When A and B cross in a discharge through a sequence of conductances, each until an instant, ns; both nodes begin at V_DD.
    fn crossings(v_th: f64, beside: Flows, way: &[(f64, f64)]) -> Crossings {
        let fall = |[a, b]: [f64; 2], siemens: f64| {
            let (at_a, at_b) = (siemens * a + (beside.a)(a), (beside.b)(b));
            [-at_a * (1.0 / C_A + 1.0 / C_B) - at_b / C_B, -(at_a + at_b) / C_B]
        };
        let (mut t, mut v, mut crossed) = (0.0, [1.0; 2], [None; 2]);
        for (siemens, until) in way {
            let longest = if *siemens > 0.0 { 1.0 / siemens } else { 1e5 };
            while t < *until && crossed.contains(&None) {
                let step = longest.min(until - t);
                let by = |k: [f64; 2], part: f64| [0, 1].map(|node| v[node] + part * step * k[node]);
                let k1 = fall(v, *siemens);
                let k2 = fall(by(k1, 0.5), *siemens);
                let k3 = fall(by(k2, 0.5), *siemens);
                let k4 = fall(by(k3, 1.0), *siemens);
                let next = [0, 1].map(|n| v[n] + step / 6.0 * (k1[n] + 2.0 * (k2[n] + k3[n]) + k4[n]));
                for node in 0..2 {
                    if crossed[node].is_none() && next[node] <= v_th {
                        // Between two steps a node falls as an exponential.
                        let part = (v[node] / v_th).ln() / (v[node] / next[node]).ln();
                        crossed[node] = Some(t + part * step);
                    }
                }
                (t, v) = (t + step, next);
            }
        }
        crossed
    }

    fn record(through: Through, switch: Option<Switch>, [a_ns, b_ns]: Crossings) -> Record {
        let start = Nanos::ZERO;
        Record {
            through,
            start,
            second_ns: None,
            switch,
            a_ns,
            b_ns,
            u_switch_ns: None,
            waited_ns: None,
            later_ns: None,
        }
    }

    /// What held discharges tell, by their definition.
    fn held(v_th: f64, beside: Flows) -> [[f64; 2]; 2] {
        let [a1, b1] = crossings(v_th, beside, &[(1.0 / R_OHM[1], f64::MAX)]);
        let hold_ns = hold(a1.unwrap(), R_OHM[1]).as_ns();
        let levels = LEAK_HELD_AT.map(|part| {
            let at = part * a1.unwrap();
            let way = [(1.0 / R_OHM[1], at), (0.0, at + hold_ns), (1.0 / R_OHM[1], f64::MAX)];
            let [a, b] = crossings(v_th, beside, &way);
            let [lost_a, lost_b] =
                [a1.unwrap() - a.unwrap(), b1.unwrap() - b.unwrap()].map(|ns| ns + hold_ns);
            [lost_a / (hold_ns * R_OHM[1]), (lost_b - lost_a) / (hold_ns * R_OHM[1])]
        });
        [levels.map(|level| level[0]), levels.map(|level| level[1])]
    }

    const ALL: [(&str, Flows); 6] = [
        ("1 Mohm at A", Flows { a: |v| 1e-6 * v, ..NONE }),
        ("1 Mohm at B", Flows { b: |v| 1e-6 * v, ..NONE }),
        ("a pull-up of 1 Mohm at A", Flows { a: |v| 1e-6 * (v - 1.0), ..NONE }),
        ("a pull-up of 1 Mohm at B", Flows { b: |v| 1e-6 * (v - 1.0), ..NONE }),
        ("a current out of B", Flows { b: |_| 1e-6, ..NONE }),
        ("a pull-up and a leak of 3 Mohm at A", Flows { a: |v| 3e-7 * (2.0 * v - 1.0), ..NONE }),
    ];

    /// The greatest error that is left of any crossing, and the greatest that there was, as parts of its time.
    fn left_of(v_th: f64, beside: Flows, r_ohm: f64) -> [f64; 2] {
        let through = |r_ohm: f64| (1.0 / r_ohm, f64::MAX);
        let plain = R_OHM.map(|r_ohm| crossings(v_th, NONE, &[through(r_ohm)]));
        let ways = Ways { r_ohm: R_OHM, ns: Some(plain), d_ns: 0.0 };
        let found = Beside::of(held(v_th, beside), &ways);
        let at_ns = 0.9 * plain[1][0].unwrap() * r_ohm / R_OHM[1];
        let then = |to| Some(Switch { at_ns, on_ns: at_ns, to });
        let part = [(1.0 / r_ohm, at_ns)];
        let all = [
            (Through::C1, None, vec![through(R_OHM[0])]),
            (Through::C2, None, vec![through(R_OHM[1])]),
            (Through::X(0), None, vec![through(r_ohm)]),
            (Through::X(0), then(Through::C1), [&part[..], &[through(R_OHM[0])]].concat()),
            (Through::X(0), then(Through::C2), [&part[..], &[through(R_OHM[1])]].concat()),
        ];
        let mut greatest = [0f64; 2];
        for (through, switch, way) in all {
            let [true_ns, stamped] = [NONE, beside].map(|beside| crossings(v_th, beside, &way));
            let without = found.left_out_of(&record(through, switch, stamped), &ways).crossings();
            for (found, [ns, stamped]) in
                [0, 1].map(|n| (without[n], [true_ns[n], stamped[n]].map(Option::unwrap)))
            {
                let parts = [found.unwrap(), stamped].map(|found| (found / ns - 1.0).abs());
                greatest = [greatest[0].max(parts[0]), greatest[1].max(parts[1])];
            }
        }
        greatest
    }

    #[test]
    fn crossings_come_when_they_would_without() {
        for ((name, beside), (v_th, least)) in ALL.into_iter().flat_map(|one| V_TH.map(|v_th| (one, v_th))) {
            for r_ohm in [100.0, 1000.0, 5000.0] {
                let [left, was] = left_of(v_th, beside, r_ohm);
                println!("{name}, {v_th:.2}, {r_ohm} ohm: {left:.1e} of {was:.1e}");
                assert!(was > 2e-3 && left < least, "{name}, {v_th}, {r_ohm}: {left:e} of {was:e}");
            }
        }
    }

    #[test]
    fn what_went_mostly_beside_a_sensor_is_a_bound() {
        let (v_th, _) = V_TH[0];
        let plain = R_OHM.map(|r_ohm| crossings(v_th, NONE, &[(1.0 / r_ohm, f64::MAX)]));
        let ways = Ways { r_ohm: R_OHM, ns: Some(plain), d_ns: 0.0 };
        let [leak, feed] = [1e-6, -1e-6].map(|k| Beside::of([[k; 2], [0.0; 2]], &ways));
        let open = record(Through::X(0), None, crossings(v_th, ALL[0].1, &[(1e-9, f64::MAX)]));
        let found = leak.left_out_of(&open, &ways);
        assert_eq!((found.crossings(), found.waited_ns), ([None; 2], open.b_ns));
        // Nor does a wait tell more than it has shown.
        let waited = Record { a_ns: None, b_ns: None, waited_ns: Some(1e9), ..open };
        assert_eq!(leak.left_out_of(&waited, &ways), waited);
        assert!(feed.left_out_of(&waited, &ways).waited_ns.unwrap() < 0.8e9);
        assert!(leak.is_of(&[[1e-6; 2], [0.0; 2]], &ways) && !leak.is_of(&[[0.0; 2]; 2], &ways));
    }

    #[test]
    fn without_a_calibration_only_what_is_known_is_undone() {
        let ways = Ways { r_ohm: R_OHM, ns: None, d_ns: 0.0 };
        let leak = Beside::of([[1e-6; 2], [0.0; 2]], &ways);
        let second = record(Through::C2, None, [Some(1e6), Some(2e6)]);
        assert_eq!(
            leak.left_out_of(&second, &ways).crossings(),
            [Some(1e6 + 12_740.0), Some(2e6 + 25_480.0)]
        );
        let x = Record { through: Through::X(0), ..second };
        assert_eq!(leak.left_out_of(&x, &ways), x);
    }
}
