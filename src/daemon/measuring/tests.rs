use super::*;
use crate::config_file;
use crate::daemon::limits::STOP_PATIENCE;
use crate::pins::monotonic;
use crate::pins::sim::{Scene, SimPins};
use crate::pins::{Armed, Bracket, Drives, Edge, Levels, Particulars};
use std::sync::atomic::AtomicU32;

fn config(scene: &str) -> (Config, Settings) {
    let config = config_file::config(|c| {
        c.set("circuit.v-th", "1.1 V").set("gpio.backend", "mock").channel("x").set("mock.scene", scene)
    });
    let config = config.parse();
    let settings = config.settings().unwrap();
    (config, settings)
}

/// Pins with a mistake in the program that shows at the last of so many waits for an edge.
struct Mistaken {
    pins: SimPins,
    waits: u32,
    /// How many lines drive, for all to see.
    driving: Arc<AtomicU32>,
}

impl Pins for Mistaken {
    fn now(&mut self) -> Nanos {
        self.pins.now()
    }
    fn drive(&mut self, on: Drives) -> Result<Bracket, PinsError> {
        self.driving.store(on.count(), Ordering::SeqCst);
        self.pins.drive(on)
    }
    fn arm(&mut self) -> Result<Armed, PinsError> {
        self.pins.arm()
    }
    fn edge(&mut self, until: Nanos) -> Result<Option<Edge>, PinsError> {
        self.waits -= 1;
        assert!(self.waits > 0, "a panic that this test asks for, {} lines driving", self.driving());
        self.pins.edge(until)
    }
    fn sleep_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.pins.sleep_until(at)
    }
    fn levels(&mut self) -> Result<Levels, PinsError> {
        self.pins.levels()
    }
    fn rest_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.pins.rest_until(at)
    }
    fn rest_before_edge(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.pins.rest_before_edge(at)
    }
    fn particulars(&self) -> Particulars<'_> {
        self.pins.particulars()
    }
}

impl Mistaken {
    fn driving(&self) -> u32 {
        self.driving.load(Ordering::SeqCst)
    }
}

/// A circuit whose nodes stay high: each wait for an edge lasts as long as it may. It takes no time but that of its call.
struct Endless {
    now: Nanos,
    call: Duration,
    driving: Arc<AtomicU32>,
    waits: Arc<AtomicU32>,
}

impl Pins for Endless {
    fn now(&mut self) -> Nanos {
        self.now
    }
    fn drive(&mut self, on: Drives) -> Result<Bracket, PinsError> {
        self.driving.store(on.count(), Ordering::SeqCst);
        Ok(Bracket { before: self.now, after: self.now })
    }
    fn arm(&mut self) -> Result<Armed, PinsError> {
        Ok(Armed { levels: self.levels()?, seqno: 0, line_seqno: [0; 2] })
    }
    fn edge(&mut self, until: Nanos) -> Result<Option<Edge>, PinsError> {
        self.waits.fetch_add(1, Ordering::SeqCst);
        thread::sleep(self.call);
        self.now = until;
        Ok(None)
    }
    fn sleep_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.now = self.now.max(at);
        Ok(())
    }
    fn levels(&mut self) -> Result<Levels, PinsError> {
        Ok(Levels { a: true, b: true })
    }
    fn rest_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.sleep_until(at)
    }
    fn rest_before_edge(&mut self, _at: Nanos) -> Result<(), PinsError> {
        Ok(())
    }
    fn particulars(&self) -> Particulars<'_> {
        Particulars::default()
    }
}

/// A measurement of it, how many lines drive, and how many waits there were.
fn endless(call: Duration) -> (Measuring, Arc<AtomicU32>, Arc<AtomicU32>) {
    let config = config_file::config(|c| c.set("measure.deadline", "3600 s").channel("x")).parse();
    let settings = config.settings().unwrap();
    let [driving, waits] = [(); 2].map(|()| Arc::new(AtomicU32::new(0)));
    let pins = Endless { now: Nanos::ZERO, call, driving: Arc::clone(&driving), waits: Arc::clone(&waits) };
    (Measuring::start(Ok(Box::new(pins)), config, settings, None).unwrap(), driving, waits)
}

