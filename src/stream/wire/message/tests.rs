//! The lines of the protocol, byte by byte and read back.

use super::*;
use crate::reading::{Bound, Branch, Fault, Measured, MeasuredValue, Method, Suspect};
use crate::stream::wire::ChannelStats;
use crate::stream::wire::{InstrumentStats, to_line};
use crate::units::Nanos;

const TIME: &str = "2026-11-21T03:40:00.123456789Z";

fn reading(status: Status) -> Reading {
    Reading {
        channel: 0,
        seq: 1041,
        at: Nanos(81_234_567_890),
        status,
        suspect: None,
        method: Method::Cerm,
        duration: Nanos(18_230_400),
    }
}

fn line(message: &impl Serialize) -> String {
    String::from_utf8(to_line(message)).unwrap()
}

fn written(status: Status) -> String {
    line(&ReadingLine::new(&reading(status), "thumb", &Unit::Newton, TIME.to_owned()))
}

fn ok() -> Status {
    let r_ohm = Measured { value: 2841.3, u: Some(1.2) };
    let shown = MeasuredValue { value: 4.697, u: Some(0.41), repeat_u: Some(0.002), is_extrapolated: false };
    let shown = Some(shown);
    Status::Ok { branch: Branch::Direct, r_ohm, shown, is_moving: false, is_settling: false }
}

#[test]
fn every_channel_has_a_value_with_its_unit() {
    let written =
        |status, unit| serde_json::to_string(&StateLine::new(&status, Method::Cerm, &unit)).unwrap();
    let of_law = |status| written(status, Unit::named("degC"));
    let ok = of_law(ok());
    assert!(
        ok.contains("\"value\":4.697,\"value_u\":0.41,\"value_repeat_u\":0.002,\"unit\":\"degC\""),
        "{ok}"
    );
    assert!(!ok.contains("f_n"), "{ok}");
    let open = |shown| Status::Open { r_min_ohm: 1.9e6, shown };
    let short = |shown| Status::Short { r_max_ohm: 4.5, shown };
    let least = "\"value_min\":7";
    let (below, above) = (Some(Bound::AtMost(7.0)), Some(Bound::AtLeast(7.0)));
    assert!(of_law(open(below)).contains("\"value_max\":7") && of_law(open(below)).contains("\"degC\""));
    assert!(of_law(open(above)).contains(least) && of_law(short(above)).contains(least));
    // A force has its own names, too; a resistance is its own value.
    let wanted = "\"f_n\":4.697,\"f_u_n\":0.41,\"f_repeat_u_n\":0.002,\"value\":4.697,\"value_u\":0.41,\"value_repeat_u\":0.002,\
                  \"unit\":\"N\"";
    assert!(written(self::ok(), Unit::Newton).contains(wanted));
    let pressed = written(short(above), Unit::Newton);
    assert!(
        pressed.contains("\"f_min_n\":7,\"value_min\":7") && pressed.contains("\"unit\":\"N\""),
        "{pressed}"
    );
    let Status::Ok { branch, r_ohm, .. } = self::ok() else { panic!("{:?}", self::ok()) };
    let plain = Status::Ok { branch, r_ohm, shown: None, is_moving: false, is_settling: false };
    let itself = written(plain, Unit::Ohm);
    assert!(itself.contains("\"value\":2841.3,\"value_u\":1.2,\"unit\":\"ohm\""), "{itself}");
    assert!(written(open(None), Unit::Ohm).contains("\"value_min\":1900000"));
    assert!(written(short(None), Unit::Ohm).contains("\"value_max\":4.5"));
    assert_eq!(of_law(open(None)), "{\"status\":\"open\",\"r_min_ohm\":1900000}");
    assert_eq!(of_law(Status::Fault(Fault::Pins)), "{\"status\":\"fault\",\"fault\":\"pins\"}");
    // What a later release may measure in is a unit, too.
    let unit: Unit = serde_json::from_str("\"furlong\"").unwrap();
    assert_eq!((unit.as_str(), serde_json::from_str("\"N\"").ok()), ("furlong", Some(Unit::Newton)));
    assert_eq!(serde_json::to_string(&Unit::named("degC")).unwrap(), "\"degC\"");
}

