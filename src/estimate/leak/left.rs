//! What a leak does to a reading.
//!
//! A discharge through R takes g (R+Ro) / (1 + G (R+Ro)), and two-point calibration makes of it a resistance that is too high
//! between R_1 and R_2 and too low elsewhere: [`error_ohm`]. Where R_2 sinks beside the sensor (QERM), the leak takes the same
//! part in the discharge as in that of R_2 alone and cancels: T_x* is g (R_x+Ro), and only the calibration is wrong.

use crate::estimate::limits::{BY_CALIBRATION, LEAK_AT_B, LEAK_BENT, LEAK_LEFT};
use crate::record::Record;

/// What is left of what leaks, siemens.
#[derive(Debug, Clone, Copy, Default)]
pub struct Left {
    /// The likely one that is not undone, and the noise of one that is.
    pub likely: f64,
    pub noise: f64,
    /// By how much more it takes at the end of a discharge than at its beginning: nothing to speak of through a resistor to ground.
    pub bent: f64,
    /// What may be so at B alone, where anything leaks.
    pub at_b: f64,
    /// What is undone.
    pub undone: f64,
}

/// What a leak does to a discharge of the sensor depends on this.
#[derive(Debug, Clone, Copy)]
pub struct Course {
    pub r_ohm: f64,
    /// How long another resistor finished it, in times of the sensor's own part; 0 where none did.
    pub after: f64,
    /// It went on to node B.
    pub is_to_b: bool,
    /// Of the circuit.
    pub nodes: usize,
}

impl Course {
    pub fn of(record: &Record, r_ohm: f64, nodes: usize) -> Course {
        let ended_ns = record.b_ns.or(record.a_ns);
        let after =
            record.switch.zip(ended_ns).map(|(switch, ns)| (ns - switch.on_ns).max(0.0) / switch.at_ns);
        Course { r_ohm, after: after.unwrap_or(0.0), is_to_b: nodes == 2 && record.b_ns.is_some(), nodes }
    }

    /// What leaks may make of a reading, 1 sigma, ohm; `None`: no resistance is too high for it.
    pub fn left_ohm(&self, left: &Left, [r1, r2]: [f64; 2], sinks_beside: bool) -> Option<f64> {
        let error_ohm = |siemens: f64| error_ohm(siemens, [r1, r2], self.r_ohm, sinks_beside);
        let to_ground = error_ohm(left.likely)?.hypot(error_ohm(left.noise)?);
        let [of_error, of_calibration, of_sensor] = LEAK_LEFT[self.nodes - 1];
        let of_undone = of_error * error_ohm(left.undone)?;
        let siemens = left.at_b * if self.is_to_b { 1.0 } else { BY_CALIBRATION };
        let at_b = LEAK_AT_B[0] * error_ohm(siemens)?;
        let calibration = (of_calibration * left.undone).hypot(LEAK_AT_B[1] * siemens) * r1 * r2;
        let sensor = (of_sensor * left.undone).hypot(LEAK_AT_B[2] * siemens) * self.r_ohm * r2;
        Some([to_ground, of_undone, at_b, calibration, sensor].into_iter().fold(0.0, f64::hypot))
    }

    /// What one that need not be to ground does beside that.
    pub fn bent_ohm(&self, left: &Left, [r1, r2]: [f64; 2]) -> f64 {
        let [of_error, of_calibration, of_sensor, to_a, to_b] = LEAK_BENT[self.nodes - 1];
        let error = of_error * (self.r_ohm - r1) * (r2 - self.r_ohm);
        let calibration = (of_calibration * r1).hypot(of_sensor * self.r_ohm) * r2;
        let finish = if self.is_to_b { to_b } else { to_a } * self.r_ohm.powi(2) * self.after;
        left.bent * error.hypot(calibration).hypot(finish)
    }
}

