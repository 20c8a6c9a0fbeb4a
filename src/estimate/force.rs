//! Resistance to force, for piezoresistive sensors.

use crate::reading::Measured;
use crate::units::{Newton, NewtonOhm};

/// The characteristic of a sensor; `T` is its table, or in a configuration the file that the table is in.
#[derive(Debug, Clone, PartialEq)]
pub enum Force<T = Table> {
    /// The forces at which the sensor has R_1 and R_2, the greater one first: the reciprocal force is affine in the resistance
    /// (eq. (26), (27)).
    Calibrated {
        /// F_c1.
        fc1: Newton,
        /// F_c2.
        fc2: Newton,
    },
    /// F = alpha / R, eq. (1).
    Alpha(NewtonOhm),
    /// F = F_1k (R / 1 kohm)^-exponent.
    PowerLaw {
        /// F_1k, the force at which the sensor has 1 kohm.
        at_1_kohm: Newton,
        /// Above 0; 1 for a sensor that follows eq. (1).
        exponent: f64,
    },
    /// Measured pairs, interpolated in log-log; nothing is known outside them.
    Table(T),
}

impl<T> Force<T> {
    /// The same with its table made of what stands for it.
    ///
    /// # Errors
    /// Those of `make`.
    pub fn try_map<U, E>(self, make: impl FnOnce(T) -> Result<U, E>) -> Result<Force<U>, E> {
        Ok(match self {
            Force::Calibrated { fc1, fc2 } => Force::Calibrated { fc1, fc2 },
            Force::Alpha(alpha) => Force::Alpha(alpha),
            Force::PowerLaw { at_1_kohm, exponent } => Force::PowerLaw { at_1_kohm, exponent },
            Force::Table(table) => Force::Table(make(table)?),
        })
    }
}

impl Force {
    /// The force at a resistance and its 1-sigma uncertainty; `None` where the characteristic gives no positive, finite
    /// force. The sensor's own deviation from its characteristic is not in the uncertainty. `known`: R_1 and R_2, ohm.
    pub fn at(&self, r_ohm: Measured, known: [f64; 2]) -> Option<Measured> {
        let r = r_ohm.value;
        let (f_n, slope) = match self {
            Force::Calibrated { fc1, fc2 } => {
                let slope = (1.0 / fc2.0 - 1.0 / fc1.0) / (known[1] - known[0]);
                let f = 1.0 / (1.0 / fc1.0 + slope * (r - known[0]));
                (f, -slope * f * f)
            }
            Force::Alpha(alpha) => (alpha.0 / r, -alpha.0 / (r * r)),
            Force::PowerLaw { at_1_kohm, exponent } => {
                let f = at_1_kohm.0 * (r / 1000.0).powf(-exponent);
                (f, -exponent * f / r)
            }
            Force::Table(table) => table.at(r)?,
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
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// (ln ohm, ln newton), resistance rising.
    points: Vec<(f64, f64)>,
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

impl Table {
    /// From pairs (ohm, newton) of positive finite numbers, in any order.
    ///
    /// # Errors
    /// [`TableError::Few`], [`TableError::NotMonotone`].
    pub fn from_pairs(mut pairs: Vec<(f64, f64)>) -> Result<Table, TableError> {
        if pairs.len() < 2 {
            return Err(TableError::Few(pairs.len()));
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        if let Some(pair) = pairs.windows(2).find(|pair| pair[1].0 <= pair[0].0 || pair[1].1 >= pair[0].1) {
            return Err(TableError::NotMonotone { r_ohm: pair[1].0 });
        }
        Ok(Table { points: pairs.into_iter().map(|(r, f)| (r.ln(), f.ln())).collect() })
    }

    /// Force and its slope by resistance; `None` outside the table.
    fn at(&self, r_ohm: f64) -> Option<(f64, f64)> {
        let x = r_ohm.ln();
        let upper = self.points.partition_point(|point| point.0 < x).max(1);
        let (left, right) = (self.points[upper - 1], *self.points.get(upper)?);
        if !(left.0..=right.0).contains(&x) {
            return None;
        }
        let exponent = (right.1 - left.1) / (right.0 - left.0);
        let f = (left.1 + exponent * (x - left.0)).exp();
        Some((f, exponent * f / r_ohm))
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
        let alpha = Force::Alpha(NewtonOhm(ALPHA));
        assert_eq!(format!("{:.2}", alpha.at_bound(2320.0, KNOWN).unwrap()), "5.75");
        assert_eq!(format!("{:.2}", alpha.at_bound(12700.0, KNOWN).unwrap()), "1.05");
    }

    proptest! {
        #![proptest_config(crate::seed::cases(256))]

        #[test]
        fn every_form_says_the_same_of_a_sensor_that_follows_alpha(r in 60.0..18_000.0f64, u in 0.01..1.0f64) {
            let table = [50.0, 200.0, 3000.0, 20_000.0].map(|r| (r, ALPHA / r)).to_vec();
            let forms = [
                Force::Alpha(NewtonOhm(ALPHA)),
                Force::Calibrated { fc1: Newton(ALPHA / 2320.0), fc2: Newton(ALPHA / 12700.0) },
                Force::PowerLaw { at_1_kohm: Newton(ALPHA / 1000.0), exponent: 1.0 },
                Force::Table(Table::from_pairs(table).unwrap()),
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
        let pair = Force::Calibrated { fc1: Newton(5.75), fc2: Newton(1.05) };
        assert_eq!(pair.at_bound(-100.0, KNOWN), None);
        assert_eq!(Force::Alpha(NewtonOhm(ALPHA)).at_bound(0.0, KNOWN), None);
        // 1/F of this pair is negative below some ohms: beyond what the pair can tell.
        let steep = Force::Calibrated { fc1: Newton(20.0), fc2: Newton(1.05) };
        assert_eq!(steep.at_bound(10.0, KNOWN), None);
        let table = Force::Table(Table::from_pairs(vec![(100.0, 10.0), (1000.0, 1.0)]).unwrap());
        assert_eq!((table.at_bound(99.0, KNOWN), table.at_bound(1001.0, KNOWN)), (None, None));
        assert!(table.at_bound(100.0, KNOWN).is_some() && table.at_bound(1000.0, KNOWN).is_some());
    }

    #[test]
    fn bad_tables_say_where() {
        let message = |pairs: &[(f64, f64)]| Table::from_pairs(pairs.to_vec()).unwrap_err().to_string();
        assert!(message(&[(100.0, 1.0)]).contains("1 pair(s)"));
        assert!(message(&[(100.0, 1.0), (200.0, 2.0)]).contains("200 ohm"));
    }
}
