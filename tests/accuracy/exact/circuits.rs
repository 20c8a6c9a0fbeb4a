//! Random circuits, and the discharges that Kirchhoff's laws give for them.

use cermd::circuit::{Network, Node};
use cermd::pins::sim::SimCircuit;
use cermd::pins::sim::network::{LINES, Sense};
use cermd::pins::{Drives, MAX_CHANNELS};
use cermd::reading::{Branch, Method};
use cermd::record::{Record, Switch, Through};
use cermd::units::{Farad, Nanos};
use proptest::prelude::*;

/// What a sensor is read by: a method and the line of its equation, in a circuit with one or two nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Way {
    pub method: Method,
    pub branch: Branch,
    pub nodes: usize,
}

pub const WAYS: [Way; 7] = [
    Way { method: Method::Tpcm, branch: Branch::Direct, nodes: 1 },
    Way { method: Method::Tpcm, branch: Branch::Direct, nodes: 2 },
    Way { method: Method::Qerm, branch: Branch::Direct, nodes: 1 },
    Way { method: Method::Qerm, branch: Branch::Inferred, nodes: 1 },
    Way { method: Method::Tcdic, branch: Branch::Direct, nodes: 2 },
    Way { method: Method::Cerm, branch: Branch::Direct, nodes: 2 },
    Way { method: Method::Cerm, branch: Branch::Inferred, nodes: 2 },
];

/// How the capacitors are filled before a discharge.
#[derive(Debug, Clone, Copy)]
pub enum Charge {
    /// For ever: both nodes at V_DD.
    Full,
    /// From empty, for so many seconds.
    For(f64),
}

/// A circuit, a sensor, and how they are timed.
#[derive(Debug, Clone)]
pub struct Case {
    pub way: Way,
    pub circuit: SimCircuit,
    pub charge: Charge,
    /// Lateness d of every crossing, ns.
    pub d_ns: f64,
    /// Where the switch comes, as a share of the time until the last node crosses.
    pub switch_share: f64,
    /// From the release of the first resistor (for QERM: the sensor's sinking) to the sinking of the next, ns.
    pub gap_ns: f64,
}

fn log_uniform(from: f64, to: f64) -> impl Strategy<Value = f64> {
    (from.ln()..to.ln()).prop_map(f64::exp)
}

/// A node with one threshold and nothing else.
fn ideal(v_th: f64) -> Sense {
    Sense { falling: v_th, rising: v_th, ..Default::default() }
}

/// Capacitors from 1 nF to 100 uF, Rc1 < Rc2, V_DD and V_Th such that node B crosses, R_x from 10 ohm to 1 Mohm, Ro from
/// 0 to 100 ohm, d from 0 to 50 us, charged for ever or for 1 to 20 time constants from empty.
pub fn cases() -> impl Strategy<Value = Case> {
    let capacitors = (log_uniform(1e-9, 1e-4), 0.01..0.95f64);
    let voltages = (1.8..5.5f64, 0.15..0.75f64);
    let resistors = (log_uniform(100.0, 10e3), log_uniform(1.2, 50.0), log_uniform(10.0, 1e6), 0.0..100.0f64);
    let timing = (0.0..50e3f64, 0.02..0.999f64, 0.0..1000.0f64, prop::option::of(1.0..20.0f64));
    (prop::sample::select(WAYS.to_vec()), capacitors, voltages, resistors, timing).prop_map(
        |(way, (c_a, b_share), (v_dd, th_share), (r_c1, r_c2_by, r_x, r_o), timing)| {
            let (d_ns, switch_share, gap_ns, charge_taus) = timing;
            let v_th = v_dd * th_share;
            let network = match (way.method, way.nodes) {
                (Method::Qerm, _) => Network::SeriesCalibration { c: Farad(c_a) },
                (_, 1) => Network::OneCapacitor { c: Farad(c_a) },
                // Node B crosses as long as C_B (V_DD - V_Th) < C_A V_Th.
                _ => {
                    let c_b = b_share * c_a * v_th / (v_dd - v_th);
                    Network::TwoCapacitor { c_a: Farad(c_a), c_b: Farad(c_b) }
                }
            };
            let r_p = 180.0;
            let mut r_x_of = [f64::INFINITY; MAX_CHANNELS];
            r_x_of[0] = r_x;
            let circuit = SimCircuit {
                network,
                absorption: Default::default(),
                v_dd,
                r_c1,
                r_c2: r_c1 * r_c2_by,
                r_p,
                r_o: [r_o; LINES],
                r_x: r_x_of,
                sense: [ideal(v_th); 2],
            };
            let charge = charge_taus.map_or(Charge::Full, |taus| {
                // Of the slower mode where C_A is much greater than C_B; the charge must lift both nodes.
                Charge::For((2.0 + taus) * 2.0 * (r_p + r_o) * c_a)
            });
            Case { way, circuit, charge, d_ns, switch_share, gap_ns }
        },
    )
}

/// One state of the lines after another, from the instant (seconds) on that stands beside it.
type Steps = [(f64, Drives)];

