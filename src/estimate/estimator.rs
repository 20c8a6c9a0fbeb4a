//! The estimator: the calibration that is in force, uncertainty by propagation, and the states of a reading.

use crate::circuit::Node;
use crate::estimate::absorption::AbsorptionTest;
use crate::estimate::awake::AwakeTest;
use crate::estimate::leak::{Beside, LeakTest};
use crate::estimate::limits::{BEYOND_NOISE, UNTOLD_SWITCH_NS};
use crate::estimate::mean::Basis;
use crate::estimate::method::tracked::{self, Observed};
use crate::estimate::method::{Scale, Switched, Switching, Times, dual};
use crate::estimate::motion::Evidence;
use crate::estimate::noise::{Covariance, Noise};
use crate::estimate::offset::Offset;
use crate::estimate::tracker::Tracker;
use crate::reading::{Branch, Fault, Measured, Method};
use crate::record::{CalibrationKind, Crossings, Record, UNLIKE_CALLS};
use crate::units::Nanos;
use covariances::Covariances;
use dual::Dual;

mod covariances;
mod early;
mod leakage;
mod prediction;
mod status;

pub use status::{Judged, shown};

/// An estimate of R_x, before the sensor's own zero is taken off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Which equation.
    pub branch: Branch,
    /// Ohm, with 1 sigma.
    pub r_ohm: Measured,
    /// What that is made of; nothing where it is not known.
    pub basis: Basis,
    /// What stamps may do to it beside that, which are later after long waits or early in wide-band noise, 1 sigma, ohm.
    pub stamps_ohm: f64,
}

/// Variances of the [ratio](crate::estimate::method) to be expected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Predicted {
    /// Of a direct estimate.
    pub direct: f64,
    /// Of an inferred one.
    pub inferred: f64,
    /// The part of the offset in that.
    pub by_offset: f64,
}

/// Turns records into estimates, by one method, with the most recent calibration discharges.
#[derive(Debug, Clone)]
pub struct Estimator {
    method: Method,
    r1_ohm: f64,
    r2_ohm: f64,
    nodes: usize,
    offset: Offset,
    noise: Noise,
    c1: Option<Crossings>,
    c2: Option<Crossings>,
    /// What leaks, as far as looks have told; `None` where leaks are left out.
    leak: Option<LeakTest>,
    /// What of them was undone last.
    beside: Option<Beside>,
    /// What capacitors absorb, as far as looks have told.
    absorption: AbsorptionTest,
    /// Whether stamps are later after long waits, without a tracked calibration.
    awake: AwakeTest,
    /// With it, c1 and c2 are only used until it is ready.
    tracker: Option<Tracker>,
}

impl Estimator {
    /// For calibration resistors `r1_ohm` < `r2_ohm` (Rc1 and Rc2, or Rc1 and Rc1 + Rc2), in a circuit with one or two
    /// `nodes`.
    pub fn new(method: Method, r1_ohm: f64, r2_ohm: f64, nodes: usize, offset: Offset) -> Estimator {
        let noise = Noise::new(nodes, 1.0);
        Estimator {
            method,
            r1_ohm,
            r2_ohm,
            nodes,
            offset,
            noise,
            c1: None,
            c2: None,
            leak: None,
            beside: None,
            absorption: AbsorptionTest::default(),
            awake: AwakeTest::default(),
            tracker: None,
        }
    }

    /// The same, with a calibration that is followed instead of taken anew for each reading.
    pub fn tracked(method: Method, r1_ohm: f64, r2_ohm: f64, nodes: usize) -> Estimator {
        let tracker = Some(Tracker::new([r1_ohm, r2_ohm], nodes, 1.0));
        Estimator { tracker, ..Estimator::new(method, r1_ohm, r2_ohm, nodes, Offset::default()) }
    }

    /// The clock that stamps crossings has this period, instead of 1 ns or what was said before.
    pub fn set_resolution(&mut self, resolution_ns: f64) {
        self.noise.set_resolution(resolution_ns);
        if let Some(tracker) = &mut self.tracker {
            tracker.set_resolution(resolution_ns);
        }
    }

    /// The tracked calibration, once there is one.
    pub fn tracker(&self) -> Option<&Tracker> {
        self.tracker.as_ref().filter(|tracker| tracker.is_ready())
    }

