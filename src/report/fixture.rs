//! A made-up table of the right shape: two circuits, three resistances, means, and some of all that can be varied.

use crate::characterize::limits::PAPER_OHM;
use crate::characterize::table::{Provenance, Row, Source, Vary};
use crate::circuit::Kind;
use crate::reading::Method;

pub fn row(method: Method, r_ohm: f64) -> Row {
    let error = match method {
        Method::Tracked => 0.3 + 5e-4 * r_ohm,
        _ => 2.0 + 1e-3 * r_ohm,
    };
    Row {
        source: Source::Simulated,
        scene: "pi4".to_owned(),
        seed: Some(1),
        circuit: Kind::TwoCapacitor,
        c_a_f: Some(2.2e-6),
        c_b_f: Some(680e-9),
        r_c1_ohm: 470.0,
        r_c2_ohm: 12_700.0,
        method,
        average_s: None,
        vary: None,
        vary_value: None,
        vary_name: None,
        r_ohm,
        instruments: 20,
        readings: 400,
        no_number: 0.0,
        reason: None,
        settling: 0.0,
        moving: 0.0,
        bias_ohm: Some(0.0),
        sd_ohm: Some(error),
        rms_ohm: Some(error),
        mae_ohm: Some(3.0 * error),
        mre_percent: Some(300.0 * error / r_ohm),
        u_ohm: Some(error),
        coverage: Some(0.95),
        published_s: Some(if method == Method::Tracked { 0.002 } else { 0.02 }),
        charge_s: Some(0.0005),
        discharge_s: Some(0.001),
        calibration_s: Some(0.0003),
        overhead_s: Some(if method == Method::Tracked { 0.0002 } else { 0.0182 }),
        bound_ohm: Some(0.5 * error),
        t_ixa_rsd: None,
        t_ixb_rsd: None,
        t_c2a_rsd: None,
    }
}

/// One capacitor in the place of two.
fn small(row: &Row) -> Row {
    Row {
        circuit: Kind::OneCapacitor,
        c_a_f: Some(470e-9),
        c_b_f: None,
        rms_ohm: row.rms_ohm.map(|error| 1.5 * error),
        ..row.clone()
    }
}

pub fn rows() -> Vec<Row> {
    let mut rows = Vec::new();
    for method in [Method::Tpcm, Method::Tcdic, Method::Cerm, Method::Tracked] {
        for r_ohm in [100.0, 1000.0, 16_200.0] {
            let single = row(method, r_ohm);
            let half = single.rms_ohm.map(|error| 0.5 * error);
            rows.push(single.clone());
            rows.push(Row {
                vary: Some(Vary::Without),
                vary_name: Some("jitter".to_owned()),
                rms_ohm: half,
                ..single.clone()
            });
            for average_s in [0.1, 1.0, 10.0] {
                let part = (0.02f64 / average_s).sqrt();
                let scaled = |value: Option<f64>| value.map(|value| value * part);
                rows.push(Row {
                    average_s: Some(average_s),
                    published_s: Some(average_s),
                    rms_ohm: scaled(single.rms_ohm),
                    u_ohm: scaled(single.u_ohm),
                    ..single.clone()
                });
            }
            for (vary, amount) in [
                (Vary::Jitter, 1e-6),
                (Vary::Jitter, 1e-4),
                (Vary::Leakage, 1e6),
                (Vary::Capacitor, 1.0),
                (Vary::Capacitor, 0.1),
                (Vary::SinceStart, 0.1),
                (Vary::SinceStart, 2.0),
            ] {
                let times = if vary == Vary::Capacitor { amount } else { 1.0 };
                let [c_a_f, c_b_f] = [single.c_a_f, single.c_b_f].map(|c| c.map(|c| c * times));
                let bad = Row { vary: Some(vary), vary_value: Some(amount), c_a_f, c_b_f, ..single.clone() };
                rows.push(if vary == Vary::Leakage {
                    Row { no_number: 0.9, reason: Some("leakage".to_owned()), ..bad }
                } else {
                    bad
                });
            }
        }
    }
    let small: Vec<Row> =
        rows.iter().filter(|row| row.method == Method::Tracked && row.vary.is_none()).map(small).collect();
    rows.extend(small);
    rows
}

/// The paper's board, its three methods with its resistances, and the fourth.
pub fn papers_rows() -> Vec<Row> {
    let methods = [Method::Tpcm, Method::Tcdic, Method::Cerm, Method::Tracked].into_iter();
    let rows = methods.flat_map(|method| PAPER_OHM.map(|r_ohm| row(method, r_ohm)));
    let inferred = |r_ohm: f64, fraction: f64| Row {
        vary: Some(Vary::SwitchFraction),
        vary_value: Some(fraction),
        t_ixa_rsd: Some(3.6e-4 / fraction),
        t_ixb_rsd: Some(2.2e-4 / fraction),
        t_c2a_rsd: Some(1.9e-4),
        ..row(Method::Cerm, r_ohm)
    };
    let early = PAPER_OHM.into_iter().filter(|r_ohm| *r_ohm > 681.0);
    let inferred = PAPER_OHM
        .map(|r_ohm| inferred(r_ohm, 1.0))
        .into_iter()
        .chain(early.map(|r_ohm| inferred(r_ohm, 721.0 / (r_ohm + 40.0))));
    let on_board = |row: Row| Row {
        scene: "fpga-paper".to_owned(),
        circuit: if row.method == Method::Tpcm { Kind::OneCapacitor } else { Kind::TwoCapacitor },
        c_a_f: Some(20e-9),
        c_b_f: Some(6.8e-9).filter(|_| row.method != Method::Tpcm),
        r_c1_ohm: 2320.0,
        sd_ohm: row
            .sd_ohm
            .map(|sd| if row.method == Method::Cerm && row.r_ohm < 700.0 { 0.8 * sd } else { sd }),
        readings: 500 * row.instruments,
        ..row
    };
    rows.chain(inferred).map(on_board).collect()
}

pub fn provenance() -> Provenance {
    Provenance {
        source: Source::Simulated,
        board: "pi4".to_owned(),
        text: Some("v-dd = \"3.3 V\" # <5 V".to_owned()),
        seed: Some(1),
        version: "0.1.0".to_owned(),
        date: "2026-11-22T10:00:00Z".to_owned(),
        command: "cermctl characterize --out report".to_owned(),
        later_commands: Vec::new(),
    }
}
