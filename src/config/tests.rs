//! Parsing, defaults, the shipped file and the reports.

use super::*;
use crate::circuit::{Chargers, Network};
use crate::instrument::settings::Charges;
use crate::sensor::Law;
use crate::units::{Farad, Ohm, Seconds, Volt};
use std::fs;

const MINIMAL: &str = r#"
[circuit]
kind = "two-capacitor"
c-a = "2.2 uF"
c-b = "680 nF"
r-c1 = "2.32 kohm"
r-c2 = "12.7 kohm"
"#;

/// Every key once. Its first line is empty: messages count from there.
const FULL: &str = include_str!("tests_full.toml");

fn parse(text: &str) -> Config {
    Config::parse(text, "test").unwrap_or_else(|error| panic!("{error}"))
}

fn refusal(text: &str) -> String {
    Config::parse(text, "test.toml").unwrap_err().to_string()
}

#[test]
fn everything_can_be_said() {
    let config = parse(FULL);
    assert_eq!(config.circuit.network, Network::TwoCapacitor { c_a: Farad(2.2e-6), c_b: Farad(680e-9) });
    assert_eq!((config.circuit.r_c1, config.circuit.r_c2), (Ohm(2_320.0), Ohm(12_700.0)));
    assert_eq!((config.circuit.v_dd, config.circuit.v_th), (Volt(5.0), Volt(2.0)));
    assert_eq!(config.circuit.r_charge, Ohm(330.0));
    assert_eq!(config.gpio.backend, Backend::Chardev);
    assert_eq!(config.gpio.sense_a, Some(LineName("GPIO5".to_owned())));
    assert_eq!(config.gpio.sense_b, Some(LineName("6".to_owned())));
    assert_eq!(config.gpio.sink_c1, Some(LineName("20".to_owned())));
    assert_eq!(config.method(), Method::Cerm);
    assert_eq!(config.measure.rate_hz, Some(20.0));
    assert_eq!(config.charge_time(), Nanos(3_000_000));
    assert_eq!(config.settle_time(), Nanos(50_000));
    assert_eq!(config.deadline(), Nanos(50_000_000));
    assert_eq!(config.measure.offset, Some(OffsetSource::Auto));
    assert_eq!(config.measure.t_l, Some(Nanos(616_000)));
    assert_eq!(config.switch_fraction(), 0.8);
    assert_eq!((config.channels[0].zero_ohm, config.channels[0].scale), (Some(1.5), Some(1.002)));
    assert_eq!(config.channels[0].force, Some(Law::Calibrated { fc1_n: 5.75, fc2_n: 1.05 }.into()));
    assert_eq!(
        config.channels[1].force,
        Some(Characteristic {
            law: ForceSource::File(PathBuf::from("index.csv")),
            u: None,
            range_n: None,
            tare_n: None
        })
    );
    let [thumb, index] = &config.triggers().unwrap()[..] else { panic!("not two triggers") };
    let (thumb, (line, when)) = (thumb.rules, thumb.output.clone().unwrap());
    assert_eq!((thumb.on, thumb.off, thumb.hold), (2.0, 0.15 * 9.80665, Nanos(20_000_000)));
    assert_eq!((thumb.stale, index.rules.on, index.rules.off), (Nanos(1_000_000_000), 5e3, 8e3));
    assert_eq!(
        (&*line.chip, &*line.line, line.active_low, when),
        ("expander", "GPIO17", true, When::Released)
    );
    assert_eq!(config.server, Server { socket: PathBuf::from("/tmp/s"), mode: 0o600 });
    assert_eq!(config.mock, Some(Mock { scene: "pi4".to_owned(), seed: Some(7) }));
}

#[test]
fn silence_has_defaults() {
    let config = parse(MINIMAL);
    assert_eq!((config.circuit.v_dd, config.circuit.v_th), (Volt(3.3), Volt(1.3)));
    assert_eq!(config.gpio, Gpio::default());
    assert_eq!(config.gpio.backend, Backend::Mock);
    assert_eq!(config.method(), Method::Tracked);
    assert_eq!(config.settle_time(), Nanos::ZERO);
    assert_eq!(config.switch_fraction(), 0.9);
    assert_eq!(config.server.socket, Path::new("/run/cermd/cermd.sock"));
    assert_eq!(config.server.mode, 0o660);
    assert_eq!((config.channels.len(), config.mock.is_none()), (0, true));
}

