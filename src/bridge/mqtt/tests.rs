use super::*;
use crate::bridge::board::tests::{ok, reading, up};
use crate::stream::wire::{InstrumentStats, StatusName};

fn teller() -> Teller {
    let options = Options {
        id: "bench".to_owned(),
        discovery: Some("homeassistant".to_owned()),
        change: 3.0,
        every: Duration::from_secs(10),
        at_least: Duration::ZERO,
    };
    Teller::new(options, Nanos(1_000))
}

fn topics(messages: &[Message]) -> Vec<&str> {
    messages.iter().map(|message| &*message.topic).collect()
}

const DEVICE: &str = "homeassistant/device/bench/config";
const AVAILABILITY: &str = "cermd/bench/availability";

#[test]
fn a_daemon_that_comes_and_goes_is_told() {
    let mut teller = teller();
    let nobody = teller.introduction();
    assert_eq!((topics(&nobody), &*nobody[0].payload), (vec![AVAILABILITY], OFFLINE));
    let told = teller.tell(&up(&["thumb"]), Nanos(0));
    assert_eq!((topics(&told), &*told[1].payload), (vec![DEVICE, AVAILABILITY], ONLINE));
    assert!(told.iter().all(|message| message.is_retained));
    let told = teller.tell(&reading("thumb", 0, ok(100.0)), Nanos(0));
    assert_eq!((topics(&told), told[0].is_retained), (vec!["cermd/bench/channel/thumb"], false));
    assert!(teller.tell(&reading("thumb", 1, ok(100.0)), Nanos(1)).is_empty(), "no news");
    let told = teller.tell(&Heard::Down, Nanos(2));
    assert_eq!((topics(&told), &*told[0].payload), (vec![AVAILABILITY], OFFLINE));
    teller.tell(&up(&["thumb"]), Nanos(3));
    assert_eq!(
        teller.tell(&reading("thumb", 3, ok(100.0)), Nanos(3)).len(),
        1,
        "news for whoever saw it offline"
    );
}

#[test]
fn what_is_old_or_of_no_channel_is_not_told() {
    let mut teller = teller();
    teller.tell(&up(&["thumb"]), Nanos(0));
    assert!(teller.tell(&reading("thumb", 0, ok(1.0)), Nanos(1_001)).is_empty());
    assert!(teller.tell(&reading("other", 0, ok(1.0)), Nanos(0)).is_empty());
    assert_eq!(teller.tell(&reading("thumb", 0, ok(1.0)), Nanos(1_000)).len(), 1);
}

#[test]
fn what_was_not_taken_is_told_again() {
    let mut teller = teller();
    teller.tell(&up(&["thumb"]), Nanos(0));
    let told = teller.tell(&reading("thumb", 0, ok(100.0)), Nanos(0));
    teller.forget(told[0].channel.as_ref().unwrap());
    assert_eq!(teller.tell(&reading("thumb", 1, ok(100.0)), Nanos(1)).len(), 1);
}

#[test]
fn a_state_has_no_number() {
    let mut teller = teller();
    teller.tell(&up(&["thumb"]), Nanos(0));
    let open = StateLine { status: StatusName::Open, r_min_ohm: Some(1.9e6), ..StateLine::default() };
    let told = teller.tell(&reading("thumb", 0, open), Nanos(0));
    assert_eq!(told[0].payload, r#"{"time":"2026-11-21T03:40:00.5Z","status":"open","r_min_ohm":1900000}"#);
}

#[test]
fn figures_have_a_rate_from_the_second_on() {
    let mut teller = teller();
    teller.tell(&up(&["thumb"]), Nanos(0));
    let mut figures = |readings, uptime_s| {
        let instrument =
            InstrumentStats { readings, uptime_s, gpio_works: true, ..InstrumentStats::default() };
        let stats = StatsLine { clients: 1, published: 0, lost: 0, channels: Default::default(), instrument };
        teller.tell(&Heard::Stats(Box::new(stats), String::new()), Nanos(0))[0].payload.clone()
    };
    assert_eq!(figures(100, 10.0), r#"{"gpio_works":true,"uptime_s":10.0}"#);
    assert_eq!(figures(161, 12.0), r#"{"rate_hz":30.5,"gpio_works":true,"uptime_s":12.0}"#);
    assert_eq!(figures(3, 1.0), r#"{"gpio_works":true,"uptime_s":1.0}"#, "of a new daemon");
}

#[test]
fn channels_that_are_gone_are_taken_back() {
    let mut teller = teller();
    teller.tell(&up(&["thumb", "index"]), Nanos(0));
    let told = teller.tell(&up(&["thumb"]), Nanos(0));
    assert_eq!(topics(&told), [DEVICE, DEVICE, AVAILABILITY]);
    let entities = |message: &Message| {
        let device: serde_json::Value = serde_json::from_str(&message.payload).unwrap();
        device["cmps"].clone()
    };
    assert_eq!(entities(&told[0])["index_force"], serde_json::json!({"p": "sensor"}));
    assert!(entities(&told[0])["thumb_force"]["state_topic"] == "cermd/bench/channel/thumb");
    assert!(entities(&told[1]).get("index_force").is_none());
}

#[test]
fn the_device_as_home_assistant_gets_it() {
    let Heard::Up(version) = up(&["thumb"]) else { unreachable!() };
    let device = discovery::device(&teller().topics, &version, Duration::from_secs(10));
    insta::assert_snapshot!(serde_json::to_string_pretty(&device).unwrap());
}

#[test]
fn any_name_is_one_level_of_a_topic() {
    let topics = teller().topics;
    assert_eq!(topics.channel("a/b+#%\u{1f91a} c"), "cermd/bench/channel/a%2Fb%2B%23%25%F0%9F%A4%9A%20c");
}
