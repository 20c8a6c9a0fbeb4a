//! The constants of judgement of the pins: value and unit, the range that makes sense, and where it comes from.

use crate::units::Nanos;
use std::time::Duration;

/// As many edges as the largest buffer of uAPI v2 keeps; arming forgets no more of them, for on a line that catches a radio
/// edges may come faster than they are read. From 32 up, what v1 keeps of two lines.
pub(super) const MOST_STALE_EDGES: u32 = 1024;
/// How often a line that is still held is asked for again, after a kill: the kernel closes the files of a process with a
/// delay. With the pause half a second at most for all lines of the circuit, and as much for all outputs, which the service manager
/// allows; tests/vm, 60-killed.sh.
pub(super) const RELEASE_ATTEMPTS: u32 = 10;
/// Between two attempts.
pub(super) const RELEASE_PAUSE: Duration = Duration::from_millis(50);
/// How many similar names an unknown one is answered with: as many as are read at a glance.
pub(super) const SUGGESTIONS: usize = 3;

/// A program never stops sleeping later than this before an instant: the shortest wake-ups of the fastest boards.
pub(super) const LEAST_SPIN_MARGIN: Nanos = Nanos(20_000);
/// Nor earlier: a wake-up that comes later than this cannot be bought with processor time.
pub(super) const MOST_SPIN_MARGIN: Nanos = Nanos(500_000);
/// Before anything is learned: the usual lateness of a wake-up without real-time scheduling, with the default timer slack
/// of 50 us (prctl(2)).
pub(crate) const FIRST_SPIN_MARGIN: Nanos = Nanos(100_000);
/// The resolution of the coarse clocks where the kernel does not tell it: CONFIG_HZ = 1000, the fastest there is.
pub(super) const SHORTEST_TICK: Nanos = Nanos(1_000_000);
/// The first Linux whose ticks are at whole multiples of their period.
pub(super) const ALIGNED_TICKS: (u32, u32) = (6, 4);

/// How many changes of lines the truth of one discharge keeps: a start, a switch and an end, of two lines each.
pub(super) const CHANGES_KEPT: usize = 16;
/// What changes by a smaller part of itself has one value, against which a reading can be held: with a third or three times of it the
/// readings of a hand are as true (tests/accuracy, dynamic).
pub(super) const ONE_VALUE: f64 = 0.1;
/// A simulated call is never shorter than this share of its usual duration: above 0, so that time never goes back, and far
/// below the jitter of any scene.
pub(super) const SHORTEST_CALL: f64 = 0.1;
/// Where in its slot a line moves, from .. to, if a scene does not say it.
pub(super) const MIDDLE_OF_SLOT: [f64; 2] = [0.5; 2];
/// The longest of all that is late, a call, a wake-up, an edge, seconds: a slower board is a slip of a prefix, and a simulated
/// call that took for ever could not be stopped.
pub(super) const LATEST: f64 = 1.0;
/// The latest place of a move, in slots: a write that is posted arrives after some calls, not after hundreds.
pub(super) const LATEST_MOVE: f64 = 100.0;
/// Branches that one capacitor's absorption may have: one a decade from 10 us to 1 s.
pub(super) const MOST_BRANCHES: usize = 6;
/// Events that the kernel keeps for each line of a request (drivers/gpio/gpiolib-cdev.c).
pub(super) const EVENTS_A_LINE: usize = 16;
/// Nor more than this of a request (the same).
pub(super) const MOST_EVENTS: u32 = 1024;
/// How often the end of a bracket is searched for twice as far away: the slowest circuit of interest crosses far below
/// 2^200 time constants.
pub(super) const MOST_DOUBLINGS: u32 = 200;
/// Steps of a root search: bisection alone takes about 60 halvings for each decade of uncertainty that it starts with.
pub(super) const MOST_ROOT_STEPS: u32 = 400;
/// Sweeps of Jacobi's method over a matrix of 14: it converges quadratically, and 5 to 8 sweeps are the rule.
pub(super) const MOST_SWEEPS: u32 = 30;
/// Steps of Newton's method for the first crossing of noise: only bounds it, for it converges from every start.
pub(super) const MOST_NOISE_STEPS: u32 = 60;
/// The earliest first crossing, in standard deviations of the noise: beyond it lies less than 1e-32 of its probability.
pub(super) const EARLIEST_CROSSING: f64 = -12.0;

/// An untouched force sensor, ohm: the FSR 402 data sheet says above 10 Mohm.
pub(super) const UNTOUCHED_OHM: f64 = 20e6;
/// A hand trembles at about this frequency, Hz: physiological tremor is at 8 Hz to 12 Hz.
pub(super) const TREMOR_HZ: f64 = 9.0;
/// By this share of its force; a guess.
pub(super) const TREMOR_SHARE: f64 = 0.02;
/// The strongest press of a hand that a scene does not describe, newton: firm, in the middle of what [`FSR_402`](crate::sensor::FSR_402) holds for.
pub(super) const PEAK_NEWTON: f64 = 10.0;
/// From one press of it to the next, seconds: unhurried.
pub(super) const PERIOD_SECONDS: f64 = 2.0;
/// When a press begins, as a share of the period from .. to; as it rises it falls again, so that the latest, slowest and
/// longest one, 0.25 + 0.2 + 0.3 + 0.2, still ends within its period. These four are guesses.
pub(super) const PRESS_BEGINS: [f64; 2] = [0.05, 0.25];
/// How long it rises, and falls, likewise.
pub(super) const PRESS_RISES: [f64; 2] = [0.06, 0.2];
/// How long it is held, likewise.
pub(super) const PRESS_HOLDS: [f64; 2] = [0.1, 0.3];
/// How strong it is, as a share of the strongest.
pub(super) const PRESS_FORCE: [f64; 2] = [0.1, 1.0];
/// How long a sensor that changes is held constant, ns: short against a discharge, whose integral is then that of a
/// ramp to 1e-4 (test `a_ramp_is_integrated`).
pub(super) const SAMPLE_NS: i64 = 50_000;