#[test]
fn derived_times_follow_the_circuit() {
    let config = parse(MINIMAL);
    let (Charges { to_a, to_b, anew }, deadline) = (config.charges(), config.deadline().as_seconds());
    let taus = |time: Nanos, tau: Seconds| time.as_seconds() / tau.0;
    let [of_a, all] = [Chargers::OfA, Chargers::All].map(|chargers| config.circuit.charge_tau(chargers));
    // What discharges leave to remember, they leave at A; B comes back while A's charge is remembered no more.
    assert!((taus(to_a.alone, of_a) - 9.81).abs() < 0.01 && to_a.together == Nanos::ZERO, "{to_a:?}");
    let b = config.circuit.charge_tau_b().unwrap();
    assert!(to_b.alone == to_a.alone && (taus(to_b.together, b) - 0.5).abs() < 1e-3, "{to_b:?}");
    assert!((taus(anew.together, all) - 7.49).abs() < 0.01 && anew.alone == Nanos::ZERO, "{anew:?}");
    let given = parse(&format!("{MINIMAL}[measure]\ncharge-time = \"3 ms\"")).charges();
    let given_ms = [given.to_a, given.to_b, given.anew].map(|charge| (charge.alone.0, charge.together.0));
    let together = to_b.together.0;
    assert_eq!(given_ms, [(3_000_000, 0), (3_000_000, together), (0, anew.together.0)]);
    let t_c2b = (12_700.0 + 40.0) * config.circuit.g(crate::circuit::Node::B).unwrap().0;
    assert!((deadline - 4.0 * t_c2b).abs() < 1e-9, "{deadline}");
}

#[test]
fn the_method_follows_the_circuit() {
    let one = |kind: &str, method: &str| {
        let text = format!(
            "[circuit]\nkind = \"{kind}\"\nc = \"1 uF\"\nr-c1 = \"1 kohm\"\nr-c2 = \"9 kohm\"\n{method}"
        );
        parse(&text)
    };
    assert_eq!(one("one-capacitor", "").method(), Method::Tracked);
    let tpcm = "[measure]\nmethod = \"tpcm\"";
    assert_eq!(one("one-capacitor", tpcm).offset(), OffsetSource::Auto);
    assert_eq!(one("series-calibration", "").method(), Method::Qerm);
    assert_eq!(one("series-calibration", "").offset(), OffsetSource::Auto);
    // TPCM in the circuit with two capacitors times node A only, and so does its deadline.
    let tpcm = parse(&format!("{MINIMAL}{tpcm}"));
    assert_eq!(Some(tpcm.discharge(Ohm(1e3))), tpcm.circuit.crossing(crate::circuit::Node::A, Ohm(1e3)));
}

#[test]
fn a_tape_tells_no_offset_where_none_was_needed_or_given() {
    use crate::estimate::offset::Offset;
    use crate::stream::tape::TapeOffset;
    let header = |method: &str, found| {
        let config = parse(&format!("{MINIMAL}[measure]\nmethod = \"{method}\"\n[[channel]]\nid = \"x\"\n"));
        tape_header(&config.settings().unwrap(), found).offset
    };
    assert_eq!(header("tpcm", Some(Offset::given(0.0))), TapeOffset::default());
    let found = Offset { u_d_ns: 300.0, ..Offset::given(7000.0) };
    assert_eq!(header("cerm", None), TapeOffset::default());
    let of = header("cerm", Some(found));
    assert_eq!((of.offset_ns, of.offset_u_ns), (Some(7000.0), Some(300.0)));
}

#[test]
fn other_forces_and_offsets() {
    let with = |force: &str| {
        parse(&format!("{MINIMAL}[[channel]]\nid = \"a\"\nforce = {force}")).channels[0].force.clone()
    };
    assert_eq!(with("{ alpha = \"13346 N ohm\" }"), Some(Law::Alpha { alpha_n_ohm: 13_346.0 }.into()));
    let power = Law::Power { at_1_kohm_n: 13.3, exponent: 1.05 }.into();
    assert_eq!(with("{ at-1-kohm = \"13.3 N\", exponent = 1.05 }"), Some(power));
    let offset = parse(&format!("{MINIMAL}[measure]\noffset = \"8 us\"")).offset();
    assert_eq!(offset, OffsetSource::Given(8_000.0));
}