#[test]
fn the_lines_of_the_protocol_byte_by_byte() {
    assert_eq!(
        written(ok()),
        "{\"class\":\"READING\",\"channel\":\"thumb\",\"seq\":1041,\"time\":\"2026-11-21T03:40:00.123456789Z\",\
         \"t_mono_ns\":81234567890,\"status\":\"ok\",\"r_ohm\":2841.3,\"r_u_ohm\":1.2,\"f_n\":4.697,\
         \"f_u_n\":0.41,\"f_repeat_u_n\":0.002,\"value\":4.697,\"value_u\":0.41,\"value_repeat_u\":0.002,\"unit\":\"N\",\
         \"method\":\"cerm\",\"branch\":\"direct\",\"duration_us\":18230,\"lost\":0}\n"
    );
    let Status::Ok { branch, r_ohm, .. } = ok() else { panic!("{:?}", ok()) };
    let moving = written(Status::Ok { branch, r_ohm, shown: None, is_moving: true, is_settling: true });
    assert!(
        moving.contains(
            "\"r_ohm\":2841.3,\"r_u_ohm\":1.2,\"moving\":true,\"settling\":true,\"method\":\"cerm\""
        ),
        "{moving}"
    );
    let head = "{\"class\":\"READING\",\"channel\":\"thumb\",\"seq\":1041,\
                \"time\":\"2026-11-21T03:40:00.123456789Z\",\"t_mono_ns\":81234567890,\"status\":";
    assert_eq!(
        written(Status::Open { r_min_ohm: 1.9e6, shown: Some(Bound::AtMost(0.007)) }),
        format!(
            "{head}\"open\",\"unit\":\"N\",\"r_min_ohm\":1900000,\"f_max_n\":0.007,\"value_max\":0.007,\"duration_us\":18230,\"lost\":0}}\n"
        )
    );
    assert_eq!(
        written(Status::Short { r_max_ohm: 4.5, shown: None }),
        format!("{head}\"short\",\"r_max_ohm\":4.5,\"duration_us\":18230,\"lost\":0}}\n")
    );
    assert_eq!(
        written(Status::Fault(Fault::MissedEdge)),
        format!("{head}\"fault\",\"fault\":\"missed-edge\",\"lost\":0}}\n")
    );
    let suspected =
        Reading { suspect: Some(Suspect::SecondOpen), ..reading(Status::Fault(Fault::NoCalibration)) };
    assert_eq!(
        line(&ReadingLine::new(&suspected, "thumb", &Unit::Newton, TIME.to_owned())),
        format!(
            "{head}\"fault\",\"fault\":\"no-calibration\",\"hint\":\"nothing falls in a discharge through Rc2; look at \
             the wire from sink-c2 through Rc2 to node A (series calibration: to Rc1)\",\"lost\":0}}\n"
        )
    );
}

#[test]
fn version_byte_by_byte() {
    assert_eq!(
        line(&VersionLine::new(&[ChannelInfo { id: "thumb".into(), unit: Unit::Newton, trigger: false }])),
        format!(
            "{{\"class\":\"VERSION\",\"proto_major\":1,\"proto_minor\":0,\"release\":\"{}\",\
             \"channels\":[{{\"id\":\"thumb\",\"unit\":\"N\"}}]}}\n",
            env!("CARGO_PKG_VERSION")
        )
    );
}

#[test]
fn a_loss_is_a_number_and_a_later_code_is_no_mistake() {
    let lost = ErrorLine::lost(17);
    assert_eq!(
        line(&lost),
        "{\"class\":\"ERROR\",\"code\":\"lost\",\"message\":\"17 lines of the tape were lost here: read faster\",\
         \"lost\":17}\n"
    );
    assert_eq!(ServerMessage::parse(line(&lost).as_bytes()).unwrap(), ServerMessage::Error(lost));
    let later = ServerMessage::parse(br#"{"class":"ERROR","code":"new","message":"of a later release"}"#);
    assert_eq!(later.unwrap(), ServerMessage::Error(ErrorLine::new(ErrorCode::Other, "of a later release")));
}

#[test]
fn stats_are_read_back() {
    let instrument = InstrumentStats {
        uptime_s: 12.5,
        faults: [("missed-edge".to_owned(), 2)].into(),
        offset_ns: Some(8012.3),
        ..InstrumentStats::default()
    };
    let stats = StatsLine {
        clients: 1,
        published: 7,
        lost: 0,
        channels: [("thumb".to_owned(), ChannelStats::default())].into(),
        instrument,
    };
    let text = line(&stats);
    assert!(
        text.starts_with("{\"class\":\"STATS\",\"clients\":1,\"published\":7,\"lost\":0,\"backend\""),
        "{text}"
    );
    assert_eq!(ServerMessage::parse(text.as_bytes()).unwrap(), ServerMessage::Stats(Box::new(stats)));
}

#[test]
fn readings_are_read_back() {
    let ServerMessage::Reading(line) = ServerMessage::parse(written(ok()).as_bytes()).unwrap() else {
        panic!("not a reading");
    };
    assert_eq!((line.state.status, line.seq, line.lost), (StatusName::Ok, 1041, 0));
    assert_eq!(
        (line.state.r_ohm, line.state.r_u_ohm, line.state.f_n, line.state.f_u_n),
        (Some(2841.3), Some(1.2), Some(4.697), Some(0.41))
    );
    assert_eq!((line.duration_us, line.state.r_min_ohm, line.state.fault), (Some(18230), None, None));
}

#[test]
fn unknown_fields_and_classes_pass_wrong_types_do_not() {
    let text = written(ok());
    let with = |from: &str, to: &str| ServerMessage::parse(text.replace(from, to).as_bytes());
    assert!(with("\"lost\":0", "\"lost\":0,\"new\":{\"a\":1}").is_ok());
    assert!(with("\"lost\":0", "\"lost\":\"0\"").is_err());
    assert!(with("2841.3", "\"2841.3\"").is_err());
    assert!(with("\"status\":\"ok\"", "\"status\":\"fine\"").is_err());
    let other = ServerMessage::parse(br#"{"class":"NEW","x":1}"#).unwrap();
    assert_eq!(other, ServerMessage::Other { class: "NEW".into() });
    assert!(ServerMessage::parse(b"{}").is_err());
    assert!(ServerMessage::parse(b"[1]").is_err());
    assert!(ServerMessage::parse(b"\xff").is_err());
}
