//! For: finding a chip by label, name or path; listing what there is. Must not know: what the lines are used for.
//!
//! Numbers of chips change between kernels (the Raspberry Pi 5 went from gpiochip4 to gpiochip0), labels do not.

use super::error::{Context, OpenError, as_io, cause, owning_group};
use gpiocdev_uapi::{v1, v2};
use std::fs::{File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};

/// Where the kernel's device nodes are.
const DEV: &str = "/dev";

/// The chips of this machine.
#[derive(Debug, Default)]
pub struct Listing {
    /// Those that could be opened, by path.
    pub chips: Vec<ChipListing>,
    /// Why the others could not.
    pub refused: Vec<OpenError>,
}

/// One chip and its lines.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChipListing {
    /// "gpiochip0".
    pub name: String,
    /// "pinctrl-rp1".
    pub label: String,
    /// "/dev/gpiochip0".
    pub path: PathBuf,
    /// In the order of their offsets.
    pub lines: Vec<LineListing>,
}

/// What the kernel tells about a line (GPIO_V2_GET_LINEINFO_IOCTL).
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct LineListing {
    /// Its number on the chip.
    pub offset: u32,
    /// Its name, if the board gives one.
    pub name: Option<String>,
    /// Output or input. A released open-drain line counts as an output.
    pub output: bool,
    /// Further settings, in the words of the kernel's documentation: "open-drain", "bias-disabled", ...
    pub flags: Vec<&'static str>,
    /// Whether it is taken.
    pub used: bool,
    /// By whom, if they gave a name.
    pub consumer: Option<String>,
}

/// All chips and lines.
pub fn list() -> Listing {
    let mut listing = Listing::default();
    for chip in all(Path::new(DEV)) {
        match chip.and_then(|chip| Ok((chip.lines()?, chip))) {
            Ok((lines, Chip { name, label, path, .. })) => {
                listing.chips.push(ChipListing { name, label, path, lines });
            }
            Err(error) => listing.refused.push(error),
        }
    }
    listing
}

/// An open chip.
#[derive(Debug)]
pub(in crate::pins) struct Chip {
    /// Its device node.
    pub file: File,
    /// Where that is.
    pub path: PathBuf,
    /// "gpiochip0".
    pub name: String,
    /// "pinctrl-rp1".
    pub label: String,
    count: u32,
}

impl Chip {
    /// Opens a device node.
    pub fn open(path: &Path) -> Result<Chip, OpenError> {
        let refuse = |call: &'static str, source: io::Error| {
            let group = owning_group(path);
            let context = Context { group: group.as_deref(), ..Context::default() };
            let cause = cause(source.raw_os_error().unwrap_or(0), &context);
            OpenError::Call { call, line: path.display().to_string(), source, cause }
        };
        let file = OpenOptions::new().read(true).write(true).open(path).map_err(|e| refuse("open", e))?;
        let info = v2::get_chip_info(&file).map_err(|e| refuse("GET_CHIPINFO", as_io(e)))?;
        Ok(Chip {
            file,
            path: path.to_path_buf(),
            name: String::from(&info.name),
            label: String::from(&info.label),
            count: info.num_lines,
        })
    }

    /// Finds the chip with this label, name or path.
    pub fn find(wanted: &str) -> Result<Chip, OpenError> {
        find_in(Path::new(DEV), wanted)
    }

    /// "gpiochip0 [pinctrl-rp1]".
    pub fn title(&self) -> String {
        format!("{} [{}]", self.name, self.label)
    }

    /// All lines, in the order of their offsets.
    pub fn lines(&self) -> Result<Vec<LineListing>, OpenError> {
        (0..self.count).map(|offset| self.line(offset)).collect()
    }

    fn line(&self, offset: u32) -> Result<LineListing, OpenError> {
        match v2::get_line_info(&self.file, offset).map(from_v2) {
            // The kernel is older than 5.10 (or the line is not there, which v1 answers in the same way).
            Err(v2::Error::Os(errno)) if errno.0 == libc::EINVAL => {
                v1::get_line_info(&self.file, offset).map(from_v1)
            }
            other => other,
        }
        .map_err(|error| self.refusal("GET_LINEINFO", format!("line {offset}"), &[], as_io(error)))
    }

    /// A failed call on this chip, explained: who holds which of `offsets`, whose group the node is, which chips exist.
    pub fn refusal(&self, call: &'static str, line: String, offsets: &[u32], source: io::Error) -> OpenError {
        let errno = source.raw_os_error().unwrap_or(0);
        let held: Vec<String> = match errno {
            libc::EBUSY => offsets.iter().filter_map(|offset| self.line(*offset).ok()?.holder()).collect(),
            _ => Vec::new(),
        };
        let group = owning_group(&self.path);
        let chips = if super::error::is_gone(errno) { present(&all(Path::new(DEV))) } else { String::new() };
        let context = Context { group: group.as_deref(), held: &held, chips: &chips };
        OpenError::Call {
            call,
            line: format!("{line} of {}", self.title()),
            source,
            cause: cause(errno, &context),
        }
    }
}

