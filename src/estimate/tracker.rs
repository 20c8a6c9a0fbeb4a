//! The calibration followed while measuring: g_A, g_B, Ro and d in a small Kalman filter.
//!
//! The state walks at random (process noise per root second) and is observed by plain and split calibration discharges
//! through the [law](crate::estimate::law). Innovations beyond the gate are rejected and counted; several in a row are a step, and
//! everything is found again from the beginning. The noise of crossings is learned from the calibration discharges themselves
//! ([`Noise`]); how fast g drifts is learned from the innovations: their normalised square is 1 on average when the walk is
//! as fast as the state.

use crate::estimate::law::{Crossing, D, R_O, Route, State};
use crate::estimate::limits::{
    BEGINNINGS, FIRST_ROUNDS, INNOVATION_GATE, LEARN_WALK, MOST_REJECTED, REJECTED_OF_A_STEP, SPLIT_FRACTION,
    WALK_D, WALK_G, WALK_R_O,
};
use crate::estimate::noise::{Covariance, Noise};
use crate::estimate::offset::{Offset, SplitCalibration};
use crate::estimate::scatter::SwitchScatter;
use crate::reading::Fault;
use crate::record::{CalibrationKind, Record, Switch, Through};
use crate::units::Nanos;
use gain::Gain;

mod gain;

/// A symmetric 4 x 4 covariance.
pub type Matrix = [[f64; 4]; 4];

/// v^T M v.
pub fn quadratic(matrix: &Matrix, v: &State) -> f64 {
    bilinear(matrix, v, v)
}

/// u^T M v.
pub fn bilinear(matrix: &Matrix, u: &State, v: &State) -> f64 {
    (0..4).map(|i| u[i] * (0..4).map(|j| matrix[i][j] * v[j]).sum::<f64>()).sum()
}

/// What has been counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Calibration discharges used.
    pub used: u64,
    /// Rejected by the gate.
    pub rejected: u64,
    /// Steps of the calibration.
    pub steps: u64,
}

/// The filter.
#[derive(Debug, Clone)]
pub struct Tracker {
    r_ohm: [f64; 2],
    nodes: usize,
    resolution_ns: f64,
    noise: Noise,
    state: State,
    covariance: Matrix,
    at: Nanos,
    walk_g: f64,
    rejected_in_row: u32,
    counts: Counts,
    scatter: SwitchScatter,
    split: SplitCalibration,
    rounds: Vec<[Record; 3]>,
    round: [Option<Record>; 3],
    ready: bool,
}

impl Tracker {
    /// Knows nothing yet. `r_ohm`: R_1 < R_2; one or two `nodes`; `resolution_ns`: period of the clock that stamps.
    pub fn new(r_ohm: [f64; 2], nodes: usize, resolution_ns: f64) -> Tracker {
        let split = SplitCalibration::new(r_ohm[0], r_ohm[1], nodes, FIRST_ROUNDS);
        Tracker::empty(r_ohm, nodes, resolution_ns, split, Vec::with_capacity(FIRST_ROUNDS))
    }

    /// The same with memory that is there already.
    fn empty(
        r_ohm: [f64; 2],
        nodes: usize,
        resolution_ns: f64,
        split: SplitCalibration,
        rounds: Vec<[Record; 3]>,
    ) -> Tracker {
        Tracker {
            r_ohm,
            nodes,
            resolution_ns,
            noise: Noise::new(resolution_ns),
            state: [0.0; 4],
            covariance: [[0.0; 4]; 4],
            at: Nanos::ZERO,
            walk_g: WALK_G[0],
            rejected_in_row: 0,
            counts: Counts::default(),
            scatter: SwitchScatter::default(),
            split,
            rounds,
            round: [None; 3],
            ready: false,
        }
    }

    /// How many nodes there are.
    pub fn nodes(&self) -> usize {
        self.nodes
    }

    /// Whether there is a state.
    pub fn is_ready(&self) -> bool {
        self.ready
    }

    /// g_A, g_B, Ro, d.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// How well it is known.
    pub fn covariance(&self) -> &Matrix {
        &self.covariance
    }

    /// The noise of crossings.
    pub fn noise(&self) -> &Noise {
        &self.noise
    }

    /// Calibration discharges used and rejected.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Whether the last calibration discharge was rejected.
    pub fn is_doubted(&self) -> bool {
        self.rejected_in_row > 0
    }

    /// Uncertainty of a switch's instant, ns: what has been learned of it, at most what the calls' duration says.
    pub fn u_switch_ns(&self, bracket_ns: f64) -> f64 {
        self.scatter.bound_ns().map_or(bracket_ns, |bound| bound.min(bracket_ns))
    }

