//! The latency offset d and the pins' resistance Ro, by split calibration.
//!
//! For: finding d from discharges of the two calibration resistors alone. Must not know: the sensor, the method.
//!
//! One round is three discharges: R_1 in full, R_2 in full, and a split one that runs through R_1 for the time s and
//! then through R_2 for the time c until the last node crosses. The progress g is the same in all of them, and d
//! cancels in D = T_c2 - c (both are crossings), so
//!
//! ```text
//! s/(R_1+Ro) = D/(R_2+Ro)          =>  Ro = (s R_2 - D R_1)/(D - s)
//! g_n = (T_c2n - T_c1n)/(R_2-R_1)      for each node n
//! d   = T_c1n - g_n (R_1+Ro)           the mean over the nodes
//! ```
//!
//! The rounds are averaged; their scatter gives the uncertainties (GUM type A). Rounds that a latency spike has spoilt
//! are left out.

use crate::noise::Noise;
use crate::record::Record;

/// What the split calibration found; each uncertainty is 1 sigma.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Offset {
    /// How much later than the truth a crossing is stamped, ns.
    pub d_ns: f64,
    /// Its uncertainty, ns; 0 for a given offset.
    pub u_d_ns: f64,
    /// Output resistance of a calibration pin, ohm; `None` for a given offset.
    pub r_o_ohm: Option<(f64, f64)>,
    /// Scatter of the instant of a switch, ns; `None` if it was not measured.
    pub switch_ns: Option<f64>,
}

impl Offset {
    /// An offset that is known from elsewhere.
    pub fn given(d_ns: f64) -> Offset {
        Offset { d_ns, ..Offset::default() }
    }
}

#[derive(Debug, Clone, Copy)]
struct Round {
    d_ns: f64,
    r_o_ohm: f64,
    s_ns: f64,
    big_d_ns: f64,
}

/// Collects rounds of a split calibration.
#[derive(Debug, Clone)]
pub struct SplitCalibration {
    r1_ohm: f64,
    r2_ohm: f64,
    nodes: usize,
    wanted: usize,
    rounds: Vec<Round>,
}

impl SplitCalibration {
    /// Rounds by which the offset's uncertainty is small beside that of one reading: 1/8 of a round's.
    pub const ROUNDS: usize = 64;
    /// The split comes after this part of node A's time through R_1: late, since the resistors' difference acts only
    /// after it on D, early enough to come before the last node crosses.
    pub const FRACTION: f64 = 0.9;

    /// For calibration resistors `r1_ohm` < `r2_ohm` and a circuit with one or two nodes.
    pub fn new(r1_ohm: f64, r2_ohm: f64, nodes: usize, wanted: usize) -> SplitCalibration {
        SplitCalibration { r1_ohm, r2_ohm, nodes, wanted, rounds: Vec::with_capacity(wanted) }
    }

    /// Takes one round: crossings of the plain discharges and the record of the split one. A round whose split
    /// discharge was not switched in time, or that does not fit the law, tells nothing and is passed over.
    pub fn add(&mut self, c1: [f64; 2], c2: [f64; 2], split: &Record) {
        if let Some(round) = self.round(c1, c2, split) {
            if self.rounds.len() < self.wanted {
                self.rounds.push(round);
            }
        }
    }

    fn round(&self, c1: [f64; 2], c2: [f64; 2], split: &Record) -> Option<Round> {
        let last = self.nodes - 1;
        let switch = split.switch?;
        let crossing = if last == 0 { split.a_ns? } else { split.b_ns? };
        let (s, c) = (switch.at_ns, crossing - switch.on_ns);
        let big_d = c2[last] - c;
        if c <= 0.0 || s <= 0.0 || big_d <= s {
            return None;
        }
        let (r1, r2) = (self.r1_ohm, self.r2_ohm);
        let r_o_ohm = (s * r2 - big_d * r1) / (big_d - s);
        let mut d_ns = 0.0;
        for node in 0..self.nodes {
            let g = (c2[node] - c1[node]) / (r2 - r1);
            d_ns += (c1[node] - g * (r1 + r_o_ohm)) / self.nodes as f64;
        }
        (d_ns.is_finite() && r_o_ohm.is_finite()).then_some(Round { d_ns, r_o_ohm, s_ns: s, big_d_ns: big_d })
    }

    /// Whether all rounds have been taken.
    pub fn is_complete(&self) -> bool {
        self.rounds.len() >= self.wanted
    }

    /// The result so far; `None` for fewer than four rounds.
    ///
    /// The scatter of switch instants is what remains of the scatter of D, given s, when the noise of its two crossings
    /// (both through R_2, at `c2` ns) is taken away.
    pub fn result(&self, noise: &Noise, c2: [f64; 2]) -> Option<Offset> {
        if self.rounds.len() < 4 {
            return None;
        }
        let all: Vec<f64> = self.rounds.iter().map(|round| round.d_ns).collect();
        let (middle, limit) = median_and_limit(&all);
        let kept: Vec<&Round> =
            self.rounds.iter().filter(|round| (round.d_ns - middle).abs() <= limit).collect();
        let (d_ns, u_d_ns) = mean_and_uncertainty(kept.iter().map(|round| round.d_ns))?;
        let r_o = mean_and_uncertainty(kept.iter().map(|round| round.r_o_ohm))?;
        let slope = (self.r2_ohm + r_o.0) / (self.r1_ohm + r_o.0);
        let misfits = kept.iter().map(|round| round.big_d_ns - slope * round.s_ns);
        let (_, u_misfit) = mean_and_uncertainty(misfits)?;
        let switch_ns = noise.covariance(c2).map(|covariance| {
            let crossing = if self.nodes == 1 { covariance.aa } else { covariance.bb };
            let scatter = u_misfit * u_misfit * kept.len() as f64;
            ((scatter - 2.0 * crossing).max(0.0)).sqrt() / slope
        });
        Some(Offset { d_ns, u_d_ns, r_o_ohm: Some(r_o), switch_ns })
    }
}

/// The median, and five sigma as told by the median absolute deviation.
fn median_and_limit(values: &[f64]) -> (f64, f64) {
    let median = |values: &mut Vec<f64>| {
        values.sort_by(f64::total_cmp);
        (values[(values.len() - 1) / 2] + values[values.len() / 2]) / 2.0
    };
    let middle = median(&mut values.to_vec());
    let mut away: Vec<f64> = values.iter().map(|value| (value - middle).abs()).collect();
    (middle, 5.0 * median(&mut away) / 0.6745)
}

fn mean_and_uncertainty(values: impl Iterator<Item = f64> + Clone) -> Option<(f64, f64)> {
    let count = values.clone().count() as f64;
    if count < 2.0 {
        return None;
    }
    let mean = values.clone().sum::<f64>() / count;
    let square = values.map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
    Some((mean, (square / count).sqrt()))
}