impl LineListing {
    /// `GPIO20 ("gpioset")`, if the line is taken.
    fn holder(&self) -> Option<String> {
        let name = self.name.clone().unwrap_or_else(|| format!("line {}", self.offset));
        let consumer = self.consumer.as_deref().unwrap_or("unnamed");
        self.used.then(|| format!("{name} (\"{consumer}\")"))
    }
}

fn find_in(dev: &Path, wanted: &str) -> Result<Chip, OpenError> {
    if wanted.contains('/') {
        return open_or_missing(dev, Path::new(wanted), wanted);
    }
    let chips = all(dev);
    let matches = |chip: &Result<Chip, OpenError>| {
        chip.as_ref().is_ok_and(|chip| chip.name == wanted || chip.label == wanted)
    };
    if chips.iter().filter(|chip| matches(chip)).count() > 1 {
        let names: Vec<String> =
            chips.into_iter().filter(|chip| matches(chip)).flatten().map(|chip| chip.name).collect();
        return Err(OpenError::AmbiguousChip { label: wanted.to_string(), names: names.join(", ") });
    }
    let present = present(&chips);
    let (found, refused): (Vec<_>, Vec<_>) = chips.into_iter().partition(|chip| matches(chip));
    if let Some(chip) = found.into_iter().next() {
        return chip;
    }
    // A compatibility link such as /dev/gpiochip4 is no chip of its own, but a name that people use.
    let link = dev.join(wanted);
    if link.exists() {
        return Chip::open(&link);
    }
    // The one that is wanted may be among those that are closed to us: best named by one that a group may open.
    let mut refused: Vec<OpenError> = refused.into_iter().filter_map(Result::err).collect();
    refused.sort_by_key(|error| !error.asks_for_a_group());
    match refused.into_iter().next() {
        Some(closed) => Err(closed),
        None => Err(OpenError::NoChip { wanted: wanted.to_string(), present }),
    }
}

fn open_or_missing(dev: &Path, path: &Path, wanted: &str) -> Result<Chip, OpenError> {
    match path.try_exists() {
        Ok(false) => Err(OpenError::NoChip { wanted: wanted.to_string(), present: present(&all(dev)) }),
        _ => Chip::open(path),
    }
}

/// Tries to open every chip below `dev`, in the order of their numbers; links to other nodes are left out.
fn all(dev: &Path) -> Vec<Result<Chip, OpenError>> {
    let Ok(entries) = std::fs::read_dir(dev) else { return Vec::new() };
    let mut nodes: Vec<(u32, PathBuf)> = entries
        .flatten()
        .filter(|entry| entry.file_type().is_ok_and(|kind| !kind.is_symlink()))
        .filter_map(|entry| {
            let number = entry.file_name().to_str()?.strip_prefix("gpiochip")?.parse().ok()?;
            Some((number, entry.path()))
        })
        .collect();
    nodes.sort();
    nodes.iter().map(|(_, path)| Chip::open(path)).collect()
}

fn present(chips: &[Result<Chip, OpenError>]) -> String {
    let titles: Vec<String> = chips.iter().flatten().map(Chip::title).collect();
    match titles.as_slice() {
        [] => "no GPIO chip can be opened".to_string(),
        some => format!("chips present: {}", some.join(", ")),
    }
}

