//! What one would take instead, at its own speed: computed from data sheets, here and nowhere else.
//!
//! An ADC reads the divider sensor to ground, one fixed resistor to the supply. For 100 ohm to 16.2 kohm, as in the paper,
//! the largest relative error is smallest with a fixed resistor of the geometric mean, 1.27 kohm: d ln(R) / dV = (R + Rf)^2 / (V R Rf).
//! Resistors and supply count as known, as ours do; offset and gain as calibrated. What averages falls with the root of the number
//! of samples, what does not stays.

use super::limits::SAME;

/// Ohm: a value of the E96 series.
const FIXED: f64 = 1270.0;
/// Of the divider, volt.
const SUPPLY: f64 = 3.3;
/// The standard deviation of what lies anywhere within +-1.
const ANYWHERE: f64 = 0.577_35;
/// Section V of the paper, us: the longest reading by CERM.
const FPGA_S: f64 = 1076.82e-6;
/// The largest of 500 normal errors of either sign, in sigma: its median, (2 Phi(x) - 1)^500 = 1/2.
const LARGEST_OF_500: f64 = 3.20;
/// 1 uF charged through the sensor to 1.3 V of 3.3 V, seconds per ohm: 1 uF ln(3.3 / 2).
const CHARGE: f64 = 0.50e-6;
/// A ceramic capacitor of 10 %, as a share of the resistance.
const CAPACITOR: f64 = 0.1 * ANYWHERE;

/// One of them.
pub struct Rival {
    pub name: &'static str,
    /// Beyond what ours needs, too.
    pub price: &'static str,
    /// How its numbers come about.
    pub how: &'static str,
    pub sources: &'static [&'static str],
    /// Seconds of one sample of so many ohm.
    pub sample_s: fn(f64) -> f64,
    /// What averages of one sample, and what does not, ohm, 1 sigma; `None` where nothing is known.
    pub error: fn(f64) -> Option<[f64; 2]>,
    /// Whether it is known what means of it are worth.
    pub is_averaged: bool,
}

/// Ohm for each volt at the divider.
fn slope(r_ohm: f64, volt: f64) -> f64 {
    (r_ohm + FIXED).powi(2) / (volt * FIXED)
}

/// The paper's largest errors, ohm, at the only resistances for which it prints them.
fn printed(r_ohm: f64) -> Option<f64> {
    let printed = [(100.0, 0.88), (15_010.0, 6.2)];
    printed.iter().find(|(at, _)| (r_ohm / at - 1.0).abs() < SAME).map(|(_, mae)| *mae)
}

pub const RIVALS: [Rival; 6] = [
    Rival {
        name: "ADS1115, 860/s",
        price: "about 7 USD as a module",
        how: "16 bits, 4.096 V: a step of 125 uV and 30 uV rms of noise average, a nonlinearity of one step at the most does not.",
        sources: &[
            "https://www.ti.com/lit/ds/symlink/ads1115.pdf",
            "https://e2e.ti.com/support/data_converters/precision_data_converters/f/73/t/442080",
            "https://openhardware.directory/devices/ads1115-16bit-adc-module",
        ],
        sample_s: |_| 1.0 / 860.0,
        error: |r_ohm| {
            let noise = 30e-6f64.hypot(125e-6 / 12f64.sqrt());
            Some([noise, 125e-6 * ANYWHERE].map(|volt| volt * slope(r_ohm, SUPPLY)))
        },
        is_averaged: true,
    },
    Rival {
        name: "MCP3008, 75000/s",
        price: "a few USD (assumed)",
        how: "10 bits of 3.3 V: a step of 3.2 mV, which nothing dithers, and a typical nonlinearity of half a step; neither averages. \
              75000 samples a second at 2.7 V; the time of a call is not counted.",
        sources: &["https://dtsheet.com/doc/39122/microchip-mcp3004-i-st"],
        sample_s: |_| 1.0 / 75e3,
        error: |r_ohm| {
            let step = SUPPLY / 1024.0;
            Some([0.0, (step / 12f64.sqrt()).hypot(0.5 * step * ANYWHERE) * slope(r_ohm, SUPPLY)])
        },
        is_averaged: true,
    },
    Rival {
        name: "HX711, 80/s",
        price: "a few USD (assumed)",
        how: "Gain 128: +-20 mV, so the divider is fed with 46.8 mV. 90 nV rms at 80 samples a second and 50 nV at 10: 80 nV average, 41 nV do not. Its nonlinearity is not \
              stated and not counted; it takes 50 ms to follow a step.",
        sources: &[
            "https://datasheet.eeworld.com.cn/view/18792612.html",
            "https://learn.sparkfun.com/tutorials/openscale-applications-and-hookup-guide/hardware-features",
        ],
        sample_s: |_| 1.0 / 80.0,
        error: |r_ohm| Some([80e-9, 41e-9].map(|volt| volt * slope(r_ohm, 46.8e-3))),
        is_averaged: true,
    },
    Rival {
        name: "gpiozero LightSensor",
        price: "one capacitor",
        how: "As it comes: 1 uF of 10 %, 0.1 s of draining, and the charge timed from Python: 58 us late (assumed: 50 us for a call, 8 us for \
              the stamp) with a scatter of 5 us (assumed).",
        sources: &["https://github.com/gpiozero/gpiozero/blob/master/gpiozero/input_devices.py"],
        sample_s: |r_ohm| 0.1 + CHARGE * r_ohm,
        error: |r_ohm| Some([5e-6 / CHARGE, (CAPACITOR * r_ohm).hypot(58e-6 / CHARGE)]),
        is_averaged: true,
    },
    Rival {
        name: "plain RCtime loop",
        price: "one capacitor",
        how: "As it comes: 1 uF of 10 %, 0.1 s of draining, then passes of a Python loop are counted: 2.1 us for a call, two calls' worth \
              for a pass (assumed).",
        sources: &[
            "https://learn.adafruit.com/basic-resistor-sensor-reading-on-raspberry-pi?view=all",
            "http://codeandlife.com/tags/c/",
        ],
        sample_s: |r_ohm| 0.1 + CHARGE * r_ohm,
        error: |r_ohm| Some([4.1e-6 / 12f64.sqrt() / CHARGE, CAPACITOR * r_ohm]),
        is_averaged: true,
    },
    Rival {
        name: "the paper's FPGA, CERM",
        price: "tens of USD (assumed)",
        how: "Its printed largest errors of 500, divided by 3.20, and its longest reading; they are printed at 100 ohm and 15.01 kohm only. \
              Whether they average is not said.",
        sources: &[],
        sample_s: |_| FPGA_S,
        error: |r_ohm| printed(r_ohm).map(|mae| [0.0, mae / LARGEST_OF_500]),
        is_averaged: false,
    },
];

