//! The constants of judgement of this room.
//!
//! | constant | value | unit | range or reason | source |
//! |---|---|---|---|---|
//! | `CAPACITORS`, `SUPPLIES` | | F, V | what is sold; outside is a slip of a prefix | judgement |
//! | `PIN_LIMITS_A` | 0.008, 0.012 | A | what a pin of a Pi 4 and of a Pi 5 may carry | drive strength as they boot, strongest drive (hw/wiring.md) |
//! | `STRONGEST_PIN_A` | 0.016 | A | the same of any other | Raspberry Pi up to the 3, strongest drive |
//! | `B_MARGIN` | 0.05 | V_DD | below it node B crosses late and unsteadily | judgement |
//! | `CALIBRATION_RATIO` | 1.5 | | below it the difference of two times is mostly noise | judgement |
//! | `LONGEST_WAIT` | 60 | s | a longer one is a slip of a prefix | judgement |
//! | `SLOWEST_HZ` | 1/60 | Hz | `LONGEST_WAIT` from one reading to the next; what follows from it, stale triggers and sensors that are read rarely, stays within what counts in ns | judgement |
//! | `LARGEST_SWITCH_FRACTION` | 1.3 | T_xA | beyond it even a late node B has crossed | judgement |
//! | `HYSTERESIS` | 0.8 | of `on-above` | where a channel is released unless it is said: more than the tremor of a hand, 2 % | as of a ForceSensor, clients/python |
//! | `STALE_READINGS`, `SHORTEST_STALE` | 3, 100 | readings, ms | a number is old after two readings that are none; and after a pause that any process may have | judgement |
//! | `LONGEST_ID` | 64 | bytes | the first line of the stream has to hold all names | stream, 64 KiB a line |
//! | `EVERY` | 1 to 1000 | cycles | a sensor that is read more rarely is not read | judgement |
//! | `LARGEST_ZERO_OHM` | 500 | ohm | pins and a series resistor make up less | tests/programs/calibrate.rs |
//! | `LONGEST_SOCKET` | 107 | bytes | `sun_path` has 108 with its final zero | include/uapi/linux/un.h |
//! | `PRIORITIES` | 1 to 99 | | SCHED_FIFO | sched(7) |
//! | `INTERRUPTS` | 50 | | the priority of threads of interrupts | kernel/irq/manage.c, sched_set_fifo |
//! | `PROCESSORS` | 1024 | | what the kernel's set of processors holds here | CPU_SET(3) |
//! | `LIKE_GRAMS` | 100; 2.7e5 | N; N ohm | numbers without a unit that are as large, and make a sensor of as much force for its resistance, are grams: twenty times an FSR 402, of which grams make a hundred times | judgement |
//! | `WEIGHTS_N`, `UNDER_WEIGHTS_OHM` | | N, ohm | outside is a slip; squares and reciprocals inside are finite | judgement |
//! | `SHORT_CHARGE` | 0.9 | automatic charge | a shorter one changes a reading by more than planned | charge.rs |
//! | `SHORTEST_DISCHARGE` | 1 | us | a system call takes as long on the fastest of boards | docs/latency.md |
//! | `SHORTEST_PART` | 50 | us | a part of a split discharge has to be long against the system calls between them | judgement |
//! | `DEADLINE` | 5 | discharges of R_2 | the derived deadline: sensors up to about five times R_2 | judgement |
//! | `FINISHED` | 4 | discharges of R_2 | the same where what lasts longer is finished through R_1: 100 kohm to 0.1 % within 60 ms on the default parts | docs/averages.md |
//! | `LEAST_DEADLINE` | 2 | discharges of R_2 | the same where readings are wanted often: room for a calibration on slow capacitors | judgement |
//! | `DEADLINE_SHARE` | 0.9 | of the time for a cycle | what the discharges of sensors may take and one of R_2; the rest is for charges | tests/accuracy/wanted.rs |
//! | `TOGETHER` | 0.5 | time constants of B | how long B has its charger in each charge: 29 % of what has leaked away since the last one comes back | tests/accuracy/charging.rs |
//! | `DRAIN` | 1.2 | discharges of R_1 | the tolerance of the capacitors | judgement |
//! | `SWITCH_FRACTION` | 0.9 | T_xA | where the switch comes unless it is given | judgement |
//! | `CHARGE_SHARE` | 0.1 | sigma | error of an incomplete charge: a hundred readings have to be averaged to see it | tests/accuracy/charging.rs |
//! | `LEAST_TAUS` | 4 | time constants | below it the first order of charge.rs does not hold | charge.rs |
//! | `JITTER_S` | 0.5e-6 | s | of a crossing: less than any board is known to have, so that the error stays small on each | judgement |
//! | `NOISE_V` | 0.25e-3 | V | of a node | board of the paper |
//! | `SWITCH_S` | 0.1e-6 | s | scatter of a switch | judgement |
//! | `LATENESS_S` | 20e-6 | s | scatter of the end of a charge, which is rested until, not spun: with 2.2 uF it is 2 % of tau and adds an eighth to what depths differ by anyway; where it adds more, one tau more of charge costs less than spinning | judgement |
//! | `PER_DECADE`, `RESISTANCES` | 6, 30 | | resistances that are looked at, down from what the deadline resolves | five decades |

