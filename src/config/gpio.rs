//! `[gpio]`: which lines the circuit is wired to.

use crate::units::named;
use serde::{Deserialize, Serialize};

named! {
    /// What switches and senses the lines.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    Backend {
        /// The character device, uAPI v2: Linux 5.10 and later.
        Chardev = "chardev",
        /// The character device, uAPI v1: for kernels before 5.10. Needs chargers of their own.
        ChardevV1 = "chardev-v1",
        /// The simulated circuit of `[mock]`.
        #[default]
        Mock = "mock",
    }
}

/// `[gpio]`. Lines may stay out with the simulated circuit.
#[derive(Debug, Clone, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Gpio {
    /// Required where `[gpio]` is there; without `[gpio]`: `mock`.
    pub backend: Backend,
    /// The chip by label, name or path. Required for hardware.
    pub chip: Option<String>,
    /// The input at node A. Required for hardware.
    pub sense_a: Option<LineName>,
    /// The input at node B. Required for hardware with two capacitors.
    pub sense_b: Option<LineName>,
    /// The output that charges node A. Default: the sense line charges too (the wiring of the paper).
    pub charge_a: Option<LineName>,
    /// The output that charges node B. Default: as `charge-a`; either both or none.
    pub charge_b: Option<LineName>,
    /// The output that sinks Rc1. Required for hardware.
    pub sink_c1: Option<LineName>,
    /// The output that sinks Rc2, or the far end of Rc1 + Rc2. Required for hardware.
    pub sink_c2: Option<LineName>,
}

/// A line of the chip: its name as `gpioinfo` shows it, `GPIO17`, or the digits of its offset.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Deserialize)]
#[serde(try_from = "Written")]
pub struct LineName(pub String);

#[derive(Deserialize)]
#[serde(untagged, expecting = "expected a line's name such as \"GPIO17\", or its offset such as 17")]
enum Written {
    Offset(u32),
    Text(String),
}

impl TryFrom<Written> for LineName {
    type Error = &'static str;

    fn try_from(written: Written) -> Result<LineName, &'static str> {
        match written {
            Written::Offset(offset) => Ok(LineName(offset.to_string())),
            Written::Text(text) if text.trim().is_empty() => {
                Err("expected a line's name such as \"GPIO17\", or its offset such as 17")
            }
            Written::Text(text) => {
                Ok(LineName(text.parse::<u32>().map_or(text, |offset| offset.to_string())))
            }
        }
    }
}
