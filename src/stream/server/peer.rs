//! One connected client: its socket and its session, and the bytes between them. Nothing here ever waits.

use super::StatsSource;
use super::hub::Hub;
use super::limits::User;
use super::session::Session;
use crate::stream::limits::serving::{LINES_PER_TURN, READ_BYTES};
use nix::errno::Errno;
use nix::sys::epoll::{Epoll, EpollEvent, EpollFlags};
use nix::sys::socket::{self, MsgFlags};
use std::os::fd::AsRawFd;
use std::os::unix::net::UnixStream;

/// How every line is sent: never waiting, never raising SIGPIPE.
pub(super) const SEND: MsgFlags = MsgFlags::MSG_DONTWAIT.union(MsgFlags::MSG_NOSIGNAL);

/// A connected client.
#[derive(Debug)]
pub(super) struct Peer {
    socket: UnixStream,
    pub user: User,
    pub session: Session,
    /// What epoll watches for.
    interest: EpollFlags,
    /// It has closed its side.
    has_ended: bool,
}

/// The connection is no more.
pub(super) struct Gone;

impl Peer {
    /// Takes the connection into the watch of `epoll`.
    pub fn new(
        (socket, user): (UnixStream, User),
        hub: &Hub,
        queue_lines: usize,
        (epoll, token): (&Epoll, u64),
    ) -> nix::Result<Peer> {
        let interest = EpollFlags::EPOLLIN;
        epoll.add(&socket, EpollEvent::new(interest, token))?;
        let session = Session::new(hub, queue_lines);
        Ok(Peer { socket, user, session, interest, has_ended: false })
    }

    /// Whether it still has something older to read.
    pub fn is_behind(&self) -> bool {
        self.interest.contains(EpollFlags::EPOLLOUT)
    }

    /// Does what `events` allow, and whatever else is due.
    pub fn attend(
        &mut self,
        events: EpollFlags,
        hub: &Hub,
        stats: &StatsSource<'_>,
        (epoll, token): (&Epoll, u64),
    ) -> Result<(), Gone> {
        if events.intersects(EpollFlags::EPOLLHUP | EpollFlags::EPOLLERR) {
            return Err(Gone);
        }
        if events.contains(EpollFlags::EPOLLIN) {
            self.receive()?;
        }
        let has_all = self.send(hub, stats)?;
        let mut interest = EpollFlags::empty();
        interest.set(EpollFlags::EPOLLOUT, !has_all);
        // A client that does not read its answers is not heard: that bounds them.
        interest.set(EpollFlags::EPOLLIN, self.session.is_listening() && !self.has_ended);
        if interest != self.interest {
            epoll.modify(&self.socket, &mut EpollEvent::new(interest, token)).map_err(|_| Gone)?;
            self.interest = interest;
        }
        Ok(())
    }

    fn receive(&mut self) -> Result<(), Gone> {
        let mut chunk = [0; READ_BYTES];
        match socket::recv(self.socket.as_raw_fd(), &mut chunk, MsgFlags::MSG_DONTWAIT) {
            Ok(0) => {
                self.has_ended = true;
                self.session.receive_end();
            }
            Ok(length) => self.session.receive(&chunk[..length]),
            Err(Errno::EAGAIN | Errno::EINTR) => {}
            Err(_) => return Err(Gone),
        }
        Ok(())
    }

    /// Returns whether the client has been sent everything there is.
    fn send(&mut self, hub: &Hub, stats: &StatsSource<'_>) -> Result<bool, Gone> {
        for _ in 0..LINES_PER_TURN {
            let line = self.session.next_output(hub, stats);
            if line.is_empty() {
                return Ok(true);
            }
            match socket::send(self.socket.as_raw_fd(), line, SEND) {
                Ok(bytes) => self.session.sent(bytes),
                Err(Errno::EAGAIN | Errno::EINTR) => return Ok(false),
                Err(_) => return Err(Gone),
            }
        }
        Ok(false)
    }
}
