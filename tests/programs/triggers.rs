//! Triggers as programs and hardware behind a line see them: the real daemon, a simulated hand that presses, a simulated output.

use crate::common::Bench;
use crate::common::config::ConfigFile;
use crate::daemon::process::{Home, Stream, config};
use crate::waiting::until_so;
use cermd::instrument::{Instrument, Message};
use cermd::pins::Pins;
use cermd::pins::sim::{Sensor, SimPins};
use cermd::reading::{Method, Reading};
use cermd::trigger::{Event, State, Trigger, Why};
use cermd::units::{Nanos, Ohm, Seconds};
use nix::sys::signal::Signal;
use serde_json::{Value, json};
use std::fs;

/// 2 N are 6673 ohm.
const KEYS: &str = r#"
    force = { alpha = "13346 N ohm" }
    on-above = "2 N"
    off-below = "1.5 N"
    hold = "5 ms"
    output = { line = "GPIO17" }
"#;

/// Presses of 0.2 s, from 0.67 N to 13 N within a millisecond, one each 0.5 s.
fn pressing(home: &Home) {
    let row = |t: f64, ohm: u32| format!("{t},{ohm}\n");
    let presses = (0..200).map(|n| {
        let t = 0.5 * f64::from(n + 1);
        [row(t, 20_000), row(t + 0.001, 1000), row(t + 0.2, 1000), row(t + 0.201, 20_000)].concat()
    });
    fs::write(home.path().join("press.csv"), "time_s,ohm\n".to_owned() + &presses.collect::<String>())
        .unwrap();
    let mut scene = ConfigFile::of(&fs::read_to_string(home.path().join("fast.toml")).unwrap());
    scene.unset(&["sensor"]).sensor("1 kohm").unset(&["sensor.0.constant"]);
    scene.lines("sensor.0", "file = { path = \"press.csv\" }");
    fs::write(home.path().join("fast.toml"), scene.to_string()).unwrap();
}

fn home() -> Home {
    let home = Home::new(config(&["thumb"], "offset = \"8 us\"").lines("channel.thumb", KEYS));
    pressing(&home);
    home
}

/// What the output did so far.
fn levels(home: &Home) -> Vec<&'static str> {
    let log = home.log();
    let lines = log.lines().filter_map(|line| line.split("simulated output GPIO17: ").nth(1));
    lines.map(|level| if level == "active" { "active" } else { "inactive" }).collect()
}

/// The next event that a number has brought: on a busy machine a number may come late.
fn next(stream: &mut Stream) -> Value {
    loop {
        let event = stream.next_of("EVENT");
        if event.get("reason").is_none() {
            return event;
        }
    }
}

#[test]
fn presses_are_events_and_move_the_output() {
    let home = home();
    let daemon = home.start();
    let mut stream = home.connect();
    assert_eq!(stream.next().unwrap()["channels"], json!([{"id": "thumb", "unit": "N", "trigger": true}]));
    let events: Vec<Value> = (0..9).map(|_| next(&mut stream)).collect();
    // Untouched first; then by turns, unless the machine was so busy that between two there was nothing.
    assert_eq!(events[0]["event"], "released");
    let pressed = events.iter().filter(|event| event["event"] == "pressed").count();
    assert!((2..=4).contains(&pressed), "{events:#?}");
    assert!(levels(&home).iter().filter(|level| **level == "active").count() >= pressed);
    // Who comes late knows at once.
    let mut late = home.connect();
    assert_eq!(late.next().unwrap()["class"], "VERSION");
    let first = late.next().unwrap();
    assert_eq!((&first["class"], &first["channel"]), (&json!("EVENT"), &json!("thumb")));
    daemon.signal(Signal::SIGTERM);
    assert_eq!(daemon.end().code(), Some(0));
    assert_eq!(levels(&home).last(), Some(&"inactive"), "at the end");
}

