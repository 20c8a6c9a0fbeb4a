//! What `demo`, `watch`, `get`, `stats` and `check` show in narrow, usual and wide windows: the demo's board in virtual time.

use super::cli::{Demo, ForceUnitArg};
use super::demo::board::Board;
use super::demo::introduction;
use super::demo::summary::Tally;
use super::limits::HISTORY_S;
use super::panel::Panel;
use super::terminal::{cut, wrapped};
use super::{check, line, stats};
use crate::daemon::publish::{self, Known};
use crate::instrument::{Instrument, Message};
use crate::pins::Pins;
use crate::stream::wire::{
    ChannelInfo, ReadingLine, ReadingTally, ServerMessage, StateLine, StatsLine, Unit, VersionLine,
};
use crate::units::{ForceUnit, Nanos};
use console::{measure_text_width, strip_ansi_codes};
use jiff::Timestamp;
use std::collections::BTreeMap;
use std::path::Path;

const WIDTHS: [usize; 3] = [40, 80, 200];
/// Of the demo.
const SECONDS: f64 = 8.0;

/// Lines that stay, then lines that are rewritten in place, as windows of each width show them.
fn windows(said: &[String], drawn: impl Fn(usize) -> Vec<String>) -> String {
    let window = |width: usize| {
        let said = said.iter().map(|line| wrapped(line, width));
        let drawn = drawn(width).into_iter().map(|line| cut(&line, width, true));
        let text =
            said.chain(drawn).map(|line| strip_ansi_codes(&line).into_owned() + "\n").collect::<String>();
        for line in text.lines() {
            assert!(measure_text_width(line) <= width, "wider than {width}: {line}");
        }
        let lines: Vec<&str> = text.lines().map(str::trim_end).collect();
        format!("{:-<width$}\n{}", format!("{width} columns "), lines.join("\n"))
    };
    WIDTHS.map(window).join("\n")
}

fn said(text: &str) -> String {
    windows(&text.lines().map(str::to_owned).collect::<Vec<_>>(), |_| Vec::new())
}

/// What the demo's board says in virtual time.
struct Run {
    arguments: Demo,
    board: Board,
    readings: Vec<ReadingLine>,
    stats: StatsLine,
}

impl Run {
    fn new() -> Run {
        let arguments = Demo {
            scene: "pi4".to_owned(),
            seconds: SECONDS,
            seed: Some(1),
            method: None,
            compare: false,
            wiring: None,
            shown: ForceUnitArg { unit: ForceUnit::Newton },
        };
        let board = Board::new(&arguments, Path::new("socket")).unwrap();
        let mut instrument = Instrument::new(board.simulation(), board.config.settings().unwrap());
        let (noon, mut readings) = (Timestamp::from_second(1_795_348_800).unwrap(), Vec::new());
        while instrument.pins().now() < Nanos::from_seconds(SECONDS) {
            let mut take = |message| {
                if let Message::Reading(reading) = message {
                    let time = noon.as_nanosecond() + i128::from(reading.at.0);
                    let time = Timestamp::from_nanosecond(time).unwrap().to_string();
                    readings.push(ReadingLine::new(&reading, "thumb", &Unit::Newton, time));
                }
            };
            instrument.step(&mut take).unwrap();
        }
        let mut known = Known::default();
        known.stats = instrument.stats();
        let instrument = publish::stats(&known, &board.config, instrument.pins().now());
        let published = readings.len() as u64;
        let mut tally = ReadingTally::default();
        readings.iter().for_each(|reading| tally.add_line(reading));
        let channels = [("thumb".to_owned(), tally.stats())].into();
        Run {
            arguments,
            board,
            readings,
            stats: StatsLine { clients: 1, published, lost: 0, channels, instrument },
        }
    }

    /// After all readings, or those up to a time.
    fn panel(&self, seconds: f64) -> Panel {
        let info = ChannelInfo { id: "thumb".to_owned(), unit: Unit::Newton, trigger: false };
        let mut panel = Panel::new([&info].into_iter(), ForceUnit::Newton, true);
        let until = Nanos::from_seconds(seconds).0;
        self.readings
            .iter()
            .filter(|reading| reading.t_mono_ns < until)
            .for_each(|reading| panel.feed(reading));
        panel
    }
}

/// Live lines, as `watch` and `demo` draw them.
fn live(panel: &Panel, width: usize) -> Vec<String> {
    panel.lines(width).into_iter().chain(panel.history(HISTORY_S.min(SECONDS), width)).collect()
}

