//! Without noise, every method gives back the resistance that was simulated.
//!
//! The voltages are those of Kirchhoff's laws, which know neither progress nor threshold times; what the estimators get
//! are the instants at which they fall through the thresholds, late by d. A failing case prints itself.

mod circuits;

use crate::common::seed;
use cermd::circuit::{Chargers, Network};
use cermd::ctl::replay::Replay;
use cermd::estimate::Estimator;
use cermd::estimate::offset::Offset;
use cermd::instrument::settings::OffsetSource;
use cermd::pins::Drives;
use cermd::pins::sim::Scene;
use cermd::reading::Method;
use cermd::record::Through;
use cermd::stream::tape::{DischargeLine, Header};
use cermd::units::{Farad, Ohm, Volt};
use circuits::{Case, cases, record, walk};
use proptest::prelude::*;

fn estimator(case: &Case, d_ns: f64) -> Estimator {
    let [r1, r2] = case.r_ohm();
    let nodes = if case.way.method == Method::Tpcm { 1 } else { case.way.nodes };
    Estimator::new(case.way.method, r1, r2, nodes, Offset::given(d_ns))
}

proptest! {
    #![proptest_config(seed::cases(10_000))]

    /// The equations lose this many units in the last place, at most:
    ///
    /// - R_x = R_1 + rho (R_2 - R_1) is a difference for low R_x: (R_1 + Ro)/R_x, 1000 at 10 ohm and Rc1 = 10 kohm;
    /// - a crossing holds d: 1 + d/T for each of its times;
    /// - T_c2B - T_c2,x is the part of the way that went through the sensor: T_c2B over it, 50 for a switch at 2 % of
    ///   the way; QERM's T_c2 - T_3 likewise R_x/R_2, 1 Mohm / 220 ohm.
    ///
    /// 1e-9 are 4.5e6 units: it holds in the whole range. (The worst of 300,000 cases: 8e-11.)
    #[test]
    fn solving_what_was_simulated_gives_the_resistance(case in cases()) {
        let mut estimator = estimator(&case, case.d_ns);
        estimator.calibrate(&case.full(Through::C1)).unwrap();
        estimator.calibrate(&case.full(case.second())).unwrap();
        let estimate = estimator.estimate(&case.of_sensor()).unwrap();
        prop_assert_eq!(estimate.branch, case.way.branch);
        let error = estimate.r_ohm.value / case.r_x() - 1.0;
        prop_assert!(error.abs() < 1e-9, "relative error {error:e}");
    }
}

