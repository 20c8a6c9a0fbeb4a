//! Middle and spread of measured values.

use crate::estimate::limits::{READINGS_OF_SCATTER, SCATTER_DOUBT, SCATTER_MEMORY, UNKNOWN_SWITCH_NS};
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

/// How much the time from a start to a switch scatters: what split discharges show of it, against what is to be expected of
/// calls of that length.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SwitchScatter {
    /// Of variances, ns^-4, and the sum of what each has told with its weight, ns^-2.
    weight: f64,
    excess: f64,
    /// By how much successive readings of a sensor differ, as times of their switches: mean square, what of it is not the
    /// switches', ns², and of how many.
    readings: [f64; 3],
}

impl SwitchScatter {
    /// Takes by how much a split discharge seems to have been switched late, ns, and the variance that this would have if
    /// switches did not scatter, ns².
    pub fn add(&mut self, late_ns: f64, steady: f64) {
        let spread = self.likely().max(0.0) + steady;
        let weight = 1.0 / (2.0 * spread * spread);
        let keep = 1.0 - 1.0 / SCATTER_MEMORY;
        self.excess = keep * self.excess + weight * (late_ns * late_ns - steady);
        self.weight = keep * self.weight + weight;
    }

    /// Takes by how much a reading of a sensor is beside those before and after it, as a time of their switches, ns: at rest
    /// by no less than these scatter. `steady`: the variance if they did not, ns².
    pub fn add_reading(&mut self, beside_ns: f64, steady: f64) {
        let [mean, rest, count] = &mut self.readings;
        *count = (*count + 1.0).min(READINGS_OF_SCATTER[1]);
        *mean += (beside_ns * beside_ns - *mean) / *count;
        *rest += (steady - *rest) / *count;
    }

    /// No steadier than this are switches if the sensor is at rest, and steadier if it is not, ns².
    fn bound(&self) -> f64 {
        let [mean, rest, count] = self.readings;
        if count < READINGS_OF_SCATTER[0] {
            return f64::INFINITY;
        }
        (mean - rest).max(0.0) + mean.max(rest) * (2.0 / count).sqrt()
    }

    /// What the discharges alone say, ns²; may be negative by chance.
    fn likely(&self) -> f64 {
        if self.weight > 0.0 { self.excess / self.weight } else { 0.0 }
    }

    /// 1 sigma, ns, and as much more as is not known of it; `expected_ns`: by the length of calls, which may be wrong by as
    /// much as it is, or as the discharges say, but is not less steady than readings are.
    pub fn u_ns(&self, expected_ns: f64) -> f64 {
        let expected = (expected_ns * expected_ns).min(self.bound());
        let doubt = expected.max(self.likely());
        let weight = if doubt > 0.0 { 1.0 / (doubt * doubt) } else { 0.0 };
        let all = weight + self.weight;
        if all <= 0.0 {
            return expected_ns;
        }
        let variance = (weight * expected + self.excess) / all;
        (variance.max(0.0) + SCATTER_DOUBT * (1.0 / all).sqrt()).sqrt()
    }
}
