//! docs/protocol.schema.json against what the types write, what a daemon sends, and what the pages show.
//!
//! The keywords of the schema are few: those that are read here, any other one fails.

use crate::cermctl::daemon::{Daemon, config, scene};
use crate::waiting::PATIENCE;
use cermd::circuit::Kind;
use cermd::sensor::ldr::Ldr;
use cermd::sensor::ntc::{Curve, Ntc};
use cermd::sensor::position::Position;
use cermd::sensor::pt1000::{Class, Pt1000};
use cermd::sensor::table::{Pairs, Tabled};
use cermd::sensor::{Channel, Force, Law, Transducer};
use cermd::tape::{DischargeLine, Header, Resistor, SwitchLine, TapeCircuit, TapeLooks, TapeOffset};
use cermd::wire::{
    ChannelInfo, ChannelStats, ErrorCode, ErrorLine, EventLine, EventName, InstrumentStats, ReadingLine,
    StateLine, StatsLine, StatusName, Unit, VersionLine,
};
use serde_json::{Map, Value};
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;

fn read(name: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(name)).unwrap()
}

struct Schema(Value);

impl Schema {
    fn new() -> Schema {
        Schema(serde_json::from_str(&read("docs/protocol.schema.json")).unwrap())
    }

    fn of(&self, name: &str) -> &Value {
        &self.0["$defs"][name]
    }

    /// What is wrong with a line of the server.
    fn wrong_with(&self, line: &Value) -> Vec<String> {
        self.wrong(&self.0, line, "line")
    }

    fn wrong(&self, schema: &Value, value: &Value, at: &str) -> Vec<String> {
        let mut wrong = Vec::new();
        let mut check = |is_so: bool, what: String| {
            if !is_so {
                wrong.push(format!("{at}: {value} {what}"));
            }
        };
        let mut inner = Vec::new();
        for (keyword, wanted) in schema.as_object().unwrap() {
            match keyword.as_str() {
                "$schema" | "title" | "description" | "$defs" => {}
                "type" => check(is_of(value, wanted.as_str().unwrap()), format!("is no {wanted}")),
                "const" => check(value == wanted, format!("is not {wanted}")),
                // Those of this release are all that it has.
                "enum" | "examples" => {
                    check(wanted.as_array().unwrap().contains(value), format!("is none of {wanted}"));
                }
                "minimum" => check(value.as_f64() >= wanted.as_f64(), format!("is below {wanted}")),
                "exclusiveMinimum" => {
                    check(value.as_f64() > wanted.as_f64(), format!("is not above {wanted}"))
                }
                "required" => {
                    let missing = wanted
                        .as_array()
                        .unwrap()
                        .iter()
                        .find(|key| value.get(key.as_str().unwrap()).is_none());
                    check(missing.is_none(), format!("lacks {missing:?}"));
                }
                "properties" | "additionalProperties" => {}
                "items" => {
                    let items = value.as_array().into_iter().flatten();
                    inner.extend(items.flat_map(|item| self.wrong(wanted, item, &format!("{at}[]"))));
                }
                "$ref" => {
                    let name = wanted.as_str().unwrap().strip_prefix("#/$defs/").unwrap();
                    inner.extend(self.wrong(self.of(name), value, name));
                }
                "oneOf" => {
                    let of_each: Vec<_> =
                        wanted.as_array().unwrap().iter().map(|one| self.wrong(one, value, at)).collect();
                    let fitting = of_each.iter().filter(|wrong| wrong.is_empty()).count();
                    check(fitting == 1, format!("fits {fitting} of {} forms: {of_each:#?}", of_each.len()));
                }
                other => panic!("{at}: no keyword {other}"),
            }
        }
        wrong.extend(inner);
        wrong.extend(value.as_object().into_iter().flatten().flat_map(|(key, value)| {
            let at = format!("{at}.{key}");
            match schema["properties"].get(key).or_else(|| schema.get("additionalProperties")) {
                Some(schema) => self.wrong(schema, value, &at),
                None if schema["type"] == "object" => vec![format!("{at} is in no schema")],
                None => Vec::new(),
            }
        }));
        wrong
    }
}

