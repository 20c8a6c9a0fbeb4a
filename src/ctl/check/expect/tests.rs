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

/// Errors of all readings of a board, ohm, and how many came in a second.
fn errors(scene: &Scene, settings: &Settings, r_ohm: f64, seed: u64) -> (Vec<f64>, f64) {
    let scene = scene.clone().with_sensors(vec![Sensor::Constant(Ohm(r_ohm))]).unwrap();
    let pins = SimPins::new(&scene, Some(crate::seed::seed(seed)));
    let mut instrument = Instrument::new(pins, settings.clone());
    let (mut errors, mut first, mut last) = (Vec::new(), None, Nanos::ZERO);
    while errors.len() < 100 {
        let is_warm = instrument.cycle().offset_is_known() && instrument.pins().now() > WARM;
        instrument
            .step(&mut |message| match message {
                Message::Reading(reading) if is_warm => {
                    first.get_or_insert(reading.at);
                    last = reading.at;
                    if let Status::Ok { r_ohm: found, .. } = reading.status {
                        errors.push(found.value - r_ohm);
                    }
                }
                _ => {}
            })
            .unwrap();
    }
    let rate_hz = (errors.len() - 1) as f64 / (last - first.unwrap()).as_seconds();
    (errors, rate_hz)
}

#[test]
fn errors_and_rates_are_as_expected() {
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
            let (all, rates): (Vec<_>, Vec<_>) =
                (0..BOARDS).map(|seed| errors(&scene, &settings, r_ohm, seed)).unzip();
            let rms = rms_of(&all.iter().map(|board| rms(board)).collect::<Vec<_>>());
            let (error, rate) = (rms.times(1.0 / u_ohm.unwrap()), mean_of(&rates).times(1.0 / rate_hz));
            // Far above R_2 u is mostly what leaks may do that do not show, and these boards have none.
            let least = if r_ohm > 2.0 * settings.r_ohm()[1] { 0.0 } else { 0.85 };
            if !error.is_in(least..=1.15) || !rate.is_in(0.85..=1.15) {
                wrong.push(format!(
                    "{kind}, {measure}, {r_ohm}: error {error}, rate {rate} of what is expected"
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
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
