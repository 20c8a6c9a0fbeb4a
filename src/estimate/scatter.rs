//! Middle and spread of measured values.

use crate::estimate::limits::SCATTER_OF;
use crate::reading::Measured;

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

/// How much the instants of switches scatter: what the crossings of split discharges scatter beyond their own noise. Its
/// bound holds however few discharges have told it.
#[derive(Debug, Clone, Copy, Default)]
pub struct SwitchScatter {
    count: f64,
    excess: f64,
    steady: f64,
}

impl SwitchScatter {
    /// Takes the deviation of a crossing from what was expected, ns, the variance it would have without a scatter of the
    /// switch, ns², and by how much the switch moves it.
    pub fn add(&mut self, away_ns: f64, steady: f64, by_switch: f64) {
        self.count = (self.count + 1.0).min(SCATTER_OF[1]);
        self.excess += ((away_ns * away_ns - steady) / (by_switch * by_switch) - self.excess) / self.count;
        self.steady += (steady / (by_switch * by_switch) - self.steady) / self.count;
    }

    /// What the scatter is at the most (1 sigma more than found); `None` before there have been a few.
    pub fn bound_ns(&self) -> Option<f64> {
        let doubt = self.steady * (2.0 / self.count).sqrt();
        (self.count >= SCATTER_OF[0]).then(|| (self.excess.max(0.0) + doubt).sqrt())
    }
}
