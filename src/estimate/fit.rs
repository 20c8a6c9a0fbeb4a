//! Fitting the characteristic of a force sensor to measured pairs of force and resistance, with 1-sigma uncertainties.
//!
//! The force is taken as exact, the scatter as that of the resistance.

use crate::estimate::limits::{BLOCKS_OF_A_MEAN, NO_RESIDUAL};
use crate::estimate::scatter;
use crate::reading::Measured;
use crate::sensor::table::PairsError;
use crate::sensor::{Force, Law, Table};
use crate::units::sample::{self, rms};

/// A force and the resistance under it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weighing {
    /// Newton, positive and finite.
    pub f_n: f64,
    /// Ohm, positive and finite.
    pub r_ohm: f64,
}

/// A fitted characteristic.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// What was fitted.
    pub law: Law,
    /// 1 sigma of its numbers, in their order; `None` where there are too few pairs, or nothing was fitted.
    pub u: [Option<f64>; 2],
}

/// Why pairs cannot be fitted.
#[derive(Debug, thiserror::Error)]
pub enum FitError {
    /// Not enough of them.
    #[error("{found} pair(s) of force and resistance: it takes at least {needed}")]
    Few {
        /// How many there are.
        found: usize,
        /// How many it takes.
        needed: usize,
    },
    /// One force only tells no exponent.
    #[error("all pairs have the same force: a power law takes at least two forces")]
    OneForce,
    /// More force gives more resistance.
    #[error("the resistance does not fall while the force rises: are the columns swapped? force comes first")]
    Rising,
    /// No table.
    #[error(transparent)]
    Table(#[from] PairsError),
}

/// The least squares of R = alpha / F: minimises the sum of (R - alpha/F)^2.
///
/// # Errors
/// [`FitError::Few`] without a pair.
pub fn alpha(pairs: &[Weighing]) -> Result<Fit, FitError> {
    enough(pairs, 1)?;
    let squares: f64 = pairs.iter().map(|pair| pair.f_n.powi(-2)).sum();
    let alpha = pairs.iter().map(|pair| pair.r_ohm / pair.f_n).sum::<f64>() / squares;
    let rest: f64 = pairs.iter().map(|pair| (pair.r_ohm - alpha / pair.f_n).powi(2)).sum();
    let u = (pairs.len() > 1).then(|| (rest / (pairs.len() - 1) as f64 / squares).sqrt());
    Ok(Fit { law: Law::Alpha { alpha_n_ohm: alpha }, u: [u, None] })
}

/// The least squares of ln R = a - b ln F, with the exponent 1/b.
///
/// # Errors
/// [`FitError::Few`], [`FitError::OneForce`], [`FitError::Rising`].
pub fn power(pairs: &[Weighing]) -> Result<Fit, FitError> {
    enough(pairs, 2)?;
    let n = pairs.len() as f64;
    // ln (R / 1 kohm) against ln F, both from their means.
    let logs = || pairs.iter().map(|pair| (pair.f_n.ln(), (pair.r_ohm / 1000.0).ln()));
    let (mean_x, mean_y) = logs().fold((0.0, 0.0), |sum, (x, y)| (sum.0 + x / n, sum.1 + y / n));
    let s_xx: f64 = logs().map(|(x, _)| (x - mean_x).powi(2)).sum();
    // What rounding leaves of one and the same force.
    if s_xx <= n * 1e-24 {
        return Err(FitError::OneForce);
    }
    let b = -logs().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum::<f64>() / s_xx;
    if b.is_nan() || b <= 0.0 {
        return Err(FitError::Rising);
    }
    let rest: f64 = logs().map(|(x, y)| (y - mean_y + b * (x - mean_x)).powi(2)).sum();
    // ln F_1k is the x at which y is 0; mean_y and b are independent.
    let ln_f = mean_x + mean_y / b;
    let u = |by_mean: f64, by_b: f64| {
        let variance = rest / (n - 2.0);
        (n > 2.0).then(|| (variance * (by_mean * by_mean / n + by_b * by_b / s_xx)).sqrt())
    };
    let at_1_kohm_n = ln_f.exp();
    let u_n = u(1.0 / b, mean_y / (b * b)).map(|relative| relative * at_1_kohm_n);
    Ok(Fit { law: Law::Power { at_1_kohm_n, exponent: 1.0 / b }, u: [u_n, u(0.0, 1.0 / (b * b))] })
}

/// The pairs as a table.
///
/// # Errors
/// [`FitError::Table`] when there are fewer than two, or force and resistance do not run against each other.
pub fn table(pairs: &[Weighing]) -> Result<Fit, FitError> {
    let pairs: Vec<_> = pairs.iter().map(|pair| (pair.r_ohm, pair.f_n)).collect();
    Ok(Fit { law: Law::Table { table: Table::try_from(pairs)? }, u: [None; 2] })
}

fn enough(pairs: &[Weighing], needed: usize) -> Result<(), FitError> {
    if pairs.len() < needed { Err(FitError::Few { found: pairs.len(), needed }) } else { Ok(()) }
}

impl Fit {
    /// The resistance that the fit gives at a force, ohm; `None` for a table, which goes through its pairs.
    pub fn r_ohm(&self, f_n: f64) -> Option<f64> {
        match self.law {
            Law::Alpha { alpha_n_ohm } => Some(alpha_n_ohm / f_n),
            Law::Power { at_1_kohm_n, exponent } => Some(1000.0 * (f_n / at_1_kohm_n).powf(-1.0 / exponent)),
            Law::Calibrated { .. } | Law::Table { .. } => None,
        }
    }

