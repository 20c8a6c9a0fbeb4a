//! The calibration followed while measuring: g, d of both nodes and Ro in a small Kalman filter.
//!
//! The state walks at random (process noise per root second) and is observed by plain and split calibration discharges
//! through the [law](crate::estimate::law). Innovations beyond the gate are rejected and counted; several in a row are a step, and
//! everything is found again from the beginning. The noise of crossings is learned from the calibration discharges themselves
//! ([`Noise`]), and so is how fast g, Ro and d walk.

use crate::circuit::Node;
use crate::estimate::awake::AwakeTest;
use crate::estimate::law::{Crossing, D, D_B, R_O, Route, State, UNKNOWNS, d_ns};
use crate::estimate::limits::{FIRST_ROUNDS, INNOVATION_GATE, LATE_NS, SPLIT_FRACTION};
use crate::estimate::noise::{Covariance, Noise, is_step};
use crate::estimate::offset::{Offset, SplitCalibration};
use crate::estimate::scatter::{SwitchScatter, expected_ns};
use crate::reading::Fault;
use crate::record::{CalibrationKind, Record, Switch, Through, UNLIKE_CALLS};
use crate::units::Nanos;
use elsewhere::Elsewhere;
use gain::Gain;
use speeds::Speeds;

mod awake;
mod beginning;
mod elsewhere;
mod evidence;
mod gain;
mod speeds;
mod walk;

/// A symmetric covariance of the state.
pub type Matrix = [State; UNKNOWNS];

/// v^T M v.
fn quadratic(matrix: &Matrix, v: &State) -> f64 {
    bilinear(matrix, v, v)
}

