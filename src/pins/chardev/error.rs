//! What a refusal of the kernel means to the person at the board: which call, which line, the likely cause.

use gpiocdev_uapi::v2;
use nix::errno::Errno;
use nix::unistd::{Gid, Group};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

/// Why chips, lines or requests could not be had. Errors after that are [`PinsError`](crate::pins::PinsError).
#[derive(Debug, thiserror::Error)]
pub enum ChardevError {
    /// A kernel call failed.
    #[error("{call} on {line} failed: {source}; {hint}")]
    Call {
        /// The system call or ioctl.
        call: &'static str,
        /// The line, chip or device node it was made for.
        line: String,
        /// What the kernel answered.
        source: io::Error,
        /// The likely cause, as far as it could be looked up, and the remedy.
        hint: String,
        /// Whether a group may do what this user may not.
        for_a_group: bool,
        /// Who holds lines that were asked for, if that could be found out.
        consumers: Vec<String>,
    },
    /// No such chip now: it may come (back).
    #[error("there is no GPIO chip with label, name or path \"{wanted}\"; {present}")]
    NoChip {
        /// As configured.
        wanted: String,
        /// Which chips there are.
        present: String,
    },
    /// The wiring makes no sense, or not with this chip or backend.
    #[error("{0}")]
    Wiring(String),
}

impl ChardevError {
    /// From a failed call on a device node; who holds a line and which other chips there are is not looked up.
    pub(super) fn call(call: &'static str, line: String, source: io::Error, node: &Path) -> ChardevError {
        let errno = source.raw_os_error().unwrap_or_default();
        let (hint, for_a_group) = match Errno::from_raw(errno) {
            Errno::EACCES | Errno::EPERM => closed(node),
            _ if is_gone(&source) => ("the chip is gone".to_owned(), false),
            _ => (hint(errno).to_owned(), false),
        };
        ChardevError::Call { call, line, source, hint, for_a_group, consumers: Vec::new() }
    }

    /// With what was looked up: another hint, and who holds lines that were asked for.
    pub(super) fn explained(self, hint: String, consumers: Vec<String>) -> ChardevError {
        match self {
            ChardevError::Call { call, line, source, for_a_group, .. } => {
                ChardevError::Call { call, line, source, hint, for_a_group, consumers }
            }
            other => other,
        }
    }

    /// Whether opening again later may help: the chip is not there (any more, or yet).
    pub fn is_gone(&self) -> bool {
        match self {
            ChardevError::NoChip { .. } => true,
            ChardevError::Call { source, .. } => is_gone(source),
            ChardevError::Wiring(_) => false,
        }
    }

    /// Whether another program holds a line that was asked for.
    pub fn is_busy(&self) -> bool {
        matches!(self, ChardevError::Call { source, .. } if source.raw_os_error() == Some(libc::EBUSY))
    }

    /// Whether a consumer of this name holds a line that was asked for.
    pub fn is_held_by(&self, consumer: &str) -> bool {
        matches!(self, ChardevError::Call { consumers, .. } if consumers.iter().any(|held| held == consumer))
    }

    /// Whether other programs, whose names are known, hold all lines that could not be had, and none of this name does.
    pub fn is_held_by_others_than(&self, consumer: &str) -> bool {
        let ChardevError::Call { consumers, .. } = self else { return false };
        self.is_busy() && !consumers.is_empty() && !self.is_held_by(consumer)
    }

    /// Whether a group may do what this user may not.
    pub(super) fn asks_for_a_group(&self) -> bool {
        matches!(self, ChardevError::Call { for_a_group: true, .. })
    }
}

/// The likely cause and the remedy by the error number alone.
pub(super) fn hint(errno: i32) -> &'static str {
    match Errno::from_raw(errno) {
        Errno::EINVAL => {
            "the kernel refuses a flag: older than 5.10 (use backend \"chardev-v1\"), without uAPI v1 (use backend \
             \"chardev\"), or the controller lacks it"
        }
        Errno::ENOTTY => "this is not a GPIO chip",
        Errno::EPERM => "another program has turned the line into an input",
        Errno::EBUSY => "another process or driver holds a line; cermctl lines shows which",
        Errno::EOPNOTSUPP => "the controller does not support this",
        Errno::EMFILE | Errno::ENFILE => "too many open files",
        _ => "unexpected: see the kernel log (dmesg)",
    }
}

