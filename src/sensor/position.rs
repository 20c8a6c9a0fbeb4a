//! `position`: a potentiometer, or whatever is linear in its resistance: x = span (R - R_0) / (R_1 - R_0).

use super::relation::{Relation, defect_of_part, defect_of_unit};
use super::{Defect, Shown};
use serde::{Deserialize, Serialize};

/// A sensor that is linear in its resistance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Position {
    /// At 0, ohm.
    pub r0_ohm: f64,
    /// At the span, ohm; below R_0 where the position falls with the resistance.
    pub r1_ohm: f64,
    /// From one end to the other.
    pub span: f64,
    /// What span, u and values are in: "mm", "deg" or "%".
    pub unit: String,
    /// How far the position is off the line, 1 sigma; absent: not known, and no value has an uncertainty.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u: Option<f64>,
}

impl Relation for Position {
    fn unit(&self) -> &str {
        &self.unit
    }

    fn shown(&self, r_ohm: f64) -> Option<Shown> {
        let slope = self.span / (self.r1_ohm - self.r0_ohm);
        let value = slope * (r_ohm - self.r0_ohm);
        let is_extrapolated = !(0.0..=self.span).contains(&value);
        Some(Shown { value, slope, own_u: self.u, is_extrapolated })
    }

    fn defect(&self) -> Option<Defect> {
        // The end of a wiper has next to none.
        let r0 = if self.r0_ohm == 0.0 { None } else { defect_of_part("r0", self.r0_ohm) };
        let ends = (self.r0_ohm == self.r1_ohm).then(|| {
            (
                "r0 and r1 are the same".to_owned(),
                "what the channel reads in ohm at either end: r0 at 0, r1 at span",
            )
        });
        let span = (!(self.span > 0.0 && self.span.is_finite())).then(|| {
            (
                format!("span = {} {} is not above 0", self.span, self.unit),
                "span = \"100 mm\", r0 and r1 swapped",
            )
        });
        let u = self.u.filter(|u| !(*u > 0.0 && *u <= self.span)).map(|u| {
            (format!("u = {u} {} is not above 0 and up to span", self.unit), "u = \"0.5 mm\", 1 sigma")
        });
        r0.or(defect_of_part("r1", self.r1_ohm)).or(ends).or(span).or(u).or(defect_of_unit(&self.unit))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slider(r0_ohm: f64, r1_ohm: f64) -> Position {
        Position { r0_ohm, r1_ohm, span: 100.0, unit: "mm".to_owned(), u: Some(0.5) }
    }

    #[test]
    fn both_ways_along_a_slider() {
        let mm = |law: &Position, r_ohm| law.shown(r_ohm).unwrap();
        let (up, down) = (slider(20.0, 10_020.0), slider(10_020.0, 20.0));
        assert!((mm(&up, 2_520.0).value - 25.0).abs() < 1e-9 && mm(&up, 0.0).slope > 0.0);
        assert!((mm(&down, 2_520.0).value - 75.0).abs() < 1e-9 && mm(&down, 0.0).slope < 0.0);
        assert!(mm(&up, 0.0).is_extrapolated && mm(&up, 10_100.0).is_extrapolated);
        assert!(!mm(&up, 5_000.0).is_extrapolated && mm(&up, 5_000.0).own_u == Some(0.5));
    }

    #[test]
    fn what_has_no_length_is_refused() {
        assert_eq!(slider(0.0, 1e4).defect(), None);
        for (wrong, word) in [
            (slider(1e4, 1e4), "the same"),
            (slider(-5.0, 1e4), "r0"),
            (slider(0.0, 0.0), "r1"),
            (Position { span: 0.0, ..slider(0.0, 1e4) }, "span"),
            (Position { span: f64::NAN, ..slider(0.0, 1e4) }, "span"),
            (Position { u: Some(101.0), ..slider(0.0, 1e4) }, "u = 101 mm"),
            (Position { unit: "N".to_owned(), ..slider(0.0, 1e4) }, "unit"),
        ] {
            let (reason, _) = wrong.defect().expect(word);
            assert!(reason.contains(word), "{reason}");
        }
    }
}
