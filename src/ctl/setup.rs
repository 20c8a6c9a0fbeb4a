//! `cermctl setup`: from wires to the first reading, a step at a time; each can be taken back.

mod draft;
mod service;

use super::limits::{LOOK_AROUND, STARTED};
use super::stream::Stream;
use super::{CtlError, calibrate, check, get, print};
use crate::ctl::cli::{self, CalibrateBy, Setup, Update, Zero};
use crate::files;
use crate::pins::chardev::{self, ChipListing};
use crate::units::ForceUnit;
use draft::{Answers, Key, MARK};
use std::fs::{self, Permissions};
use std::io::{self, ErrorKind};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Labels of the chips whose lines are on the header of a Raspberry Pi, the newest first.
const HEADERS: [&str; 3] = ["pinctrl-rp1", "pinctrl-bcm2711", "pinctrl-bcm2835"];

/// Sets the instrument up, or takes that back.
pub fn run(arguments: &Setup) -> Result<(), CtlError> {
    let path = &arguments.file.path;
    if arguments.undo {
        return undo(path);
    }
    let chip = chip(arguments)?;
    let answers = ask(arguments, chip)?;
    let text = answers.configuration().map_err(CtlError::Said)?;
    write(path, &text)?;
    say(&format!("2. configuration: {} is written", path.display()))?;
    match test(arguments) {
        Ok(()) => finish(arguments),
        Err(error) => Err(CtlError::Said(format!(
            "{error}\nput it right and run this again, or take it back: cermctl setup --undo --config {}",
            path.display()
        ))),
    }
}

fn say(text: &str) -> Result<(), CtlError> {
    print(&format!("{text}\n"))
}

/// The chip that was named, or the one of a header; `None` for a simulated board.
fn chip(arguments: &Setup) -> Result<Option<String>, CtlError> {
    if let Some(scene) = &arguments.scene {
        say(&format!("1. chip: none, the board {scene} is simulated"))?;
        return Ok(None);
    }
    let chips: Vec<ChipListing> = chardev::list().collect::<Result<_, _>>().map_err(CtlError::said)?;
    let is_it = |chip: &&ChipListing, name: &str| {
        chip.label == name || chip.name == name || chip.path == Path::new(name)
    };
    let found = match &arguments.chip {
        Some(name) => chips.iter().find(|chip| is_it(chip, name)),
        None => HEADERS.iter().find_map(|label| chips.iter().find(|chip| is_it(chip, label))),
    };
    let Some(found) = found else {
        let there: Vec<String> = chips.iter().map(|chip| format!("{} [{}]", chip.name, chip.label)).collect();
        let there = if there.is_empty() { "none".to_owned() } else { there.join(", ") };
        let wanted = arguments.chip.as_deref().unwrap_or("of a Raspberry Pi's header");
        return Err(CtlError::Said(format!(
            "no GPIO chip {wanted}: there is {there}; name one with --chip (`cermctl lines` shows their lines), or try \
             --scene pi4 for a simulated board"
        )));
    };
    say(&format!("1. chip: {} [{}], {} lines", found.name, found.label, found.lines.len()))?;
    // A label outlives a reboot, a name may not.
    Ok(Some(if found.label.is_empty() { found.name.clone() } else { found.label.clone() }))
}

/// What the options leave open is asked, unless nobody is to be.
fn ask(arguments: &Setup, chip: Option<String>) -> Result<Answers<'_>, CtlError> {
    let mut answers = Answers::new(arguments, chip).map_err(CtlError::Said)?;
    for key in Key::ALL {
        while !arguments.yes && answers.is_open(key) {
            let question = format!("   {} [{}]: ", key.question(), answers.text(key));
            let Some(typed) = calibrate::typed_line(&question)? else {
                return Err(CtlError::said(
                    "the input has ended; --yes takes what is in brackets for an answer",
                ));
            };
            let typed = typed.trim();
            match if typed.is_empty() { Ok(()) } else { answers.answer(key, typed) } {
                Ok(()) => break,
                Err(error) => say(&format!("   {error}"))?,
            }
        }
    }
    Ok(answers)
}

/// As it was before the first setup; beside the configuration.
fn kept(path: &Path) -> PathBuf {
    let mut kept = path.as_os_str().to_owned();
    kept.push(".before-setup");
    kept.into()
}