/// Whether an answer of the kernel says that the chip itself has disappeared.
pub(super) fn is_gone(answer: &io::Error) -> bool {
    matches!(answer.raw_os_error(), Some(libc::ENODEV | libc::ENXIO | libc::ENOENT))
}

/// How to be let in by a device node: by way of the group that owns it (its number, if it has no name), unless that is root's; and
/// whether there is such a way.
fn closed(node: &Path) -> (String, bool) {
    let (gid, mode) = std::fs::metadata(node).map_or((0, 0), |node| (node.gid(), node.mode()));
    if gid == 0 || mode & 0o060 != 0o060 {
        let hint =
            "the device node is open to its owner alone: install the udev rule that gives it to a group";
        return (hint.to_owned(), false);
    }
    let named = Group::from_gid(Gid::from_raw(gid)).ok().flatten();
    let group = named.map_or_else(|| gid.to_string(), |group| group.name);
    let hint = format!(
        "the device node belongs to group {group}: add yourself to group {group} (sudo usermod -aG {group} USER, then log in \
         again)"
    );
    (hint, true)
}

/// As an `io::Error`, which keeps the error number.
pub(in crate::pins) fn as_io(error: v2::Error) -> io::Error {
    match error {
        v2::Error::Os(errno) => io::Error::from_raw_os_error(errno.0),
        short => io::Error::new(io::ErrorKind::UnexpectedEof, short),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    fn refused(errno: i32, node: &Path) -> ChardevError {
        ChardevError::call("GET_LINE", "sink-c1".to_owned(), io::Error::from_raw_os_error(errno), node)
    }

    fn text(errno: i32) -> String {
        refused(errno, Path::new("/nonexistent")).to_string()
    }

    #[test]
    fn a_refusal_names_the_group_to_join() {
        for errno in [libc::EACCES, libc::EPERM] {
            assert!(text(errno).contains("udev rule"));
        }
        let node = tempfile::NamedTempFile::new().unwrap();
        let mode =
            |bits| std::fs::set_permissions(node.path(), std::fs::Permissions::from_mode(bits)).unwrap();
        mode(0o660);
        let (own, other) = (node.path().metadata().unwrap().gid(), 4321);
        let joins = |text: &str| text.contains("usermod -aG ") && text.contains("then log in again");
        if std::os::unix::fs::chown(node.path(), None, Some(other)).is_ok() {
            assert!(joins(&refused(libc::EACCES, node.path()).to_string()));
        } else {
            assert_eq!(joins(&refused(libc::EACCES, node.path()).to_string()), own != 0);
        }
        // A group that may not either is no help.
        mode(0o640);
        assert!(!joins(&refused(libc::EACCES, node.path()).to_string()));
    }

    #[test]
    fn a_lost_chip_may_come_back() {
        for errno in [libc::ENODEV, libc::ENOENT, libc::ENXIO] {
            let error = refused(errno, Path::new("/nonexistent"));
            assert!(error.is_gone() && error.to_string().ends_with("the chip is gone"), "{error}");
        }
        let missing = ChardevError::NoChip { wanted: "x".into(), present: String::new() };
        assert!(missing.is_gone());
        assert!(!ChardevError::Wiring("x".into()).is_gone());
    }

    #[test]
    fn an_old_kernel_is_pointed_to_the_other_backend() {
        assert!(text(libc::EINVAL).contains("chardev-v1"));
        assert!(text(libc::EIO).contains("dmesg"));
    }

    #[test]
    fn error_numbers_survive_the_conversion() {
        let os = v2::Error::Os(v2::Errno(libc::EBUSY));
        assert_eq!(as_io(os).raw_os_error(), Some(libc::EBUSY));
    }
}
