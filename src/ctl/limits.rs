//! The constants of judgement of this room: how long a person waits, and how much a screen shows.
//!
//! | constant | value | unit | reason |
//! |---|---|---|---|
//! | `LOOK_AROUND` | 0.1 | s | how long a verb waits for a line before it looks for Ctrl-C or the end of its time |
//! | `ANSWER` | 2 | s | a busy daemon greets and answers well within it |
//! | `STARTED` | 20 | s | a service that was just started listens by then, on the slowest board |
//! | `FIRST_READING` | 5 | s | an instrument that has just started has one by then |
//! | `NEXT_READING` | 10 | s | the next discharge or reading while something is calibrated |
//! | `RETRY_AFTER` | 0.25 | s | from one attempt to connect again to the next |
//! | `REDRAW_AFTER` | 0.04 | s | live lines: faster than the eye, slower than a slow terminal |
//! | `SAY_AFTER` | 0.5 | s | the demo on anything but a terminal shows one reading in it |
//! | `HISTORY_S` | 10 | s | how far back the sparklines go |
//! | `HISTORY` | 10 000 | readings | that are kept for them |
//! | `RATE_WINDOW` | 2 | s | readings per second are counted over it |
//! | `SILENT_S`, `SILENT_READINGS` | 2, 3 | s, readings | after this much silence, the longer of both, a number is no longer shown as one of now |
//! | `FULL_N` | 10 | N | a bar is full at about so much, 10 to the something of what is shown, until a reading is beyond it |
//! | `NAME_COLUMNS` | 11 | columns | a longer name is cut where numbers need the room |
//! | `BAR_OHM` | 10 to 1e6 | ohm | a bar of ohms is logarithmic, full at the first and empty at the second |
//! | `BAR_COLUMNS`, `HISTORY_COLUMNS` | 6 to 30, 60 | columns | a narrower bar shows nothing; wider ones are not easier to read |
//! | `PROGRESS_COLUMNS` | 24 | columns | leaves room for words at 80 columns |
//! | `LIVE_READINGS`, `LIVE_AVERAGES`, `LIVE_MEANS` | 400; 0, 1 s; 10 | readings | of a resistor on hardware: the root mean square is known to 4 %, and somebody waits for it |
//! | `MISTAKEN` | 0.2, 50 | R, ohm | a reading that is off by more is that of another resistor |
//! | `WORST_FIT` | 0.5 | | residuals beyond it are a mistake: two sensors of a kind differ by a tenth of it |
//! | `WAKE_UPS`, `SLEEP` | 300, 1 | , ms | sleeps that are timed by `check` |
//! | `DISCHARGES` | 50 | | discharges that are timed by `check` |
//! | `SHARES_OF_R_2` | 0.01 to 4 | R_2 | resistances of which `check` says what to expect: what Rc2 is chosen for |
//! | `WARM`, `COLD` | | s | those of [`characterize`](crate::characterize::limits); a rehearsal that has no state or offset by the second has nothing to expect |
//! | `METERED` | 1 | s | of a rehearsal for the processor time: fifty discharges at the least, or those of the longest mean |
//! | `REHEARSED`, `REHEARSED_READINGS` | 2, 200 | s, | how long it counts on each board at the most |
//! | `LONGEST_REHEARSED` | 5 | s | of a mean: `check` takes some seconds for it, and longer means differ in what they state by less than boards do |
//! | `REHEARSED_BOARDS` | 8 | | what a board states scatters by a tenth (`tcdic`, 50 kohm): the median of so many, by 5 % |
//! | `BEYOND_CHANCE` | 2 | standard errors | of what boards of a kind are off by, above what they state: the error is then what is to be expected |
//! | `REHEARSED_RESISTANCES` | 5 | | of the range of a sensor, for `size` |
//! | `GOOD` | 0.95 | of the error asked for | boards of a kind differ: a few percent are left for that |
//! | `TUNINGS`, `TOO_GOOD` | 4, 0.8 | , of the error asked for | how often the mean is made longer or shorter, and until where |
//! | `CONFIRMING` | 4 | boards | that what is proposed is rehearsed on: the chance of one is in its state |
//! | `TAPE_BLOCKS` | 4 | | a mean of a tape is over so many readings at least, and there are so many of it |
//! | `REST`, `COUNTED_S`, `MEANS_S` | 1000; 30; 0.01 to 1 | ohm; s; s | of `demo --compare`: where the sensor rests, how long is counted, which means |
//! | `NO_PULL` | 200 k | ohm | a charged node that holds its level as long as a discharge through it takes has no pull beside it: those of processors are 30 to 100 kohm |
//! | `PLAUSIBLE` | 2 | | printed capacitors are within 20 %, thresholds between a quarter and a half of the supply: times beyond this factor have another cause |
//! | `PLAUSIBLE_RATIO` | 1.2 | | resistors are known better than capacitors: the ratio of their times may differ by it |
//! | `SMALLEST_LEAK` | 1e-7 | S | a smaller leak is that of the capacitors, and is not told |
//! | `PATIENCE` | 5 | | the wiring test waits for a discharge as long as so many predicted ones take |
//! | `ENOUGH` | 1.1 | | of the best: a cheaper circuit that is hardly worse is better |

