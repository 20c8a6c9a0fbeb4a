//! `cermctl characterize`: error against time, and where methods fail, as a table and a report in a folder.

mod live;
mod remaining;
mod tape;

use super::check::expect;
use super::interrupt::Interrupt;
use super::progress::Progress;
use super::{CtlError, print};
use crate::characterize::cell::Cell;
use crate::characterize::folder::Folder;
use crate::characterize::run;
use crate::characterize::sweep::Sweep;
use crate::characterize::table::{POINTS, Provenance, Row, Source};
use crate::config::{Backend, Config};
use crate::ctl::cli::Characterize;
use crate::files::{self, SETTINGS_BYTES};
use crate::pins::sim::Scene;
use crate::report;
use jiff::Timestamp;
use remaining::Remaining;
use std::path::{Path, PathBuf};

/// Characterises what was asked for.
pub fn run(arguments: &Characterize) -> Result<(), CtlError> {
    let config = arguments.config.as_deref().map(usable).transpose()?;
    let measured = match (&arguments.tape, config) {
        (Some(tape), _) => tape::run(arguments, tape),
        (None, Some(config)) if arguments.scene.is_none() && config.gpio.backend != Backend::Mock => {
            live::run(arguments, &config)
        }
        (None, config) => simulated(arguments, config),
    };
    let Folder { rows, provenance, .. } = measured?;
    report::write(&arguments.out, &rows, &provenance)?;
    let named = |name: &str| arguments.out.join(name).display().to_string();
    let (points, page) = (named(POINTS), named(report::PAGE));
    let Provenance { source, board, .. } = provenance;
    print(&format!("{page}: open it in a browser\n{points}: {} points, {source}, {board}\n", rows.len()))
}

/// A configuration that can be run.
fn usable(path: &Path) -> Result<Config, CtlError> {
    let config = Config::load(path)?;
    let findings = config.check();
    if findings.has_errors() {
        return Err(CtlError::Said(format!("{}:\n{}", path.display(), findings.errors())));
    }
    Ok(config)
}

/// What is swept, and the text that it comes from.
fn sweep(arguments: &Characterize, config: Option<Config>) -> Result<(Sweep, String), CtlError> {
    let mock = config.as_ref().and_then(|config| config.mock.clone());
    let (name, folder) = match (&arguments.scene, &config) {
        (None, Some(config)) => (mock.as_ref().map(|mock| mock.scene.clone()), config.base.clone()),
        (scene, _) => (scene.clone(), PathBuf::new()),
    };
    let name = name.unwrap_or_else(|| "pi4".to_owned());
    let scene = Scene::named(&name, &folder)?;
    // The scene of a configuration has its own parts, whatever the configuration says of them.
    let scene = match &config {
        Some(config) if arguments.scene.is_some() || mock.is_none() => {
            let kind = config.circuit.kind();
            let unfit =
                || CtlError::Said(format!("--scene: {name} cannot have the {kind} circuit of --config"));
            expect::built(scene, &config.circuit).ok_or_else(unfit)?
        }
        _ => scene,
    };
    let given = arguments
        .config
        .as_ref()
        .map(|path| files::read_text(path, SETTINGS_BYTES).map_err(CtlError::file(path)));
    let scene_text = Scene::text_of(&name, &folder)?;
    let name = named(&name, &scene_text);
    let text = given.transpose()?.unwrap_or_default() + &scene_text;
    let seed = arguments.seed.or(mock.and_then(|mock| mock.seed)).unwrap_or(scene.seed);
    let sweep = Sweep {
        name,
        scene,
        config: config.map(alone),
        methods: arguments.method.clone(),
        kinds: arguments.circuit.clone(),
        r_ohm: arguments.r.clone(),
        averages: arguments.average.clone(),
        instruments: arguments.instruments,
        seed,
    };
    Ok((sweep, text))
}

/// The name of a scene: of a file with its ending, lest it pass for the built-in one of its name, unless it is that.
fn named(name: &str, text: &str) -> String {
    let path = Path::new(name);
    let [file, stem] =
        [path.file_name(), path.file_stem()].map(|name| name.unwrap_or_default().to_string_lossy());
    let is_builtin = Scene::text_of(&stem, Path::new("")).is_ok_and(|builtin| builtin == text);
    if is_builtin { stem.into_owned() } else { file.into_owned() }
}

