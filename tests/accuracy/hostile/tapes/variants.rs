//! The boards of which there are tapes.

use super::board::Wiring;
use super::network::{Absorption, Load};
use cermd::reading::Method;
use cermd::reading::Method::{Cerm, Qerm, Tcdic, Tpcm, Tracked};

type Cases = &'static [(Method, &'static [f64])];

/// Stamps are so much later after waits that are longer, s.
#[derive(Debug, Clone, Copy)]
pub struct Asleep {
    pub after: f64,
    pub late: f64,
}

/// What stamps crossings.
#[derive(Debug, Clone, Copy)]
pub struct Clock {
    pub period_ns: f64,
    /// The tape says so.
    pub is_told: bool,
}

/// What its boards have in common, most of which the tape does not say.
#[derive(Debug, Clone, Copy)]
pub struct Variant {
    pub name: &'static str,
    /// Of methods that do not need another one.
    pub wiring: Wiring,
    pub r_c1: f64,
    /// Stamps of B are later than those of A by so much, ns.
    pub b_later_ns: f64,
    pub asleep: Option<Asleep>,
    pub clock: Option<Clock>,
    /// Stamps jitter by a tenth of what they do elsewhere, and so does the voltage.
    pub is_quiet: bool,
    /// Lines move before and after the instants on the tape, ns, 1 sigma, each for itself; what the tape says of that.
    pub scatter_ns: f64,
    pub told_ns: Option<f64>,
    /// The noise at the inputs is so wide.
    pub bandwidth_hz: Option<f64>,
    /// What else is connected to A and to B, and what their capacitors absorb.
    pub beside: [Load; 2],
    pub absorption: Option<Absorption>,
    /// Ro, the capacitors (relative) and the threshold walk by so much in a second.
    pub walk_ohm: f64,
    pub walk_c: f64,
    pub walk_volt: f64,
    /// The tape has the instants at which discharges started.
    pub has_t: bool,
    /// It has the discharges by which a daemon looks for what is wrong.
    pub looks: bool,
    /// Sensors above Rc1 discharge until the end, as those above Rc2 always do.
    pub to_end: bool,
    /// All estimates count, from the first on.
    pub from_first: bool,
    pub cycles: usize,
    /// If a smaller share of the estimates are numbers, the program has only found a way not to answer.
    pub least_numbers: f64,
    /// So many estimates of a case may be beyond ten sigma unsaid.
    pub wild: usize,
    pub cases: Cases,
    /// Cases that do not hold: to be mended, not to be kept.
    pub fails: &'static [(Method, f64)],
}

/// What a tape shows to the methods that it was made for before there were looks.
const BARE: Variant = Variant {
    name: "",
    wiring: Wiring::Two,
    r_c1: 2320.0,
    b_later_ns: 0.0,
    asleep: None,
    clock: None,
    is_quiet: false,
    scatter_ns: 0.0,
    told_ns: None,
    bandwidth_hz: None,
    beside: [Load::NONE; 2],
    absorption: None,
    walk_ohm: 0.0,
    walk_c: 0.0,
    walk_volt: 0.0,
    has_t: true,
    looks: false,
    to_end: true,
    from_first: false,
    cycles: 60,
    // A switched discharge tells nothing before there is a state.
    least_numbers: 0.5,
    wild: 0,
    cases: &[(Tracked, &[100.0, 1000.0, 5000.0]), (Cerm, &[100.0]), (Tcdic, &[5000.0])],
    fails: &[],
};

/// As a daemon records it on a usual board: calls of half a microsecond, in which lines move anywhere.
const DAEMON: Variant = Variant {
    r_c1: 470.0,
    scatter_ns: 150.0,
    told_ns: Some(200.0),
    looks: true,
    to_end: false,
    // The state is found anew when a leak shows, and has to see some looks.
    cycles: 100,
    cases: &[
        (Tracked, &[100.0, 1000.0, 5000.0]),
        (Cerm, &[100.0, 5000.0]),
        (Tcdic, &[5000.0]),
        (Tpcm, &[5000.0]),
        (Qerm, &[1000.0]),
    ],
    ..BARE
};

/// What changes in time changes what is followed, and what is taken anew.
const WALKING: Variant =
    Variant { cases: &[(Tracked, &[100.0, 1000.0, 5000.0]), (Cerm, &[100.0]), (Tpcm, &[5000.0])], ..DAEMON };

/// What stamps coarsely does it to all alike.
const TICKING: Variant =
    Variant { cases: &[(Tracked, &[100.0, 5000.0]), (Cerm, &[100.0]), (Tpcm, &[5000.0])], ..DAEMON };

/// A fault is an answer.
const LEAKING: Variant = Variant { least_numbers: 0.0, ..DAEMON };

