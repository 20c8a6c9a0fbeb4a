//! `table`: measured pairs of value and resistance, monotone in either direction; between two of them the value is a line in the
//! logarithm of the resistance, outside them nothing is known.

use super::relation::{Relation, defect_of_share, defect_of_unit};
use super::{Defect, Shown};
use serde::{Deserialize, Serialize};

/// A sensor that is known by pairs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Tabled {
    /// The pairs.
    pub table: Pairs,
    /// What the values are in.
    pub unit: String,
    /// How far its resistance is off the pairs and what is between them, relative, 1 sigma; absent: not known, and no value has an
    /// uncertainty.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u: Option<f64>,
}

/// Measured pairs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<(f64, f64)>", into = "Vec<(f64, f64)>")]
pub struct Pairs(Vec<(f64, f64)>);

/// What is wrong with the pairs of a table, and what to do.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct PairsError(String);

/// What a table asks of its pairs beside an order, in the words of its errors.
pub(super) struct PairsDemands {
    pub name: &'static str,
    pub is_sound: fn(f64) -> bool,
    pub unsound: &'static str,
    pub may_rise: bool,
    pub turned: &'static str,
}

const RULES: PairsDemands = PairsDemands {
    name: "the table",
    is_sound: f64::is_finite,
    unsound: "has a pair whose resistance is not above 0, or that is no number",
    may_rise: true,
    turned: "the value stays or turns back",
};

impl TryFrom<Vec<(f64, f64)>> for Pairs {
    type Error = PairsError;
    /// From pairs (ohm, value) in any order.
    fn try_from(pairs: Vec<(f64, f64)>) -> Result<Pairs, PairsError> {
        Pairs::sorted(pairs, &RULES)
    }
}

impl From<Pairs> for Vec<(f64, f64)> {
    fn from(pairs: Pairs) -> Vec<(f64, f64)> {
        pairs.0
    }
}

impl Pairs {
    /// From pairs in any order.
    pub(super) fn sorted(mut pairs: Vec<(f64, f64)>, rules: &PairsDemands) -> Result<Pairs, PairsError> {
        let wrong = |what: &str| Err(PairsError(format!("{} {what}", rules.name)));
        if pairs.len() < 2 {
            return wrong(&format!("has {} pair(s); it takes at least 2", pairs.len()));
        }
        let is_sound =
            |&(r_ohm, value): &(f64, f64)| r_ohm.is_finite() && r_ohm > 0.0 && (rules.is_sound)(value);
        if !pairs.iter().all(is_sound) {
            return wrong(rules.unsound);
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let is_rising = rules.may_rise && pairs[pairs.len() - 1].1 > pairs[0].1;
        let turns = |pair: &&[(f64, f64)]| {
            pair[1].0 <= pair[0].0 || pair[1].1 == pair[0].1 || (pair[1].1 > pair[0].1) != is_rising
        };
        if let Some(pair) = pairs.windows(2).find(turns) {
            return wrong(&format!(
                "is not monotone: at {} ohm {} while the resistance rises; take that pair out or measure it again",
                pair[1].0, rules.turned
            ));
        }
        Ok(Pairs(pairs))
    }

    /// The pairs on both sides of a resistance; `None` outside.
    pub(super) fn around(&self, r_ohm: f64) -> Option<[(f64, f64); 2]> {
        let upper = self.0.partition_point(|pair| pair.0 < r_ohm).max(1);
        let (left, right) = (self.0[upper - 1], *self.0.get(upper)?);
        (left.0..=right.0).contains(&r_ohm).then_some([left, right])
    }

    /// Value and its slope by resistance; `None` outside.
    fn at(&self, r_ohm: f64) -> Option<(f64, f64)> {
        let [left, right] = self.around(r_ohm)?;
        let by_log = (right.1 - left.1) / (right.0 / left.0).ln();
        Some((left.1 + by_log * (r_ohm / left.0).ln(), by_log / r_ohm))
    }
}

impl Relation for Tabled {
    fn unit(&self) -> &str {
        &self.unit
    }

