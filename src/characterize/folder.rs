//! The folder of a sweep: rows are written as they come, and a sweep that was interrupted goes on where it was.

use super::table::{self, POINTS, PROVENANCE, Provenance, Row};
use crate::files::{self, FileError, SETTINGS_BYTES, TABLE_BYTES};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Why a folder cannot be used. What had been measured stays in it.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// The system refuses.
    #[error(transparent)]
    Io(#[from] FileError),
    /// A file that nobody here has written.
    #[error("{path}: {reason}; name another folder, or remove it", path = .path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
}

fn look_where(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::PermissionDenied => "this user may not write there; choose another folder",
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            "make room, then the same command goes on: what was measured is kept"
        }
        io::ErrorKind::AlreadyExists | io::ErrorKind::NotADirectory => {
            "a folder is wanted, and that is a file"
        }
        _ => "the same command goes on when it can be written: what was measured is kept",
    }
}

/// A folder with a table that grows.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    /// What is known already.
    pub rows: Vec<Row>,
    /// Where it comes from, by all commands that have gone on with it.
    pub provenance: Provenance,
    file: File,
}

impl Folder {
    /// Makes the folder, or goes on with the table in it if that is of the same provenance.
    ///
    /// # Errors
    /// It cannot be written, or what is in it is of another provenance.
    pub fn open(path: &Path, provenance: &Provenance) -> Result<Folder, FolderError> {
        fs::create_dir_all(path).map_err(failed(path))?;
        let provenance = begin(&path.join(PROVENANCE), provenance)?;
        let points = path.join(POINTS);
        let rows = match files::read_text(&points, TABLE_BYTES) {
            Ok(text) => table::read(&text)
                .map_err(|error| FolderError::Foreign { path: points.clone(), reason: error.to_string() })?,
            Err(error) if error.kind() == io::ErrorKind::NotFound => Vec::new(),
            Err(error) => return Err(failed(&points)(error).into()),
        };
        // Whole rows only: the last one may have been cut off.
        replace(&points, &rows)?;
        let file = OpenOptions::new().append(true).open(&points).map_err(failed(&points))?;
        Ok(Folder { path: path.to_owned(), rows, provenance, file })
    }

    /// Whether all of these questions have an answer.
    pub fn has(&self, asked: &[Row]) -> bool {
        asked.iter().all(|asked| self.rows.iter().any(|row| row.is_same_cell(asked)))
    }

    /// Adds rows, all of them or none, but for those that are there already.
    ///
    /// # Errors
    /// They cannot be written.
    pub fn add(&mut self, mut rows: Vec<Row>) -> Result<(), FolderError> {
        rows.retain(|row| !self.has(std::slice::from_ref(row)));
        let failed = failed(&self.path.join(POINTS));
        let text = table::text(&rows, self.rows.is_empty()).map_err(|error| failed(error.into()))?;
        self.file.write_all(text.as_bytes()).map_err(failed)?;
        self.rows.extend(rows);
        Ok(())
    }

    /// Puts rows into the order of the questions, those behind that nobody has asked for this time.
    ///
    /// # Errors
    /// The table cannot be replaced.
    pub fn sort(&mut self, asked: &[Row]) -> Result<(), FolderError> {
        let place = |row: &Row| asked.iter().position(|asked| asked.is_same_cell(row)).unwrap_or(usize::MAX);
        self.rows.sort_by_cached_key(place);
        replace(&self.path.join(POINTS), &self.rows)
    }
}

fn failed(path: &Path) -> impl Fn(io::Error) -> FileError + use<> {
    FileError::at(path, look_where)
}

/// Writes where a table comes from, or, where that stands there already, by which command it goes on; all of it comes back.
fn begin(path: &Path, provenance: &Provenance) -> Result<Provenance, FolderError> {
    let write = |provenance: &Provenance| {
        let text = serde_json::to_string_pretty(provenance).unwrap_or_default() + "\n";
        files::replace(path, &text).map_err(failed(path))
    };
    let text = match files::read_text(path, SETTINGS_BYTES) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            write(provenance)?;
            return Ok(provenance.clone());
        }
        Err(error) => return Err(failed(path)(error).into()),
    };
    let foreign = |reason: String| FolderError::Foreign { path: path.to_owned(), reason };
    let mut there: Provenance = serde_json::from_str(&text).map_err(|error| foreign(error.to_string()))?;
    if let Some(what) = there.differs(provenance) {
        return Err(foreign(format!("the table there has {what}")));
    }
    if there.commands().all(|known| *known != provenance.command) {
        there.later_commands.push(provenance.command.clone());
        write(&there)?;
    }
    Ok(there)
}

