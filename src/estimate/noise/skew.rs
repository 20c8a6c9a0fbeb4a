//! Whether noise is wide-band, by the skewness of crossings.
//!
//! Of noise that is wide compared with a crossing there are many dips, and the first one below the threshold is stamped. It comes
//! the earlier the slower the node falls, more than in proportion: by b for each e-fold of the time that it takes, in units in
//! which that time is 1. Two known resistors do not tell such a bend, and no scatter of theirs does; but the first of many dips
//! scatters by as much as b, nearly, and more to the early side than to the late one (extreme values: Gumbel's distribution in
//! the limit), while other noise is as often late as early, and interrupts are late only.

use crate::estimate::limits::{EARLY_OF_SCATTER, NOISE_MEMORY, SKEW_OF_FIRST, SKEW_SHOWS};

/// Of the crossings of one node through one resistor: how many, and the sums of their first three powers.
#[derive(Debug, Clone, Copy)]
pub struct Skew {
    count: f64,
    sums: [f64; 3],
}

impl Skew {
    /// Of none.
    pub const NEW: Skew = Skew { count: 0.0, sums: [0.0; 3] };

    /// Takes how far a crossing was from where it was expected.
    pub fn add(&mut self, away: f64) {
        let keep = if self.count > NOISE_MEMORY { 1.0 - 1.0 / NOISE_MEMORY } else { 1.0 };
        self.count = keep * self.count + 1.0;
        for (sum, power) in self.sums.iter_mut().zip([away, away * away, away * away * away]) {
            *sum = keep * *sum + power;
        }
    }

    /// The variance, and the third cumulant in units of it to the power of 3/2; 0 for what does not scatter.
    fn value(&self) -> (f64, f64) {
        let [mean, square, cube] = self.sums.map(|sum| sum / self.count);
        let variance = (square - mean * mean).max(0.0);
        let third = cube - 3.0 * mean * square + 2.0 * mean * mean * mean;
        let skewness = third / (variance * variance.sqrt());
        if skewness.is_finite() { (variance, skewness) } else { (0.0, 0.0) }
    }
}

/// By how much a crossing of either node is early for each e-fold of its time, in the unit of what was taken; 0 as long as nothing
/// shows. Whether it does, both tell together, since one noise moves both.
pub fn early(nodes: [Skew; 2]) -> [f64; 2] {
    let count = nodes[0].count + nodes[1].count;
    let (values, counts) = (nodes.map(|node| node.value()), nodes.map(|node| node.count));
    let skewness = values.iter().zip(counts).map(|((_, skewness), of)| of / count * skewness).sum::<f64>();
    // Of normal values the skewness of `count` has this variance.
    let sigmas = -skewness / (6.0 / count).sqrt();
    let [from, to] = SKEW_SHOWS;
    // Of nothing nothing shows.
    let shown = if sigmas > from { ((sigmas - from) / (to - from)).min(1.0) } else { return [0.0; 2] };
    // What is not wide-band has no third cumulant: only the rest of the scatter has one.
    let share = (-skewness / SKEW_OF_FIRST).min(1.0).cbrt();
    values.map(|(variance, _)| shown * EARLY_OF_SCATTER * share * variance.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::{mean_of, share_is_in};
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Exp1, Gumbel, StandardNormal};

    const BOARDS: u64 = 200;
    const SIGMA: f64 = 50.0;

    /// What is found of so many crossings of each node, as they are drawn; `ramp`: how far each is expected beside the one before.
    fn found(count: usize, ramp: f64, draw: impl Fn(&mut ChaCha8Rng) -> f64) -> Vec<f64> {
        let of_board = |seed| {
            let mut rng = crate::seed::rng(seed);
            let mut nodes = [Skew::NEW; 2];
            for index in 0..count {
                nodes.iter_mut().for_each(|node| node.add(ramp * index as f64 + SIGMA * draw(&mut rng)));
            }
            early(nodes)[0] / SIGMA
        };
        (0..BOARDS).map(of_board).collect()
    }

    fn normal(rng: &mut ChaCha8Rng) -> f64 {
        rng.sample(StandardNormal)
    }

    #[test]
    fn the_first_of_many_dips_shows_and_other_noise_does_not() {
        let shows = |found: &[f64]| found.iter().filter(|found| **found > 0.0).count();
        let late = |rng: &mut ChaCha8Rng| rng.sample::<f64, _>(Exp1);
        for (count, ramp) in [(30, 0.0), (300, 0.0), (3000, 0.0), (3000, 0.01)] {
            let calm = shows(&found(count, ramp, normal));
            assert!(share_is_in(calm, BOARDS as usize, 0.0..=0.04), "{calm} of {BOARDS} with {count}");
            assert_eq!(shows(&found(count, ramp, late)), 0, "interrupts are late, not early");
        }
        let first = |rng: &mut ChaCha8Rng| -Gumbel::new(0.0, 0.8).unwrap().sample(rng);
        for (count, least) in [(60, 0.4), (200, 0.7)] {
            let mean = mean_of(&found(count, 0.0, first));
            assert!(mean.is_in(least..=EARLY_OF_SCATTER), "{mean} with {count}");
        }
        // Beside as much of other noise: b is 0.8.
        let mean = mean_of(&found(1000, 0.0, |rng| normal(rng) + first(rng)));
        assert!(mean.is_in(0.7..=1.0), "{mean}");
    }

    #[test]
    fn nothing_and_what_never_scatters_is_not_skewed() {
        assert_eq!(early([Skew::NEW; 2]), [0.0; 2]);
        assert!(found(300, 0.0, |_| 0.0).into_iter().all(|early| early == 0.0));
    }
}
