//! `ldr`: a photoresistor, E = 10 lx (R / R_10)^(-1/gamma).
//!
//! Gamma is defined by two illuminances, gamma = log(R_10 / R_100) / log(100 / 10), and data sheets give it as the slope of a line in a
//! log-log chart; what lies beyond a decade on either side is extrapolated. The colour of the light and its history are in no law.

use super::limits::{GAMMAS, LDR_LX};
use super::relation::{Relation, defect_of_part, defect_of_range, defect_of_share};
use super::{Defect, Shown};
use serde::{Deserialize, Serialize};

/// The illuminance that R_10 belongs to, lx.
const AT_LX: f64 = 10.0;

/// A photoresistor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Ldr {
    /// R_10, ohm.
    pub at_10_lx_ohm: f64,
    /// The exponent.
    pub gamma: f64,
    /// How far its resistance is off the law, relative, 1 sigma; absent: not known, and no value has an uncertainty.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u: Option<f64>,
    /// How far gamma is off, 1 sigma; absent: u is all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gamma_u: Option<f64>,
    /// Where the law holds, lx; absent: 1 to 1000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range_lx: Option<[f64; 2]>,
}

impl Relation for Ldr {
    fn unit(&self) -> &str {
        "lx"
    }

    fn shown(&self, r_ohm: f64) -> Option<Shown> {
        if r_ohm.is_nan() || r_ohm <= 0.0 {
            return None;
        }
        let log = (r_ohm / self.at_10_lx_ohm).ln();
        let value = AT_LX * (-log / self.gamma).exp();
        let by_gamma = log / self.gamma * self.gamma_u.unwrap_or(0.0);
        let [least, greatest] = self.range_lx.unwrap_or(LDR_LX);
        Some(Shown {
            value,
            slope: -value / (self.gamma * r_ohm),
            own_u: self.u.map(|u| value / self.gamma * u.hypot(by_gamma)),
            is_extrapolated: !(least..=greatest).contains(&value),
        })
    }

    fn defect(&self) -> Option<Defect> {
        let gamma = (!GAMMAS.contains(&self.gamma)).then(|| {
            (
                format!("gamma = {} is not between {} and {}", self.gamma, GAMMAS.start(), GAMMAS.end()),
                "gamma = 0.7, as its data sheet says",
            )
        });
        let gamma_u = self.gamma_u.filter(|u| !(*u > 0.0 && *u < self.gamma) || self.u.is_none()).map(|u| {
            (
                format!("gamma-u = {u} has to be above 0 and below gamma, and says nothing without u"),
                "u = \"19 %\", gamma-u = 0.06: 1 sigma, 58 % of a tolerance",
            )
        });
        (defect_of_part("at-10-lux", self.at_10_lx_ohm)
            .or(gamma)
            .or(defect_of_share("u", self.u))
            .or(gamma_u))
        .or(defect_of_range(self.range_lx, "range = [\"1 lx\", \"1000 lx\"]"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ldr(gamma_u: Option<f64>) -> Ldr {
        Ldr { at_10_lx_ohm: 15_000.0, gamma: 0.7, u: Some(0.2), gamma_u, range_lx: None }
    }

    #[test]
    fn gamma_is_as_data_sheets_define_it() {
        let lux = |r_ohm| ldr(None).shown(r_ohm).unwrap().value;
        assert!((lux(15_000.0) - 10.0).abs() < 1e-9);
        // log(R_10 / R_100) = gamma.
        assert!((lux(15_000.0 / 10f64.powf(0.7)) - 100.0).abs() < 1e-9);
        assert_eq!(ldr(None).shown(0.0), None);
    }

    #[test]
    fn gamma_adds_what_it_is_off_by_away_from_10_lx() {
        let u = |law: &Ldr, r_ohm| law.shown(r_ohm).unwrap().own_u.unwrap();
        assert!((u(&ldr(Some(0.06)), 15_000.0) - u(&ldr(None), 15_000.0)).abs() < 1e-12);
        let steeper = Ldr { gamma: 0.7 + 1e-6, ..ldr(None) };
        let r_ohm = 2_993.0;
        let by_gamma = (steeper.shown(r_ohm).unwrap().value - ldr(None).shown(r_ohm).unwrap().value) / 1e-6;
        let wanted = u(&ldr(None), r_ohm).hypot(0.06 * by_gamma);
        assert!((u(&ldr(Some(0.06)), r_ohm) / wanted - 1.0).abs() < 1e-4);
    }

    #[test]
    fn what_is_no_photoresistor_is_refused() {
        for (wrong, word) in [
            (Ldr { at_10_lx_ohm: 0.0, ..ldr(None) }, "at-10-lux"),
            (Ldr { gamma: 70.0, ..ldr(None) }, "gamma = 70"),
            (Ldr { u: Some(0.0), ..ldr(None) }, "u = 0 %"),
            (Ldr { u: None, ..ldr(Some(0.06)) }, "gamma-u"),
            (ldr(Some(0.7)), "gamma-u"),
            (Ldr { range_lx: Some([10.0, 10.0]), ..ldr(None) }, "range"),
        ] {
            let (reason, _) = wrong.defect().expect(word);
            assert!(reason.contains(word), "{reason}");
        }
    }
}