    fn shown(&self, r_ohm: f64) -> Option<Shown> {
        let (value, slope) = self.table.at(r_ohm)?;
        let own_u = self.u.map(|u| u * r_ohm * slope.abs());
        Some(Shown { value, slope, own_u, is_extrapolated: false })
    }

    fn defect(&self) -> Option<Defect> {
        defect_of(&self.unit, self.u)
    }
}

/// What is wrong with what is said of a table beside its pairs.
pub fn defect_of(unit: &str, u: Option<f64>) -> Option<Defect> {
    defect_of_unit(unit).or(defect_of_share("u", u))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn tabled(pairs: &[(f64, f64)]) -> Tabled {
        Tabled { table: Pairs::try_from(pairs.to_vec()).unwrap(), unit: "%".to_owned(), u: Some(0.02) }
    }

    #[test]
    fn pairs_are_met_and_nothing_is_said_outside() {
        let pairs = [(1e6, 20.0), (1e5, 40.0), (1e4, 70.0), (3e3, 90.0)];
        let law = tabled(&pairs);
        for (r_ohm, value) in pairs {
            assert!((law.shown(r_ohm).unwrap().value - value).abs() < 1e-9, "{r_ohm}");
        }
        assert_eq!([2_999.0, 1.001e6, 0.0, f64::NAN].map(|r_ohm| law.shown(r_ohm)), [None; 4]);
        // Half way in the logarithm.
        assert!((law.shown(1e5 * 10f64.sqrt()).unwrap().value - 30.0).abs() < 1e-9);
    }

    #[test]
    fn bad_pairs_say_where() {
        let message = |pairs: &[(f64, f64)]| Pairs::try_from(pairs.to_vec()).unwrap_err().to_string();
        assert!(message(&[(100.0, 1.0)]).contains("1 pair(s)"));
        assert!(message(&[(100.0, 1.0), (200.0, 2.0), (300.0, 1.5)]).contains("300 ohm"));
        assert!(message(&[(100.0, 3.0), (200.0, 2.0), (300.0, 2.0)]).contains("300 ohm"));
        assert!(message(&[(100.0, 3.0), (100.0, 2.0)]).contains("100 ohm"));
        assert!(message(&[(-1.0, 3.0), (100.0, 2.0)]).contains("above 0"));
        assert!(message(&[(1.0, f64::NAN), (100.0, 2.0)]).contains("no number"));
        let unit =
            |unit: &str| Tabled { unit: unit.to_owned(), ..tabled(&[(1.0, 1.0), (2.0, 2.0)]) }.defect();
        assert_eq!(unit("%RH"), None);
        for wrong in ["", " ", "N", "ohm", "a\nb", "sixteen and more bytes"] {
            assert!(unit(wrong).is_some(), "{wrong:?}");
        }
    }

    proptest! {
        #![proptest_config(crate::seed::cases(256))]

        #[test]
        fn monotone_pairs_give_a_monotone_law(
            steps in prop::collection::vec((0.01..3.0f64, 0.01..50.0f64), 2..8),
            is_rising: bool,
            [a, b] in [0.0..1.0f64, 0.0..1.0f64],
        ) {
            let (mut log, mut value) = (0.0, 0.0);
            let pairs: Vec<_> = steps.iter().map(|(dlog, dvalue)| {
                (log, value) = (log + dlog, value + if is_rising { *dvalue } else { -dvalue });
                (f64::exp(log), value)
            }).collect();
            let law = tabled(&pairs);
            let (low, high) = (pairs[0].0.ln(), log);
            let at = |share: f64| law.shown((low + share * (high - low)).exp().clamp(pairs[0].0, log.exp()));
            let [a, b] = [a.min(b), a.max(b)].map(|share| at(share).unwrap());
            let is_in_order = if is_rising { a.value <= b.value } else { a.value >= b.value };
            prop_assert!(is_in_order, "{law:?}");
            prop_assert!((a.slope > 0.0) == is_rising);
        }
    }
}
