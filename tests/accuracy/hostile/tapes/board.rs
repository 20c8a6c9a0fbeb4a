//! A board drawn at random, and what a kernel on it says of its discharges.

use super::network::{Course, Crossing, Load, Network, State};
use super::variants::Variant;
use crate::common::seed;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

pub const V_DD: f64 = 3.3;
pub const R_C2: f64 = 12_700.0;
/// In series with each charger, ohm, and with a pin of a usual board.
const R_P: f64 = 220.0;
const R_CHARGE: f64 = 260.0;
/// From the release at the end of a charge to the start, s: arming.
const FLOATS_S: f64 = 50e-6;
/// From the last crossing to the charge, s: what sinks goes on as long as the program needs to wake.
const ENDS_S: f64 = 60e-6;
/// From the sinking of the sensor to that of what sinks beside it, s.
pub const SECOND_S: f64 = 600e-9;
/// Whoever waits for a crossing gives up then, s.
pub const DEADLINE_S: f64 = 1.0;
/// A noisy input is looked at from so many sigma before its crossing on.
const EARLIEST_SIGMA: f64 = 5.5;

/// How capacitors and calibration resistors are wired.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wiring {
    Two,
    One,
    /// One capacitor, Rc2 in series with Rc1.
    Series,
}

/// What sinks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Path {
    C1,
    /// Rc2, or both in series.
    C2,
    X,
    /// The sensor, and Rc1 and Rc2 in series.
    Beside,
}

/// A discharge through one path, and from an instant on through another.
#[derive(Debug, Clone, Copy)]
pub struct Way {
    pub first: Path,
    pub then: Option<Then>,
    /// The node whose crossing ends it.
    pub last: usize,
    /// How much longer than usual both chargers drive before it, s.
    pub rest: f64,
}

/// s since the start. To the path that sinks already at one instant: the program wakes.
#[derive(Debug, Clone, Copy)]
pub struct Then {
    pub at: f64,
    pub on: f64,
    pub to: Path,
}

/// What is known of a discharge, s since its start.
#[derive(Debug, Clone, Copy)]
pub struct Timed {
    pub start_ns: i64,
    pub stamps: [Option<f64>; 2],
    /// The noise of A's.
    pub sigma: f64,
    /// The last node crossed after the switch, if one was to be.
    pub is_switched: bool,
}

/// Seconds, ohm, farad, volt.
#[derive(Debug, Clone)]
pub struct Board<'a> {
    pub variant: &'a Variant,
    pub wiring: Wiring,
    r_x: f64,
    network: Network,
    v_th: f64,
    r_o: f64,
    late: f64,
    jitter: f64,
    noise: f64,
    now: f64,
    /// Both chargers drive for so long that nothing is remembered.
    pub charges_anew: bool,
    state: State,
    rng: ChaCha8Rng,
}

