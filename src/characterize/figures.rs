//! From what instruments said to the rows of a table.

use super::cell::Cell;
use super::change::Change;
use super::limits::{DIGITS, SINCE_START};
use super::table::{Row, Source, Vary};
use super::watch::{Deviation, Found, Observation};
use crate::config::Config;
use crate::units::sample::{mean, rms};
use crate::units::{Nanos, rounded};
use std::collections::BTreeMap;

/// What is asked of the circuit of a configuration: a row without figures.
pub fn asked(source: Source, scene: &str, config: &Config, r_ohm: f64) -> Row {
    let (circuit, method) = (&config.circuit, config.method());
    let r_c_ohm = [circuit.r_c1.0, circuit.r_c2.0];
    let average_s = config.average().map(Nanos::as_seconds);
    let row =
        Row::asked(source, scene, circuit.kind(), r_c_ohm, method, r_ohm).with_capacitors(circuit.network);
    Row { average_s, ..row }
}

impl Cell {
    /// What is asked: its rows without their figures.
    pub fn asked(&self) -> Vec<Row> {
        let mut config = self.config.clone();
        if let Some(change) = self.change {
            change.apply(self.scene.clone(), &mut config);
        }
        let network = config.circuit.network;
        let columns = self.change.map(Change::columns);
        let row = Row {
            seed: Some(self.seed),
            vary: columns.as_ref().map(|columns| columns.0),
            vary_value: columns.as_ref().and_then(|columns| columns.1),
            vary_name: columns.and_then(|columns| columns.2),
            instruments: self.instruments,
            ..asked(Source::Simulated, &self.name, &self.config, self.r_ohm).with_capacitors(network)
        };
        match self.change {
            Some(Change::SinceStart) => {
                SINCE_START.map(|end| Row { vary_value: Some(end), ..row.clone() }).into()
            }
            _ => vec![row],
        }
    }

    /// Its rows.
    pub fn rows(&self, found: &[Found]) -> Vec<Row> {
        let rows = self.asked();
        let is_moving = matches!(self.change, Some(Change::Speed(_)));
        if rows.len() == 1 {
            return rows.into_iter().map(|row| filled(row, found, is_moving)).collect();
        }
        let mut from = Nanos::ZERO;
        let within = |row: Row| {
            let until = Nanos::from_seconds(row.vary_value.unwrap_or_default());
            let stretch = |told: &&Observation| (from..until).contains(&told.at);
            let part = |found: &Found| Found {
                told: found.told.iter().filter(stretch).copied().collect(),
                ..Found::default()
            };
            let parts: Vec<Found> = found.iter().map(part).collect();
            from = until;
            filled(row, &parts, is_moving)
        };
        rows.into_iter().map(within).collect()
    }
}

/// A row with the figures of instruments. Where the sensor does not move, a number that says so has seen a late stamp: it counts
/// as that, and not among the errors.
pub fn filled(row: Row, found: &[Found], is_moving: bool) -> Row {
    let told = || found.iter().flat_map(|found| &found.told);
    let counts = |number: &&Deviation| is_moving || !number.is_moving;
    let of = |found: &Found| -> Vec<Deviation> {
        found.told.iter().filter_map(|told| told.what.as_ref().ok()).filter(counts).copied().collect()
    };
    let by_instrument: Vec<Vec<Deviation>> = found.iter().map(of).collect();
    let numbers = by_instrument.concat();
    let readings = told().count();
    let share = |is: &dyn Fn(&Deviation) -> bool| {
        let count = told().filter(|told| told.what.as_ref().is_ok_and(is)).count();
        rounded(count as f64 / readings.max(1) as f64, DIGITS)
    };
    let errors: Vec<f64> = numbers.iter().map(|number| number.error_ohm).collect();
    let bias = mean(&errors);
    let largest =
        |numbers: &Vec<Deviation>| numbers.iter().map(|number| number.error_ohm.abs()).reduce(f64::max);
    let mae = mean(&by_instrument.iter().filter_map(largest).collect::<Vec<_>>());
    let stated: Vec<(f64, f64)> =
        numbers.iter().filter_map(|number| Some((number.error_ohm, number.u_ohm?))).collect();
    let within: Vec<f64> =
        stated.iter().map(|(error, u)| f64::from(u8::from(error.abs() <= 2.0 * u))).collect();
    let bounds: Option<Vec<f64>> = numbers.iter().map(|number| number.bound_ohm).collect();
    let figure = |value: Option<f64>| value.map(|value| rounded(value, DIGITS));
    let [t_ixa_rsd, t_ixb_rsd, t_c2a_rsd] = [0, 1, 2].map(|part| {
        let known = found.iter().filter(|_| row.vary == Some(Vary::SwitchFraction));
        figure(rms(known.filter_map(|found| relative(found.inferred_ns.iter().map(|times| times[part])))))
    });
    let row = Row {
        readings: readings as u64,
        no_number: rounded(1.0 - share(&|_| true), DIGITS),
        reason: most_frequent(told().filter_map(|told| told.what.err())).map(str::to_owned),
        settling: share(&|number| number.is_settling),
        moving: share(&|number| number.is_moving),
        bias_ohm: figure(bias),
        sd_ohm: figure(bias.and_then(|bias| rms(errors.iter().map(|error| error - bias)))),
        rms_ohm: figure(rms(errors.iter().copied())),
        mae_ohm: figure(mae),
        mre_percent: figure(mae.map(|mae| 100.0 * mae / row.r_ohm)),
        u_ohm: figure(rms(stated.iter().map(|(_, u)| *u))),
        coverage: figure(mean(&within)),
        bound_ohm: figure(bounds.and_then(|bounds| rms(bounds.into_iter()))),
        t_ixa_rsd,
        t_ixb_rsd,
        t_c2a_rsd,
        ..row
    };
    timed(row, found)
}

