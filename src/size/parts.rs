//! What there is to build from: series of values on sale, or what lies in a drawer; and what it costs.

use super::limits::{CLASSES_EUR, DRAWER_LIMIT, EXACT_EUR, FILM_EUR, GREATEST_C, LEAST_C, USUAL_EUR};
use crate::units::{Farad, Ohm, named, rounded};
use std::str::FromStr;

/// E12 (IEC 60063).
const E12: [f64; 12] = [1.0, 1.2, 1.5, 1.8, 2.2, 2.7, 3.3, 3.9, 4.7, 5.6, 6.8, 8.2];

/// The value of E96 (IEC 60063) that is nearest to one, ohm: that series is its formula, rounded to three digits.
pub fn e96(ohm: f64) -> Ohm {
    Ohm(rounded(10f64.powf((96.0 * ohm.log10()).round() / 96.0), 3))
}

/// The lowest value of E12 that is not below one, ohm.
pub fn e12_from(ohm: f64) -> Ohm {
    let decade = 10f64.powf(ohm.log10().floor());
    let values = E12.into_iter().chain([10.0]).map(|value| rounded(value * decade, 2));
    Ohm(values.into_iter().find(|value| *value >= ohm).unwrap_or(10.0 * decade))
}

/// Film capacitors on sale, smallest first.
pub fn e12_capacitors() -> Vec<Farad> {
    let all = (-8..=-5).flat_map(|power| E12.map(|value| rounded(value * 10f64.powi(power), 2)));
    all.filter(|c| (0.99 * LEAST_C..=1.01 * GREATEST_C).contains(c)).map(Farad).collect()
}

/// Where parts come from.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Stock {
    /// Whatever is sold: film capacitors of E12, resistors of E96.
    #[default]
    Shop,
    /// These capacitors and calibration resistors, as many of each as it takes; what limits a current may be bought.
    Drawer {
        /// Smallest first.
        capacitors: Vec<Farad>,
        /// Lowest first.
        resistors: Vec<Ohm>,
    },
}

impl FromStr for Stock {
    type Err = String;

    /// A drawer: `2.2uF, 680nF, 470ohm, 10kohm`.
    fn from_str(text: &str) -> Result<Stock, String> {
        let (mut capacitors, mut resistors) = (Vec::new(), Vec::new());
        for part in text.split(',').map(str::trim) {
            match (part.parse::<Farad>(), part.parse::<Ohm>()) {
                (Ok(c), _) if (1e-9..=1e-3).contains(&c.0) => capacitors.push(c),
                (_, Ok(r)) if (1.0..=1e8).contains(&r.0) => resistors.push(r),
                (Ok(_), _) => return Err(format!("{part} is no capacitor for this: 1 nF to 1 mF")),
                (_, Ok(_)) => return Err(format!("{part} is no resistor for this: 1 ohm to 100 Mohm")),
                _ => {
                    return Err(format!(
                        "\"{part}\" is neither a capacitor such as 680nF nor a resistor such as 12.7kohm"
                    ));
                }
            }
        }
        capacitors.sort_by(|a, b| a.0.total_cmp(&b.0));
        resistors.sort_by(|a, b| a.0.total_cmp(&b.0));
        capacitors.dedup();
        resistors.dedup();
        match (capacitors.len(), resistors.len()) {
            (0, _) => Err("there is no capacitor among them: one such as 470nF is needed".to_owned()),
            (_, 0 | 1) => Err("two different resistors are needed to calibrate with, such as 470ohm and \
                               12.7kohm"
                .to_owned()),
            _ => Ok(Stock::Drawer { capacitors, resistors }),
        }
    }
}

impl Stock {
    /// A resistor that limits a current, not below this; from the drawer if one there will do.
    pub fn limiting(&self, least_ohm: f64) -> Ohm {
        let there = match self {
            Stock::Shop => None,
            Stock::Drawer { resistors, .. } => {
                resistors.iter().find(|r| (least_ohm..=DRAWER_LIMIT * least_ohm).contains(&r.0)).copied()
            }
        };
        there.unwrap_or_else(|| e12_from(least_ohm))
    }

