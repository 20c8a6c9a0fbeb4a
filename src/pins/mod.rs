//! The hardware behind one trait, [`Pins`]: character devices, the simulated circuit, and the rights to be in time.
//!
//! For: switching drive lines and reading stamped threshold crossings. Must not know: what a discharge, a
//! method or a resistor is.
//!
//! A circuit has one or two *sense* nodes (A, B), *chargers* that pull a node up to V_DD and *sinks* that pull
//! a resistor down to ground. A drive line is either driving or released (an input); there is no third state,
//! so the whole electrical state is one set, [`Drives`].
//!
//! | backend | for |
//! |---|---|
//! | [`chardev::Chardev`] | GPIO lines of Linux, from 5.10 on (uAPI v2) and before ([v1](chardev_v1)) |
//! | [`sim::SimPins`] | a simulated board, in virtual time or in step with the wall clock |
//!
//! # Example
//!
//! One discharge through Rc1 on a simulated board, timed from the middle of the call that began it:
//!
//! ```
//! use cermd::pins::sim::{Scene, SimPins};
//! use cermd::pins::{Drives, Pins};
//! use cermd::units::Nanos;
//!
//! fn crossing_of_a(pins: &mut impl Pins) -> Result<Option<Nanos>, cermd::pins::PinsError> {
//!     let charging = pins.drive(Drives::CHARGE)?;
//!     pins.rest_until(charging.after + Nanos(20_000_000))?;
//!     pins.drive(Drives::NONE)?;
//!     let armed = pins.arm()?;
//!     assert!(armed.levels.a, "charged");
//!     let start = pins.drive(Drives::C1)?;
//!     let edge = pins.edge(start.after + Nanos(50_000_000))?;
//!     pins.drive(Drives::NONE)?;
//!     let middle = start.before + Nanos(start.width().0 / 2);
//!     Ok(edge.map(|edge| edge.at - middle))
//! }
//!
//! let mut pins = SimPins::new(&Scene::builtin("pi4")?, None);
//! let crossing = crossing_of_a(&mut pins)?.ok_or("no edge came")?;
//! // (Rc1 + Ro) C_T ln(V_DD / V_Th), and some microseconds of latency.
//! assert!((285_000..320_000).contains(&crossing.0), "{crossing}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A backend of one's own implements every method of [`Pins`], and so does a decorator: none has a default that could
//! change what is decorated. What they owe is written down as thirteen clauses in tests/backends/clauses.rs.

use crate::circuit::Node;
use crate::units::Nanos;
use nix::sys::time::TimeValLike;
use nix::time::{ClockId, clock_gettime};
use std::fmt;

pub mod chardev;
pub mod chardev_v1;
mod limits;
pub mod output;
pub mod realtime;
pub mod sim;

pub use crate::record::MAX_CHANNELS;
pub(crate) use limits::FIRST_SPIN_MARGIN;

/// The set of lines that drive; every other line is an input.
///
/// Chargers drive high, sinks drive low. In the circuit with series calibration (Fig. 1(b)) [`Drives::C2`] is
/// the far end of Rc1 + Rc2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Drives(u32);

impl Drives {
    /// All lines are inputs: the safe state.
    pub const NONE: Drives = Drives(0);
    /// The charger of node A.
    pub const CHARGE_A: Drives = Drives(1);
    /// The charger of node B.
    pub const CHARGE_B: Drives = Drives(1 << 1);
    /// Both chargers.
    pub const CHARGE: Drives = Drives(0b11);
    /// The sink of Rc1.
    pub const C1: Drives = Drives(1 << 2);
    /// The sink of Rc2.
    pub const C2: Drives = Drives(1 << 3);

    /// The sink of the sensor of channel `index`, below [`MAX_CHANNELS`].
    pub const fn x(index: usize) -> Drives {
        assert!(index < MAX_CHANNELS);
        Drives(1 << (4 + index))
    }

    /// Every line of both sets.
    pub const fn and(self, other: Drives) -> Drives {
        Drives(self.0 | other.0)
    }

    /// The lines of `self` that are not in `other`.
    pub const fn without(self, other: Drives) -> Drives {
        Drives(self.0 & !other.0)
    }

    /// Whether every line of `other` drives.
    pub const fn contains(self, other: Drives) -> bool {
        self.0 & other.0 == other.0
    }

    /// Whether no line drives.
    pub const fn is_none(self) -> bool {
        self.0 == 0
    }

    /// The lines that are in both sets.
    pub const fn only(self, other: Drives) -> Drives {
        Drives(self.0 & other.0)
    }

    /// How many lines drive.
    pub const fn count(self) -> u32 {
        self.0.count_ones()
    }

