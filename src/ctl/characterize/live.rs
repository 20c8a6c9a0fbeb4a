//! The circuit of this machine, with one known resistor after another in the place of a sensor.

use super::provenance;
use crate::characterize::figures::{asked, filled};
use crate::characterize::folder::Folder;
use crate::characterize::limits::WARM;
use crate::characterize::table::Source;
use crate::characterize::watch::{Found, WatchSpan, watch};
use crate::config::Config;
use crate::config::backend::{self, AnyPins, OpenError};
use crate::ctl::CtlError;
use crate::ctl::calibrate::typed_line;
use crate::ctl::cli::{Characterize, known_ohm};
use crate::ctl::interrupt::Interrupt;
use crate::ctl::limits::{LIVE_AVERAGES, LIVE_MEANS, LIVE_READINGS, MISTAKEN};
use crate::estimate::scatter::median;
use crate::files::{self, SETTINGS_BYTES};
use crate::instrument::Instrument;
use crate::pins::realtime::Realtime;
use crate::pins::{Drives, Pins, kernel, monotonic};
use crate::units::{Nanos, Ohm, rough};
use std::fs;

/// Measures as long as there are resistors.
pub fn run(arguments: &Characterize, config: &Config) -> Result<Folder, CtlError> {
    let simulated =
        [("--seed", arguments.seed.is_some()), ("--instruments", arguments.instruments.is_some())];
    if let Some((option, _)) = simulated.into_iter().find(|(_, is_given)| *is_given) {
        return Err(CtlError::Said(format!("{option} is of simulated boards; name one with --scene")));
    }
    let text = arguments
        .config
        .as_deref()
        .map(|path| files::read_text(path, SETTINGS_BYTES).map_err(CtlError::file(path)));
    let board = model();
    let provenance = provenance(Source::Live, board.clone(), text.transpose()?, None);
    let _rights = Realtime::request(&config.realtime);
    let interrupt = Interrupt::new()?;
    let mut folder = Folder::open(&arguments.out, &provenance)?;
    let mut bench = Bench {
        board,
        ways: ways(arguments, config),
        open: &mut |config| backend::open(config, monotonic()).map_err(refused),
        ask: &mut typed_line,
        is_stopped: &|| interrupt.is_set(),
    };
    bench.measure_all(&arguments.r, &mut folder)?;
    Ok(folder)
}

/// The board of this machine.
fn model() -> String {
    let model = fs::read_to_string("/proc/device-tree/model").unwrap_or_default();
    let (release, _) = kernel();
    match model.trim_end_matches('\0').trim() {
        "" => format!("Linux {release}"),
        model => format!("{model}, Linux {release}"),
    }
}

fn refused(error: OpenError) -> CtlError {
    let hint = match &error {
        OpenError::Hardware(error) if error.is_held_by(backend::CONSUMER) => {
            "; `systemctl stop cermd`, then this again"
        }
        _ => "",
    };
    CtlError::Said(format!("{error}{hint}"))
}

/// The configuration with each method and mean that is asked for, and its first channel alone.
fn ways(arguments: &Characterize, config: &Config) -> Vec<Config> {
    let methods = if arguments.method.is_empty() { vec![config.method()] } else { arguments.method.clone() };
    let averages = if arguments.average.is_empty() { &LIVE_AVERAGES[..] } else { &arguments.average };
    let each = methods.into_iter().flat_map(|method| averages.iter().map(move |average| (method, *average)));
    each.map(|(method, average)| {
        let mut config = config.clone();
        config.channels.truncate(1);
        // How often is what is characterised.
        (config.measure.rate_hz, config.measure.idle) = (None, false);
        config.measure.method = Some(method);
        config.measure.average = Some(average).filter(|average| *average > Nanos::ZERO);
        config
    })
    .collect()
}

/// What resistors are measured with.
struct Bench<'a> {
    board: String,
    ways: Vec<Config>,
    open: &'a mut dyn FnMut(&Config) -> Result<AnyPins, CtlError>,
    /// The next line that is typed, after a question; `None`: there is none any more.
    ask: &'a mut dyn FnMut(&str) -> Result<Option<String>, CtlError>,
    is_stopped: &'a dyn Fn() -> bool,
}

