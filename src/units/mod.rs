//! Quantities and instants: what every number of this crate is measured in.
//!
//! For: units in types and in text ("2.2 uF"). Must not know: what a quantity is used for.

mod force;
#[doc(hidden)]
pub mod markup;
mod number;
mod quantity;
#[doc(hidden)]
pub mod sample;

pub use force::{ForceUnit, GRAVITY};
pub use number::{measured, rough, rounded, rounded_down, rounded_up, to_places};
pub use quantity::{
    Ampere, Celsius, Degree, Farad, Hertz, Kelvin, Lux, Metre, Micros, Millis, Newton, NewtonOhm, Ohm,
    ParseQuantityError, Percent, Quantity, Seconds, Ticks, Volt,
};

use serde::Deserialize;
use std::fmt;
use std::ops::{Add, Sub};
use std::str::FromStr;

/// An instant on `CLOCK_MONOTONIC`, or the distance of two instants, in whole nanoseconds.
///
/// The kernel stamps edges in whole nanoseconds; fractions of a nanosecond exist only in the times of a
/// [`Record`](crate::record::Record), which are `f64` with the suffix `_ns`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Deserialize)]
#[serde(from = "Seconds")]
pub struct Nanos(pub i64);

impl Nanos {
    /// Zero.
    pub const ZERO: Nanos = Nanos(0);
    /// The farthest instant: "no time-out".
    pub const MAX: Nanos = Nanos(i64::MAX);

    /// From seconds, rounded to the nearest nanosecond; saturates.
    pub fn from_seconds(seconds: f64) -> Nanos {
        Nanos((seconds * 1e9).round() as i64)
    }

    /// In seconds.
    pub fn as_seconds(self) -> f64 {
        self.0 as f64 * 1e-9
    }

    /// In nanoseconds as a float, for the arithmetic of estimates.
    pub fn as_ns(self) -> f64 {
        self.0 as f64
    }
}

impl Add for Nanos {
    type Output = Nanos;
    fn add(self, other: Nanos) -> Nanos {
        Nanos(self.0.saturating_add(other.0))
    }
}

impl Sub for Nanos {
    type Output = Nanos;
    fn sub(self, other: Nanos) -> Nanos {
        Nanos(self.0.saturating_sub(other.0))
    }
}

/// From a duration in seconds, whatever it is of.
macro_rules! from_seconds {
    ($($Duration:ident),+) => {
        $(impl From<$Duration> for Nanos {
            fn from(duration: $Duration) -> Nanos {
                Nanos::from_seconds(duration.0)
            }
        })+
    };
}

from_seconds!(Seconds, Millis, Micros, Ticks);

impl From<Nanos> for Seconds {
    fn from(nanos: Nanos) -> Seconds {
        Seconds(nanos.as_seconds())
    }
}

impl FromStr for Nanos {
    type Err = ParseQuantityError;
    /// Reads a duration such as `3 ms`, rounded to the nearest nanosecond.
    fn from_str(text: &str) -> Result<Nanos, ParseQuantityError> {
        text.parse::<Seconds>().map(Nanos::from)
    }
}

impl fmt::Display for Nanos {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ns", self.0)
    }
}

/// An enum whose variants have names.
macro_rules! named {
    ($(#[$meta:meta])* $Enum:ident { $($(#[$doc:meta])* $Variant:ident = $name:literal,)+ }) => {
        $(#[$meta])*
        pub enum $Enum {
            $($(#[$doc])* $Variant,)+
        }

        impl $Enum {
            /// All of them.
            pub const ALL: [$Enum; [$($name),+].len()] = [$($Enum::$Variant),+];

            /// The name in configuration, stream and command line.
            pub fn as_str(self) -> &'static str {
                match self {
                    $($Enum::$Variant => $name,)+
                }
            }
        }

        impl ::std::fmt::Display for $Enum {
            fn fmt(&self, f: &mut ::std::fmt::Formatter<'_>) -> ::std::fmt::Result {
                f.write_str(self.as_str())
            }
        }
    };
}

pub(crate) use named;
