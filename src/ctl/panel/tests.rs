//! States in words, and lines that fit.

use super::*;
use crate::stream::wire::{EventName, ServerMessage};

fn reading(at_ms: i64, rest: &str) -> ReadingLine {
    let line = format!(
        r#"{{"class":"READING","channel":"thumb","seq":1,"time":"2026-11-21T03:40:00.123456789Z","t_mono_ns":{},{rest},"lost":0}}"#,
        at_ms * 1_000_000
    );
    match ServerMessage::parse(line.as_bytes()).unwrap() {
        ServerMessage::Reading(reading) => *reading,
        other => panic!("{other:?}"),
    }
}

const FULL: &str = r#""status":"ok","r_ohm":1334.6,"r_u_ohm":2.5,"f_n":10.0,"f_u_n":0.02"#;
const HALF: &str = r#""status":"ok","r_ohm":2669.2,"r_u_ohm":2.5,"f_n":5.0,"f_u_n":0.01"#;
const BEYOND: &str = r#""status":"ok","r_ohm":889.8,"r_u_ohm":2.5,"f_n":15.0,"f_u_n":1.3,"f_repeat_u_n":0.042,"extrapolated":true"#;
const MOVING: &str =
    r#""status":"ok","r_ohm":889.8,"r_u_ohm":32.0,"f_n":15.0,"f_u_n":1.4,"extrapolated":true,"moving":true"#;
const SETTLING: &str = r#""status":"ok","r_ohm":2669.2,"r_u_ohm":74,"settling":true"#;
const OPEN: &str = r#""status":"open","r_min_ohm":63000.0,"f_max_n":0.21"#;
const FAULT: &str = r#""status":"fault","fault":"missed-edge""#;

const HINTED: &str = r#""status":"fault","fault":"no-calibration","hint":"nothing falls in a discharge through Rc1; look at the wire""#;

fn panel(readings: &[(i64, &str)]) -> Panel {
    let info = ChannelInfo { id: "thumb".to_owned(), unit: Unit::Newton, trigger: false };
    let mut panel = Panel::new([info].iter(), ForceUnit::Newton, true);
    readings.iter().for_each(|(at_ms, rest)| panel.feed(&reading(*at_ms, rest)));
    panel
}

#[test]
fn each_state_has_its_words() {
    let plain = |rest| panel(&[(0, rest)]).plain("thumb").unwrap();
    let is = |line: String, text: &str| assert_eq!(line, text);
    is(plain(HALF), "03:40:00.123  thumb  5.000 ± 0.010 N  2669.2 ± 2.5 ohm  ok");
    is(plain(OPEN), "03:40:00.123  thumb  < 0.210 N  > 63000 ohm  open");
    is(plain(BEYOND), "03:40:00.123  thumb  15.0 ± 1.3 N  889.8 ± 2.5 ohm  extrapolated");
    is(plain(MOVING), "03:40:00.123  thumb  15.0 ± 1.4 N  890 ± 32 ohm  moving");
    is(plain(SETTLING), "03:40:00.123  thumb  2669 ± 74 ohm  settling");
    is(plain(FAULT), "03:40:00.123  thumb  missed-edge  fault");
    is(
        plain(HINTED),
        "03:40:00.123  thumb  no-calibration  fault  nothing falls in a discharge through Rc1; look at the wire",
    );
    is(
        panel(&[(0, OPEN), (100, OPEN), (200, OPEN)]).plain("thumb").unwrap(),
        "03:40:00.123  thumb  < 0.210 N  > 63000 ohm  open  10.0/s",
    );
}

#[test]
fn what_is_pressed_is_marked_and_what_is_not_known_is_not() {
    let mut panel = panel(&[(0, HALF)]);
    for (event, reason, mark, plain) in [
        (EventName::Pressed, None, "●thumb", "  ok  pressed"),
        (EventName::Released, None, " thumb", "  ok"),
        (EventName::Pressed, None, "●thumb", "  ok  pressed"),
        (EventName::Released, Some("stale".to_owned()), " thumb", "  ok"),
    ] {
        let (channel, time) = ("thumb".to_owned(), String::new());
        panel.press(&EventLine { channel, event, reason, time, t_mono_ns: 0 });
        let line = console::strip_ansi_codes(&panel.lines(80)[0]).into_owned();
        assert!(line.starts_with(mark), "{line}");
        assert!(panel.plain("thumb").unwrap().ends_with(plain));
    }
}

#[test]
fn the_history_repeats_silence_and_leaves_faults_blank() {
    let panel = panel(&[(0, OPEN), (1000, FULL), (3000, FAULT), (4000, HALF)]);
    assert_eq!(panel.rows[0].slots(5_000_000_000, 5), [Some(0.0), Some(1.0), Some(1.0), None, Some(0.5)]);
    // The first reading is past.
    assert_eq!(panel.rows[0].slots(4_000_000_000, 4), [Some(1.0), Some(1.0), None, Some(0.5)]);
}