impl Bench<'_> {
    /// Those that are given, or as many as are typed.
    fn measure_all(&mut self, given: &[f64], folder: &mut Folder) -> Result<(), CtlError> {
        let channel = self.ways.first().and_then(|config| config.channels.first());
        let place = format!("in the place of {}'s sensor", channel.map_or("", |channel| &channel.id));
        for r_ohm in given {
            let question = format!("{:.6} {place}, then Enter (s: leave it out) ", Ohm(*r_ohm));
            while let Some(answer) = self.answer(&question)? {
                if answer.trim() == "s" || self.measure(*r_ohm, folder)? {
                    break;
                }
            }
        }
        let question = format!("ohm of the resistor {place}, as measured, such as 997.3 (Enter: no more) ");
        while given.is_empty() {
            let answer = self.answer(&question)?.unwrap_or_default();
            match known_ohm(answer.trim()) {
                _ if answer.trim().is_empty() => break,
                Ok(r_ohm) => drop(self.measure(r_ohm, folder)?),
                Err(wanted) => eprintln!("not taken: {wanted}"),
            }
        }
        let nothing = || CtlError::said("nothing was measured: no resistor was there, or none was typed");
        if folder.rows.is_empty() { Err(nothing()) } else { Ok(()) }
    }

    fn answer(&mut self, question: &str) -> Result<Option<String>, CtlError> {
        let answer = (self.ask)(question)?;
        self.goes_on().map(|()| answer)
    }

    fn goes_on(&self) -> Result<(), CtlError> {
        let stopped = "stopped; what was measured is kept, and the same command goes on from there";
        if (self.is_stopped)() { Err(CtlError::said(stopped)) } else { Ok(()) }
    }

    /// Whether it was there; says so if not.
    fn measure(&mut self, r_ohm: f64, folder: &mut Folder) -> Result<bool, CtlError> {
        for index in 0..self.ways.len() {
            let config = &self.ways[index];
            let row = asked(Source::Live, &self.board, config, r_ohm);
            if folder.has(std::slice::from_ref(&row)) {
                eprintln!("{:.6} by {} is in the table already", Ohm(r_ohm), row.method);
                continue;
            }
            let pins = (self.open)(config)?;
            let found = self.watch(pins, config, r_ohm)?;
            self.goes_on()?;
            if let Some(doubt) = doubt(&found, r_ohm) {
                eprintln!("not taken: {doubt}");
                return Ok(false);
            }
            let row = filled(row, &[found], false);
            let says = |name, value: Option<f64>| {
                value.map_or(String::new(), |value| format!("  {name} {}", rough(value, "ohm")))
            };
            let mean = row.average_s.map_or("each reading".to_owned(), |s| format!("means over {s} s"));
            eprintln!("  {}, {mean}:{}{}", row.method, says("error", row.rms_ohm), says("u", row.u_ohm));
            folder.add(vec![row])?;
        }
        Ok(true)
    }

    fn watch(&self, pins: AnyPins, config: &Config, r_ohm: f64) -> Result<Found, CtlError> {
        let settings = config.settings().map_err(CtlError::said)?;
        let readings = if settings.average.is_some() { LIVE_MEANS } else { LIVE_READINGS };
        let channel = settings.channels[0].clone();
        let mut instrument = Instrument::new(pins, settings);
        let start = instrument.pins().now();
        let asked = WatchSpan { channel, start, from: Some(start + WARM), until: Nanos::MAX, readings };
        let found = watch(&mut instrument, &asked, |_, _| r_ohm, || !(self.is_stopped)());
        // Whatever came of it: the last resistor sinks until the next charge.
        let released = instrument.pins().drive(Drives::NONE);
        let found = found.map_err(CtlError::said)?;
        released.map(|_| found).map_err(CtlError::said)
    }
}