/// u^T M v.
fn bilinear(matrix: &Matrix, u: &State, v: &State) -> f64 {
    (0..UNKNOWNS).map(|i| u[i] * (0..UNKNOWNS).map(|j| matrix[i][j] * v[j]).sum::<f64>()).sum()
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
    /// How fast d, g and Ro walk: each by one kind of discharge.
    speeds: [Speeds; 3],
    /// What each crossing of each kind of discharge is beside its expectation on average, in sigma.
    means: [[f64; 2]; 3],
    rejected_in_row: u32,
    /// The share of late stamps before them, which may be a step.
    late_before: f64,
    /// Steps of the calibration so far.
    steps: u64,
    scatter: SwitchScatter,
    elsewhere: Elsewhere,
    awake: AwakeTest,
    split: SplitCalibration,
    rounds: Vec<[Record; 3]>,
    round: [Option<Record>; 3],
    /// Ro by the rounds before these, ohm.
    rough_r_o_ohm: Option<f64>,
    ready: bool,
    /// Gain and rows of the last calibration discharge; 0 if it has corrected nothing.
    last: ([[f64; 2]; UNKNOWNS], [State; 2]),
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
            noise: Noise::new(nodes, resolution_ns),
            state: State::default(),
            covariance: Matrix::default(),
            at: Nanos::ZERO,
            speeds: Speeds::of_all(),
            means: [[0.0; 2]; 3],
            rejected_in_row: 0,
            late_before: 0.0,
            steps: 0,
            scatter: SwitchScatter::default(),
            elsewhere: Elsewhere::default(),
            awake: AwakeTest::default(),
            split,
            rounds,
            round: [None; 3],
            rough_r_o_ohm: None,
            ready: false,
            last: Default::default(),
        }
    }

    /// The clock that stamps crossings has another period.
    pub fn set_resolution(&mut self, resolution_ns: f64) {
        self.resolution_ns = resolution_ns;
        self.noise.set_resolution(resolution_ns);
    }

    /// How many nodes there are.
    pub fn nodes(&self) -> usize {
        self.nodes
    }

    /// Ro as far as it is known before there is a state, ohm.
    pub fn rough_r_o_ohm(&self) -> Option<f64> {
        self.rough_r_o_ohm
    }

    /// Whether there is a state.
    pub fn is_ready(&self) -> bool {
        self.ready
    }

    /// The state: g_A, g_B, Ro, d of A, what B's is greater by, and how fast both g change.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The noise of crossings.
    pub fn noise(&self) -> &Noise {
        &self.noise
    }

    /// How many steps of the calibration there have been.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Whether the last calibration discharge was rejected.
    pub fn is_doubted(&self) -> bool {
        self.rejected_in_row > 0
    }

    /// Uncertainty of a switch's instant, ns, where `expected_ns` is what the calls' duration says.
    pub fn u_switch_ns(&self, expected_ns: f64) -> f64 {
        self.scatter.u_ns(expected_ns)
    }

    /// Takes by how much a reading was beside those before and after it, as [`SwitchScatter::add_reading`].
    pub fn add_reading(&mut self, beside_ns: f64, steady: f64) {
        self.scatter.add_reading(beside_ns, steady);
    }

    /// Takes a calibration discharge.
    ///
    /// # Errors
    /// [`Fault::NoCalibration`] if a crossing is missing, [`Fault::LatencyOutlier`] if it is rejected,
    /// [`Fault::CalibrationStep`] if it is the one after which the filter opens again.
    pub fn add(&mut self, record: &Record) -> Result<(), Fault> {
        let kind = record.calibration_kind().ok_or(Fault::NoCalibration)?;
        let times = record.ended(self.nodes).ok_or(Fault::NoCalibration)?;
        if self.ready {
            return self.update(kind, record, times);
        }
        self.noise.add(kind, times, [0.0; 2])?;
        self.round[kind as usize] = Some(*record);
        if let [Some(first), Some(second), Some(split)] = self.round {
            self.round = [None; 3];
            self.rounds.push([first, second, split]);
            self.look_roughly();
        }
        if self.rounds.len() >= FIRST_ROUNDS && self.noise.is_known() {
            self.begin();
        }
        Ok(())
    }

    fn update(
        &mut self,
        kind: CalibrationKind,
        record: &Record,
        times: [Option<f64>; 2],
    ) -> Result<(), Fault> {
        self.advance(record.start);
        self.last = Default::default();
        let unlike_others = self.takes_awake(kind, record).or_else(|| self.takes_elsewhere(kind, record));
        if unlike_others == Some(false) {
            return Ok(());
        }
        if self.rejected_in_row == 0 {
            self.late_before = self.noise.late_share();
        }
        match self.correct(kind, record, times) {
            Ok(expected) => {
                // What the filter takes is no spike, whatever the spread says.
                if record.later_ns.is_none() {
                    let _ = self.noise.add(kind, times, expected);
                }
                self.rejected_in_row = 0;
                return Ok(());
            }
            Err(beside_ns) => {
                // What the state leaves out may make it early, which no stamp is. The next one is as usual, and tells.
                let beside = |ns: &f64| if unlike_others.is_some() { *ns } else { ns.abs() };
                self.noise.tell_far(kind, beside_ns.iter().map(beside).any(|ns| ns > LATE_NS));
            }
        }
        self.rejected_in_row += 1;
        if !is_step(self.rejected_in_row, self.late_before) {
            return Err(Fault::LatencyOutlier);
        }
        self.begin_anew();
        Err(Fault::CalibrationStep)
    }

    /// The variance of v times the state.
    pub fn variance(&self, v: &State) -> f64 {
        self.misfit() * quadratic(&self.covariance, v)
    }

    /// The covariance of v times the state with the state, but for [`Tracker::misfit`].
    pub fn with_state(&self, v: &State) -> State {
        self.covariance.map(|row| row.iter().zip(v).map(|(p, v)| p * v).sum())
    }

    /// What a covariance with the state has become by the last calibration discharge: c - K H c.
    pub fn after_correction(&self, c: &State) -> State {
        let (gain, rows) = &self.last;
        let seen = rows.map(|row| row.iter().zip(c).map(|(h, c)| h * c).sum::<f64>());
        std::array::from_fn(|i| c[i] - gain[i][0] * seen[0] - gain[i][1] * seen[1])
    }

    /// The covariance of u and of v times the state.
    pub fn covariance_of(&self, u: &State, v: &State) -> f64 {
        self.misfit() * bilinear(&self.covariance, u, v)
    }

    /// The resistors of a calibration discharge.
    fn route(&self, kind: CalibrationKind, record: &Record) -> Route {
        let is_split = kind == CalibrationKind::Split;
        let switch = record.switch.filter(|_| is_split).map(|switch| (switch, self.r_ohm[1]));
        Route { first_ohm: self.first_ohm(kind), switch }
    }

    /// How long node A takes through R_1 and R_2, ns.
    fn takes_ns(&self) -> [f64; 2] {
        self.r_ohm.map(|r_ohm| self.state[0] * (r_ohm + self.state[R_O]))
    }

    /// When both nodes cross, by the state.
    fn crossings(&self, route: &Route) -> [Crossing; 2] {
        [0, 1].map(|node| route.crossing(&self.state, node))
    }

    fn first_ohm(&self, kind: CalibrationKind) -> f64 {
        self.r_ohm[usize::from(kind == CalibrationKind::Second)]
    }

    /// The noise of the crossings of a discharge, and with it that of its switch; `expected_ns`: as in
    /// [`Tracker::u_switch_ns`], `later_ns`: as in [`Record::later_ns`].
    fn noise_of(
        &self,
        route: &Route,
        rows: &[Crossing; 2],
        expected_ns: f64,
        later_ns: f64,
    ) -> Option<(Covariance, Covariance)> {
        let mut crossings = self.noise.covariance(route.late_ns(&self.state))?;
        // A late start comes later to the crossings, a late switch to what follows.
        crossings.add_each(rows.map(|row| row.by_switch.abs().max(1.0) * later_ns));
        let u_switch_ns = self.u_switch_ns(expected_ns);
        let mut all = crossings;
        all.add_outer(rows.map(|row| row.by_switch * u_switch_ns));
        Some((crossings, all))
    }

    /// Where the crossings of a calibration discharge are expected, and their noise as [`Tracker::noise_of`] has it.
    fn expected(
        &self,
        kind: CalibrationKind,
        record: &Record,
    ) -> ([Crossing; 2], Option<(Covariance, Covariance)>) {
        let route = self.route(kind, record);
        let rows = self.crossings(&route);
        let noise = self.noise_of(&route, &rows, expected_ns(record), record.later_ns.unwrap_or(0.0));
        (rows, noise)
    }

    /// Kalman's correction by the crossings that were seen; where they were expected, ns.
    ///
    /// # Errors
    /// By how much they are beside that, ns, if they are beyond the gate and have not been used.
    fn correct(
        &mut self,
        kind: CalibrationKind,
        record: &Record,
        times: [Option<f64>; 2],
    ) -> Result<[f64; 2], [f64; 2]> {
        let (rows, noise) = self.expected(kind, record);
        let seen = times.map(|time| time.is_some());
        let innovation = [0, 1].map(|node: usize| times[node].map_or(0.0, |ns| ns - rows[node].ns));
        let (states, by_switch) = (rows.map(|row| row.by_state), rows.map(|row| row.by_switch));
        let (crossings, noise) = noise.ok_or(innovation)?;
        let gain = Gain::new(&self.covariance, &states, &noise, seen).ok_or(innovation)?;
        let count = seen.iter().filter(|seen| **seen).count();
        if gain.normalised(innovation) > INNOVATION_GATE * INNOVATION_GATE * count as f64 {
            return Err(innovation);
        }
        self.learn_misfit(kind, &gain, innovation, seen);
        self.learn_walk(kind, &gain, &states, innovation);
        // The first rounds have told their scatter as they told the state: they are not beside it as strangers are.
        if self.ready {
            let steady = gain.by_state.plus(&crossings);
            self.learn_scatter(by_switch, &steady, innovation, seen, expected_ns(record));
        }
        let correction: State =
            std::array::from_fn(|i| gain.of[i][0] * innovation[0] + gain.of[i][1] * innovation[1]);
        self.correct_speeds(&correction);
        self.state.iter_mut().zip(correction).for_each(|(part, by)| *part += by);
        self.covariance = gain.posterior(&self.covariance);
        self.last = (gain.of, states);
        Ok(rows.map(|row| row.ns))
    }

    /// What an error that all switches have in common does to an estimate that depends on the state and on its own switch as given,
    /// 1 sigma, ohm: it is in Ro and d by the split discharges, which run through R_1 by so much longer than is known, and in
    /// the estimate once more. `u_switch_ns`: of a switch by the length of calls, 0 without one.
    pub fn unlike_calls_ohm(&self, by_state: &State, by_switch: f64, u_switch_ns: f64) -> f64 {
        let by_split = by_state[D] - by_state[R_O] / self.state[0];
        UNLIKE_CALLS * u_switch_ns * (by_split / SPLIT_FRACTION - by_switch).abs()
    }

    /// What a calibration discharge of this kind would bring, if it ends at this node. What discharges of different kinds
    /// contradict each other by, more of them do not take away: it is not in it.
    pub fn planned_gain(&self, kind: CalibrationKind, last: Node) -> Option<Gain> {
        let route = self.planned(kind);
        let rows = self.crossings(&route);
        let (_, noise) = self.noise_of(&route, &rows, 0.0, 0.0)?;
        Gain::new(&self.covariance, &rows.map(|row| row.by_state), &noise, [true, last == Node::B])
    }

    /// What a calibration discharge of this kind runs through.
    pub fn planned(&self, kind: CalibrationKind) -> Route {
        let at_ns = SPLIT_FRACTION * self.takes_ns()[0];
        let switch = Switch { at_ns, on_ns: at_ns, to: Through::C2 };
        let switch = (kind == CalibrationKind::Split).then_some((switch, self.r_ohm[1]));
        Route { first_ohm: self.first_ohm(kind), switch }
    }

    /// When both nodes cross in the calibration discharges as they would be now, ns: asked for several times a discharge.
    pub fn calibration_ns(&self) -> [[f64; 2]; 2] {
        let state = &self.state;
        self.r_ohm.map(|r_ohm| [0, 1].map(|node| d_ns(state, node) + state[node] * (r_ohm + state[R_O])))
    }

    /// The crossings of the calibration discharges as they would be now, and their derivatives by the state.
    pub fn calibration(&self) -> [[Crossing; 2]; 2] {
        self.r_ohm.map(|first_ohm| {
            let route = Route { first_ohm, switch: None };
            self.crossings(&route)
        })
    }

    /// d and Ro, and what has been learned of switches.
    pub fn offset(&self) -> Offset {
        let known = |index: usize| (self.state[index], self.covariance[index][index].sqrt());
        let (d_ns, u_d_ns) = known(D);
        Offset {
            d_ns,
            u_d_ns,
            b_later_ns: self.state[D_B],
            r_o_ohm: Some(known(R_O)),
            scatter: self.scatter,
            ..Offset::default()
        }
    }
}

#[cfg(test)]
mod tests;
