//! The scatter of switches.
//!
//! For: a bound that holds however few discharges have told it. Must not know: the filter.

/// How much the instants of switches scatter: what the crossings of split discharges scatter beyond their own noise.
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
        self.count = (self.count + 1.0).min(4096.0);
        self.excess += ((away_ns * away_ns - steady) / (by_switch * by_switch) - self.excess) / self.count;
        self.steady += (steady / (by_switch * by_switch) - self.steady) / self.count;
    }

    /// What the scatter is at the most (1 sigma more than found); `None` before there have been a few.
    pub fn bound_ns(&self) -> Option<f64> {
        let doubt = self.steady * (2.0 / self.count).sqrt();
        (self.count >= 8.0).then(|| (self.excess.max(0.0) + doubt).sqrt())
    }
}
