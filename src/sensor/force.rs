//! `force`: how the resistance of a piezoresistive sensor becomes a force: the four ways to say it, how well it is known, and
//! what lies on the sensor.

use super::limits::{EXPONENTS, FORCES_N, UNCALIBRATED_N, UNCALIBRATED_U};
use super::table::{Pairs, PairsDemands, PairsError};
use super::{Defect, Shown};
use crate::units::{Newton, NewtonOhm, rounded};
use serde::{Deserialize, Serialize};
use std::fmt::Display;

/// The characteristic of a sensor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Force {
    /// How force follows from resistance.
    #[serde(flatten)]
    pub law: Law,
    /// How far the sensor is off that, relative deviation of its resistance, 1 sigma; absent: as [`UNCALIBRATED_U`] says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u: Option<f64>,
    /// The least and the greatest force that it was found with, newton; absent: as [`UNCALIBRATED_N`] says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range_n: Option<[f64; 2]>,
    /// What lies on the sensor and does not count, newton: it is taken off every force.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tare_n: Option<f64>,
}

#[cfg(test)]
impl From<Law> for Force {
    fn from(law: Law) -> Force {
        Force { law, u: None, range_n: None, tare_n: None }
    }
}

fn absurd(value: impl Display) -> Defect {
    (format!("{value} is beyond any sensor"), "another prefix: M is mega, m is milli")
}

/// The same of how well one is known.
pub fn defect_of_bounds(u: Option<f64>, range_n: Option<[f64; 2]>, tare_n: Option<f64>) -> Option<Defect> {
    let is_range = |[least, greatest]: [f64; 2]| {
        least < greatest && FORCES_N.contains(&least) && FORCES_N.contains(&greatest)
    };
    match (u, range_n, tare_n) {
        (Some(u), ..) if !(u > 0.0 && u <= 1.0) => Some((
            format!("u = {} % is not above 0 % and up to 100 %", rounded(100.0 * u, 7)),
            "u = \"8.7 %\", the residual that `cermctl calibrate force` shows",
        )),
        (.., Some(tare_n)) if !FORCES_N.contains(&tare_n) => {
            Some((format!("tare = {} is no load", Newton(tare_n)), "what `cermctl zero` finds"))
        }
        (_, Some(range), _) if !is_range(range) => Some((
            format!(
                "range = {:?} is not from a lesser to a greater force",
                range.map(|f_n| Newton(f_n).to_string())
            ),
            "range = [\"0.5 N\", \"20 N\"]",
        )),
        _ => None,
    }
}

impl Force {
    /// What is wrong with it.
    pub fn defect(&self) -> Option<Defect> {
        self.law.defect().or(defect_of_bounds(self.u, self.range_n, self.tare_n))
    }

    /// The force at a resistance; `None` where the characteristic gives no positive, finite force. `known`: R_1 and R_2, ohm.
    pub fn shown(&self, r_ohm: f64, known: [f64; 2]) -> Option<Shown> {
        let (f_n, slope) = self.law.at(r_ohm, known)?;
        let [least, greatest] = self.range_n.unwrap_or(UNCALIBRATED_N);
        // Outside of its pairs a table gives no force at all.
        let is_table = matches!(self.law, Law::Table { .. });
        Some(Shown {
            value: self.net(f_n),
            slope,
            // What the sensor is off its law by at the tare is mostly in both, and u is that of the greater one alone.
            own_u: Some(self.u.unwrap_or(UNCALIBRATED_U) * r_ohm * slope.abs()),
            is_extrapolated: !is_table && !(least..=greatest).contains(&f_n),
        })
    }

    /// The force at an exactly known resistance, such as a bound.
    pub fn at_bound(&self, r_ohm: f64, known: [f64; 2]) -> Option<f64> {
        self.law.at(r_ohm, known).map(|(f_n, _)| self.net(f_n))
    }

    /// Of what lies on the sensor, what counts, newton.
    fn net(&self, f_n: f64) -> f64 {
        f_n - self.tare_n.unwrap_or(0.0)
    }
}

/// How force follows from resistance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "force is one of {\"fc1_n\", \"fc2_n\"}, {\"alpha_n_ohm\"}, {\"at_1_kohm_n\", \"exponent\"}, {\"table\"}"
)]
pub enum Law {
    /// The forces at which the sensor has R_1 and R_2, the greater one first: the reciprocal force is affine in the resistance
    /// (eq. (26), (27)).
    Calibrated {
        /// F_c1, newton.
        fc1_n: f64,
        /// F_c2, newton.
        fc2_n: f64,
    },
    /// F = alpha / R, eq. (1).
    Alpha {
        /// N ohm.
        alpha_n_ohm: f64,
    },
    /// F = F_1k (R / 1 kohm)^-exponent.
    Power {
        /// F_1k, the force at which the sensor has 1 kohm, newton.
        at_1_kohm_n: f64,
        /// Above 0; 1 for a sensor that follows eq. (1).
        exponent: f64,
    },
    /// Measured pairs, interpolated in log-log; nothing is known outside them.
    Table {
        /// The pairs.
        table: Table,
    },
}

