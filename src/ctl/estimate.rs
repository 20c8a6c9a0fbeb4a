//! `cermctl estimate`: from a tape to resistances and forces, a line for each discharge of a sensor as soon as it is read.

mod summary;

use super::{CtlError, line, print};
use crate::ctl::cli;
use crate::ctl::replay::Replay;
use crate::stream::tape::Reader;
use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::Path;
use summary::Summary;

/// Prints the estimates, or says which line is wrong.
pub fn run(arguments: &cli::Estimate) -> Result<(), CtlError> {
    let path = &arguments.tape;
    let is_stdin = path == Path::new("-");
    let name = if is_stdin { "standard input".to_owned() } else { path.display().to_string() };
    let input: Box<dyn BufRead> = if is_stdin {
        Box::new(io::stdin().lock())
    } else {
        Box::new(BufReader::new(File::open(path).map_err(CtlError::file(path))?))
    };
    let wrong = |why: &dyn std::fmt::Display| CtlError::Said(format!("{name}: {why}"));
    let tape = Reader::open(input).map_err(|error| wrong(&error))?;
    let new = |method: &_| Replay::new(tape.header(), *method, arguments.offset).map_err(|why| wrong(&why));
    let mut replays: Vec<Replay> = arguments.method.iter().map(new).collect::<Result<_, _>>()?;
    let mut summary = Summary::default();
    for entry in tape {
        let entry = match entry {
            Err(error) if error.is_cut => {
                eprintln!("cermctl: {name}: the tape is cut off in its last line: {error}");
                break;
            }
            entry => entry.map_err(|error| wrong(&error))?,
        };
        for replay in &mut replays {
            match replay.take(&entry) {
                Some(estimate) if arguments.summary => summary.add(estimate),
                Some(estimate) => print(&line(&estimate))?,
                None => {}
            }
        }
    }
    summary
        .rows()
        .iter()
        .try_for_each(|row| print(&if arguments.json { line(row) } else { row.to_string() }))?;
    // A tape without a discharge of a sensor has nothing to give.
    if let Some(why) = replays.iter().find_map(Replay::missed) {
        return Err(wrong(&why));
    }
    if replays.iter().any(Replay::ignores_leaks) {
        eprintln!(
            "cermctl: {name}: this tape shows no look for a leak: what one beside the sensor does is not in u (docs/tapes.md)"
        );
    }
    Ok(())
}
