//! Reads resistive sensors on Linux GPIO lines without an ADC.
//!
//! Two capacitors, two known resistors and five to seven GPIO lines make an ohmmeter: lines charge the capacitors,
//! one resistor at a time discharges them, the kernel stamps the moment a node falls through the threshold of its
//! input, and the times give the resistance (direct interface circuits: TPCM, QERM, TCDIC, CERM).
//!
//! # The way of the data
//!
//! ```text
//! pins -> discharge -> record -> estimate -> reading -> client
//! ```
//!
//! Arrows point one way, and so do the modules, in this order:
//!
//! | for | modules |
//! |---|---|
//! | quantities and the law of the circuit | [`units`], [`circuit`] |
//! | what a user may decide | [`config`], [`settings`] |
//! | the hardware behind one trait, and what stands in for it | [`pins`], [`backend`], [`realtime`] |
//! | one discharge, and its timings | [`discharge`], [`record`], [`tape`] |
//! | timings to ohms and newtons, pure | [`method`], [`noise`], [`offset`], [`motion`], [`estimate`], [`force`], [`fit`], [`replay`] |
//! | which discharges, in which order, and what is wrong with the board | [`leak`], [`diagnosis`], [`cycle`], [`instrument`], [`stats`] |
//! | what a client is told | [`reading`], [`wire`], [`server`], [`client`] |
//! | threads, signals, the service manager | [`daemon`] |
//! | what a person types | [`check`], [`cli`], [`ctl`] |
//!
//! Pure code takes time as an argument; only [`daemon`] and the pins know that time passes by itself. The simulated
//! circuit ([`pins::sim`]) shares nothing with the estimators but constants and units, so that an error in the physics of
//! either shows.
//!
//! Equation numbers are those of the paper on the compact error reduction method (wide range calibration for direct
//! interface circuits).

pub mod backend;
pub mod check;
pub mod circuit;
pub mod cli;
pub mod client;
pub mod config;
pub mod ctl;
pub mod cycle;
pub mod daemon;
pub mod diagnosis;
pub mod discharge;
pub mod estimate;
pub mod fit;
pub mod force;
pub mod instrument;
pub mod law;
pub mod leak;
pub mod method;
pub mod motion;
pub mod noise;
pub mod offset;
pub mod pins;
pub mod reading;
pub mod realtime;
pub mod record;
pub mod replay;
pub mod server;
pub mod settings;
pub mod stats;
pub mod tape;
pub mod tracker;
pub mod units;
pub mod wire;
