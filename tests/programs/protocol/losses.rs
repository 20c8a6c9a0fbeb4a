//! What is lost on the way to a client is counted, and told where the gap is.

use super::bench::Bench;
use super::{discharge, error_code, received};
use serde_json::Value;

fn readings(lines: &[Value]) -> Vec<&Value> {
    lines.iter().filter(|line| line["class"] == "READING").collect()
}

#[test]
fn a_stalled_client_loses_only_its_own_oldest_readings() {
    let mut bench = Bench::new();
    let (mut stalled, mut live) = (bench.connect(), bench.connect());
    let published = 5000;
    let mut live_seqs = Vec::new();
    for _ in 0..published {
        bench.publish(1);
        live_seqs.extend(received(&bench.lines(&mut live)).0);
    }
    assert_eq!(live_seqs, (1..=published).collect::<Vec<_>>(), "the other client got each at once");
    let lines = bench.lines(&mut stalled);
    let (seqs, lost) = received(&lines);
    assert_eq!(seqs.len() as u64 + lost, published);
    assert!(lost > 3000, "{lost} lost: the kernel and the ring hold few");
    assert_eq!(seqs.last(), Some(&published), "the newest are kept");
    // `lost` is told by the first reading after each gap, and is its length.
    let mut previous = 0;
    for line in readings(&lines) {
        let seq = line["seq"].as_u64().unwrap();
        assert_eq!(line["lost"], seq - previous - 1, "at {seq}");
        previous = seq;
    }
}

#[test]
fn what_a_filter_drops_is_not_lost() {
    let mut bench = Bench::new();
    let mut thumb = bench.connect();
    let mut thinned = bench.connect();
    thumb.send(r#"{"class":"WATCH","channels":["thumb"]}"#);
    thinned.send(r#"{"class":"WATCH","channels":["thumb"],"max_hz":25}"#);
    bench.settle();
    bench.publish(20_000);
    let (seqs, lost) = received(&bench.lines(&mut thumb));
    assert!(lost > 0);
    assert_eq!(seqs.len() as u64 + lost, 10_000);
    let (seqs, lost) = received(&bench.lines(&mut thinned));
    assert!(lost > 0);
    assert_eq!(seqs.len() as u64 + lost, 5_000, "25 of the 50 Hz of its channel");
}

#[test]
fn what_the_instrument_loses_is_told_to_everybody() {
    let mut bench = Bench::new();
    let mut peer = bench.connect();
    bench.publish(2);
    bench.server.miss(3, 100);
    bench.publish(2);
    let lines = bench.lines(&mut peer);
    let lost: Vec<_> = readings(&lines).into_iter().map(|line| line["lost"].clone()).collect();
    assert_eq!(lost, [0, 0, 3, 0], "told where the gap is");
}

#[test]
fn losses_on_the_way_add_to_those_of_a_slow_client_at_their_places() {
    let mut bench = Bench::new();
    let mut stalled = bench.connect();
    let mut expected = 0;
    for _ in 0..5000 {
        bench.publish(1);
        bench.server.miss(2, 1);
        expected += 3;
    }
    bench.publish(1);
    let lines = bench.lines(&mut stalled);
    let (seqs, lost) = received(&lines);
    assert_eq!(seqs.len() as u64 + lost, expected + 1);
    assert!(seqs.len() < 5000, "it lost some by itself");
    for pair in readings(&lines).windows(2) {
        let [before, after] = [pair[0], pair[1]].map(|line| line["seq"].as_u64().unwrap());
        assert_eq!(pair[1]["lost"], 3 * (after - before) - 1, "at {after}");
    }
}

#[test]
fn losses_of_a_tape_are_told() {
    let mut bench = Bench::new();
    let mut peer = bench.connect();
    peer.send(r#"{"class":"WATCH","raw":true}"#);
    bench.lines(&mut peer);
    for seq in 1..=5000 {
        bench.server.publish_discharge(discharge(seq, None));
        bench.settle();
    }
    let mut previous = 0;
    let mut gap = 0;
    for line in bench.lines(&mut peer) {
        if line["class"] == "ERROR" {
            assert_eq!(error_code(&line), "lost");
            gap = line["lost"].as_u64().unwrap();
            assert!(gap > 0);
        } else {
            assert_eq!(line["seq"], previous + 1 + gap);
            previous += 1 + std::mem::take(&mut gap);
        }
    }
    assert_eq!(previous, 5000);
}
