//! The daemon: parse, run, exit status.

use cermd::ctl::cli::{self, Cermd, NO_HARDWARE};
use cermd::ctl::{self, check};
use cermd::daemon::{self, DaemonError, Released};
use std::error::Error;
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

/// EX_CONFIG of sysexits.h, which the service manager does not start again (systemd/cermd.service).
const NO_USE_TO_RESTART: u8 = 78;
/// EX_UNAVAILABLE: the chip is not there, which is no failure of the service.
const NO_CHIP: u8 = 69;

fn main() -> ExitCode {
    let arguments: Cermd = match cli::arguments() {
        Ok(arguments) => arguments,
        Err(status) => return status,
    };
    ctl::log::start();
    let path = arguments.file.path;
    let is_to_measure = !arguments.check && !arguments.release_lines;
    if is_to_measure && matches!(path.try_exists(), Ok(false)) {
        // If nobody can be told, the status says it.
        let _ = writeln!(
            io::stderr(),
            "cermd: there is no configuration file {}: name another with --config FILE. No hardware was touched.\n{NO_HARDWARE}",
            path.display()
        );
        return ExitCode::from(2);
    }
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
            match error.downcast_ref::<DaemonError>() {
                Some(error) if error.is_absent() => ExitCode::from(NO_CHIP),
                Some(error) if error.is_lasting() => ExitCode::from(NO_USE_TO_RESTART),
                _ => ExitCode::FAILURE,
            }
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
    match daemon::release_lines(path)? {
        Released::All => log::info!("every line is an input"),
        Released::ButOf(error) => {
            log::warn!("{error}: left to whoever that is; every other line is an input");
        }
        Released::Nothing => log::info!("a simulated circuit: no line to release"),
    }
    Ok(true)
}