/// An event comes after its reading, which is beyond the threshold.
#[test]
fn an_event_follows_a_reading_that_says_so() {
    let home = home();
    let _daemon = home.start();
    let mut stream = home.connect();
    // What was so before is told first.
    let (mut readings, mut pressed) = (vec![stream.next_of("READING")], 0);
    while pressed < 3 {
        let line = stream.next().unwrap();
        match line["class"].as_str() {
            Some("READING") => readings.push(line),
            Some("EVENT") if line.get("reason").is_none() => {
                let is_it = |reading: &&Value| reading["t_mono_ns"] == line["t_mono_ns"];
                let of = readings.iter().rev().find(is_it);
                let of = of.unwrap_or_else(|| panic!("no reading of {line}"));
                let f_n = of["f_n"].as_f64().or(of["f_max_n"].as_f64()).unwrap();
                let is_pressed = line["event"] == "pressed";
                assert!(if is_pressed { f_n >= 2.0 } else { f_n < 2.0 }, "{line} by {of}");
                pressed += usize::from(is_pressed);
            }
            _ => {}
        }
    }
}

/// A slider that a hand moves from 10 % to 0.5 % of its way and back.
#[test]
fn thresholds_may_be_in_the_unit_of_a_law() {
    let home = home();
    let keys = r#"
        law = { kind = "position", r0 = "0 ohm", r1 = "200 kohm", span = "100 %", u = "0.1 %" }
        on-below = "3 %"
        off-above = "4 %"
    "#;
    home.configure(config(&["thumb"], "offset = \"8 us\"").lines("channel.thumb", keys));
    let _daemon = home.start();
    let mut stream = home.connect();
    assert_eq!(stream.next().unwrap()["channels"], json!([{"id": "thumb", "unit": "%", "trigger": true}]));
    // What was so before is told first.
    let (mut readings, mut told) = (vec![stream.next_of("READING")], Vec::new());
    while told.len() < 4 {
        let line = stream.next().unwrap();
        match line["class"].as_str() {
            Some("READING") => readings.push(line),
            Some("EVENT") if line.get("reason").is_none() => {
                let of = readings.iter().rev().find(|reading| reading["t_mono_ns"] == line["t_mono_ns"]);
                let value = of.unwrap_or_else(|| panic!("no reading of {line}"))["value"].as_f64().unwrap();
                let is_pressed = line["event"] == "pressed";
                assert!(if is_pressed { value <= 3.0 } else { value > 3.0 }, "{line} by {of:?}");
                told.push(is_pressed);
            }
            _ => {}
        }
    }
    assert!(told.contains(&true) && told.contains(&false), "{told:?}");
}

#[test]
fn an_output_may_be_active_while_released() {
    let keys = KEYS.replace("\"GPIO17\" }", "\"GPIO17\", when = \"released\" }");
    let home = Home::new(config(&["thumb"], "offset = \"8 us\"").lines("channel.thumb", &keys));
    pressing(&home);
    let daemon = home.start();
    let mut stream = home.connect();
    while next(&mut stream)["event"] != "released" {}
    until_so("the output is active", || levels(&home).contains(&"active"));
    while next(&mut stream)["event"] != "pressed" {}
    while next(&mut stream)["event"] != "released" {}
    until_so("a press has made it inactive", || {
        levels(&home).windows(3).any(|levels| levels == ["active", "inactive", "active"])
    });
    daemon.signal(Signal::SIGTERM);
    assert_eq!(daemon.end().code(), Some(0));
    assert_eq!(levels(&home).last(), Some(&"inactive"), "at the end");
}

#[test]
fn a_reload_lets_go_of_the_output() {
    let home = home();
    let daemon = home.start();
    let mut stream = home.connect();
    while next(&mut stream)["event"] != "pressed" {}
    until_so("the output is active", || levels(&home).contains(&"active"));
    home.configure(config(&["thumb"], "offset = \"8 us\""));
    daemon.signal(Signal::SIGHUP);
    let mut last = Value::Null;
    let version = loop {
        let line = stream.next().unwrap();
        match line["class"].as_str() {
            Some("VERSION") => break line,
            Some("EVENT") => last = line,
            _ => {}
        }
    };
    // Whoever heard of the last press hears that it is over, and if no reading says so, why.
    assert_eq!(last["event"], "released");
    assert_eq!(version["channels"], json!([{"id": "thumb", "unit": "ohm"}]));
    assert_eq!(levels(&home).last(), Some(&"inactive"));
    // From here on there is no trigger.
    for _ in 0..300 {
        assert_eq!(stream.next().unwrap()["class"], "READING");
    }
}

