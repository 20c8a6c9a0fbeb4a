//! The published equations and the law of the circuit, written a second time for predictions: nothing of the estimators is
//! used here. Seconds, ohm, farad and volt.

/// Capacitors, resistors and the threshold of a board.
#[derive(Debug, Clone, Copy)]
pub struct Parts {
    pub c_a: f64,
    pub c_b: f64,
    /// Of the circuits with one capacitor.
    pub c: f64,
    pub r_c1: f64,
    pub r_c2: f64,
    pub v_th: f64,
}

pub const V_DD: f64 = 3.3;
pub const R_O: f64 = 40.0;

impl Parts {
    pub const PI4: Parts =
        Parts { c_a: 2.2e-6, c_b: 680e-9, c: 470e-9, r_c1: 470.0, r_c2: 12_700.0, v_th: 1.1 };
    /// Section IV.
    pub const PAPER: Parts =
        Parts { c_a: 330e-9, c_b: 22e-9, c: 20e-9, r_c1: 2320.0, v_th: 1.441, ..Parts::PI4 };

    /// g_A and g_B: eq. (10) divided by R + Ro.
    pub fn g(&self) -> [f64; 2] {
        let c_t = self.c_a * self.c_b / (self.c_a + self.c_b);
        let b = V_DD * self.c_a / (self.v_th * (self.c_a + self.c_b) - V_DD * self.c_b);
        [c_t * (V_DD / self.v_th).ln(), c_t * b.ln()]
    }

    /// The same of a single capacitor: eq. (2).
    pub fn g_single(&self) -> f64 {
        self.c * (V_DD / self.v_th).ln()
    }

    /// One volt over the slope of A and B where they cross, divided by R + Ro: eq. (7), and for B by eq. (9).
    pub fn s_per_volt_ohm(&self) -> [f64; 2] {
        let sum = self.c_a + self.c_b;
        let c_t = self.c_a * self.c_b / sum;
        let v_a_at_b = (self.v_th * sum - V_DD * self.c_b) / self.c_a;
        [c_t / self.v_th, c_t / (v_a_at_b * self.c_a / sum)]
    }

    /// The resistor of the second calibration discharge of QERM.
    pub fn r_series(&self) -> f64 {
        self.r_c1 + self.r_c2
    }
}

/// The crossings of the three discharges, and when a switch came.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Times {
    pub c1: [f64; 2],
    pub c2: [f64; 2],
    pub x: [f64; 2],
    pub switch: f64,
}

impl Times {
    /// Without noise; `switch` of 0: none. It comes before A crosses, or not at all.
    pub fn of(parts: &Parts, r_x: f64, switch: f64) -> Times {
        let full = |r: f64| parts.g().map(|g| g * (r + R_O));
        let x = if switch > 0.0 {
            parts.g().map(|g| switch + (g - switch / (r_x + R_O)) * (parts.r_c2 + R_O))
        } else {
            full(r_x)
        };
        Times { c1: full(parts.r_c1), c2: full(parts.r_c2), x, switch }
    }

    fn to_array(self) -> [f64; 7] {
        let Times { c1, c2, x, switch } = self;
        [c1[0], c1[1], c2[0], c2[1], x[0], x[1], switch]
    }

    fn from_array([c1a, c1b, c2a, c2b, xa, xb, switch]: [f64; 7]) -> Times {
        Times { c1: [c1a, c1b], c2: [c2a, c2b], x: [xa, xb], switch }
    }

    /// Each time later by so much.
    pub fn plus(self, late: Times) -> Times {
        let (mut sum, late) = (self.to_array(), late.to_array());
        sum.iter_mut().zip(late).for_each(|(sum, late)| *sum += late);
        Times::from_array(sum)
    }

    /// The standard deviation of an equation whose times scatter, each by its own, by so much: first order.
    pub fn scatter(self, sigma: Times, equation: impl Fn(&Times) -> f64) -> f64 {
        let (times, sigma) = (self.to_array(), sigma.to_array());
        let variance: f64 = (0..7)
            .map(|index| {
                let shifted = |by: f64| {
                    let mut times = times;
                    times[index] += by * 1e-3 * sigma[index];
                    equation(&Times::from_array(times))
                };
                ((shifted(1.0) - shifted(-1.0)) / 2e-3).powi(2)
            })
            .sum();
        variance.sqrt()
    }
}

