//! `ntc`: a thermistor whose resistance falls with temperature.
//!
//! With T in kelvin, by beta: 1/T = 1/T_25 + ln(R/R_25) / beta. By Steinhart and Hart (Deep-Sea Research 15, 1968, 497-503):
//! 1/T = a + b ln R + c (ln R)^3, R in ohm. Beta alone is off by some tenths of a kelvin between the two temperatures that it was
//! found with, and by more outside; Steinhart-Hart by some hundredths.

use super::limits::{BETAS_K, NTC_DEGC, PARTS_OHM};
use super::relation::{Relation, defect_of_part, defect_of_range, defect_of_share};
use super::{Defect, Shown};
use crate::units::Kelvin;
use serde::{Deserialize, Serialize};

/// 0 degC, K.
const ICE_K: f64 = 273.15;
/// The temperature that R_25 is the resistance at, K.
const T_25_K: f64 = ICE_K + 25.0;

/// A thermistor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Ntc {
    /// How its temperature follows from its resistance.
    #[serde(flatten)]
    pub curve: Curve,
    /// How far its resistance is off the curve, relative, 1 sigma; absent: not known, and no value has an uncertainty.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u: Option<f64>,
    /// Where the curve holds, degC; absent: -40 to 125.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range_degc: Option<[f64; 2]>,
}

/// The two ways to say it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "an ntc has {\"r25_ohm\", \"beta_k\"} or {\"a_per_k\", \"b_per_k\", \"c_per_k\"}"
)]
pub enum Curve {
    /// By two points.
    Beta {
        /// R_25, ohm.
        r25_ohm: f64,
        /// B_25/85 or its like, K.
        beta_k: f64,
        /// How far that is off, relative, 1 sigma; absent: u is all.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        beta_u: Option<f64>,
    },
    /// By three.
    SteinhartHart {
        /// 1/K.
        a_per_k: f64,
        /// 1/K.
        b_per_k: f64,
        /// 1/K.
        c_per_k: f64,
    },
}

impl Curve {
    /// 1/T, how that changes with ln R, and how far it may be off by beta, 1 sigma; all 1/K.
    fn at(&self, r_ohm: f64) -> [f64; 3] {
        match *self {
            Curve::Beta { r25_ohm, beta_k, beta_u } => {
                let by_beta = (r_ohm / r25_ohm).ln() / beta_k;
                [1.0 / T_25_K + by_beta, 1.0 / beta_k, by_beta * beta_u.unwrap_or(0.0)]
            }
            Curve::SteinhartHart { a_per_k: a, b_per_k: b, c_per_k: c } => {
                let log = r_ohm.ln();
                [a + b * log + c * log.powi(3), b + 3.0 * c * log * log, 0.0]
            }
        }
    }

    fn defect(&self) -> Option<Defect> {
        match *self {
            Curve::Beta { r25_ohm, beta_k, beta_u } => {
                let beta = (!BETAS_K.contains(&beta_k)).then(|| {
                    (format!("beta = {} is that of no thermistor", Kelvin(beta_k)), "beta = \"3950 K\"")
                });
                defect_of_part("r25", r25_ohm).or(beta).or(defect_of_share("beta-u", beta_u))
            }
            Curve::SteinhartHart { .. } => {
                let [[hot, low_slope, _], [cold, high_slope, _]] =
                    [*PARTS_OHM.start(), *PARTS_OHM.end()].map(|r_ohm| self.at(r_ohm));
                // Between the ends the slope, a parabola in ln R, is as at one of them, or b.
                let betas = [low_slope, high_slope, self.at(1.0)[1]].map(|by_log| 1.0 / by_log);
                let is_sound = betas.iter().all(|beta_k| BETAS_K.contains(beta_k))
                    && (hot..cold).contains(&(1.0 / T_25_K));
                (!is_sound).then(|| {
                    (
                        "a, b, c are those of no thermistor".to_owned(),
                        "1/T = a + b ln R + c (ln R)^3 in K and ohm: a = 1.1e-3, b = 2.4e-4, c = 7.6e-8 are usual for 10 kohm",
                    )
                })
            }
        }
    }
}

impl Relation for Ntc {
    fn unit(&self) -> &str {
        "degC"
    }

    fn shown(&self, r_ohm: f64) -> Option<Shown> {
        let [per_t, by_log, beta_u] = self.curve.at(r_ohm);
        if !(r_ohm > 0.0 && per_t > 0.0 && by_log > 0.0) {
            return None;
        }
        let t_k = 1.0 / per_t;
        let value = t_k - ICE_K;
        let [least, greatest] = self.range_degc.unwrap_or(NTC_DEGC);
        Some(Shown {
            value,
            slope: -t_k * t_k * by_log / r_ohm,
            own_u: self.u.map(|u| t_k * t_k * (u * by_log).hypot(beta_u)),
            is_extrapolated: !(least..=greatest).contains(&value),
        })
    }