impl Rival {
    /// Seconds and error in ohm, 1 sigma: one sample, and means of as many as fit below `until` seconds.
    pub fn points(&self, r_ohm: f64, until: f64) -> Vec<[f64; 2]> {
        let Some([noise, floor]) = (self.error)(r_ohm) else { return Vec::new() };
        let one = (self.sample_s)(r_ohm);
        let counts = (0..8).flat_map(|power| [1.0, 3.0].map(|digit| digit * 10f64.powi(power)));
        let fitting = counts.filter(|count| *count == 1.0 || (count * one <= until));
        let points = fitting.map(|count| [count * one, (noise / count.sqrt()).hypot(floor)]);
        points.take(if self.is_averaged { usize::MAX } else { 1 }).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    /// The fixed resistor, and with it every number of an ADC here, is the best one for the range.
    #[test]
    fn no_fixed_resistor_is_better_at_both_ends() {
        let worst = |fixed: f64| {
            let relative = |r_ohm: f64| (r_ohm + fixed).powi(2) / (fixed * r_ohm);
            relative(100.0).max(relative(16_200.0))
        };
        let best =
            (1..2000).map(|step| f64::from(step) * 10.0).min_by(|a, b| worst(*a).total_cmp(&worst(*b)));
        assert_eq!(best, Some(FIXED));
        let span = |r_ohm: f64| r_ohm / (r_ohm + FIXED);
        assert!((46.8e-3 * (span(16_200.0) - span(100.0)) - 40e-3).abs() < 0.05e-3, "what the HX711 takes");
    }

    #[test]
    fn averages_end_at_what_does_not_average() {
        let ads = RIVALS[0].points(1000.0, 10.0);
        // 1230 ohm/V, by hand: 47 uV average, 72 uV do not.
        assert!((ads[0][1] - 0.1058).abs() < 0.0005, "{ads:?}");
        let floor = (RIVALS[0].error)(1000.0).unwrap()[1];
        assert!(ads[1][1] < ads[0][1] && ads.last().unwrap()[1] < 1.01 * floor, "{ads:?}");
        let fpga = &RIVALS[5];
        // Nothing is made up between.
        for r_ohm in [1000.0, 14_500.0, 16_200.0] {
            assert_eq!(fpga.points(r_ohm, 10.0).len(), 0);
        }
        assert!((fpga.points(15_000.0, 10.0)[0][1] - 1.9375).abs() < 0.0001);
        assert!((fpga.points(100.0, 10.0)[0][1] - 0.275).abs() < 0.0001);
    }

    #[test]
    fn half_of_all_largest_errors_are_larger() {
        const SETS: usize = 2001;
        let mut rng = ChaCha8Rng::seed_from_u64(crate::seed::seed(1));
        let mut largest = || (0..500).map(|_| f64::abs(rng.sample(StandardNormal))).fold(0.0, f64::max);
        let larger = (0..SETS).filter(|_| largest() > LARGEST_OF_500).count();
        let off = larger as f64 - 0.5 * SETS as f64;
        // Five standard deviations of that count, 0.05 sigma; 3.04 is off by 17.
        assert!(off.abs() < 5.0 * 0.5 * (SETS as f64).sqrt(), "{larger} of {SETS}");
    }
}
