//! What is predicted, against simulated readings.

use super::*;
use crate::config::backend::simulated_noise;
use crate::estimate::scatter::{MEDIAN_DEVIATION, median};
use crate::instrument::{Instrument, Message};
use crate::pins::sim::{Scene, Sensor, SimPins};
use crate::reading::Status;

const READINGS: usize = 600;

fn config(kind: &str, measure: &str) -> Config {
    let capacitors =
        if kind == "two-capacitor" { "c-a = \"2.2 uF\"\nc-b = \"680 nF\"" } else { "c = \"470 nF\"" };
    let text = format!(
        "[circuit]\nkind = \"{kind}\"\n{capacitors}\nr-c1 = \"2.32 kohm\"\nr-c2 = \"12.7 kohm\"\nv-th = \"1.1 V\"\n\
         [measure]\n{measure}\n[[channel]]\nid = \"x\"\n[mock]\nscene = \"pi4\"\n"
    );
    Config::parse(&text, "test").unwrap()
}

/// The spread of readings of a resistance (rare long delays hardly change it), ohm, and from one to the next, s.
fn measured(config: &Config, r: Ohm) -> (f64, f64) {
    let scene = Scene::builtin("pi4").unwrap().with_kind(config.circuit.kind()).unwrap();
    let scene = scene.with_sensors(vec![Sensor::Constant(r)]).unwrap();
    let pins = SimPins::new(&scene, Some(crate::seed::seed(r.0 as u64)));
    let mut instrument = Instrument::new(pins, config.settings().unwrap());
    let (mut r_ohm, mut first, mut last) = (Vec::new(), None, Nanos::ZERO);
    while r_ohm.len() < READINGS {
        let is_warm = instrument.cycle().offset_is_known() && instrument.stats().cycles > 1000;
        instrument
            .step(&mut |message| match message {
                Message::Reading(reading) if is_warm => {
                    first.get_or_insert(reading.at);
                    last = reading.at;
                    let Status::Ok { r_ohm: measured, .. } = reading.status else { return };
                    r_ohm.push(measured.value);
                }
                _ => {}
            })
            .unwrap();
    }
    let middle = median(&mut r_ohm);
    r_ohm.iter_mut().for_each(|r_ohm| *r_ohm = (*r_ohm - middle).abs());
    let period_s = (last - first.unwrap()).as_seconds() / (READINGS - 1) as f64;
    (median(&mut r_ohm) / MEDIAN_DEVIATION, period_s)
}

#[test]
fn errors_and_rates_are_as_predicted() {
    // 1 sigma of a spread by the median deviation of so many readings.
    let sampling = 1.17 / (2.0 * READINGS as f64).sqrt() * 1.17;
    let mut wrong = Vec::new();
    for (kind, measure) in [
        ("two-capacitor", "method = \"tcdic\""),
        ("two-capacitor", "method = \"tpcm\""),
        ("two-capacitor", "method = \"cerm\""),
        ("two-capacitor", "method = \"tracked\""),
        ("one-capacitor", "method = \"tpcm\""),
        ("one-capacitor", "method = \"tracked\""),
        ("series-calibration", "method = \"qerm\""),
    ] {
        let config = config(kind, measure);
        for Prediction { r, u, period } in config.predictions(simulated_noise(&config).unwrap()) {
            let (spread_ohm, period_s) = measured(&config, r);
            let apart = (u.0 / spread_ohm - 1.0).abs();
            // Between the least and the most, and with what the system's calls take. Where a switch hardly pays, one that is
            // not known as well as it could be is not made.
            let is_in_time = 0.9 * period[0].0 < period_s && period_s < 1.25 * period[1].0;
            if apart > 0.25 + 4.0 * sampling || !is_in_time {
                wrong.push(format!("{kind}, {measure}, {r}: {u} {spread_ohm:.3}, {period:?} {period_s:.4}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
