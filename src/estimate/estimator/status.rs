//! What is known about a sensor: a number, or a state with its reason.

use super::Estimator;
use super::leakage::Leaked;
use crate::estimate::limits::{BEYOND_NOISE, COVERAGE, RESOLVED};
use crate::estimate::mean::Basis;
use crate::estimate::method::tracked;
use crate::estimate::motion::Motion;
use crate::reading::{Fault, Measured, MeasuredValue, Status};
use crate::record::Record;
use crate::sensor::Channel;
use crate::units::Nanos;

/// What an x discharge has told.
#[derive(Debug, Clone, Copy)]
pub struct Judged {
    /// Of the sensor.
    pub status: Status,
    /// When it was so, ns since the start: the middle of its part of the discharge where nothing tells better; `None` where
    /// there was none.
    pub at_ns: Option<f64>,
    /// What the variance of the number is made of, before motion and leaks.
    pub basis: Basis,
    /// With its sign, before the zero and the scale of the sensor, ohm, with 1 sigma of what other readings share with it.
    pub as_read_ohm: Option<Measured>,
}

impl Judged {
    /// Nothing but a fault.
    pub fn fault(fault: Fault) -> Judged {
        Judged { status: Status::Fault(fault), at_ns: None, basis: Basis::default(), as_read_ohm: None }
    }

    /// When it was so, if the discharge began at `start`.
    pub fn at(&self, start: Nanos) -> Nanos {
        self.at_ns.map_or(start, |at_ns| start + Nanos(at_ns as i64))
    }
}

impl Estimator {
    /// The lowest resistance that leaves the last node above its threshold for `waited_ns`, ohm.
    fn bound_ohm(&self, waited_ns: f64) -> Option<f64> {
        let (c1, c2) = self.calibration()?;
        let last = self.last().index();
        let (c1_ns, c2_ns) = (c1[last]?, c2[last]?);
        // While R_2 sinks too, the sensor's own part of the way is what R_2 has left over.
        let beside = self.method.rules().sinks_beside;
        let x_ns = if beside { 1.0 / (1.0 / waited_ns - 1.0 / c2_ns) } else { waited_ns };
        let ratio = (x_ns - c1_ns) / (c2_ns - c1_ns);
        let r_ohm = self.r1_ohm + ratio * (self.r2_ohm - self.r1_ohm);
        (r_ohm.is_finite() && r_ohm > 0.0).then_some(r_ohm)
    }

    /// The lower bound of a resistance that a discharge finished through R_1 or R_2 cannot tell from an open circuit.
    fn beyond(&self, record: &Record) -> Option<f64> {
        tracked::beyond(self.state()?, &self.observed(record).ok()?, self.r2_ohm)
    }

    /// The lower bound of a resistance that leaves no trace in a discharge that ended.
    fn above(&self, record: &Record) -> Option<f64> {
        let (_, c2) = self.calibration()?;
        let (node, late) = (self.last(), self.noise().covariance(c2)?.aa);
        let certain_ns = self.method.rules().certain_ns;
        self.bound_ohm(certain_ns(record.crossing(node)?, c2[node.index()]?, late)?)
    }

    /// What is known about the sensor after an x discharge alone.
    pub fn status(&self, record: &Record, sensor: &Channel) -> Status {
        self.judge(record, sensor, &mut Motion::default()).status
    }

    /// What is known about the sensor after an x discharge.
    pub fn judge(&self, record: &Record, sensor: &Channel, motion: &mut Motion) -> Judged {
        let at_ns = middle_ns(record);
        let mut judged = Judged { at_ns, ..Judged::fault(Fault::Implausible) };
        judged.status = self.status_of(record, sensor, motion, &mut judged).unwrap_or_else(|fault| {
            motion.resolved.counts(false);
            Status::Fault(fault)
        });
        if let Status::Open { r_min_ohm, .. } = judged.status {
            motion.is_open(judged.at(record.start), sensor.as_read(r_min_ohm));
        }
        judged
    }

