//! Middle and spread of measured values.

use crate::estimate::limits::{
    BEYOND_NOISE, READINGS_OF_SCATTER, SCATTER_DOUBT, SCATTER_MEMORY, UNKNOWN_SWITCH_NS, USUAL_STEP,
};
use crate::reading::Measured;
use crate::record::Record;

/// The middle of values, or of the middle two of an even number; 0 of none. Sorts them.
pub fn median(values: &mut [f64]) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    let at = |index: usize| values.get(index).copied().unwrap_or(0.0);
    (at(values.len().saturating_sub(1) / 2) + at(values.len() / 2)) / 2.0
}

/// What the median of the absolute deviations of a normal distribution is, in sigma.
pub const MEDIAN_DEVIATION: f64 = 0.6745;

/// Where most of many values are, and how far from there: both go a small step towards each value, so that a value far away
/// moves them no more than a near one. With these steps the place of normal values is uncertain by a sixth of their sigma.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Usual {
    /// The median.
    pub place: f64,
    /// The median of the absolute deviations from it.
    deviation: f64,
}

impl Usual {
    /// Of nothing.
    pub const NONE: Usual = Usual { place: 0.0, deviation: 0.0 };

    /// Of the first values. Leaves their deviations in them, sorted.
    pub fn of(values: &mut [f64]) -> Usual {
        let place = median(values);
        values.iter_mut().for_each(|value| *value = (*value - place).abs());
        Usual { place, deviation: median(values) }
    }

    /// 1 sigma of normal values whose deviations have such a median.
    pub fn sigma(&self) -> f64 {
        self.deviation / MEDIAN_DEVIATION
    }

    /// Whether a value is no farther away than noise makes it.
    pub fn has(&self, value: f64) -> bool {
        (value - self.place).abs() <= self.reach()
    }

    /// The greatest of such values.
    pub fn greatest(&self) -> f64 {
        self.place + self.reach()
    }

    fn reach(&self) -> f64 {
        BEYOND_NOISE * self.sigma()
    }

    /// Takes a value; steps are no smaller than `least`, or those of values that were all alike would be none.
    pub fn add(&mut self, value: f64, least: f64) {
        let step = (USUAL_STEP * self.deviation).max(least);
        let beside = value - self.place;
        self.place += beside.clamp(-step, step);
        self.deviation += (beside.abs() - self.deviation).clamp(-step, step);
    }
}

/// The mean with its 1-sigma uncertainty by the scatter of independent values (GUM type A); `None` of none.
pub fn mean(values: impl Iterator<Item = f64> + Clone) -> Option<Measured> {
    let count = values.clone().count() as f64;
    if count == 0.0 {
        return None;
    }
    let value = values.clone().sum::<f64>() / count;
    let squares = values.map(|one| (one - value).powi(2)).sum::<f64>();
    Some(Measured { value, u: (count > 1.0).then(|| (squares / (count - 1.0) / count).sqrt()) })
}

/// 1 sigma of the time from a start to a switch by the length of calls, ns.
pub fn expected_ns(record: &Record) -> f64 {
    record.u_switch_ns.unwrap_or(UNKNOWN_SWITCH_NS)
}

/// What squares have shown so far.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Squares {
    /// The mean square, and what of it something else explains, ns².
    mean: f64,
    rest: f64,
    /// Of how many.
    count: f64,
}

impl Squares {
    /// `weight`: by nothing that the value itself has a part in, or small ones would weigh more than great ones.
    fn add(&mut self, value: f64, rest: f64, weight: f64, most: f64) {
        self.count = (self.count + weight).min(most);
        let share = if self.count > 0.0 { weight / self.count } else { 0.0 };
        self.mean += (value * value - self.mean) * share;
        self.rest += (rest - self.rest) * share;
    }

    /// By how much the variance is greater than what is explained, ns²; negative by chance.
    fn excess(&self) -> f64 {
        self.mean - self.rest
    }

    /// 1 sigma of that, ns²; `None` of nothing.
    fn u(&self) -> Option<f64> {
        (self.count > 0.0).then(|| self.mean.max(self.rest) * (2.0 / self.count).sqrt())
    }
}

/// How much the time from a start to a switch scatters: what split discharges show of it, against what is to be expected of
/// calls of that length.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SwitchScatter {
    /// By how much split discharges seem to have been switched late.
    splits: Squares,
    /// By how much successive readings of a sensor differ, as times of their switches.
    readings: Squares,
}

impl SwitchScatter {
    /// Takes by how much a split discharge seems to have been switched late, ns, and the variance that this would have if
    /// switches did not scatter, ns²; `expected_ns`: by the length of calls.
    pub fn add(&mut self, late_ns: f64, steady: f64, expected_ns: f64) {
        let expected = expected_ns * expected_ns;
        let weight = if expected > 0.0 { (1.0 + steady / expected).powi(-2) } else { 1.0 };
        self.splits.add(late_ns, steady, weight, SCATTER_MEMORY);
    }

