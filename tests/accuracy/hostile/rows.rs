//! The hostile boards.

use super::Row;
use cermd::pins::sim::Kind;
use cermd::reading::Method;
use cermd::reading::Method::{Cerm, Qerm, Tcdic, Tpcm, Tracked};

/// The board `pi4`, unchanged, for what it is to be changed to.
pub const ROW: Row = Row {
    name: "",
    base: "pi4",
    scene: "",
    circuit: "",
    measure: "",
    kind: None,
    channel: "zero-ohm = 0\nscale = 1",
    beside_a_hand: false,
    seconds: [2.0, f64::INFINITY],
    readings: 20,
    boards: 100,
    least_numbers: 0.5,
    wild: 0,
    cases: BOTH,
    fails: &[],
};

/// A fast board: it has its state soon, and what takes long is to simulate its readings until then. Rounded alike each time, what each is
/// off by is its own.
const COARSE: Row = Row {
    base: "fpga-paper",
    seconds: [0.5, f64::INFINITY],
    cases: &[
        (Tracked, &[100.0, 170.0, 1000.0, 3000.0, 16_200.0]),
        (Cerm, &[130.0, 5000.0]),
        (Tcdic, &[300.0, 5000.0]),
    ],
    ..ROW
};

/// What switches while a sensor is read.
const BOTH: &[(Method, &[f64])] = &[(Tracked, &[100.0, 1000.0]), (Cerm, &[100.0, 1000.0])];
const ALL: &[(Method, &[f64])] = &[
    (Tracked, &[100.0, 1000.0, 5000.0]),
    (Cerm, &[100.0, 1000.0, 5000.0]),
    (Tcdic, &[100.0, 1000.0, 5000.0]),
];
const SWITCHED: &[(Method, &[f64])] =
    &[(Tracked, &[100.0, 1000.0]), (Cerm, &[100.0, 1000.0]), (Qerm, &[100.0, 1000.0])];

const STEADY: &str = "[calls]\nfixed = '0 s'\nper-line = '7.6 us'\nmoves-at = [0.475, 0.525]\n[stamps]\njitter = '2.2 us'\n[circuit]\n\
r-c1 = '1650 ohm'";

pub static LINES: [Row; 10] = [
    Row { name: "none: the board pi4 as it is", cases: ALL, ..ROW },
    Row {
        name: "lines move anywhere in calls of 1.15 us",
        scene: "[calls]\nfixed = '0 s'\nper-line = '1.15 us'\nmoves-at = [0.0, 1.0]",
        cases: SWITCHED,
        ..ROW
    },
    Row {
        name: "lines move anywhere in calls of 2.3 us",
        scene: "[calls]\nfixed = '0 s'\nper-line = '2.3 us'\nmoves-at = [0.0, 1.0]",
        cases: SWITCHED,
        ..ROW
    },
    // Split discharges show little of that beside what stamps do.
    Row {
        name: "steady switches in calls of 7.6 us, stamps by 2.2 us, Rc1 of 1.65 kohm",
        scene: STEADY,
        circuit: "r-c1 = '1650 ohm'",
        cases: &[(Tracked, &[100.0, 1000.0])],
        ..ROW
    },
    Row {
        name: "the same, one node",
        scene: STEADY,
        circuit: "r-c1 = '1650 ohm'",
        kind: Some(Kind::OneCapacitor),
        seconds: [4.0, f64::INFINITY],
        cases: &[(Tracked, &[100.0, 300.0, 1000.0])],
        ..ROW
    },
    // A sigma of 0.3 us is 1.04 us wide.
    Row {
        name: "lines move within 1.04 us after calls of 1.15 us",
        scene: "[calls]\nfixed = '0 s'\nper-line = '1.15 us'\nmoves-at = [1.0, 1.9]",
        cases: SWITCHED,
        ..ROW
    },
    Row {
        name: "writes are posted for 1 to 3 calls of 0.5 us",
        scene: "[calls]\nfixed = '0 s'\nper-line = '0.5 us'\nmoves-at = [1.0, 3.0]",
        cases: SWITCHED,
        ..ROW
    },
    Row {
        name: "writes are posted for 1 to 3 calls of 1.15 us",
        scene: "[calls]\nfixed = '0 s'\nper-line = '1.15 us'\nmoves-at = [1.0, 3.0]",
        cases: SWITCHED,
        ..ROW
    },
    Row {
        name: "writes are posted for 3 calls exactly",
        scene: "[calls]\nfixed = '0 s'\nper-line = '1.15 us'\nmoves-at = [3.0, 3.0]",
        cases: SWITCHED,
        ..ROW
    },
    // Uniform over 6.9 us.
    Row {
        name: "starts and switches scatter by 2 us",
        scene: "[calls]\nfixed = '0 s'\nper-line = '1.15 us'\nmoves-at = [0.0, 6.0]",
        ..ROW
    },
];

