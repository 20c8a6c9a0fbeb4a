//! What is known of a sensor before it is measured.
//!
//! For: its zero, and how its resistance becomes a force, as a configuration gives them and a tape carries them. Must not know:
//! how the resistance is measured.

use crate::reading::Measured;
use serde::{Deserialize, Serialize};

/// A sensor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Channel {
    /// Its name.
    pub id: String,
    /// What a short circuit in its place reads, ohm.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub zero_ohm: f64,
    /// Its characteristic, if it is to give forces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<Force>,
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// The characteristic of a sensor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "force is one of {\"fc1_n\", \"fc2_n\"}, {\"alpha_n_ohm\"}, {\"at_1_kohm_n\", \"exponent\"}, {\"table\"}"
)]
pub enum Force {
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

impl Force {
    /// The force at a resistance and its 1-sigma uncertainty; `None` where the characteristic gives no positive, finite
    /// force. The sensor's own deviation from its characteristic is not in the uncertainty. `known`: R_1 and R_2, ohm.
    pub fn at(&self, r_ohm: Measured, known: [f64; 2]) -> Option<Measured> {
        let r = r_ohm.value;
        let (f_n, slope) = match self {
            Force::Calibrated { fc1_n, fc2_n } => {
                let slope = (1.0 / fc2_n - 1.0 / fc1_n) / (known[1] - known[0]);
                let f = 1.0 / (1.0 / fc1_n + slope * (r - known[0]));
                (f, -slope * f * f)
            }
            Force::Alpha { alpha_n_ohm } => (alpha_n_ohm / r, -alpha_n_ohm / (r * r)),
            Force::Power { at_1_kohm_n, exponent } => {
                let f = at_1_kohm_n * (r / 1000.0).powf(-exponent);
                (f, -exponent * f / r)
            }
            Force::Table { table } => table.at(r)?,
        };
        let measured = Measured { value: f_n, u: r_ohm.u.map(|u| u * slope.abs()) };
        let sound = f_n > 0.0 && f_n.is_finite() && measured.u.is_none_or(f64::is_finite);
        (r > 0.0 && sound).then_some(measured)
    }

    /// The force at an exactly known resistance, such as a bound.
    pub fn at_bound(&self, r_ohm: f64, known: [f64; 2]) -> Option<f64> {
        self.at(Measured { value: r_ohm, u: None }, known).map(|force| force.value)
    }
}

/// Measured pairs of force and resistance: more force, less resistance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<(f64, f64)>", into = "Vec<(f64, f64)>")]
pub struct Table {
    /// (ohm, newton), resistance rising.
    pairs: Vec<(f64, f64)>,
}

/// What is wrong with a force table.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// Too few pairs.
    #[error("the force table has {0} pair(s); it takes at least 2")]
    Few(usize),
    /// Not monotone.
    #[error(
        "the force table is not monotone: at {r_ohm} ohm the force does not fall while the resistance rises; take that pair out or measure it again"
    )]
    NotMonotone {
        /// The resistance of the offending pair.
        r_ohm: f64,
    },
}

impl TryFrom<Vec<(f64, f64)>> for Table {
    type Error = TableError;
    /// From pairs (ohm, newton) of positive finite numbers, in any order.
    fn try_from(mut pairs: Vec<(f64, f64)>) -> Result<Table, TableError> {
        if pairs.len() < 2 {
            return Err(TableError::Few(pairs.len()));
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        if let Some(pair) = pairs.windows(2).find(|pair| pair[1].0 <= pair[0].0 || pair[1].1 >= pair[0].1) {
            return Err(TableError::NotMonotone { r_ohm: pair[1].0 });
        }
        Ok(Table { pairs })
    }
}

impl Table {
    /// The pairs (ohm, newton), resistance rising.
    pub fn pairs(&self) -> &[(f64, f64)] {
        &self.pairs
    }

    /// Force and its slope by resistance; `None` outside the table.
    fn at(&self, r_ohm: f64) -> Option<(f64, f64)> {
        let upper = self.pairs.partition_point(|pair| pair.0 < r_ohm).max(1);
        let (left, right) = (self.pairs[upper - 1], *self.pairs.get(upper)?);
        if !(left.0..=right.0).contains(&r_ohm) {
            return None;
        }
        let exponent = (right.1 / left.1).ln() / (right.0 / left.0).ln();
        let f = left.1 * (r_ohm / left.0).powf(exponent);
        Some((f, exponent * f / r_ohm))
    }
}

impl From<Table> for Vec<(f64, f64)> {
    fn from(table: Table) -> Vec<(f64, f64)> {
        table.pairs
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The FSR 402 of the paper: alpha = 13346.46 N ohm at Rc1 = 2320 and Rc2 = 12700 ohm.
    const ALPHA: f64 = 13346.46;
    const KNOWN: [f64; 2] = [2320.0, 12700.0];

    #[test]
    fn the_calibration_forces_of_the_paper_belong_to_its_alpha() {
        let alpha = Force::Alpha { alpha_n_ohm: ALPHA };
        assert_eq!(format!("{:.2}", alpha.at_bound(2320.0, KNOWN).unwrap()), "5.75");
        assert_eq!(format!("{:.2}", alpha.at_bound(12700.0, KNOWN).unwrap()), "1.05");
    }

    proptest! {
        #![proptest_config(crate::seed::cases(256))]

        #[test]
        fn every_form_says_the_same_of_a_sensor_that_follows_alpha(r in 60.0..18_000.0f64, u in 0.01..1.0f64) {
            let table = [50.0, 200.0, 3000.0, 20_000.0].map(|r| (r, ALPHA / r)).to_vec();
            let forms = [
                Force::Alpha { alpha_n_ohm: ALPHA },
                Force::Calibrated { fc1_n: ALPHA / 2320.0, fc2_n: ALPHA / 12700.0 },
                Force::Power { at_1_kohm_n: ALPHA / 1000.0, exponent: 1.0 },
                Force::Table { table: Table::try_from(table).unwrap() },
            ];
            for form in forms {
                let force = form.at(Measured { value: r, u: Some(u) }, KNOWN).unwrap();
                prop_assert!((force.value * r / ALPHA - 1.0).abs() < 1e-9, "{form:?}");
                let slope = (form.at_bound(r * (1.0 - 1e-6), KNOWN).unwrap() - form.at_bound(r * (1.0 + 1e-6), KNOWN).unwrap()) / (2e-6 * r);
                prop_assert!((force.u.unwrap() / (slope * u) - 1.0).abs() < 1e-4, "{form:?}");
            }
        }
    }

    #[test]
    fn no_force_is_made_up() {
        let pair = Force::Calibrated { fc1_n: 5.75, fc2_n: 1.05 };
        assert_eq!(pair.at_bound(-100.0, KNOWN), None);
        assert_eq!(Force::Alpha { alpha_n_ohm: ALPHA }.at_bound(0.0, KNOWN), None);
        // 1/F of this pair is negative below some ohms: beyond what the pair can tell.
        let steep = Force::Calibrated { fc1_n: 20.0, fc2_n: 1.05 };
        assert_eq!(steep.at_bound(10.0, KNOWN), None);
        let table = Force::Table { table: Table::try_from(vec![(100.0, 10.0), (1000.0, 1.0)]).unwrap() };
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
