//! What a refusal of the kernel means to the person at the board: which call, which line, the likely cause.

use gpiocdev_uapi::v2;
use nix::errno::Errno;
use nix::unistd::{Gid, Group};
use std::fmt;
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

/// Why chips, lines or requests could not be had. Errors after that are [`PinsError`](crate::pins::PinsError).
#[derive(Debug, thiserror::Error)]
pub enum ChardevError {
    /// A kernel call failed.
    #[error("{call} on {line} failed: {source}; {cause}")]
    Call {
        /// The system call or ioctl.
        call: &'static str,
        /// The line, chip or device node it was made for.
        line: String,
        /// What the kernel answered.
        source: io::Error,
        /// The likely cause and what to do.
        cause: Cause,
    },
    /// No such chip now: it may come (back).
    #[error("there is no GPIO chip with label, name or path \"{wanted}\"; {present}")]
    NoChip {
        /// As configured.
        wanted: String,
        /// Which chips there are.
        present: String,
    },
    /// Several chips carry the label.
    #[error("several GPIO chips have the label \"{label}\": {}; give the name or path of one", names.join(", "))]
    AmbiguousChip {
        /// As configured.
        label: String,
        /// Their names.
        names: Vec<String>,
    },
    /// The chip has no such line.
    #[error("chip {chip} has no line \"{wanted}\"; {instead}")]
    NoLine {
        /// Name and label of the chip.
        chip: String,
        /// As configured.
        wanted: String,
        /// What could be asked for.
        instead: String,
    },
    /// The wiring makes no sense, or not with this backend.
    #[error("{0}")]
    Wiring(String),
}

impl ChardevError {
    /// Whether opening again later may help: the chip is not there (any more, or yet).
    pub fn is_gone(&self) -> bool {
        match self {
            ChardevError::NoChip { .. } => true,
            ChardevError::Call { cause, .. } => matches!(cause, Cause::Gone { .. }),
            _ => false,
        }
    }

    /// Whether another program holds a line that was asked for.
    pub fn is_busy(&self) -> bool {
        matches!(self, ChardevError::Call { cause: Cause::Held(_), .. })
    }

    /// Whether a consumer of this name holds a line that was asked for.
    pub fn is_held_by(&self, consumer: &str) -> bool {
        let ChardevError::Call { cause: Cause::Held(holders), .. } = self else { return false };
        holders.iter().any(|holder| holder.consumer.as_deref() == Some(consumer))
    }
}

/// The likely cause of a failed call, as far as it could be looked up; its text has the remedy.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Cause {
    /// The device node belongs to this group; `None`: to root alone.
    Closed(Option<String>),
    /// Lines of the request are taken, by these holders if they could be found out.
    Held(Vec<Holder>),
    /// The chip has disappeared.
    Gone {
        /// Which chips there are, if that was looked up.
        present: Option<String>,
    },
    /// All that is known from the error number alone.
    Hint(&'static str),
}

impl Cause {
    /// From the error number of a call on a device node; holders and other chips are not looked up.
    pub(in crate::pins) fn of(error: &io::Error, node: &Path) -> Cause {
        let errno = error.raw_os_error().unwrap_or_default();
        match Errno::from_raw(errno) {
            Errno::EACCES | Errno::EPERM => Cause::Closed(owning_group(node)),
            Errno::EBUSY => Cause::Held(Vec::new()),
            _ if is_gone(errno) => Cause::Gone { present: None },
            _ => Cause::Hint(hint(errno)),
        }
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Cause::Closed(None) => f.write_str(
                "the device node belongs to root alone: install the udev rule that gives it to a group",
            ),
            Cause::Closed(Some(group)) => write!(
                f,
                "the device node belongs to group {group}: add yourself to group {group} \
                 (sudo usermod -aG {group} USER, then log in again)"
            ),
            Cause::Held(holders) if holders.is_empty() => {
                f.write_str("another process or driver holds a line; cermctl lines shows which")
            }
            Cause::Held(holders) => {
                let holders: Vec<String> = holders.iter().map(Holder::to_string).collect();
                write!(f, "held by another consumer: {}", holders.join(", "))
            }
            Cause::Gone { present: None } => f.write_str("the chip is gone"),
            Cause::Gone { present: Some(present) } => write!(f, "the chip is gone; {present}"),
            Cause::Hint(hint) => f.write_str(hint),
        }
    }
}

