//! The constants of judgement of this room: how long a person waits, and how much a screen shows.
//!
//! | constant | value | unit | reason |
//! |---|---|---|---|
//! | `LOOK_AROUND` | 0.1 | s | how long a verb waits for a line before it looks for Ctrl-C or the end of its time |
//! | `ANSWER` | 2 | s | a busy daemon greets and answers well within it |
//! | `FIRST_READING` | 5 | s | an instrument that has just started has one by then |
//! | `NEXT_READING` | 10 | s | the next discharge or reading while something is calibrated |
//! | `RETRY_AFTER` | 0.25 | s | from one attempt to connect again to the next |
//! | `REDRAW_AFTER` | 0.04 | s | live lines: faster than the eye, slower than a slow terminal |
//! | `SAY_AFTER` | 0.5 | s | the demo on anything but a terminal shows one reading in it |
//! | `HISTORY_S` | 10 | s | how far back the sparklines of the demo go |
//! | `HISTORY` | 10 000 | readings | that are kept for them |
//! | `RATE_WINDOW_NS` | 2e9 | ns | readings per second are counted over it |
//! | `FULL_N` | 10 | N | a bar is full at so much until a reading is beyond it |
//! | `BAR_OHM` | 10 to 1e6 | ohm | a bar of ohms is logarithmic, full at the first and empty at the second |
//! | `BAR_COLUMNS`, `HISTORY_COLUMNS` | 6 to 30, 60 | columns | a narrower bar shows nothing; wider ones are not easier to read |
//! | `WAKE_UPS`, `SLEEP` | 300, 1 | , ms | sleeps that are timed by `check` |
//! | `DISCHARGES` | 50 | | discharges that are timed by `check` |
//! | `SHARES_OF_R_2` | 0.01 to 4 | R_2 | resistances of which `check` says what to expect: what Rc2 is chosen for |
//! | `WARM`, `COLD` | 4, 30 | s | a rehearsal counts from the first on, where state, noise and leaks are known; without either by the second there is nothing to expect |
//! | `REHEARSED`, `REHEARSED_READINGS` | 2, 300 | s, | how long it counts at the most: the root mean square of so many u is known to 2 % |

use crate::units::Nanos;
use std::ops::RangeInclusive;
use std::time::Duration;

pub const LOOK_AROUND: Duration = Duration::from_millis(100);
pub const ANSWER: Duration = Duration::from_secs(2);
pub const FIRST_READING: Duration = Duration::from_secs(5);
pub const NEXT_READING: Duration = Duration::from_secs(10);
pub const RETRY_AFTER: Duration = Duration::from_millis(250);
pub const REDRAW_AFTER: Duration = Duration::from_millis(40);
pub const SAY_AFTER: Duration = Duration::from_millis(500);
pub const HISTORY_S: f64 = 10.0;
pub const HISTORY: usize = 10_000;
pub const RATE_WINDOW_NS: i64 = 2_000_000_000;
pub const FULL_N: f64 = 10.0;
pub const BAR_OHM: [f64; 2] = [10.0, 1e6];
pub const BAR_COLUMNS: RangeInclusive<usize> = 6..=30;
pub const HISTORY_COLUMNS: usize = 60;
pub const WAKE_UPS: usize = 300;
pub const SLEEP: Duration = Duration::from_millis(1);
pub const DISCHARGES: usize = 50;
pub const SHARES_OF_R_2: [f64; 4] = [0.01, 0.1, 1.0, 4.0];
pub const WARM: Nanos = Nanos(4_000_000_000);
pub const COLD: Nanos = Nanos(30_000_000_000);
pub const REHEARSED: Nanos = Nanos(2_000_000_000);
pub const REHEARSED_READINGS: usize = 300;
