//! The stream over a real unix socket: what is promised to clients, good and bad.
//!
//! One thread plays the daemon's main loop and every client. Nothing here depends on time: a step is over when the
//! server has nothing more to do.

pub mod bench;
mod losses;

use bench::{Bench, Peer, channels, reading};
use cermd::stream::client::{Client, ClientError};
use cermd::stream::server::Limits;
use cermd::stream::tape::{DischargeLine, Header};
use serde_json::{Value, json};
use std::time::Duration;

/// The header of a tape.
fn header() -> Header {
    serde_json::from_value(json!({"class": "TAPE", "proto_major": 1, "channels": [{"id": "thumb"}],
        "circuit": {"kind": "one-capacitor", "r_c1_ohm": 1000.0, "r_c2_ohm": 2000.0}}))
    .unwrap()
}

/// A discharge of which nothing was seen, of a sensor or for calibration.
fn discharge(seq: u64, channel: Option<&str>) -> DischargeLine {
    let mut line = json!({"seq": seq, "through": if channel.is_some() { "x" } else { "c1" }});
    if let Some(channel) = channel {
        line["channel"] = json!(channel);
    }
    serde_json::from_value(line).unwrap()
}

/// Seq of each READING, and what they say was lost.
fn received(lines: &[Value]) -> (Vec<u64>, u64) {
    let readings = lines.iter().filter(|line| line["class"] == "READING");
    let (seqs, lost): (Vec<u64>, Vec<u64>) =
        readings.map(|line| (line["seq"].as_u64().unwrap(), line["lost"].as_u64().unwrap())).unzip();
    (seqs, lost.iter().sum())
}

fn error_code(line: &Value) -> &str {
    assert_eq!(line["class"], "ERROR", "{line}");
    assert!(line["message"].as_str().unwrap().len() > 10, "{line}");
    line["code"].as_str().unwrap()
}

#[test]
fn version_comes_first_then_readings_at_once() {
    let mut bench = Bench::new();
    bench.publish(3);
    let mut peer = bench.connect();
    bench.publish(2);
    let lines = bench.lines(&mut peer);
    let channels = json!([{"id": "thumb", "unit": "N"}, {"id": "index", "unit": "ohm"}]);
    assert_eq!(
        lines[0],
        json!({"class": "VERSION", "proto_major": 1, "proto_minor": 0,
        "release": env!("CARGO_PKG_VERSION"), "channels": channels})
    );
    assert_eq!(received(&lines), (vec![4, 5], 0));
    assert_eq!(lines.len(), 3);
    assert_eq!((&lines[1]["channel"], &lines[2]["channel"]), (&json!("index"), &json!("thumb")));
}

