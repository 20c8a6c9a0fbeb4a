//! For: what the kernel's answer means to the person at the board: which call, which line, the likely cause.
//! Must not know: how lines are switched or timed.

use crate::pins::PinsError;
use gpiocdev_uapi::v2;
use nix::errno::Errno;
use nix::unistd::{Gid, Group};
use std::fmt::Write as _;
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

/// Why chips, lines or requests could not be had. Errors after that are [`PinsError`].
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
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
        cause: String,
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
    #[error("several GPIO chips have the label \"{label}\": {names}; give the name or path of one")]
    AmbiguousChip {
        /// As configured.
        label: String,
        /// Their names.
        names: String,
    },
    /// The chip has no such line.
    #[error("chip {chip} has no line \"{wanted}\"; {nearest}")]
    NoLine {
        /// Name and label of the chip.
        chip: String,
        /// As configured.
        wanted: String,
        /// The most similar names, or the range of offsets.
        nearest: String,
    },
    /// The wiring makes no sense, or not with this backend.
    #[error("{0}")]
    Wiring(String),
}

impl OpenError {
    /// Whether joining a group would help.
    pub(super) fn asks_for_a_group(&self) -> bool {
        matches!(self, OpenError::Call { source, line, .. }
            if source.kind() == io::ErrorKind::PermissionDenied && owning_group(Path::new(line)).is_some())
    }

    /// Whether opening again later may help: the chip is not there (any more, or yet).
    pub fn is_gone(&self) -> bool {
        match self {
            OpenError::NoChip { .. } => true,
            OpenError::Call { source, .. } => source.raw_os_error().is_some_and(is_gone),
            _ => false,
        }
    }
}

/// What the cause of a failed call depends on besides the error number.
#[derive(Debug, Default)]
pub(in crate::pins) struct Context<'a> {
    /// The group that owns the device node, other than root's.
    pub group: Option<&'a str>,
    /// Lines of the request that are in use, with their consumers: `GPIO20 ("gpioset")`.
    pub held: &'a [String],
    /// The chips that exist.
    pub chips: &'a str,
}

/// The likely cause of `errno` from a call of the character device, and the remedy.
pub(in crate::pins) fn cause(errno: i32, context: &Context) -> String {
    match Errno::from_raw(errno) {
        Errno::EACCES | Errno::EPERM => match context.group {
            None => "the device node belongs to root alone: install the udev rule that gives it to a group"
                .to_string(),
            Some(group) => format!(
                "the device node belongs to group {group}: add yourself to group {group} \
                 (sudo usermod -aG {group} USER, then log in again)"
            ),
        },
        Errno::EBUSY if context.held.is_empty() => {
            "another process or driver holds a line; cermctl lines shows which".to_string()
        }
        Errno::EBUSY => format!("held by another consumer: {}", context.held.join(", ")),
        Errno::ENOENT | Errno::ENODEV | Errno::ENXIO => {
            let mut text = "the chip is gone".to_string();
            if !context.chips.is_empty() {
                let _ = write!(text, "; {}", context.chips);
            }
            text
        }
        other => hint(other as i32).to_string(),
    }
}

/// The same for calls while measuring, where nothing can be looked up.
pub(in crate::pins) fn hint(errno: i32) -> &'static str {
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
pub(in crate::pins) fn is_gone(errno: i32) -> bool {
    matches!(Errno::from_raw(errno), Errno::ENODEV | Errno::ENXIO | Errno::ENOENT)
}

/// A failed call on an open request: the chip gone, or a failure with what is known without looking anything up.
pub(in crate::pins) fn while_running(
    call: &'static str,
    line: &str,
    chip: &str,
    source: io::Error,
) -> PinsError {
    let errno = source.raw_os_error().unwrap_or(0);
    if is_gone(errno) {
        return PinsError::Gone { chip: chip.to_string(), call, line: line.to_string() };
    }
    PinsError::Call { call, line: line.to_string(), source, hint: hint(errno) }
}

/// What came of sleeping, which fails only if the system is at fault.
pub(in crate::pins) fn while_sleeping(chip: &str, outcome: Result<(), Errno>) -> Result<(), PinsError> {
    outcome.map_err(|errno| while_running("clock_nanosleep", "CLOCK_MONOTONIC", chip, errno.into()))
}

/// The name of the group that owns a device node, its number if it has no name; `None` for root's.
pub(in crate::pins) fn owning_group(node: &Path) -> Option<String> {
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

    #[test]
    fn a_refusal_names_the_group_to_join() {
        let context = Context { group: Some("gpio"), ..Context::default() };
        assert!(cause(libc::EACCES, &context).contains("add yourself to group gpio"));
        assert!(cause(libc::EPERM, &context).contains("usermod -aG gpio"));
        assert!(cause(libc::EACCES, &Context::default()).contains("udev rule"));
    }

    #[test]
    fn a_busy_line_names_its_holder() {
        let held = ["GPIO20 (\"gpioset\")".to_string()];
        let text = cause(libc::EBUSY, &Context { held: &held, ..Context::default() });
        assert_eq!(text, "held by another consumer: GPIO20 (\"gpioset\")");
        assert!(cause(libc::EBUSY, &Context::default()).contains("cermctl lines"));
    }

    #[test]
    fn a_lost_chip_names_the_others() {
        let context = Context { chips: "chips present: gpiochip0 [pinctrl-rp1]", ..Context::default() };
        for errno in [libc::ENODEV, libc::ENOENT, libc::ENXIO] {
            let text = cause(errno, &context);
            assert!(text.starts_with("the chip is gone") && text.contains("pinctrl-rp1"), "{text}");
        }
    }

    #[test]
    fn an_old_kernel_is_pointed_to_the_other_backend() {
        assert!(cause(libc::EINVAL, &Context::default()).contains("chardev-v1"));
        assert!(cause(libc::EIO, &Context::default()).contains("dmesg"));
    }

    #[test]
    fn the_disappearance_of_a_chip_is_told_from_other_failures() {
        let error =
            while_running("GET_VALUES", "sense", "gpiochip0", io::Error::from_raw_os_error(libc::ENODEV));
        let expected = "the GPIO chip gpiochip0 is gone, says GET_VALUES on sense: its driver was unbound, or the board \
                        unplugged";
        assert!(matches!(error, PinsError::Gone { .. }) && error.to_string() == expected, "{error}");
        let error = while_running("SET_VALUES", "c1", "gpiochip0", io::Error::from_raw_os_error(libc::EIO));
        assert!(matches!(error, PinsError::Call { call: "SET_VALUES", .. }), "{error}");
        let missing = OpenError::NoChip { wanted: "x".into(), present: String::new() };
        assert!(missing.is_gone());
        assert!(!OpenError::Wiring("x".into()).is_gone());
    }

    #[test]
    fn error_numbers_survive_the_conversion() {
        let os = v2::Error::Os(v2::Errno(libc::EBUSY));
        assert_eq!(as_io(os).raw_os_error(), Some(libc::EBUSY));
    }
}
