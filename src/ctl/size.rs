//! `cermctl size`: which circuit does what is asked for, as closed forms rank it and a rehearsal confirms it.

mod asked;
mod file;
mod reason;
mod rehearsal;
mod report;

use super::{CtlError, cli, line, print};
use crate::size::Search;
use crate::size::limits::PERIOD_SHARES;
use asked::Asked;
use rehearsal::Rehearsed;
use std::io::Write;
use std::path::Path;

/// Finds it and says what to expect.
pub fn run(arguments: &cli::Size) -> Result<(), CtlError> {
    let asked = asked::asked(arguments)?;
    let found = find(&asked)?;
    let why = reason::why_not(&asked, found.first());
    if arguments.json {
        print(&line(&report::SizeLine::new(&asked, &found, why.as_deref())))?;
    } else {
        print(&report::text(&asked, &found, why.as_deref()))?;
    }
    if let Some(why) = why {
        return Err(CtlError::said(why));
    }
    match (&arguments.write, found.first()) {
        (Some(path), Some(best)) => {
            write(path, &file::text(&asked, &best.design))?;
            let next =
                format!("{}: written; next `cermd --check --config {}`", path.display(), path.display());
            if arguments.json { Ok(()) } else { print(&format!("\n {next}\n")) }
        }
        _ => Ok(()),
    }
}

/// The best first; nothing if nothing is fast enough even to be tried. Where a wiring is too slow, because calibration takes more of
/// the time between readings than was thought, again with shorter discharges.
fn find(asked: &Asked) -> Result<Vec<Rehearsed>, CtlError> {
    let shares = if asked.search.need.rate_hz.is_some() { &PERIOD_SHARES[..] } else { &PERIOD_SHARES[..1] };
    let (mut all, mut search): (Vec<Rehearsed>, Search) = (Vec::new(), asked.search.clone());
    for share in shares {
        let done = rehearsal::all(asked, &search.ranked(*share))?;
        search.kinds.retain(|kind| done.iter().all(|one| !one.meets || one.design.kind() != *kind));
        all.extend(done);
    }
    rehearsal::confirmed(asked, &mut all)?;
    Ok(all)
}

fn write(path: &Path, text: &str) -> Result<(), CtlError> {
    let mut file = std::fs::File::create_new(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::AlreadyExists => CtlError::said(format!(
            "{}: is there already, and was not changed; name another file",
            path.display()
        )),
        _ => CtlError::file(path)(error),
    })?;
    file.write_all(text.as_bytes()).map_err(CtlError::file(path))
}

#[cfg(test)]
mod tests;