#[test]
fn a_thread_that_hangs_is_not_waited_for_without_limit() {
    let (mut measuring, _, waits) = endless(Duration::from_secs(3600));
    while waits.load(Ordering::SeqCst) == 0 {
        thread::yield_now();
    }
    let asked = monotonic();
    assert!(measuring.stop().is_err(), "it has ended");
    // As a service manager that waits 10 s asks for it, whatever else this machine does.
    assert!(monotonic() - asked >= STOP_PATIENCE);
    let again = monotonic();
    drop(measuring);
    assert!(monotonic() - again < STOP_PATIENCE, "it is waited for once more");
}

#[test]
fn a_long_discharge_looks_alive_and_ends_when_it_is_to() {
    let (mut measuring, driving, waits) = endless(Duration::from_millis(1));
    while waits.load(Ordering::SeqCst) < 3 {
        thread::yield_now();
    }
    assert_eq!(driving.load(Ordering::SeqCst), 1);
    let beat = measuring.beat();
    while waits.load(Ordering::SeqCst) < 10 {
        thread::yield_now();
    }
    assert!(measuring.beat() > beat, "no sign of life within a discharge");
    measuring.stop().unwrap();
    // An hour in pieces of 100 ms, each of them 1 ms here.
    assert!(waits.load(Ordering::SeqCst) < 36_000, "the discharge went on to its deadline");
    assert_eq!(driving.load(Ordering::SeqCst), 0);
    while let Some(update) = measuring.next() {
        assert!(matches!(update, Update::Realtime(_) | Update::Found(_) | Update::Stats(_)), "{update:?}");
    }
}

#[test]
fn a_panic_ends_the_measurement_with_every_line_released() {
    let (config, settings) = config("ideal");
    let driving = Arc::new(AtomicU32::new(u32::MAX));
    let pins = SimPins::new(&Scene::builtin("ideal").unwrap(), None);
    let pins = Mistaken { pins, waits: 20, driving: Arc::clone(&driving) };
    let mut measuring = Measuring::start(Ok(Box::new(pins)), config, settings, None).unwrap();
    while !measuring.has_ended() {
        thread::yield_now();
    }
    assert_eq!(driving.load(Ordering::SeqCst), 0);
    assert!(matches!(measuring.next(), Some(Update::Realtime(_))));
    assert!(matches!(measuring.next(), Some(Update::Message(_))), "what was measured before is still there");
    measuring.stop().unwrap();
}

#[test]
fn readings_wake_nobody_while_nobody_watches() {
    let (config, settings) = config("ideal");
    for watched in [false, true] {
        let pins = SimPins::new(&Scene::builtin("ideal").unwrap(), None);
        let measuring =
            &mut Measuring::start(Ok(Box::new(pins)), config.clone(), settings.clone(), None).unwrap();
        measuring.set_watched(watched);
        // What was sent before that.
        let _ = measuring.wake().read();
        let (mut readings, mut others) = (0, 1);
        while readings < 200 {
            match measuring.next() {
                Some(Update::Message(Message::Reading(_))) => readings += 1,
                Some(Update::Message(Message::Discharge { .. })) => {}
                Some(_) => others += 1,
                None => thread::yield_now(),
            }
        }
        measuring.stop().unwrap();
        let wakes = measuring.wake().read().unwrap_or(0);
        while let Some(update) = measuring.next() {
            others += u64::from(!matches!(update, Update::Message(_)));
        }
        assert_eq!(wakes > others + 100, watched, "{wakes} wake-ups, {others} reports that are no readings");
    }
}

#[test]
fn what_was_kept_is_told_as_soon_as_somebody_watches() {
    let (config, settings) = config("ideal");
    let pins = SimPins::new(&Scene::builtin("ideal").unwrap(), None);
    let mut measuring = Measuring::start(Ok(Box::new(pins)), config, settings, None).unwrap();
    measuring.stop().unwrap();
    measuring.set_watched(false);
    let _ = measuring.wake().read();
    measuring.set_watched(true);
    assert_eq!(measuring.wake().read(), Ok(1));
    measuring.set_watched(true);
    assert!(measuring.wake().read().is_err(), "nothing has changed");
}

