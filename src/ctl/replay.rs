//! Estimating from a tape: for every x discharge one line, from the most recent calibration discharges before it.

use crate::circuit::Kind;
use crate::estimate::Estimator;
use crate::estimate::offset::{Offset, SplitCalibration};
use crate::instrument::settings::OffsetSource;
use crate::reading::{Fault, Method, Status};
use crate::record::CalibrationKind;
use crate::sensor::Channel;
use crate::stream::tape::{Entry, Header};
use crate::stream::wire::StateLine;
use serde::Serialize;

/// What is said about one x discharge.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "class", rename = "ESTIMATE")]
pub struct Estimate {
    seq: u64,
    channel: String,
    #[serde(flatten)]
    state: StateLine,
}

/// The estimates of a whole tape, or the first thing that is wrong with it. `offset`: where d comes from; `None`: from the
/// header, or else from the split discharges on the tape.
///
/// # Errors
/// What is wrong, with the line number, or what to do.
pub fn estimate(text: &str, method: Method, offset: Option<OffsetSource>) -> Result<Vec<Estimate>, String> {
    let (header, entries) = parse(text)?;
    replay(&header, &entries, method, offset, line)
}

/// The estimates of one channel as they are, ohm: no zero taken off, and below 0 too, where a reading says `short`; a
/// fault for each discharge that gives none.
///
/// # Errors
/// The method does not belong to the circuit, or d is needed and not known.
pub(crate) fn signed_ohm(
    header: &Header,
    entries: &[Entry],
    method: Method,
    id: &str,
) -> Result<Vec<Result<f64, Fault>>, String> {
    let signed = replay(header, entries, method, None, |estimator, channel, entry| {
        let estimate = || estimator.estimate(&entry.record).map(|estimate| estimate.r_ohm.value);
        (channel.id == id).then(estimate)
    })?;
    Ok(signed.into_iter().flatten().collect())
}

/// Calibrates with the calibration discharges of a tape, and asks `each` about those of sensors.
fn replay<T>(
    header: &Header,
    entries: &[Entry],
    method: Method,
    offset: Option<OffsetSource>,
    each: impl Fn(&Estimator, &Channel, &Entry) -> T,
) -> Result<Vec<T>, String> {
    let nodes = nodes_of(method, header.circuit.kind)?;
    let [r1, r2] = header.r_ohm();
    let new = |offset| Estimator::new(method, r1, r2, nodes, offset);
    let offset = match (offset, header.offset_ns) {
        (Some(OffsetSource::Given(d_ns)), _) | (None, Some(d_ns)) => Offset::given(d_ns),
        // It cancels in the equations of these, or is part of what is tracked.
        _ if !method.needs_offset() => Offset::default(),
        _ => split_offset(new(Offset::default()), [r1, r2], nodes, entries).ok_or_else(|| {
            format!(
                "{method} needs the latency offset, and the tape has neither offset_ns nor enough split calibration \
                 discharges; give it with --offset, e.g. --offset \"8 us\""
            )
        })?,
    };
    let mut estimator =
        if method.is_tracked() { Estimator::tracked(method, r1, r2, nodes) } else { new(offset) };
    let mut estimates = Vec::new();
    for entry in entries {
        match (entry.record.through.channel(), entry.record.switch) {
            (Some(channel), _) => estimates.push(each(&estimator, &header.channels[channel], entry)),
            // The calibration in force stays when a discharge is of no use.
            (None, None) => drop(estimator.calibrate(&entry.record)),
            (None, Some(_)) if method.is_tracked() => drop(estimator.calibrate(&entry.record)),
            (None, Some(_)) => {}
        }
    }
    Ok(estimates)
}

fn parse(text: &str) -> Result<(Header, Vec<Entry>), String> {
    let mut lines = text.lines().enumerate();
    let (_, first) = lines.next().ok_or("line 1: the tape is empty")?;
    let header = Header::parse(first).map_err(|error| error.to_string())?;
    let mut entries: Vec<Entry> = Vec::new();
    for (index, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
        let entry = header.parse_discharge(index + 1, line).map_err(|error| error.to_string())?;
        if let Some(before) = entries.last().filter(|before| before.seq >= entry.seq) {
            return Err(format!(
                "line {}: seq {} comes after {}; the lines are out of order, or two tapes were joined",
                index + 1,
                entry.seq,
                before.seq
            ));
        }
        entries.push(entry);
    }
    Ok((header, entries))
}

fn nodes_of(method: Method, kind: Kind) -> Result<usize, String> {
    let rules = method.rules();
    if rules.circuits.contains(&kind) {
        return Ok(rules.last(kind).index() + 1);
    }
    let names: Vec<&str> = Method::on(kind).map(Method::as_str).collect();
    let (last, others) = names.split_last().unwrap_or((&"", &[]));
    let others = others.join(", ");
    let kind = kind.as_str();
    Err(format!("{method} does not work on a {kind} tape; take {others} or {last}"))
}

fn split_offset(
    mut estimator: Estimator,
    [r1, r2]: [f64; 2],
    nodes: usize,
    entries: &[Entry],
) -> Option<Offset> {
    let mut split = SplitCalibration::new(r1, r2, nodes, entries.len());
    for Entry { record, .. } in entries.iter().filter(|entry| entry.record.through.channel().is_none()) {
        match record.calibration_kind() {
            Some(CalibrationKind::Split) => {
                if let Some((c1, c2)) = estimator.calibration() {
                    split.add(c1, c2, record, estimator.noise());
                }
            }
            _ => drop(estimator.calibrate(record)),
        }
    }
    split.result()
}

fn line(estimator: &Estimator, channel: &Channel, entry: &Entry) -> Estimate {
    let status = match estimator.status(&entry.record, channel.zero_ohm, channel.force.as_ref()) {
        // A tape does not say how long was waited for a crossing that is not on it, so `open` never comes of it.
        Status::Open { .. } => Status::Fault(Fault::MissedEdge),
        status => status,
    };
    let mut state = StateLine::new(&status, estimator.method());
    state.method = Some(estimator.method().to_string());
    Estimate { seq: entry.seq, channel: channel.id.clone(), state }
}