/// Beginning with the first reading after a start, whose uncertainty is a prior.
const FIRST_READINGS: Row = Row {
    seconds: [0.0, f64::INFINITY],
    readings: 30,
    least_numbers: 0.9,
    cases: &[
        (Tracked, &[100.0, 1000.0, 16_200.0]),
        (Cerm, &[100.0, 1000.0, 16_200.0]),
        (Tcdic, &[100.0, 1000.0, 16_200.0]),
        (Tpcm, &[1000.0]),
        (Qerm, &[1000.0]),
    ],
    ..ROW
};

pub static STARTS: [Row; 6] = [
    Row { name: "the first readings", ..FIRST_READINGS },
    Row { name: "the first readings: pi-zero", base: "pi-zero", ..FIRST_READINGS },
    Row { name: "the first readings: pi5", base: "pi5", ..FIRST_READINGS },
    Row {
        name: "the first readings: stamps jitter by 5 us",
        scene: "[stamps]\njitter = '5 us'\nmean = '20 us'",
        ..FIRST_READINGS
    },
    Row { name: "the first readings: 2 mV of noise", scene: "[noise]\nvoltage = '2 mV'", ..FIRST_READINGS },
    Row {
        name: "the first readings: starts and switches scatter by 2 us",
        scene: "[calls]\nfixed = '0 s'\nper-line = '1.15 us'\nmoves-at = [0.0, 6.0]",
        ..FIRST_READINGS
    },
];

const SLEEPY: &[(Method, &[f64])] = &[
    (Tracked, &[100.0, 1000.0, 5000.0]),
    (Cerm, &[100.0, 1000.0, 5000.0]),
    (Tcdic, &[100.0, 1000.0, 5000.0]),
    (Tpcm, &[1000.0, 5000.0]),
    (Qerm, &[1000.0, 5000.0]),
];
const SLEEPY_ONE: Row = Row {
    kind: Some(Kind::OneCapacitor),
    cases: &[(Tracked, &[100.0, 300.0, 1000.0, 5000.0]), (Tpcm, &[300.0, 5000.0])],
    // A fault is an answer.
    least_numbers: 0.0,
    ..ROW
};
const LATER_BY_60: &str = "[events]\ndeep-sleep-after = '200 us'\ndeep-sleep-late = '60 us'";
const LATER_BY_60_AFTER_500: &str = "[events]\ndeep-sleep-after = '500 us'\ndeep-sleep-late = '60 us'";