/// Advice that is refused in its turn, such as an offset of 8 s, is none.
#[test]
fn a_duration_without_a_unit_gets_the_unit_of_its_key() {
    for (written, advised) in [
        ("offset = 8", "8 us"),
        ("offset = \"8\"", "8 us"),
        ("offset = 7.5", "7.5 us"),
        ("offset = 8000", "8 us"),
        ("offset = 8e-6", "8 us"),
        ("resolution = 20", "20 ns"),
        ("settle-time = 5", "5 us"),
        ("charge-time = 1.85", "1.85 ms"),
        ("deadline = 30", "30 ms"),
        ("deadline = 0.03", "30 ms"),
        ("t-l = 1", "1 ms"),
        ("average = 50", "50 ms"),
        ("average = 0.05", "50 ms"),
        ("average = 1", "1 s"),
    ] {
        let refused = refusal(&format!("{MINIMAL}[measure]\n{written}"));
        assert!(
            refused.contains(&format!("the unit is missing, write \"{advised}\"")),
            "{written}: {refused}"
        );
        let (key, _) = written.split_once(' ').unwrap();
        let config = parse(&format!("{MINIMAL}[measure]\n{key} = \"{advised}\"\n[[channel]]\nid = \"a\""));
        let said = config.check().errors();
        assert!(!said.contains(&format!("measure.{key}")), "{written}: {said}");
    }
}

