//! Every line of a wiring made an input, after a program that held them was killed.
//!
//! Raspberry Pi kernels leave outputs driving when their owner dies (`persist_gpio_outputs`).

use super::chips::Chip;
use super::error::{ChardevError, as_io};
use super::request::release_request;
use super::wiring::{Lines, WiredLine, Wiring};
use crate::pins::limits::{RELEASE_ATTEMPTS, RELEASE_PAUSE};
use gpiocdev_uapi::v2;
use std::thread;

/// Makes every line of the wiring an input, one by one, and lets go of it.
///
/// # Errors
/// The first failure; the other lines have been released all the same.
pub fn release_lines(wiring: &Wiring) -> Result<(), ChardevError> {
    let chip = Chip::find(&wiring.chip)?;
    each_line(&wiring.resolve(&chip)?, |line| {
        v2::get_line(&chip.file, release_request(line, &wiring.consumer))
            .map(drop)
            .map_err(|error| chip.refusal("GET_LINE", &line.title, &[line.offset], as_io(error)))
    })
}

/// Tries `release` on every line, again and again on those that are busy: the kernel closes the files of a killed
/// process with a delay. Keeps the first failure.
pub(in crate::pins) fn each_line(
    lines: &Lines,
    mut release: impl FnMut(&WiredLine) -> Result<(), ChardevError>,
) -> Result<(), ChardevError> {
    let mut attempts_left = RELEASE_ATTEMPTS;
    let mut first_failure = Ok(());
    for line in lines.drives.iter().chain(&lines.sense) {
        let mut outcome = release(line);
        while attempts_left > 0 && outcome.as_ref().is_err_and(ChardevError::is_busy) {
            attempts_left -= 1;
            thread::sleep(RELEASE_PAUSE);
            outcome = release(line);
        }
        first_failure = first_failure.and(outcome);
    }
    first_failure
}

#[cfg(test)]
mod tests {
    use super::super::wiring::tests::{lines, wiring};
    use super::*;

    fn failure(errno: i32, line: &WiredLine) -> ChardevError {
        let source = std::io::Error::from_raw_os_error(errno);
        ChardevError::call("GET_LINE", line.title.clone(), source, std::path::Path::new("/nonexistent"))
    }

    #[test]
    fn a_busy_line_is_asked_for_again() {
        let lines = lines(&wiring());
        let mut asked = 0;
        let outcome = each_line(&lines, |line| {
            asked += 1;
            if asked < 3 { Err(failure(libc::EBUSY, line)) } else { Ok(()) }
        });
        assert!(outcome.is_ok());
        assert_eq!(asked, 10, "the first line three times, the other seven once");
    }

    #[test]
    fn one_failure_does_not_spare_the_other_lines() {
        let lines = lines(&wiring());
        let mut released = Vec::new();
        let outcome = each_line(&lines, |line| {
            released.push(line.offset);
            if line.offset == 20 { Err(failure(libc::EIO, line)) } else { Ok(()) }
        });
        assert!(outcome.unwrap_err().to_string().contains("sink-c1 (GPIO20)"));
        assert_eq!(released, [16, 26, 20, 21, 13, 19, 5, 6]);
    }
}
