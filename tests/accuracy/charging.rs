//! How short a charge may be, in the simulated circuit and in virtual time, against what is predicted.
//!
//! Writes `docs/charging.md` with `UPDATE_DOCS=1 cargo test --test accuracy charging`, and fails when it is out of date.

mod bench;
mod chart;
mod circuit;
mod leak;

use bench::{Board, Found, LONG_TAUS, NEIGHBOUR_OHM};
use cermd::circuit::Chargers;
use cermd::instrument::discharge::Charge;
use cermd::reading::Method;
use std::fmt::Write;

/// The error that is allowed, in sigma.
const SHARE: f64 = 0.1;
const RESISTANCES: [f64; 4] = [100.0, 1000.0, 5000.0, 16_200.0];
const METHODS: [Method; 5] = [Method::Tpcm, Method::Qerm, Method::Tcdic, Method::Cerm, Method::Tracked];
/// Leaks at B, ohm.
const LEAKS: [f64; 2] = [30e6, 1e6];

const HEAD: &str = "# How short a charge may be

![Error and honesty over resistance and size of capacitors](map-capacitor.svg)

The picture, what larger and smaller capacitors are worth, is of `cermctl characterize`; the rest of the page is of tests.

Every figure on this page is **simulated**: scene `pi4` without its rare long delays (2.2 uF / 680 nF, or 470 nF for the circuit
with series calibration; Rc 470 / 12700 ohm), wake-ups from the charge 53 us late with a scatter of 5 us. Written by
`UPDATE_DOCS=1 cargo test --test accuracy charging`; do not edit. The same test asserts what is said here.

The two capacitors are in series: a discharge takes the same charge out of both. So a charge **through A alone**, with B floating,
puts it back into both, along the line of the discharge, and has the time constant Rp C_A C_B / (C_A + C_B): a ninth of
that of both chargers with these parts. What it cannot bring back is what B has lost otherwise. So where a discharge waits for B, all
chargers follow for half a time constant of B; where none does, B is left alone and put back four times a second.

What an incomplete charge leaves missing is the same each time and cancels, but for what it remembers of the discharge before: how
far that one took the capacitors. A discharge of a low resistance falls far below the threshold before the program has let go
of it, one of a high resistance does not. The charge forgets that with exp(-t/tau), and the resistance is wrong in
proportion (derivation: [src/circuit/charge.rs](../src/circuit/charge.rs)). The time is automatic when it is not given: the
shortest with which this error stays below a tenth of a reading's uncertainty, for any resistances that follow on each other
([src/config/charge.rs](../src/config/charge.rs)). The uncertainty is predicted for a board with less noise than any we know, as the
configuration does not know the noise; what is left of the tenth on `pi4` is the reserve for capacitors and chargers with some percent
more than is written down. Where it is more, `tracked` sees it in its first four rounds of calibration: from then on charges follow the
board's own time constant, up to twice as long, and the state begins with what comes after ([coverage.md](coverage.md): Ro of 90 ohm
for 40, capacitors 15 % larger).

A discharge that ends before its time (deadline, preemption, lost edge) leaves the capacitors nearly full, as no other
does. The next one then begins by sinking through Rc1 for as long as Rc1 takes, so that its charge begins where others do.

![Error over u against the length of a charge, through A alone and through all chargers](charging.svg)
";

