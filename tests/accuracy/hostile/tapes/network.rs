//! The capacitors and what flows beside the resistors, as a linear differential equation that is integrated by its own series.
//!
//! With two capacitors C_A lies between A and B and C_B from B to ground; with one, C_A lies from A to ground and there is no B.
//! The state is what lies across each capacitor, and across that of the branch in which its dielectric absorbs:
//!
//! ```text
//! C_A du_A/dt = i_A - share_A C_A (u_A - w_A) / tau_A         u_A = v_A - v_B
//! C_B dv_B/dt = i_A + i_B - share_B C_B (v_B - w_B) / tau_B
//! dw/dt = (u - w) / tau                                       i = amperes - siemens v, of each node
//! ```

/// u_A, v_B, w_A, w_B, volt.
pub const STATES: usize = 4;
pub type State = [f64; STATES];

/// Terms of a series, over one time constant at the most: what is left out is below 1e-12 of what there is.
const TERMS: usize = 15;
const HALVINGS: usize = 50;

/// What is connected to a node: the current into it is `amperes - siemens v`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Load {
    pub amperes: f64,
    pub siemens: f64,
}

impl Load {
    pub const NONE: Load = Load { amperes: 0.0, siemens: 0.0 };

    /// A resistor to a voltage.
    pub const fn to(volt: f64, ohm: f64) -> Load {
        Load { amperes: volt / ohm, siemens: 1.0 / ohm }
    }

    pub fn and(self, other: Load) -> Load {
        Load { amperes: self.amperes + other.amperes, siemens: self.siemens + other.siemens }
    }
}

/// A dielectric that takes up a share of the charge with a time constant, s.
#[derive(Debug, Clone, Copy)]
pub struct Absorption {
    pub share: f64,
    pub tau: f64,
}

/// Capacitors, farad; of one node, the second is `None`.
#[derive(Debug, Clone, Copy)]
pub struct Network {
    pub c_a: f64,
    pub c_b: Option<f64>,
    pub absorption: Option<Absorption>,
    /// What is always connected to A and to B.
    pub beside: [Load; 2],
}

impl Network {
    /// Both nodes at a voltage, which has been there for ever.
    pub fn at_rest(&self, volt: f64) -> State {
        match self.c_b {
            Some(_) => [0.0, volt, 0.0, volt],
            None => [volt, 0.0, volt, 0.0],
        }
    }

    /// The equation while these are connected to A and to B, too.
    pub fn flow(&self, connected: [Load; 2]) -> Flow {
        let [a, b] = [0, 1].map(|node| self.beside[node].and(connected[node]));
        let has_b = self.c_b.is_some();
        let Absorption { share, tau } = self.absorption.unwrap_or(Absorption { share: 0.0, tau: 1.0 });
        let absorbs = share / tau;
        let by_b = f64::from(u8::from(has_b));
        let mut flow = Flow { matrix: [[0.0; STATES]; STATES], source: [0.0; STATES], by_b };
        let of_a = a.siemens / self.c_a;
        flow.matrix[0] = [-of_a - absorbs, -of_a * by_b, absorbs, 0.0];
        flow.source[0] = a.amperes / self.c_a;
        if let Some(c_b) = self.c_b {
            flow.matrix[1] = [-a.siemens / c_b, -(a.siemens + b.siemens) / c_b - absorbs, 0.0, absorbs];
            flow.source[1] = (a.amperes + b.amperes) / c_b;
        }
        flow.matrix[2] = [1.0 / tau, 0.0, -1.0 / tau, 0.0];
        flow.matrix[3] = [0.0, 1.0 / tau, 0.0, -1.0 / tau];
        flow
    }
}

/// dx/dt = M x + b.
#[derive(Debug, Clone, Copy)]
pub struct Flow {
    matrix: [[f64; STATES]; STATES],
    source: State,
    /// 1 if there is a node B.
    by_b: f64,
}

/// Where a node passes its threshold, s after what the time is counted from, and how fast it falls there, V/s.
#[derive(Debug, Clone, Copy)]
pub struct Crossing {
    pub at: f64,
    pub slope: f64,
}

/// The network on its way.
#[derive(Debug, Clone, Copy)]
pub struct Course {
    pub state: State,
    /// Seconds since what the time is counted from.
    pub time: f64,
    pub crossings: [Option<Crossing>; 2],
}

impl Course {
    pub fn from(state: State) -> Course {
        Course { state, time: 0.0, crossings: [None; 2] }
    }

    /// Goes on until a time, or until a node falls to its threshold if that is to end it; whether one has.
    pub fn go(&mut self, flow: &Flow, until: f64, v_th: f64, last: Option<usize>) -> bool {
        let longest = 1.0 / flow.fastest();
        while self.time < until {
            let step = longest.min(until - self.time);
            let series = flow.series(self.state);
            for node in 0..2 {
                let Some(after) = self.falls(&flow.volts(&series, node), step, v_th, node) else { continue };
                if last == Some(node) {
                    (self.state, self.time) = (at(&series, after), self.time + after);
                    return true;
                }
            }
            // What rounding leaves of the way is not gone for ever.
            self.time = if step < longest { until } else { self.time + step };
            self.state = at(&series, step);
        }
        false
    }

    /// After how long in a step a node falls to its threshold for the first time.
    fn falls(&mut self, volts: &[f64; TERMS], step: f64, v_th: f64, node: usize) -> Option<f64> {
        let above = |t: f64| volts.iter().rev().fold(0.0, |sum, term| sum * t + term) - v_th;
        if self.crossings[node].is_some() || above(0.0) <= 0.0 || above(step) > 0.0 {
            return None;
        }
        let (mut low, mut high) = (0.0, step);
        for _ in 0..HALVINGS {
            let middle = f64::midpoint(low, high);
            if above(middle) > 0.0 { low = middle } else { high = middle }
        }
        let slope = volts.iter().enumerate().skip(1).rev();
        let slope = slope.fold(0.0, |sum, (power, term)| sum * high + power as f64 * term);
        self.crossings[node] = Some(Crossing { at: self.time + high, slope: slope.abs() });
        Some(high)
    }
}

