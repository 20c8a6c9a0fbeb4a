//! The constants of judgement of this room. What figures are laid out by stands where they are drawn, what the paper prints and what
//! rivals are computed from beside the figures.
//!
//! | constant | value | unit | reason |
//! |---|---|---|---|
//! | `EDGE` | 1.05 | | so much beyond an end of an axis still counts as on it: a mean over 10 s is there every 10.003 s |
//! | `SILENT` | 0.5 | of readings | without a number: the cell counts as failed |
//! | `HONEST` | 0.9 | of readings | within 2u: there should be 95 %, and fewer than this are no chance |
//! | `COARSE` | 0.1 | R_x | a greater error is a failure, however honest |
//! | `TIMES` | 1e-3 to 10 | s | the time axis of a front goes at least so far |
//! | `SHOWN` | 100 to 16 200 | ohm | there is a figure of the measured resistances next to these |
//! | `SAME` | 0.005 | | a resistance is one that is printed, though rounded |

pub const EDGE: f64 = 1.05;
pub const SILENT: f64 = 0.5;
pub const HONEST: f64 = 0.9;
pub const COARSE: f64 = 0.1;
pub const TIMES: [f64; 2] = [1e-3, 10.0];
pub const SHOWN: [f64; 3] = [100.0, 1000.0, 16_200.0];
pub const SAME: f64 = 0.005;
