//! The table of a sweep: `points.csv`, one row for each cell, and `provenance.json`, where they come from.

use super::limits::DIGITS;
use crate::circuit::{Kind, Network};
use crate::reading::Method;
use crate::units::{Farad, named, rounded};
use serde::{Deserialize, Serialize};

/// The names of the files in the folder of a sweep.
pub const POINTS: &str = "points.csv";
/// See there.
pub const PROVENANCE: &str = "provenance.json";

named! {
    /// What was measured.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    Source {
        /// A simulated board, in virtual time.
        Simulated = "simulated",
        /// The board of this machine.
        Live = "live",
        /// Timings that were recorded.
        Tape = "tape",
    }
}

named! {
    /// What a cell has other than its scene, by the amount in `vary_value` or the name in `vary_name`.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    Vary {
        /// Jitter of stamps, s.
        Jitter = "jitter",
        /// A given latency offset that is wrong by so much, s.
        OffsetError = "offset-error",
        /// Every capacitor, times so much.
        Capacitor = "capacitor",
        /// A resistance from each sense node to ground, ohm.
        Leakage = "leakage",
        /// A sensor whose resistance changes by such a share of itself in a second, 1/s.
        Speed = "speed",
        /// An effect of the scene that is switched off: its name.
        Without = "without",
        /// The readings up to so long after the start, from the row before on, s.
        SinceStart = "since-start",
        /// CERM infers at all resistances, by the first line of eq. (19): the switch, as a part of T_xA.
        SwitchFraction = "switch-fraction",
    }
}

/// What came of a cell. Absent: unknown. Errors are those of readings with a number; where the sensor does not move, a number that
/// says so has seen a late stamp, is counted in `moving`, and is not among the errors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// What was measured.
    pub source: Source,
    /// The name of the scene, of the configuration, or of the tape.
    pub scene: String,
    /// Of the first instrument; each one has the next.
    pub seed: Option<u64>,
    /// How it is wired.
    pub circuit: Kind,
    /// The capacitor at node A, farad.
    pub c_a_f: Option<f64>,
    /// That at node B, farad; absent where there is one.
    pub c_b_f: Option<f64>,
    /// The lower calibration resistor, ohm.
    pub r_c1_ohm: f64,
    /// The other one, ohm.
    pub r_c2_ohm: f64,
    /// How it was read.
    pub method: Method,
    /// What is published is the mean over so long, s; absent: each reading.
    pub average_s: Option<f64>,
    /// What is other than the scene says; absent: nothing.
    pub vary: Option<Vary>,
    /// By how much; see [`Vary`] for the unit.
    pub vary_value: Option<f64>,
    /// Which, where it is a name.
    pub vary_name: Option<String>,
    /// The truth, ohm; of a moving sensor its middle.
    pub r_ohm: f64,
    /// How many instruments, each of another seed.
    pub instruments: u64,
    /// How many published readings, of all of them.
    pub readings: u64,
    /// The share of readings without a number.
    pub no_number: f64,
    /// The most frequent reason for that: `open`, `short`, or the name of a fault.
    pub reason: Option<String>,
    /// The share of readings whose u is still a prior.
    pub settling: f64,
    /// The share of readings that say that the sensor moves.
    pub moving: f64,
    /// The mean error, ohm.
    pub bias_ohm: Option<f64>,
    /// Standard deviation of errors about it, ohm.
    pub sd_ohm: Option<f64>,
    /// Root mean square error, ohm.
    pub rms_ohm: Option<f64>,
    /// Eq. (28): the largest error of an instrument's readings, ohm, the mean over instruments.
    pub mae_ohm: Option<f64>,
    /// Eq. (29): that in percent of the truth.
    pub mre_percent: Option<f64>,
    /// Root mean square of the stated u, 1 sigma, ohm.
    pub u_ohm: Option<f64>,
    /// The share of numbers that are off by less than twice their u.
    pub coverage: Option<f64>,
    /// Time for each published reading, everything included, mean, s: the sum of the four that follow.
    pub published_s: Option<f64>,
    /// Of it: charges, drains and pauses before discharges of sensors, s.
    pub charge_s: Option<f64>,
    /// Discharges of sensors until their last crossing, s.
    pub discharge_s: Option<f64>,
    /// Calibration discharges with their charges, and looks for a leak, s.
    pub calibration_s: Option<f64>,
    /// What is left: calls, waking, computing, waiting, s.
    pub overhead_s: Option<f64>,
    /// No unbiased estimate from the discharges that were taken is better (Cramer-Rao), calibration known exactly; of a mean
    /// that of all its discharges, ohm, 1 sigma.
    pub bound_ohm: Option<f64>,
    /// Where the switch is what is varied: standard deviation of the inferred crossing T_i,xA (16) of an instrument, as a
    /// part of its mean; root mean square over instruments.
    pub t_ixa_rsd: Option<f64>,
    /// The same of T_i,xB (18).
    pub t_ixb_rsd: Option<f64>,
    /// The same of T_c2A, the crossing of A through R_2 that they were inferred with.
    pub t_c2a_rsd: Option<f64>,
}

