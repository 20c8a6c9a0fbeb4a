//! `cermctl demo`: an instrument on a simulated circuit, and somebody watching it.
//!
//! What runs is the real daemon on a thread, with the real socket in a private directory that is gone afterwards.

mod board;
mod summary;

use super::CtlError;
use super::interrupt::Interrupt;
use super::screen::Screen;
use super::stream::{Next, Stream};
use crate::ctl::cli;
use crate::daemon::{Daemon, DaemonError, Loaded, Signals, StopHandle, monotonic};
use crate::stream::client::ClientError;
use crate::stream::wire::ServerMessage;
use board::Board;
use console::style;
use serde_json::{Map, Value};
use std::path::Path;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};
use summary::Tally;

/// On anything but a terminal, one reading in this time is shown.
const SAY_AFTER: Duration = Duration::from_millis(500);
/// How far back the history goes, seconds.
const HISTORY_S: f64 = 10.0;

/// Shows the demo.
pub fn run(arguments: &cli::Demo) -> Result<(), CtlError> {
    let interrupt = Interrupt::new()?;
    let folder = tempfile::Builder::new().prefix("cermctl-demo-").tempdir();
    let folder = folder.map_err(|error| CtlError::System("a temporary directory for the socket", error))?;
    let socket = folder.path().join("socket");
    let board = Board::new(arguments, &socket)?;
    let daemon = Running::start(&board)?;
    let mut show = Show::begin(&board, arguments.seconds, &socket)?;
    let outcome = show.go_on(&interrupt);
    // What the daemon says of its end explains the failure of a client.
    daemon.stop()?;
    let stats = outcome?;
    show.end(&board, &stats)
}

/// The daemon on its thread.
struct Running {
    handle: StopHandle,
    thread: JoinHandle<Result<(), DaemonError>>,
}

impl Running {
    fn start(board: &Board) -> Result<Running, CtlError> {
        let (signals, handle) =
            Signals::from_handle().map_err(|error| CtlError::System("socketpair", error))?;
        let loaded = Loaded::new(board.config.clone(), Path::new("the demo"))?;
        // Here, so that the socket is there when the client comes.
        let mut daemon = Daemon::start_with(loaded, signals, |_| Ok(Box::new(board.pins())))?;
        let thread = thread::Builder::new().name("cermd".to_owned()).spawn(move || daemon.serve(None));
        Ok(Running { handle, thread: thread.map_err(|error| CtlError::System("thread", error))? })
    }

    fn stop(self) -> Result<(), CtlError> {
        self.handle.stop();
        Ok(self.thread.join().unwrap_or(Err(DaemonError::Died))?)
    }
}

/// What is seen.
struct Show {
    screen: Screen,
    stream: Stream,
    tally: Tally,
    until: Instant,
}

impl Show {
    fn begin(board: &Board, seconds: f64, socket: &Path) -> Result<Show, CtlError> {
        let stream = Stream::connect(socket, &[])?;
        let screen = Screen::new(stream.version().channels.iter());
        let mut screen = screen.with_history(seconds.min(HISTORY_S), SAY_AFTER, "simulated  ");
        for line in board.introduction(seconds) {
            screen.terminal.say(&line)?;
        }
        let until = Instant::now() + Duration::from_secs_f64(seconds);
        Ok(Show { screen, stream, tally: Tally::default(), until })
    }

    /// Until the time is over; what the daemon then says of itself.
    fn go_on(&mut self, interrupt: &Interrupt) -> Result<Map<String, Value>, CtlError> {
        while !interrupt.is_set() && Instant::now() < self.until {
            match self.stream.next()? {
                Next::Line(_, ServerMessage::Reading(reading)) => {
                    self.tally.add(&reading);
                    self.screen.feed(&reading)?;
                }
                Next::Line(..) | Next::Quiet => {}
                Next::Ended => return Err(ClientError::Closed.into()),
            }
        }
        Ok(self.stream.stats()?.1)
    }

    fn end(&mut self, board: &Board, stats: &Map<String, Value>) -> Result<(), CtlError> {
        self.screen.redraw()?;
        for line in self.tally.summary(board, stats, self.screen.terminal.unicode()) {
            self.screen.terminal.say(&line)?;
        }
        Ok(())
    }
}

impl Board {
    fn introduction(&self, seconds: f64) -> [String; 3] {
        let method = self.config.method().as_str();
        let first = format!(
            " {}  {}  {}, method {method}, {seconds} s, Ctrl-C ends it",
            style("cermd demo").bold(),
            style("simulated").yellow(),
            self.title
        );
        let second = style(format!(" {}; open: untouched", self.connected)).dim().to_string();
        [first, second, String::new()]
    }

    /// The simulated circuit, from now on.
    fn pins(&self) -> crate::pins::sim::SimPins {
        let now = monotonic();
        self.epoch.set(now);
        self.simulation().paced(now)
    }
}
