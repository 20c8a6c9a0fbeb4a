//! A number that carries its partial derivatives (forward-mode differentiation).
//!
//! For: exact gradients of the equations without writing them a second time. Must not know: the equations.

use super::{Number, Times};
use std::ops::{Add, Div, Mul, Sub};

/// A value and its partial derivatives by each of the nine [`Times`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual {
    /// The value.
    pub value: f64,
    /// Partial derivatives, in the order of [`Times::to_array`].
    pub by: [f64; 9],
}

impl Number for Dual {}

/// The times as independent variables.
pub fn variables(times: &Times<f64>) -> Times<Dual> {
    let values = times.to_array();
    let mut duals = values.map(|value| Dual { value, by: [0.0; 9] });
    for (index, dual) in duals.iter_mut().enumerate() {
        dual.by[index] = 1.0;
    }
    Times::from_array(duals)
}

impl Dual {
    fn combine(value: f64, p: f64, a: &Dual, q: f64, b: &Dual) -> Dual {
        let mut by = [0.0; 9];
        for (index, slot) in by.iter_mut().enumerate() {
            *slot = p * a.by[index] + q * b.by[index];
        }
        Dual { value, by }
    }
}

impl Add for Dual {
    type Output = Dual;
    fn add(self, other: Dual) -> Dual {
        Dual::combine(self.value + other.value, 1.0, &self, 1.0, &other)
    }
}

impl Sub for Dual {
    type Output = Dual;
    fn sub(self, other: Dual) -> Dual {
        Dual::combine(self.value - other.value, 1.0, &self, -1.0, &other)
    }
}

impl Mul for Dual {
    type Output = Dual;
    fn mul(self, other: Dual) -> Dual {
        Dual::combine(self.value * other.value, other.value, &self, self.value, &other)
    }
}

impl Div for Dual {
    type Output = Dual;
    fn div(self, other: Dual) -> Dual {
        let value = self.value / other.value;
        Dual::combine(value, 1.0 / other.value, &self, -value / other.value, &other)
    }
}