    fn status_of(
        &self,
        record: &Record,
        sensor: &Channel,
        motion: &mut Motion,
        judged: &mut Judged,
    ) -> Result<Status, Fault> {
        self.check_paths()?;
        if let Some(r_ohm) = self.bound_alone(record, sensor)? {
            return Ok(self.open(sensor, r_ohm));
        }
        let (estimate, evidence) = self.solve(record)?;
        let Measured { value, u } = estimate.r_ohm;
        let leaked = self.leaked(value, record);
        let evidence = evidence.beside(leaked.as_ref().map_or(0.0, Leaked::disagree_ohm));
        let by_prior = self.is_settling(record, &estimate);
        // Whose conductance may be none is no number, as where the state tells it; a prior is wide enough already.
        let sigmas = if by_prior { COVERAGE } else { RESOLVED };
        let may_be_none = |u: f64| value > self.r2_ohm && value <= sigmas * u && !evidence.contradicts;
        if let Some(u) = u.filter(|u| may_be_none(*u)) {
            return Ok(self.open_above(sensor, value, u));
        }
        let r_o_ohm = self.offset().r_o();
        (judged.at_ns, judged.basis) = (Some(evidence.at_ns), estimate.basis);
        let late = self.noise().late_share();
        let moved =
            u.map(|u| motion.judge(record.start, [value, u], r_o_ohm, &evidence, late)).transpose()?;
        let measured = Measured { value, u: u.map(|u| u.hypot(moved.map_or(0.0, |moved| moved.u_ohm))) };
        let with_leak = |leaked| self.with_defects(measured, leaked, estimate.stamps_ohm);
        let Some(as_read) = leaked.as_ref().and_then(with_leak) else {
            // What is left of a leak has made it lower or higher; so far up it is the reciprocal that is known.
            let u = measured.u.ok_or(Fault::Implausible)?;
            let left_ohm = leaked.as_ref().map_or(0.0, Leaked::left_ohm);
            return Ok(self.open_above(sensor, measured.value, u.hypot(left_ohm)));
        };
        judged.as_read_ohm = Some(estimate.basis.shared(as_read));
        let r_ohm = self.own_ohm(sensor, as_read);
        let is_settling = motion.settles(by_prior);
        let is_resolved = r_ohm.u.is_none_or(|u| motion.resolved.tells(r_ohm.value / u));
        if let Some(status) = self.unresolved(record, sensor, r_ohm, is_settling, is_resolved)? {
            return Ok(status);
        }
        Ok(Status::Ok {
            branch: estimate.branch,
            r_ohm,
            is_moving: moved.is_some_and(|moved| moved.is_moving),
            is_settling: is_settling || self.noise().hides_late(),
            shown: shown(sensor, r_ohm, self.known_ohm()),
        })
    }

    /// The lower bound that is all that is known after a discharge that has not ended, or ended by R_1 or R_2 alone.
    fn bound_alone(&self, record: &Record, sensor: &Channel) -> Result<Option<f64>, Fault> {
        let (None, Some(waited_ns)) = (record.crossing(self.last()), record.waited_ns) else {
            return Ok(self.beyond(record));
        };
        // A known resistor was to finish it, and has not: nothing of this is the sensor's.
        if record.switch.is_some() {
            return Err(Fault::NoCalibration);
        }
        let bound = self.bound_ohm(waited_ns).filter(|r_ohm| sensor.corrected(*r_ohm) > 0.0);
        bound.map(Some).ok_or(Fault::Implausible)
    }

    /// What a resistance that cannot be told from a short circuit is; `None`: it can.
    fn unresolved(
        &self,
        record: &Record,
        sensor: &Channel,
        r_ohm: Measured,
        is_settling: bool,
        is_resolved: bool,
    ) -> Result<Option<Status>, Fault> {
        match r_ohm.u {
            Some(u) if r_ohm.value < -BEYOND_NOISE * u => Err(Fault::Implausible),
            // What a wide prior cannot tell from a short circuit is none yet.
            Some(u) if !is_resolved && (!is_settling || r_ohm.value <= 0.0) => {
                let r_max_ohm = r_ohm.value.max(0.0) + COVERAGE * u;
                // What may as well be above R_1 is no short circuit: nothing is known.
                if r_max_ohm > self.r1_ohm {
                    let r_ohm = self.above(record).ok_or(Fault::Implausible)?;
                    return Ok(Some(self.open(sensor, r_ohm)));
                }
                let shown = sensor.bound_below(r_max_ohm, self.known_ohm());
                Ok(Some(Status::Short { r_max_ohm, shown }))
            }
            None if r_ohm.value <= 0.0 => Err(Fault::Implausible),
            _ => Ok(None),
        }
    }

    /// The sensor's own part of a resistance as it was read.
    fn own_ohm(&self, sensor: &Channel, as_read: Measured) -> Measured {
        let value = sensor.corrected(as_read.value);
        let pins_u_ohm = sensor.pins_u_ohm(value, self.known_ohm());
        Measured { value, u: as_read.u.map(|u| u.hypot(pins_u_ohm)) }
    }

    /// At least so much as it is read.
    fn open(&self, sensor: &Channel, r_ohm: f64) -> Status {
        let r_min_ohm = sensor.corrected(r_ohm).max(0.0);
        Status::Open { r_min_ohm, shown: sensor.bound_above(r_min_ohm, self.known_ohm()) }
    }

    /// Where the reciprocal is known to +-u.
    fn open_above(&self, sensor: &Channel, value: f64, u: f64) -> Status {
        self.open(sensor, value / (1.0 + COVERAGE * u / value))
    }

    fn known_ohm(&self) -> [f64; 2] {
        [self.r1_ohm, self.r2_ohm]
    }
}

/// What a channel shows of a resistance. Of one that may be 0 the reciprocal is anything: nothing. `known_ohm`: R_1 and R_2.
pub fn shown(sensor: &Channel, r_ohm: Measured, known_ohm: [f64; 2]) -> Option<MeasuredValue> {
    is_resolved(r_ohm).then(|| sensor.value_at(r_ohm, known_ohm)).flatten()
}

/// Whether a resistance is certainly above 0.
fn is_resolved(r_ohm: Measured) -> bool {
    r_ohm.u.is_none_or(|u| r_ohm.value > COVERAGE * u)
}

/// The middle of the part of a discharge that ran through the sensor.
fn middle_ns(record: &Record) -> Option<f64> {
    let end = record.b_ns.or(record.a_ns).or(record.waited_ns)?;
    Some(record.switch.map_or(end, |switch| switch.at_ns.min(end)) / 2.0)
}