    /// Whether that does not have to be bought.
    pub fn has(&self, r: Ohm) -> bool {
        matches!(self, Stock::Drawer { resistors, .. } if resistors.contains(&r))
    }

    /// What a circuit of these costs: capacitors and calibration resistors, then those that limit a current or protect.
    pub fn price(&self, capacitors: &[Farad], usual: &[Ohm]) -> Price {
        let film = |c: &Farad| FILM_EUR.into_iter().find(|(up_to, _)| c.0 <= *up_to).map_or(0.0, |row| row.1);
        let bought = usual.iter().filter(|r| !self.has(**r)).count() as f64 * USUAL_EUR;
        let exact = match self {
            Stock::Shop => capacitors.iter().map(film).sum::<f64>() + 2.0 * EXACT_EUR,
            Stock::Drawer { .. } => 0.0,
        };
        let eur = bought + exact;
        match CLASSES_EUR {
            _ if exact == 0.0 => Price::Drawer,
            [low, _] if eur < low => Price::Low,
            [_, middle] if eur < middle => Price::Middle,
            _ => Price::High,
        }
    }
}

named! {
    /// What the parts of a circuit cost, without the sensor: single pieces, roughly.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
    Price {
        /// All that counts is there.
        Drawer = "in the drawer",
        /// Up to the first of [`CLASSES_EUR`].
        Low = "below 2 EUR",
        /// Up to the second.
        Middle = "2 to 5 EUR",
        /// More.
        High = "above 5 EUR",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_those_of_the_series() {
        for (wanted, is) in [(470.0, 475.0), (12_700.0, 12_700.0), (2_300.0, 2_320.0), (99_000.0, 100_000.0)]
        {
            assert_eq!(e96(wanted), Ohm(is));
        }
        for (least, is) in [(218.8, 220.0), (291.7, 330.0), (437.5, 470.0), (820.1, 1000.0), (470.0, 470.0)] {
            assert_eq!(e12_from(least), Ohm(is));
        }
        let all = e12_capacitors();
        assert_eq!((all.len(), all[0], all[36]), (37, Farad(10e-9), Farad(10e-6)));
        assert!(all.contains(&Farad(470e-9)) && all.contains(&Farad(2.2e-6)));
    }

    #[test]
    fn a_drawer_is_read_or_refused_with_what_is_missing() {
        let drawer: Stock = "10kohm, 680nF,470ohm,2.2 uF, 680nF".parse().unwrap();
        let Stock::Drawer { capacitors, resistors } = &drawer else { panic!() };
        assert_eq!((capacitors.len(), resistors.as_slice()), (2, &[Ohm(470.0), Ohm(10_000.0)][..]));
        assert_eq!((drawer.limiting(437.5), drawer.limiting(218.8)), (Ohm(470.0), Ohm(220.0)));
        for (wrong, says) in [
            ("470ohm,10kohm", "no capacitor among them"),
            ("470nF,10kohm", "two different resistors"),
            ("470nF,10kohm,10 kohm", "two different resistors"),
            ("470n,10kohm", "\"470n\" is neither"),
            ("", "\"\" is neither"),
            ("5 pF,1kohm,2kohm", "5 pF is no capacitor for this"),
            ("1uF,5 mohm,2kohm", "5 mohm is no resistor for this"),
        ] {
            let error = wrong.parse::<Stock>().unwrap_err();
            assert!(error.contains(says), "{wrong}: {error}");
        }
    }

    #[test]
    fn large_capacitors_cost_more_and_what_is_there_costs_nothing() {
        let price =
            |c: &[f64]| Stock::Shop.price(&c.iter().map(|c| Farad(*c)).collect::<Vec<_>>(), &[Ohm(220.0); 3]);
        assert_eq!(
            [price(&[470e-9]), price(&[2.2e-6, 680e-9]), price(&[10e-6, 680e-9])],
            [Price::Low, Price::Middle, Price::High]
        );
        let drawer: Stock = "2.2uF,470ohm,10kohm".parse().unwrap();
        assert_eq!(drawer.price(&[Farad(2.2e-6)], &[Ohm(220.0)]), Price::Drawer);
    }
}