const fn at_a(load: Load) -> [Load; 2] {
    [load, Load::NONE]
}

const fn at_b(load: Load) -> [Load; 2] {
    [Load::NONE, load]
}

const fn absorbs(share: f64, tau: f64) -> Option<Absorption> {
    Some(Absorption { share, tau })
}

const AMPERES: Load = Load { amperes: 5e-6, siemens: 0.0 };
const AT_B: Cases = &[(Tracked, &[100.0, 1000.0, 5000.0]), (Cerm, &[100.0, 5000.0]), (Tcdic, &[5000.0])];
const SLEEPY: Cases = &[
    (Tracked, &[100.0, 1000.0, 5000.0]),
    (Cerm, &[100.0, 5000.0]),
    (Tcdic, &[100.0, 5000.0]),
    (Tpcm, &[1000.0, 5000.0]),
    (Qerm, &[1000.0, 5000.0]),
];
const ONE: Cases = &[(Tracked, &[30.0, 100.0, 1000.0, 5000.0]), (Tpcm, &[100.0, 5000.0])];
const DIELECTRIC: Cases =
    &[(Tracked, &[100.0, 1000.0, 5000.0]), (Cerm, &[100.0]), (Tcdic, &[100.0, 5000.0]), (Qerm, &[1000.0])];

/// All that waits for a sensor is late, and only wakes show it.
const TO_END: Variant = Variant {
    asleep: Some(Asleep { after: 2e-3, late: 5e-6 }),
    to_end: true,
    cases: &[(Tracked, &[5000.0, 16_200.0])],
    ..DAEMON
};