/// Writes the page if that is asked for; otherwise it has to be what it would be.
#[test]
fn the_page_is_up_to_date_and_the_error_is_as_predicted() {
    let (mut wrong, curves) = (String::new(), chart::curves());
    let mut page = format!("{HEAD}\n{}", gains(&mut wrong));
    write!(
        page,
        "\n## Error against time\n\nMean error over u of a sensor that is read after a short circuit ({NEIGHBOUR_OHM} ohm) on another channel, less that with \
         {LONG_TAUS} time constants (whatever else is wrong with a reading is no matter here), and the share of readings within 2u, where the time through A \
         alone is a part of the automatic one; {} instruments, 40 readings of each; the standard error of the error is 0.02, for `tracked` 0.03 to 0.06, and 0.2 at half of the time.\n\n\
         | method | R_x / ohm | 0.5 of the automatic time | 0.6 | 0.75 | automatic |\n|---|--:|--:|--:|--:|--:|\n",
        bench::INSTRUMENTS
    )
    .unwrap();
    for method in METHODS {
        for r_ohm in RESISTANCES {
            let board = Board { method, r_ohm };
            let long = board.measure(NEIGHBOUR_OHM, (Chargers::OfA, LONG_TAUS));
            write!(page, "| {} | {r_ohm} |", method.as_str()).unwrap();
            for part in [0.5, 0.6, 0.75, 1.0] {
                let found =
                    board.measure(NEIGHBOUR_OHM, (Chargers::OfA, part * board.automatic_taus(Chargers::OfA)));
                let error = found.error_beyond(&long);
                write!(page, " {:+.2} ({:.0} %) |", error.value, 100.0 * found.within_2u.value).unwrap();
                check(&board, part, &found, &long, &mut wrong);
            }
            page.push('\n');
        }
    }
    page += &leaks(&mut wrong);
    assert!(wrong.is_empty(), "seeds 0..{}\n{wrong}\n{page}", bench::INSTRUMENTS);
    if std::env::var_os("UPDATE_DOCS").is_some() {
        chart::write(&curves);
    }
    crate::common::check_page("accuracy charging", "charging.md", &page);
}

/// At the automatic time, the error is within its share and u is true. Below it, the error is as predicted, where each
/// charge has a known discharge before it, and below the prediction's limit everywhere.
fn check(board: &Board, part: f64, found: &Found, long: &Found, wrong: &mut String) {
    let (error, automatic) = (found.error_beyond(long), board.automatic_taus(Chargers::OfA));
    let case = format!("{} {} ohm, {part} of {automatic:.2} tau", board.method.as_str(), board.r_ohm);
    println!("{case}: {error:.3} u, within 2u {}", found.within_2u);
    if part == 1.0 && !error.is(0.0, SHARE) {
        writeln!(wrong, "{case}: {error:.3} u").unwrap();
    }
    if part == 1.0 && !found.within_2u.is_in(0.93..=0.97) {
        writeln!(wrong, "{case}: {} within 2u", found.within_2u).unwrap();
    }
    let taus = part * automatic;
    // In a u that is less than that of any board; of first order.
    let limit = 1.05 * SHARE * (automatic - taus).exp();
    if !error.is(0.0, limit) {
        writeln!(wrong, "{case}: {error:.3} u is above {limit:.3} u").unwrap();
    }
    if let Some(predicted) = board.predicted_ohm((Chargers::OfA, taus)) {
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
        let automatic = board.automatic_taus(Chargers::OfA);
        let measure = |taus| board.measure(100e6, (Chargers::OfA, taus));
        let error = measure(automatic).error_beyond(&measure(LONG_TAUS));
        println!("{}: {error:.3} u", method.as_str());
        assert!(error.is(0.0, SHARE), "{}: {error:.3} u", method.as_str());
    }
}

