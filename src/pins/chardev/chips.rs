//! Chips by label, name or path, and lists of what there is.
//!
//! Numbers of chips change between kernels (the Raspberry Pi 5 went from gpiochip4 to gpiochip0), labels do not.

use super::error::{ChardevError, as_io, is_gone};
use gpiocdev_uapi::{v1, v2};
use serde::Serialize;
use std::fs::{File, Metadata, OpenOptions};
use std::io;
use std::os::fd::AsRawFd;
use std::os::unix::fs::{FileTypeExt, MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

/// Where the kernel's device nodes are.
const DEV: &str = "/dev";

/// One chip and its lines.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(tag = "class", rename = "CHIP")]
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
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct LineListing {
    /// Its number on the chip.
    pub offset: u32,
    /// Its name, if the board gives one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// "output" or "input". A released open-drain line counts as an output.
    pub direction: &'static str,
    /// Further settings, in the words of the kernel's documentation: "open-drain", "bias-disabled", ...
    pub flags: Vec<&'static str>,
    /// Whether it is taken.
    pub used: bool,
    /// By whom, if they gave a name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub consumer: Option<String>,
}

/// Every chip of this machine with its lines, or why it could not be opened.
pub fn list() -> impl Iterator<Item = Result<ChipListing, ChardevError>> {
    all(Path::new(DEV)).into_iter().map(|chip| chip.map(|chip| chip.listing))
}

/// An open chip.
#[derive(Debug)]
pub(in crate::pins) struct Chip {
    /// Its device node.
    pub file: File,
    /// What it told when it was opened.
    pub listing: ChipListing,
}

impl Chip {
    /// Opens a device node.
    fn open(path: &Path) -> Result<Chip, ChardevError> {
        let refuse = |call: &'static str, source: io::Error| {
            ChardevError::call(call, path.display().to_string(), source, path)
        };
        let file = open_node(path).map_err(|e| refuse("open", e))?;
        let info = v2::get_chip_info(&file).map_err(|e| refuse("GET_CHIPINFO", as_io(e)))?;
        let lines: Result<_, _> = (0..info.num_lines).map(|offset| line(&file, offset)).collect();
        let lines = lines.map_err(|e| refuse("GET_LINEINFO", as_io(e)))?;
        let (name, label) = (String::from(&info.name), String::from(&info.label));
        Ok(Chip { file, listing: ChipListing { name, label, path: path.to_path_buf(), lines } })
    }

    /// Finds the chip with this label, name or path.
    pub fn find(wanted: &str) -> Result<Chip, ChardevError> {
        find_in(Path::new(DEV), wanted)
    }

    /// "gpiochip0 [pinctrl-rp1]".
    pub fn title(&self) -> String {
        format!("{} [{}]", self.listing.name, self.listing.label)
    }

    /// A failed call on this chip, explained: who holds which of `offsets`, whose group the node is, which chips exist.
    pub fn refusal(
        &self,
        call: &'static str,
        lines: &str,
        offsets: &[u32],
        source: io::Error,
    ) -> ChardevError {
        let lines = format!("{lines} of {}", self.title());
        let error = ChardevError::call(call, lines, source, &self.listing.path);
        if error.is_gone() {
            return error
                .explained(format!("the chip is gone; {}", titles(&all(Path::new(DEV)))), Vec::new());
        }
        let held = offsets.iter().filter_map(|offset| line(&self.file, *offset).ok());
        explain_busy(error, &held.filter(|line| line.used).collect::<Vec<_>>())
    }
}

/// Opens a device node unless it is another device's: to open one may do something, such as start a watchdog. What was looked at
/// is what is opened, whatever the path leads to by then.
fn open_node(path: &Path) -> io::Result<File> {
    let looked_at = OpenOptions::new().read(true).custom_flags(libc::O_PATH).open(path)?;
    if is_another_device(&looked_at.metadata()?) {
        return Err(io::Error::from_raw_os_error(libc::ENOTTY));
    }
    OpenOptions::new().read(true).write(true).open(format!("/proc/self/fd/{}", looked_at.as_raw_fd()))
}

/// By what the kernel tells of device nodes; where it tells nothing, the first call will.
fn is_another_device(node: &Metadata) -> bool {
    let (major, minor) = (libc::major(node.rdev()), libc::minor(node.rdev()));
    let subsystem = std::fs::read_link(format!("/sys/dev/char/{major}:{minor}/subsystem"));
    let is_of_gpio = |link: PathBuf| link.file_name().is_some_and(|name| name == "gpio");
    node.file_type().is_block_device()
        || (node.file_type().is_char_device() && subsystem.is_ok_and(|link| !is_of_gpio(link)))
}

/// What a refused request for edges of `line` means: a chip that is still there has no interrupt for it. For which lines it
/// has one the kernel tells only to those who request them, which makes them inputs.
pub(in crate::pins) fn refused_edges(error: ChardevError, chip: &Chip, line: &str) -> ChardevError {
    no_interrupt(error, v2::get_chip_info(&chip.file).is_ok(), &format!("{line} of {}", chip.title()))
}

fn no_interrupt(error: ChardevError, is_there: bool, line: &str) -> ChardevError {
    match error {
        ChardevError::Call { call, source, .. } if is_there && is_gone(&source) => {
            ChardevError::Wiring(format!(
                "{line} has no interrupt ({call}: {source}), so its crossings cannot be stamped; sense by a line that has one, \
             of a controller in the processor rather than of an expander"
            ))
        }
        other => other,
    }
}

