//! A lock by a file that nobody else can open: a lock on what others can read (a directory, say) others can hold, and keep
//! everybody from starting.

use nix::errno::Errno;
use nix::fcntl::{Flock, FlockArg, OFlag};
use nix::unistd::Uid;
use std::fs::{self, File};
use std::io;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

/// Held until it is dropped; the file goes with it.
#[derive(Debug)]
pub(super) struct Lock {
    _file: Flock<File>,
    path: PathBuf,
}

/// Why there is no lock.
#[derive(Debug)]
pub(super) enum LockError {
    /// Another process has it just now.
    Held,
    /// What is at that path somebody else can open, or is no file.
    NotOurs,
    Failed(io::Error),
}

impl From<io::Error> for LockError {
    fn from(error: io::Error) -> LockError {
        match error.raw_os_error().map(Errno::from_raw) {
            Some(Errno::ELOOP | Errno::ENXIO | Errno::EISDIR) => LockError::NotOurs,
            _ => LockError::Failed(error),
        }
    }
}

impl Lock {
    /// Takes the lock of that path, without waiting for it.
    pub fn take(path: &Path) -> Result<Lock, LockError> {
        let flags = OFlag::O_NOFOLLOW | OFlag::O_NONBLOCK;
        loop {
            let mut options = File::options();
            options.create(true).truncate(false).write(true).mode(0o600).custom_flags(flags.bits());
            let file = options.open(path)?;
            let metadata = file.metadata()?;
            let is_ours = metadata.uid() == Uid::effective().as_raw() && metadata.mode() & 0o077 == 0;
            if !(metadata.is_file() && is_ours) {
                return Err(LockError::NotOurs);
            }
            let file = match Flock::lock(file, FlockArg::LockExclusiveNonblock) {
                Ok(file) => file,
                Err((_, Errno::EWOULDBLOCK)) => return Err(LockError::Held),
                Err((_, errno)) => return Err(LockError::Failed(errno.into())),
            };
            // Whoever held it before may have removed the file since we opened it.
            let now = fs::symlink_metadata(path);
            if now.is_ok_and(|now| (now.dev(), now.ino()) == (metadata.dev(), metadata.ino())) {
                return Ok(Lock { _file: file, path: path.to_owned() });
            }
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // While it is held: nobody has locked this file, and nobody ever will.
        if let Err(error) = fs::remove_file(&self.path) {
            log::warn!("remove {}: {error}", self.path.display());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::{PermissionsExt, symlink};
    use std::sync::atomic::{AtomicU32, Ordering};

    #[test]
    fn one_at_a_time_and_nothing_is_left() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("s.lock");
        let held = Lock::take(&path).unwrap();
        assert_eq!(fs::metadata(&path).unwrap().mode() & 0o777, 0o600);
        assert!(matches!(Lock::take(&path), Err(LockError::Held)));
        drop(held);
        assert!(!path.exists());
        // Many at once: whoever has it is alone, although the file goes and comes.
        let (inside, taken) = (AtomicU32::new(0), AtomicU32::new(0));
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    for _ in 0..2000 {
                        if let Ok(lock) = Lock::take(&path) {
                            assert_eq!(inside.fetch_add(1, Ordering::SeqCst), 0, "two have the lock");
                            taken.fetch_add(1, Ordering::SeqCst);
                            inside.fetch_sub(1, Ordering::SeqCst);
                            drop(lock);
                        }
                    }
                });
            }
        });
        assert!(taken.into_inner() > 0 && !path.exists());
    }

    #[test]
    fn what_others_can_open_is_no_lock() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("s.lock");
        let refused = || matches!(Lock::take(&path), Err(LockError::NotOurs));
        fs::write(&path, "").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o644)).unwrap();
        assert!(refused());
        fs::remove_file(&path).unwrap();
        symlink("elsewhere", &path).unwrap();
        assert!(refused() && !directory.path().join("elsewhere").exists());
        fs::remove_file(&path).unwrap();
        nix::unistd::mkfifo(&path, nix::sys::stat::Mode::S_IRWXU).unwrap();
        assert!(refused(), "and no wait for its reader");
        fs::remove_file(&path).unwrap();
        fs::create_dir(&path).unwrap();
        assert!(refused());
    }
}
