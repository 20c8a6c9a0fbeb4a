//! Everything a person types: parse, dispatch, exit status.

use cermd::ctl::{self, cli};
use std::io::{self, Write};
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: cli::Cermctl = match cli::arguments() {
        Ok(arguments) => arguments,
        Err(status) => return status,
    };
    match ctl::run(arguments.verb) {
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
