//! What holds of any input, however hostile. Each function takes the bytes of one input, and panics if it does not hold; beside
//! that, it has to end soon. The inputs come from tests/fuzz/main.rs, and in fuzz/ from libFuzzer.

use super::hostile::Hostile;
use cermd::circuit::{Kind, Node};
use cermd::config::{Config, ForceSource, LawSource, pairs};
use cermd::ctl::replay::Replay;
use cermd::instrument::discharge::{Charge, Plan, run};
use cermd::instrument::settings::Settings;
use cermd::instrument::{Instrument, Message};
use cermd::pins::Drives;
use cermd::pins::sim::{Scene, SimPins};
use cermd::reading::{Measured, Method, Status};
use cermd::record::Through;
use cermd::sensor::pt1000::Pt1000;
use cermd::sensor::{Law, Table, Transducer};
use cermd::stream::tape::Reader;
use cermd::stream::wire::{LineSplitter, Request};
use cermd::units::Nanos;
use std::path::Path;
use std::sync::LazyLock;

/// A target, and its name in fuzz/corpus.
pub type Target = (&'static str, fn(&[u8]));

pub const ALL: [Target; 6] = [
    ("configuration", configuration),
    ("scene", scene),
    ("force-table", force_table),
    ("tape", tape),
    ("requests", requests),
    ("events", events),
];

/// A text that parses is checked; what passes its check can be measured with.
pub fn configuration(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let Ok(mut config) = Config::parse(text, "fuzz") else { return };
    let findings = config.check();
    findings.0.iter().for_each(|finding| drop(finding.to_string()));
    if findings.has_errors() {
        return;
    }
    for trigger in config.triggers().expect("it has passed its check") {
        let (rules, is_wanted) = (trigger.rules, config.channels[trigger.channel].levels().is_some());
        assert!(
            is_wanted && rules.on.is_finite() && rules.off.is_finite() && rules.on != rules.off,
            "{rules:?}"
        );
    }
    // No file of this machine is an input.
    for force in config.channels.iter_mut().filter_map(|channel| channel.force.as_mut()) {
        if matches!(force.law, ForceSource::File(_)) {
            force.law = ForceSource::Given(Law::Alpha { alpha_n_ohm: 1.0 });
        }
    }
    for law in config.channels.iter_mut().filter_map(|channel| channel.law.as_mut()) {
        if matches!(law, LawSource::File { .. }) {
            *law = LawSource::Given(Transducer::Pt1000(Pt1000 { class: None }));
        }
    }
    let settings = config.settings().expect("it has passed its check");
    for channel in &settings.channels {
        for r_ohm in [0.0, 1.0, 1e3, 1e6, 1e12] {
            let shown = channel.value_at(Measured { value: r_ohm, u: Some(1.0) }, settings.r_ohm());
            assert!(shown.is_none_or(|shown| shown.value.is_finite()), "{channel:?} {shown:?}");
        }
    }
    assert!(settings.deadline > Nanos::ZERO && settings.charge.anew.time() > Nanos::ZERO, "{settings:?}");
    let [r_1, r_2] = settings.r_ohm();
    assert!(0.0 < r_1 && r_1 < r_2 && r_2.is_finite(), "{settings:?}");
}

/// A scene that is accepted can be discharged, without two outputs against each other.
pub fn scene(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let Ok(scene) = Scene::parse(text, Path::new("/nowhere/fuzz.toml")) else { return };
    let mut pins = SimPins::new(&scene, Some(1));
    let two = scene.circuit.kind == Kind::TwoCapacitor;
    let (last, chargers) = if two { (Node::B, Drives::CHARGE) } else { (Node::A, Drives::CHARGE_A) };
    for through in [Through::C1, Through::X(0)] {
        let charge = Charge::alone(Nanos(1_000_000));
        let plan = Plan { chargers, ..Plan::full(through, last, charge, Nanos(20_000_000)) };
        // A sensor that is not there is a refusal.
        let _ = run(&mut pins, plan);
        assert_eq!(pins.conflicts(), 0);
    }
}

/// A table that is accepted gives finite forces, the smaller the greater the resistance.
pub fn force_table(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let Ok(pairs) = pairs::of_csv(text, "fuzz") else { return };
    let pairs: Vec<_> = pairs.iter().map(|pair| (pair.r_ohm, pair.f_n)).collect();
    let Ok(table) = Table::try_from(pairs) else { return };
    let known = [470.0, 12_700.0];
    let sorted = Vec::from(table.clone());
    let (least, most) = (sorted[0].0, sorted[sorted.len() - 1].0);
    let force = cermd::sensor::Force { law: Law::Table { table }, u: None, range_n: None, tare_n: None };
    let mut before = f64::INFINITY;
    for step in 0..=20 {
        let r_ohm = least * (most / least).powf(f64::from(step) / 20.0);
        let Some(f_n) = force.at_bound(r_ohm, known) else { continue };
        assert!(f_n.is_finite() && f_n > 0.0, "{f_n} N at {r_ohm} ohm");
        assert!(f_n <= before * (1.0 + 1e-9), "{f_n} N at {r_ohm} ohm after {before} N");
        before = f_n;
    }
}

/// A tape is estimated to its end or its first bad line, by each method of its circuit.
pub fn tape(data: &[u8]) {
    for method in Method::ALL {
        let Ok(reader) = Reader::open(data) else { return };
        let Ok(mut replay) = Replay::new(reader.header(), method, None) else { continue };
        for entry in reader.map_while(Result::ok) {
            let Some(estimate) = replay.take(&entry) else { continue };
            let (r_ohm, u_ohm) = (estimate.state.r_ohm, estimate.state.r_u_ohm);
            assert!(r_ohm.is_none_or(f64::is_finite) && u_ohm.is_none_or(|u| u >= 0.0), "{estimate:?}");
        }
    }
}

/// However the kernel cuts the bytes, the lines are the same; every one has an answer, and that is short.
pub fn requests(data: &[u8]) {
    let lines = |step: usize| {
        let (mut splitter, mut lines) = (LineSplitter::default(), Vec::new());
        for chunk in data.chunks(step) {
            splitter.feed(chunk);
            lines.extend(std::iter::from_fn(|| splitter.next_line()));
        }
        lines
    };
    let whole = lines(usize::MAX);
    assert_eq!(whole, lines(1));
    for line in whole {
        let line = line.as_ref().map(Vec::as_slice).map_err(|&error| error);
        match Request::parse(line) {
            Ok(request) => {
                // A rate is rounded when it is written; after that it stays.
                let written = request.to_line();
                let again = Request::parse(Ok(&written[..written.len() - 1])).unwrap();
                assert_eq!(again.to_line(), written);
            }
            Err(refusal) => {
                let answer = serde_json::to_vec(&refusal).unwrap();
                assert!(answer.len() < 1000, "{} bytes", answer.len());
            }
        }
    }
}

/// One for each method on each circuit.
static SETTINGS: LazyLock<Vec<Settings>> = LazyLock::new(|| {
    let circuits = [
        (Kind::TwoCapacitor, "c-a = \"2.2 uF\"\nc-b = \"680 nF\""),
        (Kind::OneCapacitor, "c = \"470 nF\""),
        (Kind::SeriesCalibration, "c = \"470 nF\""),
    ];
    let settings = |kind: Kind, parts: &str, method: Method| {
        let text = format!(
            "[circuit]\nkind = \"{kind}\"\n{parts}\nr-c1 = \"470 ohm\"\nr-c2 = \"12.7 kohm\"\nv-th = \"1.1 V\"\n\
             [measure]\nmethod = \"{method}\"\n[[channel]]\nid = \"x\"\n[[channel]]\nid = \"y\"\nevery = 3\n\
             [mock]\nscene = \"pi4\"\n"
        );
        Config::parse(&text, "events").unwrap().settings().unwrap()
    };
    let of_kind = |(kind, parts)| Method::on(kind).map(move |method| settings(kind, parts, method));
    circuits.into_iter().flat_map(of_kind).collect()
});

/// Whatever pins answer, the instrument asks for no two outputs against each other, and what it calls a number is one.
pub fn events(data: &[u8]) {
    numbers(data);
}

/// The same; how many readings are numbers.
pub fn numbers(data: &[u8]) -> usize {
    let mut numbers = 0;
    let Some((first, data)) = data.split_first() else { return numbers };
    let settings = SETTINGS[usize::from(*first) % SETTINGS.len()].clone();
    let mut instrument = Instrument::new(Hostile::new(data), settings);
    while !instrument.pins().is_over() {
        // What goes wrong is reported, and the next step begins anew.
        let _ = instrument.step(&mut |message| {
            let Message::Reading(reading) = message else { return };
            if let Status::Ok { r_ohm, .. } = reading.status {
                let u_is_sound = r_ohm.u.is_none_or(|u| u.is_finite() && u > 0.0);
                assert!(r_ohm.value.is_finite() && u_is_sound, "{reading:?}");
                numbers += 1;
            }
        });
    }
    assert_eq!(instrument.pins().conflicts(), 0);
    numbers
}
