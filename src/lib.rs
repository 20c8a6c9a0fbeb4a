//! Reads resistive sensors on Linux GPIO lines without an ADC.
//!
//! One or two capacitors, two known resistors and five to seven GPIO lines make an ohmmeter: lines charge the capacitors,
//! one resistor at a time discharges them, the kernel stamps the moment a node falls through the threshold of its
//! input, and the times give the resistance (direct interface circuits: TPCM, QERM, TCDIC, CERM).
//!
//! # The way of the data
//!
//! ```text
//! pins -> discharge -> record -> estimate -> reading -> client
//! ```
//!
//! # The rooms
//!
//! Each room imports from rooms above it in this table, never from one below; `tests/house.rs` holds the table against the
//! imports. The nominal circuit stands before the timings and the readings because both name its nodes.
//!
//! | room | for | must not know |
//! |---|---|---|
//! | [`units`] | time and quantities with their units, how numbers and texts are written | physics |
//! | [`files`] | the text of a file whose path is not to be trusted | what is in it |
//! | [`circuit`] | the nominal law of the circuit, its nodes, its three wirings | measured times, pins |
//! | [`record`] | the timings of one discharge | how they were taken |
//! | [`reading`] | what is said of a sensor: a number, or a state with its reason | how it came about |
//! | [`sensor`] | what is known of a sensor before it is measured: its zero, how its resistance becomes a force, a temperature or what else it stands for | how it is measured |
//! | [`trigger`] | when readings become an event: pressed, released, or not known any more | who is told, what is switched |
//! | [`pins`] | the hardware behind one trait: character devices, the simulated circuit, real-time rights | discharges, methods |
//! | [`estimate`] | from records to what is known: law, methods, noise, offset, tracked calibration, force; pure | pins, clocks, the order of discharges |
//! | [`instrument`] | which discharges in which order, one discharge step by step, what is wrong with the board | files, threads, clients |
//! | [`stream`] | lines of the protocol and of a tape, server, client | equations, configuration |
//! | [`bridge`] | what the socket says, in the words of other systems | measuring, configuration of the instrument, GPIO |
//! | [`config`] | the configuration file, its checks, and from it to settings, pins and tape headers | measuring |
//! | [`size`] | which circuit does what is asked for: parts, candidates, their rank by closed forms | how it is measured, command lines |
//! | [`daemon`] | threads, signals, the service manager | equations |
//! | [`characterize`] | sweeps of whole instruments over resistances and settings, as a tidy table | how it is drawn, terminals |
//! | [`report`] | from a table of measured points to figures and one page | how points were measured, pins, the instrument |
//! | [`ctl`] | what a person types, and what is shown | GPIO calls |
//!
//! Pure code takes time as an argument; only [`daemon`] and the pins know that time passes by itself. The simulated
//! circuit ([`pins::sim`]) shares nothing with the estimators but constants, units and the list of capacitors, so that an
//! error in the physics of either shows.
//!
//! Equation numbers are those of the paper on the compact error reduction method (wide range calibration for direct
//! interface circuits).
//!
//! # Features
//!
//! `programs` (default): everything. Without default features there is what a program needs that only listens to the
//! daemon, and its few dependencies: [`client`], [`wire`], and [`tape`] with the timings of a recording.

#[cfg(feature = "programs")]
#[doc(hidden)]
pub mod bridge;
#[cfg(test)]
#[path = "../tests/common/chance.rs"]
#[allow(dead_code, reason = "shared with all other tests")]
pub(crate) mod chance;
#[cfg(feature = "programs")]
#[doc(hidden)]
pub mod characterize;
pub mod circuit;
#[cfg(feature = "programs")]
pub mod config;
#[cfg(all(test, feature = "programs"))]
#[path = "../tests/common/config.rs"]
#[allow(dead_code, reason = "shared with all other tests")]
pub(crate) mod config_file;
#[cfg(feature = "programs")]
#[doc(hidden)]
pub mod ctl;
#[cfg(feature = "programs")]
#[doc(hidden)]
pub mod daemon;
#[cfg(all(test, feature = "programs"))]
#[path = "../tests/common/decorated.rs"]
#[allow(dead_code, reason = "shared with all other tests")]
pub(crate) mod decorated;
#[cfg(feature = "programs")]
#[doc(hidden)]
pub mod estimate;
#[cfg(feature = "programs")]
#[doc(hidden)]
pub mod files;
#[cfg(feature = "programs")]
pub mod instrument;
#[cfg(feature = "programs")]
pub mod pins;
pub mod reading;
pub mod record;
#[cfg(feature = "programs")]
#[doc(hidden)]
pub mod report;
#[cfg(test)]
#[path = "../tests/common/seed.rs"]
pub(crate) mod seed;
pub mod sensor;
#[cfg(feature = "programs")]
#[doc(hidden)]
pub mod size;
#[cfg(test)]
extern crate self as cermd;
pub mod stream;
#[cfg(feature = "programs")]
#[doc(hidden)]
pub mod trigger;
pub mod units;

pub use stream::{client, tape, wire};
