//! Voltage noise as it shows in the instant of a crossing: how much earlier or later a noisy input changes.

use super::scene::NoiseScene;
use crate::pins::limits::{EARLIEST_CROSSING, MOST_NOISE_STEPS};
use rand::{Rng, RngExt};
use rand_distr::{Exp1, StandardNormal};
use std::f64::consts::{SQRT_2, TAU};

impl NoiseScene {
    /// Draws the shift of a crossing whose voltage falls with `slope` (V/s, its magnitude), in seconds; negative is early.
    ///
    /// Without bandwidth B this is trigger noise: Gaussian, sigma = voltage / slope, eq. (7). With it the noise is wide
    /// compared with the crossing: independent samples 1/(2B) apart.
    pub(super) fn shift(&self, slope: f64, rng: &mut impl Rng) -> f64 {
        let unit = self.voltage.0 / slope;
        let z = match self.bandwidth {
            None => rng.sample::<f64, _>(StandardNormal),
            Some(bandwidth) => {
                let spacing = 0.5 / bandwidth.0;
                first_crossing(unit / spacing, rng.sample::<f64, _>(Exp1))
            }
        };
        let shift = z * unit;
        if shift.is_finite() { shift } else { 0.0 }
    }
}

/// The first sample below the threshold, in units of voltage / slope after the true crossing.
///
/// z of these units after it, a sample is below with probability Phi(z), and `samples` samples fall in a unit: the
/// cumulative hazard is samples (z Phi(z) + phi(z)), and the first crossing comes where it reaches an exponential
/// variate. Exact in the limit of many samples in a unit (wide-band noise); where they are rarer than one in a unit it
/// becomes the wait for the next sample.
fn first_crossing(samples: f64, exponential: f64) -> f64 {
    let wanted = exponential / samples;
    // The function is convex, rises from 0, and lies above both 0 and z: to the right of the root Newton's
    // method descends without overshoot.
    let mut z = wanted;
    for _ in 0..MOST_NOISE_STEPS {
        let (below, density) = (normal_below(z), (-0.5 * z * z).exp() / TAU.sqrt());
        let step = (z * below + density - wanted) / below;
        z -= step;
        if step.abs() <= 1e-9 * (1.0 + z.abs()) || z < EARLIEST_CROSSING {
            break;
        }
    }
    z.max(EARLIEST_CROSSING)
}

/// Phi, by the complementary error function of W. J. Cody's form as in Numerical Recipes (erfc Chebyshev fit,
/// relative error below 1.2e-7 everywhere).
fn normal_below(z: f64) -> f64 {
    0.5 * erfc(-z / SQRT_2)
}

fn erfc(x: f64) -> f64 {
    const FIT: [f64; 10] = [
        -1.265_512_23,
        1.000_023_68,
        0.374_091_96,
        0.096_784_18,
        -0.186_288_06,
        0.278_868_07,
        -1.135_203_98,
        1.488_515_87,
        -0.822_152_23,
        0.170_872_77,
    ];
    let t = 1.0 / (1.0 + 0.5 * x.abs());
    let polynomial = FIT.iter().rev().fold(0.0, |sum, factor| sum * t + factor);
    let tail = t * (polynomial - x * x).exp();
    if x >= 0.0 { tail } else { 2.0 - tail }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::{mean_of, sd_of};
    use crate::units::{Hertz, Volt};
    use rand_chacha::ChaCha8Rng;

    /// Against the process itself: a falling line sampled with independent noise until a sample is below.
    #[test]
    fn the_first_crossing_is_that_of_a_sampled_process() {
        for spacing in [0.1, 0.02, 0.005] {
            let noise = NoiseScene { voltage: Volt(1.0), bandwidth: Some(Hertz(0.5 / spacing)) };
            let mut rng = crate::seed::rng(3);
            let sampled: Vec<f64> = (0..2000).map(|_| sampled(spacing, &mut rng)).collect();
            let drawn: Vec<f64> = (0..2000).map(|_| noise.shift(1.0, &mut rng)).collect();
            let apart = mean_of(&sampled).less(mean_of(&drawn));
            let wider = sd_of(&sampled).over(sd_of(&drawn));
            // The continuous hazard is a sum over samples: they differ by less than half a sample.
            assert!(
                apart.is(0.0, 0.5 * spacing) && wider.is(1.0, 0.5 * spacing),
                "{spacing}: {apart}, {wider}"
            );
        }
    }

    fn sampled(spacing: f64, rng: &mut ChaCha8Rng) -> f64 {
        let mut t = -6.0 + spacing * rng.random::<f64>();
        while rng.sample::<f64, _>(StandardNormal) > t {
            t += spacing;
        }
        t
    }

    #[test]
    fn the_normal_distribution_has_its_tabulated_values() {
        for (z, wanted) in [(0.0, 0.5), (1.0, 0.841_344_746), (-2.0, 0.022_750_132), (-6.0, 9.865_876_45e-10)]
        {
            assert!((normal_below(z) / wanted - 1.0).abs() < 3e-7, "{z}");
        }
    }
}
