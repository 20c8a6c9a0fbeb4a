//! A daemon that is killed: its clients see whole lines, and the next one serves.
//!
//! How soon it serves is printed, for docs/performance.md; a machine that does other things takes its time.

use super::process::{Home, config};
use crate::common::seed::rng;
use nix::sys::signal::Signal;
use rand::RngExt;
use std::time::{Duration, Instant};

const SEED: u64 = 20;
const KILLS: usize = 20;
const CLIENTS: usize = 4;

#[test]
fn whole_lines_before_the_kill_and_readings_after_the_next_start() {
    let home = Home::new(&config(&["thumb", "index"], "offset = \"8 us\""));
    let mut rng = rng(SEED);
    let (mut lines, mut times) = (0, Vec::new());
    for _ in 0..KILLS {
        let started = Instant::now();
        let daemon = home.start();
        home.connect().next_of("READING");
        times.push(started.elapsed());
        let clients: Vec<_> = (0..CLIENTS)
            .map(|_| {
                let mut stream = home.connect();
                stream.next_of("READING");
                std::thread::spawn(move || 1 + stream.drain())
            })
            .collect();
        // Anywhere in a line, and in the time between two.
        std::thread::sleep(Duration::from_micros(rng.random_range(0..100_000)));
        daemon.signal(Signal::SIGKILL);
        daemon.end();
        // Every one of them was a whole line of JSON, or drain() has panicked.
        lines += clients.into_iter().map(|client| client.join().unwrap()).sum::<usize>();
    }
    times.sort();
    let (median, most) = (times[KILLS / 2], times[KILLS - 1]);
    println!("{KILLS} kills: {lines} whole lines; serves after {median:.1?}, at most {most:.1?}");
}
