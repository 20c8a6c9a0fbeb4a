//! A line of its own that says something to other hardware: high or low, and an input whenever it is not held.
//!
//! It is driven both ways and inactive from the first moment on. When it is let go of, it is made inactive, then an input: what
//! it is from there on is a matter of a resistor on the board.

use super::chardev::chips::Chip;
use super::chardev::error::{ChardevError, as_io};
use super::chardev::wiring::{line_offset, patient};
use super::chardev::{Failed, explain};
use super::limits::RELEASE_ATTEMPTS;
use super::{PinsError, chardev_v1};
use embedded_hal::digital::OutputPin;
use gpiocdev_uapi::v2::{self, LineConfig, LineFlags, LineRequest, LineValues, Offsets};
use linux_embedded_hal::CdevPin;
use serde::{Deserialize, Serialize};
use std::fs::File;

/// Which line, and what is active.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct OutputLine {
    /// Label, name or path of the chip.
    pub chip: String,
    /// Name ("GPIO17") or offset ("17") of the line.
    pub line: String,
    /// Whether it is low when it is active.
    pub active_low: bool,
    /// What other programs see as the consumer of the line.
    pub consumer: String,
}

/// By way of what a line is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// uAPI v2: Linux 5.10 and later.
    V2,
    /// uAPI v1, which newer kernels may be built without.
    V1,
    /// No line at all: what it would do is logged.
    Simulated,
}

/// A held line.
pub struct Output {
    held: HeldLine,
    active_low: bool,
    /// What errors call the chip and the line.
    chip: String,
    title: String,
}

enum HeldLine {
    V2(File),
    /// `None` only while it is let go of.
    V1(Option<CdevPin>),
    Simulated,
}

impl Output {
    /// Takes the line, inactive.
    ///
    /// # Errors
    /// There is no such chip or line, or somebody else holds it.
    pub fn open(line: &OutputLine, way: Way) -> Result<Output, ChardevError> {
        let title = format!("output {}", line.line);
        if way == Way::Simulated {
            return Ok(Output {
                held: HeldLine::Simulated,
                active_low: line.active_low,
                chip: line.chip.clone(),
                title,
            });
        }
        let chip = Chip::find(&line.chip)?;
        let offset = line_offset(&chip.listing.lines, &line.line, &chip.title())?;
        let high = line.active_low;
        let held = if way == Way::V2 {
            let config = driven(high);
            let request = LineRequest {
                offsets: Offsets::from_slice(&[offset]),
                consumer: line.consumer.as_str().into(),
                config,
                num_lines: 1,
                ..Default::default()
            };
            let file = v2::get_line(&chip.file, request);
            HeldLine::V2(file.map_err(|error| chip.refusal("GET_LINE", &title, &[offset], as_io(error)))?)
        } else {
            HeldLine::V1(Some(chardev_v1::output(&chip, offset, high, &title, &line.consumer)?))
        };
        Ok(Output { held, active_low: line.active_low, chip: chip.title(), title })
    }

    /// Makes it active or inactive.
    ///
    /// # Errors
    /// The chip is gone, or the kernel refuses: what the line does is not known then.
    pub fn set(&mut self, active: bool) -> Result<(), PinsError> {
        let high = active != self.active_low;
        let failed = |call, source| -> Failed { (call, source, self.title.clone()) };
        let outcome = match &mut self.held {
            HeldLine::V2(file) => v2::set_line_values(&*file, &LineValues { bits: high.into(), mask: 1 })
                .map_err(|error| failed("SET_VALUES", as_io(error))),
            HeldLine::V1(pin) => pin.as_mut().map_or(Ok(()), |pin| {
                pin.set_state(high.into())
                    .map_err(|error| failed("SET_LINE_VALUES", chardev_v1::last_call(error.inner())))
            }),
            HeldLine::Simulated => {
                log::info!("simulated {}: {}", self.title, if active { "active" } else { "inactive" });
                Ok(())
            }
        };
        outcome.map_err(|failed| explain(&self.chip, failed))
    }
}

impl Drop for Output {
    /// Nothing can be done about an error here; the chip is gone.
    fn drop(&mut self) {
        let _ = self.set(false);
        match &mut self.held {
            HeldLine::V2(file) => drop(v2::set_line_config(
                &*file,
                LineConfig { flags: LineFlags::INPUT, ..Default::default() },
            )),
            HeldLine::V1(pin) => drop(pin.take().map(CdevPin::into_input_pin)),
            HeldLine::Simulated => {}
        }
    }
}

/// An output at this level from the request on.
fn driven(high: bool) -> LineConfig {
    let mut config = LineConfig { flags: LineFlags::OUTPUT, ..Default::default() };
    config.add_values(&LineValues { bits: high.into(), mask: 1 });
    config
}

/// Makes each of the lines inactive, then an input: for after a kill. Lines that are still held are asked for again, all together
/// for as long as one would be.
///
/// # Errors
/// Of each line, as [`Output::open`].
pub fn release_each(lines: &[OutputLine], way: Way) -> Vec<Result<(), ChardevError>> {
    let mut attempts_left = RELEASE_ATTEMPTS;
    lines.iter().map(|line| patient(&mut attempts_left, || Output::open(line, way)).map(drop)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line() -> OutputLine {
        let [chip, line, consumer] = ["no-such-chip", "GPIO17", "cermd"].map(str::to_owned);
        OutputLine { chip, line, active_low: true, consumer }
    }

    #[test]
    fn a_simulated_line_takes_everything_and_another_needs_its_chip() {
        let mut output = Output::open(&line(), Way::Simulated).unwrap();
        output.set(true).unwrap();
        output.set(false).unwrap();
        assert!(release_each(&[line(), line()], Way::Simulated).iter().all(Result::is_ok));
        for way in [Way::V1, Way::V2] {
            for outcome in release_each(&[line(), line()], way) {
                let error = outcome.unwrap_err();
                assert!(error.is_gone() && error.to_string().contains("no-such-chip"), "{error}");
            }
        }
    }

    #[test]
    fn a_line_is_driven_at_its_level_from_the_request_on() {
        for high in [false, true] {
            let config = driven(high);
            assert_eq!((config.flags, config.num_attrs), (LineFlags::OUTPUT, 1));
            let attribute = &config.attrs.0[0];
            let value = attribute.attr.to_value().unwrap();
            assert_eq!((attribute.mask, value), (1, v2::LineAttributeValue::Values(high.into())));
        }
    }
}