#[test]
fn laws_are_read_with_their_units() {
    use crate::sensor::Transducer;
    use crate::sensor::ntc::{Curve, Ntc};
    let with = |law: &str| {
        let config = parse(&format!("{MINIMAL}[[channel]]\nid = \"a\"\nlaw = {law}"));
        match config.channels[0].law.clone() {
            Some(LawSource::Given(law)) => law,
            other => panic!("{other:?}"),
        }
    };
    let curve = Curve::Beta { r25_ohm: 10_000.0, beta_k: 3950.0, beta_u: None };
    let ntc = with(
        r#"{ kind = "ntc", r25 = "10 kohm", beta = "3.95 kK", u = "1 %", range = ["-5 degC", "60 degC"] }"#,
    );
    assert_eq!(ntc, Transducer::Ntc(Ntc { curve, u: Some(0.01), range_degc: Some([-5.0, 60.0]) }));
    let Transducer::Position(slider) =
        with(r#"{ kind = "position", r0 = "0 ohm", r1 = "10 kohm", span = "10 cm", u = "0.5 mm" }"#)
    else {
        panic!()
    };
    assert_eq!((slider.span, slider.unit.as_str(), slider.u), (100.0, "mm", Some(0.5)));
}

#[test]
fn a_law_that_cannot_be_read_says_what_it_takes() {
    let refused = |law: &str| refusal(&format!("{MINIMAL}[[channel]]\nid = \"a\"\nlaw = {law}"));
    for (law, wanted) in [
        (r#"{ r25 = "10 kohm" }"#, "missing field `kind`"),
        (
            r#"{ kind = "ptc" }"#,
            "unknown variant `ptc`, expected one of `ntc`, `pt1000`, `ldr`, `position`, `table`",
        ),
        (r#"{ kind = "ntc", r25 = "10 kohm" }"#, "an ntc takes r25 and beta, or a, b and c"),
        (
            r#"{ kind = "ntc", r25 = "10 kohm", beta = "3950 K", a = 1 }"#,
            "an ntc takes r25 and beta, or a, b and c",
        ),
        (r#"{ kind = "ntc", r25 = 10000, beta = "3950 K" }"#, "the unit is missing, write \"10 kohm\""),
        (r#"{ kind = "ntc", r25 = "10 kohm", beta = "3950 degC" }"#, "expected a number of kelvins such as"),
        (r#"{ kind = "pt1000", class = "D" }"#, "unknown variant `D`, expected one of `AA`, `A`, `B`, `C`"),
        (r#"{ kind = "pt1000", r25 = "1 kohm" }"#, "unknown field `r25`, expected `class`"),
        (
            r#"{ kind = "position", r0 = "0 ohm", r1 = "1 kohm", span = "1 s" }"#,
            "span = \"1 s\" is no length",
        ),
        (
            r#"{ kind = "position", r0 = "0 ohm", r1 = "1 kohm", span = "1 m", u = "1 %" }"#,
            "u is in %, and span in mm",
        ),
    ] {
        let error = refused(law);
        assert!(error.contains(wanted) && error.contains("law = "), "{law}: {error}");
    }
}

#[test]
fn an_unknown_key_is_pointed_at() {
    insta::assert_snapshot!(refusal(&MINIMAL.replace("c-b", "cb")), @r#"
    test.toml: TOML parse error at line 5, column 1
      |
    5 | cb = "680 nF"
      | ^^
    unknown field `cb`, expected one of `kind`, `c-a`, `c-b`, `c`, `r-c1`, `r-c2`, `v-dd`, `v-th`, `r-charge`
    "#);
}

#[test]
fn a_wrong_unit_is_pointed_at() {
    insta::assert_snapshot!(refusal(&MINIMAL.replace("2.2 uF", "2.2 uH")), @r#"
    test.toml: TOML parse error at line 4, column 7
      |
    4 | c-a = "2.2 uH"
      |       ^^^^^^^^
    expected a capacitance such as "2.2 uF", got "2.2 uH"
    "#);
}

#[test]
fn refusals_name_the_line_and_the_choice() {
    let text = |line: &str| format!("{MINIMAL}{line}\n");
    for (text, line, said) in [
        (MINIMAL.replace("c-b = \"680 nF\"\n", ""), 2, "has the capacitors c-a and c-b"),
        (MINIMAL.replace("two-c", "one-c"), 2, "one capacitor, c, and neither c-a nor c-b"),
        (MINIMAL.replace("two-c", "three-c"), 3, "unknown variant `three-capacitor`"),
        (MINIMAL.replace("\"2.2 uF\"", "2.2e-6"), 4, "expected a capacitance such as \"2.2 uF\""),
        (MINIMAL.replace("r-c1 = \"2.32 kohm\"\n", ""), 2, "missing field `r-c1`"),
        (
            text("[measure]\noffset = \"soon\""),
            9,
            "expected a duration such as \"8 us\", got \"soon\"; or \"auto\"",
        ),
        (text("[measure]\nmethod = \"magic\""), 9, "unknown variant `magic`"),
        (text("[gpio]\nbackend = \"spi\""), 9, "unknown variant `spi`"),
        (text("[gpio]\nchip = \"a\""), 8, "missing field `backend`"),
        (text("[gpio]\nbackend = \"mock\"\nsense-a = -1"), 10, "a line's name such as \"GPIO17\""),
        (text("[gpio]\nbackend = \"mock\"\nsense-a = \"\""), 10, "a line's name such as \"GPIO17\""),
        (text("[server]\nmode = \"0680\""), 9, "expected octal permissions such as \"0660\", got \"0680\""),
        (text("[server]\nmode = \"1777\""), 9, "expected octal permissions"),
        (text("[[channel]]\nsink = 1"), 8, "missing field `id`"),
        (text("[[channel]]\nid = \"a\"\nforce = { fc1 = \"1 N\" }"), 10, "force takes one of"),
        (text("[measure]\nrate-hz = \"10 Hz\""), 9, "expected a number, without a unit"),
        (text("[[channel]]\nid = \"a\"\nzero-ohm = \"220 ohm\""), 10, "expected a number, without a unit"),
        (text("[[channel]]\nid = \"a\"\nforce = 5"), 10, "integer `5`, expected one of { fc1, fc2 }"),
        (
            text("[[channel]]\nid = \"a\"\nforce = { fc1 = \"1 N\", fc2 = \"1 V\" }"),
            10,
            "expected a force such as",
        ),
        (text("[mock]\nseed = 1"), 8, "missing field `scene`"),
        (text("[thumb]"), 8, "unknown field `thumb`"),
        (text("[measure"), 8, "unclosed table"),
        ("[measure]\nrate-hz = 1\n".to_owned(), 1, "missing field `circuit`"),
    ] {
        let message = refusal(&text);
        assert!(message.starts_with("test.toml: ") && message.contains(said), "{message}");
        assert!(message.contains(&format!("at line {line}, column ")), "{message}");
    }
}

#[test]
fn files_count_from_the_configuration() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("cermd.toml");
    fs::write(&file, FULL).unwrap();
    let config = Config::load(&file).unwrap();
    assert_eq!(config.base.join("index.csv"), folder.path().join("index.csv"));
    assert_eq!(parse(FULL).base.join("index.csv"), Path::new("index.csv"));
}

/// Serde names the keys of a table when it refuses another one.
#[test]
fn the_shipped_configuration_explains_every_key() {
    let text = include_str!("../../hw/cermd.toml");
    for table in ["[circuit]", "[gpio]", "[measure]", "[[channel]]", "[server]", "[realtime]", "[mock]"] {
        let comment = format!("# {table}");
        let header = if text.contains(&comment) { comment } else { table.to_owned() };
        let asked = text.replace(&format!("{header}\n"), &format!("{table}\nnonsense = 1\n"));
        let refusal = Config::parse(&asked, "test").unwrap_err().to_string();
        let (_, keys) =
            refusal.split_once("`nonsense`, expected ").unwrap_or_else(|| panic!("{table}: {refusal}"));
        for key in keys.split('`').skip(1).step_by(2) {
            let is_set = |line: &str| line.trim_start_matches("# ").starts_with(&format!("{key} ="));
            assert!(text.lines().any(is_set) || text.contains(&format!("`{key}`")), "{table}: no {key}");
        }
    }
}

/// Every default that the shipped file shows in a comment is the default.
#[test]
fn the_shipped_comments_are_true() {
    let text = include_str!("../../hw/cermd.toml");
    let uncommented: String = text
        .lines()
        .map(|line| match line.strip_prefix("# ") {
            Some(table) if table.starts_with('[') => table,
            Some(setting) if setting.contains(" = ") && !setting.contains([';', ',']) => setting,
            _ => line,
        })
        .flat_map(|line| [line, "\n"])
        .collect();
    let (shown, silent) = (parse(&uncommented), parse(text));
    assert!(shown.measure.charge_time.is_some() && shown.measure.switch_fraction.is_some(), "{uncommented}");
    assert_eq!(
        (shown.circuit, &shown.server, &shown.channels),
        (silent.circuit, &silent.server, &silent.channels)
    );
    assert_eq!((shown.settle_time(), shown.method()), (silent.settle_time(), silent.method()));
    let as_cerm = |text: &str| parse(&text.replace("[measure]", "[measure]\nmethod = \"cerm\""));
    let without = uncommented.replace("method = \"tracked\"\n", "");
    let (shown_cerm, silent_cerm) = (as_cerm(&without), as_cerm(text));
    assert_eq!(shown_cerm.offset(), silent_cerm.offset());
    assert!(shown.measure.calibration.is_some() && !shown_cerm.is_tracked() && !silent_cerm.is_tracked());
    assert_eq!(shown.measure.resolution, Some(Nanos(1)));
    assert_eq!(shown.switch_fraction(), silent.switch_fraction());
    // What is shown under [realtime] are examples: the default is nothing.
    let all = Wishes { fifo_priority: Some(40), lock_memory: true, cpu: Some(3), no_deep_idle: true };
    assert_eq!((&shown.realtime, &silent.realtime), (&all, &Wishes::default()));
    for (shown, derived) in
        [(shown.charge_time(), silent.charge_time()), (shown.deadline(), silent.deadline())]
    {
        assert!((shown.as_ns() / derived.as_ns() - 1.0).abs() < 0.005, "{shown} shown, {derived} derived");
    }
}

#[test]
fn a_force_may_say_how_well_it_is_known() {
    let text = "[[channel]]\nid = \"a\"\nforce = { fc1 = \"5.75 N\", fc2 = \"1.05 N\", u = \"8.7 %\", range = [\"500 mN\", \"20 N\"] }";
    let force = parse(&format!("{MINIMAL}{text}")).channels[0].force.clone().unwrap();
    assert!((force.u.unwrap() - 0.087).abs() < 1e-12 && force.range_n == Some([0.5, 20.0]), "{force:?}");
    let bad = |from: &str, to: &str| {
        let config = parse(&format!("{MINIMAL}{}", text.replace(from, to)));
        config.check().errors().lines().any(|line| line.starts_with("error: channel.a.force: "))
    };
    assert!(!bad("8.7 %", "8.7 %") && bad("8.7 %", "0 %") && bad("8.7 %", "870 %") && bad("20 N", "0.1 N"));
}