    /// Lets the tracked calibration know how steady readings are: [`Tracker::add_reading`].
    pub fn add_reading(&mut self, beside_ns: f64, steady: f64) {
        if let Some(tracker) = &mut self.tracker {
            tracker.add_reading(beside_ns, steady);
        }
    }

    /// Finds a tracked calibration again, from the beginning.
    pub fn begin_anew(&mut self) {
        if let Some(tracker) = &mut self.tracker {
            tracker.begin_anew();
        }
    }

    /// Lets the tracked calibration grow older.
    pub fn advance(&mut self, now: Nanos) {
        if let Some(tracker) = self.tracker.as_mut().filter(|tracker| tracker.is_ready()) {
            tracker.advance(now);
        }
    }

    /// The method.
    pub fn method(&self) -> Method {
        self.method
    }

    /// The offset in force.
    pub fn offset(&self) -> Offset {
        self.tracker().map_or(self.offset, Tracker::offset)
    }

    /// Ro as far as it is known, ohm: before there is a tracked state, too.
    pub fn r_o_ohm(&self) -> Option<f64> {
        self.offset().r_o().or_else(|| self.tracker.as_ref()?.rough_r_o_ohm())
    }

    /// Puts another offset in force.
    pub fn set_offset(&mut self, offset: Offset) {
        self.offset = offset;
    }

    /// What is known about noise.
    pub fn noise(&self) -> &Noise {
        self.tracker().map_or(&self.noise, Tracker::noise)
    }

    /// The crossings of the calibration discharges in force, of the nodes that there are.
    pub fn calibration(&self) -> Option<(Crossings, Crossings)> {
        let Some(tracker) = self.tracker() else { return self.c1.zip(self.c2) };
        let [c1, c2] = tracker.calibration_ns().map(|of| self.existing(of.map(Some)));
        Some((c1, c2))
    }

    /// Takes a calibration discharge.
    ///
    /// # Errors
    /// [`Fault::NoCalibration`] if a crossing is missing, [`Fault::LatencyOutlier`] if it is late beyond the others.
    /// The calibration in force stays.
    pub fn calibrate(&mut self, record: &Record) -> Result<(), Fault> {
        // Whether its stamp is as late as others is not known before there is a state that it can be held against.
        if record.is_woken() && self.tracker().is_none() {
            return Ok(());
        }
        if let Some(tracker) = &mut self.tracker {
            tracker.add(record)?;
            if tracker.is_ready() {
                return Ok(());
            }
        }
        let kind = record.calibration_kind().ok_or(Fault::NoCalibration)?;
        let times = record.complete(self.nodes).ok_or(Fault::NoCalibration)?;
        let ended = record.ended(self.nodes).ok_or(Fault::NoCalibration)?;
        let judged = self.noise.add(kind, ended, [0.0; 2]);
        // After a step others are where these were not.
        if self.tracker.as_ref().is_none_or(|tracker| tracker.steps() == 0) {
            judged?;
        }
        match kind {
            CalibrationKind::First => self.c1 = Some(times),
            CalibrationKind::Second => self.c2 = Some(times),
            CalibrationKind::Split => {}
        }
        Ok(())
    }

    /// The node whose crossing ends a discharge.
    fn last(&self) -> Node {
        Node::BOTH[self.nodes - 1]
    }

    /// Estimates R_x from an x discharge alone.
    ///
    /// # Errors
    /// The fault that keeps it from being a number; [`Fault::LatencyOutlier`] if its crossings contradict each other.
    pub fn estimate(&self, record: &Record) -> Result<Estimate, Fault> {
        match self.solve(record)? {
            (_, evidence) if evidence.contradicts => Err(Fault::LatencyOutlier),
            (estimate, _) => Ok(estimate),
        }
    }

    /// The state that the method solves by, if it does and there is one.
    fn state(&self) -> Option<&Tracker> {
        self.tracker().filter(|_| self.method.is_tracked())
    }