    fn defect(&self) -> Option<Defect> {
        let beta_alone = matches!(self.curve, Curve::Beta { beta_u: Some(_), .. }) && self.u.is_none();
        let beta_alone = beta_alone.then(|| {
            (
                "beta-u says nothing without u".to_owned(),
                "u = \"0.6 %\", of r25: 1 sigma, 58 % of a tolerance",
            )
        });
        let remedy = "range = [\"-10 degC\", \"85 degC\"]";
        let too_cold = self.range_degc.filter(|[least, _]| *least <= -ICE_K);
        let too_cold = too_cold.map(|[least, _]| (format!("range: nothing has {least} degC"), remedy));
        (self.curve.defect().or(defect_of_share("u", self.u)).or(beta_alone))
            .or(defect_of_range(self.range_degc, remedy))
            .or(too_cold)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// EPCOS B57330V2103: degC and ohm of the table in its data sheet, which Linux has too (drivers/hwmon/ntc_thermistor.c).
    /// By the data sheet B_25/85 is 3435 K.
    const PUBLISHED: [(f64, f64); 12] = [
        (-40.0, 190_030.0),
        (-20.0, 68_104.0),
        (-10.0, 42_576.0),
        (0.0, 27_326.0),
        (10.0, 17_973.0),
        (25.0, 10_000.0),
        (40.0, 5_825.0),
        (50.0, 4_158.0),
        (60.0, 3_019.0),
        (85.0, 1_451.0),
        (100.0, 973.0),
        (125.0, 531.0),
    ];

    fn ntc(curve: Curve, u: Option<f64>) -> Ntc {
        Ntc { curve, u, range_degc: None }
    }

    fn by_beta(beta_u: Option<f64>) -> Ntc {
        ntc(Curve::Beta { r25_ohm: 10_000.0, beta_k: 3435.0, beta_u }, Some(0.01))
    }

    /// Through three points of the table.
    fn steinhart_hart(temperatures: [f64; 3]) -> Ntc {
        let rows = temperatures.map(|t| *PUBLISHED.iter().find(|(degc, _)| *degc == t).unwrap());
        let [l1, l2, l3] = rows.map(|(_, r_ohm)| r_ohm.ln());
        let [y1, y2, y3] = rows.map(|(degc, _)| 1.0 / (degc + 273.15));
        let (g2, g3) = ((y2 - y1) / (l2 - l1), (y3 - y1) / (l3 - l1));
        let c = (g3 - g2) / (l3 - l2) / (l1 + l2 + l3);
        let b = g2 - c * (l1 * l1 + l1 * l2 + l2 * l2);
        let a = y1 - (b + c * l1 * l1) * l1;
        ntc(Curve::SteinhartHart { a_per_k: a, b_per_k: b, c_per_k: c }, Some(0.01))
    }

    fn degc(law: &Ntc, r_ohm: f64) -> f64 {
        law.shown(r_ohm).unwrap().value
    }

    #[test]
    fn beta_meets_the_table_where_it_was_found_and_nearly_between() {
        let law = by_beta(None);
        for (t, r_ohm) in PUBLISHED {
            // The table has whole ohms: 0.02 K at 85 degC. Between, a second-order law cannot do better.
            let allowed = match t {
                25.0 | 85.0 => 0.03,
                25.0..85.0 => 0.45,
                0.0..100.1 => 1.1,
                _ => continue,
            };
            assert!((degc(&law, r_ohm) - t).abs() < allowed, "{t}: {}", degc(&law, r_ohm));
        }
        // What docs/sensors.md says of the cold end.
        assert!((degc(&law, 190_030.0) + 40.0 - 4.3).abs() < 0.05);
    }

    #[test]
    fn steinhart_hart_meets_the_whole_table() {
        let law = steinhart_hart([-20.0, 25.0, 85.0]);
        assert_eq!(law.defect(), None);
        for (t, r_ohm) in PUBLISHED {
            assert!((degc(&law, r_ohm) - t).abs() < 0.1, "{t}: {}", degc(&law, r_ohm));
        }
    }

    #[test]
    fn beta_adds_what_it_is_off_by_away_from_25_degc() {
        let [alone, with] = [None, Some(0.01)].map(by_beta);
        let u = |law: &Ntc, r_ohm| law.shown(r_ohm).unwrap().own_u.unwrap();
        assert!((u(&with, 10_000.0) - u(&alone, 10_000.0)).abs() < 1e-12);
        // By finite differences in beta.
        let off = ntc(Curve::Beta { r25_ohm: 10_000.0, beta_k: 3435.0 * 1.001, beta_u: None }, None);
        let by_beta_u = 10.0 * (degc(&off, 1451.0) - degc(&alone, 1451.0));
        assert!((u(&with, 1451.0).hypot(0.0) - u(&alone, 1451.0).hypot(by_beta_u)).abs() < 2e-3);
    }

    #[test]
    fn what_is_no_thermistor_is_refused() {
        let beta = |r25_ohm, beta_k, beta_u| Curve::Beta { r25_ohm, beta_k, beta_u };
        let abc = |a_per_k, b_per_k, c_per_k| Curve::SteinhartHart { a_per_k, b_per_k, c_per_k };
        for (wrong, word) in [
            (ntc(beta(1e12, 3950.0, None), None), "r25"),
            (ntc(beta(1e4, 3.95, None), None), "beta = 3.95 K"),
            (ntc(beta(1e4, 3950.0, Some(0.01)), None), "beta-u"),
            (ntc(beta(1e4, 3950.0, None), Some(1.5)), "u = 150 %"),
            (ntc(abc(1.1e-3, -2.4e-4, 7.6e-8), None), "a, b, c"),
            (ntc(abc(f64::NAN, 2.4e-4, 7.6e-8), None), "a, b, c"),
            (ntc(abc(1.1, 2.4e-4, 7.6e-8), None), "a, b, c"),
            (Ntc { range_degc: Some([80.0, 0.0]), ..by_beta(None) }, "range"),
            (Ntc { range_degc: Some([-300.0, 85.0]), ..by_beta(None) }, "-300 degC"),
        ] {
            let (reason, _) = wrong.defect().expect(word);
            assert!(reason.contains(word), "{reason}");
        }
    }
}