    /// One that is known from elsewhere, 1 sigma, ns.
    pub fn of(u_ns: f64) -> SwitchScatter {
        let mut scatter = SwitchScatter::default();
        scatter.splits.add(u_ns, 0.0, SCATTER_MEMORY, SCATTER_MEMORY);
        scatter
    }

    /// What the discharges alone say of it, 1 sigma, ns; `None` of none.
    pub fn found_ns(&self) -> Option<f64> {
        (self.splits.count > 0.0).then(|| self.u_ns(UNKNOWN_SWITCH_NS))
    }

    /// Takes by how much a reading of a sensor is beside those before and after it, as a time of their switches, ns: at rest
    /// by no less than these scatter. `steady`: the variance if they did not, ns².
    pub fn add_reading(&mut self, beside_ns: f64, steady: f64) {
        self.readings.add(beside_ns, steady, 1.0, READINGS_OF_SCATTER[1]);
    }

    /// What readings show, with its 1 sigma, once there are enough of them, ns².
    fn shown_by_readings(&self) -> Option<[f64; 2]> {
        self.readings
            .u()
            .filter(|_| self.readings.count >= READINGS_OF_SCATTER[0])
            .map(|u| [self.readings.excess(), u])
    }

    /// What readings show at the least, as far as split discharges do not contradict: few of these say less by chance, ns².
    fn agreed(&self) -> f64 {
        let Some([shown, u]) = self.shown_by_readings() else { return 0.0 };
        let most = self.splits.u().map(|u| self.splits.excess() + 2.0 * u);
        most.map_or(shown - u, |most| most.min(shown - u)).max(0.0)
    }

    /// 1 sigma, ns, and as much more as is not known of it; `expected_ns`: by the length of calls, which may be wrong by as
    /// much as it is, or as the discharges say, but is not less steady than readings are.
    pub fn u_ns(&self, expected_ns: f64) -> f64 {
        // No steadier than they let readings be are switches if the sensor is at rest, and steadier if it is not.
        let bound = self.shown_by_readings().map(|[shown, u]| shown.max(0.0) + u);
        let expected = expected_ns * expected_ns;
        let expected = bound.map_or(expected, |bound| expected.min(bound));
        let doubt = expected.max(self.splits.excess());
        let information = |u: Option<f64>| u.filter(|u| *u > 0.0).map_or(0.0, |u| 1.0 / (u * u));
        let [prior, shown] = [Some(doubt), self.splits.u()].map(information);
        let all = prior + shown;
        if all <= 0.0 {
            return expected_ns;
        }
        let variance = (prior * expected + shown * self.splits.excess()) / all;
        (variance.max(0.0) + SCATTER_DOUBT * (1.0 / all).sqrt()).max(self.agreed()).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::share_is_in;
    use crate::seed::rng;
    use rand::RngExt;
    use rand_distr::StandardNormal;

    /// Instruments that begin by chance with small values must not believe them for ever.
    #[test]
    fn every_instrument_finds_the_scatter_to_what_its_sample_tells() {
        let (true_ns, steady) = (1900.0, 100.0);
        let found = |seed: u64| {
            let (mut rng, mut scatter) = (rng(seed), SwitchScatter::default());
            for _ in 0..64 {
                scatter.add(true_ns * rng.sample::<f64, _>(StandardNormal), steady, 6700.0);
            }
            scatter.u_ns(6700.0)
        };
        let mut found: Vec<f64> = (0..400).map(found).collect();
        found.sort_unstable_by(f64::total_cmp);
        // 64 values tell a sigma to 9 %.
        let [low, middle, high] = [20, 200, 379].map(|index: usize| found[index] / true_ns);
        assert!(low > 0.8 && (0.95..1.15).contains(&middle) && high < 1.35, "{low} {middle} {high}");
    }

    /// Where split discharges say little, readings at rest keep them from saying too little, and readings of a moving hand nothing.
    #[test]
    fn readings_at_rest_are_no_steadier_than_their_switches() {
        let (true_ns, noise_ns, expected_ns) = (280.0, 500.0, 1550.0);
        let found = |seed: u64, readings_ns: f64| {
            let (mut rng, mut scatter) = (rng(seed), SwitchScatter::default());
            let mut normal = |sigma: f64| sigma * rng.sample::<f64, _>(StandardNormal);
            for _ in 0..64 {
                scatter.add(normal(f64::hypot(true_ns, noise_ns)), noise_ns * noise_ns, expected_ns);
                scatter.add_reading(normal(f64::hypot(readings_ns, 50.0)), 2500.0);
            }
            scatter.u_ns(expected_ns) / true_ns
        };
        for (readings_ns, most) in [(true_ns, 1.5), (20_000.0, 2.5)] {
            let found: Vec<f64> = (0..400).map(|seed| found(seed, readings_ns)).collect();
            let low = found.iter().filter(|u| **u <= 0.75).count();
            let high = found.iter().filter(|u| **u >= most).count();
            let is_rare = |count, share| share_is_in(count, found.len(), 0.0..=share);
            assert!(
                is_rare(low, 0.02) && is_rare(high, 0.05),
                "readings by {readings_ns} ns: {low} low, {high} high"
            );
        }
    }
}