    /// Takes a calibration discharge.
    ///
    /// # Errors
    /// [`Fault::NoCalibration`] if a crossing is missing, [`Fault::LatencyOutlier`] if it is rejected,
    /// [`Fault::CalibrationStep`] if it is the one after which the filter opens again.
    pub fn add(&mut self, record: &Record) -> Result<(), Fault> {
        let kind = record.calibration_kind().ok_or(Fault::NoCalibration)?;
        let times = record.complete(self.nodes).ok_or(Fault::NoCalibration)?;
        if self.ready {
            return self.update(kind, record, times);
        }
        self.noise.add(kind, times, [0.0; 2])?;
        self.round[kind as usize] = Some(*record);
        if let [Some(first), Some(second), Some(split)] = self.round {
            self.round = [None; 3];
            self.rounds.push([first, second, split]);
        }
        if self.rounds.len() >= FIRST_ROUNDS && self.noise.is_known() {
            self.begin();
        }
        Ok(())
    }

    /// The first state by closed form from the mean of the first rounds; its covariance by letting the filter see them
    /// all, starting from almost no knowledge.
    fn begin(&mut self) {
        let [r1, r2] = self.r_ohm;
        let rounds = std::mem::take(&mut self.rounds);
        let mut slope = [0.0; 2];
        for [first, second, split] in &rounds {
            let (Some(c1), Some(c2)) = (first.complete(self.nodes), second.complete(self.nodes)) else {
                continue;
            };
            self.split.add(c1, c2, split, &self.noise);
            for node in 0..2 {
                slope[node] += (c2[node] - c1[node]) / (r2 - r1) / rounds.len() as f64;
            }
        }
        let offset = self.split.result();
        if let Some((offset, (r_o_ohm, _))) = offset.and_then(|offset| Some((offset, offset.r_o_ohm?))) {
            let state = [slope[0], slope[1], r_o_ohm, offset.d_ns];
            // While little is known no gate keeps a spike out, and what fits it is rejected afterwards: then the
            // rounds are seen again without the first one. If that never helps, there are new rounds.
            self.ready = (0..BEGINNINGS).any(|skipped| self.fits(state, &rounds[skipped..]));
            if self.ready {
                self.noise.expect_what_comes();
            }
        }
        self.rounds = rounds;
        self.rounds.clear();
    }

    /// Lets the filter see rounds, starting from almost no knowledge; whether they fit.
    fn fits(&mut self, state: State, rounds: &[[Record; 3]]) -> bool {
        self.state = state;
        self.open();
        self.at = rounds[0][0].start;
        let mut rejected = 0;
        for record in rounds.iter().flatten() {
            self.advance(record.start);
            // One that the gate rejects is one less.
            let used = record.complete(self.nodes).and_then(|times| self.correct(record, times));
            rejected += usize::from(used.is_none());
        }
        rejected * MOST_REJECTED <= 3 * rounds.len()
    }

    /// As little knowledge as physics leaves: g to 5 %, Ro to 50 ohm, d to 50 us.
    fn open(&mut self) {
        self.covariance = [[0.0; 4]; 4];
        let sigma = [0.05 * self.state[0], 0.05 * self.state[1], 50.0, 50_000.0];
        for (index, sigma) in sigma.into_iter().enumerate() {
            self.covariance[index][index] = sigma * sigma;
        }
    }

    fn update(&mut self, kind: CalibrationKind, record: &Record, times: [f64; 2]) -> Result<(), Fault> {
        self.advance(record.start);
        let route = self.route(record).ok_or(Fault::NoCalibration)?;
        let expected = [0, 1].map(|node| route.crossing(&self.state, node).ns);
        if let Some(normalised) = self.correct(record, times) {
            // What the filter takes is no spike, whatever the spread says.
            let _ = self.noise.add(kind, times, expected);
            let faster =
                (LEARN_WALK * (normalised / self.nodes as f64 - 1.0)).clamp(-LEARN_WALK, 4.0 * LEARN_WALK);
            self.walk_g = (self.walk_g * faster.exp()).clamp(WALK_G[0], WALK_G[1]);
            self.rejected_in_row = 0;
            self.counts.used += 1;
            return Ok(());
        }
        self.counts.rejected += 1;
        self.rejected_in_row += 1;
        if self.rejected_in_row < REJECTED_OF_A_STEP {
            return Err(Fault::LatencyOutlier);
        }
        self.begin_anew();
        Err(Fault::CalibrationStep)
    }

    /// After a step. Nothing of the old state may bias the new one: how far the step went is not known.
    pub fn begin_anew(&mut self) {
        let counts = Counts { steps: self.counts.steps + 1, ..self.counts };
        let (mut split, mut rounds) = (std::mem::take(&mut self.split), std::mem::take(&mut self.rounds));
        split.clear();
        rounds.clear();
        *self =
            Tracker { counts, ..Tracker::empty(self.r_ohm, self.nodes, self.resolution_ns, split, rounds) };
    }

