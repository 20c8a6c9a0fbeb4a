//! The equations: times of three discharges in, position of R_x between the calibration resistors out.
//!
//! For: TPCM, QERM, TCDIC and CERM as pure functions. Must not know: ohms, noise, clocks or records.
//!
//! Every method answers the same quantity, the **ratio**
//!
//! ```text
//! rho = (R_x - R_1) / (R_2 - R_1)
//! ```
//!
//! with R_1 the lower and R_2 the higher calibration resistor (Rc1 and Rc2, or Rc1 and Rc1 + Rc2 in the circuit
//! with series calibration). From rho follow the resistance, affine, and the force of eq. (27), whose reciprocal is
//! affine too. The functions are generic over [`Number`], so that the same text is evaluated for values (`f64`) and
//! for values with all their partial derivatives ([`Dual`](dual::Dual)), by which uncertainties propagate.
//!
//! The offset d is subtracted from crossings, never from switches, as the text of each method says; where it cancels,
//! it is written all the same.

pub mod cerm;
pub mod dual;
pub mod qerm;
pub mod tcdic;
pub mod tpcm;
pub mod tracked;

use std::ops::{Add, Div, Mul, Sub};

/// What the equations calculate with.
pub trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
}

impl Number for f64 {}

/// The times of one estimate, all in one unit (here ns): crossings `[A, B]` as measured, d included.
///
/// Times that a method does not use, or that were not seen, may hold anything finite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Times<T> {
    /// Crossings of the discharge through R_1.
    pub c1: [T; 2],
    /// Crossings of the discharge through R_2.
    pub c2: [T; 2],
    /// Crossings of the discharge through the sensor.
    pub x: [T; 2],
    /// When the sensor was released.
    pub at: T,
    /// When R_2 was sunk instead (for QERM: beside the sensor).
    pub on: T,
    /// The latency offset d of crossings.
    pub d: T,
}

impl<T: Copy> Times<T> {
    /// How many times there are.
    pub const COUNT: usize = 9;

    /// In the order c1A, c1B, c2A, c2B, xA, xB, at, on, d.
    pub fn to_array(self) -> [T; 9] {
        let Times { c1, c2, x, at, on, d } = self;
        [c1[0], c1[1], c2[0], c2[1], x[0], x[1], at, on, d]
    }

    /// The reverse of [`Times::to_array`].
    pub fn from_array(times: [T; 9]) -> Times<T> {
        let [c1a, c1b, c2a, c2b, xa, xb, at, on, d] = times;
        Times { c1: [c1a, c1b], c2: [c2a, c2b], x: [xa, xb], at, on, d }
    }
}