pub static STAMPS: [Row; 14] = [
    Row { name: "B is stamped 3 us later than A", scene: "[events]\nb-later = '3 us'", cases: ALL, ..ROW },
    Row {
        name: "2 us later after waits of 4 ms",
        scene: "[events]\ndeep-sleep-after = '4 ms'\ndeep-sleep-late = '2 us'",
        cases: &[
            (Tracked, &[100.0, 1000.0, 5000.0]),
            (Cerm, &[100.0, 1000.0, 5000.0]),
            (Tcdic, &[100.0, 1000.0, 5000.0]),
            (Tpcm, &[1000.0]),
            (Qerm, &[1000.0]),
        ],
        ..ROW
    },
    Row {
        name: "5 us later after waits of 2 ms",
        scene: "[events]\ndeep-sleep-after = '2 ms'\ndeep-sleep-late = '5 us'",
        cases: SLEEPY,
        ..ROW
    },
    Row {
        name: "10 us later after waits of 1 ms",
        scene: "[events]\ndeep-sleep-after = '1 ms'\ndeep-sleep-late = '10 us'",
        cases: SLEEPY,
        ..ROW
    },
    Row {
        name: "5 us later after waits of 200 us, one node",
        scene: "[events]\ndeep-sleep-after = '200 us'\ndeep-sleep-late = '5 us'",
        ..SLEEPY_ONE
    },
    Row {
        name: "60 us later after waits of 200 us",
        scene: LATER_BY_60,
        cases: SLEEPY,
        least_numbers: 0.0,
        ..ROW
    },
    Row { name: "60 us later after waits of 200 us, one node", scene: LATER_BY_60, ..SLEEPY_ONE },
    Row {
        name: "60 us later after waits of 500 us",
        scene: LATER_BY_60_AFTER_500,
        cases: SLEEPY,
        least_numbers: 0.0,
        ..ROW
    },
    Row { name: "60 us later after waits of 500 us, one node", scene: LATER_BY_60_AFTER_500, ..SLEEPY_ONE },
    Row {
        name: "wide-band noise: 0.5 mV of 10 MHz",
        scene: "[noise]\nbandwidth = '10 MHz'",
        cases: &[
            (Tracked, &[100.0, 1000.0, 5000.0, 16_200.0]),
            (Cerm, &[100.0, 1000.0, 5000.0]),
            (Tcdic, &[100.0, 16_200.0]),
        ],
        ..ROW
    },
    Row {
        name: "wide-band noise: 2 mV of 1 MHz",
        scene: "[noise]\nvoltage = '2 mV'\nbandwidth = '1 MHz'",
        cases: &[
            (Tracked, &[100.0, 1000.0, 5000.0, 16_200.0]),
            (Cerm, &[100.0, 1000.0, 5000.0]),
            (Tcdic, &[100.0, 16_200.0]),
        ],
        ..ROW
    },
    // Starts go by that clock, too, so that each crossing is rounded alike time after time.
    Row {
        name: "all at the edges of a clock of 40 ns taken for 20 ns",
        scene: "clock-period = '40 ns'",
        ..COARSE
    },
    Row {
        name: "all at the edges of a clock of 200 ns taken for 20 ns",
        scene: "clock-period = '200 ns'",
        ..COARSE
    },
    Row { name: "stamps jitter by 5 us", scene: "[stamps]\njitter = '5 us'\nmean = '20 us'", ..ROW },
];

const AT_B: &[(Method, &[f64])] =
    &[(Tracked, &[100.0, 5000.0]), (Cerm, &[100.0, 5000.0]), (Tcdic, &[5000.0])];
const AT_A: &[(Method, &[f64])] = &[
    (Tracked, &[100.0, 5000.0]),
    (Cerm, &[100.0, 5000.0]),
    (Tcdic, &[5000.0]),
    (Tpcm, &[5000.0]),
    (Qerm, &[1000.0]),
];
/// Ten readings a second, as most are configured: the first ten seconds, and what comes later.
const FIRST: Row = Row {
    measure: "rate-hz = 10",
    seconds: [0.0, 10.0],
    readings: 50,
    least_numbers: 0.9,
    cases: AT_A,
    ..ROW
};
const LATER: Row = Row { seconds: [15.0, f64::INFINITY], readings: 20, boards: 50, ..FIRST };
/// A fault is the answer to a defect, of each board alike.
const DEFECT_FIRST: Row = Row { boards: 20, least_numbers: 0.0, ..FIRST };
const DEFECT_LATER: Row = Row { boards: 20, least_numbers: 0.0, ..LATER };

const A_100_KOHM: &str = "[circuit.node-a]\nleakage-resistance = '100 kohm'";
pub const A_10_MOHM: &str = "[circuit.node-a]\nleakage-resistance = '10 Mohm'";
pub const A_PULL_UP_OF_10_MOHM: &str = "[circuit.node-a]\npull-up = '10 Mohm'";
pub const A_1_UA: &str = "[circuit.node-a]\nleakage = '-1 uA'";
pub const A_1_MOHM: &str = "[circuit.node-a]\nleakage-resistance = '1 Mohm'";
const A_CURRENT: &str = "[circuit.node-a]\nleakage = '-5 uA'";
pub const A_PULL_UP: &str = "[circuit.node-a]\npull-up = '1 Mohm'";
const B_50_KOHM: &str = "[circuit.node-b]\nleakage-resistance = '50 kohm'";
const B_3_MOHM: &str = "[circuit.node-b]\nleakage-resistance = '3 Mohm'";

const A_BOTH: &str = "[circuit.node-a]\npull-up = '3 Mohm'\nleakage-resistance = '3 Mohm'";
const B_CURRENT: &str = "[circuit.node-b]\nleakage = '-2 uA'";
const B_PULL_UP: &str = "[circuit.node-b]\npull-up = '1 Mohm'";
/// Where the error that a leak makes is none, and where discharges end through another resistor early.
const LOW: &[(Method, &[f64])] =
    &[(Tracked, &[50.0, 200.0, 470.0, 1000.0, 5000.0]), (Cerm, &[200.0, 470.0, 1000.0])];
