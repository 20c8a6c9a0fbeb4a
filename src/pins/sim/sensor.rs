//! What is connected in a sensor's place: R_x as a function of time.

use crate::pins::limits::{
    PEAK_NEWTON, PERIOD_SECONDS, PRESS_BEGINS, PRESS_FORCE, PRESS_HOLDS, PRESS_RISES, TREMOR_HZ,
    TREMOR_SHARE, UNTOUCHED_OHM,
};
use crate::sensor::FSR_402;
use crate::units::{Hertz, Newton, NewtonOhm, Ohm, Seconds};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;
use std::f64::consts::TAU;
use std::path::PathBuf;

/// R_x of one channel.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", rename_all_fields = "kebab-case", deny_unknown_fields)]
pub enum Sensor {
    /// Always the same.
    Constant(Ohm),
    /// One value before an instant, another after it.
    Step {
        /// Before.
        before: Ohm,
        /// From `at` on.
        after: Ohm,
        /// Since the start of the simulation.
        at: Seconds,
    },
    /// Linear between two values, constant before and after.
    Ramp {
        /// Until `start`.
        from: Ohm,
        /// From `start` + `duration` on.
        to: Ohm,
        /// Since the start of the simulation.
        start: Seconds,
        /// Of the change.
        duration: Seconds,
    },
    /// mean + amplitude sin(2 pi frequency t).
    Sine {
        /// In the middle.
        mean: Ohm,
        /// Peak, below the mean.
        amplitude: Ohm,
        /// Of the oscillation.
        frequency: Hertz,
    },
    /// Interpolated linearly between the rows `time_s,ohm` of a CSV file; constant before and after.
    File {
        /// Relative to the folder of the scene file.
        path: PathBuf,
        /// The rows.
        #[serde(skip)]
        points: Vec<(f64, f64)>,
    },
    /// A hand that presses an FSR 402 again and again, R_x = alpha / F, a little differently each time.
    Hand {
        /// Of the sensor.
        #[serde(default = "fsr_402")]
        alpha: NewtonOhm,
        /// The strongest press.
        #[serde(default = "firm")]
        peak: Newton,
        /// From one press to the next.
        #[serde(default = "unhurried")]
        period: Seconds,
    },
}

impl Sensor {
    /// A hand on an FSR 402, as it is when a scene says no more.
    pub fn hand() -> Sensor {
        Sensor::Hand { alpha: fsr_402(), peak: firm(), period: unhurried() }
    }
}

fn fsr_402() -> NewtonOhm {
    FSR_402
}

fn firm() -> Newton {
    Newton(PEAK_NEWTON)
}

fn unhurried() -> Seconds {
    Seconds(PERIOD_SECONDS)
}

/// A sensor in use: with the press that a hand is just making.
#[derive(Debug, Clone)]
pub(super) struct ActiveSensor {
    sensor: Sensor,
    rng: ChaCha8Rng,
    press: Option<Press>,
}

/// One press of a hand; times in seconds.
#[derive(Debug, Clone, Copy)]
struct Press {
    index: u64,
    begin: f64,
    rise: f64,
    hold: f64,
    force: f64,
}

impl ActiveSensor {
    /// `stream` keeps the hands of several channels apart.
    pub fn new(sensor: Sensor, seed: u64, stream: u64) -> ActiveSensor {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(stream);
        ActiveSensor { sensor, rng, press: None }
    }

    pub fn is_constant(&self) -> bool {
        matches!(self.sensor, Sensor::Constant(_))
    }

    /// Ohm, `t` seconds after the start of the simulation.
    pub fn r_x(&mut self, t: f64) -> f64 {
        match &self.sensor {
            Sensor::Constant(r) => r.0,
            Sensor::Step { before, after, at } => {
                if t < at.0 {
                    before.0
                } else {
                    after.0
                }
            }
            Sensor::Ramp { from, to, start, duration } => {
                from.0 + (to.0 - from.0) * ((t - start.0) / duration.0).clamp(0.0, 1.0)
            }
            Sensor::Sine { mean, amplitude, frequency } => {
                mean.0 + amplitude.0 * (TAU * frequency.0 * t).sin()
            }
            Sensor::File { points, .. } => interpolate(points, t),
            Sensor::Hand { alpha, peak, period } => {
                let (alpha, peak, period) = (alpha.0, peak.0, period.0);
                (alpha / self.force(t, peak, period)).min(UNTOUCHED_OHM)
            }
        }
    }