/// When the nodes cross, seconds, from voltages `start`; and the voltages `lag` seconds after the last of them.
pub fn walk(circuit: &SimCircuit, start: [f64; 2], steps: &Steps, lag: f64) -> ([Option<f64>; 2], [f64; 2]) {
    let mut crossings = [None; 2];
    let (mut voltages, mut last) = (start, circuit.flow(start, Drives::NONE));
    let mut began = 0.0;
    for (index, (from, on)) in steps.iter().enumerate() {
        voltages = last.after(from - began);
        (last, began) = (circuit.flow(voltages, *on), *from);
        let until = steps.get(index + 1).map_or(f64::INFINITY, |next| next.0 - from);
        for node in Node::BOTH.into_iter().filter(|node| *node == Node::A || circuit.has_b()) {
            let crossing = &mut crossings[node.index()];
            let threshold = circuit.sense[node.index()].falling;
            *crossing =
                crossing.or_else(|| last.waveform(node).falls_after(0.0, threshold, until).map(|t| from + t));
        }
    }
    let end = crossings.iter().flatten().fold(0.0, |end: f64, t| end.max(*t)) + lag;
    if end > began {
        voltages = last.after(end - began);
    }
    (crossings, voltages)
}

/// The record that a kernel with lateness d makes of crossings in seconds.
pub fn record(through: Through, crossings: [Option<f64>; 2], d_ns: f64) -> Record {
    let [a_ns, b_ns] = crossings.map(|crossing| crossing.map(|t| t * 1e9 + d_ns));
    Record {
        through,
        start: Nanos::ZERO,
        second_ns: None,
        switch: None,
        a_ns,
        b_ns,
        u_switch_ns: None,
        waited_ns: None,
        later_ns: None,
    }
}

impl Case {
    pub fn r_x(&self) -> f64 {
        self.circuit.r_x[0]
    }

    /// R_1 and R_2 of the ratio.
    pub fn r_ohm(&self) -> [f64; 2] {
        let SimCircuit { r_c1, r_c2, .. } = self.circuit;
        [r_c1, if self.way.method == Method::Qerm { r_c1 + r_c2 } else { r_c2 }]
    }

    pub fn second(&self) -> Through {
        if self.way.method == Method::Qerm { Through::C12 } else { Through::C2 }
    }

    fn start(&self) -> [f64; 2] {
        match self.charge {
            Charge::Full => [self.circuit.v_dd; 2],
            Charge::For(seconds) => self.circuit.flow([0.0; 2], Drives::CHARGE).after(seconds),
        }
    }

    fn record(
        &self,
        through: Through,
        steps: &Steps,
        second_ns: Option<f64>,
        switch: Option<Switch>,
    ) -> Record {
        let (crossings, _) = walk(&self.circuit, self.start(), steps, 0.0);
        Record { second_ns, switch, ..record(through, crossings, self.d_ns) }
    }

    pub fn full(&self, through: Through) -> Record {
        self.record(through, &[(0.0, through.drives())], None, None)
    }

    /// Runs through R_1 until this share of its way to A's threshold, and then through R_2.
    pub fn split(&self, share: f64) -> Record {
        let crossing_ns = self.full(Through::C1).a_ns.unwrap() - self.d_ns;
        self.switched(Through::C1, share * crossing_ns)
    }

    fn switched(&self, through: Through, at_ns: f64) -> Record {
        let (on_ns, to) = (at_ns + self.gap_ns, self.second());
        let steps = [(0.0, through.drives()), (at_ns * 1e-9, Drives::NONE), (on_ns * 1e-9, to.drives())];
        self.record(through, &steps, None, Some(Switch { at_ns, on_ns, to }))
    }

    /// The x discharge of the way.
    pub fn of_sensor(&self) -> Record {
        let x = Through::X(0);
        if self.way.method == Method::Qerm {
            return self.of_sensor_and_series();
        }
        let full = self.full(x);
        match self.way.branch {
            Branch::Direct => full,
            Branch::Inferred => self.switched(x, self.switch_share * (full.b_ns.unwrap() - self.d_ns)),
        }
    }

    /// Fig. 1(b): the sensor first, Rc1 + Rc2 beside it a little later, at last alone.
    fn of_sensor_and_series(&self) -> Record {
        let through = Through::XWithC12(0);
        let alone_ns = self.full(Through::X(0)).a_ns.unwrap() - self.d_ns;
        let second_ns = self.gap_ns.min(0.5 * alone_ns);
        let both = [(0.0, Drives::x(0)), (second_ns * 1e-9, through.drives())];
        let together = self.record(through, &both, Some(second_ns), None);
        match self.way.branch {
            Branch::Direct => together,
            Branch::Inferred => {
                let rest_ns = together.a_ns.unwrap() - self.d_ns - second_ns;
                let at_ns = second_ns + self.switch_share * rest_ns;
                let steps = [both[0], both[1], (at_ns * 1e-9, Drives::C2)];
                self.record(
                    through,
                    &steps,
                    Some(second_ns),
                    Some(Switch { at_ns, on_ns: at_ns, to: Through::C12 }),
                )
            }
        }
    }
}