impl Law {
    /// What is wrong with its numbers.
    pub fn defect(&self) -> Option<Defect> {
        match *self {
            Law::Calibrated { fc1_n, fc2_n } if !(fc2_n > 0.0 && fc1_n > fc2_n) => Some((
                format!(
                    "fc1 = {} at the lower resistance has to exceed fc2 = {}, and both be above zero",
                    Newton(fc1_n),
                    Newton(fc2_n)
                ),
                "the greater force as fc1",
            )),
            Law::Alpha { alpha_n_ohm } if alpha_n_ohm <= 0.0 => Some((
                format!("alpha = {} is not above zero", NewtonOhm(alpha_n_ohm)),
                "alpha = \"13346 N ohm\", usual for an FSR 402",
            )),
            Law::Power { at_1_kohm_n, exponent } if !(at_1_kohm_n > 0.0 && exponent > 0.0) => Some((
                format!(
                    "at-1-kohm = {} and exponent = {exponent} have to be above zero",
                    Newton(at_1_kohm_n)
                ),
                "{ at-1-kohm = \"13.3 N\", exponent = 1.0 }",
            )),
            Law::Calibrated { fc1_n, .. } if !FORCES_N.contains(&fc1_n) => Some(absurd(Newton(fc1_n))),
            Law::Calibrated { fc2_n: f_n, .. } | Law::Power { at_1_kohm_n: f_n, .. }
                if !FORCES_N.contains(&f_n) =>
            {
                Some(absurd(Newton(f_n)))
            }
            // At 1 kohm.
            Law::Alpha { alpha_n_ohm } if !FORCES_N.contains(&(alpha_n_ohm / 1e3)) => {
                Some(absurd(NewtonOhm(alpha_n_ohm)))
            }
            Law::Power { exponent, .. } if !EXPONENTS.contains(&exponent) => Some((
                format!(
                    "exponent = {exponent:e} is not between {} and {}",
                    EXPONENTS.start(),
                    EXPONENTS.end()
                ),
                "1.0, near which force-sensing resistors are",
            )),
            _ => None,
        }
    }

    /// The force at a resistance, and its slope by that; `None` where there is no positive, finite force. `known`: R_1 and R_2.
    fn at(&self, r: f64, known: [f64; 2]) -> Option<(f64, f64)> {
        let (f_n, slope) = match self {
            Law::Calibrated { fc1_n, fc2_n } => {
                let slope = (1.0 / fc2_n - 1.0 / fc1_n) / (known[1] - known[0]);
                let f = 1.0 / (1.0 / fc1_n + slope * (r - known[0]));
                (f, -slope * f * f)
            }
            Law::Alpha { alpha_n_ohm } => (alpha_n_ohm / r, -alpha_n_ohm / (r * r)),
            Law::Power { at_1_kohm_n, exponent } => {
                let f = at_1_kohm_n * (r / 1000.0).powf(-exponent);
                (f, -exponent * f / r)
            }
            Law::Table { table } => table.at(r)?,
        };
        let is_sound = r > 0.0 && f_n > 0.0 && f_n.is_finite() && slope.is_finite();
        is_sound.then_some((f_n, slope))
    }
}

/// Measured pairs (ohm, newton): more force, less resistance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<(f64, f64)>", into = "Vec<(f64, f64)>")]
pub struct Table(Pairs);

const RULES: PairsDemands = PairsDemands {
    name: "the force table",
    is_sound: |f_n| FORCES_N.contains(&f_n),
    unsound: "has a pair (ohm, newton) that is not above 0",
    may_rise: false,
    turned: "the force does not fall",
};

impl TryFrom<Vec<(f64, f64)>> for Table {
    type Error = PairsError;
    /// From pairs (ohm, newton) in any order.
    fn try_from(pairs: Vec<(f64, f64)>) -> Result<Table, PairsError> {
        Pairs::sorted(pairs, &RULES).map(Table)
    }
}

impl From<Table> for Vec<(f64, f64)> {
    fn from(table: Table) -> Vec<(f64, f64)> {
        table.0.into()
    }
}