impl Flow {
    /// No faster than this does anything change, 1/s.
    fn fastest(&self) -> f64 {
        let sums = self.matrix.iter().map(|row| row.iter().map(|part| part.abs()).sum::<f64>());
        sums.fold(1.0, f64::max)
    }

    /// The terms of x(t) in powers of t.
    fn series(&self, start: State) -> [State; TERMS] {
        let mut terms = [start; TERMS];
        for power in 1..TERMS {
            let before = terms[power - 1];
            for (row, term) in terms[power].iter_mut().enumerate() {
                let source = if power == 1 { self.source[row] } else { 0.0 };
                let sum: f64 = self.matrix[row].iter().zip(before).map(|(part, x)| part * x).sum();
                *term = (sum + source) / power as f64;
            }
        }
        terms
    }

    /// The voltage of a node in powers of t. Of a node that there is not, 0.
    fn volts(&self, series: &[State; TERMS], node: usize) -> [f64; TERMS] {
        let by_a = if node == 0 { 1.0 } else { 0.0 };
        series.map(|[u_a, v_b, ..]| by_a * u_a + self.by_b * v_b)
    }
}

fn at(series: &[State; TERMS], t: f64) -> State {
    let mut state = State::default();
    for term in series.iter().rev() {
        state = std::array::from_fn(|index| state[index] * t + term[index]);
    }
    state
}

#[cfg(test)]
mod tests {
    use super::*;

    const V_DD: f64 = 3.3;
    const V_TH: f64 = 1.2;
    const C: [f64; 2] = [2.2e-6, 680e-9];

    fn network() -> Network {
        Network { c_a: C[0], c_b: Some(C[1]), absorption: None, beside: [Load::NONE; 2] }
    }

    fn crossings(network: &Network, parts: &[(f64, f64)]) -> [f64; 2] {
        let mut course = Course::from(network.at_rest(V_DD));
        for (until, ohm) in parts {
            course.go(&network.flow([Load::to(0.0, *ohm), Load::NONE]), *until, V_TH, None);
        }
        course.crossings.map(|crossing| crossing.map_or(f64::NAN, |crossing| crossing.at))
    }

    /// Progress is the charge that has left, whatever it left through.
    #[test]
    fn without_leaks_crossings_are_those_of_the_charge() {
        let [c_a, c_b] = C;
        let c_t = c_a * c_b / (c_a + c_b);
        let v_a_of_b = (V_TH * (c_a + c_b) - V_DD * c_b) / c_a;
        let theta = [V_TH, v_a_of_b].map(|v_a| c_t * (V_DD / v_a).ln());
        for ohm in [70.0, 510.0, 12_740.0, 100_040.0] {
            let found = crossings(&network(), &[(1.0, ohm)]);
            for node in 0..2 {
                assert!((found[node] - theta[node] * ohm).abs() < 1e-11, "{ohm} {node}: {found:?}");
            }
        }
        let at = 0.9 * theta[0] * 140.0;
        let found = crossings(&network(), &[(at, 140.0), (1.0, 12_740.0)]);
        for node in 0..2 {
            let due = at + (theta[node] - at / 140.0) * 12_740.0;
            assert!((found[node] - due).abs() < 1e-10, "{node}: {found:?}");
        }
    }

    /// A second way to the same: small steps of the midpoint rule.
    #[test]
    fn leaks_and_dielectrics_are_those_of_another_integration() {
        let absorption = Some(Absorption { share: 0.0025, tau: 1e-3 });
        let beside = [Load { amperes: 5e-6, siemens: 1e-6 }, Load::to(0.0, 3e6)];
        for network in [
            Network { absorption, beside, ..network() },
            Network { c_b: None, absorption, beside: [beside[0], Load::NONE], ..network() },
        ] {
            let [found, _] = crossings(&network, &[(1.0, 2360.0)]);
            let flow = network.flow([Load::to(0.0, 2360.0), Load::NONE]);
            let speed = |x: &State| -> State {
                std::array::from_fn(|row| {
                    flow.source[row] + (0..STATES).map(|i| flow.matrix[row][i] * x[i]).sum::<f64>()
                })
            };
            let (mut x, mut t, step) = (network.at_rest(V_DD), 0.0, 1e-7);
            let mut before = [0.0; 2];
            while x[0] + x[1] > V_TH {
                before = [t, x[0] + x[1]];
                let half = speed(&x);
                let middle: State = std::array::from_fn(|i| x[i] + 0.5 * step * half[i]);
                let slope = speed(&middle);
                x = std::array::from_fn(|i| x[i] + step * slope[i]);
                t += step;
            }
            let due = before[0] + step * (before[1] - V_TH) / (before[1] - x[0] - x[1]);
            assert!((found - due).abs() < 1e-10, "{found} {due}");
        }
    }

    #[test]
    fn a_charge_fills_dielectrics_as_their_time_constant_says() {
        let absorption = Some(Absorption { share: 0.01, tau: 10e-3 });
        let network = Network { c_b: None, absorption, ..network() };
        let mut course = Course::from([0.0; STATES]);
        course.go(&network.flow([Load::to(V_DD, 1.0), Load::NONE]), 10e-3, 0.0, None);
        let due = V_DD * (1.0 - (-1.0f64).exp());
        assert!((course.state[0] / V_DD - 1.0).abs() < 1e-5 && (course.state[2] / due - 1.0).abs() < 1e-3);
    }
}
