//! A tape with a known resistor on each channel: what strangers send is judged as what is measured here.
//!
//! A tape does not tell when a discharge was asked for, so of the time of a reading only the whole and its discharge are known.
//! Means are those of blocks of the estimates as they came.

use super::provenance;
use crate::characterize::figures::{blocks, filled};
use crate::characterize::folder::Folder;
use crate::characterize::limits::{AVERAGES, WARM};
use crate::characterize::table::{Row, Source};
use crate::characterize::watch::{Found, observed};
use crate::ctl::CtlError;
use crate::ctl::cli::Characterize;
use crate::ctl::limits::TAPE_BLOCKS;
use crate::ctl::replay::Replay;
use crate::reading::Method;
use crate::stream::tape::{Entry, Header, Reader};
use crate::units::sample::mean;
use crate::units::{Nanos, rounded};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// Writes the rows of a tape.
pub fn run(arguments: &Characterize, path: &Path) -> Result<Folder, CtlError> {
    let wrong = |why: &dyn std::fmt::Display| CtlError::Said(format!("{}: {why}", path.display()));
    let file = File::open(path).map_err(CtlError::file(path))?;
    let tape = Reader::open(BufReader::new(file)).map_err(|error| wrong(&error))?;
    let header = tape.header().clone();
    let mut entries = Vec::new();
    for entry in tape {
        match entry {
            Err(error) if error.is_cut => eprintln!("cermctl: {}: cut off in its last line", path.display()),
            entry => entries.push(entry.map_err(|error| wrong(&error))?),
        }
    }
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let mut rows = Vec::new();
    for (channel, r_ohm) in known(&header, &arguments.truth)? {
        for method in methods(&header, &arguments.method) {
            let found = replayed(&header, &entries, method, channel, r_ohm).map_err(|why| wrong(&why))?;
            let kind = header.circuit.kind;
            let r_c_ohm = [header.circuit.r_c1_ohm, header.circuit.r_c2_ohm];
            // Two channels may have equal resistors.
            let scene = format!("{name}, {}", header.channels[channel].id);
            let row = Row::asked(Source::Tape, &scene, kind, r_c_ohm, method, r_ohm);
            rows.extend(rows_of(row, &found, &entries, channel));
        }
    }
    if rows.iter().all(|row| row.rms_ohm.is_none()) {
        let method = methods(&header, &arguments.method)[0];
        return Err(wrong(&format!(
            "no number comes out of it; `cermctl estimate --method {method}` says why"
        )));
    }
    let provenance = provenance(Source::Tape, name.into_owned(), Some(ends(&header, &entries)), None);
    let mut folder = Folder::open(&arguments.out, &provenance)?;
    folder.add(rows.clone())?;
    folder.sort(&rows)?;
    Ok(folder)
}

/// What tells a tape from others of its name: its header, its first discharge and its last, as far as it goes.
fn ends(header: &Header, entries: &[Entry]) -> String {
    let header = serde_json::to_string_pretty(header).unwrap_or_default();
    let [first, last] = [entries.first(), entries.last()].map(|entry| format!("{entry:?}"));
    format!("{header}\n{} discharges\n{first}\n{last}\n", entries.len())
}

/// The channels by their place, with their resistors.
fn known(header: &Header, truth: &[(String, f64)]) -> Result<Vec<(usize, f64)>, CtlError> {
    let ids: Vec<String> = header.channels.iter().map(|channel| channel.id.clone()).collect();
    let place = |id: &String| ids.iter().position(|known| known == id);
    let of =
        |(id, r_ohm): &(String, f64)| Ok((place(id).ok_or_else(|| CtlError::no_channel(id, &ids))?, *r_ohm));
    // Which of two is right nobody knows.
    let twice = truth
        .iter()
        .enumerate()
        .find(|(index, (id, _))| truth[..*index].iter().any(|(other, _)| other == id));
    if let Some((_, (id, _))) = twice {
        return Err(CtlError::Said(format!("--truth names {id} twice: one resistor for each channel")));
    }
    truth.iter().map(of).collect()
}

/// As asked for, or all that work on the circuit.
fn methods(header: &Header, asked: &[Method]) -> Vec<Method> {
    if asked.is_empty() { Method::on(header.circuit.kind).collect() } else { asked.to_vec() }
}

fn replayed(
    header: &Header,
    entries: &[Entry],
    method: Method,
    channel: usize,
    r_ohm: f64,
) -> Result<Found, String> {
    let mut replay = Replay::new(header, method, None)?;
    let mut found = Found::default();
    for entry in entries {
        let reading = replay.read(entry).filter(|reading| reading.channel == channel);
        found.told.extend(reading.map(|reading| observed(&reading, r_ohm, None)));
    }
    // Where d is needed and the tape does not tell it, this method has nothing to say.
    if replay.has_no_offset() {
        return Ok(Found::default());
    }
    // As an instrument is watched, where the tape is long enough.
    let settled = found.told.first().map(|first| first.at + WARM);
    let is_long = found.told.last().zip(settled).is_some_and(|(last, settled)| last.at > settled + WARM);
    if is_long {
        found.told.retain(|told| Some(told.at) >= settled);
    }
    Ok(found)
}

/// Single readings, and means over as long as the tape allows.
fn rows_of(row: Row, found: &Found, entries: &[Entry], channel: usize) -> Vec<Row> {
    if found.told.is_empty() {
        return Vec::new();
    }
    let timed = |row: Row, length: Option<f64>| Row { published_s: length, ..row };
    let of_sensor = || entries.iter().filter(|entry| entry.record.through.channel() == Some(channel));
    let discharges: Vec<f64> = of_sensor()
        .filter_map(|entry| entry.record.crossings().into_iter().flatten().reduce(f64::max))
        .collect();
    let discharge_ns = mean(&discharges).unwrap_or(0.0);
    let [first, last] = [found.told[0].at, found.told[found.told.len() - 1].at];
    let whole_s = (last - first).as_seconds();
    let each_s = whole_s / (found.told.len() as f64 - 1.0).max(1.0);
    let is_timed = entries.iter().all(|entry| entry.is_timed) && whole_s > 0.0;
    let single = filled(row.clone(), std::slice::from_ref(found), false);
    let single = timed(single, is_timed.then(|| rounded(each_s, 6)));
    let mut rows = vec![Row { discharge_s: Some(rounded(discharge_ns * 1e-9, 6)), ..single }];
    for average in AVERAGES {
        let length_s = average.as_seconds();
        if is_timed && length_s > TAPE_BLOCKS as f64 * each_s && length_s * TAPE_BLOCKS as f64 <= whole_s {
            let means = blocks(found, Nanos::from_seconds(length_s));
            let row = Row { average_s: Some(length_s), ..row.clone() };
            rows.push(timed(filled(row, &[means], false), Some(length_s)));
        }
    }
    rows
}
