//! Error against time for one published value: measured on a resistor of 1 kohm, single readings and the means that `average`
//! publishes, and drawn with letters.

use super::super::board::Board;
use crate::ctl::limits::{COUNTED_S, MEANS_S, REST, WARM};
use crate::instrument::settings::Settings;
use crate::instrument::{Instrument, Message};
use crate::pins::Pins;
use crate::reading::{Method, Status};
use crate::units::sample::rms;
use crate::units::{Nanos, Seconds, rounded};
use console::style;

/// The chart, in columns and rows without its margins.
const COLUMNS: usize = 54;
const ROWS: usize = 11;
/// Columns before the axis.
const MARGIN: usize = 9;

/// A method: seconds for a value, and the root mean square of its errors, ohm; the first are single readings.
pub struct Front {
    method: Method,
    points: Vec<(f64, f64)>,
}

/// Measures all; what is returned does the work.
pub fn all(boards: &[(Method, Board)]) -> impl FnOnce() -> Vec<Front> + Send + use<> {
    let resting: Vec<_> = boards
        .iter()
        .filter_map(|(method, board)| Some((*method, board.resting(REST)?, board.config.settings().ok()?)))
        .collect();
    let averages = || std::iter::once(None).chain(MEANS_S.map(|mean_s| Some(Nanos::from_seconds(mean_s))));
    move || {
        let each = resting.into_iter().map(|(method, pins, settings)| {
            let over = |average| Settings { average, ..settings.clone() };
            let measured =
                averages().map(|average| point(Instrument::new(pins.clone(), over(average)), average));
            Front { method, points: measured.flatten().collect() }
        });
        each.collect()
    }
}

/// The errors of all numbers, ohm, and how long one takes, s.
fn errors(mut instrument: Instrument<impl Pins>) -> (f64, Vec<f64>) {
    let (mut errors, mut now) = (Vec::new(), Nanos::ZERO);
    let end = WARM + Nanos::from_seconds(COUNTED_S);
    while now < end {
        let step = instrument.step(&mut |message| match message {
            Message::Reading(reading) if now > WARM => {
                if let Status::Ok { r_ohm, .. } = reading.status {
                    errors.push(r_ohm.value - REST.0);
                }
            }
            _ => {}
        });
        if step.is_err() {
            break;
        }
        now = instrument.pins().now();
    }
    (COUNTED_S / errors.len().max(1) as f64, errors)
}

/// How long a value takes, s, and the root mean square of their errors, ohm; `None` of none.
fn point(instrument: Instrument<impl Pins>, average: Option<Nanos>) -> Option<(f64, f64)> {
    let (each_s, errors) = errors(instrument);
    // One more of them may end in the time that is counted than begin.
    let each_s = average.map_or(each_s, |average| each_s.max(average.as_seconds()));
    Some((each_s, rms(errors.into_iter()).filter(|rms| *rms > 0.0)?))
}

/// The chart, and beneath it what each letter means.
pub fn lines(fronts: &[Front], width: usize, unicode: bool) -> Vec<String> {
    let columns = width.saturating_sub(MARGIN + 3).min(COLUMNS);
    let mut lines = vec![String::new()];
    match width {
        60.. => lines.push(" error (rms) at 1 kohm, over the time of one published value".to_owned()),
        _ => lines
            .extend([" error (rms) at 1 kohm,", " over the time of one published value"].map(str::to_owned)),
    }
    lines.extend(chart(fronts, columns, unicode));
    for front in fronts {
        let in_time =
            |(seconds, rms): &(f64, f64)| format!("{:>4} in {:.2}", rounded(*rms, 2), Seconds(*seconds));
        let single = front.points.first().map(in_time).unwrap_or_default();
        let mean = front.points.last().filter(|_| front.points.len() > 1).map(in_time);
        let (letter, name) = (front.method.rules().letter, front.method.as_str());
        let text = format!(" {letter} {name:<8}{single:<14} {}", mean.unwrap_or_default());
        lines.push(if front.method.is_tracked() { style(text).bold().to_string() } else { text });
    }
    lines.push(" ohm: each reading, and the longest mean".to_owned());
    lines
}

/// Both axes logarithmic, whole decades.
fn chart(fronts: &[Front], columns: usize, unicode: bool) -> Vec<String> {
    let all = || fronts.iter().flat_map(|front| front.points.iter());
    let decades = |values: &mut dyn Iterator<Item = f64>| {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value.log10()), high.max(value.log10()))
        });
        // A mean over 1 s takes a little more.
        [low.floor(), (high - 0.05).ceil().max(low.floor() + 1.0)]
    };
    let [left, right] = decades(&mut all().map(|(seconds, _)| *seconds));
    let [bottom, top] = decades(&mut all().map(|(_, rms)| *rms));
    if columns < 10 || !left.is_finite() || !bottom.is_finite() {
        return Vec::new();
    }
    let place = |value: f64, [from, to]: [f64; 2], cells: usize| {
        let share = ((value.log10() - from) / (to - from)).clamp(0.0, 1.0);
        (share * (cells - 1) as f64).round() as usize
    };
    let mut cells = vec![vec![' '; columns]; ROWS];
    for front in fronts {
        for (seconds, rms) in &front.points {
            let row = ROWS - 1 - place(*rms, [bottom, top], ROWS);
            cells[row][place(*seconds, [left, right], columns)] = front.method.rules().letter;
        }
    }
    let (wall, corner, floor) = if unicode { ('│', '└', '─') } else { ('|', '+', '-') };
    let powers = |from: f64, to: f64| (from as i32..=to as i32).map(|power| 10f64.powi(power));
    let mut labels = vec![String::new(); ROWS];
    for value in powers(bottom, top) {
        labels[ROWS - 1 - place(value, [bottom, top], ROWS)] = format!("{} ohm", rounded(value, 1));
    }
    let row = |(label, cells): (&String, &Vec<char>)| {
        format!("{label:>MARGIN$} {wall}{}", cells.iter().collect::<String>())
    };
    let mut lines: Vec<String> = labels.iter().zip(&cells).map(row).collect();
    lines.push(format!("{:MARGIN$} {corner}{}", "", floor.to_string().repeat(columns)));
    let mut axis = vec![' '; MARGIN + columns + 3];
    for value in powers(left, right) {
        let label: Vec<char> = Seconds(value).to_string().chars().collect();
        let at = MARGIN + 2 + place(value, [left, right], columns);
        let at = (at.saturating_sub(label.len() / 2)).min(axis.len() - label.len());
        axis[at..at + label.len()].copy_from_slice(&label);
    }
    lines.push(axis.into_iter().collect::<String>().trim_end().to_owned());
    lines
}
