//! The constants of judgement of this room.
//!
//! | constant | value | unit | reason | source |
//! |---|---|---|---|---|
//! | `UNLIKE_PINS_OHM` | 8 | ohm | how far pins differ | data sheets of processors, GUM |
//! | `SCALES` | 0.9 to 1.1 | | beyond it pins would differ by a tenth of R_2 | judgement |
//! | `ABSURD_ZERO_OHM` | 1e6 | ohm | a slip | judgement |
//! | `PARTS_OHM` | 0.01 to 1e9 | ohm | outside is a slip of a prefix | judgement |
//! | `FSR_402` | 13346.46 | N ohm | alpha of F = alpha / R | fitted to an FSR 402 between 1.2 N and 30 N in the paper (section V) |
//! | `UNCALIBRATED_U` | 0.078 | | two FSR 402 differ by 6 %, one by 5 % with the direction | Interlink, FSR 400 series data sheet |
//! | `UNCALIBRATED_N` | 0.2 to 20 | N | the forces that this is said of | the same |
//! | `FORCES_N` | 1e-9 to 1e9 | N | outside is a slip of a prefix | judgement |
//! | `EXPONENTS` | 0.01 to 100 | | no sensor has another | judgement |
//! | `BETAS_K` | 500 to 10000 | K | sold are 2000 to 5500 | data sheets of NTCs |
//! | `NTC_DEGC` | -40 to 125 | degC | what most coated parts are rated for | Vishay NTCLE100E3, EPCOS B57330 |
//! | `GAMMAS` | 0.1 to 2 | | sold are 0.5 to 1 | data sheets of the GL55 series |
//! | `LDR_LX` | 1 to 1000 | lx | a decade on either side of the two points that gamma is defined by | judgement |
//! | `LONGEST_UNIT` | 16 | bytes | a unit is shown beside every number | judgement |

use crate::units::NewtonOhm;
use std::ops::RangeInclusive;

/// How far the output resistance of a pin is off that of its neighbours, ohm, 1 sigma, as long as nobody has looked. Data sheets
/// bound it by 70 or 100 ohm and say no more: 40 ohm, to 14 either way and nothing more likely between (GUM, rectangular).
pub const UNLIKE_PINS_OHM: f64 = 8.0;
/// A scale beyond this is a mistake: the pins would differ by a tenth of R_2.
pub const SCALES: RangeInclusive<f64> = 0.9..=1.1;
/// A zero beyond this, of either sign, is none.
pub const ABSURD_ZERO_OHM: f64 = 1e6;
pub const PARTS_OHM: RangeInclusive<f64> = 0.01..=1e9;
pub const BETAS_K: RangeInclusive<f64> = 500.0..=10_000.0;
pub const NTC_DEGC: [f64; 2] = [-40.0, 125.0];
pub const GAMMAS: RangeInclusive<f64> = 0.1..=2.0;
pub const LDR_LX: [f64; 2] = [1.0, 1000.0];
pub const LONGEST_UNIT: usize = 16;
/// Alpha of F = alpha / R for the FSR 402 of the paper (section V).
pub const FSR_402: NewtonOhm = NewtonOhm(13_346.46);
/// What a characteristic that nobody has measured is good for, relative, 1 sigma: two FSR 402 differ by 6 %, and one of them by
/// 5 % to either side with whether the force rises or falls (hysteresis of 10 %; Interlink, FSR 400 series data sheet).
pub const UNCALIBRATED_U: f64 = 0.078;
/// The forces that this is said of, newton.
pub const UNCALIBRATED_N: [f64; 2] = [0.2, 20.0];
pub const FORCES_N: RangeInclusive<f64> = 1e-9..=1e9;
pub const EXPONENTS: RangeInclusive<f64> = 0.01..=100.0;