    /// By what share of the fitted resistance a pair is off.
    pub fn residual(&self, pair: Weighing) -> f64 {
        self.r_ohm(pair.f_n).map_or(0.0, |fitted_ohm| pair.r_ohm / fitted_ohm - 1.0)
    }

    /// The characteristic as it is to be used: as good as the pairs have shown it to be, and where they were.
    pub fn force(&self, pairs: &[Weighing]) -> Force {
        let law = self.law.clone();
        let forces = || pairs.iter().map(|pair| pair.f_n);
        let range_n = [forces().fold(f64::INFINITY, f64::min), forces().fold(0.0, f64::max)];
        let is_table = matches!(law, Law::Table { .. });
        let freedom = self.freedom(pairs) as f64;
        let u = self.relative_rms(pairs).map(|rms| rms * (pairs.len() as f64 / freedom).sqrt());
        Force {
            law,
            // A table goes through its pairs, and so does a law with as many parameters. Pairs that are all on it say no more.
            u: u.filter(|u| freedom > 0.0 && !is_table && *u > NO_RESIDUAL),
            range_n: Some(range_n).filter(|[least, greatest]| !is_table && least < greatest),
            tare_n: None,
        }
    }

    /// How many more pairs there are than numbers that were fitted.
    pub fn freedom(&self, pairs: &[Weighing]) -> usize {
        pairs.len().saturating_sub(if let Law::Power { .. } = self.law { 2 } else { 1 })
    }

    /// The root mean square of the [residuals](Fit::residual); `None` for no pairs.
    pub fn relative_rms(&self, pairs: &[Weighing]) -> Option<f64> {
        rms(pairs.iter().map(|&pair| self.residual(pair)))
    }
}

/// The mean of successive readings of a constant, with 1 sigma of the mean; `None` for no readings.
///
/// Readings that share a calibration are not independent. The means of blocks longer than that scatter by what is
/// shared, too, so the greater of both scatters counts.
pub fn mean(readings: &[f64]) -> Option<Measured> {
    let Measured { value, u } = scatter::mean(readings.iter().copied())?;
    let length = readings.len() / BLOCKS_OF_A_MEAN;
    if length < 2 {
        return Some(Measured { value, u });
    }
    let blocks = readings.chunks_exact(length).take(BLOCKS_OF_A_MEAN);
    let of_blocks = scatter::mean(blocks.filter_map(sample::mean)).and_then(|mean| mean.u);
    Some(Measured { value, u: u.zip(of_blocks).map(|(a, b)| a.max(b)) })
}

#[cfg(test)]
mod tests;