impl Row {
    /// What is asked of a circuit with these calibration resistors as it is; nothing is known yet.
    pub fn asked(
        source: Source,
        scene: &str,
        circuit: Kind,
        r_c_ohm: [f64; 2],
        method: Method,
        r_ohm: f64,
    ) -> Row {
        Row {
            source,
            scene: scene.to_owned(),
            seed: None,
            circuit,
            c_a_f: None,
            c_b_f: None,
            r_c1_ohm: r_c_ohm[0],
            r_c2_ohm: r_c_ohm[1],
            method,
            average_s: None,
            vary: None,
            vary_value: None,
            vary_name: None,
            r_ohm,
            instruments: 1,
            readings: 0,
            no_number: 0.0,
            reason: None,
            settling: 0.0,
            moving: 0.0,
            bias_ohm: None,
            sd_ohm: None,
            rms_ohm: None,
            mae_ohm: None,
            mre_percent: None,
            u_ohm: None,
            coverage: None,
            published_s: None,
            charge_s: None,
            discharge_s: None,
            calibration_s: None,
            overhead_s: None,
            bound_ohm: None,
            t_ixa_rsd: None,
            t_ixb_rsd: None,
            t_c2a_rsd: None,
        }
    }

    /// With the capacitors of a circuit.
    pub fn with_capacitors(self, mut network: Network) -> Row {
        let (c_a, c_b) = network.capacitors();
        let farad = |c: &mut Farad| Some(rounded(c.0, DIGITS));
        Row { c_a_f: farad(c_a), c_b_f: c_b.and_then(farad), ..self }
    }

    /// The share of readings that its errors are of.
    pub fn counted(&self) -> f64 {
        let moving = if self.vary == Some(Vary::Speed) { 0.0 } else { self.moving };
        (1.0 - self.no_number - moving).max(0.0)
    }

    /// Time for each of those, everything included, mean, s.
    pub fn counted_s(&self) -> Option<f64> {
        self.published_s.map(|seconds| seconds / self.counted()).filter(|seconds| seconds.is_finite())
    }

    /// Whether both answer the same question.
    pub fn is_same_cell(&self, other: &Row) -> bool {
        let with_figures_of_other = Row {
            source: self.source,
            scene: self.scene.clone(),
            seed: self.seed,
            circuit: self.circuit,
            c_a_f: self.c_a_f,
            c_b_f: self.c_b_f,
            r_c1_ohm: self.r_c1_ohm,
            r_c2_ohm: self.r_c2_ohm,
            method: self.method,
            average_s: self.average_s,
            vary: self.vary,
            vary_value: self.vary_value,
            vary_name: self.vary_name.clone(),
            r_ohm: self.r_ohm,
            instruments: self.instruments,
            ..other.clone()
        };
        with_figures_of_other == *other
    }
}

/// Why a table cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// It has other columns, or words where numbers are to be.
    #[error(transparent)]
    Csv(#[from] csv::Error),
    /// A number that nothing measured can have.
    #[error("line {line}: {column} cannot be {text}")]
    Number {
        /// In the file, from 1 on.
        line: u64,
        /// Its name.
        column: String,
        /// What stands there.
        text: String,
    },
}

/// The columns with any words.
const WORDS: [&str; 3] = ["scene", "vary_name", "reason"];

/// Rows of a table from its text; an unfinished last row, of a writer that was killed, is left out.
///
/// # Errors
/// Which row cannot be read, and why.
pub fn read(text: &str) -> Result<Vec<Row>, TableError> {
    let whole = text.rfind('\n').map_or("", |end| &text[..=end]);
    let mut reader = csv::Reader::from_reader(whole.as_bytes());
    let names = reader.headers()?.clone();
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record?;
        let is_odd = |(name, text): &(&str, &str)| {
            let is_wrong = |value: f64| !value.is_finite() || (*name == "r_ohm" && value <= 0.0);
            !WORDS.contains(name) && text.parse().is_ok_and(is_wrong)
        };
        if let Some((column, text)) = names.iter().zip(&record).find(is_odd) {
            let line = record.position().map_or(0, csv::Position::line);
            return Err(TableError::Number { line, column: column.to_owned(), text: text.to_owned() });
        }
        rows.push(record.deserialize(Some(&names))?);
    }
    Ok(rows)
}