    /// The single lines of this set: first the sensors' sinks, then c1, c2, then the chargers. A backend switches
    /// lines in this order, releases before drives.
    pub fn lines(self) -> impl Iterator<Item = Drives> {
        (4..4 + MAX_CHANNELS)
            .chain([2, 3, 0, 1])
            .map(|bit| Drives(1 << bit))
            .filter(move |line| self.contains(*line))
    }

    /// Whether a charger and a sink would drive against each other: never to be requested.
    pub const fn conflicts(self) -> bool {
        self.0 & Drives::CHARGE.0 != 0 && self.0 & !Drives::CHARGE.0 != 0
    }
}

impl fmt::Display for Drives {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_none() {
            return f.write_str("none");
        }
        let name = |line| match line {
            Drives::CHARGE_A => "charge-a".to_owned(),
            Drives::CHARGE_B => "charge-b".to_owned(),
            Drives::C1 => "c1".to_owned(),
            Drives::C2 => "c2".to_owned(),
            Drives(bits) => format!("x{}", bits.trailing_zeros() - 4),
        };
        let names: Vec<String> = self.lines().map(name).collect();
        f.write_str(&names.join("+"))
    }
}

/// Two clock readings around one call that switched lines: it happened in between.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Bracket {
    /// Read just before the call.
    pub before: Nanos,
    /// Read just after it.
    pub after: Nanos,
}

impl Bracket {
    /// How long the call took.
    pub fn width(self) -> Nanos {
        self.after - self.before
    }
}

/// The input levels of the sense nodes; `true` is high (above the threshold). A node that the circuit does not
/// have reads as high.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Levels {
    /// Node A.
    pub a: bool,
    /// Node B.
    pub b: bool,
}

impl Levels {
    /// The level of one node.
    pub fn of(self, node: Node) -> bool {
        match node {
            Node::A => self.a,
            Node::B => self.b,
        }
    }
}

/// A falling edge as the kernel reports it (`struct gpio_v2_line_event`, include/uapi/linux/gpio.h).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edge {
    /// The node that fell through its threshold.
    pub node: Node,
    /// The kernel's stamp, `CLOCK_MONOTONIC`.
    pub at: Nanos,
    /// Counts the events of all sense lines from 1; a gap shows a coalesced or lost edge. Wraps. Of a single line the kernel counts
    /// only what it has room to tell (`edge_irq_handler`, drivers/gpio/gpiolib-cdev.c): coalesced edges are not seen there.
    pub seqno: u32,
    /// Counts the events of this line from 1; a gap shows an event lost to a full buffer. Wraps.
    pub line_seqno: u32,
}

/// `CLOCK_MONOTONIC` now; through the vDSO, without entering the kernel.
pub fn monotonic() -> Nanos {
    clock(ClockId::CLOCK_MONOTONIC)
}

/// Reads a clock. One that Linux always has: it cannot fail.
pub(crate) fn clock(id: ClockId) -> Nanos {
    clock_gettime(id).map_or(Nanos::ZERO, |time| Nanos(time.num_nanoseconds()))
}

/// The release of the running kernel ("6.12.34+rpt-rpi-2712"), and the first two numbers of it.
pub(crate) fn kernel() -> (String, Option<(u32, u32)>) {
    let release = nix::sys::utsname::uname().map(|name| name.release().to_string_lossy().into_owned());
    let release = release.unwrap_or_default();
    let version = version(&release);
    (release, version)
}

fn version(release: &str) -> Option<(u32, u32)> {
    let mut numbers = release.split(|c: char| !c.is_ascii_digit()).map(str::parse);
    Some((numbers.next()?.ok()?, numbers.next()?.ok()?))
}

/// The later of two numbers that wrap.
pub(crate) fn later(seqno: u32, other: u32) -> u32 {
    if other.wrapping_sub(seqno) as i32 > 0 { other } else { seqno }
}

/// The answer to [`Pins::arm`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Armed {
    /// The levels, read after arming: an edge before that gives no event.
    pub levels: Levels,
    /// The highest `seqno` handed out so far: the next edge has the following one.
    pub seqno: u32,
    /// The same for each node's `line_seqno`.
    pub line_seqno: [u32; 2],
}

/// What a backend knows about itself. The default: its waits are exact, and nothing escapes it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Particulars<'a> {
    /// How long before an instant sleeping turns into spinning, as learned so far.
    pub spin_margin: Option<Nanos>,
    /// How often lines had to be configured anew, because somebody else had made the kernel take them for inputs.
    pub renewed: u64,
    /// The kernel's tick interrupts whatever runs at whole multiples of this period; `None`: nobody knows when.
    pub tick: Option<Nanos>,
    /// What it cannot notice, in sentences.
    pub blind_spots: &'a [&'static str],
}

