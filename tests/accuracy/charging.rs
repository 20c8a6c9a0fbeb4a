//! How short a charge may be, in the simulated circuit and in virtual time, against what is predicted.
//!
//! Writes `docs/charging.md` with `UPDATE_DOCS=1 cargo test --test accuracy charging`, and fails when it is out of date.

mod bench;
mod circuit;

use bench::{Board, Found, LONG_TAUS, NEIGHBOUR_OHM};
use cermd::reading::Method;
use std::fmt::Write;

/// The error that is allowed, in sigma.
const SHARE: f64 = 0.1;
/// Time constants of the charges that were made before the length was automatic.
const BEFORE_TAUS: f64 = 9.56;
const RESISTANCES: [f64; 4] = [100.0, 1000.0, 5000.0, 16_200.0];
const METHODS: [Method; 5] = [Method::Tpcm, Method::Qerm, Method::Tcdic, Method::Cerm, Method::Tracked];

const HEAD: &str = "# How short a charge may be

Every figure on this page is **simulated**: scene `pi4` without its rare long delays (2.2 uF / 680 nF, or 470 nF for the circuit
with series calibration; Rc 2320 / 12700 ohm), wake-ups from the charge 53 us late with a scatter of 5 us. Written by
`UPDATE_DOCS=1 cargo test --test accuracy charging`; do not edit. The same test asserts what is said here.

What an incomplete charge leaves missing is the same each time and cancels, but for what it remembers of the discharge before: how
far that one took the capacitors. A discharge of a low resistance falls far below the threshold before the program has let go
of it, one of a high resistance does not. The slow part of the charge forgets that with exp(-t/tau), and the resistance is wrong in
proportion (derivation: [src/circuit/charge.rs](../src/circuit/charge.rs)). `charge-time` is automatic when it is not given: the
shortest with which this error stays below a tenth of a reading's uncertainty, for any resistances that follow on each other
([src/config/charge.rs](../src/config/charge.rs)). The uncertainty is predicted for a board with less noise than any we know, as the
configuration does not know the noise; on `pi4`, a third of the tenth is left, and that is the reserve for capacitors and chargers
with some percent more than is written down.

A discharge that ends before its time (deadline, preemption, lost edge) leaves the capacitors nearly full, as no other
does. The next one then begins by sinking through Rc1 for as long as Rc1 takes, so that its charge begins where others do.
";

/// Writes the page if that is asked for; otherwise it has to be what it would be.
#[test]
fn the_page_is_up_to_date_and_the_error_is_as_predicted() {
    let mut wrong = String::new();
    let mut page = format!("{HEAD}\n{}", gains());
    write!(
        page,
        "\n## Error against time\n\nMean error over u of a sensor that is read after a short circuit ({NEIGHBOUR_OHM} ohm) on another channel, less that with \
         {LONG_TAUS} time constants (whatever else is wrong with a reading is no matter here), and the share of readings within 2u; \
         {} instruments, 40 readings of each; the standard error of the error is 0.02, for `tracked` 0.03 to 0.07.\n\n| method | R_x / ohm | 0.5 of the automatic time | 0.6 | 0.75 | automatic |\n\
         |---|--:|--:|--:|--:|--:|\n",
        bench::INSTRUMENTS
    )
    .unwrap();
    for method in METHODS {
        let mut left = 0.0f64;
        for r_ohm in RESISTANCES {
            let board = Board { method, r_ohm };
            let long = board.measure(NEIGHBOUR_OHM, LONG_TAUS);
            let automatic = board.automatic_taus();
            write!(page, "| {} | {r_ohm} |", method.as_str()).unwrap();
            for part in [0.5, 0.6, 0.75, 1.0] {
                let found = board.measure(NEIGHBOUR_OHM, part * automatic);
                let error = found.error_beyond(&long);
                write!(page, " {:+.2} ({:.0} %) |", error.value, 100.0 * found.within_2u.value).unwrap();
                let case = format!("{} {r_ohm} ohm, {part} of {automatic:.2} tau", method.as_str());
                println!("{case}: {error:.3} u, within 2u {}", found.within_2u);
                check(&board, part, &found, &long, &case, &mut wrong);
                if part == 0.6 {
                    left = left.max(error.value.abs() + error.margin);
                }
            }
            page.push('\n');
        }
        if left <= SHARE {
            writeln!(wrong, "{}: at 0.6 of its time the error is within its share", method.as_str()).unwrap();
        }
    }
    assert!(wrong.is_empty(), "seeds 0..{}\n{wrong}\n{page}", bench::INSTRUMENTS);
    crate::common::check_page("accuracy charging", "charging.md", &page);
}

/// At the automatic time, the error is within its share and u is true. Below it, the error is as predicted, where each
/// charge has a known discharge before it, and below the prediction's limit everywhere.
fn check(board: &Board, part: f64, found: &Found, long: &Found, case: &str, wrong: &mut String) {
    let error = found.error_beyond(long);
    if part == 1.0 && !error.is(0.0, SHARE) {
        writeln!(wrong, "{case}: {error:.3} u").unwrap();
    }
    if part == 1.0 && !found.within_2u.is_in(0.93..=0.97) {
        writeln!(wrong, "{case}: {} within 2u", found.within_2u).unwrap();
    }
    let taus = part * board.automatic_taus();
    // In a u that is less than that of any board; of first order.
    let limit = 1.05 * SHARE * (board.automatic_taus() - taus).exp();
    if !error.is(0.0, limit) {
        writeln!(wrong, "{case}: {error:.3} u is above {limit:.3} u").unwrap();
    }
    if let Some(predicted) = board.predicted_ohm(taus) {
        let ohm = found.ohm_beyond(long);
        println!("{case}: {ohm:.3} ohm, predicted {predicted:+.3}");
        // The prediction is of first order in what is left, and takes the reaction to an edge for a constant.
        if !ohm.is(predicted, 0.05 * predicted.abs()) {
            writeln!(wrong, "{case}: {ohm:.3} ohm, predicted {predicted:+.3}").unwrap();
        }
    }
}

/// Its discharges time out with the capacitors nearly full; the charge of the next one would remember that far beyond what is
/// planned for, if they were not drained first.
#[test]
fn an_open_sensor_does_not_disturb_the_next_one() {
    for method in [Method::Tpcm, Method::Tcdic, Method::Cerm, Method::Tracked] {
        let board = Board { method, r_ohm: 5000.0 };
        let taus = 0.6 * board.automatic_taus();
        let error = board.measure(100e6, taus).error_beyond(&board.measure(100e6, LONG_TAUS));
        // The u that is planned for is a third of this board's.
        let limit = SHARE / 3.0 * (board.automatic_taus() - taus).exp();
        println!("{}: {error:.3} u, limit {limit:.3} u", method.as_str());
        assert!(error.is(0.0, limit), "{}: {error:.3} u", method.as_str());
    }
}

/// What the automatic time is, and what it gains.
fn gains() -> String {
    let mut table = String::from(
        "| method | automatic | time constants | readings/s at 1 kohm | with 9.56 time constants | gain |\n|---|--:|--:|--:|--:|--:|\n",
    );
    for method in METHODS {
        let board = Board { method, r_ohm: 1000.0 };
        let taus = board.automatic_taus();
        let [now, before] = [taus, BEFORE_TAUS].map(|taus| board.rate_alone(taus));
        writeln!(
            table,
            "| {} | {:.2} ms | {taus:.1} | {now:.1} | {before:.1} | {:+.0} % |",
            method.as_str(),
            1e3 * taus * board.tau().0,
            100.0 * (now / before - 1.0)
        )
        .unwrap();
    }
    table
}
