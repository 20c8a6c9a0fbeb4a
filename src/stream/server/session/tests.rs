//! What a client gets, and in which order, however slowly it reads.

use super::*;
use crate::reading::{Fault, Method, Reading, Status};
use crate::stream::limits::serving::ROUNDS;
use crate::stream::tape::{DischargeLine, Header};
use crate::stream::wire::{ChannelInfo, EventLine, EventName, InstrumentStats, Unit};
use crate::units::Nanos;
use jiff::Timestamp;
use proptest::prelude::*;

/// Lines that a client's queue holds.
const LINES: usize = 4;

fn channels(unit: Unit) -> [ChannelInfo; 1] {
    [ChannelInfo { id: "thumb".into(), unit, trigger: false }]
}

fn hub() -> Hub {
    Hub::new(&channels(Unit::Newton))
}

fn session(hub: &Hub) -> Session {
    Session::new(hub, LINES)
}

/// As the server does it.
fn reload(hub: &mut Hub, session: &mut Session, unit: Unit) {
    hub.set_channels(&channels(unit));
    session.queue(&hub.version);
}

fn publish(hub: &mut Hub, session: &mut Session, seq: u64) {
    let status = Status::Fault(Fault::MissedEdge);
    let at = Nanos(seq as i64);
    let reading =
        Reading { channel: 0, seq, at, status, suspect: None, method: Method::Cerm, duration: Nanos::ZERO };
    hub.keep_reading(&reading, Timestamp::UNIX_EPOCH);
    session.queue(&hub.last_reading(0).unwrap());
}

/// Sends at most so many bytes, as a kernel with little room would.
fn send(hub: &Hub, session: &mut Session, mut room: usize, stream: &mut Vec<u8>) {
    while room > 0 {
        let line = session.next_output(hub, &InstrumentStats::default);
        let length = line.len().min(room);
        if length == 0 {
            return;
        }
        stream.extend_from_slice(&line[..length]);
        session.sent(length);
        room -= length;
    }
}

fn answers(session: &mut Session, hub: &Hub, request: &str) -> String {
    let mut stream = Vec::new();
    session.receive(request.as_bytes());
    send(hub, session, usize::MAX, &mut stream);
    String::from_utf8(stream).unwrap()
}

