//! Estimating from a tape: the discharges go through the instrument's own order of things, so that a tape is read as the
//! daemon has read it.

use crate::circuit::Node;
use crate::estimate::estimator::Estimate;
use crate::estimate::offset::Offset;
use crate::estimate::scatter::SwitchScatter;
use crate::instrument::cycle::Cycle;
use crate::instrument::discharge::Charge;
use crate::instrument::settings::{Charges, OffsetSource, Settings};
use crate::reading::{Fault, Measured, Method, Reading, Status};
use crate::record::Record;
use crate::stream::tape::{Entry, Header, TapeOffset};
use crate::stream::wire::{StateLine, Unit};
use crate::units::Nanos;
use serde::Serialize;

/// What is said about one x discharge.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "class", rename = "ESTIMATE")]
pub struct EstimateLine {
    /// The number of the discharge on the tape.
    pub seq: u64,
    /// The id of the channel.
    pub channel: String,
    /// As in the READING of this discharge, if the tape tells when it was.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub t_mono_ns: Option<i64>,
    /// What is known.
    #[serde(flatten)]
    pub state: StateLine,
}

/// One method on its way along a tape.
#[derive(Debug)]
pub struct Replay {
    header: Header,
    method: Method,
    cycle: Cycle,
    /// Whether the calibration is followed.
    tracked: bool,
    /// The offset is what the tape tells, from the first four split discharges on.
    is_auto: bool,
    counts: Counts,
}

#[derive(Debug, Default)]
struct Counts {
    /// How many estimates were numbers.
    numbers: u64,
    /// How many discharges of sensors ended before the last node that the method times.
    ended_early: u64,
    /// How many were switched before d was known.
    without_offset: u64,
}

impl Replay {
    /// At the beginning of a tape. `offset`: where d comes from; `None`: from the header, or else from the split discharges on
    /// the tape.
    ///
    /// # Errors
    /// The method does not work on the circuit, or takes no offset.
    pub fn new(header: &Header, method: Method, offset: Option<OffsetSource>) -> Result<Replay, String> {
        let (kind, header) = (header.circuit.kind, header.clone());
        let circuits = method.rules().circuits;
        if !circuits.contains(&kind) {
            let names: Vec<&str> = Method::on(kind).map(Method::as_str).collect();
            let (last, others) = names.split_last().unwrap_or((&"", &[]));
            let others = others.join(", ");
            return Err(format!("{method} does not work on a {kind} tape; take {others} or {last}"));
        }
        let tracked = method.is_tracked() || (header.tracked && Method::can_be_tracked(kind));
        if tracked && matches!(offset, Some(OffsetSource::Given(_))) {
            return Err("the calibration of this tape is followed (tracked), and the latency offset with it: leave --offset away".to_owned());
        }
        let is_auto = offset == Some(OffsetSource::Auto);
        let offset = match (offset, header.offset.offset_ns) {
            (Some(OffsetSource::Given(d_ns)), _) => Some(Offset::given(d_ns)),
            (None, Some(d_ns)) => Some(of_header(d_ns, &header.offset)),
            // It is part of what is tracked.
            _ if tracked => Some(Offset::default()),
            _ => None,
        };
        let mut cycle = Cycle::new(settings(&header, method, tracked, offset.map(|offset| offset.d_ns)));
        cycle.know(&header.looks.found());
        // That of a calibration which is followed is followed with it.
        if let Some(offset) = offset.filter(|_| !tracked) {
            cycle.set_offset(offset);
        }
        Ok(Replay { header, method, cycle, tracked, is_auto, counts: Counts::default() })
    }

    /// Takes the next discharge; the estimate, if it was a sensor's.
    pub fn take(&mut self, entry: &Entry) -> Option<EstimateLine> {
        let reading = self.read(entry)?;
        let channel = &self.header.channels[reading.channel];
        let mut state = StateLine::new(&reading.status, self.method, &Unit::named(channel.unit()));
        state.method = Some(self.method.to_string());
        let channel = channel.id.clone();
        let t_mono_ns = entry.is_timed.then_some(reading.at.0);
        Some(EstimateLine { seq: entry.seq, channel, t_mono_ns, state })
    }

    /// The same as the instrument has it.
    pub fn read(&mut self, entry: &Entry) -> Option<Reading> {
        let Entry { is_timed, is_held, record, .. } = entry;
        let is_of_sensor = record.through.channel().is_some();
        let reading = if self.lacks_offset(record) {
            self.counts.without_offset += 1;
            self.cycle.replay_failed(record, *is_timed, Fault::NoCalibration)
        } else {
            let is_cut = record.a_ns.is_some() && record.b_ns.is_none() && record.waited_ns.is_none();
            let needs_b =
                !self.method.is_tracked() && self.method.rules().last(self.header.circuit.kind) == Node::B;
            self.counts.ended_early += u64::from(is_of_sensor && is_cut && needs_b);
            self.cycle.replay(record, *is_timed, *is_held)
        };
        let is_number = reading.is_some_and(|reading| matches!(reading.status, Status::Ok { .. }));
        self.counts.numbers += u64::from(is_number);
        reading
    }

