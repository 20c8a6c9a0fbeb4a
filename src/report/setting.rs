//! A method on a circuit: what has one line in a figure.

use super::axis::{farads, ohms};
use super::mark::{Filling, Ink, Mark};
use crate::characterize::table::{Row, Vary};
use crate::circuit::Kind;
use crate::reading::Method;
use crate::units::rounded;

/// The colour of a method.
pub fn ink(method: Method) -> Ink {
    Ink(method as usize)
}

/// How something was read, whatever was read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting {
    pub method: Method,
    pub kind: Kind,
    pub c_f: [Option<f64>; 2],
    pub r_c_ohm: [f64; 2],
}

impl Setting {
    /// With the capacitors that it was measured with.
    pub fn of(row: &Row) -> Setting {
        let (c_f, r_c_ohm) = ([row.c_a_f, row.c_b_f], [row.r_c1_ohm, row.r_c2_ohm]);
        Setting { method: row.method, kind: row.circuit, c_f, r_c_ohm }
    }

    /// Where their size is what is varied, with those of the scene.
    pub fn nominal(row: &Row) -> Setting {
        let times = row.vary_value.filter(|_| row.vary == Some(Vary::Capacitor)).unwrap_or(1.0);
        let actual = Setting::of(row);
        Setting { c_f: actual.c_f.map(|c| c.map(|c| rounded(c / times, 6))), ..actual }
    }

    /// Each once, by method, in the order in which they are met.
    pub fn all(settings: impl Iterator<Item = Setting>) -> Vec<Setting> {
        let mut all: Vec<Setting> = Vec::new();
        for setting in settings {
            if !all.contains(&setting) {
                all.push(setting);
            }
        }
        all.sort_by_key(|setting| setting.method as usize);
        all
    }

    /// Its capacitors.
    pub fn circuit(&self) -> String {
        let known: Vec<String> = self.c_f.iter().flatten().map(|c| farads(*c)).collect();
        let series = if self.kind == Kind::SeriesCalibration { " (Rc in series)" } else { "" };
        if known.is_empty() { self.kind.to_string() } else { known.join(" / ") + series }
    }

    /// Its name among others: resistors only where they tell it apart.
    pub fn name(&self, others: &[Setting]) -> String {
        let mut name = format!("{}, {}", self.method, self.circuit());
        let is_twin = |other: &&Setting| {
            (other.method, other.kind, other.c_f) == (self.method, self.kind, self.c_f) && *other != self
        };
        if others.iter().find(is_twin).is_some() {
            let [r_c1, r_c2] = self.r_c_ohm.map(ohms);
            name += &format!(", Rc {r_c1} / {r_c2}");
        }
        name
    }

    /// The class of its colour: one for each method.
    pub fn ink(&self) -> Ink {
        ink(self.method)
    }

    /// Its shape: one for each circuit of a method.
    pub fn mark(&self, others: &[Setting]) -> (Mark, Filling) {
        let same = others.iter().filter(|other| other.method == self.method);
        let index = same.take_while(|other| *other != self).count();
        let is_hollow = index >= Mark::ROUND.len();
        let filling = if is_hollow { Filling::Hollow } else { Filling::Full };
        (Mark::ROUND[index % Mark::ROUND.len()], filling)
    }
}

/// The resistances of these rows, each once, from the lowest on, ohm.
pub fn resistances<'a>(rows: impl Iterator<Item = &'a Row>) -> Vec<f64> {
    let mut all: Vec<f64> = rows.map(|row| row.r_ohm).collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

#[cfg(test)]
mod tests {
    use super::super::fixture;
    use super::*;

    #[test]
    fn settings_that_differ_have_names_that_differ() {
        let row = fixture::row(Method::Tpcm, 1000.0);
        let one = Row { circuit: Kind::OneCapacitor, c_a_f: Some(470e-9), c_b_f: None, ..row.clone() };
        let series = Row { circuit: Kind::SeriesCalibration, ..one.clone() };
        let other = Row { r_c1_ohm: 1000.0, ..one.clone() };
        let large =
            Row { vary: Some(Vary::Capacitor), vary_value: Some(3.0), c_a_f: Some(1.41e-6), ..one.clone() };
        let settings = Setting::all([row, one, series, other, large].iter().map(Setting::nominal));
        let names: Vec<String> = settings.iter().map(|setting| setting.name(&settings)).collect();
        assert_eq!(
            names,
            [
                "tpcm, 2.2 uF / 680 nF",
                "tpcm, 470 nF, Rc 470 ohm / 12.7 kohm",
                "tpcm, 470 nF (Rc in series)",
                "tpcm, 470 nF, Rc 1 kohm / 12.7 kohm"
            ]
        );
    }
}
