//! Against the law of the circuit, written down here a second time: a node crosses when the progress
//! sum t_i / (R_i + Ro) reaches its g.

use super::*;
use crate::estimate::limits::{RESOLVED, SPLIT_FRACTION};
use crate::reading::Status;
use crate::record::{Switch, Through};
use crate::sensor::{Channel, Law};
use crate::units::Nanos;
use proptest::prelude::*;

/// Calibrations after which the noise is known.
const ROUNDS: i64 = 40;

#[derive(Debug, Clone)]
struct Bench {
    r: [f64; 2],
    r_o: f64,
    /// Progress at the threshold of A and B, ns/ohm.
    g: [f64; 2],
    d: f64,
}

impl Bench {
    fn record(&self, through: Through, parts: [Option<f64>; 2]) -> Record {
        Record {
            through,
            start: Nanos::ZERO,
            second_ns: None,
            switch: None,
            a_ns: parts[0].map(|t| t + self.d),
            b_ns: parts[1].map(|t| t + self.d),
            u_switch_ns: None,
            waited_ns: None,
            later_ns: None,
        }
    }

    fn full(&self, through: Through, r: f64) -> Record {
        self.record(through, self.g.map(|g| Some(g * (r + self.r_o))))
    }

    /// Through `r` until `at`, nothing until `on`, then through `next`.
    fn switched(&self, through: Through, r: f64, at: f64, on: f64, next: f64, to: Through) -> Record {
        let crossing = |g: f64| {
            let before = at / (r + self.r_o);
            if before >= g { g * (r + self.r_o) } else { on + (g - before) * (next + self.r_o) }
        };
        let switch = Some(Switch { at_ns: at, on_ns: on, to });
        Record { switch, ..self.record(through, self.g.map(|g| Some(crossing(g)))) }
    }

    fn estimator(&self, method: Method) -> Estimator {
        let (r2, second) = if method == Method::Qerm {
            (self.r[0] + self.r[1], Through::C12)
        } else {
            (self.r[1], Through::C2)
        };
        let nodes = if matches!(method, Method::Tpcm | Method::Qerm) { 1 } else { 2 };
        if method == Method::Tracked {
            return self.tracked(nodes);
        }
        let mut estimator = Estimator::new(method, self.r[0], r2, nodes, Offset::given(self.d));
        for _ in 0..ROUNDS {
            estimator.calibrate(&self.full(Through::C1, self.r[0])).unwrap();
            estimator.calibrate(&self.full(second, r2)).unwrap();
        }
        estimator
    }

    fn tracked(&self, nodes: usize) -> Estimator {
        let [r1, r2] = self.r;
        let mut estimator = Estimator::tracked(Method::Tracked, r1, r2, nodes);
        let at = SPLIT_FRACTION * self.g[0] * (r1 + self.r_o);
        let split = self.switched(Through::C1, r1, at, at, r2, Through::C2);
        for round in 0..ROUNDS {
            for record in [self.full(Through::C1, r1), self.full(Through::C2, r2), split] {
                let start = Nanos(10_000_000 * round);
                estimator.calibrate(&Record { start, u_switch_ns: Some(100.0), ..record }).unwrap();
            }
        }
        estimator
    }
}

fn bench() -> impl Strategy<Value = Bench> {
    let resistors = (200.0..5000.0f64, 1.5..20.0f64).prop_map(|(r1, factor)| [r1, r1 * factor]);
    let progress = (10.0..5000.0f64, 1.01..2.0f64).prop_map(|(g, factor)| [g, g * factor]);
    (resistors, 0.0..120.0f64, progress, 0.0..50_000.0f64).prop_map(|(r, r_o, g, d)| Bench { r, r_o, g, d })
}

fn close(estimate: Estimate, r: f64, r1: f64) -> Result<(), TestCaseError> {
    // The calibration resistors are subtracted from each other: their size sets what rounding leaves.
    let error = (estimate.r_ohm.value - r).abs() / r.max(r1);
    prop_assert!(error < 1e-9, "{} for {r}", estimate.r_ohm.value);
    Ok(())
}