#[test]
fn pins_that_are_missing_are_opened_by_and_by() {
    let (config, settings) = config("pi4");
    let held = Err(OpenError::Missing("a line that is free by now".to_owned()));
    let mut measuring = Measuring::start(held, config, settings, None).unwrap();
    let mut told = Vec::new();
    let reading = loop {
        match measuring.next() {
            Some(Update::Message(Message::Reading(reading))) => break reading,
            Some(Update::NotOpened(error)) => told.push(error.to_string()),
            _ => thread::yield_now(),
        }
    };
    assert!(matches!(&told[..], [why] if why.contains("free by now")), "{told:?}");
    assert_ne!(reading.status, crate::reading::Status::Fault(crate::reading::Fault::Pins));
}

#[test]
fn a_reason_is_told_once() {
    let (config, settings) = config("nowhere.toml");
    let pins = backend::open(&config, Nanos::ZERO);
    let mut measuring = Measuring::start(pins, config, settings, None).unwrap();
    let begin = measuring.beat();
    // Two rounds of trying, each of ten naps.
    while measuring.beat() < begin + 25 {
        thread::sleep(Duration::from_millis(10));
    }
    measuring.stop().unwrap();
    let (mut complaints, mut faults) = (0, 0);
    while let Some(update) = measuring.next() {
        match update {
            Update::NotOpened(_) => complaints += 1,
            Update::Message(Message::Reading(reading)) => {
                assert_eq!(reading.status, crate::reading::Status::Fault(crate::reading::Fault::Pins));
                faults += 1;
            }
            Update::Realtime(_) | Update::Found(_) | Update::Stats(_) => {}
            other => panic!("{other:?}"),
        }
    }
    // But whoever reads hears in each round that there is no reading; a busy machine may see one more.
    assert!(complaints == 1 && faults >= 2, "{complaints} complaints, {faults} faults");
}

/// Holds the gaps in the numbers of readings and discharges against what was told as lost.
#[derive(Default)]
struct Gaps {
    reading: u64,
    discharge: u64,
    lost: Lost,
    seen: u32,
}

impl Gaps {
    fn look(&mut self, update: &Update) {
        let (before, told, now) = match update {
            Update::Lost(lost) => {
                assert!(lost.is_some());
                self.lost.add(*lost);
                self.seen += 1;
                return;
            }
            Update::Message(Message::Reading(reading)) => {
                (&mut self.reading, &mut self.lost.readings, reading.seq)
            }
            Update::Message(Message::Discharge { seq, .. }) => {
                (&mut self.discharge, &mut self.lost.discharges, *seq)
            }
            _ => return,
        };
        assert_eq!(now - mem::replace(before, now) - 1, mem::take(told), "before {now}");
    }
}

#[test]
fn what_a_full_ring_loses_is_told_where_the_gap_is() {
    let (config, settings) = config("ideal");
    let pins = SimPins::new(&Scene::builtin("ideal").unwrap(), None);
    let mut measuring = Measuring::start(Ok(Box::new(pins)), config, settings, None).unwrap();
    let mut gaps = Gaps::default();
    let overflow = |measuring: &Measuring| {
        let beat = measuring.beat();
        // A message takes a few beats.
        while measuring.beat() < beat + 50 * RING as u64 {
            thread::yield_now();
        }
    };
    while gaps.seen < 3 {
        overflow(&measuring);
        // Not all: the thread is as fast.
        for _ in 0..RING {
            if let Some(update) = measuring.next() {
                gaps.look(&update);
            }
        }
    }
    overflow(&measuring);
    measuring.stop().unwrap();
    let mut last = None;
    while let Some(update) = measuring.next() {
        gaps.look(&update);
        last = Some(update);
    }
    assert!(matches!(last, Some(Update::Lost(_))), "also what was lost at the end: {last:?}");
}