/// With the holders of the lines, if it is they who are in the way.
fn explain_busy(error: ChardevError, held: &[LineListing]) -> ChardevError {
    if !error.is_busy() || held.is_empty() {
        return error;
    }
    let holder = |line: &LineListing| {
        let name = line.name.clone().unwrap_or_else(|| format!("line {}", line.offset));
        format!("{name} (\"{}\")", line.consumer.as_deref().unwrap_or("unnamed"))
    };
    let holders: Vec<String> = held.iter().map(holder).collect();
    let consumers = held.iter().filter_map(|line| line.consumer.clone()).collect();
    error.explained(format!("held by another consumer: {}", holders.join(", ")), consumers)
}

/// What the kernel tells of one line.
fn line(chip: &File, offset: u32) -> v2::Result<LineListing> {
    match v2::get_line_info(chip, offset) {
        // The kernel is older than 5.10 (or the line is not there, which v1 answers in the same way).
        Err(v2::Error::Os(errno)) if errno.0 == libc::EINVAL => v1::get_line_info(chip, offset).map(as_v2),
        other => other,
    }
    .map(LineListing::from)
}

fn find_in(dev: &Path, wanted: &str) -> Result<Chip, ChardevError> {
    if wanted.contains('/') {
        return match Path::new(wanted).try_exists() {
            Ok(false) => missing(wanted, &all(dev)),
            _ => Chip::open(Path::new(wanted)),
        };
    }
    let chips = all(dev);
    let present = missing(wanted, &chips);
    let (opened, refused): (Vec<_>, Vec<_>) = chips.into_iter().partition(Result::is_ok);
    if let Some(chip) = choose(opened.into_iter().flatten(), wanted)? {
        return Ok(chip);
    }
    // A compatibility link such as /dev/gpiochip4 is no chip of its own, but a name that people use.
    let link = dev.join(wanted);
    if link.exists() {
        return Chip::open(&link);
    }
    // The one that is wanted may be among those that are closed to us: best named by one that a group may open.
    let no_group_may =
        |chip: &Result<Chip, ChardevError>| !chip.as_ref().is_err_and(ChardevError::asks_for_a_group);
    refused.into_iter().min_by_key(no_group_may).unwrap_or(present)
}

/// The one of these with this label or name.
fn choose(chips: impl Iterator<Item = Chip>, wanted: &str) -> Result<Option<Chip>, ChardevError> {
    let mut found: Vec<Chip> =
        chips.filter(|chip| chip.listing.name == wanted || chip.listing.label == wanted).collect();
    if found.len() > 1 {
        let names: Vec<String> = found.into_iter().map(|chip| chip.listing.name).collect();
        let names = names.join(", ");
        return Err(ChardevError::Wiring(format!(
            "several GPIO chips have the label \"{wanted}\": {names}; give the name or path of one"
        )));
    }
    Ok(found.pop())
}

fn missing(wanted: &str, present: &[Result<Chip, ChardevError>]) -> Result<Chip, ChardevError> {
    Err(ChardevError::NoChip { wanted: wanted.to_owned(), present: titles(present) })
}

/// Tries to open every chip below `dev`, in the order of their numbers; links to other nodes are left out.
fn all(dev: &Path) -> Vec<Result<Chip, ChardevError>> {
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

/// Name and label of each chip that can be opened, as a part of a sentence.
fn titles(chips: &[Result<Chip, ChardevError>]) -> String {
    let titles: Vec<String> = chips.iter().flatten().map(Chip::title).collect();
    match titles.as_slice() {
        [] => "no GPIO chip can be opened".to_owned(),
        some => format!("chips present: {}", some.join(", ")),
    }
}

/// The flags of uAPI v1 are some of those of v2, by the same names.
fn as_v2(info: v1::LineInfo) -> v2::LineInfo {
    let v1::LineInfo { offset, name, consumer, .. } = info;
    let flags = info.flags.iter_names().filter_map(|(name, _)| v2::LineFlags::from_name(name)).collect();
    v2::LineInfo { offset, name, consumer, flags, ..Default::default() }
}

impl From<v2::LineInfo> for LineListing {
    fn from(info: v2::LineInfo) -> LineListing {
        use v2::LineFlags as F;
        const WORDS: [(F, &str); 8] = [
            (F::ACTIVE_LOW, "active-low"),
            (F::OPEN_DRAIN, "open-drain"),
            (F::OPEN_SOURCE, "open-source"),
            (F::BIAS_PULL_UP, "pull-up"),
            (F::BIAS_PULL_DOWN, "pull-down"),
            (F::BIAS_DISABLED, "bias-disabled"),
            (F::EDGE_RISING, "rising-edges"),
            (F::EDGE_FALLING, "falling-edges"),
        ];
        let text = |name: &v2::Name| (!name.is_empty()).then(|| String::from(name));
        let words = WORDS.iter().filter(|(flag, _)| info.flags.contains(*flag));
        LineListing {
            offset: info.offset,
            name: text(&info.name),
            direction: if info.flags.contains(F::OUTPUT) { "output" } else { "input" },
            flags: words.map(|(_, word)| *word).collect(),
            used: info.flags.contains(F::USED),
            consumer: text(&info.consumer),
        }
    }
}

// One request holds all drive lines.
const _: () = assert!(crate::pins::MAX_CHANNELS + 4 <= v2::NUM_LINES_MAX);

#[cfg(test)]
impl Chip {
    /// One that no kernel has.
    pub fn of_lines(lines: Vec<LineListing>) -> Chip {
        let (name, label) = ("gpiochip0".to_owned(), "fake".to_owned());
        let listing = ChipListing { name, label, path: "/dev/gpiochip0".into(), lines };
        Chip { file: File::open("/dev/null").unwrap(), listing }
    }
}

#[cfg(test)]
mod tests;
