//! `cermctl estimate`: from a tape to resistances and forces, a line for each discharge of a sensor.

use super::{CtlError, print};
use crate::ctl::cli;
use crate::ctl::replay;
use std::io::Read;
use std::path::Path;

/// Prints the estimates, or says which line is wrong.
pub fn run(arguments: &cli::Estimate) -> Result<(), CtlError> {
    let path = &arguments.tape;
    let is_stdin = path == Path::new("-");
    let name = if is_stdin { Path::new("standard input") } else { path };
    let mut text = String::new();
    let read = if is_stdin {
        std::io::stdin().lock().read_to_string(&mut text)
    } else {
        std::fs::File::open(path).and_then(|mut file| file.read_to_string(&mut text))
    };
    read.map_err(CtlError::file(name))?;
    let estimates = replay::estimate(&text, arguments.method, arguments.offset)
        .map_err(|source| CtlError::Tape { path: name.to_owned(), source })?;
    for estimate in estimates {
        // Numbers and texts always serialise.
        print(&(serde_json::to_string(&estimate).unwrap_or_default() + "\n"))?;
    }
    Ok(())
}