pub use crate::characterize::limits::{COLD, WARM};

use crate::units::{Nanos, Ohm};
use std::ops::RangeInclusive;
use std::time::Duration;

pub const LOOK_AROUND: Duration = Duration::from_millis(100);
pub const ANSWER: Duration = Duration::from_secs(2);
pub const STARTED: Duration = Duration::from_secs(20);
pub const FIRST_READING: Duration = Duration::from_secs(5);
pub const NEXT_READING: Duration = Duration::from_secs(10);
pub const RETRY_AFTER: Duration = Duration::from_millis(250);
pub const REDRAW_AFTER: Duration = Duration::from_millis(40);
pub const SAY_AFTER: Duration = Duration::from_millis(500);
pub const HISTORY_S: f64 = 10.0;
pub const HISTORY: usize = 10_000;
pub const RATE_WINDOW: Nanos = Nanos(2_000_000_000);
pub const SILENT_S: f64 = 2.0;
pub const SILENT_READINGS: f64 = 3.0;
pub const FULL_N: f64 = 10.0;
pub const BAR_OHM: [f64; 2] = [10.0, 1e6];
pub const BAR_COLUMNS: RangeInclusive<usize> = 6..=30;
pub const HISTORY_COLUMNS: usize = 60;
pub const NAME_COLUMNS: usize = 11;
pub const WORST_FIT: f64 = 0.5;
pub const WAKE_UPS: usize = 300;
pub const SLEEP: Duration = Duration::from_millis(1);
pub const DISCHARGES: usize = 50;
pub const SHARES_OF_R_2: [f64; 4] = [0.01, 0.1, 1.0, 4.0];
pub const METERED: Nanos = Nanos(1_000_000_000);
pub const REHEARSED: Nanos = Nanos(2_000_000_000);
pub const LONGEST_REHEARSED: Nanos = Nanos(5_000_000_000);
pub const PROGRESS_COLUMNS: usize = 24;
pub const LIVE_READINGS: usize = 400;
pub const LIVE_AVERAGES: [Nanos; 2] = [Nanos::ZERO, Nanos(1_000_000_000)];
pub const LIVE_MEANS: usize = 10;
pub const MISTAKEN: [f64; 2] = [0.2, 50.0];
pub const REHEARSED_READINGS: usize = 200;
pub const REHEARSED_BOARDS: usize = 8;
pub const BEYOND_CHANCE: f64 = 2.0;
pub const REHEARSED_RESISTANCES: usize = 5;
pub const TUNINGS: u32 = 4;
pub const GOOD: f64 = 0.95;
pub const TOO_GOOD: f64 = 0.8;
pub const ENOUGH: f64 = 1.1;
pub const CONFIRMING: usize = 4;
pub const TAPE_BLOCKS: usize = 4;
pub const REST: Ohm = Ohm(1000.0);
pub const COUNTED_S: f64 = 30.0;
pub const MEANS_S: [f64; 3] = [0.01, 0.1, 1.0];
pub const NO_PULL: Ohm = Ohm(200e3);
pub const PLAUSIBLE: f64 = 2.0;
pub const PLAUSIBLE_RATIO: f64 = 1.2;
pub const SMALLEST_LEAK: f64 = 1e-7;
pub const PATIENCE: f64 = 5.0;
