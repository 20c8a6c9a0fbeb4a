//! Forces in the units that people weigh by.

use super::named;

/// Standard gravity, m/s^2: what a mass weighs (CGPM 1901).
pub const GRAVITY: f64 = 9.80665;
/// A pound-force, newton (NIST SP 811, B.8).
pub const POUND_FORCE_N: f64 = 4.448_221_615_260_5;

named! {
    /// What forces are shown in. A mass stands for its weight under standard gravity.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    ForceUnit {
        /// Newton.
        #[default]
        Newton = "N",
        /// Gram.
        Gram = "g",
        /// Kilogram.
        Kilogram = "kg",
        /// Pound-force.
        Pound = "lbf",
    }
}

impl ForceUnit {
    /// Of one of it, newton.
    pub fn newton(self) -> f64 {
        match self {
            ForceUnit::Newton => 1.0,
            ForceUnit::Gram => 1e-3 * GRAVITY,
            ForceUnit::Kilogram => GRAVITY,
            ForceUnit::Pound => POUND_FORCE_N,
        }
    }
}