impl Table {
    /// Force and its slope by resistance; `None` outside the table.
    fn at(&self, r_ohm: f64) -> Option<(f64, f64)> {
        let [left, right] = self.0.around(r_ohm)?;
        let exponent = (right.1 / left.1).ln() / (right.0 / left.0).ln();
        let f = left.1 * (r_ohm / left.0).powf(exponent);
        Some((f, exponent * f / r_ohm))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reading::{Measured, MeasuredValue};
    use crate::sensor::Channel;
    use proptest::prelude::*;

    /// The FSR 402 of the paper: alpha = 13346.46 N ohm at Rc1 = 2320 and Rc2 = 12700 ohm.
    const ALPHA: f64 = 13346.46;
    const KNOWN: [f64; 2] = [2320.0, 12700.0];

    /// Of a sensor whose pins are known.
    fn shown(force: Force, r_ohm: Measured) -> MeasuredValue {
        let channel =
            Channel { zero_ohm: Some(0.0), scale: Some(1.0), force: Some(force), ..Channel::default() };
        channel.value_at(r_ohm, KNOWN).unwrap()
    }

    #[test]
    fn the_calibration_forces_of_the_paper_belong_to_its_alpha() {
        let alpha = Force::from(Law::Alpha { alpha_n_ohm: ALPHA });
        assert_eq!(format!("{:.2}", alpha.at_bound(2320.0, KNOWN).unwrap()), "5.75");
        assert_eq!(format!("{:.2}", alpha.at_bound(12700.0, KNOWN).unwrap()), "1.05");
    }

    proptest! {
        #![proptest_config(crate::seed::cases(256))]

        #[test]
        fn every_form_says_the_same_of_a_sensor_that_follows_alpha(r in 60.0..18_000.0f64, u in 0.01..1.0f64) {
            let table = [50.0, 200.0, 3000.0, 20_000.0].map(|r| (r, ALPHA / r)).to_vec();
            let forms = [
                Law::Alpha { alpha_n_ohm: ALPHA },
                Law::Calibrated { fc1_n: ALPHA / 2320.0, fc2_n: ALPHA / 12700.0 },
                Law::Power { at_1_kohm_n: ALPHA / 1000.0, exponent: 1.0 },
                Law::Table { table: Table::try_from(table).unwrap() },
            ];
            for form in forms.map(Force::from) {
                let force = shown(form.clone(), Measured { value: r, u: Some(u) });
                prop_assert!((force.value * r / ALPHA - 1.0).abs() < 1e-9, "{form:?}");
                let slope = (form.at_bound(r * (1.0 - 1e-6), KNOWN).unwrap() - form.at_bound(r * (1.0 + 1e-6), KNOWN).unwrap()) / (2e-6 * r);
                prop_assert!((force.repeat_u.unwrap() / (slope * u) - 1.0).abs() < 1e-4, "{form:?}");
            }
        }
    }

    #[test]
    fn a_force_is_as_uncertain_as_the_sensor_and_says_where_it_is_extrapolated() {
        let of = |law: Law, u, range_n| Force { law, u, range_n, tare_n: None };
        let r_ohm = Measured { value: 2266.0, u: Some(2.6) };
        let force = |force: Force| shown(force, r_ohm);
        let alpha = || Law::Alpha { alpha_n_ohm: ALPHA };
        let known = force(of(alpha(), Some(0.087), Some([1.0, 10.0])));
        assert!((known.repeat_u.unwrap() - 5.89 * 2.6 / 2266.0).abs() < 1e-4, "{known:?}");
        assert!((known.u.unwrap() - 5.89 * 0.087).abs() < 1e-3 && !known.is_extrapolated, "{known:?}");
        // What nobody has calibrated is as good as the data sheet says.
        let unknown = force(of(alpha(), None, None));
        assert!((unknown.u.unwrap() / unknown.value - UNCALIBRATED_U).abs() < 1e-3, "{unknown:?}");
        assert!(force(of(alpha(), None, Some([1.0, 5.0]))).is_extrapolated);
        assert!(alpha().at(50_000.0, KNOWN).is_some_and(|(f_n, _)| f_n > UNCALIBRATED_N[0]));
        assert!(shown(alpha().into(), Measured { value: 1e5, u: None }).is_extrapolated);
        // The deviation is one of the resistance: a steeper sensor makes more of it.
        let steep = force(of(Law::Power { at_1_kohm_n: 13.3, exponent: 2.0 }, Some(0.05), None));
        assert!((steep.u.unwrap() / steep.value - 0.1).abs() < 1e-3, "{steep:?}");
    }

    #[test]
    fn no_force_is_made_up() {
        let pair = Force::from(Law::Calibrated { fc1_n: 5.75, fc2_n: 1.05 });
        assert_eq!(pair.at_bound(-100.0, KNOWN), None);
        assert_eq!(Force::from(Law::Alpha { alpha_n_ohm: ALPHA }).at_bound(0.0, KNOWN), None);
        // 1/F of this pair is negative below some ohms: beyond what the pair can tell.
        let steep = Force::from(Law::Calibrated { fc1_n: 20.0, fc2_n: 1.05 });
        assert_eq!(steep.at_bound(10.0, KNOWN), None);
        let table =
            Force::from(Law::Table { table: Table::try_from(vec![(100.0, 10.0), (1000.0, 1.0)]).unwrap() });
        assert_eq!((table.at_bound(99.0, KNOWN), table.at_bound(1001.0, KNOWN)), (None, None));
        assert!(table.at_bound(100.0, KNOWN).is_some() && table.at_bound(1000.0, KNOWN).is_some());
    }

    #[test]
    fn bad_tables_say_where() {
        let message = |pairs: &[(f64, f64)]| Table::try_from(pairs.to_vec()).unwrap_err().to_string();
        assert!(message(&[(100.0, 1.0)]).contains("1 pair(s)"));
        assert!(message(&[(100.0, 1.0), (200.0, 2.0)]).contains("200 ohm"));
    }
}