/// Puts a table in the place of the old one.
fn replace(path: &Path, rows: &[Row]) -> Result<(), FolderError> {
    let text = table::text(rows, true).map_err(|error| failed(path)(error.into()))?;
    Ok(files::replace(path, &text).map_err(failed(path))?)
}

#[cfg(test)]
mod tests {
    use super::super::table::Source;
    use super::*;
    use crate::circuit::Kind;
    use crate::reading::Method;

    fn row(r_ohm: f64) -> Row {
        Row::asked(Source::Simulated, "pi4", Kind::OneCapacitor, [470.0, 12_700.0], Method::Tracked, r_ohm)
    }

    fn provenance(seed: u64) -> Provenance {
        Provenance {
            source: Source::Simulated,
            board: "pi4".to_owned(),
            text: None,
            seed: Some(seed),
            version: "1".to_owned(),
            date: "2026-11-22".to_owned(),
            command: "cermctl characterize".to_owned(),
            later_commands: Vec::new(),
        }
    }

    #[test]
    fn a_sweep_goes_on_where_it_was_even_in_the_middle_of_a_row() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/b");
        let mut first = Folder::open(&path, &provenance(1)).unwrap();
        first.add(vec![row(300.0)]).unwrap();
        first.add(vec![row(100.0), row(200.0)]).unwrap();
        let points = path.join(POINTS);
        let text = fs::read_to_string(&points).unwrap();
        fs::write(&points, &text[..text.len() - 9]).unwrap();
        let later = Provenance { date: "2026-11-23".to_owned(), ..provenance(1) };
        let mut second = Folder::open(&path, &later).unwrap();
        assert!(second.has(&[row(300.0), row(100.0)]) && !second.has(&[row(200.0)]));
        // A cell may have several rows, of which some were written.
        second.add(vec![row(100.0), row(200.0)]).unwrap();
        second.sort(&[row(100.0), row(200.0)]).unwrap();
        let rows = table::read(&fs::read_to_string(&points).unwrap()).unwrap();
        assert_eq!(rows.iter().map(|row| row.r_ohm).collect::<Vec<_>>(), [100.0, 200.0, 300.0]);
    }

    #[test]
    fn every_command_that_a_table_is_of_is_told_once() {
        let folder = tempfile::tempdir().unwrap();
        let by = |command: &str| {
            let provenance = Provenance { command: command.to_owned(), ..provenance(1) };
            let kept = Folder::open(folder.path(), &provenance).unwrap().provenance;
            kept.commands().map(String::as_str).collect::<Vec<_>>().join("; ")
        };
        assert_eq!(by("a"), "a");
        assert_eq!((by("b").as_str(), by("a").as_str(), by("b").as_str()), ("a; b", "a; b", "a; b"));
    }

    #[test]
    fn another_provenance_is_refused_and_named() {
        let folder = tempfile::tempdir().unwrap();
        Folder::open(folder.path(), &provenance(1)).unwrap();
        let said = Folder::open(folder.path(), &provenance(2)).unwrap_err().to_string();
        assert!(
            said.ends_with("the table there has seed 1, not 2; name another folder, or remove it"),
            "{said}"
        );
        let other = Provenance { text: Some("[circuit]".to_owned()), ..provenance(1) };
        let said = Folder::open(folder.path(), &other).unwrap_err().to_string();
        assert!(said.contains("another scene, configuration or tape"), "{said}");
        fs::write(folder.path().join(PROVENANCE), "{}").unwrap();
        assert!(Folder::open(folder.path(), &provenance(1)).is_err());
    }

    #[test]
    fn a_full_disk_is_told_and_the_rows_before_it_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let mut open = Folder::open(folder.path(), &provenance(1)).unwrap();
        open.add(vec![row(100.0)]).unwrap();
        open.file = OpenOptions::new().append(true).open("/dev/full").unwrap();
        let said = open.add(vec![row(200.0)]).unwrap_err().to_string();
        assert!(said.contains("No space left") && said.contains("what was measured is kept"), "{said}");
        assert_eq!(open.rows.len(), 1);
        assert!(Folder::open(folder.path(), &provenance(1)).unwrap().has(&[row(100.0)]));
    }
}
