//! From what readings have to be good for to circuits that should do it: parts on sale or in a drawer, put together in every
//! sensible way and ranked by closed forms.
//!
//! For: the need, the candidates, what each costs and carries. Must not know: how a circuit is measured or rehearsed, command
//! lines, how anything is shown. What it predicts serves to rank; the figures that a person sees come from a rehearsal of the
//! best few.

mod design;
pub mod limits;
mod model;
mod parts;
mod search;
mod typed;

pub use design::{Design, Pace};
pub use model::{Platform, Shares};
pub use parts::{Price, Stock};
pub use search::{Ranked, Search};
pub use typed::{Wanted, newtons, ohms, pin_current, rate};

use crate::units::rounded;

/// What is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Need {
    /// The sensor's least and greatest resistance, ohm.
    pub r_ohm: [f64; 2],
    /// How far off a reading may be, 1 sigma; `None`: as little as possible.
    pub tolerance: Option<Tolerance>,
    /// Readings per second at the least; `None`: as many as possible.
    pub rate_hz: Option<f64>,
}

/// How far off a reading may be, 1 sigma.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tolerance {
    /// Of the reading, a share.
    Share(f64),
    /// Ohm.
    Ohm(f64),
    /// Newton, of a sensor with F = alpha / R.
    Newton {
        /// Newton.
        f_n: f64,
        /// N ohm.
        alpha_n_ohm: f64,
    },
}

impl Tolerance {
    /// At a resistance, ohm.
    pub fn ohm_at(self, r_ohm: f64) -> f64 {
        match self {
            Tolerance::Share(share) => share * r_ohm,
            Tolerance::Ohm(ohm) => ohm,
            Tolerance::Newton { f_n, alpha_n_ohm } => f_n * r_ohm * r_ohm / alpha_n_ohm,
        }
    }
}

impl Need {
    /// `count` resistances from the least to the greatest, about equally far apart as ratios, ohm: those between have two
    /// digits. One where all are the same.
    pub fn resistances(&self, count: usize) -> Vec<f64> {
        let [least, greatest] = self.r_ohm;
        let count = if least < greatest { count } else { 1 };
        let step = (greatest / least).powf(1.0 / (count.max(2) - 1) as f64);
        let between = |index: usize| match rounded(least * step.powi(index as i32), 2) {
            r_ohm if index > 0 && index + 1 < count => r_ohm.clamp(least, greatest),
            _ if index == 0 => least,
            _ => greatest,
        };
        (0..count).map(between).collect()
    }

    /// What a reading may be off by, ohm; a share of it where nothing is asked for, so that circuits can be compared.
    pub fn ohm_at(&self, r_ohm: f64) -> f64 {
        self.tolerance.unwrap_or(Tolerance::Share(1.0)).ohm_at(r_ohm)
    }
}