proptest! {
    #![proptest_config(crate::seed::cases(256))]

    #[test]
    fn every_equation_solves_the_law(bench in bench(), r in 10f64.ln()..1e6f64.ln(), fraction in 0.05..0.99f64, gap in 0.0..500.0f64) {
        let r = r.exp();
        for method in [Method::Tpcm, Method::Tcdic, Method::Cerm] {
            let estimate = bench.estimator(method).estimate(&bench.full(Through::X(0), r)).unwrap();
            prop_assert_eq!(estimate.branch, Branch::Direct);
            close(estimate, r, bench.r[0])?;
        }
        // The switch may come at any time before B crosses, before or after A.
        let at = fraction * bench.g[1] * (r + bench.r_o);
        let switched = bench.switched(Through::X(0), r, at, at + gap, bench.r[1], Through::C2);
        let estimate = bench.estimator(Method::Cerm).estimate(&switched).unwrap();
        prop_assert_eq!(estimate.branch, Branch::Inferred);
        // What is inferred is magnified where the switch leaves much of the way to Rc2.
        prop_assert!((estimate.r_ohm.value / r - 1.0).abs() < 1e-9 / fraction * (1.0 + bench.r[1] / r), "{estimate:?} for {r}");
    }

    #[test]
    fn a_line_that_moves_late_in_a_long_call_changes_no_more_than_the_call_makes_uncertain(
        bench in bench(), r in 30f64.ln()..1e5f64.ln(), fraction in 0.05..0.99f64, gap in 0.0..500.0f64,
    ) {
        let r = r.exp();
        let at = fraction * bench.g[1] * (r + bench.r_o);
        let late_ns = 1e-4 * at;
        let on = at + gap + late_ns;
        let switched = |at, on| bench.switched(Through::X(0), r, at, on, bench.r[1], Through::C2);
        let says = |record: Record| Record { switch: Some(Switch { at_ns: at, on_ns: on, to: Through::C2 }), ..record };
        let by_start = |record: Record| Record {
            switch: record.switch.map(|switch| Switch { at_ns: switch.at_ns + late_ns, on_ns: switch.on_ns + late_ns, ..switch }),
            a_ns: record.a_ns.map(|ns| ns + late_ns),
            b_ns: record.b_ns.map(|ns| ns + late_ns),
            ..record
        };
        for method in [Method::Tpcm, Method::Tcdic, Method::Cerm, Method::Tracked] {
            let estimator = bench.estimator(method);
            let full = bench.full(Through::X(0), r);
            let mut lates = vec![(full, by_start(full))];
            if matches!(method, Method::Cerm | Method::Tracked) {
                let usual = switched(at, on);
                lates.extend([by_start(usual), says(switched(at + late_ns, on)), says(switched(at, on + late_ns))].map(|late| (usual, late)));
            }
            for (usual, late) in lates {
                let longer = |record: Record| Record { later_ns: Some(late_ns / 2f64.sqrt()), ..record };
                let [short, usual, late] = [usual, longer(usual), longer(late)].map(|record| estimator.estimate(&record).unwrap().r_ohm);
                let added = (usual.u.unwrap().powi(2) - short.u.unwrap().powi(2)).max(0.0).sqrt();
                let changed = (late.value - usual.value).abs();
                prop_assert!(changed <= 1.05 * 2f64.sqrt() * added, "{method:?}: {changed} for {added} of {usual:?}");
            }
        }
    }

    #[test]
    fn what_may_as_well_be_open_is_no_number(bench in bench(), decades in 1.0..10.0f64) {
        let r = bench.r[1] * 10f64.powf(decades);
        let (x, s) = (r + bench.r_o, bench.r[0] + bench.r[1] + bench.r_o);
        let parallel = bench.g[0] / (1.0 / x + 1.0 / s);
        let beside = bench.record(Through::XWithC12(0), [Some(parallel), None]);
        let full = bench.full(Through::X(0), r);
        for (method, record) in [(Method::Qerm, beside), (Method::Cerm, full), (Method::Tcdic, full), (Method::Tpcm, full)] {
            let status = bench.estimator(method).status(&record, &Channel { zero_ohm: Some(0.0), scale: Some(1.0), ..Channel::default() });
            match status {
                Status::Ok { r_ohm, .. } => prop_assert!(r_ohm.value > RESOLVED * r_ohm.u.unwrap(), "{method:?} {status:?} for {r}"),
                Status::Open { r_min_ohm, .. } => prop_assert!(r_min_ohm <= r * (1.0 + 1e-9), "{method:?} {status:?} for {r}"),
                _ => {}
            }
        }
    }

    #[test]
    fn qerm_solves_the_law_of_two_resistors_at_once(bench in bench(), r in 10f64.ln()..1e6f64.ln(), fraction in 0.05..0.99f64) {
        let r = r.exp();
        let r2 = bench.r[0] + bench.r[1];
        let (x, s) = (r + bench.r_o, r2 + bench.r_o);
        let parallel = bench.g[0] / (1.0 / x + 1.0 / s);
        let full = bench.record(Through::XWithC12(0), [Some(parallel), None]);
        let estimate = bench.estimator(Method::Qerm).estimate(&full).unwrap();
        prop_assert_eq!(estimate.branch, Branch::Direct);
        prop_assert!((estimate.r_ohm.value / r - 1.0).abs() < 1e-9 * (1.0 + x / s) * (1.0 + bench.r[0] / r), "{estimate:?} for {r}");

        let at = fraction * parallel;
        let end = at + (bench.g[0] - at * (1.0 / x + 1.0 / s)) * s;
        let mut switched = bench.record(Through::XWithC12(0), [Some(end), None]);
        switched.switch = Some(Switch { at_ns: at, on_ns: at, to: Through::C12 });
        let estimate = bench.estimator(Method::Qerm).estimate(&switched).unwrap();
        prop_assert_eq!(estimate.branch, Branch::Inferred);
        let magnified = (1.0 + x / s) * (1.0 + s / x) / fraction;
        prop_assert!((estimate.r_ohm.value / r - 1.0).abs() < 1e-9 * magnified, "{estimate:?} for {r}");
    }

    #[test]
    fn whatever_the_times_no_number_is_made_up(
        c1 in prop::array::uniform2(-1e7..1e7f64),
        c2 in prop::array::uniform2(-1e7..1e7f64),
        x in prop::array::uniform2(-1e7..1e9f64),
        at in prop::option::of(-1e6..1e6f64),
        method in prop::sample::select(Method::ALL.to_vec()),
        zeroed in any::<bool>(),
    ) {
        let record = |through, [a, b]: [f64; 2]| Record {
            through, start: Nanos::ZERO, second_ns: None, switch: None, a_ns: Some(a), b_ns: Some(b), u_switch_ns: None, later_ns: None, waited_ns: None,
        };
        let nodes = if matches!(method, Method::Tcdic | Method::Cerm) { 2 } else { 1 };
        let mut estimator = Estimator::new(method, 2320.0, 12700.0, nodes, Offset::given(8000.0));
        estimator.calibrate(&record(Through::C1, c1)).unwrap();
        estimator.calibrate(&record(Through::C2, c2)).unwrap();
        let mut x = record(Through::X(0), x);
        x.switch = at.map(|at| Switch { at_ns: at, on_ns: at, to: Through::C2 });
        let sensor = Channel {
            zero_ohm: zeroed.then_some(0.0),
            force: Some(Law::Alpha { alpha_n_ohm: 13346.46 }.into()),
            ..Channel::default()
        };
        match estimator.status(&x, &sensor) {
            Status::Ok { r_ohm, shown, .. } => {
                prop_assert!(r_ohm.value > 0.0 && r_ohm.value.is_finite());
                prop_assert!(shown.is_none_or(|f| f.value > 0.0 && f.value.is_finite()));
            }
            Status::Open { r_min_ohm, .. } => prop_assert!(r_min_ohm > 0.0 && r_min_ohm.is_finite()),
            Status::Short { r_max_ohm, .. } => prop_assert!(r_max_ohm > 0.0 && r_max_ohm.is_finite()),
            Status::Fault(_) => {}
        }
    }
}

