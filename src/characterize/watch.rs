//! What one instrument says of a known resistance, and where its time goes.

use super::limits::COLD;
use crate::circuit::Node;
use crate::estimate::method::{self, Switched, cerm};
use crate::instrument::{Instrument, Message};
use crate::pins::{Pins, PinsError};
use crate::reading::{Reading, Status};
use crate::record::{Record, Through};
use crate::sensor::Channel;
use crate::units::Nanos;

/// How long an instrument is watched. Instants are those of its pins.
#[derive(Debug, Clone, PartialEq)]
pub struct WatchSpan {
    /// The channel that is watched.
    pub channel: Channel,
    /// When the instrument started.
    pub start: Nanos,
    /// Readings count from then on, if the offset is known, the first of them left out: it has begun before. `None`: all do.
    pub from: Option<Nanos>,
    /// Nothing counts that is of after.
    pub until: Nanos,
    /// How many published readings are enough.
    pub readings: usize,
}

/// A published reading against the truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// When R_x was what it says.
    pub at: Nanos,
    /// Its number, or why there is none: `open`, `short`, or the name of a fault.
    pub what: Result<Deviation, &'static str>,
}

/// The number of a reading.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Deviation {
    /// What it is off by, ohm.
    pub error_ohm: f64,
    /// What it says of that, 1 sigma, ohm; `None`: nothing yet.
    pub u_ohm: Option<f64>,
    /// The Cramer-Rao bound of the discharges that it is made of, 1 sigma, ohm; `None`: without a tracked state.
    pub bound_ohm: Option<f64>,
    /// It says that the sensor moves.
    pub is_moving: bool,
    /// Its u is a prior.
    pub is_settling: bool,
}

/// Where time goes, from the first instant that counts to the last reading, s.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spent {
    /// What goes before discharges of the sensor.
    pub charge_s: f64,
    /// Discharges of the sensor until their last crossing.
    pub discharge_s: f64,
    /// Calibration discharges with what goes before them, looks for a leak included.
    pub calibration_s: f64,
    /// All else.
    pub overhead_s: f64,
}

impl Spent {
    /// All of it, s.
    pub fn whole_s(&self) -> f64 {
        self.charge_s + self.discharge_s + self.calibration_s + self.overhead_s
    }
}

/// What came of it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Found {
    /// Published readings, in order.
    pub told: Vec<Observation>,
    /// The time in which they were.
    pub times: Spent,
    /// Of each discharge of the sensor that was switched to R_2: T_i,xA (16), T_i,xB (18), and T_c2A that they were inferred with, ns.
    pub inferred_ns: Vec<[f64; 3]>,
}

/// The clock of [`Spent`]: up to where time is accounted for.
struct Account {
    at: Option<Nanos>,
    times: Spent,
}

impl Account {
    fn take(&mut self, asked: Nanos, record: &Record) {
        let Some(at) = self.at else { return };
        let ended = end_of(record);
        let [beside, before, takes] =
            [asked - at, record.start - asked, ended - record.start].map(Nanos::as_seconds);
        self.times.overhead_s += beside;
        if record.through.channel().is_some() {
            self.times.charge_s += before;
            self.times.discharge_s += takes;
        } else {
            self.times.calibration_s += before + takes;
        }
        self.at = Some(ended);
    }
}