/// With where the time of a reading goes.
fn timed(row: Row, found: &[Found]) -> Row {
    let per_reading = |of: fn(&Found) -> f64| {
        let sum: f64 = found.iter().map(of).sum();
        (row.readings > 0).then(|| sum / row.readings as f64)
    };
    let parts = [
        per_reading(|found| found.times.charge_s),
        per_reading(|found| found.times.discharge_s),
        per_reading(|found| found.times.calibration_s),
        per_reading(|found| found.times.overhead_s),
    ];
    let whole = parts.iter().copied().sum::<Option<f64>>().filter(|whole| *whole > 0.0);
    let [charge_s, discharge_s, calibration_s, overhead_s] =
        parts.map(|part| part.filter(|_| whole.is_some()).map(|part| rounded(part, DIGITS)));
    let published_s = whole.map(|whole| rounded(whole, DIGITS));
    Row { published_s, charge_s, discharge_s, calibration_s, overhead_s, ..row }
}

/// The means of blocks of this length, from the readings as they came; of their u nothing is known.
pub fn blocks(found: &Found, length: Nanos) -> Found {
    let first = found.told.first().map_or(Nanos::ZERO, |told| told.at);
    let block = |told: &Observation| (told.at - first).0 / length.0.max(1);
    let last = found.told.last().map_or(0, block);
    let mean_of = |told: &[Observation]| {
        let numbers = || told.iter().filter_map(|told| told.what.as_ref().ok());
        // As in a row, what says of a resting sensor that it moves is not among the others.
        let number = |is_moving: bool| {
            let own = numbers().filter(|number| number.is_moving == is_moving);
            let error_ohm = mean(&own.map(|number| number.error_ohm).collect::<Vec<_>>())?;
            Some(Deviation { error_ohm, is_moving, ..Deviation::default() })
        };
        let reason = || most_frequent(told.iter().filter_map(|told| told.what.err())).unwrap_or_default();
        Observation { at: told[0].at, what: number(false).or_else(|| number(true)).ok_or_else(reason) }
    };
    let blocks = found.told.chunk_by(|one, next| block(one) == block(next));
    // The last one is not whole.
    let told = blocks.filter(|told| block(&told[0]) < last).map(mean_of).collect();
    Found { told, ..Found::default() }
}

/// The standard deviation as a part of the mean.
fn relative(values: impl Iterator<Item = f64> + Clone) -> Option<f64> {
    let mean = mean(&values.clone().collect::<Vec<_>>())?;
    rms(values.map(|value| value / mean - 1.0))
}

fn most_frequent(reasons: impl Iterator<Item = &'static str>) -> Option<&'static str> {
    let mut counts = BTreeMap::new();
    reasons.for_each(|reason| *counts.entry(reason).or_insert(0u64) += 1);
    counts.into_iter().max_by_key(|(_, count)| *count).map(|(reason, _)| reason)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_is_the_mean_of_what_rests_or_says_why_it_is_none() {
        let number = |error_ohm: f64, is_moving: bool| {
            Ok(Deviation { error_ohm, is_moving, u_ohm: Some(1.0), ..Deviation::default() })
        };
        let what = [
            [number(1.0, false), number(3.0, false), number(90.0, true)],
            [number(90.0, true), Err("open"), number(70.0, true)],
            [Err("open"), Err("leakage"), Err("leakage")],
            // The last one is not whole.
            [number(5.0, false); 3],
        ];
        let at = |index: usize| Nanos(index as i64);
        let told =
            what.concat().into_iter().enumerate().map(|(index, what)| Observation { at: at(index), what });
        let found = blocks(&Found { told: told.collect(), ..Found::default() }, Nanos(3));
        let moving =
            |error_ohm: f64, is_moving: bool| Ok(Deviation { error_ohm, is_moving, ..Deviation::default() });
        let blocks: Vec<_> = found.told.iter().map(|told| told.what).collect();
        assert_eq!(blocks, [moving(2.0, false), moving(80.0, true), Err("leakage")]);
    }
}