fn text(name: &v2::Name) -> Option<String> {
    (!name.is_empty()).then(|| String::from(name))
}

fn from_v2(info: v2::LineInfo) -> LineListing {
    use v2::LineFlags as F;
    const WORDS: [(v2::LineFlags, &str); 8] = [
        (F::ACTIVE_LOW, "active-low"),
        (F::OPEN_DRAIN, "open-drain"),
        (F::OPEN_SOURCE, "open-source"),
        (F::BIAS_PULL_UP, "pull-up"),
        (F::BIAS_PULL_DOWN, "pull-down"),
        (F::BIAS_DISABLED, "bias-disabled"),
        (F::EDGE_RISING, "rising-edges"),
        (F::EDGE_FALLING, "falling-edges"),
    ];
    LineListing {
        offset: info.offset,
        name: text(&info.name),
        output: info.flags.contains(F::OUTPUT),
        flags: WORDS.iter().filter(|(flag, _)| info.flags.contains(*flag)).map(|(_, word)| *word).collect(),
        used: info.flags.contains(F::USED),
        consumer: text(&info.consumer),
    }
}

fn from_v1(info: v1::LineInfo) -> LineListing {
    use v1::LineInfoFlags as F;
    const WORDS: [(v1::LineInfoFlags, &str); 6] = [
        (F::ACTIVE_LOW, "active-low"),
        (F::OPEN_DRAIN, "open-drain"),
        (F::OPEN_SOURCE, "open-source"),
        (F::BIAS_PULL_UP, "pull-up"),
        (F::BIAS_PULL_DOWN, "pull-down"),
        (F::BIAS_DISABLED, "bias-disabled"),
    ];
    LineListing {
        offset: info.offset,
        name: text(&info.name),
        output: info.flags.contains(F::OUTPUT),
        flags: WORDS.iter().filter(|(flag, _)| info.flags.contains(*flag)).map(|(_, word)| *word).collect(),
        used: info.flags.contains(F::USED),
        consumer: text(&info.consumer),
    }
}

// One request holds all drive lines.
const _: () = assert!(crate::pins::MAX_CHANNELS + 4 <= v2::NUM_LINES_MAX);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_chip_says_so_and_may_come_later() {
        let empty = tempfile::tempdir().unwrap();
        for wanted in ["pinctrl-rp1", "/nonexistent/gpiochip0"] {
            let error = find_in(empty.path(), wanted).unwrap_err();
            assert!(error.is_gone());
            assert!(
                error.to_string().contains(wanted) && error.to_string().contains("no GPIO chip"),
                "{error}"
            );
        }
    }

    #[test]
    fn what_is_no_chip_is_refused_by_the_kernel_call() {
        let dev = tempfile::tempdir().unwrap();
        std::fs::write(dev.path().join("gpiochip0"), "").unwrap();
        std::os::unix::fs::symlink(dev.path().join("gpiochip0"), dev.path().join("gpiochip4")).unwrap();
        assert_eq!(all(dev.path()).len(), 1, "a link is not a second chip");
        let error = find_in(dev.path(), "pinctrl-rp1").unwrap_err();
        assert!(matches!(&error, OpenError::Call { call: "GET_CHIPINFO", .. }), "{error}");
        assert!(error.to_string().contains("not a GPIO chip"), "{error}");
    }

    #[test]
    fn the_kernels_words_for_a_line_are_kept() {
        let info = v2::LineInfo {
            name: "GPIO20".into(),
            consumer: "cermd".into(),
            offset: 20,
            flags: v2::LineFlags::USED | v2::LineFlags::OUTPUT | v2::LineFlags::OPEN_DRAIN,
            ..Default::default()
        };
        let line = from_v2(info);
        assert!(line.output && line.used);
        assert_eq!(line.flags, ["open-drain"]);
        assert_eq!(line.holder().as_deref(), Some("GPIO20 (\"cermd\")"));
        assert_eq!(LineListing::default().holder(), None);
    }
}
