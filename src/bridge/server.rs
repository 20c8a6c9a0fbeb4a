//! Clients of a listener: a thread for each, so many at a time. Where all places are taken, the client that has been silent for
//! the longest gives way to the next one, if it has been silent for long enough.

use super::limits::{ACCEPT_PAUSE, LOOK_AROUND, STACK_BYTES};
use super::{BridgeError, Wish};
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use std::collections::VecDeque;
use std::io;
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::os::fd::AsFd;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};

/// Listens. The second is the address, where any port would do.
///
/// # Errors
/// The address is taken, not of this machine, or not for this user.
pub fn listen(address: SocketAddr) -> Result<(TcpListener, SocketAddr), BridgeError> {
    let failed = |error| BridgeError::Listen { address, error };
    let listener = TcpListener::bind(address).map_err(failed)?;
    listener.set_nonblocking(true).map_err(failed)?;
    let bound = listener.local_addr().unwrap_or(address);
    if !bound.ip().is_loopback() {
        log::warn!(
            "whoever reaches {bound} over the network may read it, and read along: there is no password"
        );
    }
    Ok((listener, bound))
}

/// Has `converse` talk to each client, in a thread of its own, until somebody wants the end.
pub fn serve<C>(listener: &TcpListener, places: &Places, converse: C, wish: Wish<'_>)
where
    C: Fn(TcpStream, &Place) -> io::Result<()> + Send + Sync + 'static,
{
    let converse = Arc::new(converse);
    while !wish() {
        match listener.accept() {
            Ok((socket, _)) => {
                let Some(place) = places.admit(&socket) else { continue };
                let converse = Arc::clone(&converse);
                let spawned = std::thread::Builder::new().stack_size(STACK_BYTES).spawn(move || {
                    // Whoever breaks off has gone, which is his right.
                    let _ = socket.set_nonblocking(false).and_then(|()| converse(socket, &place));
                });
                if spawned.is_err() {
                    std::thread::sleep(ACCEPT_PAUSE);
                }
            }
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => {
                let mut ready = [PollFd::new(listener.as_fd(), PollFlags::POLLIN)];
                // A signal wakes it, and the wish is looked at.
                let _ = poll(&mut ready, PollTimeout::try_from(LOOK_AROUND).unwrap_or(PollTimeout::MAX));
            }
            // Out of descriptors, or a connection that ended before it was taken.
            Err(_) => std::thread::sleep(ACCEPT_PAUSE),
        }
    }
}

/// Places for so many clients.
#[derive(Clone)]
pub struct Places {
    most: usize,
    /// After which a client gives way.
    silence: Duration,
    taken: Arc<Mutex<Taken>>,
}

#[derive(Default)]
struct Taken {
    next: u64,
    /// Those that have been silent for the longest first.
    clients: VecDeque<Occupant>,
}

struct Occupant {
    number: u64,
    heard_at: Instant,
    socket: TcpStream,
}

/// A place among them, given back when it is dropped.
pub struct Place {
    places: Places,
    number: u64,
}

impl Places {
    /// Nobody is there.
    pub fn new(most: usize, silence: Duration) -> Places {
        Places { most, silence, taken: Arc::default() }
    }

    fn lock(&self) -> MutexGuard<'_, Taken> {
        super::lock(&self.taken)
    }

    /// `None`: there is none, or no descriptor for it.
    fn admit(&self, socket: &TcpStream) -> Option<Place> {
        let socket = socket.try_clone().ok()?;
        let mut taken = self.lock();
        if taken.clients.len() >= self.most {
            let longest = taken.clients.front()?;
            if longest.heard_at.elapsed() < self.silence {
                return None;
            }
            // Its thread sees the end, and ends.
            let _ = longest.socket.shutdown(Shutdown::Both);
            taken.clients.pop_front();
        }
        let number = taken.next;
        taken.next += 1;
        taken.clients.push_back(Occupant { number, heard_at: Instant::now(), socket });
        Some(Place { places: self.clone(), number })
    }
}

impl Place {
    /// The client is no longer counted, and does not give way.
    pub fn give_back(&self) {
        self.places.lock().clients.retain(|client| client.number != self.number);
    }

    /// The client says something, or is being told something.
    pub fn keep(&self) {
        let mut taken = self.places.lock();
        let at = taken.clients.iter().position(|client| client.number == self.number);
        if let Some(mut client) = at.and_then(|at| taken.clients.remove(at)) {
            client.heard_at = Instant::now();
            taken.clients.push_back(client);
        }
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.give_back();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    /// Both ends of a connection; the first is the client's.
    fn connection() -> [TcpStream; 2] {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let client = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        client.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        [client, listener.accept().unwrap().0]
    }

    fn is_ended(client: &mut TcpStream) -> bool {
        client.set_nonblocking(true).unwrap();
        matches!(client.read(&mut [0]), Ok(0))
    }

    #[test]
    fn the_longest_silent_client_gives_way() {
        let places = Places::new(2, Duration::ZERO);
        let mut connections: Vec<_> = (0..4).map(|_| connection()).collect();
        let first = places.admit(&connections[0][1]).unwrap();
        let _second = places.admit(&connections[1][1]).unwrap();
        first.keep();
        let _third = places.admit(&connections[2][1]).unwrap();
        let ended = |connections: &mut [[TcpStream; 2]]| -> Vec<bool> {
            connections.iter_mut().map(|[client, _]| is_ended(client)).collect()
        };
        assert_eq!(ended(&mut connections), [false, true, false, false]);
        // Who has left, or is not counted any more, makes room.
        drop(first);
        let _fourth = places.admit(&connections[3][1]).unwrap();
        assert_eq!(ended(&mut connections), [false, true, false, false]);
    }

    #[test]
    fn nobody_gives_way_who_was_heard_of_lately() {
        let places = Places::new(1, Duration::from_secs(3600));
        let [[mut client, first], [_, second]] = [connection(), connection()];
        let place = places.admit(&first).unwrap();
        assert!(places.admit(&second).is_none());
        assert!(!is_ended(&mut client));
        place.give_back();
        assert!(places.admit(&second).is_some());
    }
}