/// R_x from the times of a cycle, ohm.
pub type Equation = fn(&Parts, &Times) -> f64;

/// Eq. (3).
pub fn tpcm(parts: &Parts, times: &Times) -> f64 {
    let Times { c1, c2, x, .. } = times;
    (x[0] - c1[0]) / (c2[0] - c1[0]) * (parts.r_c2 - parts.r_c1) + parts.r_c1
}

/// Eq. (11).
pub fn tcdic(parts: &Parts, times: &Times) -> f64 {
    let [c1, c2, x] = [times.c1, times.c2, times.x].map(|[a, b]| a + b);
    (x - c1) / (c2 - c1) * (parts.r_c2 - parts.r_c1) + parts.r_c1
}

/// The upper line of eq. (19), with (16) and (18).
pub fn cerm(parts: &Parts, times: &Times) -> f64 {
    tcdic(parts, &Times { x: inferred(times), ..*times })
}

/// Eq. (16) and (18); T_xA is the time to the switch, T_c2,x that from the switch to B.
pub fn inferred(times: &Times) -> [f64; 2] {
    let rest = times.c2[1] - (times.x[1] - times.switch);
    times.c2.map(|c2| times.switch * c2 / rest)
}

/// Eq. (27) for sums of the times of A and B; `f_n`: F_c1, F_c2.
pub fn force(times: &Times, f_n: [f64; 2]) -> f64 {
    let [c1, c2, x] = [times.c1, times.c2, times.x].map(|[a, b]| a + b);
    (c2 - c1) / ((x - c1) / f_n[1] - (x - c2) / f_n[0])
}

/// The noise of a board: latency jitter (s), and noise at the threshold (V).
#[derive(Debug, Clone, Copy)]
pub struct Noise {
    pub jitter: f64,
    pub voltage: f64,
}

impl Noise {
    /// Of the crossings of A and B through resistors: eq. (4) or the jitter of stamps, and eq. (7).
    pub fn sigma(&self, parts: &Parts, r: f64) -> [f64; 2] {
        parts.s_per_volt_ohm().map(|unit| self.jitter.hypot(self.voltage * unit * (r + R_O)))
    }

    /// Of all times, where the x discharge ends through `last`.
    pub fn of_times(&self, parts: &Parts, last: f64) -> Times {
        let [c1, c2, x] = [parts.r_c1, parts.r_c2, last].map(|r| self.sigma(parts, r));
        Times { c1, c2, x, switch: 0.0 }
    }
}

/// Phi by Simpson's rule on the density: to 1e-9, for tests.
pub fn normal_below(z: f64) -> f64 {
    const STEPS: usize = 2000;
    let (from, to) = (0.0, z.clamp(-9.0, 9.0));
    let density = |x: f64| (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
    let h = (to - from) / STEPS as f64;
    let sum: f64 = (0..=STEPS)
        .map(|i| {
            let weight = if i == 0 || i == STEPS { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
            weight * density(from + h * i as f64)
        })
        .sum();
    0.5 + sum * h / 3.0
}

/// The mean of the first crossing of a line that falls by one sigma of wide-band noise in a unit of time, `samples` of it in
/// a unit: negative is early. The chance that nothing has been below the threshold yet shrinks at each instant by Phi.
pub fn first_crossing(samples: f64) -> f64 {
    const STEP: f64 = 2e-3;
    let (mut z, mut below, mut hazard) = (-9.0, 0.0, 0.0);
    let mut mean = z;
    while hazard < 40.0 {
        below += STEP * (-0.5 * (z + STEP / 2.0) * (z + STEP / 2.0)).exp() / std::f64::consts::TAU.sqrt();
        hazard += STEP * samples * below;
        mean += STEP * (-hazard).exp();
        z += STEP;
    }
    mean
}

/// By how much the crossings of A and B come early on average in noise of this voltage and bandwidth.
pub fn early(parts: &Parts, voltage: f64, bandwidth: f64, r: f64) -> [f64; 2] {
    parts.s_per_volt_ohm().map(|unit| {
        let unit = voltage * unit * (r + R_O);
        unit * first_crossing(2.0 * bandwidth * unit)
    })
}
