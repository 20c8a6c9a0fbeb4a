//! Tapes from a law written anew: nothing of the crate's circuit, simulation or estimators is in them, and what these share by
//! mistake shows here.
//!
//! Two capacitors that were charged to V_DD lose charge q through R + Ro, in series: node A is at V_DD exp(-theta / C_T), B
//! between it and V_DD as the capacitors divide, theta being the sum of time by resistance.

use super::{Seen, Trial, judge};
use crate::common::seed;
use cermd::ctl::replay::Replay;
use cermd::reading::Method;
use cermd::tape::Reader;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use serde_json::{Value, json};
use std::fmt::Write;

const V_DD: f64 = 3.3;
const R_C: [f64; 2] = [2320.0, 12_700.0];
/// Between the calls that release and sink, ns.
const PAUSE_NS: f64 = 1150.0;
/// Between two discharges, s: charging.
const CHARGE_S: f64 = 8e-3;
const BOARDS: u64 = 120;
/// Cycles of each tape, and how many of them count: the last ones.
const CYCLES: usize = 60;
const COUNTED: usize = 20;

/// What the tape of a variant does not say.
#[derive(Debug, Clone, Copy)]
struct Variant {
    name: &'static str,
    /// Stamps of B are later than those of A by so much, ns.
    b_later_ns: f64,
    /// Lines move before and after the instants on the tape, ns, 1 sigma, each for itself.
    scatter_ns: f64,
    /// The tape says so.
    is_told: bool,
    /// Ro walks by so many ohm in a second.
    walk_ohm: f64,
    /// The tape has the instants at which discharges started.
    has_t: bool,
    /// All estimates count, from the first on.
    from_first: bool,
    fails: &'static [(Method, f64)],
}

const PLAIN: Variant = Variant {
    name: "",
    b_later_ns: 0.0,
    scatter_ns: 0.0,
    is_told: false,
    walk_ohm: 0.0,
    has_t: true,
    from_first: false,
    fails: &[],
};

const VARIANTS: [Variant; 9] = [
    Variant { name: "tape: plain", ..PLAIN },
    Variant { name: "tape: from its first estimate on", from_first: true, ..PLAIN },
    Variant {
        name: "tape: from its first estimate on, lines scatter by 2 us",
        from_first: true,
        scatter_ns: 2000.0,
        ..PLAIN
    },
    Variant { name: "tape: plain, without the instants of starts", has_t: false, ..PLAIN },
    Variant { name: "tape: B is stamped 3 us later than A", b_later_ns: 3000.0, ..PLAIN },
    Variant { name: "tape: lines scatter by 0.3 us", scatter_ns: 300.0, ..PLAIN },
    Variant {
        name: "tape: lines scatter by 0.3 us, and it says so",
        scatter_ns: 300.0,
        is_told: true,
        ..PLAIN
    },
    Variant { name: "tape: lines scatter by 2 us", scatter_ns: 2000.0, ..PLAIN },
    Variant {
        name: "tape: Ro walks by 1 ohm in a second",
        walk_ohm: 1.0,
        fails: &[(Method::Tracked, 100.0)],
        ..PLAIN
    },
];

const CASES: [(Method, f64); 5] = [
    (Method::Tracked, 100.0),
    (Method::Tracked, 1000.0),
    (Method::Tracked, 5000.0),
    (Method::Cerm, 100.0),
    (Method::Tcdic, 5000.0),
];

/// One board, drawn anew for each tape. Seconds, ohm, farad, volt.
struct Board {
    c_a: f64,
    c_b: f64,
    v_th: f64,
    r_o: f64,
    late: f64,
    jitter: f64,
    noise: f64,
    now: f64,
    rng: ChaCha8Rng,
}

/// A discharge: through one resistor, and from an instant on through another.
#[derive(Clone, Copy)]
struct Way {
    first: f64,
    then: Option<(f64, f64)>,
}

impl Board {
    fn new(number: u64) -> Board {
        let mut rng = seed::rng(number);
        let mut within = |low: f64, high: f64| low + (high - low) * rng.random::<f64>();
        Board {
            c_a: within(2.0e-6, 2.4e-6),
            c_b: within(600e-9, 700e-9),
            v_th: within(1.1, 1.4),
            r_o: within(20.0, 60.0),
            late: within(3e-6, 12e-6),
            jitter: within(1e-6, 2e-6),
            noise: within(0.1e-3, 0.5e-3),
            now: 1.0,
            rng,
        }
    }

    fn normal(&mut self, sigma: f64) -> f64 {
        sigma * self.rng.sample::<f64, _>(StandardNormal)
    }

    fn c_t(&self) -> f64 {
        self.c_a * self.c_b / (self.c_a + self.c_b)
    }

    /// Of node A, volt, when A or B is at its threshold.
    fn v_a_at(&self, node_b: bool) -> f64 {
        if node_b { (self.v_th * (self.c_a + self.c_b) - V_DD * self.c_b) / self.c_a } else { self.v_th }
    }

