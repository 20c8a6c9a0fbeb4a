//! The unix socket: readings to any number of clients, none of which can delay the instrument or another client.
//!
//! Each line is made once and shared. A client is a queue of such lines, a subscription and at most one answer that it has
//! not read yet. The kernel's buffer of each socket is kept small. So a client that never reads costs a bounded amount of
//! memory and no time; when its queue is full, it loses its oldest reading and the next one it gets says how many. That is,
//! with the default [`Limits`]: 8 KiB for the queue, 64 KiB for an unfinished request, one answer, and 32 KiB in the kernel;
//! the lines that queues share are the last 1024 readings and as many discharges, whatever the number of clients.
//!
//! One thread drives it: poll the descriptor of the [`Server`] for input beside whatever else there is, and call
//! [`turn`](Server::turn) whenever it is ready or [`wake_at`](Server::wake_at) has come; [`tell`](Server::tell) is enough where
//! something was published and nothing else.

mod hub;
mod limits;
mod listener;
mod lock;
mod peer;
mod session;
mod subscription;

pub use limits::Limits;
pub use listener::{ListenError, Listener};

use super::limits::serving::{ACCEPT_PAUSE, ACCEPT_SAID_FOR, ACCEPTS_PER_TURN, EVENTS_PER_TURN};
use super::tape::{DischargeLine, Header};
use super::wire::{ChannelInfo, ErrorCode, ErrorLine, EventLine, InstrumentStats, to_line};
use crate::reading::Reading;
use crate::units::Nanos;
use hub::{Content, Hub, Published};
use jiff::Timestamp;
use limits::User;
use nix::errno::Errno;
use nix::sys::epoll::{Epoll, EpollCreateFlags, EpollEvent, EpollFlags, EpollTimeout};
use nix::sys::socket::{self, sockopt};
use peer::{Peer, SEND};
use std::collections::BTreeMap;
use std::io;
use std::os::fd::{AsFd, AsRawFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::sync::Arc;

/// The token of the listener; clients count from 1.
const LISTENER: u64 = 0;

/// Tells the daemon's own part of a STATS answer.
pub type StatsSource<'a> = dyn Fn() -> InstrumentStats + 'a;

/// The server. Its descriptor is readable when a [`turn`](Server::turn) has something to do.
#[derive(Debug)]
pub struct Server {
    epoll: Epoll,
    listener: Listener,
    hub: Hub,
    clients: BTreeMap<u64, Peer>,
    limits: Limits,
    last_token: u64,
    /// Something was published or announced that was not yet offered to every client.
    has_news: bool,
    /// Accepting rests until then.
    accept_again_at: Option<Nanos>,
    /// Until then nothing more is said about that.
    said_until: Option<Nanos>,
}

impl Server {
    /// A server of these channels, in the order of their indices in [`Reading::channel`].
    ///
    /// # Errors
    /// The kernel has no descriptor or memory for an epoll instance.
    pub fn new(listener: Listener, channels: &[ChannelInfo], limits: Limits) -> io::Result<Server> {
        let epoll = Epoll::new(EpollCreateFlags::EPOLL_CLOEXEC)?;
        epoll.add(&listener, EpollEvent::new(EpollFlags::EPOLLIN, LISTENER))?;
        Ok(Server {
            epoll,
            listener,
            hub: Hub::new(channels),
            clients: BTreeMap::new(),
            limits,
            last_token: LISTENER,
            has_news: false,
            accept_again_at: None,
            said_until: None,
        })
    }

    /// How many clients are connected.
    pub fn clients(&self) -> usize {
        self.clients.len()
    }

    /// Whether any client wants the lines of [`publish_discharge`](Server::publish_discharge).
    pub fn wants_raw(&self) -> bool {
        self.clients.values().any(|client| client.session.wants_raw())
    }

    /// Whether any client wants what is published as it comes, readings or raw. If not, none of it is urgent.
    pub fn is_watched(&self) -> bool {
        self.clients.values().any(|client| client.session.watches())
    }

    /// Other channels from now on: every client gets a new VERSION, after what was published before it. Subscriptions
    /// hold by id.
    pub fn set_channels(&mut self, channels: &[ChannelInfo]) {
        self.hub.set_channels(channels);
        self.publish(&Arc::clone(&self.hub.version));
    }

    /// What begins a tape: whoever watches raw gets it first, and when it changes.
    pub fn set_tape_header(&mut self, header: &Header) {
        let header = Published::new(Content::Tape, header);
        self.hub.tape_header = Some(Arc::clone(&header));
        self.publish(&header);
    }

    /// Keeps calibration discharges for who begins a tape later, until there are other channels.
    pub fn keep_round(&mut self, round: &[DischargeLine]) {
        self.hub.keep_round(round);
    }

    /// The calibration begins anew: a tape begins with what comes.
    pub fn forget_rounds(&mut self) {
        self.hub.rounds.clear();
    }

    /// Publishes a reading. `time` is `reading.at` on the wall clock. It is sent by the next turn, and formatted only if
    /// somebody wants it.
    pub fn publish_reading(&mut self, reading: &Reading, time: Timestamp) {
        self.hub.keep_reading(reading, time);
        if self.clients.values().any(|client| client.session.wants_readings()) {
            if let Some(published) = self.hub.last_reading(reading.channel) {
                self.publish(&published);
            }
        }
    }

    /// Publishes an event of a trigger. Who comes later gets the last one of each channel first.
    pub fn publish_event(&mut self, event: &EventLine) {
        if let Some(published) = self.hub.keep_event(event) {
            self.publish(&published);
        }
    }

    /// Publishes a discharge to those that watch raw.
    pub fn publish_discharge(&mut self, discharge: DischargeLine) {
        let content = Content::Discharge(discharge.channel.clone());
        self.publish(&Published::new(content, &discharge));
    }

    /// Each client takes it into its queue; the next turn sends it.
    fn publish(&mut self, published: &Arc<Published>) {
        self.hub.lost += self.clients.values_mut().map(|client| client.session.queue(published)).sum::<u64>();
        self.has_news = true;
    }

    /// So many readings and discharges were lost on the way to the server, between what was published before and what will be: to
    /// every client that watches these or those. Of which channel they were is unknown, so they count whatever the filter.
    pub fn miss(&mut self, readings: u64, discharges: u64) {
        self.publish(&Arc::new(Published {
            content: Content::Lost { readings, discharges },
            line: Vec::new(),
        }));
    }

    /// When a turn is due even if nothing happens; `None`: never.
    pub fn wake_at(&self) -> Option<Nanos> {
        self.accept_again_at
    }

    /// Does what can be done without waiting: accepts, answers, sends. `now` is on `CLOCK_MONOTONIC`.
    ///
    /// # Errors
    /// Only of epoll itself: no failure of a client is one of the server.
    pub fn turn(&mut self, now: Nanos, stats: &StatsSource<'_>) -> io::Result<()> {
        let mut events = [EpollEvent::empty(); EVENTS_PER_TURN];
        let ready = match self.epoll.wait(&mut events, EpollTimeout::ZERO) {
            Ok(ready) => ready,
            Err(Errno::EINTR) => 0,
            Err(errno) => return Err(errno.into()),
        };
        let mut is_wanted = self.resume_accepting(now)?;
        for event in &events[..ready] {
            match event.data() {
                LISTENER => is_wanted = true,
                token => self.attend(token, event.events(), stats),
            }
        }
        if is_wanted {
            self.accept_some(now, stats)?;
        }
        self.tell(stats);
        Ok(())
    }

    /// The part of a turn that is left where nothing is ready: sends what was published.
    pub fn tell(&mut self, stats: &StatsSource<'_>) {
        if std::mem::take(&mut self.has_news) {
            // To every client that is not busy with something older.
            let waiting = self.clients.iter().filter(|(_, client)| !client.is_behind());
            for token in waiting.map(|(&token, _)| token).collect::<Vec<_>>() {
                self.attend(token, EpollFlags::empty(), stats);
            }
        }
    }

    fn attend(&mut self, token: u64, events: EpollFlags, stats: &StatsSource<'_>) {
        let Some(client) = self.clients.get_mut(&token) else { return };
        if client.attend(events, &self.hub, stats, (&self.epoll, token)).is_err() {
            // Closing the socket takes it out of epoll, too.
            self.clients.remove(&token);
            self.hub.clients = self.clients.len();
            log::debug!("client {token} is gone, {} left", self.hub.clients);
        }
    }

    fn accept_some(&mut self, now: Nanos, stats: &StatsSource<'_>) -> io::Result<()> {
        for _ in 0..ACCEPTS_PER_TURN {
            match self.listener.accept() {
                Ok(socket) => self.admit(socket, stats),
                Err(error) => match error.raw_os_error().map(Errno::from_raw) {
                    Some(Errno::EINTR | Errno::ECONNABORTED) => {}
                    Some(Errno::EAGAIN) => break,
                    _ => return self.pause_accepting(now, &error),
                },
            }
        }
        Ok(())
    }

    /// The connection that cannot be accepted would keep the listener ready for ever: look away for a while.
    fn pause_accepting(&mut self, now: Nanos, error: &io::Error) -> io::Result<()> {
        if self.said_until.is_none_or(|until| now >= until) {
            self.said_until = Some(now + ACCEPT_SAID_FOR);
            log::warn!("no further clients for now: accept: {error}; raise LimitNOFILE= if that stays");
        }
        self.epoll.modify(&self.listener, &mut EpollEvent::new(EpollFlags::empty(), LISTENER))?;
        self.accept_again_at = Some(now + ACCEPT_PAUSE);
        Ok(())
    }

    fn resume_accepting(&mut self, now: Nanos) -> io::Result<bool> {
        let is_due = self.accept_again_at.is_some_and(|at| now >= at);
        if is_due {
            self.accept_again_at = None;
            self.epoll.modify(&self.listener, &mut EpollEvent::new(EpollFlags::EPOLLIN, LISTENER))?;
        }
        Ok(is_due)
    }

    fn admit(&mut self, socket: UnixStream, stats: &StatsSource<'_>) {
        let user = User::of(&socket);
        let of_user = self.clients.values().filter(|client| client.user == user).count();
        if let Err(message) = self.limits.admit(user, self.clients.len(), of_user) {
            let line = to_line(&ErrorLine::new(ErrorCode::Busy, message));
            let _ = socket::send(socket.as_raw_fd(), &line, SEND);
            return;
        }
        // Smaller than the default, so that a client that does not read holds less. If refused, the default holds.
        let _ = socket::setsockopt(&socket, sockopt::SndBuf, &self.limits.send_buffer_bytes);
        self.last_token += 1;
        let token = self.last_token;
        match Peer::new((socket, user), &self.hub, self.limits.queue_lines, (&self.epoll, token)) {
            Ok(peer) => {
                self.clients.insert(token, peer);
                self.hub.clients = self.clients.len();
                self.attend(token, EpollFlags::empty(), stats);
            }
            Err(errno) => log::warn!("client refused: epoll_ctl: {errno}"),
        }
    }
}

impl AsFd for Server {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.epoll.0.as_fd()
    }
}
