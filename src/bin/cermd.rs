//! The daemon: parse, run, exit status.

use cermd::config::Config;
use cermd::config::backend;
use cermd::ctl::check;
use cermd::ctl::cli::{Cermd, NO_HARDWARE};
use cermd::daemon::{self, DaemonError};
use clap::Parser;
use nix::sys::stat::fstat;
use std::error::Error;
use std::io::{self, Write};
use std::os::fd::{AsFd, BorrowedFd};
use std::path::Path;
use std::process::ExitCode;

/// EX_CONFIG of sysexits.h, which the service manager does not start again (systemd/cermd.service).
const NO_USE_TO_RESTART: u8 = 78;

fn main() -> ExitCode {
    let arguments = Cermd::parse();
    start_log();
    let Some(path) = arguments.config else {
        // If nobody can be told, the status says it.
        let _ = writeln!(
            io::stderr(),
            "cermd: no configuration file: name one with --config FILE. No hardware was touched.\n{NO_HARDWARE}"
        );
        return ExitCode::from(2);
    };
    let outcome = if arguments.check {
        check(&path)
    } else if arguments.release_lines {
        release_lines(&path)
    } else {
        daemon::run(&path).map(|()| true).map_err(Into::into)
    };
    match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            log::error!("{error}");
            let is_lasting = error.downcast_ref::<DaemonError>().is_some_and(DaemonError::is_lasting);
            if is_lasting { ExitCode::from(NO_USE_TO_RESTART) } else { ExitCode::FAILURE }
        }
    }
}

/// Prints what is found; whether the configuration is usable.
fn check(path: &Path) -> Result<bool, Box<dyn Error>> {
    let report = check::check(path);
    let printed = io::stdout().write_all(report.to_string().as_bytes()).and_then(|()| io::stdout().flush());
    match printed {
        // Whoever reads our output has had enough.
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(format!("standard output: {error}").into())
        }
        _ => Ok(report.is_usable()),
    }
}

fn release_lines(path: &Path) -> Result<bool, Box<dyn Error>> {
    let config = Config::load(path)?;
    if backend::release_lines(&config)? {
        log::info!("every line of {} is an input", path.display());
    } else {
        log::info!("{} is about a simulated circuit: no line to release", path.display());
    }
    Ok(true)
}

/// To standard error; into the journal, each line begins with its syslog priority (sd-daemon(3)) and has no time, which
/// the journal adds. RUST_LOG chooses what is said.
fn start_log() {
    let mut logger = env_logger::Builder::from_env(env_logger::Env::default().default_filter_or("info"));
    if is_journal(std::io::stderr().as_fd()) {
        logger.format(|out, record| {
            let priority = match record.level() {
                log::Level::Error => 3,
                log::Level::Warn => 4,
                log::Level::Info => 6,
                log::Level::Debug | log::Level::Trace => 7,
            };
            // Every line of its own, or the journal takes the rest for another priority.
            record.args().to_string().lines().try_for_each(|line| writeln!(out, "<{priority}>{line}"))
        });
    }
    logger.init();
}

/// Whether a descriptor is the stream to the journal: the variable is inherited by programs whose output was
/// redirected, so it names the stream by device and inode (systemd.exec(5), JOURNAL_STREAM).
fn is_journal(output: BorrowedFd<'_>) -> bool {
    let Ok(stream) = std::env::var("JOURNAL_STREAM") else { return false };
    fstat(output).is_ok_and(|found| stream == format!("{}:{}", found.st_dev, found.st_ino))
}
