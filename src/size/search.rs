//! Every circuit that the parts make, ranked by what the need asks for.

use super::design::least_ohm;
use super::limits::{
    B_MARGIN, CALIBRATIONS, GREATEST_R_2, LEAST_C_B, LEAST_R_1, LONGEST_MEAN_S, POINTS, R_2_PER_DECADE,
    R_2_RATIO, RATE_MARGIN, SPREAD_OF_C,
};
use super::model::{Model, Shares};
use super::parts::{e12_capacitors, e96};
use super::{Design, Need, Pace, Platform, Stock};
use crate::circuit::{Circuit, Kind, Network, Node};
use crate::units::{Farad, Nanos, Ohm, rounded};

/// A candidate.
#[derive(Debug, Clone, PartialEq)]
pub struct Ranked {
    /// The circuit and its settings.
    pub design: Design,
    /// How many times too slow (or too inaccurate, squared) it is; without a rate that is asked for, the seconds that a good
    /// reading takes; without an error, its square, relative. The less the better.
    pub price: f64,
    /// Where that is, ohm, and what makes it.
    pub worst: (f64, Shares),
}

/// What to look for, on what, and from what.
#[derive(Debug, Clone, PartialEq)]
pub struct Search {
    /// What is asked for.
    pub need: Need,
    /// What it is to run on.
    pub platform: Platform,
    /// What there is to build from.
    pub stock: Stock,
    /// What a pin may carry, ampere.
    pub pin_a: f64,
    /// The wirings to look at.
    pub kinds: Vec<Kind>,
}

impl Search {
    /// All candidates, best first. `share`: of the time between readings that are asked for, how much of it a discharge of the
    /// sensor may take; what is left is for calibration.
    pub fn ranked(&self, share: f64) -> Vec<Ranked> {
        let mut ranked: Vec<Ranked> =
            self.designs().filter_map(|design| judged(&self.need, &self.platform, share, design)).collect();
        ranked.sort_by(|a, b| a.price.total_cmp(&b.price));
        ranked
    }

    /// The circuit that takes its calibration fastest, and the time of that in its shares: charge, discharge, calls, s.
    pub fn quickest(&self) -> Option<(Design, [f64; 3])> {
        let all = self.designs().filter(|design| is_sure_of_b(&design.circuit(&self.platform)));
        let timed = all.filter_map(|design| {
            let time = Model::new(&design, &self.platform)?.second();
            Some((design, time))
        });
        let seconds = |time: &[f64; 3]| time.iter().sum::<f64>();
        timed.min_by(|(_, a), (_, b)| seconds(a).total_cmp(&seconds(b)))
    }

    /// Whether any two resistors of the drawer can calibrate without more than pins may carry.
    pub fn can_calibrate(&self) -> bool {
        !resistors(&self.stock, self.least_ohm()).is_empty()
    }

    /// The least resistance that a pin may drive.
    pub fn least_ohm(&self) -> f64 {
        least_ohm(&self.platform, self.pin_a)
    }

    fn designs(&self) -> impl Iterator<Item = Design> {
        let least = self.least_ohm();
        let (limiting, calibration) = (self.stock.limiting(least), resistors(&self.stock, least));
        let pace = self.need.rate_hz.map_or(Pace::Each, |hertz| Pace::Hertz(rounded(RATE_MARGIN * hertz, 3)));
        self.kinds.iter().flat_map(|kind| networks(&self.stock, *kind)).flat_map(move |network| {
            let with =
                move |r_c| Design { network, r_c, r_p: limiting, r_lim: limiting, deadline: None, pace };
            calibration.clone().into_iter().map(with)
        })
    }
}

