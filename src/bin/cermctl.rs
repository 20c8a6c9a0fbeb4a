//! Everything a person types: parse, dispatch, exit status.

use cermd::ctl::{self, cli::Cermctl};
use clap::Parser;
use std::io::{self, Write};
use std::process::ExitCode;

fn main() -> ExitCode {
    match ctl::run(Cermctl::parse().verb) {
        Ok(()) => ExitCode::SUCCESS,
        // Whoever reads our output has had enough.
        Err(error) if error.is_closed_pipe() => ExitCode::SUCCESS,
        Err(error) => {
            // If nobody can be told, the status says it.
            let _ = writeln!(io::stderr(), "cermctl: {error}");
            ExitCode::FAILURE
        }
    }
}