#[test]
fn a_tape_begins_with_its_header_and_has_no_past() {
    let header = r#"{"class":"TAPE","proto_major":1,"circuit":{"kind":"one-capacitor","r_c1_ohm":1.0,"r_c2_ohm":2.0},"channels":[]}"#;
    let mut hub = hub();
    hub.tape_header = Some(Published::new(Content::Tape, &serde_json::from_str::<Header>(header).unwrap()));
    let mut session = session(&hub);
    let discharge = |seq: u64| {
        let line = format!(r#"{{"class":"DISCHARGE","seq":{seq},"through":"c1"}}"#);
        let discharge: DischargeLine = serde_json::from_str(&line).unwrap();
        (Published::new(Content::Discharge(discharge.channel.clone()), &discharge), line + "\n")
    };
    session.queue(&discharge(1).0);
    let watch = answers(&mut session, &hub, "{\"class\":\"WATCH\",\"raw\":true}\n");
    assert!(watch.ends_with(&format!("]}}\n{header}\n")), "{watch}");
    let (after, line) = discharge(2);
    session.queue(&after);
    assert_eq!(answers(&mut session, &hub, ""), line);
    assert_eq!(answers(&mut session, &hub, "{\"class\":\"WATCH\",\"raw\":true}\n"), "");

    // A slow client gets the header that its next discharge belongs to, and what it has lost.
    session.queue(hub.tape_header.as_ref().unwrap());
    let lines: Vec<String> = (3..=7)
        .map(|seq| {
            let (published, line) = discharge(seq);
            session.queue(&published);
            line
        })
        .collect();
    let stream = answers(&mut session, &hub, "");
    let lost = String::from_utf8(to_line(&ErrorLine::lost(1))).unwrap();
    assert_eq!(stream, format!("{header}\n{lost}{}", lines[1..].concat()));
}

#[test]
fn a_tape_that_begins_later_begins_with_the_rounds_that_were_kept() {
    let header = r#"{"class":"TAPE","proto_major":1,"circuit":{"kind":"one-capacitor","r_c1_ohm":1.0,"r_c2_ohm":2.0},"tracked":true,"channels":[]}"#;
    let mut hub = hub();
    hub.tape_header = Some(Published::new(Content::Tape, &serde_json::from_str::<Header>(header).unwrap()));
    let line = |seq: usize| format!("{{\"class\":\"DISCHARGE\",\"seq\":{seq},\"through\":\"c1\"}}\n");
    for round in 0..ROUNDS + 2 {
        let lines =
            [3 * round, 3 * round + 1, 3 * round + 2].map(|seq| serde_json::from_str(&line(seq)).unwrap());
        hub.keep_round(&lines);
    }
    let watch = "{\"class\":\"WATCH\",\"raw\":true}\n";
    let kept: String = (6..3 * (ROUNDS + 2)).map(line).collect();
    let said = answers(&mut session(&hub), &hub, watch);
    assert!(said.ends_with(&format!("]}}\n{header}\n{kept}")), "{said}");
    // Those of other channels, or of a state that was given up, are of no use.
    hub.set_channels(&[]);
    let said = answers(&mut session(&hub), &hub, watch);
    assert!(said.ends_with(&format!("]}}\n{header}\n")), "{said}");
}

fn event(hub: &mut Hub, session: &mut Session, event: EventName, t_mono_ns: i64) {
    let line = EventLine { channel: "thumb".into(), event, reason: None, time: String::new(), t_mono_ns };
    session.queue(&hub.keep_event(&line).unwrap());
}

#[test]
fn the_last_event_is_known_to_whoever_comes_late_or_reads_slowly() {
    let (mut hub, mut early) = (hub(), session(&hub()));
    answers(&mut early, &hub, "{\"class\":\"WATCH\",\"max_hz\":0.001}\n");
    for (at, name) in [(1, EventName::Pressed), (2, EventName::Released)] {
        event(&mut hub, &mut early, name, at);
    }
    let stream = answers(&mut early, &hub, "");
    assert!(
        stream.contains("\"pressed\"") && stream.lines().count() == 2,
        "no rate holds for them: {stream}"
    );
    let mut late = session(&hub);
    let stream = answers(&mut late, &hub, "");
    let lines: Vec<&str> = stream.lines().collect();
    let last =
        "{\"class\":\"EVENT\",\"channel\":\"thumb\",\"event\":\"released\",\"time\":\"\",\"t_mono_ns\":2}";
    assert!(lines.len() == 2 && lines[1] == last, "{stream}");
    assert!(answers(&mut late, &hub, "{\"class\":\"POLL\"}\n").contains(last));
    // A stream that begins anew tells it again; raw there is none.
    assert_eq!(answers(&mut late, &hub, "{\"class\":\"WATCH\",\"raw\":true}\n"), "");
    assert_eq!(answers(&mut late, &hub, "{\"class\":\"WATCH\"}\n").trim_end(), last);
    // It is written before what came after it, however much was lost in between.
    let mut slow = session(&hub);
    answers(&mut slow, &hub, "");
    event(&mut hub, &mut slow, EventName::Pressed, 3);
    (1..=10).for_each(|seq| publish(&mut hub, &mut slow, seq));
    let stream = answers(&mut slow, &hub, "");
    let lines: Vec<&str> = stream.lines().collect();
    assert!(lines.len() == LINES + 1 && lines[0].contains("\"t_mono_ns\":3}"), "{stream}");
    assert!(lines[1].contains("\"lost\":6"), "{stream}");
    // Other channels are there: what the old ones were is over.
    event(&mut hub, &mut slow, EventName::Released, 4);
    reload(&mut hub, &mut slow, Unit::Ohm);
    (11..=20).for_each(|seq| publish(&mut hub, &mut slow, seq));
    assert!(!answers(&mut slow, &hub, "").contains("EVENT"));
    assert_eq!(answers(&mut session(&hub), &hub, "").lines().count(), 1);
}

#[test]
fn an_idle_client_holds_next_to_nothing() {
    let hub = hub();
    let mut session = session(&hub);
    answers(&mut session, &hub, &"{\"class\":\"POLL\"}\n".repeat(1000));
    answers(&mut session, &hub, &format!("{{\"x\":\"{}\"}}\n", "y".repeat(60_000)));
    assert!(session.output.capacity() <= KEPT_OUTPUT_BYTES && session.is_listening());
}

#[test]
fn every_reading_comes_after_its_own_version() {
    let mut hub = hub();
    let mut session = session(&hub);
    answers(&mut session, &hub, "");
    publish(&mut hub, &mut session, 1);
    reload(&mut hub, &mut session, Unit::Ohm);
    publish(&mut hub, &mut session, 2);
    let stream = answers(&mut session, &hub, "");
    let wanted = ["\"seq\":1,", "\"unit\":\"ohm\"", "\"seq\":2,"];
    let lines: Vec<&str> = stream.lines().collect();
    assert!(lines.len() == 3 && lines.iter().zip(wanted).all(|(line, part)| line.contains(part)), "{stream}");
    // Two at once: nothing was said under the first of them.
    reload(&mut hub, &mut session, Unit::Ohm);
    reload(&mut hub, &mut session, Unit::Newton);
    publish(&mut hub, &mut session, 3);
    let stream = answers(&mut session, &hub, "");
    assert!(stream.lines().count() == 2 && stream.contains("\"unit\":\"N\""), "{stream}");
    for seq in 4..1000 {
        reload(&mut hub, &mut session, Unit::Ohm);
        publish(&mut hub, &mut session, seq);
    }
    let stream = answers(&mut session, &hub, "");
    let lines: Vec<&str> = stream.lines().collect();
    assert!(
        lines.len() <= LINES + 1 && lines[0].contains("VERSION") && lines[1].contains("\"lost\":99"),
        "{stream}"
    );
    assert!(lines[lines.len() - 1].contains("\"seq\":999,"), "{stream}");
}

#[test]
fn a_new_stream_keeps_the_version_that_was_not_sent_yet() {
    let mut hub = hub();
    let mut session = session(&hub);
    answers(&mut session, &hub, "{\"class\":\"WATCH\",\"enable\":false}\n");
    reload(&mut hub, &mut session, Unit::Ohm);
    publish(&mut hub, &mut session, 1);
    let stream = answers(&mut session, &hub, "{\"class\":\"WATCH\"}\n");
    assert!(stream.lines().count() == 1 && stream.contains("\"unit\":\"ohm\""), "{stream}");
    publish(&mut hub, &mut session, 2);
    assert!(answers(&mut session, &hub, "").contains("\"seq\":2,"));
}

proptest! {
    #![proptest_config(crate::seed::cases(256))]

    /// However little the kernel takes at a time: whole lines in order, and received + lost = published.
    #[test]
    fn every_reading_is_received_or_counted(
        steps in prop::collection::vec((0u64..12, 0usize..900), 1..60),
        lines in 1usize..9,
    ) {
        let mut hub = hub();
        let mut session = Session::new(&hub, lines);
        let (mut stream, mut published) = (Vec::new(), 0);
        for (readings, room) in steps {
            for _ in 0..readings {
                published += 1;
                publish(&mut hub, &mut session, published);
            }
            send(&hub, &mut session, room, &mut stream);
        }
        send(&hub, &mut session, usize::MAX, &mut stream);
        let mut previous = 0;
        for line in stream.split_inclusive(|&byte| byte == b'\n').skip(1) {
            let line: serde_json::Value = serde_json::from_slice(line).unwrap();
            let (seq, lost) = (line["seq"].as_u64().unwrap(), line["lost"].as_u64().unwrap());
            prop_assert_eq!(seq, previous + lost + 1);
            previous = seq;
        }
        prop_assert_eq!(previous, published, "the newest is never lost");
    }
}