/// Why that is not the resistor.
fn doubt(found: &Found, r_ohm: f64) -> Option<String> {
    let mut errors: Vec<f64> =
        found.told.iter().filter_map(|told| told.what.as_ref().ok()).map(|number| number.error_ohm).collect();
    if 2 * errors.len() <= found.told.len() {
        let reason = found.told.iter().rev().find_map(|told| told.what.err()).unwrap_or("nothing");
        return Some(format!("the channel reads {reason}; is the resistor of {:.6} there?", Ohm(r_ohm)));
    }
    let error = median(&mut errors);
    let [share, least] = MISTAKEN;
    (error.abs() > share * r_ohm + least).then(|| {
        format!(
            "the channel reads {}; is the resistor of {:.6} there?",
            rough(r_ohm + error, "ohm"),
            Ohm(r_ohm)
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::characterize::table::{POINTS, Provenance, Row};
    use crate::config_file::config;
    use crate::pins::sim::{Scene, Sensor, SimPins};
    use std::path::Path;

    /// What is typed, one answer after the other, and what comes of it when these resistors are on the bench, one for each
    /// instrument that is made.
    fn on_the_bench(
        folder: &Path,
        given: &[f64],
        typed: &[&str],
        there: &[f64],
        is_stopped: bool,
    ) -> Result<Vec<Row>, CtlError> {
        let provenance = provenance(Source::Live, "bench".to_owned(), None, None);
        let mut folder = Folder::open(folder, &Provenance { date: String::new(), ..provenance }).unwrap();
        let (mut typed, mut there) = (typed.iter(), there.iter());
        let mut bench = Bench {
            board: "bench".to_owned(),
            ways: vec![
                config(|c| c.channel("thumb").set("mock.scene", "pi4").set("circuit.v-th", "1.1 V")).parse(),
            ],
            open: &mut |_| {
                let sensor = Sensor::Constant(Ohm(*there.next().unwrap()));
                let scene = Scene::builtin("pi4").unwrap().with_sensors(vec![sensor]).unwrap();
                Ok(Box::new(SimPins::new(&scene, Some(crate::seed::seed(1)))))
            },
            ask: &mut |_| Ok(typed.next().map(|text| format!("{text}\n"))),
            is_stopped: &|| is_stopped,
        };
        bench.measure_all(given, &mut folder)?;
        assert!(there.next().is_none(), "a resistor was not asked for");
        Ok(folder.rows)
    }

    #[test]
    fn resistors_are_asked_for_one_after_the_other_until_each_is_there() {
        let folder = tempfile::tempdir().unwrap();
        // The second one is forgotten at first, the third one left out.
        let rows = on_the_bench(
            folder.path(),
            &[1000.0, 4700.0, 47.0],
            &["", "", "", "s"],
            &[1000.0, 1e7, 4700.0],
            false,
        )
        .unwrap();
        assert_eq!(rows.iter().map(|row| row.r_ohm).collect::<Vec<_>>(), [1000.0, 4700.0]);
        for row in &rows {
            let (rms, u) = (row.rms_ohm.unwrap(), row.u_ohm.unwrap());
            assert!(rms < 2.0 * u && u < 0.002 * row.r_ohm, "{row:?}");
            assert!(row.published_s.unwrap() > 0.0 && row.seed.is_none(), "{row:?}");
        }
        // Those that are there are not measured again.
        let typed = ["1000", "100 ohm", "much", ""];
        let rows = on_the_bench(folder.path(), &[], &typed, &[100.0], false).unwrap();
        assert_eq!(rows.len(), 3);
        let text = fs::read_to_string(folder.path().join(POINTS)).unwrap();
        assert_eq!(text.lines().count(), 4, "{text}");
    }

    #[test]
    fn nothing_is_no_success_and_nobody_is_measured_for_who_has_stopped() {
        for (given, typed, is_stopped, says) in [
            (&[][..], &[][..], false, "nothing was measured"),
            (&[1000.0], &["s"], false, "nothing was measured"),
            (&[], &["1000"], true, "stopped; what was measured is kept"),
            (&[1000.0], &[""], true, "stopped; what was measured is kept"),
        ] {
            let folder = tempfile::tempdir().unwrap();
            let said = on_the_bench(folder.path(), given, typed, &[], is_stopped).unwrap_err().to_string();
            assert!(said.starts_with(says), "{given:?} {typed:?}: {said}");
        }
    }
}