/// Lets an instrument of one channel measure, and compares what it publishes with `truth`, ohm at an instant. `goes_on` is asked
/// before each step.
///
/// # Errors
/// Those of the pins.
pub fn watch<P: Pins>(
    instrument: &mut Instrument<P>,
    watch: &WatchSpan,
    truth: impl Fn(&P, Nanos) -> f64,
    mut goes_on: impl FnMut() -> bool,
) -> Result<Found, PinsError> {
    let (mut found, mut information) = (Found::default(), Some(0.0));
    let mut account = Account { at: watch.from.is_none().then_some(watch.start), times: Spent::default() };
    let mut second = None;
    while found.told.len() < watch.readings && goes_on() {
        let (mut discharged, mut read) = (None, None);
        instrument.step(&mut |message| match message {
            Message::Discharge { asked, record, .. } => discharged = Some((asked, record)),
            Message::Reading(reading) => read = Some(reading),
        })?;
        if let Some((asked, record)) = &discharged {
            account.take(*asked, record);
            if record.through == Through::C2 {
                second = Some(*record);
            }
            if record.through.channel().is_some() {
                if account.at.is_some() {
                    let d_ns = instrument.cycle().estimator().offset().d_ns;
                    found.inferred_ns.extend(second.and_then(|second| inferred(record, &second, d_ns)));
                }
                let r_ohm = watch.channel.as_read(truth(instrument.pins(), record.start));
                information =
                    information.zip(bound(instrument, record, r_ohm)).map(|(sum, bound)| sum + 1.0 / bound);
            }
        }
        let Some(reading) = read else { continue };
        if reading.at > watch.until {
            break;
        }
        let is_known = || instrument.stats().offset_is_known || reading.at > watch.start + COLD;
        if watch.from.is_none_or(|from| reading.at >= from && is_known()) {
            if account.at.is_some() {
                let r_ohm = truth(instrument.pins(), reading.at);
                found.told.push(observed(&reading, r_ohm, information));
            } else {
                account.at = Some(discharged.map_or(reading.at, |(_, record)| end_of(&record)));
            }
        }
        information = Some(0.0);
    }
    found.times = account.times;
    Ok(found)
}

/// As [`Found::inferred_ns`], with the last discharge through R_2.
fn inferred(record: &Record, second: &Record, d_ns: f64) -> Option<[f64; 3]> {
    let switch = record.switch.filter(|switch| switch.to == Through::C2)?;
    let times = method::Times {
        c1: [None; 2],
        c2: [second.a_ns, second.b_ns],
        x: [record.a_ns, record.b_ns],
        switch: Some(Switched { at: switch.at_ns, on: switch.on_ns }),
        beside: None,
        d: d_ns,
    };
    let [t_ixa, t_ixb] = cerm::inferred(&times)?;
    Some([t_ixa, t_ixb, second.a_ns? - d_ns])
}

/// When a discharge came to its end, or was waited for in vain.
fn end_of(record: &Record) -> Nanos {
    let ends_ns = record.crossings().into_iter().chain([record.waited_ns]).flatten();
    record.start + Nanos(ends_ns.fold(0.0, f64::max) as i64)
}

/// The Cramer-Rao bound of a discharge of the sensor, ohm², if there is a tracked state. `r_ohm`: as it is read, without its zero.
fn bound<P: Pins>(instrument: &Instrument<P>, record: &Record, r_ohm: f64) -> Option<f64> {
    let last = if record.b_ns.is_some() { Node::B } else { Node::A };
    let estimator = instrument.cycle().estimator();
    let u_switch_ns = record.u_switch_ns.unwrap_or(0.0);
    Some(estimator.predict_tracked(r_ohm, record.switch, u_switch_ns, last)?.bound)
        .filter(|bound| *bound > 0.0)
}

/// A reading against the truth, ohm. `information`: of the discharges that it is made of, 1/ohm², if it is known.
pub fn observed(reading: &Reading, truth_ohm: f64, information: Option<f64>) -> Observation {
    let what = match reading.status {
        Status::Ok { r_ohm, is_moving, is_settling, .. } => Ok(Deviation {
            error_ohm: r_ohm.value - truth_ohm,
            u_ohm: r_ohm.u,
            bound_ohm: information.filter(|sum| *sum > 0.0).map(|sum| sum.sqrt().recip()),
            is_moving,
            is_settling,
        }),
        Status::Open { .. } => Err("open"),
        Status::Short { .. } => Err("short"),
        Status::Fault(fault) => Err(fault.as_str()),
    };
    Observation { at: reading.at, what }
}