    /// When a node crosses as the kernel stamps it, s since the start that is on the tape; the lines have moved so much later
    /// than that says: at the start, the release, the sinking.
    fn stamp(&mut self, way: Way, moved: [f64; 3], node_b: bool, b_later: f64) -> f64 {
        let v_a = self.v_a_at(node_b);
        let theta = self.c_t() * (V_DD / v_a).ln();
        let r = |resistor: f64| resistor + self.r_o;
        let released = way.then.map_or(f64::INFINITY, |(at, _)| at + moved[1]);
        let done = (released - moved[0]) / r(way.first);
        let (crossing, sunk) = match way.then {
            Some((at, second)) if done < theta => {
                (at + PAUSE_NS * 1e-9 + moved[2] + (theta - done) * r(second), second)
            }
            _ => (moved[0] + theta * r(way.first), way.first),
        };
        // Of A; B falls with it by the share of C_A.
        let slope =
            v_a / (r(sunk) * self.c_t()) * if node_b { self.c_a / (self.c_a + self.c_b) } else { 1.0 };
        let late = (self.late + self.normal(self.jitter)).max(0.0) + if node_b { b_later } else { 0.0 };
        crossing + self.normal(self.noise / slope) + late
    }

    /// One line of the tape.
    fn discharge(&mut self, variant: &Variant, seq: usize, through: &str, way: Way) -> String {
        let scatter = variant.scatter_ns * 1e-9;
        let moved = [0; 3].map(|_| self.normal(scatter));
        let [a, b] = [false, true].map(|node_b| self.stamp(way, moved, node_b, variant.b_later_ns * 1e-9));
        let ns = |seconds: f64| (seconds * 1e9).round();
        let mut line =
            json!({ "class": "DISCHARGE", "seq": seq, "through": through, "a_ns": ns(a), "b_ns": ns(b) });
        if through == "x" {
            line["channel"] = "x".into();
        }
        if variant.has_t {
            line["t_ns"] = ((self.now * 1e9) as i64).into();
        }
        if let Some((at, _)) = way.then {
            line["switch"] = json!({ "at_ns": ns(at), "on_ns": ns(at) + PAUSE_NS, "to": "c2" });
            if variant.is_told {
                line["switch"]["u_ns"] = variant.scatter_ns.into();
            }
        }
        let took = CHARGE_S + a.max(b);
        self.now += took;
        self.r_o = (self.r_o + self.normal(variant.walk_ohm * took.sqrt())).abs();
        line.to_string()
    }

    fn tape(&mut self, variant: &Variant, method: Method, r_x: f64) -> String {
        let circuit = json!({ "kind": "two-capacitor", "r_c1_ohm": R_C[0], "r_c2_ohm": R_C[1] });
        let header = json!({ "class": "TAPE", "proto_major": 1, "circuit": circuit, "channels": [{ "id": "x", "zero_ohm": 0, "scale": 1 }] });
        // As a program plans it that has seen some discharges.
        let theta_a = self.c_t() * (V_DD / self.v_th).ln();
        let t_a = |r: f64| 0.9 * theta_a * (r + 40.0);
        let is_split = method != Method::Tcdic && r_x < R_C[0];
        let ways = [
            ("c1", Way { first: R_C[0], then: None }),
            ("c2", Way { first: R_C[1], then: None }),
            ("c1", Way { first: R_C[0], then: Some((t_a(R_C[0]), R_C[1])) }),
            ("x", Way { first: r_x, then: is_split.then(|| (t_a(r_x), R_C[1])) }),
        ];
        let mut tape = header.to_string();
        for (index, (through, way)) in ways.iter().cycle().take(ways.len() * CYCLES).enumerate() {
            write!(tape, "\n{}", self.discharge(variant, index + 1, through, *way)).unwrap();
        }
        tape
    }
}

fn run(variant: &Variant, method: Method, r_x: f64) -> Seen {
    let mut seen = Seen::default();
    for number in 0..BOARDS {
        let tape = Board::new(number).tape(variant, method, r_x);
        let reader = Reader::open(tape.as_bytes()).unwrap();
        let mut replay = Replay::new(reader.header(), method, None).unwrap();
        let estimates: Vec<_> = reader.filter_map(|entry| replay.take(&entry.unwrap())).collect();
        assert_eq!(estimates.len(), CYCLES);
        seen.errors.next_board();
        let skipped = if variant.from_first { 0 } else { estimates.len() - COUNTED };
        for estimate in &estimates[skipped..] {
            let line = serde_json::to_value(estimate).unwrap();
            seen.readings += 1;
            match (line["r_ohm"].as_f64(), line["r_u_ohm"].as_f64()) {
                (Some(r_ohm), Some(u)) => {
                    seen.errors.errors.push(r_ohm - r_x);
                    seen.errors.us.push(u);
                }
                (Some(_), None) => seen.errors.without_u += 1,
                _ => seen.errors.not_ok.push(name_of(&line)),
            }
        }
    }
    seen
}

/// Of what is no number.
fn name_of(line: &Value) -> &'static str {
    use cermd::reading::Fault;
    let name = line["fault"].as_str();
    Fault::ALL.iter().map(|fault| fault.as_str()).find(|fault| name == Some(fault)).unwrap_or("short")
}

#[test]
fn hostile_tapes() {
    let cases = VARIANTS.iter().flat_map(|variant| CASES.map(|case| (variant, case)));
    let trials = cases.map(|(variant, (method, r_ohm))| Trial {
        name: variant.name,
        method,
        r_ohm,
        fails: variant.fails.contains(&(method, r_ohm)),
        // A switched discharge tells nothing before there is a state.
        least_numbers: if variant.from_first { 0.4 } else { 0.5 },
        wild: 0,
        run: move || run(variant, method, r_ohm),
    });
    judge("tapes of an independent law", trials);
}
