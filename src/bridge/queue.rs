//! A queue to one client, each end of which knows whether the other is still there.
//!
//! For: what a feed leaves for a client that reads at its own pace, or has gone without a word. Must not know: what that is.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

/// The end of the feed.
#[derive(Debug)]
pub struct Inlet<T> {
    items: SyncSender<T>,
    /// Of both ends: there are two as long as neither has gone.
    both: Arc<()>,
}

/// The end of the client.
#[derive(Debug)]
pub struct Outlet<T> {
    items: Receiver<T>,
    both: Arc<()>,
}

/// A queue with room for so many.
pub fn queue<T>(room: usize) -> (Inlet<T>, Outlet<T>) {
    let (to, from) = sync_channel(room);
    let both = Arc::new(());
    (Inlet { items: to, both: Arc::clone(&both) }, Outlet { items: from, both })
}

impl<T> Inlet<T> {
    /// Never waits; whether there was room, and somebody who reads.
    pub fn offer(&self, item: T) -> bool {
        self.items.try_send(item).is_ok()
    }

    /// Whether somebody reads.
    pub fn is_read(&self) -> bool {
        Arc::strong_count(&self.both) > 1
    }
}

impl<T> Outlet<T> {
    /// The next one.
    ///
    /// # Errors
    /// Nothing has come in time, or nothing will.
    pub fn next(&self, patience: Duration) -> Result<T, RecvTimeoutError> {
        self.items.recv_timeout(patience)
    }

    /// Whether more may come than what waits already.
    pub fn is_fed(&self) -> bool {
        Arc::strong_count(&self.both) > 1
    }

    /// What waits.
    #[cfg(test)]
    pub fn waiting(&self) -> impl Iterator<Item = T> {
        self.items.try_iter()
    }
}