/// From a step of the sensor to the instant at which the measuring thread knows, in virtual time: quantiles for docs/triggers.md.
#[test]
fn a_press_is_known_within_what_check_promises() {
    for (measure, promised_ms) in [("", None), ("rate-hz = 20", Some(50.0))] {
        let mut latencies_ms = Vec::new();
        for seed in 0..40 {
            let mut bench = Bench::new("pi4", Method::Tracked, 20e3, seed, measure);
            bench.config.set("channel.x.on-below", "6.67 kohm");
            // After the first second, in which noise and offset are found; at any phase of a cycle.
            let at = Seconds(9.0 + 0.0137 * seed as f64);
            let step = Sensor::Step { before: Ohm(20e3), after: Ohm(1e3), at };
            bench.scene = bench.scene.with_sensors(vec![step]).unwrap();
            let config = bench.config.parse();
            let settings = config.triggers().unwrap().remove(0);
            let longest = config.longest_interval(&config.channels[0]);
            let latency = known_after(&bench, Trigger::new(settings.rules)) - Nanos::from_seconds(at.0);
            assert!(Nanos::ZERO < latency && latency < longest + longest, "{latency:?} of {longest:?}");
            latencies_ms.push(1e3 * latency.as_seconds());
        }
        latencies_ms.sort_by(f64::total_cmp);
        let [median, worst] = [latencies_ms[20], latencies_ms[39]];
        println!("{measure:12} median {median:.1} ms, worst of 40 {worst:.1} ms");
        assert!(promised_ms.is_none_or(|promised| worst < 2.0 * promised));
    }
}

/// When it is known to be pressed, in virtual time.
fn known_after(bench: &Bench, mut trigger: Trigger) -> Nanos {
    let mut instrument: Instrument<SimPins> = bench.instrument();
    let mut is_pressed = false;
    while !is_pressed {
        let mut readings: Vec<Reading> = Vec::new();
        let mut take = |message| readings.extend(reading_of(message));
        instrument.step(&mut take).unwrap();
        for event in readings.iter().filter_map(|reading| trigger.take(reading)) {
            is_pressed = event.state == State::Pressed;
        }
        assert!(instrument.pins().now() < Nanos::from_seconds(30.0), "never pressed");
    }
    instrument.pins().now()
}

fn reading_of(message: Message) -> Option<Reading> {
    match message {
        Message::Reading(reading) => Some(reading),
        Message::Discharge { .. } => None,
    }
}

/// How long a channel is silent in normal operation, in virtual time: what `stale` is by default has to be longer.
#[test]
fn nothing_is_stale_by_default_while_readings_come() {
    for measure in ["", "rate-hz = 20", "average = \"1 s\"", "rate-hz = 5\nidle = true"] {
        for r_ohm in [1e3, 20e3, 20e6] {
            let mut bench = Bench::new("pi4", Method::Tracked, r_ohm, 1, measure);
            bench.config.set("channel.x.on-below", "6.67 kohm");
            let mut trigger = Trigger::new(bench.config.parse().triggers().unwrap()[0].rules);
            let mut instrument = bench.instrument();
            let (mut known, mut lost) = (0, Vec::new());
            while instrument.pins().now() < Nanos::from_seconds(20.0) {
                let mut readings = Vec::new();
                instrument.step(&mut |message| readings.extend(reading_of(message))).unwrap();
                let now = instrument.pins().now();
                known += usize::from(trigger.look_at().is_some());
                // A reading without a number beside a look is a fault, not silence.
                let is_silence = |event: &Event| event.state == State::Unknown(Why::Stale);
                lost.extend(trigger.look(now).filter(is_silence));
                for reading in &readings {
                    let _ = trigger.take(reading);
                }
            }
            assert!(known > 0 && lost.is_empty(), "{measure}, {r_ohm} ohm: {lost:?}");
        }
    }
}
