//! The end of a thread that was told to stop, which is waited for, but not for ever.

use super::limits::{STOP_LOOK, STOP_PATIENCE};
use crate::pins::monotonic;
use std::thread::{self, JoinHandle};

/// It does not end. Waiting once is enough: it is left behind.
#[derive(Debug)]
pub struct Hung;

/// What a thread leaves. `None`: it was waited for before, or has panicked, which was reported when it happened.
///
/// # Errors
/// A call of it hangs in the kernel.
pub fn end<T>(thread: &mut Option<JoinHandle<T>>) -> Result<Option<T>, Hung> {
    let Some(thread) = thread.take() else { return Ok(None) };
    let patience_ends = monotonic() + STOP_PATIENCE;
    while !thread.is_finished() {
        if monotonic() >= patience_ends {
            return Err(Hung);
        }
        thread::sleep(STOP_LOOK);
    }
    Ok(thread.join().ok())
}
