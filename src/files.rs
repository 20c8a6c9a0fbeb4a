//! The text of a file that a configuration names, in bounded time and memory whatever somebody has put in its place, and a new one
//! that is there whole or not at all.
//!
//! For: reading a file without trust in its path, replacing one. Must not know: what is in it.

use nix::fcntl::OFlag;
use std::fs::{self, File, Metadata, Permissions};
use std::io::{self, ErrorKind, Read, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt, fchown};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// A configuration or a scene, bytes: a hundred times what anybody has typed.
pub const SETTINGS_BYTES: u64 = 1 << 20;
/// A table or a recorded course of values, bytes: a day at 20 values a second.
pub const TABLE_BYTES: u64 = 64 << 20;

/// The text of a regular file of at most so many bytes. A pipe is not waited for, a device not opened.
///
/// # Errors
/// It cannot be read ([`hint`] says what to do), is no regular file ([`ErrorKind::InvalidInput`]), longer
/// ([`ErrorKind::FileTooLarge`]), or no UTF-8 ([`ErrorKind::InvalidData`]).
pub fn read_text(path: &Path, most_bytes: u64) -> io::Result<String> {
    // A device may do something as soon as it is opened.
    regular(&fs::metadata(path)?)?;
    // It may have been replaced since.
    let flags = OFlag::O_NONBLOCK | OFlag::O_NOCTTY;
    let file = File::options().read(true).custom_flags(flags.bits()).open(path)?;
    regular(&file.metadata()?)?;
    let mut text = String::new();
    // Not by the size that the file has now: it may grow.
    let bytes = file.take(most_bytes + 1).read_to_string(&mut text)?;
    if bytes as u64 > most_bytes {
        let message = format!("it has more than {} MiB", most_bytes >> 20);
        return Err(io::Error::new(ErrorKind::FileTooLarge, message));
    }
    Ok(text)
}

fn regular(metadata: &Metadata) -> io::Result<()> {
    let refusal = || io::Error::new(ErrorKind::InvalidInput, "it is no regular file");
    metadata.is_file().then_some(()).ok_or_else(refusal)
}

/// A text on its way to a path: on the disk, under a name of its own in the same folder, which is gone unless it is persisted. It
/// has the rights of a file like it, or those of any new file.
///
/// # Errors
/// It cannot be written.
pub fn beside(path: &Path, text: &str, like: Option<&Metadata>) -> io::Result<NamedTempFile> {
    let mut new = tempfile::Builder::new()
        .prefix(".cermd-")
        .permissions(Permissions::from_mode(0o666))
        .tempfile_in(folder_of(path))?;
    new.write_all(text.as_bytes())?;
    if let Some(like) = like {
        // Only root can give files away; for others the file becomes their own, as with any editor.
        // By the file, not by its name, which somebody else may have made a link since.
        let _ = fchown(new.as_file(), Some(like.uid()), Some(like.gid()));
        new.as_file().set_permissions(like.permissions())?;
    }
    new.as_file().sync_all()?;
    Ok(new)
}

/// Puts a text in the place of a file, or where none was.
///
/// # Errors
/// Then what was there is as it was.
pub fn replace(path: &Path, text: &str) -> io::Result<()> {
    let like = fs::metadata(path).ok();
    beside(path, text, like.as_ref())?.persist(path)?;
    sync_folder(path)
}

/// Waits until the names in the folder of this path are on the disk.
///
/// # Errors
/// Nobody knows whether they are.
pub fn sync_folder(path: &Path) -> io::Result<()> {
    File::open(folder_of(path))?.sync_all()
}

/// The folder that a file is in, or is to be: of a name alone, the working directory.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// What cannot be done with a file or a folder, and what to do about it.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {error}; {hint}", path = .path.display())]
pub struct FileError {
    /// Which.
    pub path: PathBuf,
    /// What the system says.
    pub error: io::Error,
    /// What to do.
    pub hint: &'static str,
}

impl FileError {
    /// What a path turns an error into; `hint`: what to do about it.
    pub fn at(path: &Path, hint: fn(&io::Error) -> &'static str) -> impl Fn(io::Error) -> FileError + use<> {
        let path = path.to_owned();
        move |error| FileError { path: path.clone(), hint: hint(&error), error }
    }
}

/// What to do about an error of [`read_text`].
pub fn hint(error: &io::Error) -> &'static str {
    match error.kind() {
        ErrorKind::NotFound => "is the path right?",
        ErrorKind::PermissionDenied => "run as a user that may read it, or make it readable",
        ErrorKind::InvalidData => "it must be UTF-8 text",
        ErrorKind::InvalidInput => "name a file, not a pipe, a device or a folder",
        ErrorKind::FileTooLarge => "is it the right file?",
        _ => "is the disk in order?",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nix::sys::stat::Mode;

    #[test]
    fn a_file_is_replaced_whole_and_keeps_its_rights() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("f");
        replace(&path, "a").unwrap();
        let mode = || fs::metadata(&path).unwrap().mode() & 0o777;
        assert_eq!(mode() & 0o600, 0o600);
        fs::set_permissions(&path, Permissions::from_mode(0o640)).unwrap();
        replace(&path, "b").unwrap();
        assert_eq!((fs::read_to_string(&path).unwrap().as_str(), mode()), ("b", 0o640));
        replace(&path.join("no"), "c").unwrap_err();
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1, "only what was asked for");
    }

    #[test]
    fn a_file_of_the_greatest_size_is_read_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("f");
        let kind = |most| read_text(&path, most).unwrap_err().kind();
        assert_eq!(kind(3), ErrorKind::NotFound);
        fs::write(&path, "abc").unwrap();
        assert_eq!(read_text(&path, 3).unwrap(), "abc");
        assert_eq!(kind(2), ErrorKind::FileTooLarge);
        fs::write(&path, [0xff]).unwrap();
        assert_eq!(kind(3), ErrorKind::InvalidData);
        fs::remove_file(&path).unwrap();
        // With a writer that never writes, and without one.
        nix::unistd::mkfifo(&path, Mode::S_IRWXU).unwrap();
        assert_eq!(kind(3), ErrorKind::InvalidInput);
        let _writer = File::options().read(true).write(true).open(&path).unwrap();
        assert_eq!(kind(3), ErrorKind::InvalidInput);
        for odd in ["/dev/zero", "/dev/tty", "/", "/dev/stdin"] {
            let error = read_text(Path::new(odd), 3).unwrap_err();
            assert!(odd != "/dev/zero" || error.kind() == ErrorKind::InvalidInput, "{odd}: {error}");
        }
    }
}
