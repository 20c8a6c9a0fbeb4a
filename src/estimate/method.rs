//! What each method decides, one file each: its circuits, its equation, how its discharges are planned.
//!
//! A sixth method is a file with its [`Rules`], a name in [`Method`] and a line in [`Method::rules`]; whoever needs an
//! answer of a method asks here.
//!
//! Every method answers the same quantity, the **ratio**
//!
//! ```text
//! rho = (R_x - R_1) / (R_2 - R_1)
//! ```
//!
//! with R_1 the lower and R_2 the higher calibration resistor (Rc1 and Rc2, or Rc1 and Rc1 + Rc2 in the circuit
//! with series calibration). From rho follow the resistance, affine, and the force of eq. (27), whose reciprocal is
//! affine too. The equations are generic over [`Number`], so that the same text is evaluated for values (`f64`) and
//! for values with all their partial derivatives ([`Dual`]), by which uncertainties propagate.
//!
//! The offset d is subtracted from crossings, never from switches, as the text of each method says; where it cancels,
//! it is written all the same.

pub mod cerm;
pub mod dual;
pub mod qerm;
pub mod tcdic;
pub mod tpcm;
pub mod tracked;

use crate::circuit::{Kind, Node};
use crate::estimate::motion::Evidence;
use crate::reading::{Branch, Method};
use crate::record::Through;
use dual::Dual;
use std::ops::{Add, Div, Mul, Sub};

/// All that a method decides.
pub struct Rules {
    /// The capital that stands for it in a chart of letters.
    pub letter: char,
    /// The circuits that it works on.
    pub circuits: &'static [Kind],
    /// Whether it looks at node A alone, whatever the circuit has.
    pub only_a: bool,
    /// How its x discharges are switched.
    pub switching: Switching,
    /// Whether R_2 sinks beside the sensor from the start of an x discharge on.
    pub sinks_beside: bool,
    /// Whether the time limit T_L of eq. (19) is one of its settings.
    pub has_time_limit: bool,
    /// Its equation; `None` if a time that it needs was not seen.
    pub ratio: fn(&Times<Dual>, Branch) -> Option<Dual>,
    /// Which stretches of the x discharge that rests on, and whether they agree; `None` as for the ratio.
    pub evidence: fn(&Times<Dual>, Branch, &Scale<'_>) -> Option<Evidence>,
    /// Of the crossing that ended an x discharge and of that through R_2, ns, and the variance of either: if the x discharge
    /// may have ended there without a sensor, too, the crossing before which it would certainly not.
    pub certain_ns: fn(f64, f64, f64) -> Option<f64>,
}

impl Rules {
    /// Those of most methods: full discharges through the sensor alone, to the last node of the circuit.
    const fn usual(letter: char) -> Rules {
        Rules {
            letter,
            circuits: &[Kind::TwoCapacitor],
            only_a: false,
            switching: Switching::Never,
            sinks_beside: false,
            has_time_limit: false,
            ratio: |times, _| tcdic::ratio(times),
            evidence: |times, _, scale| tcdic::evidence(times, scale),
            certain_ns: |_, _, _| None,
        }
    }

    /// The node whose crossing ends its discharges.
    pub fn last(&self, kind: Kind) -> Node {
        if self.only_a { Node::A } else { kind.last() }
    }

    /// What its x discharges start through.
    pub fn sensor(&self, channel: usize) -> Through {
        if self.sinks_beside { Through::XWithC12(channel) } else { Through::X(channel) }
    }
}

/// How the x discharges of a method are switched to R_2, once all is known that a switched one needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Switching {
    /// Never.
    Never,
    /// At a set fraction of the time in which node A would cross, where that promises less variance. Such a discharge tells
    /// nothing without the latency offset.
    AtFraction,
    /// At the instant that promises the least variance by a tracked state, or never. An x discharge that has not ended by its
    /// deadline is finished through R_1.
    WhereBest,
}