/// Pairs of calibration resistors.
fn resistors(stock: &Stock, least: f64) -> Vec<[Ohm; 2]> {
    match stock {
        Stock::Shop => {
            let r_1 = e96(least.max(LEAST_R_1));
            let steps = ((GREATEST_R_2 / (R_2_RATIO * r_1.0)).log10() * R_2_PER_DECADE) as i32;
            let up = |step| R_2_RATIO * r_1.0 * 10f64.powf(f64::from(step) / R_2_PER_DECADE);
            (0..=steps).map(|step| [r_1, e96(up(step))]).collect()
        }
        Stock::Drawer { resistors, .. } => {
            let pairs = resistors.iter().flat_map(|r_1| resistors.iter().map(|r_2| [*r_1, *r_2]));
            pairs.filter(|[r_1, r_2]| r_1.0 >= least && r_2.0 > 1.5 * r_1.0).collect()
        }
    }
}

fn networks(stock: &Stock, kind: Kind) -> Vec<Network> {
    let all = match stock {
        Stock::Shop => e12_capacitors(),
        Stock::Drawer { capacitors, .. } => capacitors.clone(),
    };
    match kind {
        Kind::TwoCapacitor => {
            let pairs = all.iter().flat_map(|c_a| all.iter().map(|c_b| (*c_a, *c_b)));
            let pairs = pairs.filter(|(c_a, c_b)| c_b.0 < c_a.0 && c_b.0 >= LEAST_C_B * c_a.0);
            pairs.map(|(c_a, c_b)| Network::TwoCapacitor { c_a, c_b }).collect()
        }
        Kind::OneCapacitor | Kind::SeriesCalibration => {
            all.into_iter().map(|c| Network::OneCapacitor { c }).collect()
        }
    }
}

/// Whether node B crosses with capacitors as bad as they are sold.
fn is_sure_of_b(circuit: &Circuit) -> bool {
    let Network::TwoCapacitor { c_a, c_b } = circuit.network else { return true };
    let network = Network::TwoCapacitor {
        c_a: Farad((1.0 - SPREAD_OF_C) * c_a.0),
        c_b: Farad((1.0 + SPREAD_OF_C) * c_b.0),
    };
    let end = Circuit { network, ..*circuit }.voltage(Node::B, Farad(f64::INFINITY));
    end.is_some_and(|end| circuit.v_th.0 - end.0 >= B_MARGIN * circuit.v_dd.0)
}

/// With the deadline and the mean that it needs; `None` if it cannot be, or not as fast as asked for.
fn judged(need: &Need, platform: &Platform, share: f64, mut design: Design) -> Option<Ranked> {
    if !is_sure_of_b(&design.circuit(platform)) {
        return None;
    }
    let mut model = Model::new(&design, platform)?;
    if let Some(hertz) = need.rate_hz {
        let longest_s = share / hertz - model.before_s();
        if longest_s < model.second()[1] {
            return None;
        }
        if longest_s < model.deadline_s {
            model.deadline_s = longest_s;
            design.deadline = Some(Nanos((longest_s * 1e6) as i64 * 1000));
        }
    }
    let calibration_s = CALIBRATIONS * model.calibration_s();
    let (mut most, mut worst, mut mean_s) = (f64::NEG_INFINITY, None, 0f64);
    for r_ohm in need.resistances(POINTS) {
        let shares = model.reading(r_ohm)?;
        let takes_s = shares.seconds() + calibration_s;
        let excess = shares.variance() / need.ohm_at(r_ohm).powi(2);
        if excess > 1.0 {
            mean_s = mean_s.max(takes_s * excess);
        }
        let enough = if need.tolerance.is_some() && need.rate_hz.is_none() { 1.0 } else { 0.0 };
        let price = takes_s * excess.max(enough) * need.rate_hz.unwrap_or(1.0);
        if price > most {
            (most, worst) = (price, Some((r_ohm, shares)));
        }
    }
    if need.rate_hz.is_none() && need.tolerance.is_some() && mean_s > 0.0 {
        design.pace = Pace::Mean(Nanos::from_seconds(rounded(mean_s, 2).min(LONGEST_MEAN_S)));
    }
    Some(Ranked { design, price: most, worst: worst? })
}