#[test]
fn every_number_stays_where_there_is_little_room() {
    let lines = |rest, width| {
        let lines = panel(&[(0, rest), (100, rest)]).lines(width);
        lines.iter().map(|line| console::strip_ansi_codes(line).into_owned()).collect::<Vec<_>>()
    };
    let [wide] = &lines(HALF, 80)[..] else { panic!() };
    assert!(wide.contains("▌·") && wide.contains(" 10 N  ok") && wide.ends_with("10.0/s"), "{wide}");
    let [one] = &lines(HALF, 64)[..] else { panic!() };
    assert!(!one.contains('█') && one.ends_with("10.0/s"), "{one}");
    let narrow = lines(HALF, 40);
    assert_eq!(narrow, [" thumb   5.000 ± 0.010 N  ok      ", "        2669.2 ± 2.5 ohm   10.0/s"]);
    assert!(lines(BEYOND, 90)[0].contains("extrapo."));
    let hinted = lines(HINTED, 100);
    assert!(hinted[0].contains("no-calibration") && hinted[0].contains("fault"), "{hinted:?}");
    assert!(hinted[1].trim_start().starts_with("nothing falls in a discharge"), "{hinted:?}");
}

#[test]
fn values_have_the_unit_of_their_law_and_a_bar_that_holds_them() {
    let info = ChannelInfo { id: "thumb".to_owned(), unit: Unit::named("degC"), trigger: false };
    let ok = |degc: f64| {
        format!(r#""status":"ok","r_ohm":9000,"r_u_ohm":2.5,"value":{degc},"value_u":0.26,"unit":"degC""#)
    };
    let mut panel = Panel::new([&info].into_iter(), ForceUnit::Gram, true);
    panel.feed(&reading(0, &ok(27.35)));
    assert_eq!(panel.plain("thumb").unwrap(), "03:40:00.123  thumb  27.35 ± 0.26 °C  9000.0 ± 2.5 ohm  ok");
    assert_eq!(panel.rows[0].scale().in_words(), "20 to 30 degC");
    assert!((panel.rows[0].share().unwrap() - 0.735).abs() < 1e-9);
    panel.feed(&reading(100, &ok(-3.5)));
    assert_eq!(panel.rows[0].scale().in_words(), "-10 to 30 degC");
    panel.feed(&reading(200, r#""status":"open","r_min_ohm":63000,"value_max":-14.2,"unit":"degC""#));
    assert!(
        panel.plain("thumb").unwrap().contains("  < -14.2 °C  > 63000 ohm  open"),
        "{:?}",
        panel.plain("thumb")
    );
    assert_eq!(panel.rows[0].share(), Some(0.0));
    panel.feed(&reading(300, r#""status":"short","r_max_ohm":2.5,"value_min":400,"unit":"degC""#));
    assert!(
        panel.plain("thumb").unwrap().contains("  > 400 °C  < 2.50 ohm  short"),
        "{:?}",
        panel.plain("thumb")
    );
    assert_eq!(panel.rows[0].share(), Some(1.0));
}

#[test]
fn what_was_long_ago_is_not_shown_as_if_it_were_now() {
    let info = ChannelInfo { id: "thumb".to_owned(), unit: Unit::Ohm, trigger: false };
    let mut panel = Panel::new([&info].into_iter(), ForceUnit::Newton, true);
    let said = |panel: &Panel| panel.plain("thumb").unwrap();
    // One in a second: three may be missing.
    for at_ms in [0, 1000, 2000] {
        panel.feed(&reading(at_ms, r#""status":"ok","r_ohm":9000,"r_u_ohm":2.5"#));
    }
    panel.look(Nanos(4_900_000_000));
    assert!(said(&panel).contains("9000.0 ± 2.5 ohm"));
    panel.look(Nanos(5_100_000_000));
    assert!(said(&panel).contains("silent") && !said(&panel).contains("9000"), "{}", said(&panel));
    panel.feed(&reading(9000, r#""status":"ok","r_ohm":9000,"r_u_ohm":2.5"#));
    assert!(said(&panel).contains("9000.0 ± 2.5 ohm"));
}

#[test]
fn forces_are_shown_in_the_unit_that_is_wanted() {
    let info = ChannelInfo { id: "thumb".to_owned(), unit: Unit::Newton, trigger: false };
    for (unit, plain, scale) in [
        (ForceUnit::Gram, "509.9 ± 1.0 g", "1000 g"),
        (ForceUnit::Kilogram, "0.5099 ± 0.0010 kg", "1 kg"),
        (ForceUnit::Pound, "1.1240 ± 0.0022 lbf", "2 lbf"),
    ] {
        let mut panel = Panel::new([&info].into_iter(), unit, true);
        panel.feed(&reading(0, HALF));
        assert!(
            panel.plain("thumb").unwrap().contains(&format!("  {plain}  ")),
            "{:?}",
            panel.plain("thumb")
        );
        assert!(panel.lines(100)[0].contains(scale) && panel.history(10.0, 80)[0].contains(scale));
    }
}