fn simulated(arguments: &Characterize, config: Option<Config>) -> Result<Folder, CtlError> {
    let (sweep, text) = sweep(arguments, config)?;
    let mut cells = sweep.front()?;
    if arguments.maps || sweep.is_whole() && !sweep.is_papers() {
        cells.extend(sweep.maps()?);
    }
    if cells.is_empty() {
        return Err(CtlError::said("--method: none of these works on these circuits"));
    }
    for cell in &cells {
        cell.check().map_err(CtlError::Said)?;
    }
    let provenance = provenance(Source::Simulated, sweep.name.clone(), Some(text), Some(sweep.seed));
    measure(&arguments.out, &provenance, &cells)
}

/// Measures the cells that are not in the folder yet.
fn measure(out: &Path, provenance: &Provenance, cells: &[Cell]) -> Result<Folder, CtlError> {
    let interrupt = Interrupt::new()?;
    let mut folder = Folder::open(out, provenance)?;
    let missing: Vec<Cell> = cells.iter().filter(|cell| !folder.has(&cell.asked())).cloned().collect();
    let costs = missing.iter().map(Cell::cost).collect();
    let (mut progress, mut remaining) = (Progress::new(), Remaining::new(cells.len() - missing.len(), costs));
    run::run(&missing, &|| interrupt.is_set(), |index, rows| {
        folder.add(rows)?;
        remaining.done(index);
        progress.show(|| format!("{}, {}", remaining.in_words(), missing[index]));
        Ok::<(), CtlError>(())
    })?;
    drop(progress);
    let asked: Vec<Row> = cells.iter().flat_map(Cell::asked).collect();
    folder.sort(&asked)?;
    if !folder.has(&asked) {
        let done = cells.iter().filter(|cell| folder.has(&cell.asked())).count();
        return Err(CtlError::Said(format!(
            "stopped: {done} of {} points are in {}; the same command goes on from there",
            cells.len(),
            out.display()
        )));
    }
    Ok(folder)
}

/// With its first channel only, which is commissioned: without a zero nothing stands before the sensor, as simulated pins are alike.
fn alone(mut config: Config) -> Config {
    config.channels.truncate(1);
    for channel in &mut config.channels {
        channel.zero_ohm.get_or_insert(0.0);
        channel.scale.get_or_insert(1.0);
    }
    config
}

/// Of what is begun now by this command.
fn provenance(source: Source, board: String, text: Option<String>, seed: Option<u64>) -> Provenance {
    let words = std::env::args().skip(1).map(|word| {
        let is_plain = |c: char| c.is_alphanumeric() || "-_./=,".contains(c);
        if word.chars().all(is_plain) { word } else { format!("'{}'", word.replace('\'', "'\\''")) }
    });
    let command = std::iter::once("cermctl".to_owned()).chain(words).collect::<Vec<_>>().join(" ");
    let date = Timestamp::now().strftime("%Y-%m-%dT%H:%M:%SZ").to_string();
    let version = env!("CARGO_PKG_VERSION").to_owned();
    Provenance { source, board, text, seed, version, date, command, later_commands: Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config_file::config;

    #[test]
    fn what_stands_before_a_sensor_is_kept_and_no_scene_passes_for_another() {
        let file = config(|c| c.channel("x").channel("y").set("channel.x.zero-ohm", 470.8));
        let known = alone(file.parse());
        assert_eq!((known.channels.len(), known.channels[0].zero_ohm), (1, Some(470.8)));
        let mut file = file;
        let unknown = alone(file.unset(&["channel.x.zero-ohm", "channel.x.scale"]).parse());
        assert_eq!((unknown.channels[0].zero_ohm, unknown.channels[0].scale), (Some(0.0), Some(1.0)));

        let text = Scene::text_of("pi4", Path::new("")).unwrap();
        assert_eq!(named("pi4", &text), "pi4");
        assert_eq!(named("hw/scenes/pi4.toml", &text), "pi4");
        assert_eq!(named("mine/pi4.toml", &text.replace("2.2 uF", "1 uF")), "pi4.toml");
    }
}