/// What (19) gives when d is left in the crossings: -(2 d / (g_A + g_B)) (Rc2 - R_x) / (Rc2 + Ro), to first order in d,
/// with the switch where A crosses.
#[test]
fn an_offset_that_is_not_subtracted_biases_cerm_as_predicted() {
    // 10 uF and 680 nF at 1.3 V: g in ns/ohm.
    let c_t = 10e-6 * 0.68e-6 / 10.68e-6;
    let g = [(3.3f64 / 1.3).ln(), (33.0f64 / (1.3 * 10.68 - 3.3 * 0.68)).ln()].map(|ln| ln * c_t * 1e9);
    let bench = Bench { r: [2320.0, 12700.0], r_o: 40.0, g, d: 8000.0 };
    for r in [100.0, 1000.0, 5000.0] {
        let at = g[0] * (r + 40.0);
        let record = bench.switched(Through::X(0), r, at, at, 12700.0, Through::C2);
        let mut estimator = bench.estimator(Method::Cerm);
        assert!((estimator.estimate(&record).unwrap().r_ohm.value / r - 1.0).abs() < 1e-9);
        estimator.set_offset(Offset::given(0.0));
        let bias = estimator.estimate(&record).unwrap().r_ohm.value - r;
        let predicted = -(2.0 * 8000.0 / (g[0] + g[1])) * (12700.0 - r) / 12740.0;
        assert!((bias / predicted - 1.0).abs() < 0.05, "{r} ohm: bias {bias}, predicted {predicted}");
    }
}

