//! What is expected, against the errors of other boards of the same kind.

use super::*;
use crate::chance::{mean_of, rms_of};
use crate::config_file::{ConfigFile, config};

const BOARDS: u64 = 24;

fn hardware(kind: &str, measure: &str) -> Config {
    let file = config(|c| {
        let c = match kind {
            "two-capacitor" => c,
            _ => c.one_capacitor(kind, "470 nF"),
        };
        c.set("circuit.v-th", "1.1 V").set("gpio.backend", "chardev").lines("measure", measure).channel("x")
    });
    file.parse()
}

/// Of the readings of a board: the root mean square of errors and of what is stated, ohm, and how many came in a second.
fn seen(scene: &Scene, settings: &Settings, r_ohm: f64, seed: u64) -> [f64; 3] {
    let sensor = Sensor::Constant(Ohm(settings.channels[0].as_read(r_ohm)));
    let scene = scene.clone().with_sensors(vec![sensor]).unwrap();
    let pins = SimPins::new(&scene, Some(crate::seed::seed(seed)));
    let mut instrument = Instrument::new(pins, settings.clone());
    let (mut errors, mut us, mut first, mut last) = (Vec::new(), Vec::new(), None, Nanos::ZERO);
    warm_up(&mut instrument, settings, Nanos::ZERO).unwrap();
    while errors.len() < 100 {
        instrument
            .step(&mut |message| {
                let Message::Reading(reading) = message else { return };
                first.get_or_insert(reading.at);
                last = reading.at;
                if let Status::Ok { r_ohm: found, .. } = reading.status {
                    errors.push(found.value - r_ohm);
                    us.push(found.u.unwrap());
                }
            })
            .unwrap();
    }
    [rms(&errors), rms(&us), (errors.len() - 1) as f64 / (last - first.unwrap()).as_seconds()]
}

#[test]
fn uncertainties_and_rates_are_as_expected_and_errors_no_greater() {
    let mut wrong = Vec::new();
    for (kind, measure) in [
        ("two-capacitor", "method = \"tcdic\""),
        ("two-capacitor", "method = \"tpcm\""),
        ("two-capacitor", "method = \"cerm\""),
        ("two-capacitor", ""),
        ("one-capacitor", "method = \"tpcm\""),
        ("one-capacitor", ""),
        ("one-capacitor", "average = \"50 ms\""),
        ("series-calibration", ""),
    ] {
        let config = hardware(kind, measure);
        let (settings, (scene, _)) = (config.settings().unwrap(), board(&config, None).unwrap());
        for Expected { r_ohm, u_ohm, rate_hz, .. } in expected(&config, &settings, &scene) {
            let boards: Vec<_> = (0..BOARDS).map(|seed| seen(&scene, &settings, r_ohm, seed)).collect();
            let of = |index: usize| boards.iter().map(|board| board[index]).collect::<Vec<_>>();
            let u_ohm = u_ohm.unwrap();
            let (error, u) = (rms_of(&of(0)).times(1.0 / u_ohm), rms_of(&of(1)).times(1.0 / u_ohm));
            let rate = mean_of(&of(2)).times(1.0 / rate_hz);
            // What a board does not do that u has to allow for, drifts and leaks that do not show, makes errors smaller.
            if !error.is_in(0.0..=1.15) || !u.is_in(0.85..=1.15) || !rate.is_in(0.85..=1.15) {
                wrong.push(format!("{kind}, {measure}, {r_ohm}: error {error}, u {u}, rate {rate} of it"));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
}

#[test]
fn errors_count_where_they_refute_what_is_stated_by_more_than_chance() {
    let refuted = |squares: &[f64]| {
        let board =
            |square: &f64| RehearsalSum { numbers: 10, errors: 10.0 * square, ..RehearsalSum::default() };
        refuted_by(&squares.iter().map(board).collect::<Vec<_>>(), 1.0)
    };
    assert_eq!(refuted(&[4.0, 5.0, 4.0, 3.0]), Some(4.0));
    for chance in [&[1.25, 0.75, 1.5, 1.0][..], &[9.0, 0.0, 0.0, 0.0], &[0.1, 0.2], &[9.0], &[]] {
        assert_eq!(refuted(chance), None, "{chance:?}");
    }
}

#[test]
fn a_board_that_never_measures_has_nothing_to_expect() {
    let mut file: ConfigFile = config(|c| c.channel("x"));
    file.set("gpio.backend", "mock").set("mock.scene", "pi4").set("circuit.r-c1", "4.7 kohm");
    let config = file.parse();
    let settings = config.settings().unwrap();
    let (scene, how) = board(&config, None).unwrap();
    let all = expected(&config, &settings, &scene);
    assert!(how == "the scene" && all.iter().all(|one| one.u_ohm.is_none()), "{all:?}");
}

/// One reading a minute, with no discharge between them.
#[test]
fn what_comes_too_late_to_be_simulated_is_said() {
    let config = hardware("two-capacitor", "idle = true\nrate-hz = 0.0167");
    let mut findings = Findings::default();
    readings(&config, &config.settings().unwrap(), None, &mut findings);
    assert!(format!("{findings:?}").contains("no calibration after 1"), "{findings:?}");
}

#[test]
fn a_mean_over_minutes_is_not_simulated_for_minutes() {
    let found = |average: &str| {
        let config = hardware("two-capacitor", &format!("average = \"{average}\""));
        let (settings, (scene, _)) = (config.settings().unwrap(), board(&config, None).unwrap());
        expected(&config, &settings, &scene)
    };
    let (longest, rehearsed) = (found("60 s"), found("5 s"));
    assert!(!longest.is_empty());
    for (long, short) in longest.iter().zip(&rehearsed) {
        let rate = long.rate_hz / short.rate_hz * 60.0 / 5.0;
        assert!(long.u_ohm == short.u_ohm && (rate - 1.0).abs() < 1e-9, "{long:?} {short:?}");
        assert!((long.rate_hz * 60.0 - 1.0).abs() < 0.1, "{long:?}");
    }
}
