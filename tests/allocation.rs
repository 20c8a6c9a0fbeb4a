//! The measuring loop allocates nothing, from its first step on, with every scene, circuit and method.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]
#![allow(
    unsafe_code,
    reason = "GlobalAlloc is an unsafe trait; every call goes on to the system's allocator"
)]

mod common;

use cermd::circuit::Node;
use cermd::instrument::{Instrument, Message};
use cermd::pins::Pins;
use cermd::reading::Method;
use cermd::units::Nanos;
use common::Bench;
use common::faulty::{Faulty, Injection};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    /// Of this thread alone: the threads of other tests may do as they like.
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

struct Counting;

fn count() {
    // A thread that is ending has no counter any more, and nobody who would read it.
    let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
}

// SAFETY: the contract of each call is that of the system's allocator, to which it is passed on as it is.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: see above.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count();
        // SAFETY: see above.
        unsafe { System.dealloc(pointer, layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: see above.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Allocations and releases of the first so many readings.
fn allocations<P: Pins>(instrument: &mut Instrument<P>, readings: u64) -> u64 {
    let before = ALLOCATIONS.get();
    let mut seen = 0;
    while seen < readings {
        let result =
            instrument.step(&mut |message| seen += u64::from(matches!(message, Message::Reading(_))));
        assert!(result.is_ok());
    }
    ALLOCATIONS.get() - before
}

#[test]
fn the_counter_counts() {
    let before = ALLOCATIONS.get();
    drop(std::hint::black_box(Vec::<u8>::with_capacity(10)));
    assert_eq!(ALLOCATIONS.get() - before, 2);
}

#[test]
fn a_step_allocates_nothing() {
    for scene in ["ideal", "fpga-paper", "pi-zero", "pi4", "pi5"] {
        for method in Method::ALL {
            let mut instrument = Bench::new(scene, method, 500.0, 1, "").instrument();
            // Enough for the offset to be found and followed, and for direct and inferred readings.
            assert_eq!(allocations(&mut instrument, 2000), 0, "{scene}, {}", method.as_str());
            assert!(instrument.stats().offset_is_known && instrument.stats().ok > 1500);
        }
    }
}

/// Two readings a second on a Pi 4, in virtual time. An instrument that allocates nothing cannot grow.
#[test]
fn eight_hours_take_no_memory_and_the_offset_stays() {
    let mut instrument = Bench::new("pi4", Method::Cerm, 1000.0, 1, "rate-hz = 2\nidle = true").instrument();
    let begin = instrument.pins().now();
    let (mut lateness, mut offsets) = (Vec::with_capacity(1 << 19), Vec::with_capacity(1 << 13));
    let before = ALLOCATIONS.get();
    while instrument.pins().now() - begin < Nanos(8 * 3600 * 1_000_000_000) {
        let mut a_ns = None;
        let mut take = |message| {
            if let Message::Discharge { record, .. } = message {
                a_ns = record.a_ns;
            }
        };
        assert!(instrument.step(&mut take).is_ok());
        let true_ns = instrument.pins().truth().crossing_ns(Node::A);
        lateness.extend(a_ns.zip(true_ns).map(|(a_ns, true_ns)| a_ns - true_ns));
        let offset = instrument.stats().offset;
        if instrument.stats().offset_is_known && offsets.last() != Some(&offset) {
            offsets.push(offset);
        }
    }
    assert_eq!(ALLOCATIONS.get() - before, 0);
    let stats = instrument.stats();
    assert!(stats.readings > 57_000 && stats.ok * 100 > stats.readings * 98, "{stats:?}");
    lateness.sort_by(f64::total_cmp);
    let d_ns = lateness[lateness.len() / 2];
    // About ten times as many rounds as one offset is the mean of: four sigma is one case in a thousand.
    assert!(offsets.len() > 80, "{}", offsets.len());
    for offset in offsets {
        assert!((offset.d_ns - d_ns).abs() < 4.0 * offset.u_d_ns, "{offset:?}, {d_ns} ns in truth");
    }
}

#[test]
fn neither_do_faults_and_outliers() {
    for method in Method::ALL {
        let (pins, settings) = Bench::new("pi4", method, 500.0, 1, "").parts();
        let mut pins = Faulty::new(pins, 2);
        for injection in Injection::ALL {
            // A call that fails does allocate: it brings the text of its error.
            let probability = if injection == Injection::FailingCall { 0.0 } else { 0.02 };
            pins = pins.with(injection, probability);
        }
        let mut instrument = Instrument::new(pins, settings);
        assert_eq!(allocations(&mut instrument, 5000), 0, "{}", method.as_str());
        let stats = instrument.stats();
        // There was something to trip over; a tracked calibration has fewer discharges that could be taken again.
        assert!(stats.faults.iter().sum::<u64>() > 100 && stats.retried > 50, "{stats:?}");
    }
}
