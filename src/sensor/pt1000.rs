//! `pt1000`: a platinum resistor of 1 kohm at 0 degC, by IEC 60751:2008 (Callendar and Van Dusen).
//!
//! R = R_0 (1 + A t + B t^2), below 0 degC R_0 (1 + A t + B t^2 + C (t - 100) t^3), from -200 to 850 degC; nothing is said beyond.

use super::relation::Relation;
use super::{Defect, Shown};
use serde::{Deserialize, Serialize};

const R_0_OHM: f64 = 1000.0;
// IEC 60751:2008, 4.2.
/// 1/degC.
const A: f64 = 3.9083e-3;
/// 1/degC^2.
const B: f64 = -5.775e-7;
/// 1/degC^4, below 0 degC.
const C: f64 = -4.183e-12;
/// degC.
const DEFINED_DEGC: [f64; 2] = [-200.0, 850.0];
/// Newton's steps from the line of A: four reach 1e-9 degC from any end, as tests show.
const STEPS: usize = 8;

/// A platinum resistor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Pt1000 {
    /// Its tolerance class; absent: not known, and no value has an uncertainty.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub class: Option<Class>,
}

/// A tolerance class of IEC 60751:2008.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Class {
    /// +-(0.1 + 0.0017 |t|) degC.
    AA,
    /// +-(0.15 + 0.002 |t|) degC.
    A,
    /// +-(0.3 + 0.005 |t|) degC.
    B,
    /// +-(0.6 + 0.01 |t|) degC.
    C,
}

impl Class {
    /// The tolerance at 0 degC, degC, what it grows by with each degree, and where it holds for film resistors, degC.
    fn limits(self) -> ([f64; 2], [f64; 2]) {
        match self {
            Class::AA => ([0.1, 0.0017], [0.0, 150.0]),
            Class::A => ([0.15, 0.002], [-30.0, 300.0]),
            Class::B => ([0.3, 0.005], [-50.0, 500.0]),
            Class::C => ([0.6, 0.01], [-50.0, 600.0]),
        }
    }
}

/// The resistance at a temperature, and how it changes with that, ohm and ohm/degC.
fn at(t: f64) -> [f64; 2] {
    let c = if t < 0.0 { C } else { 0.0 };
    let r = 1.0 + t * (A + t * (B + c * t * (t - 100.0)));
    let slope = A + t * (2.0 * B + c * t * (4.0 * t - 300.0));
    [R_0_OHM * r, R_0_OHM * slope]
}

impl Relation for Pt1000 {
    fn unit(&self) -> &str {
        "degC"
    }

    fn shown(&self, r_ohm: f64) -> Option<Shown> {
        let [lowest, highest] = DEFINED_DEGC;
        if !(at(lowest)[0]..=at(highest)[0]).contains(&r_ohm) {
            return None;
        }
        let mut t = (r_ohm / R_0_OHM - 1.0) / A;
        for _ in 0..STEPS {
            let [r, slope] = at(t);
            t += (r_ohm - r) / slope;
        }
        let limits = self.class.map(Class::limits);
        let [least, greatest] = limits.map_or(DEFINED_DEGC, |(_, range)| range);
        Some(Shown {
            value: t,
            slope: 1.0 / at(t)[1],
            // Of limits between which nothing is more likely (GUM 4.3.7).
            own_u: limits.map(|([at_0, per_degree], _)| (at_0 + per_degree * t.abs()) / 3f64.sqrt()),
            is_extrapolated: !(least..=greatest).contains(&t),
        })
    }

    fn defect(&self) -> Option<Defect> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Ten times the ohms of table 1 of IEC 60751, which are given to 0.01 ohm of a Pt100.
    const PUBLISHED: [(f64, f64); 14] = [
        (-200.0, 185.2),
        (-150.0, 397.2),
        (-100.0, 602.6),
        (-50.0, 803.1),
        (-10.0, 960.9),
        (0.0, 1000.0),
        (10.0, 1039.0),
        (50.0, 1194.0),
        (100.0, 1385.1),
        (200.0, 1758.6),
        (300.0, 2120.5),
        (500.0, 2809.8),
        (600.0, 3137.1),
        (850.0, 3904.8),
    ];

    #[test]
    fn it_is_the_table_of_the_standard() {
        for (t, r_ohm) in PUBLISHED {
            assert!((at(t)[0] - r_ohm).abs() <= 0.0501, "{t}: {}", at(t)[0]);
        }
        // To five digits, as data sheets of Pt1000 have it.
        for (t, r_ohm) in [(-50.0, 803.06), (0.0, 1000.0), (100.0, 1385.06)] {
            assert!((at(t)[0] - r_ohm).abs() <= 0.00501, "{t}: {}", at(t)[0]);
        }
    }

    #[test]
    fn the_classes_are_limits_at_0_and_100_degc() {
        for (class, at_0, at_100) in
            [(Class::AA, 0.1, 0.27), (Class::A, 0.15, 0.35), (Class::B, 0.3, 0.8), (Class::C, 0.6, 1.6)]
        {
            let law = Pt1000 { class: Some(class) };
            for (t, limit) in [(0.0, at_0), (100.0, at_100)] {
                let u = law.shown(at(t)[0]).unwrap().own_u.unwrap();
                assert!((u * 3f64.sqrt() - limit).abs() < 1e-9, "{class:?} {t}: {u}");
            }
        }
        let b = Pt1000 { class: Some(Class::B) };
        let is_extrapolated = |t| b.shown(at(t)[0]).unwrap().is_extrapolated;
        assert_eq!([-51.0, -49.0, 499.0, 501.0].map(is_extrapolated), [true, false, false, true]);
        assert_eq!(Pt1000 { class: None }.shown(1000.0).unwrap().own_u, None);
    }

    #[test]
    fn nothing_is_said_beyond_the_standard() {
        let law = Pt1000 { class: None };
        for r_ohm in [-5.0, 0.0, 185.0, 3905.0, 1e6, f64::NAN] {
            assert_eq!(law.shown(r_ohm), None, "{r_ohm}");
        }
    }

    proptest! {
        #![proptest_config(crate::seed::cases(256))]

        #[test]
        fn there_and_back(t in -200.0..850.0f64) {
            let shown = Pt1000 { class: None }.shown(at(t)[0]).unwrap();
            prop_assert!((shown.value - t).abs() < 1e-9, "{}", shown.value);
        }
    }
}
