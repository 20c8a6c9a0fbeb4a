//! `cermctl estimate`: from a tape to resistances and forces, a line for each discharge of a sensor.

use super::{CtlError, print};
use crate::ctl::cli;
use crate::ctl::replay;
use std::path::Path;
use std::{fs, io};

/// Prints the estimates, or says which line is wrong.
pub fn run(arguments: &cli::Estimate) -> Result<(), CtlError> {
    let path = &arguments.tape;
    let is_stdin = path == Path::new("-");
    let name = if is_stdin { Path::new("standard input") } else { path };
    let text = if is_stdin { io::read_to_string(io::stdin()) } else { fs::read_to_string(path) };
    let text = text.map_err(CtlError::file(name))?;
    let estimates = replay::estimate(&text, arguments.method, arguments.offset)
        .map_err(|why| CtlError::Said(format!("{}: {why}", name.display())))?;
    for estimate in estimates {
        // Numbers and texts always serialise.
        print(&(serde_json::to_string(&estimate).unwrap_or_default() + "\n"))?;
    }
    Ok(())
}