impl Method {
    /// All that it decides.
    pub fn rules(self) -> &'static Rules {
        match self {
            Method::Tpcm => &tpcm::RULES,
            Method::Qerm => &qerm::RULES,
            Method::Tcdic => &tcdic::RULES,
            Method::Cerm => &cerm::RULES,
            Method::Tracked => &tracked::RULES,
        }
    }

    /// The best method that a circuit allows.
    pub fn best(kind: Kind) -> Method {
        match kind {
            Kind::TwoCapacitor | Kind::OneCapacitor => Method::Tracked,
            Kind::SeriesCalibration => Method::Qerm,
        }
    }

    /// Those that work on a circuit.
    pub fn on(kind: Kind) -> impl Iterator<Item = Method> {
        Method::ALL.into_iter().filter(move |method| method.rules().circuits.contains(&kind))
    }

    /// Whether the calibration of any method can be tracked on a circuit.
    pub fn can_be_tracked(kind: Kind) -> bool {
        tracked::RULES.circuits.contains(&kind)
    }

    /// Whether its calibration is always tracked.
    pub fn is_tracked(self) -> bool {
        self.rules().switching == Switching::WhereBest
    }

    /// Whether its equation contains the latency offset.
    pub fn needs_offset(self) -> bool {
        self.rules().switching == Switching::AtFraction
    }
}

/// What the equations calculate with.
pub trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
}

impl Number for f64 {}

/// The times of one estimate, all in one unit (here ns): crossings `[A, B]` as measured, d included; `None` for a node that
/// the circuit has not, or that was not seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Times<T> {
    /// Crossings of the discharge through R_1.
    pub c1: [Option<T>; 2],
    /// Crossings of the discharge through R_2.
    pub c2: [Option<T>; 2],
    /// Crossings of the discharge through the sensor.
    pub x: [Option<T>; 2],
    /// The switch from the sensor to R_2.
    pub switch: Option<Switched<T>>,
    /// When R_2 was sunk beside the sensor; `None`: with it, or not at all.
    pub beside: Option<T>,
    /// The latency offset d of crossings.
    pub d: T,
}

/// The switch of an x discharge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Switched<T> {
    /// When the sensor was released.
    pub at: T,
    /// When R_2 was sunk.
    pub on: T,
}

impl<T: Copy> Times<T> {
    /// The crossings of one node through R_1, R_2 and the sensor.
    pub fn of(&self, node: Node) -> Option<[T; 3]> {
        let index = node.index();
        Some([self.c1[index]?, self.c2[index]?, self.x[index]?])
    }
}

impl<T: Number> Times<T> {
    /// The crossing of a node through the sensor, d subtracted.
    fn x_end(&self, node: Node) -> Option<T> {
        self.x[node.index()].map(|crossing| crossing - self.d)
    }
}

/// What turns ratios into ohms, and says how well what follows from the times is known.
pub struct Scale<'a> {
    /// R_1 and R_2, ohm.
    pub r_ohm: [f64; 2],
    /// 1 sigma of what follows from the times; `None` while the noise is not known.
    pub u: &'a dyn Fn(&Dual) -> Option<f64>,
}

impl Scale<'_> {
    /// An estimate that has `weights` on two stretches, which alone would say `ratios`.
    pub fn over_two(&self, end_ns: [f64; 2], weights: [f64; 2], ratios: [Dual; 2]) -> Evidence {
        let [r1, r2] = self.r_ohm;
        let u_ohm = (self.u)(&(ratios[1] - ratios[0])).map(|u| (r2 - r1) * u);
        Evidence::over_two(end_ns, weights, ratios.map(|ratio| r1 + (r2 - r1) * ratio.value), u_ohm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_methods_share_a_letter() {
        let mut letters = Method::ALL.map(|method| method.rules().letter).to_vec();
        letters.sort_unstable();
        letters.dedup();
        assert_eq!(letters.len(), Method::ALL.len());
    }
}