#[test]
fn the_demo() {
    let run = Run::new();
    let mut tally = Tally::new(&run.board, run.board.simulation());
    run.readings.iter().for_each(|reading| tally.add(reading));
    let introduction = introduction(&run.board, &run.arguments);
    let during = windows(&introduction, |width| live(&run.panel(4.2), width));
    insta::assert_snapshot!(
        "demo",
        during + "\n" + &windows(&tally.summary(&run.stats, true), |_| Vec::new())
    );
}

#[test]
fn the_last_readings() {
    let run = Run::new();
    let plain = |seconds| run.panel(seconds).plain("thumb").unwrap();
    insta::assert_snapshot!("get", said(&[plain(0.4), plain(4.2), plain(7.5)].join("\n")));
}

/// The samples of the pages are what the programs print of the demo's board, word for word; UPDATE_DOCS=1 puts them there.
#[test]
fn the_samples_of_the_pages() {
    let run = Run::new();
    let info = ChannelInfo { id: "thumb".to_owned(), unit: Unit::Newton, trigger: false };
    let at_rest = |reading: &&ReadingLine| {
        let StateLine { r_ohm, moving, settling, .. } = reading.state;
        !moving && !settling && r_ohm.is_some_and(|r_ohm| r_ohm < 2000.0)
    };
    let reading = run.readings.iter().filter(at_rest).nth(50).unwrap();
    let mut panel = Panel::new([&info].into_iter(), ForceUnit::Newton, true);
    panel.feed(reading);
    let get = panel.plain("thumb").unwrap() + "\n";
    let stream = line(&VersionLine::new(&[info])) + &line(reading);
    for (page, samples) in [
        ("README.md", [get.as_str()].as_slice()),
        ("docs/overview.md", &[&get, &stream]),
        ("docs/protocol.md", &[&stream]),
    ] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(page);
        let mut text = std::fs::read_to_string(&path).unwrap();
        for wanted in samples.iter().flat_map(|sample| sample.lines()) {
            if std::env::var_os("UPDATE_DOCS").is_some() {
                // The class, or the hour, says which line it is.
                let same = if wanted.starts_with('{') { 15 } else { 7 };
                let old =
                    text.lines().find(|line| line.get(..same) == wanted.get(..same)).unwrap().to_owned();
                text = text.replacen(&old, wanted, 1);
                std::fs::write(&path, &text).unwrap();
            }
            assert!(text.lines().any(|line| line == wanted), "{page} lacks a line of:\n{get}{stream}");
        }
    }
}

#[test]
fn the_statistics() {
    insta::assert_snapshot!("stats", said(&stats::table(&line(&Run::new().stats), &BTreeMap::new(), true)));
}

/// Of the shipped configuration, with what is to be expected of it; no line is touched.
#[test]
fn the_check() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("hw/cermd.toml");
    let report = check::check(&path).to_string().replace(path.to_str().unwrap(), "/etc/cermd/cermd.toml");
    insta::assert_snapshot!("check", said(&report));
}

/// Each state, on channels with names that are hard to fit in.
#[test]
fn the_live_lines() {
    let states = [
        ("thumb", Unit::Newton, r#""status":"ok","r_ohm":2669.2,"r_u_ohm":2.5,"f_n":5.0,"f_u_n":0.39"#),
        ("\u{1f469}\u{200d}\u{1f680}", Unit::Newton, r#""status":"open","r_min_ohm":63000.0,"f_max_n":0.21"#),
        (
            "the-left-foot-below-the-heel",
            Unit::Ohm,
            r#""status":"ok","r_ohm":284134,"r_u_ohm":312,"settling":true"#,
        ),
        ("middle", Unit::Newton, r#""status":"short","r_max_ohm":0.9,"f_min_n":14800"#),
        (
            "ring",
            Unit::Newton,
            r#""status":"fault","fault":"no-calibration","hint":"nothing falls in a discharge through Rc1; look at the wire from sink-c1 through Rc1 to node A""#,
        ),
    ];
    let channels =
        states.clone().map(|(id, unit, _)| ChannelInfo { id: id.to_owned(), unit, trigger: false });
    let mut panel = Panel::new(channels.iter(), ForceUnit::Newton, true);
    for (at_ms, (id, _, rest)) in (0..10).flat_map(|step| states.clone().map(|state| (100 * step, state))) {
        let text = format!(
            r#"{{"class":"READING","channel":"{id}","seq":1,"time":"2026-11-22T12:00:00.000000000Z","t_mono_ns":{},{rest},"lost":0}}"#,
            1_000_000 * at_ms
        );
        let ServerMessage::Reading(reading) = ServerMessage::parse(text.as_bytes()).unwrap() else {
            panic!()
        };
        panel.feed(&reading);
    }
    insta::assert_snapshot!("watch", windows(&[], |width| live(&panel, width)));
}
