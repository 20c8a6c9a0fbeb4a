//! Ctrl-C as a wish, for verbs that run until they are told to stop, and then end properly.

use super::CtlError;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Set by SIGINT, SIGTERM and SIGHUP; the second of them ends the process at once.
#[derive(Debug, Clone)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Takes over the handlers.
    pub fn new() -> Result<Interrupt, CtlError> {
        let wish = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM, SIGHUP] {
            // First the look at the flag, then the setting of it.
            signal_hook::flag::register_conditional_shutdown(signal, 1, Arc::clone(&wish))
                .and_then(|_| signal_hook::flag::register(signal, Arc::clone(&wish)))
                .map_err(CtlError::system("signal handlers"))?;
        }
        Ok(Interrupt(wish))
    }

    /// Whether somebody wants the end.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