const ONE: &[(Method, &[f64])] = &[(Tracked, &[50.0, 470.0, 5000.0, 16_200.0])];

/// Small capacitors lose as much in less time.
const SMALL: &str = "c-a = '470 nF'\nc-b = '100 nF'";
const SMALL_A_1_MOHM: &str =
    "[circuit]\nc-a = '470 nF'\nc-b = '100 nF'\nnode-a = { leakage-resistance = '1 Mohm' }";
const SMALL_A_PULL_UP: &str = "[circuit]\nc-a = '470 nF'\nc-b = '100 nF'\nnode-a = { pull-up = '250 kohm' }";
const SMALL_B_PULL_UP: &str = "[circuit]\nc-a = '470 nF'\nc-b = '100 nF'\nnode-b = { pull-up = '250 kohm' }";
const B_250_KOHM: &str = "[circuit.node-b]\nleakage-resistance = '250 kohm'";
const LARGE: Row =
    Row { boards: 50, cases: &[(Tracked, &[1000.0, 5000.0]), (Cerm, &[1000.0, 5000.0])], ..ROW };

pub static LEAKS: [Row; 23] = [
    Row { name: "100 kohm at A, the first 10 s", scene: A_100_KOHM, ..DEFECT_FIRST },
    Row { name: "100 kohm at A, later", scene: A_100_KOHM, ..DEFECT_LATER },
    Row { name: "1 Mohm at A, the first 10 s", scene: A_1_MOHM, ..FIRST },
    Row { name: "1 Mohm at A, later", scene: A_1_MOHM, ..LATER },
    Row { name: "5 uA into A, the first 10 s", scene: A_CURRENT, ..FIRST },
    Row { name: "5 uA into A, later", scene: A_CURRENT, ..LATER },
    Row { name: "pull-up of 1 Mohm at A, the first 10 s", scene: A_PULL_UP, ..FIRST },
    Row { name: "pull-up of 1 Mohm at A, later", scene: A_PULL_UP, ..LATER },
    Row { name: "50 kohm at B, the first 10 s", scene: B_50_KOHM, cases: AT_B, ..DEFECT_FIRST },
    Row { name: "50 kohm at B, later", scene: B_50_KOHM, cases: AT_B, ..DEFECT_LATER },
    Row { name: "3 Mohm at B, the first 10 s", scene: B_3_MOHM, cases: AT_B, ..FIRST },
    Row { name: "3 Mohm at B, later", scene: B_3_MOHM, cases: AT_B, ..LATER },
    Row { name: "pull-up of 1 Mohm at A, low ones", scene: A_PULL_UP, cases: LOW, ..LATER },
    Row { name: "pull-up and leak of 3 Mohm at A, later", scene: A_BOTH, cases: LOW, ..LATER },
    Row { name: "2 uA into B, pi-zero, later", scene: B_CURRENT, base: "pi-zero", cases: LOW, ..LATER },
    Row {
        name: "pull-up of 1 Mohm at B, pi-zero, later",
        scene: B_PULL_UP,
        base: "pi-zero",
        cases: LOW,
        ..LATER
    },
    Row {
        name: "1 Mohm at A, one node, later",
        scene: A_1_MOHM,
        kind: Some(Kind::OneCapacitor),
        cases: ONE,
        ..LATER
    },
    Row {
        name: "pull-up of 1 Mohm at A, one node, later",
        scene: A_PULL_UP,
        kind: Some(Kind::OneCapacitor),
        cases: ONE,
        ..LATER
    },
    Row {
        name: "pull-up and leak of 3 Mohm at A, one node",
        scene: A_BOTH,
        kind: Some(Kind::OneCapacitor),
        cases: ONE,
        ..LATER
    },
    Row { name: "250 kohm at B", scene: B_250_KOHM, ..LARGE },
    Row { name: "1 Mohm at A, 470 nF and 100 nF", scene: SMALL_A_1_MOHM, circuit: SMALL, ..LARGE },
    Row {
        name: "pull-up of 250 kohm at A, 470 nF and 100 nF",
        scene: SMALL_A_PULL_UP,
        circuit: SMALL,
        ..LARGE
    },
    Row {
        name: "pull-up of 250 kohm at B, 470 nF and 100 nF",
        scene: SMALL_B_PULL_UP,
        circuit: SMALL,
        ..LARGE
    },
];

