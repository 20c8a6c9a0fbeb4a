use super::*;
use crate::chance::{mean_of, rms_of};
use crate::ctl::check::expect::{built, tests::seen};
use crate::ctl::cli::{Cermctl, Verb};
use crate::size::Pace;
use clap::Parser;
use std::sync::LazyLock;

fn asked(line: &str) -> Asked {
    let words = line.split_whitespace().map(|word| word.replace('_', " "));
    let words = ["cermctl", "size"].map(str::to_owned).into_iter().chain(words);
    match Cermctl::try_parse_from(words).unwrap().verb {
        Verb::Size(arguments) => asked::asked(&arguments).unwrap(),
        other => panic!("{other:?}"),
    }
}

const CASES: [&str; 5] = [
    "--r 100ohm..100kohm --error 0.5%",
    "--r 1kohm..10kohm --rate 200Hz",
    "--sensor fsr402 --force 0.2N..20N --rate 100Hz --error 0.5% --board pi5",
    "--r 50ohm..2kohm --error 1ohm --wiring two --board pi-zero",
    "--r 100ohm..10kohm --rate 20Hz --have 2.2uF,680nF,470ohm,10kohm",
];

/// What is found for each of them.
static FOUND: LazyLock<Vec<(Asked, Vec<Rehearsed>)>> = LazyLock::new(|| {
    let found = |line| {
        let asked = asked(line);
        let all = find(&asked).unwrap();
        (asked, all)
    };
    CASES.into_iter().map(found).collect()
});

#[test]
fn what_is_promised_comes_true_on_other_boards_of_the_kind() {
    const BOARDS: u64 = 10;
    let mut wrong = Vec::new();
    for (line, (asked, found)) in CASES.iter().zip(FOUND.iter()) {
        let best = &found[0];
        assert!(best.meets && reason::why_not(asked, Some(best)).is_none(), "{line}");
        let mut config = file::parsed(asked, &best.design).unwrap();
        (config.channels[0].zero_ohm, config.channels[0].scale) = (Some(best.design.r_lim.0), Some(1.0));
        let settings = config.settings().unwrap();
        let scene = built(asked.scene.clone(), &best.design.circuit(&asked.search.board)).unwrap();
        // Of all boards and resistances, as parts of what is promised.
        let (mut errors, mut us, mut rates) = (Vec::new(), Vec::new(), Vec::new());
        for (index, one) in best.expected.iter().enumerate() {
            for board in 0..BOARDS {
                let seed = 1000 + 100 * index as u64 + board;
                let [error, u, rate_hz] = seen(&scene, &settings, one.r_ohm, seed);
                errors.push(error / one.u_ohm.unwrap());
                us.push(u / one.u_ohm.unwrap());
                rates.push(rate_hz / one.rate_hz);
            }
        }
        let (error, u, rate) = (rms_of(&errors), rms_of(&us), mean_of(&rates));
        println!("{line}: error {error}, u {u}, rate {rate} of what is promised");
        if ![error, u, rate].iter().all(|part| part.is_in(0.85..=1.15)) {
            wrong.push(format!("{line}: error {error}, u {u}, rate {rate}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn no_candidate_that_was_not_rehearsed_is_much_better() {
    for line in
        ["--r 100ohm..100kohm --rate 20Hz", "--sensor fsr402 --force 0.2N..20N --rate 50Hz --board pi-zero"]
    {
        let asked = asked(line);
        let best = find(&asked).unwrap().remove(0);
        let ranked = asked.search.ranked(PERIOD_SHARES[0]);
        let every = (ranked.len() / 20).max(1);
        for one in ranked.iter().step_by(every) {
            let other = rehearsal::rehearsed(&asked, &one.design, one.worst, 1).unwrap();
            let is_much_better = other.meets && other.error < 0.75 * best.error;
            assert!(
                !is_much_better,
                "{line}: {:?} with {}, {:?} with {}",
                best.design, best.error, other.design, other.error
            );
        }
    }
}

#[test]
fn what_is_written_is_in_order_and_says_what_to_measure() {
    for (asked, found) in FOUND.iter() {
        for one in found.iter().take(3) {
            let text = file::text(asked, &one.design);
            let config = file::parsed(asked, &one.design).unwrap();
            assert_eq!(config.check().errors(), "", "{text}");
            assert_eq!(
                text.matches("MEASURE").count(),
                2 + usize::from(asked.alpha_n_ohm.is_some()),
                "{text}"
            );
            // It is the circuit that the report shows.
            let planned = one.design.config(&asked.search.board);
            assert_eq!((config.circuit, config.charges()), (planned.circuit, planned.charges()), "{text}");
            let times =
                |config: &crate::config::Config| (config.average(), config.deadline(), config.period());
            assert_eq!(times(&config), times(&planned), "{text}");
        }
    }
}

#[test]
fn what_stops_it_is_named() {
    for (line, says) in [
        ("--r 100ohm..100kohm --rate 9kHz", "for the calls of board pi4"),
        ("--r 100ohm..1kohm --error 0.02% --rate 200Hz", "times what is asked for: at 100 ohm"),
        ("--r 100ohm..100kohm --rate 5kHz", "it gives no number at 100 ohm"),
        (
            "--r 100ohm..10kohm --rate 1Hz --wiring two --have 680nF,680nF,470ohm,10kohm",
            "more capacitors to choose from",
        ),
    ] {
        let asked = asked(line);
        let found = find(&asked).unwrap();
        let why = reason::why_not(&asked, found.first()).unwrap_or_default();
        assert!(why.contains(says), "{line}: {why}");
    }
}

#[test]
fn an_error_without_a_rate_is_met_by_the_shortest_mean() {
    let asked = asked("--r 100ohm..100kohm --error 0.1%");
    let best = find(&asked).unwrap().remove(0);
    assert!(matches!(best.design.pace, Pace::Mean(_)) && best.meets, "{best:?}");
    // A mean of less than half of it would not do.
    assert!(best.error > 0.7, "{best:?}");
}

#[test]
fn a_board_without_noise_is_sized_too() {
    let ranked = asked("--r 100ohm..10kohm --error 1% --board ideal").search.ranked(PERIOD_SHARES[0]);
    let is_number = |shares: &crate::size::Shares| shares.variance() > 0.0 && shares.variance().is_finite();
    assert!(!ranked.is_empty());
    assert!(ranked.iter().all(|one| one.price.is_finite() && is_number(&one.worst.1)), "{:?}", ranked[0]);
}

#[test]
fn all_lines_fit_a_terminal() {
    for (asked, found) in FOUND.iter() {
        let text = report::text(asked, found, None);
        let long: Vec<&str> = text.lines().filter(|line| line.chars().count() > 92).collect();
        assert!(long.is_empty(), "{long:#?}");
    }
}