/// The tape of a case: two calibrations, so many split discharges, the sensor. Its lines are not written: times on a tape have
/// ten digits, and those of the least circuits here are below a picosecond.
fn tape(case: &Case, offset_ns: Option<f64>, splits: usize) -> (Header, Vec<DischargeLine>) {
    let kind = match (case.way.method, case.way.nodes) {
        (Method::Qerm, _) => "series-calibration",
        (_, 1) => "one-capacitor",
        _ => "two-capacitor",
    };
    let offset = offset_ns.map_or(String::new(), |d| format!(r#""offset_ns":{d},"#));
    let header = Header::parse(&format!(
        r#"{{"class":"TAPE","proto_major":1,"circuit":{{"kind":"{kind}","r_c1_ohm":{},"r_c2_ohm":{}}},{offset}"channels":[{{"id":"x"}}]}}"#,
        case.circuit.r_c1, case.circuit.r_c2
    ))
    .unwrap();
    let calibration = [case.full(Through::C1), case.full(case.second())];
    let split = std::iter::repeat_n(case.split(0.9), splits);
    let records = calibration.into_iter().chain(split).chain([case.of_sensor()]);
    let lines = records.zip(1..).map(|(record, seq)| header.discharge(seq, &record, false)).collect();
    (header, lines)
}

/// What `cermctl estimate` prints, as relative error of R_x; `None` where by a guess of the noise the sensor may conduct nothing, and the
/// bound that is all it tells is true.
fn error_from_tape(
    case: &Case,
    (header, lines): (Header, Vec<DischargeLine>),
    offset: Option<OffsetSource>,
) -> Option<f64> {
    let mut replay = Replay::new(&header, case.way.method, offset).unwrap();
    let estimates: Vec<_> =
        lines.iter().filter_map(|line| replay.take(&header.entry(line).unwrap())).collect();
    assert_eq!(estimates.len(), 1);
    let line = serde_json::to_value(&estimates[0]).unwrap();
    if line["status"] == "open" {
        assert!(case.r_x() > case.circuit.r_c2, "{line}");
        assert!(line["r_min_ohm"].as_f64().unwrap() < case.r_x(), "{line}");
        return None;
    }
    assert_eq!(line["branch"], case.way.branch.as_str(), "{line}");
    Some(line["r_ohm"].as_f64().unwrap() / case.r_x() - 1.0)
}

proptest! {
    #![proptest_config(seed::cases(2000))]

    #[test]
    fn a_tape_gives_the_resistance(case in cases()) {
        let given = Some(OffsetSource::Given(case.d_ns));
        for (name, tape, offset) in [
            ("on the tape", tape(&case, Some(case.d_ns), 0), None),
            ("given", tape(&case, None, 0), given),
            ("from split discharges", tape(&case, None, 4), Some(OffsetSource::Auto)),
        ] {
            let error = error_from_tape(&case, tape, offset);
            prop_assert!(error.is_none_or(|error| error.abs() < 1e-6), "offset {name}: {error:?}");
        }
    }
}

/// The error of eq. (11) in ohm when each charge lasts until at most `residual` of V_DD is left of whatever was there, and starts
/// where the discharge before it ended: at the sensor's last crossing and 61 us of reaction later.
fn error_of_unfinished_charge(r_x: f64, residual: f64) -> f64 {
    let mut circuit = Scene::builtin("pi4").unwrap().network();
    circuit.r_x[0] = r_x;
    let [r1, r2] = [circuit.r_c1, circuit.r_c2];
    let nominal = cermd::circuit::Circuit {
        network: Network::TwoCapacitor { c_a: Farad(2.2e-6), c_b: Farad(680e-9) },
        r_c1: Ohm(r1),
        r_c2: Ohm(r2),
        v_dd: Volt(circuit.v_dd),
        v_th: Volt(circuit.sense[0].falling),
        r_charge: Ohm(220.0),
        r_o: Ohm(40.0),
    };
    let charge = nominal.charge_tau(Chargers::All).0 * (2f64.sqrt() / residual).ln();
    let mut estimator = Estimator::new(Method::Tcdic, r1, r2, 2, Offset::default());
    let (mut voltages, mut r_ohm) = ([0.0; 2], f64::NAN);
    for through in [Through::C1, Through::C2, Through::X(0)].repeat(4) {
        let start = circuit.flow(voltages, Drives::CHARGE).after(charge);
        let (crossings, end) = walk(&circuit, start, &[(0.0, through.drives())], 61e-6);
        voltages = end;
        let record = record(through, crossings, 0.0);
        match through {
            Through::X(_) => r_ohm = estimator.estimate(&record).unwrap().r_ohm.value,
            _ => estimator.calibrate(&record).unwrap(),
        }
    }
    r_ohm - r_x
}

/// What every discharge finds alike (the cases above charge from empty, for as little as 3 time constants) cancels
/// altogether. What the discharge before left behind does not: on the `pi4` circuit it is a thirtieth of the residual or
/// less, and with 1e-4 (9.6 time constants) 0.5 mohm at 100 ohm.
#[test]
fn an_unfinished_charge_cancels_but_for_a_thirtieth_of_what_is_left() {
    for residual in [1e-2, 1e-3, 1e-4] {
        for r_x in [10.0, 100.0, 1e3, 10e3, 100e3, 1e6] {
            let error = error_of_unfinished_charge(r_x, residual);
            let relative = error.abs() / (r_x + 470.0 + 40.0);
            assert!(relative < residual / 30.0, "{residual:e} left, {r_x} ohm: {error:e} ohm");
        }
    }
    let error = error_of_unfinished_charge(100.0, 1e-4);
    assert_eq!(format!("{error:.4}"), "-0.0005");
}
