//! Cycles of discharges that begin where charges of finite length leave the capacitors, by steps of the network's own
//! equations: what the predictions of published methods stand on.

use crate::paper::{self, Equation, Noise, Parts, R_O, Times, V_DD};
use crate::scenario::Board;
use crate::switching::PI4_NOISE;
use cermd::circuit::Node;
use cermd::instrument::discharge::Charge;
use cermd::reading::Method;

/// Rp + Ro of `pi4`.
const R_CHARGE: f64 = 220.0;
/// From a crossing to the release of the sink: the edge's way to the program, and a call.
const RELEASE: f64 = 62e-6;
/// Cycles after which nothing is remembered of the first.
const CYCLES: usize = 12;
const CHARGES: usize = 3 * CYCLES;
/// Of a part of a charge.
const STEPS: u32 = 500;

/// V_A and V_B.
type Volts = [f64; 2];

/// When A and B cross, and how that scatters, s.
struct Crossings {
    at: [f64; 2],
    sigma: [f64; 2],
}

/// A method that takes a calibration of its own in each cycle.
pub struct Charged {
    parts: Parts,
    charge: Charge,
    last: Node,
    r_ohm: f64,
    equation: Equation,
}

impl Charged {
    /// `None` where a reading takes more than c1, c2 and x in full.
    pub fn new(board: &Board, method: Method, r_ohm: f64) -> Option<Charged> {
        let equation: Equation = match method {
            Method::Tpcm => paper::tpcm,
            Method::Tcdic => paper::tcdic,
            _ => return None,
        };
        let (_, settings) = board.bench(method, r_ohm, 0).parts();
        let last = settings.last();
        let charge = if last == Node::A { settings.charge.to_a } else { settings.charge.to_b };
        Some(Charged { parts: board.parts, charge, last, r_ohm, equation })
    }

    /// The error by the noise of `pi4`, and by a supply that is another one whenever charging lines switch, V rms.
    pub fn error(&self, supply: f64) -> f64 {
        let (times, sigma) = self.cycle(PI4_NOISE, |_| V_DD);
        let found = (self.equation)(&self.parts, &times);
        let by_part = |part: usize| {
            let off = |n| if n == part { V_DD + supply } else { V_DD };
            (self.equation)(&self.parts, &self.cycle(PI4_NOISE, off).0) - found
        };
        let of_supply: f64 =
            if supply > 0.0 { (0..2 * CHARGES).map(|part| by_part(part).powi(2)).sum() } else { 0.0 };
        times.scatter(sigma, |times| (self.equation)(&self.parts, times)).hypot(of_supply.sqrt())
    }

    /// The last of many cycles, and how its times scatter; the supply in each part of their charges, V: through A alone,
    /// and through both.
    fn cycle(&self, noise: Noise, supply: impl Fn(usize) -> f64) -> (Times, Times) {
        let parts = &self.parts;
        let mut volts = [V_DD; 2];
        let crossings: [Crossings; CHARGES] = std::array::from_fn(|n| {
            let r = [parts.r_c1, parts.r_c2, self.r_ohm][n % 3] + R_O;
            self.charge(&mut volts, [supply(2 * n), supply(2 * n + 1)]);
            self.discharge(&mut volts, r, noise)
        });
        let last = |of: fn(&Crossings) -> [f64; 2]| {
            let [c1, c2, x] = [3, 2, 1].map(|back| of(&crossings[CHARGES - back]));
            Times { c1, c2, x, switch: 0.0 }
        };
        (last(|crossings| crossings.at), last(|crossings| crossings.sigma))
    }

    fn charge(&self, volts: &mut Volts, supply: [f64; 2]) {
        let Parts { c_a, c_b, .. } = self.parts;
        let parts = [(self.charge.alone, 0.0), (self.charge.together, 1.0)];
        for ((time, b_too), supply) in parts.into_iter().zip(supply) {
            let dt = time.as_seconds() / f64::from(STEPS);
            let rate = |[a, b]: Volts| {
                let [i_a, i_b] = [supply - a, b_too * (supply - b)].map(|volts| volts / R_CHARGE);
                [i_a / c_a + (i_a + i_b) / c_b, (i_a + i_b) / c_b]
            };
            for _ in 0..STEPS {
                let ahead = |rate: Volts, by: f64| [volts[0] + by * rate[0], volts[1] + by * rate[1]];
                let (k1, half) = (rate(*volts), 0.5 * dt);
                let k2 = rate(ahead(k1, half));
                let k3 = rate(ahead(k2, half));
                let k4 = rate(ahead(k3, dt));
                *volts =
                    std::array::from_fn(|i| volts[i] + dt / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
            }
        }
    }

    /// Through `r`, Ro included: the crossings of A and B, and how they scatter. Leaves what is there when the sink lets go.
    fn discharge(&self, volts: &mut Volts, r: f64, noise: Noise) -> Crossings {
        let Parts { c_a, c_b, v_th, .. } = self.parts;
        let (tau, k) = (r * c_a * c_b / (c_a + c_b), c_a / (c_a + c_b));
        let [a, b] = *volts;
        // What A has when B crosses.
        let a_at = [v_th, a - (b - v_th) / k];
        let slope = [v_th / tau, k * a_at[1] / tau];
        let times = a_at.map(|left| tau * (a / left).ln());
        let left = a * (-(times[self.last.index()] + RELEASE) / tau).exp();
        *volts = [left, b - k * (a - left)];
        Crossings { at: times, sigma: slope.map(|slope| noise.jitter.hypot(noise.voltage / slope)) }
    }
}
