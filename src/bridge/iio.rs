//! Industrial I/O: the protocol of iiod 0.x on TCP, so that libiio's programs and bindings read the channels as those of a
//! device. <https://analogdevicesinc.github.io/libiio/>
//!
//! Each channel is `resistanceN`, and `forceN` where it has a force. Values are whole thousandths (`scale`). A channel
//! without a number has none here either: its attributes are an error (ENODATA), its `status` says why, and a buffer has no
//! row then, which the `timestamp` shows.

mod context;
mod rows;
mod session;

use super::feed::{Feed, Heard};
use super::latest::{Latest, now};
use super::limits::{IIO_CLIENTS, IIO_IDLE, IIO_READINGS, PAGE_PATIENCE};
use super::queue::{Inlet, Outlet, queue};
use super::server::{self, Place, Places};
use super::{BridgeError, Upstream, Wish, lock};
use crate::stream::wire::ReadingLine;
use crate::units::Nanos;
use nix::sys::socket::{setsockopt, sockopt};
use session::Session;
use std::io;
use std::net::{SocketAddr, TcpStream};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// What the sessions share.
#[derive(Debug)]
pub struct Buffers {
    latest: Latest,
    /// A reading that is older is no row.
    patience: Nanos,
    /// Buffers that are open. A slow one loses readings, which its timestamps show.
    buffers: Vec<Inlet<Arc<ReadingLine>>>,
}

type SharedBuffers = Arc<Mutex<Buffers>>;

impl Buffers {
    fn new(patience: Duration) -> Buffers {
        let latest = Latest::new(patience);
        Buffers { latest, patience: Nanos::from_seconds(patience.as_secs_f64()), buffers: Vec::new() }
    }

    fn hear(&mut self, heard: &Heard) {
        self.latest.hear(heard);
        if let Heard::Reading(reading, _) = heard {
            // A daemon that was asleep may say first what it had measured before.
            if now() - Nanos(reading.t_mono_ns) > self.patience {
                return;
            }
            let reading: Arc<ReadingLine> = Arc::new((**reading).clone());
            self.buffers.retain(|buffer| buffer.offer(Arc::clone(&reading)) || buffer.is_read());
        }
    }

    fn open(&mut self) -> Outlet<Arc<ReadingLine>> {
        // Where no daemon is, nothing is sent that would show which are closed.
        self.buffers.retain(Inlet::is_read);
        let (buffer, readings) = queue(IIO_READINGS);
        self.buffers.push(buffer);
        readings
    }
}

/// Serves until somebody wants the end.
///
/// # Errors
/// The address is not to be had.
pub fn run(source: Upstream, address: SocketAddr, wish: Wish<'_>) -> Result<(), BridgeError> {
    let (listener, bound) = server::listen(address)?;
    log::info!("serving ip:{bound}");
    let hub: SharedBuffers = Arc::new(Mutex::new(Buffers::new(source.patience)));
    std::thread::scope(|scope| {
        scope.spawn(|| Feed::new(source.socket, None).hear(wish, |heard| lock(&hub).hear(heard)));
        let hub = Arc::clone(&hub);
        let places = Places::new(IIO_CLIENTS, IIO_IDLE);
        server::serve(&listener, &places, move |socket, place| converse(socket, &hub, place), wish);
    });
    Ok(())
}

fn converse(socket: TcpStream, hub: &SharedBuffers, place: &Place) -> io::Result<()> {
    socket.set_nodelay(true)?;
    socket.set_write_timeout(Some(PAGE_PATIENCE))?;
    // A client may be silent for hours; one whose machine is gone must not keep its place.
    setsockopt(&socket, sockopt::KeepAlive, &true)?;
    Session::new(socket, Arc::clone(hub), place)?.run()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bridge::latest::tests::{ok, reading, up};

    #[test]
    fn a_buffer_gets_what_is_fresh() {
        let mut shared = Buffers::new(Duration::from_secs(10));
        shared.hear(&up(&["thumb"]));
        let buffer = shared.open();
        shared.hear(&reading("thumb", now().0 - 11_000_000_000, ok(1.0)));
        shared.hear(&reading("thumb", now().0, ok(2.0)));
        let heard: Vec<_> = buffer.waiting().map(|reading| reading.state.r_ohm).collect();
        assert_eq!(heard, [Some(2.0)]);
        drop(buffer);
        shared.hear(&reading("thumb", now().0, ok(3.0)));
        assert!(shared.buffers.is_empty());
    }

    #[test]
    fn a_closed_buffer_leaves_nothing_behind_though_no_reading_comes() {
        let mut shared = Buffers::new(Duration::from_secs(10));
        let kept = shared.open();
        (0..1000).for_each(|_| drop(shared.open()));
        assert_eq!(shared.buffers.len(), 2);
        shared.hear(&reading("thumb", now().0, ok(3.0)));
        assert_eq!(kept.waiting().count(), 1);
    }
}