    /// The same, contradictions left to who knows the sensor's motion.
    fn solve(&self, record: &Record) -> Result<(Estimate, Evidence), Fault> {
        if let Some(tracker) = self.state() {
            let solution = tracked::solve(tracker, &self.observed(record)?)?;
            let observed_u_ns = self.u_switch_ns(record, solution.branch);
            let unlike_ohm = tracker.unlike_calls_ohm(&solution.by_state, solution.by_switch, observed_u_ns);
            let asleep_ohm = tracker.asleep_ohm(solution.r_ohm, &solution.by_state, record);
            let stamps_ohm = asleep_ohm.hypot(self.early_ohm(tracker, solution.r_ohm, solution.branch));
            let u_ohm = solution.variance.sqrt().hypot(unlike_ohm);
            let r_ohm = Measured { value: solution.r_ohm, u: Some(u_ohm) };
            let own = (solution.variance - tracker.variance(&solution.by_state)).max(0.0);
            let by_switch = (solution.branch == Branch::Inferred).then_some(solution.by_switch);
            let basis = Basis { own, by_state: Some(solution.by_state), by_switch };
            return Ok((Estimate { branch: solution.branch, r_ohm, basis, stamps_ohm }, solution.evidence));
        }
        let (times, branch) = self.times(record)?;
        let (ratio, basis, evidence, by_stamps) =
            self.ratio(&times, branch, record).ok_or(Fault::MissedEdge)?;
        let span = self.r2_ohm - self.r1_ohm;
        let r_ohm = self.r1_ohm + ratio.value * span;
        let u = ratio.u.map(|u| u * span);
        let sound = r_ohm.is_finite() && u.is_none_or(f64::is_finite);
        if sound {
            let basis = Basis {
                own: span * span * basis.own,
                by_state: basis.by_state.map(|by| by.map(|by| span * by)),
                by_switch: basis.by_switch.map(|by| span * by),
            };
            let (r_ohm, stamps_ohm) = (Measured { value: r_ohm, u }, span * by_stamps);
            Ok((Estimate { branch, r_ohm, basis, stamps_ohm }, evidence))
        } else {
            Err(Fault::Implausible)
        }
    }

    fn observed(&self, record: &Record) -> Result<Observed, Fault> {
        record.ended(self.nodes).ok_or(Fault::MissedEdge)?;
        let switch = record.switch.map(|switch| (switch, self.ohm_after(switch)));
        let branch = if switch.is_some() { Branch::Inferred } else { Branch::Direct };
        let u_switch_ns = self.u_switch_ns(record, branch);
        let later_ns = record.later_ns.unwrap_or(0.0);
        Ok(Observed { crossings: record.crossings(), switch, u_switch_ns, later_ns })
    }

    /// The uncertainty of the switch of a discharge, ns: as its recorder says, or else what switches scatter by.
    fn u_switch_ns(&self, record: &Record, branch: Branch) -> f64 {
        match branch {
            Branch::Direct => 0.0,
            Branch::Inferred => self.told_switch_ns(record).unwrap_or(UNTOLD_SWITCH_NS),
        }
    }

    fn told_switch_ns(&self, record: &Record) -> Option<f64> {
        record.u_switch_ns.or(self.offset().scatter.found_ns())
    }

    /// Whether the uncertainty of an estimate is more prior than evidence.
    fn is_settling(&self, record: &Record, Estimate { branch, r_ohm, basis, .. }: &Estimate) -> bool {
        let is_untold = *branch == Branch::Inferred && self.told_switch_ns(record).is_none();
        let by_offset = r_ohm.u.map_or(0.0, |u| u * u - basis.own);
        let is_early = self.offset().is_prior && by_offset > basis.own;
        let is_unseen = self.leak.as_ref().is_some_and(|leak| !leak.is_known());
        is_untold || is_early || is_unseen || !self.noise().is_known()
    }