pub static VARIANTS: [Variant; 44] = [
    Variant { name: "tape: plain", ..BARE },
    Variant { name: "tape: from its first estimate on", from_first: true, least_numbers: 0.4, ..BARE },
    Variant {
        name: "tape: from its first estimate on, lines scatter by 2 us",
        from_first: true,
        scatter_ns: 2000.0,
        least_numbers: 0.4,
        ..BARE
    },
    Variant { name: "tape: plain, without the instants of starts", has_t: false, ..BARE },
    Variant { name: "tape: B is stamped 3 us later than A", b_later_ns: 3000.0, ..BARE },
    Variant { name: "tape: lines scatter by 0.3 us", scatter_ns: 300.0, ..BARE },
    Variant {
        name: "tape: lines scatter by 0.3 us, and it says so",
        scatter_ns: 300.0,
        told_ns: Some(300.0),
        ..BARE
    },
    Variant { name: "tape: lines scatter by 2 us", scatter_ns: 2000.0, ..BARE },
    Variant { name: "tape: Ro walks by 1 ohm in a second", walk_ohm: 1.0, ..BARE },
    Variant {
        name: "tape of a daemon: plain",
        cases: &[
            (Tracked, &[30.0, 100.0, 1000.0, 5000.0, 16_200.0, 100_000.0]),
            (Cerm, &[30.0, 1000.0, 5000.0, 100_000.0]),
            (Tcdic, &[30.0, 1000.0, 5000.0, 100_000.0]),
            (Tpcm, &[30.0, 1000.0, 5000.0, 100_000.0]),
            (Qerm, &[30.0, 1000.0, 5000.0, 100_000.0]),
        ],
        ..DAEMON
    },
    Variant { name: "tape of a daemon: Rc1 of 2.32 kohm", r_c1: 2320.0, ..DAEMON },
    Variant { name: "tape of a daemon: without its looks", looks: false, ..DAEMON },
    Variant { name: "tape of a daemon: B is stamped 3 us later", b_later_ns: 3000.0, ..DAEMON },
    Variant { name: "tape of a daemon: 100 kohm at A", beside: at_a(Load::to(0.0, 100e3)), ..LEAKING },
    Variant { name: "tape of a daemon: 1 Mohm at A", beside: at_a(Load::to(0.0, 1e6)), ..LEAKING },
    Variant { name: "tape of a daemon: pull-up of 1 Mohm at A", beside: at_a(Load::to(3.3, 1e6)), ..LEAKING },
    Variant { name: "tape of a daemon: 5 uA into A", beside: at_a(AMPERES), ..LEAKING },
    Variant {
        name: "tape of a daemon: 50 kohm at B",
        beside: at_b(Load::to(0.0, 50e3)),
        cases: AT_B,
        ..LEAKING
    },
    Variant {
        name: "tape of a daemon: 3 Mohm at B",
        beside: at_b(Load::to(0.0, 3e6)),
        cases: AT_B,
        ..LEAKING
    },
    Variant {
        name: "tape of a daemon: PP, 0.05 % at 1 ms",
        absorption: absorbs(0.0005, 1e-3),
        cases: DIELECTRIC,
        ..DAEMON
    },
    Variant {
        name: "tape of a daemon: PP, 0.05 % at 10 ms",
        absorption: absorbs(0.0005, 10e-3),
        cases: DIELECTRIC,
        ..DAEMON
    },
    Variant {
        name: "tape of a daemon: PET, 0.25 % at 1 ms",
        absorption: absorbs(0.0025, 1e-3),
        cases: DIELECTRIC,
        ..DAEMON
    },
    Variant {
        name: "tape of a daemon: PET, 0.25 % at 10 ms",
        absorption: absorbs(0.0025, 10e-3),
        cases: DIELECTRIC,
        ..DAEMON
    },
    Variant {
        name: "tape of a daemon: 5 us later after waits of 2 ms",
        asleep: Some(Asleep { after: 2e-3, late: 5e-6 }),
        cases: SLEEPY,
        ..DAEMON
    },
    Variant {
        name: "tape of a daemon: 2 us later after waits of 4 ms",
        asleep: Some(Asleep { after: 4e-3, late: 2e-6 }),
        cases: SLEEPY,
        ..DAEMON
    },
    Variant {
        name: "tape of a daemon: 0.5 mV of 10 MHz",
        bandwidth_hz: Some(10e6),
        cases: &[
            (Tracked, &[100.0, 1000.0, 5000.0, 16_200.0]),
            (Cerm, &[100.0, 5000.0]),
            (Tcdic, &[100.0, 16_200.0]),
            (Tpcm, &[5000.0]),
            (Qerm, &[1000.0]),
        ],
        ..DAEMON
    },
    Variant {
        name: "tape of a daemon: a clock of 1 us, told",
        clock: Some(Clock { period_ns: 1000.0, is_told: true }),
        ..TICKING
    },
    Variant {
        name: "tape of a daemon: a clock of 5 us, told",
        clock: Some(Clock { period_ns: 5000.0, is_told: true }),
        ..TICKING
    },
    Variant {
        name: "tape of a daemon: a clock of 5 us, not told",
        clock: Some(Clock { period_ns: 5000.0, is_told: false }),
        ..TICKING
    },
    Variant {
        name: "tape of a daemon: a clock of 5 us, told, quiet",
        clock: Some(Clock { period_ns: 5000.0, is_told: true }),
        is_quiet: true,
        ..TICKING
    },
    Variant {
        name: "tape of a daemon: a clock of 5 us, not told, quiet",
        clock: Some(Clock { period_ns: 5000.0, is_told: false }),
        is_quiet: true,
        ..TICKING
    },
    Variant { name: "tape of a daemon: C walks by 100 ppm in a second", walk_c: 1e-4, ..WALKING },
    Variant { name: "tape of a daemon: V_Th walks by 1 mV in a second", walk_volt: 1e-3, ..WALKING },
    Variant { name: "tape of a daemon: Ro walks by 0.1 ohm in a second", walk_ohm: 0.1, ..WALKING },
    Variant { name: "tape of a daemon: Ro walks by 1 ohm in a second", walk_ohm: 1.0, ..WALKING },
    Variant { name: "tape of a daemon: one node", wiring: Wiring::One, cases: ONE, ..DAEMON },
    Variant {
        name: "tape of a daemon: one node, lines scatter by 2 us",
        wiring: Wiring::One,
        scatter_ns: 2000.0,
        cases: ONE,
        ..DAEMON
    },
    Variant {
        name: "tape of a daemon: one node, 1 Mohm at A",
        wiring: Wiring::One,
        beside: at_a(Load::to(0.0, 1e6)),
        cases: ONE,
        ..LEAKING
    },
    Variant {
        name: "tape of a daemon: one node, pull-up of 1 Mohm at A",
        wiring: Wiring::One,
        beside: at_a(Load::to(3.3, 1e6)),
        cases: ONE,
        ..LEAKING
    },
    Variant {
        name: "tape of a daemon: one node, 5 us later after waits of 2 ms",
        wiring: Wiring::One,
        asleep: Some(Asleep { after: 2e-3, late: 5e-6 }),
        cases: ONE,
        ..DAEMON
    },
    Variant { name: "tape of a daemon: the same, two nodes, each sensor to its end", ..TO_END },
    Variant {
        name: "tape of a daemon: the same, one node, each sensor to its end",
        wiring: Wiring::One,
        ..TO_END
    },
    // By now the state is no part of what shows it.
    Variant { name: "tape of a daemon: the same, two nodes, after 180 cycles", cycles: 200, ..TO_END },
    Variant {
        name: "tape of a daemon: the same, one node, after 180 cycles",
        wiring: Wiring::One,
        cycles: 200,
        ..TO_END
    },
];