/// What somebody else has written is kept, what an earlier setup has written is not.
fn write(path: &Path, text: &str) -> Result<(), CtlError> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(CtlError::file(folder))?;
    }
    let is_new = !path.exists();
    match files::read_text(path, files::SETTINGS_BYTES) {
        Ok(old) if old.starts_with(MARK) => {}
        Ok(_) => drop(fs::copy(path, kept(path)).map_err(CtlError::file(&kept(path)))?),
        Err(error) if error.kind() == ErrorKind::NotFound => {}
        Err(error) => return Err(CtlError::file(path)(error)),
    }
    files::replace(path, text).map_err(CtlError::file(path))?;
    // The service is another user, whatever root's mask is.
    let mode = Permissions::from_mode(0o644);
    if is_new { fs::set_permissions(path, mode).map_err(CtlError::file(path)) } else { Ok(()) }
}

/// Everything that `cermctl check` tests, with the daemon out of the way.
fn test(arguments: &Setup) -> Result<(), CtlError> {
    if !arguments.no_service && service::can_be_asked() && service::is_active() {
        service::run(&["stop", service::UNIT])?;
    }
    say("3. test:")?;
    check::run(&cli::Check { file: cli::ConfigFile { path: arguments.file.path.clone() } })
}

fn finish(arguments: &Setup) -> Result<(), CtlError> {
    let path = arguments.file.path.display();
    let is_asked = !arguments.no_service;
    if !is_asked || !service::can_be_asked() {
        let why = if is_asked { ": it takes root and systemd" } else { "" };
        say(&format!("4. service: not started{why}; by hand: cermd --config {path}"))?;
        return Ok(());
    }
    service::run(&["enable", service::UNIT])?;
    service::run(&["restart", service::UNIT])?;
    say("4. service: started, and will be at each boot")?;
    first_reading(arguments)?;
    if !arguments.yes {
        zero(arguments)?;
    }
    say(
        "done. Live: cermctl watch. What pins differ by is taken out by `cermctl calibrate zero` and `reference`,",
    )?;
    say("and forces are as true as `cermctl calibrate force` makes them. Taken back by: cermctl setup --undo")
}

/// Waits until the daemon listens, and prints what it has read.
fn first_reading(arguments: &Setup) -> Result<(), CtlError> {
    let since = Instant::now();
    let socket = &arguments.connection.socket;
    while let Err(error) = Stream::connect(socket, &[]) {
        if since.elapsed() > STARTED {
            return Err(CtlError::Said(format!("{error}; what the service says: journalctl -u cermd")));
        }
        std::thread::sleep(LOOK_AROUND);
    }
    get::run(&cli::Get {
        channels: Vec::new(),
        shown: cli::Shown { unit: ForceUnit::Newton },
        json: false,
        connection: cli::Connection { socket: socket.clone() },
    })
}

fn zero(arguments: &Setup) -> Result<(), CtlError> {
    let question =
        "5. zero: put a wire in the sensor's place and press Enter, or type s to leave that for later: ";
    match calibrate::typed_line(question)? {
        Some(text) if text.trim().is_empty() => {}
        _ => return Ok(()),
    }
    calibrate::run(&CalibrateBy::Zero(Zero {
        count: 200,
        update: Update {
            channel: None,
            file: cli::ConfigFile { path: arguments.file.path.clone() },
            yes: true,
            json: false,
        },
        connection: cli::Connection { socket: arguments.connection.socket.clone() },
    }))?;
    service::run(&["reload", service::UNIT])
}

/// The service is stopped, and the configuration as it was before the first setup.
fn undo(path: &Path) -> Result<(), CtlError> {
    let is_ours = match files::read_text(path, files::SETTINGS_BYTES) {
        Ok(text) => text.starts_with(MARK),
        Err(error) if error.kind() == ErrorKind::NotFound => false,
        Err(error) => return Err(CtlError::file(path)(error)),
    };
    if !is_ours {
        return Err(CtlError::Said(format!(
            "{} was not written by `cermctl setup`: nothing to take back",
            path.display()
        )));
    }
    if service::can_be_asked() {
        service::run(&["disable", "--now", service::UNIT])?;
        say("service: stopped, and no longer started at boot")?;
    }
    let kept = kept(path);
    match fs::rename(&kept, path) {
        Ok(()) => say(&format!("configuration: {} is as it was", path.display())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            fs::remove_file(path).map_err(CtlError::file(path))?;
            say(&format!("configuration: {} is gone; there was none before", path.display()))
        }
        Err(error) => Err(CtlError::file(&kept)(error)),
    }
}
