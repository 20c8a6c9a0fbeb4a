use super::*;
use crate::bridge::latest::tests::{event, ok, reading, up};
use crate::stream::wire::{ChannelInfo, InstrumentStats, StatusName, Unit, VersionLine};

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

fn topics(messages: &[Publication]) -> Vec<&str> {
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
fn what_is_pressed_is_told_at_once_and_again_and_what_is_not_known_is_not() {
    let mut teller = teller();
    teller.tell(&up(&["thumb"]), Nanos(0));
    assert!(teller.tell(&event("other", EventName::Pressed, None), Nanos(0)).is_empty());
    let told = teller.tell(&event("thumb", EventName::Pressed, None), Nanos(0));
    let pressed = r#"{"time":"2026-11-21T03:40:00.5Z","event":"pressed"}"#;
    assert_eq!((topics(&told), &*told[0].payload), (vec!["cermd/bench/trigger/thumb"], pressed));
    assert!(!told[0].is_retained);
    let stats = StatsLine {
        clients: 1,
        published: 0,
        lost: 0,
        channels: Default::default(),
        instrument: InstrumentStats::default(),
    };
    let stats = Heard::Stats(Box::new(stats), String::new());
    let told = teller.tell(&stats, Nanos(0));
    assert_eq!((topics(&told)[1], &*told[1].payload), ("cermd/bench/trigger/thumb", pressed));
    let told = teller.tell(&event("thumb", EventName::Released, Some("stale")), Nanos(0));
    assert!(told[0].payload.ends_with(r#""event":"released","reason":"stale"}"#), "{}", told[0].payload);
    // Of another daemon nothing is known yet.
    teller.tell(&Heard::Down, Nanos(0));
    assert_eq!(teller.tell(&stats, Nanos(0)).len(), 1);
}

#[test]
fn channels_that_are_gone_are_taken_back() {
    let mut teller = teller();
    teller.tell(&up(&["thumb", "index"]), Nanos(0));
    let told = teller.tell(&up(&["thumb"]), Nanos(0));
    assert_eq!(topics(&told), [DEVICE, DEVICE, AVAILABILITY]);
    let entities = |message: &Publication| {
        let device: serde_json::Value = serde_json::from_str(&message.payload).unwrap();
        device["cmps"].clone()
    };
    assert_eq!(entities(&told[0])["index_force"], serde_json::json!({"p": "sensor"}));
    assert!(entities(&told[0])["thumb_force"]["state_topic"] == "cermd/bench/channel/thumb");
    assert!(entities(&told[1]).get("index_force").is_none());
    // Also when the daemon was away, or the broker, while that happened.
    teller.tell(&up(&["thumb", "index"]), Nanos(0));
    teller.tell(&Heard::Down, Nanos(0));
    assert_eq!(topics(&teller.tell(&up(&["thumb"]), Nanos(0))), [DEVICE, DEVICE, AVAILABILITY]);
    teller.note(&up(&["index"]));
    assert_eq!(topics(&teller.introduction()), [DEVICE, DEVICE, AVAILABILITY]);
    // What was said last may never have reached anybody: all before is taken back as well, for as many as are remembered.
    teller.note(&up(&["palm"]));
    teller.introduction();
    let told = teller.introduction();
    for gone in ["index_force", "thumb_force"] {
        assert_eq!(entities(&told[0])[gone], serde_json::json!({"p": "sensor"}), "{gone}");
    }
    for index in 0..2 * MOST_ANNOUNCED {
        teller.note(&up(&[&index.to_string()]));
        teller.introduction();
    }
    assert_eq!(teller.announced.unwrap().channels.len(), MOST_ANNOUNCED);
}

#[test]
fn the_device_as_home_assistant_gets_it() {
    let Heard::Up(version) = up(&["thumb"]) else { unreachable!() };
    let device = discovery::device(&teller().topics, &version, Duration::from_secs(10));
    insta::assert_snapshot!(serde_json::to_string_pretty(&device).unwrap());
}

#[test]
fn a_channel_with_a_trigger_is_a_binary_sensor_too() {
    let Heard::Up(mut version) = up(&["thumb"]) else { unreachable!() };
    let entity = |version: &VersionLine| {
        let device = discovery::device(&teller().topics, version, Duration::from_secs(10));
        device["cmps"].get("thumb_pressed").cloned()
    };
    assert_eq!(entity(&version), None);
    version.channels[0].trigger = true;
    insta::assert_snapshot!(serde_json::to_string_pretty(&entity(&version)).unwrap(), @r#"
    {
      "expire_after": 30,
      "json_attributes_topic": "cermd/bench/trigger/thumb",
      "name": "thumb pressed",
      "p": "binary_sensor",
      "state_topic": "cermd/bench/trigger/thumb",
      "unique_id": "cermd-bench.thumb-pressed",
      "value_template": "{{ None if value_json.reason is defined else ('ON' if value_json.event == 'pressed' else 'OFF') }}"
    }
    "#);
}

#[test]
fn home_assistant_knows_what_laws_give() {
    let channel = |unit: &str| ChannelInfo { id: unit.to_owned(), unit: Unit::named(unit), trigger: false };
    let version = VersionLine::new(&["degC", "lx", "mm", "deg", "%RH"].map(channel));
    let device = discovery::device(&teller().topics, &version, Duration::from_secs(10));
    for (key, class, unit) in [
        ("degC_temperature", Some("temperature"), "\u{b0}C"),
        ("lx_illuminance", Some("illuminance"), "lx"),
        ("mm_position", Some("distance"), "mm"),
        ("deg_angle", None, "\u{b0}"),
        ("%RH_value", None, "%RH"),
    ] {
        let entity = &device["cmps"][key];
        assert_eq!(
            (entity["device_class"].as_str(), entity["unit_of_measurement"].as_str()),
            (class, Some(unit))
        );
        assert!(entity["value_template"].as_str().unwrap().contains("value_json.value if"), "{entity}");
        assert!(entity["json_attributes_template"].as_str().unwrap().contains("'value_u'"), "{entity}");
    }
    assert!(device["cmps"].as_object().unwrap().contains_key("mm_resistance"));
}

#[test]
fn any_name_is_one_level_of_a_topic() {
    let topics = teller().topics;
    assert_eq!(topics.channel("a/b+#%\u{1f91a} c"), "cermd/bench/channel/a%2Fb%2B%23%25%F0%9F%A4%9A%20c");
}