fn is_of(value: &Value, kind: &str) -> bool {
    match kind {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "number" => value.is_number(),
        "integer" => value.is_i64() || value.is_u64(),
        other => panic!("no type {other}"),
    }
}

/// What a running daemon says until it has said one line of each class, by its answers to these requests.
fn lines_of_a_daemon(daemon: &Daemon) -> Vec<Value> {
    let mut socket = UnixStream::connect(daemon.socket()).unwrap();
    socket.set_read_timeout(Some(PATIENCE)).unwrap();
    let mut lines = BufReader::new(socket.try_clone().unwrap()).lines().map(|line| {
        let line: Value = serde_json::from_str(&line.unwrap()).unwrap();
        line
    });
    let mut heard: Vec<Value> = lines.by_ref().take(200).collect();
    for (request, class) in [
        (r#"{"class":"STATS"}"#, "STATS"),
        (r#"{"class":"POLL"}"#, "READING"),
        (r#"{"class":"WATCH","channels":["nobody"]}"#, "ERROR"),
        (r#"{"class":"WATCH","raw":true}"#, "DISCHARGE"),
    ] {
        writeln!(socket, "{request}").unwrap();
        let mut is_there = false;
        while !is_there {
            let line = lines.next().unwrap();
            is_there = line["class"] == class;
            heard.push(line);
        }
    }
    heard.extend(lines.take(100));
    heard
}

#[test]
fn what_a_daemon_says_is_as_the_schema_has_it() {
    let schema = Schema::new();
    // Numbers, then a broken board: faults with a hint.
    let config = config().lines("channel.thumb", "on-above = \"1 N\"").clone();
    for (is_whole, scene) in [(true, &mut scene()), (false, scene().set("circuit.r-c2", "100 Mohm"))] {
        let lines = lines_of_a_daemon(&Daemon::start_as(&config, scene));
        // Of what has no number there is no event.
        let classes = ["VERSION", "READING", "STATS", "ERROR", "TAPE", "DISCHARGE"];
        for class in classes.into_iter().chain(is_whole.then_some("EVENT")) {
            assert!(lines.iter().any(|line| line["class"] == class), "no {class}");
        }
        for line in &lines {
            assert_eq!(schema.wrong_with(line), Vec::<String>::new(), "{line}");
        }
    }
}

/// What a line of a class may hold: every field of its type has a value. A new field does not compile until it is here.
fn full(class: &str) -> Map<String, Value> {
    let (text, u) = (String::new(), Some(0.1));
    let value = match class {
        "VERSION" => serde_json::to_value(VersionLine {
            proto_major: 1,
            proto_minor: 0,
            release: text.clone(),
            channels: vec![ChannelInfo { id: text, unit: Unit::Newton, trigger: true }],
        }),
        "READING" => serde_json::to_value(ReadingLine {
            channel: text.clone(),
            seq: 1,
            time: text.clone(),
            t_mono_ns: 1,
            state: state(),
            hint: Some(text),
            duration_us: Some(1),
            lost: 0,
        }),
        "STATS" => serde_json::to_value(StatsLine {
            clients: 1,
            published: 1,
            lost: 1,
            instrument: instrument(),
            channels: [(
                text,
                ChannelStats { rate_hz: u, r_u_ohm: u, f_u_n: u, value_u: u, ..ChannelStats::default() },
            )]
            .into(),
        }),
        "EVENT" => serde_json::to_value(EventLine {
            channel: text.clone(),
            event: EventName::Released,
            reason: Some("stale".to_owned()),
            time: text,
            t_mono_ns: 1,
        }),
        "ERROR" => serde_json::to_value(ErrorLine { code: ErrorCode::Lost, message: text, lost: Some(1) }),
        "TAPE" => serde_json::to_value(header()),
        "DISCHARGE" => serde_json::to_value(discharge()),
        other => panic!("{other}"),
    };
    let Value::Object(fields) = value.unwrap() else { panic!("{class} is no object") };
    fields
}

fn state() -> StateLine {
    let u = Some(0.1);
    StateLine {
        status: StatusName::Ok,
        r_ohm: u,
        r_u_ohm: u,
        f_n: u,
        f_u_n: u,
        f_repeat_u_n: u,
        extrapolated: true,
        moving: true,
        settling: true,
        r_min_ohm: u,
        f_max_n: u,
        r_max_ohm: u,
        f_min_n: u,
        value: u,
        value_u: u,
        value_repeat_u: u,
        unit: Some("degC".to_owned()),
        value_min: u,
        value_max: u,
        fault: Some("pins".to_owned()),
        method: Some("cerm".to_owned()),
        branch: Some("direct".to_owned()),
    }
}

fn header() -> Header {
    let (u, one) = (Some(0.1), 1.0);
    Header {
        proto_major: 1,
        circuit: TapeCircuit { kind: Kind::TwoCapacitor, r_c1_ohm: one, r_c2_ohm: one },
        resolution_ns: u,
        offset: TapeOffset {
            offset_ns: u,
            offset_u_ns: u,
            offset_by_switch: u,
            switch_u_ns: u,
            r_o_ohm: u,
            r_o_u_ohm: u,
        },
        looks: TapeLooks {
            leak_siemens: Some([0.1; 2]),
            leak_u_siemens: Some([0.1; 2]),
            leak_b_siemens: Some([0.1; 2]),
            leak_b_u_siemens: Some([0.1; 2]),
            late_ns: Some([0.1; 2]),
            late_u_ns: Some([0.1; 2]),
            absorbed: u,
        },
        tracked: true,
        channels: [
            vec![Channel { id: String::new(), zero_ohm: u, scale: u, force: Some(force()), law: None }],
            laws().map(|law| Channel { law: Some(law), ..Channel::default() }).into(),
        ]
        .concat(),
    }
}

fn discharge() -> DischargeLine {
    let (u, one) = (Some(0.1), 1.0);
    DischargeLine {
        seq: 1,
        t_ns: Some(1),
        channel: Some(String::new()),
        through: Resistor::X,
        held: true,
        second_ns: u,
        switch: Some(SwitchLine { at_ns: one, on_ns: one, to: Resistor::C2, u_ns: u }),
        a_ns: u,
        b_ns: u,
        waited_ns: u,
        later_ns: u,
        as_read_ohm: u,
        shared_u_ohm: u,
    }
}

fn force() -> Force {
    Force { law: Law::Alpha { alpha_n_ohm: 1.0 }, u: Some(0.1), range_n: Some([1.0, 2.0]), tare_n: Some(1.0) }
}

/// Each form of a law, with all that it may say.
fn laws() -> [Transducer; 6] {
    let u = Some(0.1);
    let ntc = |curve| Transducer::Ntc(Ntc { curve, u, range_degc: Some([0.0, 60.0]) });
    let table = Pairs::try_from(vec![(1.0, -2.0), (2.0, -1.0)]).unwrap();
    let unit = "mm".to_owned();
    [
        ntc(Curve::Beta { r25_ohm: 1e4, beta_k: 3950.0, beta_u: u }),
        ntc(Curve::SteinhartHart { a_per_k: 1e-3, b_per_k: 2e-4, c_per_k: 1e-7 }),
        Transducer::Pt1000(Pt1000 { class: Some(Class::AA) }),
        Transducer::Ldr(Ldr { at_10_lx_ohm: 1e4, gamma: 0.7, u, gamma_u: u, range_lx: Some([1.0, 2.0]) }),
        Transducer::Position(Position { r0_ohm: 0.0, r1_ohm: 1e4, span: 100.0, unit: unit.clone(), u }),
        Transducer::Table(Tabled { table, unit, u }),
    ]
}

fn instrument() -> InstrumentStats {
    let u = Some(0.1);
    InstrumentStats {
        backend: "mock".to_owned(),
        method: "cerm".to_owned(),
        gpio_works: true,
        uptime_s: 1.0,
        cycles: 1,
        readings: 1,
        ok: 1,
        moving: 0,
        open: 0,
        short: 0,
        faults: [("pins".to_owned(), 1)].into(),
        hint: Some(String::new()),
        leak_ohm: u,
        feed_ohm: u,
        absorbed_percent: u,
        late_after_waits_ns: u,
        unlike_calls_ns: u,
        retried: 0,
        offset_known: true,
        offset_ns: u,
        offset_u_ns: u,
        r_o_ohm: u,
        r_o_u_ohm: u,
        spin_margin_ns: Some(1),
        lines_renewed: 0,
        blind_spots: 0,
        realtime: [("cpu".to_owned(), String::new())].into(),
    }
}

#[test]
fn the_schema_has_the_fields_of_the_types_and_no_other() {
    let schema = Schema::new();
    for class in ["VERSION", "READING", "EVENT", "STATS", "ERROR", "TAPE", "DISCHARGE"] {
        let full = full(class);
        let named: Vec<&String> = schema.of(class)["properties"].as_object().unwrap().keys().collect();
        assert_eq!(named, full.keys().collect::<Vec<_>>(), "{class}");
        assert_eq!(schema.wrong_with(&full.into()), Vec::<String>::new());
        for key in schema.of(class)["required"].as_array().unwrap() {
            let mut cut = self::full(class);
            cut.remove(key.as_str().unwrap());
            assert_ne!(schema.wrong_with(&cut.into()), Vec::<String>::new(), "{class} without {key}");
        }
    }
}

#[test]
fn names_of_states_faults_and_codes_are_all_there() {
    use cermd::reading::{Branch, Fault, Method};
    let schema = Schema::new();
    let of = |field: &str, keyword: &str| schema.of("READING")["properties"][field][keyword].clone();
    let names = |names: Vec<&str>| Value::from(names);
    assert_eq!(of("fault", "examples"), names(Fault::ALL.map(Fault::as_str).to_vec()));
    assert_eq!(of("method", "examples"), names(Method::ALL.map(Method::as_str).to_vec()));
    assert_eq!(of("branch", "examples"), names(Branch::ALL.map(Branch::as_str).to_vec()));
    for code in schema.of("ERROR")["properties"]["code"]["examples"].as_array().unwrap() {
        let read: ErrorCode = serde_json::from_value(code.clone()).unwrap();
        assert_ne!(read, ErrorCode::Other, "{code}");
    }
}

/// Samples are put into the pages by a program: this section is not of a number.
#[test]
fn the_readings_without_a_number_are_such() {
    let page = read("docs/protocol.md");
    let (_, section) =
        page.split_once("READING, above what can be resolved, and one that has no number:").unwrap();
    let lines = section.split("```").nth(1).unwrap().lines().filter(|line| line.starts_with('{'));
    let readings: Vec<Value> = lines.map(|line| serde_json::from_str(line).unwrap()).collect();
    let states: Vec<_> = readings.iter().map(|reading| reading["status"].as_str().unwrap()).collect();
    assert_eq!(states, ["open", "fault"]);
    assert!(readings.iter().all(|reading| reading.get("r_ohm").is_none()), "{readings:?}");
    assert!(readings[0]["r_min_ohm"].is_number() && readings[1]["fault"] == "missed-edge", "{readings:?}");
}

#[test]
fn the_lines_of_the_pages_are_lines_of_the_protocol() {
    let (schema, mut seen) = (Schema::new(), 0);
    for page in ["docs/protocol.md", "docs/overview.md"] {
        for line in read(page).lines().filter(|line| line.starts_with("{\"class\":\"")) {
            assert_eq!(
                schema.wrong_with(&serde_json::from_str(line).unwrap()),
                Vec::<String>::new(),
                "{page}: {line}"
            );
            seen += 1;
        }
        let requests = read(page);
        for request in
            requests.split('`').filter(|text| text.starts_with("{\"class\":\"") && !text.contains('\n'))
        {
            let value = serde_json::from_str(request).unwrap();
            assert_eq!(schema.wrong(schema.of("request"), &value, "request"), Vec::<String>::new(), "{page}");
            cermd::wire::Request::parse(Ok(request.as_bytes())).unwrap();
            seen += 1;
        }
    }
    assert!(seen > 10, "{seen}");
}