/// What can go wrong with the hardware.
#[derive(Debug, thiserror::Error)]
pub enum PinsError {
    /// A charger and a sink were asked to drive at once; nothing was switched.
    #[error("refused to drive {0}: a charger and a sink would drive against each other")]
    Conflict(Drives),
    /// A part that no line plays was asked to drive; nothing was switched.
    #[error("refused to drive {0}: no line is wired to it")]
    Unwired(Drives),
    /// The thread is to stop: no failure of the hardware.
    #[error("the measurement was stopped")]
    Stopped,
    /// The chip has disappeared, its driver unbound or the board unplugged: let go, and open it again later.
    #[error(
        "the GPIO chip {chip} is gone, says {call} on {line}: its driver was unbound, or the board unplugged"
    )]
    Gone {
        /// Name and label it had.
        chip: String,
        /// The system call or ioctl that found out.
        call: &'static str,
        /// The line or request it was made for.
        line: String,
    },
    /// A kernel call failed.
    #[error("{call} on {line} failed: {source}; {hint}")]
    Call {
        /// The system call or ioctl.
        call: &'static str,
        /// The line, chip or request it was made for.
        line: String,
        /// What the kernel answered.
        source: std::io::Error,
        /// The likely cause and what to do.
        hint: &'static str,
    },
}

/// The GPIO lines of one circuit, and the clock that stamps them; the [module](self) has an example.
///
/// Implementations are real hardware, the simulated circuit, or decorators around either. All instants are
/// `CLOCK_MONOTONIC`. Nothing here allocates, except to report an error.
///
/// # Errors
/// A call fails with [`PinsError::Gone`] when the chip has disappeared, with [`PinsError::Call`] when the kernel refuses it
/// for another reason. After a failed call any line may drive, until a call of [`drive`](Pins::drive) succeeds.
pub trait Pins {
    /// What time it is.
    fn now(&mut self) -> Nanos;

    /// Makes exactly the lines of `on` drive, in one call: first releases, then drives, line by line in the order
    /// of [`Drives::lines`]. Lines that already are as asked are not touched.
    ///
    /// # Errors
    /// [`PinsError::Conflict`], before anything is touched, when `on` [conflicts](Drives::conflicts).
    fn drive(&mut self, on: Drives) -> Result<Bracket, PinsError>;

    /// Forgets the edges that have come so far, and watches for falling edges from here on. To be called while nothing
    /// drives: some wirings have to reconfigure the sense lines.
    fn arm(&mut self) -> Result<Armed, PinsError>;

    /// Waits for the next edge, at most until `until`; `None` when that instant has passed without one.
    fn edge(&mut self, until: Nanos) -> Result<Option<Edge>, PinsError>;

    /// Waits until an instant, as precisely as the system can. Edges that come meanwhile are kept.
    fn sleep_until(&mut self, at: Nanos) -> Result<(), PinsError>;

    /// Waits until an instant or somewhat later, where nothing depends on how much later: no processor time is spent on
    /// being in time.
    fn rest_until(&mut self, at: Nanos) -> Result<(), PinsError>;

    /// Rests until shortly before an edge that is due at an instant, if that is cheaper than waiting for it all the time;
    /// else does nothing.
    fn rest_before_edge(&mut self, at: Nanos) -> Result<(), PinsError>;

    /// The input levels now. They tell an edge that was missed from a node that is still above its threshold.
    fn levels(&mut self) -> Result<Levels, PinsError>;

    /// What the backend knows about itself.
    fn particulars(&self) -> Particulars<'_>;
}

/// Pins of a backend that is chosen while the program runs.
impl<P: Pins + ?Sized> Pins for Box<P> {
    fn now(&mut self) -> Nanos {
        (**self).now()
    }
    fn drive(&mut self, on: Drives) -> Result<Bracket, PinsError> {
        (**self).drive(on)
    }
    fn arm(&mut self) -> Result<Armed, PinsError> {
        (**self).arm()
    }
    fn edge(&mut self, until: Nanos) -> Result<Option<Edge>, PinsError> {
        (**self).edge(until)
    }
    fn sleep_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        (**self).sleep_until(at)
    }
    fn rest_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        (**self).rest_until(at)
    }
    fn rest_before_edge(&mut self, at: Nanos) -> Result<(), PinsError> {
        (**self).rest_before_edge(at)
    }
    fn levels(&mut self) -> Result<Levels, PinsError> {
        (**self).levels()
    }
    fn particulars(&self) -> Particulars<'_> {
        (**self).particulars()
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn releases_of_kernels_are_read() {
        for (release, version) in [
            ("6.12.34+rpt-rpi-2712", Some((6, 12))),
            ("5.4.0-150-generic", Some((5, 4))),
            ("7.2-rc1", Some((7, 2))),
            ("unknown", None),
        ] {
            assert_eq!(super::version(release), version);
        }
        assert!(super::kernel().1.is_some());
    }
}