    /// The walk since the last discharge.
    pub fn advance(&mut self, now: Nanos) {
        let seconds = (now - self.at).as_seconds().clamp(0.0, 3600.0);
        self.at = now;
        // A crossing without delay has no other noise than latency.
        let jitter_ns = self.noise.covariance([0.0; 2]).map_or(0.0, |noise| noise.aa.sqrt());
        let walk = [self.walk_g * self.state[0], self.walk_g * self.state[1], WALK_R_O, WALK_D * jitter_ns];
        for (index, walk) in walk.into_iter().enumerate() {
            self.covariance[index][index] += walk * walk * seconds;
        }
    }

    /// The resistors of a calibration discharge.
    fn route(&self, record: &Record) -> Option<Route> {
        let kind = record.calibration_kind()?;
        Some(Route {
            first_ohm: self.first_ohm(kind),
            switch: record.switch.map(|switch| (switch, self.r_ohm[1])),
        })
    }

    fn first_ohm(&self, kind: CalibrationKind) -> f64 {
        self.r_ohm[usize::from(kind == CalibrationKind::Second)]
    }

    /// Which nodes there are.
    fn seen(&self) -> [bool; 2] {
        [true, self.nodes == 2]
    }

    /// The covariance of what is observed of a discharge, its noise and its switch.
    pub fn observation(&self, route: &Route, u_switch_ns: f64) -> Option<Covariance> {
        let mut noise = self.noise.covariance(route.late_ns(&self.state))?;
        let u_switch = self.u_switch_ns(u_switch_ns);
        let by = [0, 1].map(|node| route.crossing(&self.state, node).by_switch * u_switch);
        noise.add_outer(by);
        Some(noise)
    }

    /// Kalman's correction by both crossings; the innovation's normalised square, or `None` if it is beyond the gate.
    fn correct(&mut self, record: &Record, times: [f64; 2]) -> Option<f64> {
        let route = self.route(record)?;
        let rows = [0, 1].map(|node| route.crossing(&self.state, node));
        let innovation = [0, 1].map(|node| if node < self.nodes { times[node] - rows[node].ns } else { 0.0 });
        let states = rows.map(|row| row.by_state);
        let gain = Gain::new(
            &self.covariance,
            &states,
            &self.observation(&route, record.u_switch_ns.or(self.scatter.bound_ns()).unwrap_or(0.0))?,
            self.seen(),
        )?;
        let normalised = gain.normalised(innovation);
        if normalised > INNOVATION_GATE * INNOVATION_GATE * self.nodes as f64 {
            return None;
        }
        if rows[0].by_switch != 0.0 {
            // As it would scatter if the switch did not.
            let steady = quadratic(&self.covariance, &states[0]) + self.observation(&route, 0.0)?.aa;
            self.scatter.add(innovation[0], steady, rows[0].by_switch);
        }
        for index in 0..4 {
            self.state[index] += gain.of[index][0] * innovation[0] + gain.of[index][1] * innovation[1];
        }
        self.covariance = gain.posterior(&self.covariance);
        Some(normalised)
    }

    /// By how much a calibration discharge of this kind would lower v^T P v.
    pub fn benefit(&self, kind: CalibrationKind, v: &State) -> Option<f64> {
        let route = self.planned(kind);
        let rows = [0, 1].map(|node| route.crossing(&self.state, node).by_state);
        let gain = Gain::new(&self.covariance, &rows, &self.observation(&route, 0.0)?, self.seen())?;
        Some(quadratic(&self.covariance, v) - quadratic(&gain.posterior(&self.covariance), v))
    }

    /// What a calibration discharge of this kind runs through.
    pub fn planned(&self, kind: CalibrationKind) -> Route {
        let at_ns = SPLIT_FRACTION * self.state[0] * (self.r_ohm[0] + self.state[R_O]);
        let switch = Switch { at_ns, on_ns: at_ns, to: Through::C2 };
        let switch = (kind == CalibrationKind::Split).then_some((switch, self.r_ohm[1]));
        Route { first_ohm: self.first_ohm(kind), switch }
    }

    /// The crossings of the calibration discharges as they would be now, and their derivatives by the state.
    pub fn calibration(&self) -> [[Crossing; 2]; 2] {
        self.r_ohm.map(|first_ohm| {
            let route = Route { first_ohm, switch: None };
            [0, 1].map(|node| route.crossing(&self.state, node))
        })
    }

    /// d and Ro, and what has been learned of switches.
    pub fn offset(&self) -> Offset {
        let known = |index: usize| (self.state[index], self.covariance[index][index].sqrt());
        let (d_ns, u_d_ns) = known(D);
        let (r_o_ohm, switch_ns) = (Some(known(R_O)), self.scatter.bound_ns());
        Offset { d_ns, u_d_ns, r_o_ohm, switch_ns, ..Offset::default() }
    }
}

#[cfg(test)]
mod tests;
