//! The measuring loop allocates nothing, from its first step on, with every scene, circuit and method.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]
#![allow(
    unsafe_code,
    reason = "GlobalAlloc is an unsafe trait; every call goes on to the system's allocator"
)]

mod common;

use cermd::instrument::{Instrument, Message};
use cermd::pins::Pins;
use cermd::pins::faulty::{Faulty, Injection};
use cermd::reading::Method;
use common::Bench;
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
