//! What the instrument runs with: every default filled in and every file read.

use crate::circuit::Node;
use crate::estimate::force::Force;
use crate::pins::Drives;
use crate::reading::Method;
use crate::record::Through;
use crate::units::Nanos;
use std::str::FromStr;

/// One sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Its name.
    pub id: String,
    /// What a short circuit in its place reads, ohm.
    pub zero_ohm: f64,
    /// Its characteristic, if it is to give forces.
    pub force: Option<Force>,
}

/// Where the latency offset comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OffsetSource {
    /// Split calibration.
    Auto,
    /// Given, ns.
    Given(f64),
}

impl FromStr for OffsetSource {
    type Err = String;
    /// As people write it: `auto`, or a duration such as `8 us`.
    fn from_str(text: &str) -> Result<OffsetSource, String> {
        if text == "auto" {
            return Ok(OffsetSource::Auto);
        }
        let d: Nanos = text.parse().map_err(|error| format!("{error}; or \"auto\""))?;
        Ok(OffsetSource::Given(d.as_ns()))
    }
}

/// Everything that the measuring thread needs to know.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The method.
    pub method: Method,
    /// R_1 and R_2 of the [ratio](crate::estimate::method), ohm.
    pub r_ohm: [f64; 2],
    /// The circuit has Rc1 and Rc2 in series.
    pub series: bool,
    /// The chargers there are.
    pub chargers: Drives,
    /// When node A should cross in a discharge through R_1, by nominal values, for diagnosis alone.
    pub nominal: Nanos,
    /// The node whose crossing ends a discharge.
    pub last: Node,
    /// Length of what goes before the charge after a discharge that ended before its time.
    pub drain: Nanos,
    /// Length of a charge.
    pub charge: Nanos,
    /// Pause between charge and discharge.
    pub settle: Nanos,
    /// The longest discharge through a sensor.
    pub deadline: Nanos,
    /// From the start of one cycle to the next; `None`: at once.
    pub period: Option<Nanos>,
    /// The latency offset, where the calibration is not tracked.
    pub offset: OffsetSource,
    /// Period of the clock that stamps crossings.
    pub resolution: Nanos,
    /// The calibration is followed over many readings instead of taken anew for each.
    pub tracked: bool,
    /// T_L of eq. (19); `None`: where the predicted uncertainties cross.
    pub t_l: Option<Nanos>,
    /// The planned switch comes at this fraction of the predicted T_xA.
    pub switch_fraction: f64,
    /// The sensors.
    pub channels: Vec<Channel>,
}

impl Settings {
    /// How many nodes the method times.
    pub fn nodes(&self) -> usize {
        match self.last {
            Node::A => 1,
            Node::B => 2,
        }
    }

    /// The discharge of R_2.
    pub fn second(&self) -> Through {
        if self.series { Through::C12 } else { Through::C2 }
    }

    /// What the discharge of a sensor starts through.
    pub fn sensor(&self, channel: usize) -> Through {
        match self.method {
            Method::Qerm => Through::XWithC12(channel),
            Method::Tpcm | Method::Tcdic | Method::Cerm | Method::Tracked => Through::X(channel),
        }
    }
}