/// What the automatic charge is, and what it gains against one through all chargers.
fn gains(wrong: &mut String) -> String {
    let mut table = String::from(
        "| method | A alone | time constants | then all | readings/s at 1 kohm | all chargers only | readings/s | gain |\n\
         |---|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    for method in METHODS {
        let board = Board { method, r_ohm: 1000.0 };
        let Charge { alone, together } = board.automatic();
        let [now, before] = [Chargers::OfA, Chargers::All]
            .map(|chargers| board.rate_alone((chargers, board.automatic_taus(chargers))));
        let all_ms = 1e3 * board.automatic_taus(Chargers::All) * board.tau(Chargers::All).0;
        let ms = |time: cermd::units::Nanos| 1e3 * time.as_seconds();
        writeln!(
            table,
            "| {} | {:.2} ms | {:.1} | {:.2} ms | {now:.1} | {all_ms:.2} ms | {before:.1} | {:+.0} % |",
            method.as_str(),
            ms(alone),
            board.automatic_taus(Chargers::OfA),
            ms(together),
            100.0 * (now / before - 1.0)
        )
        .unwrap();
        // Of series calibration there is one charger.
        if method != Method::Qerm && now < 1.5 * before {
            writeln!(wrong, "{}: {now} readings/s, {before} by all chargers", method.as_str()).unwrap();
        }
    }
    table + "\n`tracked` has that part for B only where a discharge waits for B.\n"
}

/// What leaks do to a B that floats most of the time.
fn leaks(wrong: &mut String) -> String {
    let charge = Board { method: Method::Tcdic, r_ohm: 1000.0 }.automatic();
    let mut table = format!(
        "\n## A leak at node B\n\nWhat leaks out of B while it floats, neither a charge through A nor a discharge brings back; half a time constant of all chargers \
         brings back {:.0} % of what is missing by then, each time. `B crosses`: by how much the leak moves that, through Rc2, beyond what it does with complete charges of all chargers (simulated pins, against \
         the closed form of the test). The other columns: the mean error over u with the leak, less that without it, and the share \
         of readings within 2u; first with the automatic charge, then with all chargers for as long as that needs (a leak harms a discharge as well).\n\n\
         | leak | B crosses |",
        100.0 * (1.0 - leak::kept(charge))
    );
    let cells = [Method::Tcdic, Method::Tracked]
        .map(|method| [1000.0, 16_200.0].map(|r_ohm| Board { method, r_ohm }));
    for Board { method, r_ohm } in cells.into_iter().flatten() {
        write!(table, " {} {r_ohm} ohm, automatic | all chargers |", method.as_str()).unwrap();
    }
    table += "\n|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n";
    let by_both = |board| [Chargers::OfA, Chargers::All].map(|chargers| (board, chargers));
    let charged = |(board, chargers): (Board, Chargers)| (board, (chargers, board.automatic_taus(chargers)));
    let sound: Vec<_> = cells
        .into_iter()
        .flatten()
        .flat_map(by_both)
        .map(charged)
        .map(|(board, charging)| (board, charging, board.measure(NEIGHBOUR_OHM, charging)))
        .collect();
    for leak_ohm in LEAKS {
        let [found, predicted] = leak::shift(leak_ohm, charge);
        println!("{leak_ohm} ohm at B: its crossing moves by {found:e}, predicted {predicted:e}");
        // Of first order in what has leaked away.
        if (found / predicted - 1.0).abs() > 0.01 + 2.5 * found.abs() {
            writeln!(wrong, "{leak_ohm} ohm at B: {found:e}, predicted {predicted:e}").unwrap();
        }
        write!(table, "| {} Mohm | {:+.3} % |", leak_ohm / 1e6, 100.0 * found).unwrap();
        for (board, charging, sound) in &sound {
            let leaking = board.measure_leaking(NEIGHBOUR_OHM, *charging, leak_ohm);
            let (error, missing) = (leaking.error_beyond(sound), leaking.missing);
            let case = format!("{board:?} {charging:?} {leak_ohm} ohm");
            println!("{case}: {error:.3} u, within 2u {}, missing {missing:.3}", leaking.within_2u);
            if missing > 0.5 {
                write!(table, " {:.0} % no number |", 100.0 * missing).unwrap();
                continue;
            }
            write!(table, " {:+.2} ({:.0} %) |", error.value, 100.0 * leaking.within_2u.value).unwrap();
            if !leaking.within_2u.is_in(0.93..=1.0) {
                writeln!(wrong, "{case}: {}", leaking.within_2u).unwrap();
            }
        }
        table.push('\n');
    }
    table
}