    /// Whether this discharge needs d, and nothing has told it yet. Of a calibration that is followed, readings say that there is none
    /// yet; full ones are read as the daemon reads them before it has found the offset, unless the tape is to tell it.
    fn lacks_offset(&mut self, record: &Record) -> bool {
        let is_switched = record.through.channel().is_some() && record.switch.is_some();
        let is_wanting = self.method.needs_offset() && !self.tracked && !self.cycle.offset_is_known();
        let is_settled = is_wanting && (is_switched || self.is_auto) && self.cycle.settle_offset();
        is_wanting && is_switched && !is_settled
    }

    /// Takes the next discharge; the estimate as it is, ohm, if it was a sensor's and there is a calibration: no zero taken
    /// off, and below 0 too, where a reading says `short`; with 1 sigma of what other readings share with it.
    pub fn signed_ohm(&mut self, entry: &Entry) -> Option<Result<Measured, Fault>> {
        let (record, estimator) = (&entry.record, self.cycle.estimator());
        let is_known = record.through.channel().is_some() && estimator.calibration().is_some();
        let shared = |estimate: Estimate| estimate.basis.shared(estimate.r_ohm);
        let signed = is_known.then(|| estimator.estimate(record).map(shared));
        self.cycle.replay(record, entry.is_timed, entry.is_held);
        signed
    }

    /// Whether neither the header nor a discharge that was held has told of leaks: none is in the uncertainties.
    pub fn ignores_leaks(&self) -> bool {
        self.cycle.estimator().ignores_leaks()
    }

    /// At the end of the tape: whether there is not a single number because nothing has told d.
    pub fn has_no_offset(&self) -> bool {
        self.counts.numbers == 0 && self.counts.without_offset > 0
    }

    /// At the end of the tape: what was missing on it, if there is not a single number because of that.
    pub fn missed(&self) -> Option<String> {
        let method = self.method;
        match self.counts.numbers {
            0 if self.tracked && !self.cycle.offset_is_known() => Some(format!(
                "no number: the tape shows too few whole rounds of calibration discharges to follow the calibration of {method} by; \
                 record it again, all of it: `cermctl record --raw` begins with them",
            )),
            0 if self.has_no_offset() => Some(format!(
                "{method} needs the latency offset, and the tape has neither offset_ns nor enough split calibration \
                 discharges; give it with --offset, e.g. --offset \"8 us\"",
            )),
            0 if self.counts.ended_early > 0 => Some(format!(
                "no number: the discharges of this tape end at node A, and {method} needs node B, too; take --method tracked, or \
                 record a cermd with method = \"{method}\"",
            )),
            _ => None,
        }
    }

    /// What all discharges belong to.
    pub fn header(&self) -> &Header {
        &self.header
    }
}

/// Of an instrument that only takes what is on the tape.
fn settings(header: &Header, method: Method, tracked: bool, offset_ns: Option<f64>) -> Settings {
    Settings {
        method,
        kind: header.circuit.kind,
        r_c_ohm: [header.circuit.r_c1_ohm, header.circuit.r_c2_ohm],
        offset_ns,
        resolution: Nanos(header.resolution_ns.unwrap_or(1.0) as i64),
        tracked,
        channels: header.channels.clone(),
        // What is planned is on the tape already.
        nominal: Nanos::ZERO,
        drain: Nanos::ZERO,
        charge: Charges::alike(Charge::alone(Nanos::ZERO)),
        charge_ohm: None,
        settle: Nanos::ZERO,
        deadline: Nanos::MAX,
        period: None,
        average: None,
        every: vec![1; header.channels.len()],
        t_l: None,
        switch_fraction: 1.0,
    }
}

/// What the tape does not tell of it is as of a given one.
fn of_header(d_ns: f64, known: &TapeOffset) -> Offset {
    let given = Offset::given(d_ns);
    Offset {
        u_d_ns: known.offset_u_ns.unwrap_or(given.u_d_ns),
        r_o_ohm: known.r_o_ohm.zip(known.r_o_u_ohm),
        scatter: known.switch_u_ns.map(SwitchScatter::of).unwrap_or_default(),
        by_switch: known.offset_by_switch.unwrap_or(given.by_switch),
        ..given
    }
}

#[cfg(test)]
mod coarse;
#[cfg(test)]
mod later;
#[cfg(test)]
mod tests;