    /// Newton. Each period holds one press that begins and ends inside it.
    fn force(&mut self, t: f64, peak: f64, period: f64) -> f64 {
        let index = (t / period).max(0.0) as u64;
        let press = match self.press {
            Some(press) if press.index == index => press,
            _ => self.press(index, peak, period),
        };
        self.press = Some(press);
        let since = t - index as f64 * period - press.begin;
        let smooth = |share: f64| {
            let s = share.clamp(0.0, 1.0);
            s * s * (3.0 - 2.0 * s)
        };
        let envelope =
            smooth(since / press.rise) * smooth((2.0 * press.rise + press.hold - since) / press.rise);
        press.force * envelope * (1.0 + TREMOR_SHARE * (TAU * TREMOR_HZ * t).sin())
    }

    /// Each press has a block of the generator of its own, so that any instant can be asked for.
    fn press(&mut self, index: u64, peak: f64, period: f64) -> Press {
        self.rng.set_word_pos(u128::from(index) * 16);
        let mut between = |[low, high]: [f64; 2]| low + (high - low) * self.rng.random::<f64>();
        Press {
            index,
            begin: between(PRESS_BEGINS) * period,
            rise: between(PRESS_RISES) * period,
            hold: between(PRESS_HOLDS) * period,
            force: between(PRESS_FORCE) * peak,
        }
    }
}

fn interpolate(points: &[(f64, f64)], t: f64) -> f64 {
    let next = points.partition_point(|(time, _)| *time <= t);
    match (next.checked_sub(1).and_then(|last| points.get(last)), points.get(next)) {
        (Some((t0, r0)), Some((t1, r1))) => r0 + (r1 - r0) * (t - t0) / (t1 - t0),
        (Some((_, r)), None) | (None, Some((_, r))) => *r,
        (None, None) => UNTOUCHED_OHM,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hand_presses_differently_each_time_and_lets_go() {
        let mut source = ActiveSensor::new(Sensor::hand(), 1, 16);
        let strongest: Vec<f64> = (0..20)
            .map(|press| {
                let r = (0..200).map(|i| source.r_x(f64::from(press) * 2.0 + f64::from(i) * 0.01));
                FSR_402.0 / r.fold(f64::INFINITY, f64::min)
            })
            .collect();
        assert!(strongest.iter().all(|force| (0.9..10.3).contains(force)), "{strongest:?}");
        assert!(strongest.windows(2).all(|pair| pair[0] != pair[1]));
        for press in 0..20 {
            assert_eq!(source.r_x(f64::from(press) * 2.0), UNTOUCHED_OHM);
        }
    }

    #[test]
    fn a_hand_is_the_same_from_whichever_side_it_is_looked_at() {
        let (mut forward, mut backward) =
            (ActiveSensor::new(Sensor::hand(), 5, 16), ActiveSensor::new(Sensor::hand(), 5, 16));
        let times: Vec<f64> = (0..400).map(|i| 0.05 * f64::from(i)).collect();
        let there: Vec<f64> = times.iter().map(|t| forward.r_x(*t)).collect();
        let mut back: Vec<f64> = times.iter().rev().map(|t| backward.r_x(*t)).collect();
        back.reverse();
        assert_eq!(there, back);
        let mut other = ActiveSensor::new(Sensor::hand(), 6, 16);
        assert_ne!(there, times.iter().map(|t| other.r_x(*t)).collect::<Vec<_>>());
    }

    #[test]
    fn the_other_profiles_are_what_they_say() {
        let r = |sensor: Sensor, t: f64| ActiveSensor::new(sensor, 1, 16).r_x(t);
        let step = || Sensor::Step { before: Ohm(1.0), after: Ohm(2.0), at: Seconds(3.0) };
        assert_eq!((r(step(), 2.9), r(step(), 3.0)), (1.0, 2.0));
        let ramp =
            || Sensor::Ramp { from: Ohm(10.0), to: Ohm(20.0), start: Seconds(1.0), duration: Seconds(2.0) };
        assert_eq!((r(ramp(), 0.0), r(ramp(), 2.0), r(ramp(), 9.0)), (10.0, 15.0, 20.0));
        let sine = || Sensor::Sine { mean: Ohm(100.0), amplitude: Ohm(50.0), frequency: Hertz(0.25) };
        assert!((r(sine(), 1.0) - 150.0).abs() < 1e-9 && (r(sine(), 3.0) - 50.0).abs() < 1e-9);
        let file = || Sensor::File { path: PathBuf::new(), points: vec![(1.0, 10.0), (2.0, 30.0)] };
        assert_eq!((r(file(), 0.0), r(file(), 1.5), r(file(), 5.0)), (10.0, 20.0, 30.0));
    }
}
