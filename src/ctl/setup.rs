//! `cermctl setup`: from wires to the first reading, a step at a time; each can be taken back.

mod draft;
mod kept;
mod service;

use super::limits::{LOOK_AROUND, STARTED};
use super::stream::Stream;
use super::{CtlError, calibrate, check, get, print};
use crate::config::Config;
use crate::ctl::cli::{self, CalibrateBy, Setup, Update, Zero};
use crate::pins::chardev::{self, ChipListing};
use crate::units::ForceUnit;
use draft::{Answers, Key};
use std::fs;
use std::path::Path;
use std::time::Instant;

/// Labels of the chips whose lines are on the header of a Raspberry Pi, the newest first.
const HEADERS: [&str; 3] = ["pinctrl-rp1", "pinctrl-bcm2711", "pinctrl-bcm2835"];

/// Sets the instrument up, or takes that back.
pub fn run(arguments: &Setup) -> Result<(), CtlError> {
    if arguments.undo {
        return undo(arguments);
    }
    let path = &arguments.file.path;
    let chip = chip(arguments)?;
    let answers = ask(arguments, chip)?;
    say(&format!("   r-charge: {}, Rp and its pin; for another Rp: --r-charge", answers.r_charge()))?;
    let text = answers.configuration().map_err(CtlError::Said)?;
    let report = check::usable(path, Config::of_file(&text, path));
    if !report.is_usable() {
        let errors = report.errors();
        return Err(CtlError::Said(format!("with these values nothing would be measured:\n{errors}")));
    }
    let ours = service::left_alone(arguments).is_none();
    let (was_active, was_enabled) = (ours && service::is_active(), ours && service::is_enabled());
    let old = kept::replace(path, &text, was_enabled)?;
    say(&format!("2. configuration: {} is written", path.display()))?;
    let Err(error) = test(arguments, was_active) else { return finish(arguments) };
    if let (true, Some(old)) = (was_active, old) {
        fs::rename(&old, path).map_err(CtlError::file(&old))?;
        service::run(&["start", service::UNIT])?;
        return Err(CtlError::Said(format!(
            "{error}\nthe service runs again, with the configuration of before; put it right and run this again"
        )));
    }
    Err(CtlError::Said(format!(
        "{error}\nput it right and run this again, or take it back: cermctl setup --undo --config {}",
        path.display()
    )))
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

/// Everything that `cermctl check` tests, with the daemon out of the way.
fn test(arguments: &Setup, is_active: bool) -> Result<(), CtlError> {
    if is_active {
        service::run(&["stop", service::UNIT])?;
    }
    say("3. test:")?;
    check::run(&cli::Check { file: cli::ConfigFile { path: arguments.file.path.clone() } })
}

fn finish(arguments: &Setup) -> Result<(), CtlError> {
    let path = arguments.file.path.display();
    if let Some(why) = service::left_alone(arguments) {
        return say(&format!("4. service: not started, {why}; by hand: cermd --config {path}"));
    }
    service::run(&["enable", service::UNIT])?;
    service::run(&["restart", service::UNIT])?;
    if !service::is_active() {
        // A condition of the unit that does not hold is no failure to the service manager.
        return Err(CtlError::said("the service did not start: systemctl status cermd says why"));
    }
    say("4. service: started, and will be at each boot")?;
    first_reading(arguments)?;
    if !arguments.yes {
        zero(arguments)?;
    }
    let user = std::env::var("SUDO_USER").unwrap_or_else(|_| "USER".to_owned());
    say("done. Live: sudo cermctl watch")?;
    say(&format!("without sudo, once {user} has logged in again: sudo usermod -aG cermd {user}"))?;
    say("What pins differ by is taken out by `cermctl calibrate zero` and `reference`,")?;
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
        shown: cli::ForceUnitArg { unit: ForceUnit::Newton },
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

/// The configuration as it was before the first setup, and the service too.
fn undo(arguments: &Setup) -> Result<(), CtlError> {
    let path = &arguments.file.path;
    let before = kept::before(path)?;
    let is_left_alone = service::left_alone(arguments).is_some();
    if !is_left_alone {
        service::run(&["disable", "--now", service::UNIT])?;
        say("service: stopped, and no longer started at boot")?;
    }
    let last = kept::put_back(path, before.as_ref())?;
    let what = if before.is_some() { "as it was" } else { "gone; there was none before" };
    say(&format!("configuration: {} is {what}; the last one is {}", path.display(), last.display()))?;
    if !is_left_alone && before.is_some_and(|before| before.was_enabled) {
        service::run(&["enable", "--now", service::UNIT])?;
        say("service: started, as it was before the setup")?;
    }
    Ok(())
}
