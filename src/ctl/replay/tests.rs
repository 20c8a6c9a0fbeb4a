//! A tape is read as the instrument has read it: the same states, numbers and uncertainties.

use super::*;
use crate::config::{Config, tape_header};
use crate::instrument::{Instrument, Message};
use crate::pins::sim::{Scene, SimPins};
use crate::stream::tape::Reader;
use crate::stream::wire::{StatusName, Unit};

pub(super) fn config(kind: &str, method: &str) -> Config {
    let capacitors =
        if kind == "two-capacitor" { "c-a = \"2.2 uF\"\nc-b = \"680 nF\"" } else { "c = \"470 nF\"" };
    let text = format!(
        "[circuit]\nkind = \"{kind}\"\n{capacitors}\nr-c1 = \"470 ohm\"\nr-c2 = \"12.7 kohm\"\n[measure]\n{method}\n\
         [[channel]]\nid = \"thumb\"\nzero-ohm = 1.5\nforce = {{ alpha = \"13346 N ohm\" }}\n[[channel]]\nid = \"index\"\n"
    );
    Config::parse(&text, "test").unwrap()
}

/// The readings of a simulated instrument that have a discharge, as they are published, and its tape.
fn measured(kind: &str, method: &str, cycles: u64) -> (Vec<(i64, StateLine)>, String) {
    let config = config(kind, method);
    let settings = config.settings().unwrap();
    let scene = Scene::builtin("pi4").unwrap();
    let hand = crate::pins::sim::Sensor::Hand {
        alpha: crate::units::NewtonOhm(13_346.0),
        peak: crate::units::Newton(10.0),
        period: crate::units::Seconds(3.0),
    };
    let still = crate::pins::sim::Sensor::Constant(crate::units::Ohm(50.0));
    let scene = scene.with_sensors(vec![hand, still]).unwrap().with_kind(config.circuit.kind()).unwrap();
    let header = tape_header(&settings, None);
    let mut tape = vec![serde_json::to_string(&header).unwrap()];
    let mut readings = Vec::new();
    let mut instrument = Instrument::new(SimPins::new(&scene, Some(crate::seed::seed(1))), settings.clone());
    while instrument.stats().cycles < cycles {
        let mut has_record = false;
        instrument
            .step(&mut |message| match message {
                Message::Discharge { seq, record, is_held, .. } => {
                    has_record = record.through.channel().is_some();
                    tape.push(serde_json::to_string(&header.discharge(seq, &record, is_held)).unwrap());
                }
                Message::Reading(reading) if has_record => {
                    let unit = Unit::named(settings.channels[reading.channel].unit());
                    let mut state = StateLine::new(&reading.status, reading.method, &unit);
                    state.method = Some(reading.method.to_string());
                    readings.push((reading.at.0, state));
                }
                Message::Reading(_) => {}
            })
            .unwrap();
    }
    (readings, tape.join("\n") + "\n")
}

pub(super) fn replayed(tape: &str, method: Method) -> Vec<EstimateLine> {
    let tape = Reader::open(tape.as_bytes()).unwrap();
    let mut replay = Replay::new(tape.header(), method, None).unwrap();
    tape.filter_map(|entry| replay.take(&entry.unwrap())).collect()
}

