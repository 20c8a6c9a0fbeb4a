//! A number that carries its partial derivatives: exact gradients of the equations without writing them a second time
//! (forward-mode differentiation).

use super::{Number, Switched, Times};
use std::ops::{Add, Div, Mul, Sub};

/// Partial derivatives by each of the [`Times`]. When R_2 comes in hardly matters beside when the sensor goes, and has none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Gradient {
    /// By the crossings of A and B through R_1.
    pub c1: [f64; 2],
    /// By those through R_2.
    pub c2: [f64; 2],
    /// By those through the sensor.
    pub x: [f64; 2],
    /// By the instant at which the sensor is released.
    pub switch: f64,
    /// By the latency offset d.
    pub offset: f64,
}

impl Gradient {
    /// p a + q b.
    fn combined(p: f64, a: &Gradient, q: f64, b: &Gradient) -> Gradient {
        let pair = |a: [f64; 2], b: [f64; 2]| [p * a[0] + q * b[0], p * a[1] + q * b[1]];
        Gradient {
            c1: pair(a.c1, b.c1),
            c2: pair(a.c2, b.c2),
            x: pair(a.x, b.x),
            switch: p * a.switch + q * b.switch,
            offset: p * a.offset + q * b.offset,
        }
    }
}

/// A value and its partial derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual {
    /// The value.
    pub value: f64,
    /// Partial derivatives.
    pub by: Gradient,
}

impl Number for Dual {}

/// The times as independent variables.
pub fn variables(times: &Times<f64>) -> Times<Dual> {
    let variable = |value: f64, by: Gradient| Dual { value, by };
    let pair = |values: [Option<f64>; 2], by: fn([f64; 2]) -> Gradient| {
        let [a, b] = values;
        [a.map(|a| variable(a, by([1.0, 0.0]))), b.map(|b| variable(b, by([0.0, 1.0])))]
    };
    let none = Gradient::default();
    Times {
        c1: pair(times.c1, |c1| Gradient { c1, ..Gradient::default() }),
        c2: pair(times.c2, |c2| Gradient { c2, ..Gradient::default() }),
        x: pair(times.x, |x| Gradient { x, ..Gradient::default() }),
        switch: times.switch.map(|Switched { at, on }| Switched {
            at: variable(at, Gradient { switch: 1.0, ..none }),
            on: variable(on, none),
        }),
        beside: times.beside.map(|beside| variable(beside, none)),
        d: variable(times.d, Gradient { offset: 1.0, ..none }),
    }
}

impl Dual {
    fn combined(value: f64, p: f64, a: &Dual, q: f64, b: &Dual) -> Dual {
        Dual { value, by: Gradient::combined(p, &a.by, q, &b.by) }
    }
}

impl Add for Dual {
    type Output = Dual;
    fn add(self, other: Dual) -> Dual {
        Dual::combined(self.value + other.value, 1.0, &self, 1.0, &other)
    }
}

impl Sub for Dual {
    type Output = Dual;
    fn sub(self, other: Dual) -> Dual {
        Dual::combined(self.value - other.value, 1.0, &self, -1.0, &other)
    }
}

impl Mul for Dual {
    type Output = Dual;
    fn mul(self, other: Dual) -> Dual {
        Dual::combined(self.value * other.value, other.value, &self, self.value, &other)
    }
}

impl Div for Dual {
    type Output = Dual;
    fn div(self, other: Dual) -> Dual {
        let value = self.value / other.value;
        Dual::combined(value, 1.0 / other.value, &self, -value / other.value, &other)
    }
}