/// Charges by nominal values would remember too much there, and without much noise one sees it.
const SLOW: &str = "[circuit]\nr-o = '90 ohm'\nc-a = '2.53 uF'\nc-b = '782 nF'\n\
[stamps]\njitter = '0.25 us'\n[noise]\nvoltage = '0.1 mV'";

pub static PINS: [Row; 8] = [
    Row { name: "Ro is 90 ohm for 40, C 15 % larger, little noise", scene: SLOW, cases: ALL, ..ROW },
    Row { name: "Ro walks by 1 ohm in a second", scene: "[walk]\nr-o = '1 ohm'", cases: ALL, ..ROW },
    Row { name: "Ro walks by 0.3 ohm in a second", scene: "[walk]\nr-o = '0.3 ohm'", cases: ALL, ..ROW },
    Row { name: "Ro walks by 0.1 ohm in a second", scene: "[walk]\nr-o = '0.1 ohm'", cases: ALL, ..ROW },
    Row {
        name: "Ro is 47 ohm at Rc1, 38 at Rc2, 41 at x",
        scene: "[circuit.r-o-of]\nc1 = '47 ohm'\nc2 = '38 ohm'\nx0 = '41 ohm'",
        channel: "",
        cases: ALL,
        ..ROW
    },
    Row {
        name: "Ro is 47 ohm at Rc1, 38 at Rc2, 41 at x, zeroed",
        scene: "[circuit.r-o-of]\nc1 = '47 ohm'\nc2 = '38 ohm'\nx0 = '41 ohm'",
        channel: "zero-ohm = -6.35",
        cases: ALL,
        ..ROW
    },
    Row {
        name: "Ro is 55 ohm at Rc1 and 33 at Rc2",
        scene: "[circuit.r-o-of]\nc1 = '55 ohm'\nc2 = '33 ohm'",
        channel: "",
        cases: ALL,
        ..ROW
    },
    Row {
        name: "Ro is 55 ohm at Rc1 and 33 at Rc2, zero and reference",
        scene: "[circuit.r-o-of]\nc1 = '55 ohm'\nc2 = '33 ohm'",
        channel: "zero-ohm = -15.874\nscale = 1.001802",
        cases: ALL,
        ..ROW
    },
];

/// A dielectric whose branches take up the same share in each of five decades, or at one time constant alone.
macro_rules! dielectric {
    (spread $share:literal) => {
        dielectric!(@ concat!(
            "[{ share = ", $share, ", tau = '100 us' }, { share = ", $share, ", tau = '1 ms' }, { share = ", $share,
            ", tau = '10 ms' }, { share = ", $share, ", tau = '100 ms' }, { share = ", $share, ", tau = '1 s' }]"
        ))
    };
    (at $share:literal, $tau:literal) => {
        dielectric!(@ concat!("[{ share = ", $share, ", tau = '", $tau, "' }]"))
    };
    (@ concat!($($part:expr),*)) => {
        concat!(
            "[circuit.absorption]\nc-a = ", $($part,)* "\nc-b = ", $($part,)* "\nc = ", $($part),*
        )
    };
}

const SLOW_CALLS_PET: &str = concat!("[calls]\nfixed = '5.4 us'\n", dielectric!(at "0.0025", "1 ms"));

const DIELECTRIC: Row = Row {
    cases: &[
        (Tracked, &[100.0, 1000.0, 5000.0]),
        (Cerm, &[100.0]),
        (Tcdic, &[100.0, 5000.0]),
        (Tpcm, &[100.0, 5000.0]),
        (Qerm, &[100.0, 5000.0]),
    ],
    ..ROW
};

const FAST_ONE: Row = Row {
    kind: Some(Kind::OneCapacitor),
    cases: &[(Tracked, &[100.0, 300.0, 1000.0, 5000.0])],
    // The first late splits are too few to show it.
    seconds: [4.0, f64::INFINITY],
    ..ROW
};