    /// The times of an estimate, and which equation is to be used.
    fn times(&self, record: &Record) -> Result<(Times<f64>, Branch), Fault> {
        let (c1, c2) = self.calibration().ok_or(Fault::NoCalibration)?;
        // Of crossings that are closer than their noise any may be the first, but R_1 and R_2 are apart by more.
        let noise = self.noise().covariance(c1);
        let within = |noise: Covariance| BEYOND_NOISE * noise.aa.max(noise.bb).sqrt();
        let apart = noise.map_or(0.0, within);
        let close = within(noise.unwrap_or_else(|| Noise::prior(c1)));
        let d = self.offset().d_ns;
        let follow = |[first, second]: [Option<f64>; 2], by: f64| {
            first.zip(second).is_none_or(|(first, second)| second > first + by)
        };
        let ordered =
            (0..2).all(|node| follow([c1[node], c2[node]], apart) && follow([Some(d), c1[node]], -close));
        if !ordered || !follow(c1, -close) || !follow(c2, -close) {
            return Err(Fault::Implausible);
        }
        let last = record.crossing(self.last()).ok_or(Fault::MissedEdge)?;
        let switch = record.switch.filter(|switch| last - d > switch.on_ns);
        let branch = if switch.is_some() { Branch::Inferred } else { Branch::Direct };
        match (switch, self.method.rules().switching) {
            // Of a switched discharge nothing is known before there is a tracked calibration.
            (Some(_), Switching::WhereBest) => return Err(Fault::NoCalibration),
            (Some(_), Switching::Never) => return Err(Fault::Implausible),
            (Some(switch), Switching::AtFraction) if switch.at_ns <= 0.0 => return Err(Fault::Implausible),
            _ => {}
        }
        let x = self.existing(record.crossings());
        if x.into_iter().flatten().any(|crossing| crossing < 0.0) || last <= d - close {
            return Err(Fault::Implausible);
        }
        let switch = switch.map(|switch| Switched { at: switch.at_ns, on: switch.on_ns });
        let [c1, c2, x] = [c1, c2, x].map(|[a, b]| [a, b.map(|b| b - self.offset().b_later_ns)]);
        Ok((Times { c1, c2, x, switch, beside: record.second_ns, d }, branch))
    }

    /// The crossings of nodes that the method looks at.
    fn existing(&self, [a, b]: [Option<f64>; 2]) -> [Option<f64>; 2] {
        [a, b.filter(|_| self.nodes == 2)]
    }

    /// The ratio, what its variance is made of, what it rests on, and what stamps that are later after long waits or early in noise do
    /// to it; `None` if a time was not seen that the equation needs.
    fn ratio(
        &self,
        times: &Times<f64>,
        branch: Branch,
        record: &Record,
    ) -> Option<(Measured, Basis, Evidence, f64)> {
        let late = match branch {
            Branch::Direct => times.x,
            Branch::Inferred => times.c2,
        };
        let u_switch_ns = self.u_switch_ns(record, branch);
        let covariances = self.covariances(late, u_switch_ns, record.later_ns.unwrap_or(0.0));
        let u = |of: &Dual| covariances.as_ref().map(|covariances| covariances.of(&of.by).sqrt());
        let (rules, variables) = (self.method.rules(), dual::variables(times));
        let ratio = (rules.ratio)(&variables, branch)?;
        let scale = Scale { r_ohm: [self.r1_ohm, self.r2_ohm], u: &u };
        let evidence = (rules.evidence)(&variables, branch, &scale)?;
        let asleep = self.asleep(&ratio.by, record).unwrap_or(0.0);
        let by_stamps = asleep.hypot(self.early(&ratio.by, times, branch));
        let by_switch = (branch == Branch::Inferred).then_some(ratio.by.switch);
        let basis =
            covariances.as_ref().map(|covariances| Basis { by_switch, ..covariances.basis(&ratio.by) });
        Some((Measured { value: ratio.value, u: u(&ratio) }, basis.unwrap_or_default(), evidence, by_stamps))
    }

    /// The covariances of all times; `late` are the crossings that a discharge only through the resistor that ran last
    /// would have. `later_ns`: as in [`Record::later_ns`].
    fn covariances(&self, late: Crossings, u_switch_ns: f64, later_ns: f64) -> Option<Covariances<'_>> {
        let (c1, c2) = self.calibration()?;
        let offset = self.offset();
        let at = offset.scatter.u_ns(u_switch_ns).hypot(later_ns);
        let (noise, u_common_ns) = (self.noise(), UNLIKE_CALLS * u_switch_ns);
        let common = (u_common_ns * u_common_ns, offset.by_switch);
        let mut covariances = match self.tracker() {
            Some(tracker) => Covariances {
                crossings: [Covariance::default(), Covariance::default(), noise.covariance(late)?],
                single: [at * at, 0.0],
                common,
                tracker: Some(tracker),
            },
            None => Covariances {
                crossings: noise.covariances([c1, c2, late]).unwrap_or([c1, c2, late].map(Noise::prior)),
                single: [at * at, offset.own_variance(u_common_ns)],
                common,
                tracker: None,
            },
        };
        covariances.crossings[2].add_outer([later_ns; 2]);
        Some(covariances)
    }
}

#[cfg(test)]
mod tests;
