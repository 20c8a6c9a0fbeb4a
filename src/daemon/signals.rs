//! Signals as a descriptor to poll: SIGTERM and SIGINT ask for the end, SIGHUP for a reload.

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::{flag, low_level};
use std::io::{self, Read, Write};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The signals of this process. Its descriptor is readable after one has come.
#[derive(Debug)]
pub struct Signals {
    woken: UnixStream,
    end: Arc<AtomicBool>,
    reload: Arc<AtomicBool>,
}

/// What was asked for since the last look.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Signalled {
    /// To stop.
    pub end: bool,
    /// To read the configuration again.
    pub reload: bool,
}

impl Signals {
    /// Takes over the handlers of SIGTERM, SIGINT and SIGHUP.
    ///
    /// # Errors
    /// The system refuses a descriptor or a handler.
    pub fn new() -> io::Result<Signals> {
        let (signals, StopHandle { waker, .. }) = Signals::from_handle()?;
        for (signal, asked) in [(SIGTERM, &signals.end), (SIGINT, &signals.end), (SIGHUP, &signals.reload)] {
            // The flag first: handlers run in the order of their registration.
            flag::register(signal, Arc::clone(asked))?;
            low_level::pipe::register(signal, waker.try_clone()?)?;
        }
        Ok(signals)
    }

    /// No signal at all: the end comes from the other half, for a daemon that is a part of another program.
    ///
    /// # Errors
    /// The system refuses a descriptor.
    pub fn from_handle() -> io::Result<(Signals, StopHandle)> {
        let (woken, waker) = UnixStream::pair()?;
        woken.set_nonblocking(true)?;
        let signals = Signals { woken, end: Arc::default(), reload: Arc::default() };
        let handle = StopHandle { waker, end: Arc::clone(&signals.end) };
        Ok((signals, handle))
    }

    /// What was asked for, once.
    pub fn take(&mut self) -> Signalled {
        let mut bytes = [0; 64];
        while matches!(self.woken.read(&mut bytes), Ok(count) if count > 0) {}
        Signalled {
            end: self.end.swap(false, Ordering::SeqCst),
            reload: self.reload.swap(false, Ordering::SeqCst),
        }
    }
}

/// Ends a daemon that runs on another thread.
#[derive(Debug)]
pub struct StopHandle {
    waker: UnixStream,
    end: Arc<AtomicBool>,
}

impl StopHandle {
    /// Asks for the end, as SIGTERM would.
    pub fn stop(mut self) {
        self.end.store(true, Ordering::SeqCst);
        // It fails only when the daemon has ended by itself.
        let _ = self.waker.write(&[0]);
    }
}

impl AsFd for Signals {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.woken.as_fd()
    }
}