pub static DIELECTRICS: [Row; 17] = [
    Row { name: "PP: 0.05 % over five decades", scene: dielectric!(spread "0.0001"), ..DIELECTRIC },
    Row { name: "PP: 0.05 % at 1 ms", scene: dielectric!(at "0.0005", "1 ms"), ..DIELECTRIC },
    Row { name: "PP: 0.05 % at 10 ms", scene: dielectric!(at "0.0005", "10 ms"), ..DIELECTRIC },
    Row { name: "PET: 0.25 % over five decades", scene: dielectric!(spread "0.0005"), ..DIELECTRIC },
    Row { name: "PET: 0.25 % at 1 ms", scene: dielectric!(at "0.0025", "1 ms"), ..DIELECTRIC },
    // Switches keep as far from A's crossing as calls take, and show more of it.
    Row { name: "PET: 0.25 % at 1 ms, calls of 6 us", scene: SLOW_CALLS_PET, ..DIELECTRIC },
    Row {
        name: "PET: 0.25 % at 1 ms, calls of 6 us, from 4 s on",
        scene: SLOW_CALLS_PET,
        seconds: [4.0, f64::INFINITY],
        ..DIELECTRIC
    },
    Row { name: "PET: 0.25 % at 10 ms", scene: dielectric!(at "0.0025", "10 ms"), ..DIELECTRIC },
    Row { name: "PET: 0.25 % at 100 ms", scene: dielectric!(at "0.0025", "100 ms"), ..DIELECTRIC },
    Row { name: "X7R: 2.5 % over five decades", scene: dielectric!(spread "0.005"), ..DIELECTRIC },
    // The first late splits are too few to show it.
    Row {
        name: "X7R: 2.5 % at 100 us, from 4 s on",
        scene: dielectric!(at "0.025", "100 us"),
        seconds: [4.0, f64::INFINITY],
        ..DIELECTRIC
    },
    Row {
        name: "X7R: 2.5 % at 100 us, one node, from 4 s on",
        scene: dielectric!(at "0.025", "100 us"),
        ..FAST_ONE
    },
    Row {
        name: "X7R: 2.5 % at 300 us, from 4 s on",
        scene: dielectric!(at "0.025", "300 us"),
        seconds: [4.0, f64::INFINITY],
        ..DIELECTRIC
    },
    Row {
        name: "X7R: 2.5 % at 300 us, one node, from 4 s on",
        scene: dielectric!(at "0.025", "300 us"),
        ..FAST_ONE
    },
    Row { name: "X7R: 2.5 % at 1 ms", scene: dielectric!(at "0.025", "1 ms"), ..DIELECTRIC },
    Row { name: "X7R: 2.5 % at 10 ms", scene: dielectric!(at "0.025", "10 ms"), ..DIELECTRIC },
    Row { name: "C0G: 0.01 % at 10 ms", scene: dielectric!(at "0.0001", "10 ms"), ..DIELECTRIC },
];

pub static PARTS: [Row; 7] = [
    Row {
        name: "1 uF and 220 nF",
        scene: "[circuit]\nc-a = '1 uF'\nc-b = '220 nF'",
        circuit: "c-a = '1 uF'\nc-b = '220 nF'",
        cases: ALL,
        ..ROW
    },
    Row {
        name: "330 nF and 100 nF",
        scene: "[circuit]\nc-a = '330 nF'\nc-b = '100 nF'",
        circuit: "c-a = '330 nF'\nc-b = '100 nF'",
        cases: ALL,
        ..ROW
    },
    Row {
        name: "calibrated by 4.7 kohm and 47 kohm",
        scene: "[circuit]\nr-c1 = '4.7 kohm'\nr-c2 = '47 kohm'",
        circuit: "r-c1 = '4.7 kohm'\nr-c2 = '47 kohm'",
        cases: &[(Tracked, &[100.0]), (Cerm, &[100.0]), (Tcdic, &[100.0])],
        ..ROW
    },
    Row {
        name: "one node",
        kind: Some(Kind::OneCapacitor),
        cases: &[(Tracked, &[30.0, 100.0, 1000.0]), (Tpcm, &[30.0, 1000.0])],
        ..ROW
    },
    Row {
        name: "pi-zero",
        base: "pi-zero",
        cases: &[(Tracked, &[150.0, 500.0, 15_000.0, 50_000.0]), (Cerm, &[150.0, 500.0, 15_000.0])],
        measure: "deadline = '400 ms'",
        ..ROW
    },
    Row { name: "beside a hand", beside_a_hand: true, cases: SWITCHED, ..ROW },
    Row {
        name: "beside a hand, one node",
        kind: Some(Kind::OneCapacitor),
        beside_a_hand: true,
        cases: &[(Tracked, &[1000.0]), (Tpcm, &[1000.0])],
        ..ROW
    },
];