/// Rows as text, their line of names first if it is wanted.
///
/// # Errors
/// Never, as far as is known: every field has a text.
pub fn text(rows: &[Row], with_names: bool) -> Result<String, csv::Error> {
    let mut writer = csv::WriterBuilder::new().has_headers(with_names).from_writer(Vec::new());
    rows.iter().try_for_each(|row| writer.serialize(row))?;
    let bytes = writer.into_inner().map_err(|error| error.into_error())?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Where a table comes from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// What was measured.
    pub source: Source,
    /// The board: the name of the scene, or the model of the machine with its chip of lines.
    pub board: String,
    /// The whole text of the scene and of the configuration; of a tape how it begins and ends.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub text: Option<String>,
    /// Of the first instrument of each cell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Of this program.
    pub version: String,
    /// When it was begun, RFC 3339.
    pub date: String,
    /// The command line that has begun it.
    pub command: String,
    /// Those that have gone on with it, each once: all of them together make it again.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub later_commands: Vec<String>,
}

impl Provenance {
    /// All command lines, in the order in which they came.
    pub fn commands(&self) -> impl Iterator<Item = &String> {
        std::iter::once(&self.command).chain(&self.later_commands)
    }

    /// Whether all of it is of a simulated board, read as its parts tell and no configuration.
    pub fn is_of_a_scene_alone(&self) -> bool {
        let is_config = |word: &str| word == "--config" || word.starts_with("--config=");
        self.source == Source::Simulated && !self.commands().any(|line| line.split(' ').any(is_config))
    }

    /// What keeps the rows of both out of one table; `None`: nothing.
    pub fn differs(&self, other: &Provenance) -> Option<String> {
        let seed = |of: &Provenance| of.seed.map_or("none".to_owned(), |seed| seed.to_string());
        let pairs = [
            ("source", self.source.to_string(), other.source.to_string()),
            ("board", self.board.clone(), other.board.clone()),
            ("seed", seed(self), seed(other)),
            ("version", self.version.clone(), other.version.clone()),
        ];
        let named = pairs.into_iter().find(|(_, own, others)| own != others);
        let named = named.map(|(what, own, others)| format!("{what} {own}, not {others}"));
        named.or_else(|| (self.text != other.text).then(|| "another scene, configuration or tape".to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row() -> Row {
        let (kind, method) = (Kind::TwoCapacitor, Method::Tracked);
        Row {
            seed: Some(1),
            c_a_f: Some(2.2e-6),
            vary: Some(Vary::Without),
            vary_name: Some("jitter".to_owned()),
            instruments: 20,
            readings: 400,
            no_number: 0.25,
            moving: 0.5,
            bias_ohm: Some(-0.125),
            sd_ohm: Some(1.0),
            u_ohm: Some(1e-9),
            coverage: Some(0.95),
            published_s: Some(0.5),
            bound_ohm: Some(0.5),
            ..Row::asked(Source::Simulated, "pi4, mine", kind, [470.0, 12_700.0], method, 16_200.0)
        }
    }

    #[test]
    fn a_table_is_read_as_it_was_written() {
        let other = Row { vary: None, vary_name: None, seed: None, reason: Some("open".to_owned()), ..row() };
        let rows = [row(), other];
        let text = text(&rows, true).unwrap();
        assert!(text.starts_with("source,scene,seed,circuit,c_a_f,"), "{text}");
        assert_eq!(read(&text).unwrap(), rows);
        // The writer was killed in the middle of a row.
        assert_eq!(read(&text[..text.len() - 20]).unwrap(), rows[..1]);
        let wrong = text.replace("two-capacitor", "three-capacitor");
        assert!(read(&wrong).unwrap_err().to_string().contains("three-capacitor"));
        let named = Row { scene: "inf".to_owned(), ..row() };
        assert_eq!(read(&super::text(std::slice::from_ref(&named), true).unwrap()).unwrap(), [named]);
    }

    #[test]
    fn numbers_that_nothing_measured_has_are_refused_and_named() {
        for (row, says) in [
            (Row { rms_ohm: Some(f64::NAN), ..row() }, "line 2: rms_ohm cannot be NaN"),
            (Row { published_s: Some(f64::INFINITY), ..row() }, "line 2: published_s cannot be inf"),
            (Row { r_ohm: 0.0, ..row() }, "line 2: r_ohm cannot be 0.0"),
            (Row { r_ohm: -5.0, ..row() }, "line 2: r_ohm cannot be -5.0"),
        ] {
            assert_eq!(read(&text(&[row], true).unwrap()).unwrap_err().to_string(), says);
        }
    }

    #[test]
    fn cells_are_told_apart_by_what_was_asked() {
        let same = Row { rms_ohm: Some(3.0), readings: 7, reason: Some("short".to_owned()), ..row() };
        assert!(row().is_same_cell(&same));
        for other in [
            Row { r_ohm: 100.0, ..row() },
            Row { average_s: Some(1.0), ..row() },
            Row { vary_name: Some("tails".to_owned()), ..row() },
            Row { instruments: 2, ..row() },
        ] {
            assert!(!row().is_same_cell(&other));
        }
    }
}