/// Nodes whose crossings are as close to each other as stamps may jitter, in either order.
#[test]
fn nodes_that_cross_together_are_no_fault_before_the_noise_is_known() {
    for factor in [0.999, 1.001, 1.5] {
        let bench = Bench { r: [470.0, 12_700.0], r_o: 40.0, g: [200.0, factor * 200.0], d: 8000.0 };
        for method in [Method::Tcdic, Method::Tracked] {
            let mut estimator = Estimator::new(method, 470.0, 12_700.0, 2, Offset::given(bench.d));
            estimator.calibrate(&bench.full(Through::C1, 470.0)).unwrap();
            estimator.calibrate(&bench.full(Through::C2, 12_700.0)).unwrap();
            assert!(!estimator.noise().is_known());
            let estimate = estimator.estimate(&bench.full(Through::X(0), 1000.0)).unwrap();
            assert!((estimate.r_ohm.value / 1000.0 - 1.0).abs() < 1e-9, "{factor}: {estimate:?}");
        }
    }
}

/// A tape that begins anywhere may have any of them first.
#[test]
fn a_discharge_in_which_the_program_woke_is_no_beginning_of_a_state() {
    let bench = Bench { r: [2320.0, 12_700.0], r_o: 40.0, g: [600.0, 1100.0], d: 3000.0 };
    let [r1, r2] = bench.r;
    let split =
        bench.switched(Through::C1, r1, 0.9 * bench.g[0] * r1, 0.9 * bench.g[0] * r1, r2, Through::C2);
    let woken = |plain: Record| {
        let (at_ns, earlier) = (plain.a_ns.unwrap() - 200e3, |ns: Option<f64>| ns.map(|ns| ns - 60e3));
        let switch = Some(Switch { at_ns, on_ns: at_ns, to: plain.through });
        Record { switch, a_ns: earlier(plain.a_ns), b_ns: earlier(plain.b_ns), ..plain }
    };
    let found = |wakes: bool| {
        let mut estimator = Estimator::tracked(Method::Tracked, r1, r2, 2);
        for round in 0..ROUNDS {
            for plain in [bench.full(Through::C1, r1), bench.full(Through::C2, r2), split] {
                let plain = Record { start: Nanos(10_000_000 * round), u_switch_ns: Some(100.0), ..plain };
                let also = wakes && estimator.tracker().is_none() && plain.switch.is_none();
                also.then(|| estimator.calibrate(&woken(plain)).unwrap());
                estimator.calibrate(&plain).unwrap();
            }
        }
        *estimator.tracker().unwrap().state()
    };
    assert_eq!(found(true), found(false));
}