/// Who holds a line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Holder {
    /// Name of the line, or "line 4".
    pub line: String,
    /// As which consumer; `None`: it gave no name.
    pub consumer: Option<String>,
}

impl fmt::Display for Holder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} (\"{}\")", self.line, self.consumer.as_deref().unwrap_or("unnamed"))
    }
}

/// The likely cause and the remedy by the error number alone.
pub(super) fn hint(errno: i32) -> &'static str {
    match Errno::from_raw(errno) {
        Errno::EINVAL => {
            "the kernel refuses a flag: older than 5.10 (use backend \"chardev-v1\"), or the controller lacks it"
        }
        Errno::ENOTTY => "this is not a GPIO chip",
        Errno::EPERM => "another program has turned the line into an input",
        Errno::EOPNOTSUPP => "the controller does not support this",
        Errno::EMFILE | Errno::ENFILE => "too many open files",
        _ => "unexpected: see the kernel log (dmesg)",
    }
}

/// Whether `errno` says that the chip itself has disappeared.
pub(super) fn is_gone(errno: i32) -> bool {
    matches!(Errno::from_raw(errno), Errno::ENODEV | Errno::ENXIO | Errno::ENOENT)
}

/// The name of the group that owns a device node, its number if it has no name; `None` for root's.
fn owning_group(node: &Path) -> Option<String> {
    let gid = std::fs::metadata(node).ok()?.gid();
    if gid == 0 {
        return None;
    }
    let group = Group::from_gid(Gid::from_raw(gid)).ok().flatten();
    Some(group.map_or_else(|| gid.to_string(), |group| group.name))
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

    fn cause(errno: i32) -> Cause {
        Cause::of(&io::Error::from_raw_os_error(errno), Path::new("/nonexistent"))
    }

    #[test]
    fn a_refusal_names_the_group_to_join() {
        let text = Cause::Closed(Some("gpio".to_owned())).to_string();
        assert!(text.contains("add yourself to group gpio") && text.contains("usermod -aG gpio"), "{text}");
        for errno in [libc::EACCES, libc::EPERM] {
            assert!(cause(errno).to_string().contains("udev rule"));
        }
    }

    #[test]
    fn a_busy_line_names_its_holder() {
        let holder = |consumer: Option<&str>| Holder {
            line: "GPIO20".to_owned(),
            consumer: consumer.map(str::to_owned),
        };
        let held = Cause::Held(vec![holder(Some("gpioset")), holder(None)]);
        assert_eq!(held.to_string(), "held by another consumer: GPIO20 (\"gpioset\"), GPIO20 (\"unnamed\")");
        let line = "sink-c1 (GPIO20)".to_owned();
        let source = io::Error::from_raw_os_error(libc::EBUSY);
        let error = ChardevError::Call { call: "GET_LINE", line, source, cause: held };
        assert!(error.is_busy() && error.is_held_by("gpioset") && !error.is_held_by("cermd"));
        assert!(cause(libc::EBUSY).to_string().contains("cermctl lines"));
    }

    #[test]
    fn a_lost_chip_names_the_others() {
        for errno in [libc::ENODEV, libc::ENOENT, libc::ENXIO] {
            assert_eq!(cause(errno), Cause::Gone { present: None });
        }
        let present = Some("chips present: gpiochip0 [pinctrl-rp1]".to_owned());
        let text = Cause::Gone { present }.to_string();
        assert_eq!(text, "the chip is gone; chips present: gpiochip0 [pinctrl-rp1]");
    }

    #[test]
    fn an_old_kernel_is_pointed_to_the_other_backend() {
        assert!(cause(libc::EINVAL).to_string().contains("chardev-v1"));
        assert!(cause(libc::EIO).to_string().contains("dmesg"));
    }

    #[test]
    fn a_chip_that_is_not_there_may_come_back() {
        let missing = ChardevError::NoChip { wanted: "x".into(), present: String::new() };
        assert!(missing.is_gone());
        assert!(!ChardevError::Wiring("x".into()).is_gone());
    }

    #[test]
    fn error_numbers_survive_the_conversion() {
        let os = v2::Error::Os(v2::Errno(libc::EBUSY));
        assert_eq!(as_io(os).raw_os_error(), Some(libc::EBUSY));
    }
}