impl<'a> Board<'a> {
    pub fn new(number: u64, variant: &'a Variant, wiring: Wiring, r_x: f64) -> Board<'a> {
        let mut rng = seed::rng(number);
        let mut within = |low: f64, high: f64| low + (high - low) * rng.random::<f64>();
        let (c_a, c_b, c) = (within(2.0e-6, 2.4e-6), within(600e-9, 700e-9), within(420e-9, 520e-9));
        let is_two = wiring == Wiring::Two;
        let network = Network {
            c_a: if is_two { c_a } else { c },
            c_b: is_two.then_some(c_b),
            absorption: variant.absorption,
            beside: variant.beside,
        };
        let noise = within(0.1e-3, 0.5e-3);
        let loud = if variant.is_quiet { 0.1 } else { 1.0 };
        Board {
            variant,
            wiring,
            r_x,
            v_th: within(1.1, 1.4),
            r_o: within(20.0, 60.0),
            late: within(3e-6, 12e-6),
            jitter: loud * within(1e-6, 2e-6),
            noise: variant.bandwidth_hz.map_or(loud * noise, |_| 0.5e-3),
            now: within(1.0, 2.0),
            charges_anew: false,
            state: network.at_rest(V_DD),
            network,
            rng,
        }
    }

    fn normal(&mut self, sigma: f64) -> f64 {
        sigma * self.rng.sample::<f64, _>(StandardNormal)
    }

    /// R_1 and R_2 of the equations.
    pub fn known_ohm(&self) -> [f64; 2] {
        let beyond = if self.wiring == Wiring::Series { self.variant.r_c1 } else { 0.0 };
        [self.variant.r_c1, R_C2 + beyond]
    }

    /// The output resistance of a pin now.
    pub fn r_o(&self) -> f64 {
        self.r_o
    }

    fn sunk(&self, path: Path) -> Load {
        let [r1, r2] = self.known_ohm().map(|ohm| Load::to(0.0, ohm + self.r_o));
        let x = Load::to(0.0, self.r_x + self.r_o);
        match path {
            Path::C1 => r1,
            Path::C2 => r2,
            Path::X => x,
            Path::Beside => x.and(r2),
        }
    }

    /// By A's charger alone, nine and a half of its time constants long, and by both for half a time constant of theirs, as daemons do; by
    /// both for seven and a half where it is to remember nothing.
    fn charge(&mut self, rest: f64) {
        let Network { c_a, c_b, .. } = self.network;
        let c_t = c_b.map_or(c_a, |c_b| c_a * c_b / (c_a + c_b));
        let taus = if self.charges_anew { 7.5 } else { 0.5 };
        let (alone, together) = (9.5 * R_CHARGE * c_t, c_b.map_or(0.0, |c_b| taus * R_CHARGE * (c_a + c_b)));
        let charger = Load::to(V_DD, R_P + self.r_o);
        let mut course = Course::from(self.state);
        for (time, connected) in [
            (alone, [charger, Load::NONE]),
            (together + rest, [charger, charger]),
            (FLOATS_S, [Load::NONE, Load::NONE]),
        ] {
            let until = course.time + time;
            course.go(&self.network.flow(connected), until, f64::NEG_INFINITY, None);
        }
        self.state = course.state;
        self.pass(course.time);
    }

    /// Time goes on, and the board with it.
    fn pass(&mut self, seconds: f64) {
        let Variant { walk_ohm, walk_c, walk_volt, .. } = *self.variant;
        self.now += seconds;
        let root = seconds.sqrt();
        self.r_o = (self.r_o + self.normal(walk_ohm * root)).abs();
        self.v_th += self.normal(walk_volt * root);
        let factor = 1.0 + self.normal(walk_c * root);
        self.network.c_a *= factor;
        self.network.c_b = self.network.c_b.map(|c_b| c_b * factor);
    }

    /// Charges, and takes a discharge.
    pub fn discharge(&mut self, way: &Way) -> Timed {
        self.charge(way.rest);
        let start_ns = (self.now * 1e9) as i64;
        let scatter = self.variant.scatter_ns * 1e-9;
        let moved = [0; 3].map(|_| self.normal(scatter));
        let mut course = Course { time: moved[0], ..Course::from(self.state) };
        let mut is_switched = false;
        let mut sinks = Load::NONE;
        for (since, until, load) in self.parts(way, moved) {
            is_switched |= way.then.is_some_and(|then| since >= then.at + moved[1]);
            sinks = load;
            let flow = self.network.flow([load, Load::NONE]);
            if course.go(&flow, until, self.v_th, Some(way.last)) {
                break;
            }
        }
        let actions = [Some(0.0), way.then.filter(|_| is_switched).map(|then| then.on)];
        let stamps = self.stamps(&course, start_ns, actions);
        let of_volts = course.crossings[0].map_or(0.0, |crossing| self.noise / crossing.slope);
        let sigma = self.jitter.hypot(of_volts);
        let ends = course.time + ENDS_S;
        course.go(&self.network.flow([sinks, Load::NONE]), ends, f64::NEG_INFINITY, None);
        self.state = course.state;
        self.pass(ends);
        Timed { start_ns, stamps, sigma, is_switched }
    }

    /// What sinks from when to when; the lines have moved so much later than they should: at the start, the release, the sinking.
    fn parts(&self, way: &Way, moved: [f64; 3]) -> Vec<(f64, f64, Load)> {
        let first = self.sunk(way.first);
        let mut parts = Vec::with_capacity(4);
        let mut since = moved[0];
        let mut add = |until: f64, load: Load| {
            parts.push((since, until, load));
            since = until;
        };
        if way.first == Path::Beside {
            add(moved[0] + SECOND_S, self.sunk(Path::X));
        }
        if let Some(Then { at, on, to }) = way.then {
            add(at + moved[1], first);
            // Of two that sink one is released, or no line is touched.
            let goes_on = to == way.first || (way.first == Path::Beside && to == Path::C2);
            if !goes_on || on > at {
                add(on + moved[2].max(at - on + moved[1]), Load::NONE);
            }
            add(DEADLINE_S, self.sunk(to));
        } else {
            add(DEADLINE_S, first);
        }
        parts
    }

    /// The crossings as the kernel stamps them; `actions`: when the program acted last, the start and the switch.
    fn stamps(&mut self, course: &Course, start_ns: i64, actions: [Option<f64>; 2]) -> [Option<f64>; 2] {
        let mut woken: Option<f64> = None;
        let mut stamps = [None; 2];
        for (node, crossing) in course.crossings.into_iter().enumerate() {
            let Some(crossing) = crossing else { continue };
            let acted = actions.into_iter().flatten().chain(woken).filter(|at| *at < crossing.at);
            let waited = crossing.at - acted.fold(0.0, f64::max);
            let seen = crossing.at + self.noise_of(crossing);
            let stamp = seen + self.lateness(node, waited);
            woken = Some(stamp);
            stamps[node] = Some(self.by_clock(start_ns, stamp));
        }
        stamps
    }

    fn lateness(&mut self, node: usize, waited: f64) -> f64 {
        let Variant { b_later_ns, asleep, .. } = *self.variant;
        let of_b = if node == 1 { b_later_ns * 1e-9 } else { 0.0 };
        let of_sleep = asleep.filter(|asleep| waited > asleep.after).map_or(0.0, |asleep| asleep.late);
        (self.late + self.normal(self.jitter)).max(0.0) + of_b + of_sleep
    }

    /// By how much a noisy input changes after its crossing, s.
    fn noise_of(&mut self, Crossing { slope, .. }: Crossing) -> f64 {
        let sigma = self.noise / slope;
        match self.variant.bandwidth_hz {
            None => self.normal(sigma),
            Some(bandwidth_hz) => self.first_below(sigma, 0.5 / bandwidth_hz),
        }
    }

    /// Wide-band noise is as many independent values, the first of which below the threshold counts.
    fn first_below(&mut self, sigma: f64, apart: f64) -> f64 {
        let mut time = -EARLIEST_SIGMA * sigma + apart * self.rng.random::<f64>();
        while self.normal(sigma) > time {
            time += apart;
        }
        time
    }

    /// A clock shows its last tick.
    fn by_clock(&self, start_ns: i64, stamp: f64) -> f64 {
        let ns = start_ns as f64 + stamp * 1e9;
        let period_ns = self.variant.clock.map_or(1.0, |clock| clock.period_ns);
        ((ns / period_ns).floor() * period_ns - start_ns as f64) * 1e-9
    }
}
