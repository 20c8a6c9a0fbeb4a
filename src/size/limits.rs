//! The constants of judgement of this room.
//!
//! | constant | value | unit | reason |
//! |---|---|---|---|
//! | `SUPPLY_HIGH`, `PART_LOW` | 5, 1 | % | supply and resistors that limit a current, at their worst: gives 220, 330 and 470 ohm for 16, 12 and 8 mA |
//! | `LEAST_C`, `GREATEST_C` | 10 nF, 10 uF | F | film capacitors that are kept in stock everywhere |
//! | `LEAST_C_B` | 1/15 | C_A | a smaller C_B makes C_T nearly C_B: then one capacitor does as well |
//! | `SPREAD_OF_C` | 5 | % | capacitors as sold, at their worst: node B has to cross all the same |
//! | `B_MARGIN` | 0.05 | V_DD | as the configuration warns of |
//! | `LEAST_R_1` | 470 | ohm | higher tells less of the pins, lower is current for little gain (hw/wiring.md) |
//! | `R_2_RATIO`, `R_2_PER_DECADE`, `GREATEST_R_2` | 4, 3, 100 k | , , ohm | R_2 above R_1, how many are looked at, up to where leaks of pins begin to count |
//! | `POINTS` | 7 | | resistances at which a candidate is looked at |
//! | `CALLS` | 4 | calls | that switch lines for a discharge: charge, release, sink, and a switch or the release of B |
//! | `STAMP` | 1 | ns | the kernel stamps in whole ones: no board scatters by less |
//! | `READS` | 2 | reads | of levels before calls that are timed |
//! | `CALIBRATIONS` | 0.25 | discharges of R_2 | for each reading, roughly: the rehearsal knows it better |
//! | `PERIOD_SHARES` | 0.85, 0.6, 0.4 | period | that the longest discharge of a sensor may take where a rate is asked for, less where calibration needs more |
//! | `RATE_MARGIN` | 1.05 | | a pause in which leaks are looked for costs some readings |
//! | `LONGEST_MEAN` | 60 | s | as the configuration allows |
//! | `SENSE_OHM` | 1000 | ohm | R_s protects an input (hw/wiring.md) |
//! | `EXACT` | 0.001 | | what resistors are known to that are bought for it, or measured with a usual good ohmmeter |
//! | `DRAWER_LIMIT` | 2 | | a resistor of the drawer that limits a current is not more than so many times what is needed: charging takes longer with it |
//! | `FILM_EUR` | | F, EUR | single film capacitors up to a size, 2026, as big distributors sell them; roughly |
//! | `EXACT_EUR`, `USUAL_EUR` | 0.5, 0.05 | EUR | a resistor of 0.1 %, of 1 %; the same |
//! | `CLASSES_EUR` | 2, 5 | EUR | where the price classes end |

use crate::units::Seconds;

pub const SUPPLY_HIGH: f64 = 1.05;
pub const PART_LOW: f64 = 0.99;
pub const LEAST_C: f64 = 10e-9;
pub const GREATEST_C: f64 = 10e-6;
pub const LEAST_C_B: f64 = 1.0 / 15.0;
pub const SPREAD_OF_C: f64 = 0.05;
pub const B_MARGIN: f64 = 0.05;
pub const LEAST_R_1: f64 = 470.0;
pub const R_2_RATIO: f64 = 4.0;
pub const R_2_PER_DECADE: f64 = 3.0;
pub const GREATEST_R_2: f64 = 100e3;
pub const POINTS: usize = 7;
pub const CALLS: f64 = 4.0;
pub const STAMP: Seconds = Seconds(1e-9);
pub const READS: f64 = 2.0;
pub const CALIBRATIONS: f64 = 0.25;
pub const PERIOD_SHARES: [f64; 3] = [0.85, 0.6, 0.4];
pub const RATE_MARGIN: f64 = 1.05;
pub const LONGEST_MEAN_S: f64 = 60.0;
pub const SENSE_OHM: f64 = 1000.0;
pub const EXACT: f64 = 0.001;
pub const DRAWER_LIMIT: f64 = 2.0;
pub const FILM_EUR: [(f64, f64); 4] = [(1.05e-6, 0.5), (2.3e-6, 1.0), (4.8e-6, 2.0), (f64::INFINITY, 4.0)];
pub const EXACT_EUR: f64 = 0.5;
pub const USUAL_EUR: f64 = 0.05;
pub const CLASSES_EUR: [f64; 2] = [2.0, 5.0];