use crate::units::{Farad, Nanos, Seconds, Volt};
use std::ops::RangeInclusive;

pub const CAPACITORS: RangeInclusive<Farad> = Farad(10e-12)..=Farad(1e-3);
pub const SUPPLIES: RangeInclusive<Volt> = Volt(0.5)..=Volt(30.0);
const PIN_LIMITS_A: [(&str, f64); 2] = [("pinctrl-bcm2711", 0.008), ("pinctrl-rp1", 0.012)];
/// What a pin may carry where its chip is not known to carry less, A.
pub const STRONGEST_PIN_A: f64 = 0.016;

pub const B_MARGIN: f64 = 0.05;
pub const CALIBRATION_RATIO: f64 = 1.5;
/// Of what is waited for or averaged over.
pub const LONGEST_WAIT: Nanos = Nanos(60_000_000_000);
pub const SLOWEST_HZ: f64 = 1.0 / 60.0;
pub const LARGEST_SWITCH_FRACTION: f64 = 1.3;
pub const HYSTERESIS: f64 = 0.8;
pub const STALE_READINGS: i64 = 3;
pub const SHORTEST_STALE: Nanos = Nanos(100_000_000);
pub const LONGEST_ID: usize = 64;
pub const EVERY: RangeInclusive<u32> = 1..=1000;
/// Beyond this a zero is neither the difference of two pins nor a resistor that limits the current of the sensor, ohm.
pub const LARGEST_ZERO_OHM: f64 = 500.0;
pub const LONGEST_SOCKET: usize = 107;
pub const PRIORITIES: RangeInclusive<u8> = 1..=99;
pub const INTERRUPTS: u8 = 50;
pub const PROCESSORS: usize = nix::sched::CpuSet::count();
pub const SHORT_CHARGE: f64 = 0.9;
pub const SHORTEST_DISCHARGE: Seconds = Seconds(1e-6);
pub const SHORTEST_PART: Seconds = Seconds(50e-6);
pub const DEADLINE: f64 = 5.0;
pub const FINISHED: f64 = 4.0;
pub const LEAST_DEADLINE: f64 = 2.0;
pub const DEADLINE_SHARE: f64 = 0.9;
pub const TOGETHER: f64 = 0.5;
pub const DRAIN: f64 = 1.2;
pub const SWITCH_FRACTION: f64 = 0.9;
pub const LIKE_GRAMS: (f64, f64) = (100.0, 2.7e5);
pub const WEIGHTS_N: RangeInclusive<f64> = 1e-6..=1e6;
pub const UNDER_WEIGHTS_OHM: RangeInclusive<f64> = 1e-6..=1e9;
pub const CHARGE_SHARE: f64 = 0.1;
pub const LEAST_TAUS: f64 = 4.0;
pub const JITTER_S: f64 = 0.5e-6;
pub const NOISE_V: f64 = 0.25e-3;
pub const SWITCH_S: f64 = 0.1e-6;
pub const LATENESS_S: f64 = 20e-6;
pub const PER_DECADE: f64 = 6.0;
pub const RESISTANCES: u32 = 30;

/// What a pin of a GPIO chip may carry, by the chip's label, A; `None` where that is as much as any.
pub fn pin_limit_a(chip: &str) -> Option<f64> {
    PIN_LIMITS_A.iter().find(|(label, _)| *label == chip).map(|(_, ampere)| *ampere)
}
