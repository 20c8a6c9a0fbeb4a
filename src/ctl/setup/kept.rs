//! What was there before the first setup: kept beside the configuration until it is taken back.
//!
//! Its name tells whether the service was enabled then. What somebody has changed since a setup is kept, too, as by any calibration.

use super::draft::MARK;
use crate::ctl::CtlError;
use crate::ctl::calibrate::edit::free_name;
use crate::files;
use std::fs::{self, Permissions};
use std::io::ErrorKind;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

/// What is added to the name of the configuration, while the service was not enabled and while it was.
const BEFORE: [&str; 2] = [".before-setup", ".before-setup-enabled"];

/// A configuration of before the first setup.
#[derive(Debug)]
pub struct Before {
    path: PathBuf,
    /// Whether the service was started at boot.
    pub was_enabled: bool,
}

fn name(path: &Path, was_enabled: bool) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(BEFORE[usize::from(was_enabled)]);
    name.into()
}

fn find(path: &Path) -> Option<Before> {
    let named = |was_enabled| Before { path: name(path, was_enabled), was_enabled };
    [true, false].map(named).into_iter().find(|before| fs::symlink_metadata(&before.path).is_ok())
}

/// The text that is there; `None`: no file.
fn text(path: &Path) -> Result<Option<String>, CtlError> {
    match files::read_text(path, files::SETTINGS_BYTES) {
        Ok(text) => Ok(Some(text)),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(CtlError::file(path)(error)),
    }
}

/// Writes a configuration, and gives the name under which the one before it is kept, if there was another.
///
/// # Errors
/// Then what was there is as it was.
pub fn replace(path: &Path, new: &str, is_enabled: bool) -> Result<Option<PathBuf>, CtlError> {
    let folder = files::folder_of(path);
    if !folder.exists() {
        fs::create_dir_all(folder).map_err(CtlError::file(folder))?;
        readable(folder, 0o755)?;
    }
    // A link stays one.
    let path = &fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let kept = match text(path)? {
        None => None,
        Some(old) if old == new => return Ok(None),
        Some(old) if old.starts_with(MARK) => Some(free_name(path)),
        Some(_) => {
            if let Some(older) = find(path) {
                fs::rename(&older.path, free_name(path)).map_err(CtlError::file(&older.path))?;
            }
            Some(name(path, is_enabled))
        }
    };
    if let Some(kept) = &kept {
        fs::hard_link(path, kept).map_err(CtlError::file(kept))?;
    }
    files::replace(path, new).map_err(CtlError::file(path))?;
    if kept.is_none() {
        readable(path, 0o644)?;
    }
    Ok(kept)
}

/// The service is another user, whatever root's mask is.
fn readable(path: &Path, mode: u32) -> Result<(), CtlError> {
    fs::set_permissions(path, Permissions::from_mode(mode)).map_err(CtlError::file(path))
}

/// What was there before the first setup; `None`: nothing.
///
/// # Errors
/// The file that is there now is of somebody else.
pub fn before(path: &Path) -> Result<Option<Before>, CtlError> {
    if text(path)?.is_some_and(|text| text.starts_with(MARK)) {
        return Ok(find(path));
    }
    let path = path.display();
    Err(CtlError::Said(format!("{path} was not written by `cermctl setup`: nothing to take back")))
}

/// Puts that back, and gives the name of the configuration that was there last.
///
/// # Errors
/// A file cannot be renamed.
pub fn put_back(path: &Path, before: Option<&Before>) -> Result<PathBuf, CtlError> {
    let last = free_name(path);
    fs::rename(path, &last).map_err(CtlError::file(path))?;
    if let Some(before) = before {
        fs::rename(&before.path, path).map_err(CtlError::file(&before.path))?;
    }
    Ok(last)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_there_comes_back_and_nothing_is_lost() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("cermd.toml");
        let [first, second] = ["1", "2"].map(|text| format!("{MARK} {text}"));
        for was_enabled in [true, false] {
            fs::write(&path, "mine").unwrap();
            let kept = replace(&path, &first, was_enabled).unwrap().unwrap();
            assert_eq!(fs::read_to_string(kept).unwrap(), "mine");
            assert!(replace(&path, &first, true).unwrap().is_none(), "nothing has changed");
            let changed = replace(&path, &second, true).unwrap().unwrap();
            assert_eq!(fs::read_to_string(changed).unwrap(), first);
            let before = before(&path).unwrap().unwrap();
            assert_eq!(before.was_enabled, was_enabled);
            let last = put_back(&path, Some(&before)).unwrap();
            assert_eq!(
                [&path, &last].map(|path| fs::read_to_string(path).unwrap()),
                ["mine".to_owned(), second.clone()]
            );
        }
        assert!(before(&path).is_err() && find(&path).is_none());
    }

    #[test]
    fn nothing_is_written_through_a_link_that_waits_for_it() {
        let folder = tempfile::tempdir().unwrap();
        let (path, victim) = (folder.path().join("cermd.toml"), folder.path().join("victim"));
        fs::write(&path, "mine").unwrap();
        fs::write(&victim, "untouched").unwrap();
        std::os::unix::fs::symlink(&victim, name(&path, false)).unwrap();
        replace(&path, MARK, false).unwrap();
        assert_eq!(fs::read_to_string(&victim).unwrap(), "untouched");
        assert_eq!(fs::read_to_string(name(&path, false)).unwrap(), "mine");
    }
}
