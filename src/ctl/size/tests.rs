use super::*;
use crate::chance::{mean_of, rms_of};
use crate::characterize::cell::{Cell, CellError};
use crate::characterize::run::run;
use crate::characterize::table::Row;
use crate::config::Config;
use crate::ctl::check::expect::{board, built, rehearse};
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

const CASES: [&str; 6] = [
    "--r 100ohm..100kohm --error 0.5%",
    "--r 1kohm..10kohm --rate 200Hz",
    "--sensor fsr402 --force 0.2N..20N --rate 100Hz --error 0.5% --board pi5",
    "--r 50ohm..2kohm --error 1ohm --wiring two --board pi-zero",
    "--r 300ohm..10kohm --error 0.05%",
    "--r 100ohm..10kohm --rate 20Hz --have 2.2uF,680nF,470ohm,10kohm",
];

/// The configuration that is written, after commissioning.
fn commissioned(asked: &Asked, best: &Rehearsed) -> Config {
    let mut config = file::parsed(asked, &best.design).unwrap();
    (config.channels[0].zero_ohm, config.channels[0].scale) = (Some(best.design.r_lim.0), Some(1.0));
    config
}

/// What is found for each of them.
static FOUND: LazyLock<Vec<(Asked, Vec<Rehearsed>)>> = LazyLock::new(|| {
    let found = |line| {
        let asked = asked(line);
        let all = find(&asked).unwrap();
        (asked, all)
    };
    CASES.into_iter().map(found).collect()
});

/// Boards of the kind, each of another seed than those that it was rehearsed on, and readings of each.
const BOARDS: u64 = 24;
const READINGS: usize = 60;

/// What `characterize` finds of a resistance with the configuration that is written, a row for each board.
fn characterized(asked: &Asked, best: &Rehearsed, r_ohm: f64, seed: u64) -> Vec<Row> {
    let config = commissioned(asked, best);
    let scene = built(asked.scene.clone(), &config.circuit).unwrap();
    let name = asked.name.clone();
    let seed = crate::seed::seed(1000 + seed);
    let cell = Cell { name, scene, config, r_ohm, change: None, seed, instruments: 1, readings: READINGS };
    let cells: Vec<Cell> = (0..BOARDS).map(|board| Cell { seed: seed + board, ..cell.clone() }).collect();
    let mut all = Vec::new();
    run(&cells, &|| false, |_, rows| {
        all.extend(rows);
        Ok::<(), CellError>(())
    })
    .unwrap();
    all
}

#[test]
fn what_is_promised_is_what_characterize_finds_on_other_boards_of_the_kind() {
    let mut wrong = Vec::new();
    for (line, (asked, found)) in CASES.iter().zip(FOUND.iter()) {
        let (best, need) = (&found[0], &asked.search.need);
        assert!(best.meets && reason::why_not(asked, Some(best)).is_none(), "{line}");
        for (index, one) in best.expected.iter().enumerate() {
            let rows = characterized(asked, best, one.r_ohm, 100 * index as u64);
            let of = |value: fn(&Row) -> Option<f64>| {
                rows.iter().map(|row| value(row).unwrap()).collect::<Vec<_>>()
            };
            let (error, u) = (rms_of(&of(|row| row.rms_ohm)), rms_of(&of(|row| row.u_ohm)));
            let rate = mean_of(&of(|row| row.published_s.map(|seconds| 1.0 / seconds)));
            let promised = one.u_ohm.unwrap();
            let parts = [error.times(1.0 / promised), u.times(1.0 / promised), rate.times(1.0 / one.rate_hz)];
            let [error_is, u_is, rate_is] = parts;
            let says = format!(
                "{line}, {} ohm: error {error_is:.3}, u {u_is:.3}, rate {rate_is:.3} of what is promised",
                one.r_ohm
            );
            println!("{says}");
            let is_met = need.tolerance.is_none() || error.below(need.ohm_at(one.r_ohm)).may_be(true);
            let is_fast = need.rate_hz.is_none_or(|wanted| rate.is_in(wanted..=f64::INFINITY));
            if !parts.iter().all(|part| part.is_in(0.85..=1.15)) || !is_met || !is_fast {
                wrong.push(says);
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// On the board that `check` takes the lines of the configuration for.
#[test]
fn what_is_promised_is_what_check_finds_of_what_is_written() {
    for (asked, found) in FOUND.iter() {
        let config = commissioned(asked, &found[0]);
        let (settings, (scene, _)) = (config.settings().unwrap(), board(&config, None).unwrap());
        for one in &found[0].expected {
            assert_eq!(rehearse(&settings, &scene, one.r_ohm, found[0].boards), Some(*one));
        }
    }
}

#[test]
fn no_candidate_that_was_not_rehearsed_is_much_better() {
    for line in
        ["--r 100ohm..100kohm --rate 20Hz", "--sensor fsr402 --force 0.2N..20N --rate 50Hz --board pi-zero"]
    {
        let asked = asked(line);
        let best = find(&asked).unwrap().remove(0);
        let error = |one: &Rehearsed| one.overall.unwrap().error;
        let ranked = asked.search.ranked(PERIOD_SHARES[0]);
        let every = (ranked.len() / 20).max(1);
        for one in ranked.iter().step_by(every) {
            let other = rehearsal::rehearsed(&asked, &one.design, one.worst, 1).unwrap();
            let is_much_better = other.meets && error(&other) < 0.75 * error(&best);
            assert!(
                !is_much_better,
                "{line}: {:?} with {}, {:?} with {}",
                best.design,
                error(&best),
                other.design,
                error(&other)
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
            let planned = one.design.config(&asked.search.platform);
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
    assert!(best.overall.is_ok_and(|overall| overall.error > 0.7), "{best:?}");
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
