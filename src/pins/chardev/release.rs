//! For: turning every line of a wiring into an input after a program that held them was killed. Must not know: how
//! they were used.
//!
//! Raspberry Pi kernels leave outputs driving when their owner dies (`persist_gpio_outputs`).

use super::chips::Chip;
use super::error::{OpenError, as_io};
use super::request::release_request;
use super::wiring::{Line, Wiring};
use gpiocdev_uapi::v2;
use std::thread;
use std::time::Duration;

/// How often a line that is still held is asked for again: the kernel closes a killed process's files with a delay.
const ATTEMPTS: u32 = 10;
/// Between two attempts.
const PAUSE: Duration = Duration::from_millis(50);

/// Makes every line of the wiring an input, one by one, and lets go of it.
///
/// # Errors
/// The first failure; the other lines have been released all the same.
pub fn release_lines(wiring: &Wiring) -> Result<(), OpenError> {
    let chip = Chip::find(&wiring.chip)?;
    let lines = wiring.resolve(&chip)?;
    each_line(lines.drives.iter().map(|drive| &drive.line).chain(&lines.sense), |line| {
        v2::get_line(&chip.file, release_request(line, &wiring.consumer))
            .map(drop)
            .map_err(|error| chip.refusal("GET_LINE", line.title.clone(), &[line.offset], as_io(error)))
    })
}

/// Tries `release` on every line, again and again on those that are busy; keeps the first failure.
pub(in crate::pins) fn each_line<'a>(
    lines: impl Iterator<Item = &'a Line>,
    mut release: impl FnMut(&Line) -> Result<(), OpenError>,
) -> Result<(), OpenError> {
    let mut attempts_left = ATTEMPTS;
    let mut first_failure = Ok(());
    for line in lines {
        let mut outcome = release(line);
        while attempts_left > 0 && outcome.as_ref().is_err_and(is_busy) {
            attempts_left -= 1;
            thread::sleep(PAUSE);
            outcome = release(line);
        }
        first_failure = first_failure.and(outcome);
    }
    first_failure
}

fn is_busy(error: &OpenError) -> bool {
    matches!(error, OpenError::Call { source, .. } if source.raw_os_error() == Some(libc::EBUSY))
}

#[cfg(test)]
mod tests {
    use super::super::wiring::tests::{lines, wiring};
    use super::*;

    fn failure(errno: i32, line: &Line) -> OpenError {
        let source = std::io::Error::from_raw_os_error(errno);
        OpenError::Call { call: "GET_LINE", line: line.title.clone(), source, cause: String::new() }
    }

    #[test]
    fn a_busy_line_is_asked_for_again() {
        let lines = lines(&wiring());
        let mut asked = 0;
        let outcome = each_line(lines.sense.iter(), |line| {
            asked += 1;
            if asked < 3 { Err(failure(libc::EBUSY, line)) } else { Ok(()) }
        });
        assert!(outcome.is_ok());
        assert_eq!(asked, 4, "the first line three times, the second once");
    }

    #[test]
    fn one_failure_does_not_spare_the_other_lines() {
        let lines = lines(&wiring());
        let mut released = Vec::new();
        let outcome = each_line(lines.drives.iter().map(|drive| &drive.line), |line| {
            released.push(line.offset);
            if line.offset == 20 { Err(failure(libc::EIO, line)) } else { Ok(()) }
        });
        assert!(outcome.unwrap_err().to_string().contains("sink-c1 (GPIO20)"));
        assert_eq!(released, [16, 26, 20, 21, 13, 19]);
    }
}
