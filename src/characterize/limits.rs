//! The constants of judgement of this room.
//!
//! | constant | value | unit | reason |
//! |---|---|---|---|
//! | `WARM`, `COLD` | 4, 30 | s | readings count from the first on (tracked: up to `LONGEST_UNSEEN` later), where state, noise and leaks are known; without an offset by the second they count as they are |
//! | `WARM_CYCLES`, `LEAST_WARM` | 2000, 2 | cycles, s | the same with a common clock and without a tracked state, where that is sooner: u is within 1 % of what it becomes |
//! | `MOST_DISCHARGES`, `LEAST_INSTRUMENTS` | 3e5, 3 | | of a cell: a circuit for microseconds takes fewer instruments |
//! | `LONGEST_MEAN` | 20 000 | cycles | the same of what is averaged |
//! | `SINCE_START` | 0.05 to 10 | s | ends of the stretches in which settling is looked at |
//! | `SWING` | 0.5 | R_x | so far a moving sensor goes to either side of its resistance at the most: a share of what it is there stays one of R_x |
//! | `TOLERANCE` | 0.01 | | capacitors differ by so much where a clock quantises: else every crossing of a board would fall at the same place in a cycle |
//! | `FRONT_OHM`, `AVERAGES` | 100 to 16 200; 0 to 10 | ohm; s | those of docs/methods.md, and times of a decade each; 0: each reading |
//! | `MAP_OHM` | 30 to 100 000 | ohm | those of the front, and half-decades beside them |
//! | `EFFECT_OHM`, `SETTLING_OHM` | | ohm | low, middle and high |
//! | `JITTERS_S` to `SPEEDS` | | s, s, 1, ohm, 1/s | from what changes nothing to what nothing stands |
//! | `PAPER_OHM`, `PAPER_READINGS` | 100 to 16 200; 500 | ohm | section V; sections IV and V name 100, 681, 15 010 and 16 200 ohm, the others are of E96 |
//! | `PAPER_T_L`, `ALWAYS` | 12.32 us, 1 s | | section V: T_L = 616 cycles; longer than any discharge of the paper |
//! | `DIGITS` | 6 | | significant digits of a figure in a table: no figure is known better |

use crate::units::Nanos;

pub const WARM: Nanos = Nanos(4_000_000_000);
pub const COLD: Nanos = Nanos(30_000_000_000);
pub const WARM_CYCLES: f64 = 2000.0;
pub const LEAST_WARM: Nanos = Nanos(2_000_000_000);
pub const MOST_DISCHARGES: f64 = 3e5;
pub const LEAST_INSTRUMENTS: u64 = 3;
pub const LONGEST_MEAN: f64 = 20_000.0;
pub const SINCE_START: [f64; 8] = [0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0];
pub const SWING: f64 = 0.5;
pub const TOLERANCE: f64 = 0.01;
pub const DIGITS: usize = 6;
pub const FRONT_OHM: [f64; 4] = [100.0, 1000.0, 5000.0, 16_200.0];
pub const AVERAGES: [Nanos; 5] =
    [Nanos::ZERO, Nanos(10_000_000), Nanos(100_000_000), Nanos(1_000_000_000), Nanos(10_000_000_000)];
pub const MAP_OHM: [f64; 8] = [30.0, 100.0, 300.0, 1000.0, 5000.0, 16_200.0, 50_000.0, 100_000.0];
pub const EFFECT_OHM: [f64; 3] = [100.0, 1000.0, 16_200.0];
pub const SETTLING_OHM: [f64; 2] = [100.0, 16_200.0];
pub const JITTERS_S: [f64; 5] = [0.1e-6, 0.5e-6, 2e-6, 8e-6, 30e-6];
pub const OFFSET_ERRORS_S: [f64; 5] = [0.1e-6, 0.5e-6, 2e-6, 8e-6, 30e-6];
pub const CAPACITORS: [f64; 5] = [0.1, 0.3, 1.0, 3.0, 10.0];
pub const LEAKAGES_OHM: [f64; 5] = [1e6, 3e6, 10e6, 30e6, 100e6];
pub const SPEEDS: [f64; 5] = [0.01, 0.1, 1.0, 10.0, 100.0];
pub const PAPER_OHM: [f64; 28] = [
    100.0, 121.0, 150.0, 182.0, 221.0, 274.0, 332.0, 402.0, 475.0, 562.0, 681.0, 825.0, 1000.0, 1210.0,
    1500.0, 1820.0, 2210.0, 2740.0, 3320.0, 4020.0, 4870.0, 5900.0, 7150.0, 8660.0, 10_700.0, 13_000.0,
    15_010.0, 16_200.0,
];
pub const PAPER_READINGS: usize = 500;
pub const PAPER_T_L: Nanos = Nanos(12_320);
pub const ALWAYS: Nanos = Nanos(1_000_000_000);
