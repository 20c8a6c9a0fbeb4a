//! The daemon: parse, run, exit status.

use cermd::config::{self, Config};
use cermd::{backend, daemon};
use clap::Parser;
use nix::sys::stat::fstat;
use std::error::Error;
use std::io::Write;
use std::os::fd::{AsFd, BorrowedFd};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Measures resistances by timing RC discharges over GPIO lines, and streams them on a unix socket.
#[derive(Debug, Parser)]
#[command(version, after_help = NO_HARDWARE)]
struct Arguments {
    /// The configuration file
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Check the configuration, say what is found, and exit
    #[arg(long)]
    check: bool,
    /// Make every line that the configuration names an input, and exit: for after a kill
    #[arg(long, conflicts_with = "check")]
    release_lines: bool,
}

const NO_HARDWARE: &str = "Without hardware: `cermctl demo` shows live readings of a simulated circuit; a file with \
                           [gpio] backend = \"mock\" and [mock] scene = \"pi4\" makes this daemon serve one.";

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    start_log();
    let Some(path) = arguments.config else {
        eprintln!(
            "cermd: no configuration file: name one with --config FILE. No hardware was touched.\n{NO_HARDWARE}"
        );
        return ExitCode::from(2);
    };
    if arguments.check {
        let report = config::report(&path);
        print!("{report}");
        return if report.is_usable() { ExitCode::SUCCESS } else { ExitCode::FAILURE };
    }
    let outcome =
        if arguments.release_lines { release_lines(&path) } else { daemon::run(&path).map_err(Into::into) };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            log::error!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn release_lines(path: &Path) -> Result<(), Box<dyn Error>> {
    let config = Config::load(path)?;
    if backend::release_lines(&config)? {
        log::info!("every line of {} is an input", path.display());
    } else {
        log::info!("{} is about a simulated circuit: no line to release", path.display());
    }
    Ok(())
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
