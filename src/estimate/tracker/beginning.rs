//! How the first rounds of calibration become a state, and what is left of one after a step.

use super::speeds::Speeds;
use super::{Matrix, Tracker};
use crate::estimate::law::State;
use crate::estimate::limits::{BEGINNINGS, MOST_REJECTED, RATE_AT_FIRST, ROUGH_ROUNDS, UNKNOWN_STATE};
use crate::record::Record;

impl Tracker {
    /// Charges may be other ones once Ro is known roughly, so that the state begins with what comes after that.
    pub(super) fn look_roughly(&mut self) {
        if self.rough_r_o_ohm.is_some() || self.rounds.len() < ROUGH_ROUNDS {
            return;
        }
        self.take_rounds_apart();
        self.rough_r_o_ohm = self.split.result().and_then(|offset| Some(offset.r_o_ohm?.0));
        self.split.clear();
        if self.rough_r_o_ohm.is_some() {
            self.rounds.clear();
        }
    }

    /// The first state by closed form from the mean of the first rounds; its covariance by letting the filter see them
    /// all, starting from almost no knowledge.
    pub(super) fn begin(&mut self) {
        let slope = self.take_rounds_apart();
        let rounds = std::mem::take(&mut self.rounds);
        let offset = self.split.result();
        if let Some((offset, (r_o_ohm, _))) = offset.and_then(|offset| Some((offset, offset.r_o_ohm?))) {
            let state = [slope[0], slope[1], r_o_ohm, offset.d_ns, 0.0, 0.0, 0.0];
            // While little is known no gate keeps a spike out, and what fits it is rejected afterwards: then the
            // rounds are seen again without the first one. If that never helps, there are new rounds.
            self.scatter = offset.scatter;
            self.ready = (0..BEGINNINGS).any(|skipped| self.fits(state, &rounds[skipped..]));
            if self.ready {
                self.noise.expect_what_comes();
            }
        }
        self.rounds = rounds;
        self.rounds.clear();
    }

    /// Gives the rounds to the split calibration; answers the mean of g of both nodes by their plain discharges.
    fn take_rounds_apart(&mut self) -> [f64; 2] {
        let [r1, r2] = self.r_ohm;
        let (mut slope, mut count) = ([0.0; 2], 0.0);
        for [first, second, split] in &self.rounds {
            let (Some(c1), Some(c2)) = (first.complete(self.nodes), second.complete(self.nodes)) else {
                continue;
            };
            self.split.add(c1, c2, split, &self.noise);
            count += 1.0;
            for (slope, (c1, c2)) in slope.iter_mut().zip(c1.into_iter().zip(c2)) {
                let takes_ns = c1.zip(c2).map_or(0.0, |(c1, c2)| c2 - c1);
                *slope += takes_ns / (r2 - r1);
            }
        }
        slope.map(|slope| slope / f64::max(count, 1.0))
    }

    /// Lets the filter see rounds, starting from almost no knowledge; whether they fit.
    fn fits(&mut self, state: State, rounds: &[[Record; 3]]) -> bool {
        self.state = state;
        self.speeds = Speeds::of_all();
        self.open();
        self.at = rounds[0][0].start;
        let mut rejected = 0;
        for record in rounds.iter().flatten() {
            self.advance(record.start);
            // One that the gate rejects is one less.
            let used = record.ended(self.nodes).zip(record.calibration_kind());
            let used = used.is_some_and(|(times, kind)| self.correct(kind, record, times).is_ok());
            rejected += usize::from(!used);
        }
        rejected * MOST_REJECTED <= 3 * rounds.len()
    }

    /// As little knowledge as physics leaves.
    fn open(&mut self) {
        self.covariance = Matrix::default();
        let [g, r_o, d] = UNKNOWN_STATE;
        let [d_b, rate_b] = if self.nodes == 2 { [d, RATE_AT_FIRST] } else { [0.0; 2] };
        let sigma = [g * self.state[0], g * self.state[1], r_o, d, d_b, RATE_AT_FIRST, rate_b];
        for (index, sigma) in sigma.into_iter().enumerate() {
            self.covariance[index][index] = sigma * sigma;
        }
    }

    /// After a step. Nothing of the old state may bias the new one: how far the step went is not known.
    pub fn begin_anew(&mut self) {
        let (steps, awake) = (self.steps + 1, self.awake);
        let (mut split, mut rounds) = (std::mem::take(&mut self.split), std::mem::take(&mut self.rounds));
        split.clear();
        rounds.clear();
        let empty = Tracker::empty(self.r_ohm, self.nodes, self.resolution_ns, split, rounds);
        *self = Tracker { steps, awake, ..empty };
    }
}