/// By how much a leak at node A makes a reading of `r_ohm` too high (or too low, where negative), ohm; `None`: no
/// resistance is too high for it. `sinks_beside`: R_2 sinks with the sensor.
pub fn error_ohm(siemens: f64, [r1, r2]: [f64; 2], r_ohm: f64, sinks_beside: bool) -> Option<f64> {
    if sinks_beside {
        // The chord itself.
        let [t1, t2] = [r1, r2].map(|r| r / (1.0 + siemens * r));
        return Some(r_ohm - t1 - (r_ohm - r1) / (r2 - r1) * (t2 - t1));
    }
    // The chord from R_1 to R_2 taken for the curve r / (1 + G r), the other way round.
    let left = 1.0 + siemens * (r2 + r1 - r_ohm);
    (left > 0.0).then(|| siemens * (r_ohm - r1) * (r2 - r_ohm) / left)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn less_is_left_of_a_leak_that_is_undone_and_more_of_one_that_is_none_to_ground() {
        let r = [510.0, 12_740.0];
        let course = |r_ohm, nodes| Course { r_ohm, after: 0.05, is_to_b: nodes == 2, nodes };
        let there = Left { likely: 1e-6, ..Left::default() };
        let undone = Left { undone: 1e-6, noise: 5e-9, at_b: 3e-8, ..Left::default() };
        let left_ohm = |course: Course, left: &Left| course.left_ohm(left, r, false);
        for (nodes, part) in [(1, 0.03), (2, 0.06)] {
            let [before, after] =
                [&there, &undone].map(|left| left_ohm(course(5000.0, nodes), left).unwrap());
            assert!(before > 30.0 && after < part * before && after > 0.01 * before, "{before} {after}");
        }
        // Nor is there certainty where the error is none; less of it where B was waited for in calibrations alone.
        let to_b = left_ohm(course(510.0, 2), &undone).unwrap();
        let to_a = left_ohm(Course { is_to_b: false, ..course(510.0, 2) }, &undone).unwrap();
        assert!(to_b > 0.1 && to_a < 0.5 * to_b, "{to_b} {to_a}");
        assert_eq!(left_ohm(course(200_000.0, 1), &Left { likely: 1e-5, ..Left::default() }), None);
        let bent = Left { bent: 1e-7, ..Left::default() };
        assert_eq!(course(510.0, 1).bent_ohm(&there, r), 0.0);
        assert!(course(510.0, 2).bent_ohm(&bent, r) > course(510.0, 1).bent_ohm(&bent, r));
        let later = Course { after: 1.0, ..course(510.0, 1) };
        assert!(later.bent_ohm(&bent, r) > course(510.0, 1).bent_ohm(&bent, r));
    }

    #[test]
    fn an_error_is_that_of_the_chord() {
        let (siemens, [r1, r2]) = (1e-5, [2320.0, 12_700.0]);
        let time = |r: f64| r / (1.0 + siemens * r);
        for r_ohm in [1.0, 100.0, 1000.0, 2320.0, 6000.0, 12_700.0, 30_000.0, 1e6] {
            let found = r1 + (time(r_ohm) - time(r1)) / (time(r2) - time(r1)) * (r2 - r1);
            let error = error_ohm(siemens, [r1, r2], found, false).unwrap();
            assert!((error - (found - r_ohm)).abs() < 1e-9 * r_ohm, "{r_ohm}: {found} {error}");
        }
        assert_eq!(error_ohm(siemens, [r1, r2], 200_000.0, false), None);
    }

    #[test]
    fn beside_r_2_a_leak_spoils_the_calibration_alone() {
        let (g, siemens, [r1, r2]) = (0.5, 1e-6, [470.0, 13_170.0]);
        let alone = |r: f64| g / (1.0 / r + siemens);
        for r_ohm in [1000.0, 5000.0, 40_000.0] {
            // g = s/R_x + T3 (1/R_2 + G), with the sensor released half-way.
            let s = 0.5 * g / (1.0 / r_ohm + 1.0 / r2 + siemens);
            let t3 = (g - s / r_ohm) / (1.0 / r2 + siemens);
            let t_x = s * alone(r2) / (alone(r2) - t3);
            let found = r1 + (t_x - alone(r1)) / (alone(r2) - alone(r1)) * (r2 - r1);
            let error = error_ohm(siemens, [r1, r2], found, true).unwrap();
            assert!((error - (found - r_ohm)).abs() < 1e-9 * r_ohm, "{r_ohm}: {found} {error}");
        }
    }
}