#[test]
fn watch_chooses_channels() {
    let mut bench = Bench::new();
    let mut peer = bench.connect();
    peer.send(r#"{"class":"WATCH","channels":["thumb","thumb"]}"#);
    bench.settle();
    bench.publish(6);
    assert_eq!(received(&bench.lines(&mut peer)), (vec![1, 3, 5], 0));
    peer.send(r#"{"class":"WATCH","enable":false}"#);
    bench.settle();
    bench.publish(6);
    assert_eq!(bench.lines(&mut peer), Vec::<Value>::new());
    peer.send(r#"{"class":"WATCH"}"#);
    bench.settle();
    bench.publish(2);
    assert_eq!(received(&bench.lines(&mut peer)), (vec![13, 14], 0));
}

#[test]
fn watch_thins_each_channel_to_its_rate() {
    let mut bench = Bench::new();
    let mut peer = bench.connect();
    // Readings come at 100 Hz, by turns of the channels: 50 Hz each.
    peer.send(r#"{"class":"WATCH","max_hz":10}"#);
    bench.settle();
    bench.publish(200);
    let (seqs, lost) = received(&bench.lines(&mut peer));
    let of_thumb = seqs.iter().filter(|seq| *seq % 2 == 1).count();
    assert_eq!((of_thumb, seqs.len(), lost), (20, 40, 0), "2 s at 10 Hz");
}

#[test]
fn poll_gives_the_last_reading_of_each_channel() {
    let mut bench = Bench::new();
    let mut peer = bench.connect();
    peer.send(r#"{"class":"WATCH","enable":false}"#);
    peer.send(r#"{"class":"POLL"}"#);
    let lines = bench.lines(&mut peer);
    assert_eq!((lines.len(), error_code(&lines[1])), (2, "no-reading"));
    bench.publish(1);
    peer.send(r#"{"class":"POLL"}"#);
    let lines = bench.lines(&mut peer);
    assert_eq!((received(&lines).0, error_code(&lines[1])), (vec![1], "no-reading"));
    assert!(!bench.server.is_watched(), "who polls does not wait");
    bench.publish(4);
    peer.send(r#"{"class":"POLL"}"#);
    assert_eq!(received(&bench.lines(&mut peer)), (vec![5, 4], 0));
}

#[test]
fn stats_has_the_figures_of_server_and_daemon() {
    let mut bench = Bench::new();
    let (mut peer, _other) = (bench.connect(), bench.connect());
    bench.publish(7);
    bench.lines(&mut peer);
    peer.send(r#"{"class":"STATS"}"#);
    let lines = bench.lines(&mut peer);
    let figures = ["class", "clients", "published", "lost", "uptime_s"].map(|key| lines[0][key].clone());
    assert_eq!((json!(figures), lines.len()), (json!(["STATS", 2, 7, 0, 12.5]), 1));
}

#[test]
fn a_reload_announces_the_new_channels() {
    let mut bench = Bench::new();
    let mut peer = bench.connect();
    peer.send(r#"{"class":"WATCH","channels":["index"]}"#);
    bench.lines(&mut peer);
    // "index" is now the first channel; the subscription goes by its name.
    bench.server.set_channels(&channels()[1..]);
    bench.settle();
    bench.server.publish_reading(&reading(0, 1), bench::TIME);
    bench.server.publish_reading(&reading(1, 2), bench::TIME); // measured before the reload
    let lines = bench.lines(&mut peer);
    assert_eq!(lines[0]["channels"], json!([{"id": "index", "unit": "ohm"}]));
    assert_eq!((received(&lines), lines.len()), ((vec![1], 0), 2));
    peer.send(r#"{"class":"WATCH","channels":["thumb"]}"#);
    assert_eq!(error_code(&bench.lines(&mut peer)[0]), "unknown-channel");
}

#[test]
fn raw_is_a_tape() {
    let mut bench = Bench::new();
    bench.server.set_tape_header(&header());
    let mut peer = bench.connect();
    assert!(!bench.server.wants_raw());
    peer.send(r#"{"class":"WATCH","raw":true,"channels":["thumb"]}"#);
    bench.settle();
    assert!(bench.server.wants_raw());
    for (seq, channel) in [(1, None), (2, Some("thumb")), (3, Some("index"))] {
        bench.server.publish_discharge(discharge(seq, channel));
    }
    bench.publish(1);
    let lines = bench.lines(&mut peer);
    let tape = [
        serde_json::to_value(header()).unwrap(),
        json!({"class": "DISCHARGE", "seq": 1, "through": "c1"}),
        json!({"class": "DISCHARGE", "seq": 2, "through": "x", "channel": "thumb"}),
    ];
    assert_eq!(lines[1..], tape);
}

#[test]
fn bad_input_is_answered_and_the_connection_stays() {
    let mut bench = Bench::new();
    let mut peer = bench.connect();
    bench.lines(&mut peer);
    let huge = "x".repeat(1 << 20);
    let cases: [(&[u8], &str); 8] = [
        (b"hello", "bad-request"),
        (b"\x00\x01\xfe\xff", "bad-request"),
        (b"[1,2,3]", "bad-request"),
        (b"{\"class\":\"POLL\",\"x\":1}", "bad-request"),
        (b"{\"class\":\"WATCH\",\"enable\":fal", "bad-request"),
        (b"{\"class\":\"READING\"}", "unknown-class"),
        (b"{\"class\":\"WATCH\",\"channels\":[\"toe\"]}", "unknown-channel"),
        (huge.as_bytes(), "line-too-long"),
    ];
    for (line, code) in cases {
        bench.send_through(&mut peer, line);
        bench.send_through(&mut peer, b"\n\r\n\n");
        let lines = bench.lines(&mut peer);
        assert_eq!((lines.len(), error_code(&lines[0])), (1, code));
    }
    bench.publish(1);
    assert_eq!(received(&bench.lines(&mut peer)), (vec![1], 0));
}

#[test]
fn a_request_may_come_byte_by_byte() {
    let mut bench = Bench::new();
    let mut peer = bench.connect();
    bench.publish(2);
    bench.lines(&mut peer);
    for byte in b"{\"class\":\"POLL\"}\n" {
        assert_eq!(bench.lines(&mut peer), Vec::<Value>::new());
        bench.send_through(&mut peer, &[*byte]);
    }
    assert_eq!(received(&bench.lines(&mut peer)).0, [1, 2]);
}

#[test]
fn a_client_that_closed_its_side_is_still_served() {
    let mut bench = Bench::new();
    let mut peer = bench.connect();
    peer.send_bytes(b"{\"class\":\"STATS\"}"); // printf without a newline
    peer.close_writing();
    bench.settle();
    bench.publish(1);
    let lines = bench.lines(&mut peer);
    assert_eq!((&lines[1]["class"], received(&lines).0), (&json!("STATS"), vec![1]));
    drop(peer);
    bench.settle();
    assert_eq!(bench.server.clients(), 0);
}

#[test]
fn answers_that_nobody_reads_do_not_pile_up() {
    let mut bench = Bench::new();
    let mut peer = bench.connect();
    let mut sent = 0;
    // The client asks until its own socket is full: the server has stopped listening to it.
    while bench.send_some(&mut peer, b"{\"class\":\"STATS\"}\n") {
        sent += 1;
        assert!(sent < 100_000, "the server goes on listening to who does not read");
    }
    let answers = bench.lines(&mut peer).iter().filter(|line| line["class"] == "STATS").count();
    assert_eq!(answers, sent, "every request is answered in the end");
}

#[test]
fn five_hundred_clients_get_every_reading() {
    bench::allow_descriptors(4000);
    let mut bench = Bench::new();
    let mut peers: Vec<Peer> = (0..500).map(|_| bench.connect()).collect();
    let mut stalled = bench.connect();
    for _ in 0..20 {
        bench.publish(10);
        for peer in &mut peers {
            peer.receive();
        }
    }
    for (index, peer) in peers.iter_mut().enumerate() {
        assert_eq!(received(&bench.lines(peer)), ((1..=200).collect(), 0), "client {index}");
    }
    let (seqs, lost) = received(&bench.lines(&mut stalled));
    assert_eq!(seqs.len() as u64 + lost, 200);
}

#[test]
fn a_thousand_connects_leave_nothing_behind() {
    let mut bench = Bench::new();
    for round in 0..1000 {
        let mut peer = bench.connect();
        if round % 2 == 0 {
            peer.send_bytes(b"{\"class\":\"WA"); // half a line
        }
        if round % 3 == 0 {
            bench.settle();
        }
    }
    bench.settle();
    assert_eq!(bench.server.clients(), 0);
    let mut peer = bench.connect();
    bench.publish(1);
    assert_eq!(received(&bench.lines(&mut peer)), (vec![1], 0));
}

#[test]
fn one_client_too_many_is_told_so() {
    let mut bench = Bench::with(Limits { clients: 2, ..Limits::default() });
    let (first, _second) = (bench.connect(), bench.connect());
    let mut third = bench.connect();
    assert_eq!(error_code(&bench.lines(&mut third)[0]), "busy");
    assert!(third.is_closed());
    drop(first);
    bench.settle();
    let mut fourth = bench.connect();
    assert_eq!(bench.lines(&mut fourth)[0]["class"], "VERSION");
}

#[test]
fn the_client_library_talks_to_it() {
    let mut bench = Bench::new();
    let path = bench.path();
    // The server runs in this thread, so VERSION must wait in the socket before the client can read it.
    let client = std::thread::spawn(move || Client::connect(&path, crate::waiting::PATIENCE));
    while bench.server.clients() == 0 {
        bench.settle();
    }
    let mut client = client.join().unwrap().unwrap();
    assert_eq!(client.version().channels, channels());
    client.request(&cermd::stream::wire::Request::Poll).unwrap();
    bench.settle();
    bench.publish(1);
    let code = |message| match message {
        Ok(Some(cermd::stream::wire::ServerMessage::Error(error))) => error.code,
        other => panic!("{other:?}"),
    };
    assert_eq!(code(client.message()), cermd::stream::wire::ErrorCode::NoReading);
    let Ok(Some(cermd::stream::wire::ServerMessage::Reading(reading))) = client.message() else {
        panic!("no reading")
    };
    assert_eq!((reading.seq, reading.channel.as_str(), reading.lost), (1, "thumb", 0));
    drop(bench);
    assert!(matches!(client.message(), Ok(None)));
}

#[test]
fn the_client_library_says_what_is_wrong() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("s");
    let timeout = Duration::from_millis(1);
    assert!(matches!(Client::connect(&path, timeout), Err(ClientError::NoSocket(_))));
    let listener = std::os::unix::net::UnixListener::bind(&path).unwrap();
    assert!(matches!(Client::connect(&path, timeout), Err(ClientError::TimedOut(_))));
    drop(listener);
    assert!(matches!(Client::connect(&path, timeout), Err(ClientError::NobodyThere(_))));
}