/// By how much two numbers differ, relative; 0 if neither is there.
#[track_caller]
fn apart(a: Option<f64>, b: Option<f64>) -> f64 {
    match (a, b) {
        (Some(a), Some(b)) => (a / b - 1.0).abs(),
        (None, None) => 0.0,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_tape_tells_what_the_instrument_has_told() {
    for (kind, method) in [
        ("two-capacitor", "method = \"cerm\""),
        ("two-capacitor", "method = \"tcdic\""),
        ("two-capacitor", "method = \"tracked\""),
        ("two-capacitor", "method = \"cerm\"\ncalibration = \"tracked\""),
        ("one-capacitor", "method = \"tpcm\""),
        ("series-calibration", "method = \"qerm\""),
    ] {
        let (readings, tape) = measured(kind, method, 400);
        let name = method.split('"').nth(1).unwrap();
        let method = *Method::ALL.iter().find(|method| method.as_str() == name).unwrap();
        let estimates = replayed(&tape, method);
        assert_eq!(readings.len(), estimates.len(), "{name}");
        let mut states = std::collections::BTreeMap::new();
        let mut turned = 0;
        for ((at, read), EstimateLine { t_mono_ns, state, .. }) in readings.iter().zip(&estimates) {
            // Before the first look for a leak is over, which the tape tells as it comes, there is nothing to compare.
            if *at < 3_000_000_000 {
                continue;
            }
            // Where two crossings are weighted, by a middle that the rounded uncertainties of the tape move.
            assert!((t_mono_ns.unwrap() - at).abs() <= 50_000, "{name}: {read:?} {state:?}");
            assert_eq!((read.status, &read.fault, &read.branch), (state.status, &state.fault, &state.branch));
            // Of a tracked calibration, the instrument knows a few ms earlier how it has walked.
            let u = read.r_u_ohm.zip(read.r_ohm).map_or(1e-4, |(u, r_ohm)| u / r_ohm);
            assert!(apart(read.r_ohm, state.r_ohm) < 0.03 * u, "{name}: {read:?} {state:?}");
            assert!(apart(read.f_n, state.f_n) < 0.03 * u, "{name}: {read:?} {state:?}");
            // Beyond its noise or within is decided at an edge, which the rounded numbers of a tape may turn.
            if read.moving != state.moving {
                turned += 1;
                continue;
            }
            for (read, again) in
                [(read.r_u_ohm, state.r_u_ohm), (read.f_u_n, state.f_u_n), (read.r_min_ohm, state.r_min_ohm)]
            {
                assert!(apart(read, again) < 0.02, "{name}: {read:?} {again:?}");
            }
            let of_state = match read.status {
                StatusName::Ok => "ok",
                StatusName::Open => "open",
                StatusName::Short => "short",
                StatusName::Fault => "fault",
            };
            *states.entry(of_state).or_insert(0) += 1;
        }
        assert!(turned <= 1, "{name}: {turned}");
        // Both are there to be compared: the hand lifts off for a part of the time that differs.
        let ok = states.get("ok").copied().unwrap_or(0);
        assert!(2 * ok > readings.len() && states.contains_key("open"), "{name}: {states:?}");
    }
}

#[test]
fn a_switch_of_unknown_uncertainty_is_not_taken_for_exact() {
    let (_, tape) = measured("two-capacitor", "method = \"cerm\"\nt-l = \"1 ms\"", 1000);
    let (read, unsaid) = (replayed(&tape, Method::Cerm), tape.lines().map(without_u).collect::<String>());
    let estimates = replayed(&unsaid, Method::Cerm);
    let inferred = |estimates: &[EstimateLine]| -> Vec<f64> {
        let of = estimates.iter().filter(|one| one.state.branch.as_deref() == Some("inferred"));
        of.filter_map(|one| one.state.r_u_ohm).collect()
    };
    let (with, without) = (inferred(&read), inferred(&estimates));
    assert!(without.len() > 100 && with.len() == without.len(), "{} {}", with.len(), without.len());
    let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len() as f64;
    // The scatter of the switches is on the tape; what they have in common is not.
    assert!(mean(&without) > 0.5 * mean(&with), "{} {}", mean(&with), mean(&without));
}

fn without_u(line: &str) -> String {
    let (begin, rest) = line.split_once(",\"u_ns\":").unwrap_or((line, "}"));
    let end = rest.find('}').unwrap_or(0);
    if begin == line { format!("{line}\n") } else { format!("{begin}{}\n", &rest[end..]) }
}

#[test]
fn a_tape_may_end_in_the_middle_of_a_line() {
    let (_, tape) = measured("two-capacitor", "method = \"tcdic\"", 20);
    let whole: Vec<EstimateLine> = replayed(&tape, Method::Tcdic);
    let mut cut = Reader::open(&tape.as_bytes()[..tape.len() - 20]).unwrap();
    let entries: Vec<_> = cut.by_ref().collect();
    let (last, rest) = entries.split_last().unwrap();
    assert!(last.as_ref().is_err_and(|error| error.is_cut), "{last:?}");
    assert!(rest.iter().all(Result::is_ok) && whole.len() <= rest.len());
    // In the middle of a tape, the same is an error.
    let broken = tape.replacen("\"a_ns\":", "\"a_ns", 1);
    let error = Reader::open(broken.as_bytes()).unwrap().find_map(Result::err).unwrap();
    assert!(!error.is_cut && error.line == 2, "{error:?}");
}

#[test]
fn no_number_of_a_tape_is_longer_than_it_is_good_for() {
    let (_, tape) = measured("two-capacitor", "method = \"cerm\"", 100);
    let digits = |number: &str| number.chars().filter(char::is_ascii_digit).count();
    for number in tape.split(|c: char| !c.is_ascii_digit() && c != '.').filter(|number| number.contains('.'))
    {
        assert!(number.split('.').nth(1).unwrap().len() <= 5 && digits(number) <= 13, "{number}");
    }
}

/// As one that begins between the first rounds of the daemon and the offset.
#[test]
fn what_is_switched_before_the_offset_is_known_is_a_state_and_the_tape_goes_on() {
    let (_, tape) = measured("two-capacitor", "method = \"cerm\"", 200);
    let (header, lines) = tape.split_once('\n').unwrap();
    let first = lines.lines().position(|line| line.contains("\"through\":\"x\",\"switch\"")).unwrap();
    let rest = |skipped: usize| -> String {
        let of = |line: &str| !line.contains("\"held\"") && !line.contains("\"through\":\"c1\",\"switch\"");
        let (begin, end): (Vec<_>, Vec<_>) =
            lines.lines().enumerate().partition(|(index, _)| *index < skipped);
        let begin = begin.into_iter().map(|(_, line)| line).filter(|line| of(line));
        let end = end.into_iter().map(|(_, line)| line);
        [header].into_iter().chain(begin).chain(end).map(|line| format!("{line}\n")).collect()
    };
    let all = |tape: &str| {
        let reader = Reader::open(tape.as_bytes()).unwrap();
        let mut replay = Replay::new(reader.header(), Method::Cerm, None).unwrap();
        let states: Vec<_> = reader.filter_map(|entry| replay.take(&entry.unwrap())).collect();
        let (ok, none): (Vec<_>, Vec<_>) =
            states.into_iter().map(|line| line.state).partition(|state| state.r_ohm.is_some());
        let fault = |fault: &str| none.iter().filter(|state| state.fault.as_deref() == Some(fault)).count();
        (ok.len(), fault("no-calibration"), replay.missed())
    };
    // Without any split discharge up to the tenth that was switched.
    let (ok, lacking, missed) = all(&rest(first + 60));
    assert!(ok > 50 && lacking > 5 && missed.is_none(), "{ok} {lacking} {missed:?}");
    // Of those alone that are switched, there is no number at all.
    let switched = |line: &&str| {
        !line.contains("\"held\"") && (!line.contains("\"through\":\"x\"") || line.contains("switch"))
    };
    let none: String = rest(usize::MAX).lines().filter(switched).map(|line| format!("{line}\n")).collect();
    let (ok, lacking, missed) = all(&none);
    assert!(ok == 0 && lacking > 50, "{ok} {lacking}");
    assert!(missed.is_some_and(|missed| missed.starts_with("cerm needs the latency offset")));
}
