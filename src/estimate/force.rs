//! Resistance to force, for piezoresistive sensors.
//!
//! For: the force that belongs to a resistance, with its slope. Must not know: how the resistance was measured.

use crate::reading::Measured;

/// The characteristic of a sensor.
#[derive(Debug, Clone, PartialEq)]
pub enum Force {
    /// F = alpha / R (eq. (1)), alpha in N ohm.
    Alpha(f64),
    /// The reciprocal force is affine in the resistance (eq. (26), (27)), through (`r_ohm[i]`, `f_n[i]`): the forces that
    /// bring the sensor to the resistance of the calibration resistors.
    Pair {
        /// The two calibration resistors.
        r_ohm: [f64; 2],
        /// The forces that belong to them.
        f_n: [f64; 2],
    },
    /// F = scale R^-exponent, in newton with R in ohm.
    Power {
        /// N ohm^exponent.
        scale: f64,
        /// Positive.
        exponent: f64,
    },
    /// Measured pairs, interpolated in log-log; nothing is known outside them.
    Table(Table),
}

impl Force {
    /// The force at a resistance and its 1-sigma uncertainty; `None` where the characteristic gives no positive, finite
    /// force. The sensor's own deviation from its characteristic is not in the uncertainty.
    pub fn at(&self, r_ohm: Measured) -> Option<Measured> {
        let r = r_ohm.value;
        let (f_n, slope) = match self {
            Force::Alpha(alpha) => (alpha / r, -alpha / (r * r)),
            Force::Pair { r_ohm, f_n } => {
                let slope = (1.0 / f_n[1] - 1.0 / f_n[0]) / (r_ohm[1] - r_ohm[0]);
                let f = 1.0 / (1.0 / f_n[0] + slope * (r - r_ohm[0]));
                (f, -slope * f * f)
            }
            Force::Power { scale, exponent } => {
                let f = scale * r.powf(-exponent);
                (f, -exponent * f / r)
            }
            Force::Table(table) => table.at(r)?,
        };
        let measured = Measured { value: f_n, u: r_ohm.u.map(|u| u * slope.abs()) };
        let sound = f_n > 0.0 && f_n.is_finite() && measured.u.is_none_or(f64::is_finite);
        (r > 0.0 && sound).then_some(measured)
    }

    /// The force at an exactly known resistance, such as a bound.
    pub fn at_bound(&self, r_ohm: f64) -> Option<f64> {
        self.at(Measured { value: r_ohm, u: None }).map(|force| force.value)
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

    #[test]
    fn the_calibration_forces_of_the_paper_belong_to_its_alpha() {
        let alpha = Force::Alpha(ALPHA);
        assert_eq!(format!("{:.2}", alpha.at_bound(2320.0).unwrap()), "5.75");
        assert_eq!(format!("{:.2}", alpha.at_bound(12700.0).unwrap()), "1.05");
    }

    proptest! {
        #[test]
        fn every_form_says_the_same_of_a_sensor_that_follows_alpha(r in 60.0..18_000.0f64, u in 0.01..1.0f64) {
            let table = [50.0, 200.0, 3000.0, 20_000.0].map(|r| (r, ALPHA / r)).to_vec();
            let forms = [
                Force::Alpha(ALPHA),
                Force::Pair { r_ohm: [2320.0, 12700.0], f_n: [ALPHA / 2320.0, ALPHA / 12700.0] },
                Force::Power { scale: ALPHA, exponent: 1.0 },
                Force::Table(Table::from_pairs(table).unwrap()),
            ];
            for form in forms {
                let force = form.at(Measured { value: r, u: Some(u) }).unwrap();
                prop_assert!((force.value * r / ALPHA - 1.0).abs() < 1e-9, "{form:?}");
                let slope = (form.at_bound(r * (1.0 - 1e-6)).unwrap() - form.at_bound(r * (1.0 + 1e-6)).unwrap()) / (2e-6 * r);
                prop_assert!((force.u.unwrap() / (slope * u) - 1.0).abs() < 1e-4, "{form:?}");
            }
        }
    }

    #[test]
    fn no_force_is_made_up() {
        let pair = Force::Pair { r_ohm: [2320.0, 12700.0], f_n: [5.75, 1.05] };
        assert_eq!(pair.at_bound(-100.0), None);
        assert_eq!(Force::Alpha(ALPHA).at_bound(0.0), None);
        // 1/F of this pair is negative below some ohms: beyond what the pair can tell.
        let steep = Force::Pair { r_ohm: [2320.0, 12700.0], f_n: [20.0, 1.05] };
        assert_eq!(steep.at_bound(10.0), None);
        let table = Force::Table(Table::from_pairs(vec![(100.0, 10.0), (1000.0, 1.0)]).unwrap());
        assert_eq!((table.at_bound(99.0), table.at_bound(1001.0)), (None, None));
        assert!(table.at_bound(100.0).is_some() && table.at_bound(1000.0).is_some());
    }

    #[test]
    fn bad_tables_say_where() {
        let message = |pairs: &[(f64, f64)]| Table::from_pairs(pairs.to_vec()).unwrap_err().to_string();
        assert!(message(&[(100.0, 1.0)]).contains("1 pair(s)"));
        assert!(message(&[(100.0, 1.0), (200.0, 2.0)]).contains("200 ohm"));
    }
}
