//! `cermctl demo`: an instrument on a simulated circuit, and somebody watching it.
//!
//! What runs is the real daemon on a thread, with the real socket in a private directory that is gone afterwards.

mod board;
mod summary;

use super::CtlError;
use super::interrupt::Interrupt;
use super::limits::{HISTORY_S, SAY_AFTER};
use super::screen::Screen;
use super::stream::{Next, Stream};
use crate::ctl::cli;
use crate::daemon::{Daemon, DaemonError, Loaded, Signals, StopHandle};
use crate::pins::monotonic;
use crate::stream::client::ClientError;
use crate::stream::wire::ServerMessage;
use board::Board;
use console::style;
use std::path::Path;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};
use summary::Tally;

/// Shows the demo.
pub fn run(arguments: &cli::Demo) -> Result<(), CtlError> {
    let interrupt = Interrupt::new()?;
    let folder = tempfile::Builder::new().prefix("cermctl-demo-").tempdir();
    let folder = folder.map_err(|error| CtlError::System("a temporary directory for the socket", error))?;
    let socket = folder.path().join("socket");
    let board = Board::new(arguments, &socket)?;
    let daemon = Running::start(&board)?;
    let mut stream = Stream::connect(&socket, &[])?;
    let screen = Screen::new(stream.version().channels.iter());
    let mut screen = screen.with_history(arguments.seconds.min(HISTORY_S), SAY_AFTER, "simulated  ");
    for line in board.introduction(arguments.seconds) {
        screen.terminal.say(&line)?;
    }
    let mut tally = Tally::default();
    let until = Instant::now() + Duration::from_secs_f64(arguments.seconds);
    let is_over = || interrupt.is_set() || Instant::now() >= until;
    let shown = show(&mut stream, &mut screen, &mut tally, is_over);
    let stats = shown.and_then(|()| stream.stats());
    // What the daemon says of its end explains the failure of a client.
    daemon.stop()?;
    let (_, stats) = stats?;
    screen.redraw()?;
    let summary = tally.summary(&board, &stats, screen.terminal.unicode());
    summary.iter().try_for_each(|line| screen.terminal.say(line))
}

fn show(
    stream: &mut Stream,
    screen: &mut Screen,
    tally: &mut Tally,
    is_over: impl Fn() -> bool,
) -> Result<(), CtlError> {
    while !is_over() {
        match stream.next()? {
            Next::Line(_, ServerMessage::Reading(reading)) => {
                tally.add(&reading);
                screen.feed(&reading)?;
            }
            Next::Line(..) | Next::Quiet => {}
            Next::Ended => return Err(ClientError::Closed.into()),
        }
    }
    Ok(())
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
        let mut daemon = Daemon::start(loaded, signals, |_| Ok(Box::new(board.pins())))?;
        let thread = thread::Builder::new().name("cermd".to_owned()).spawn(move || daemon.serve(None));
        Ok(Running { handle, thread: thread.map_err(|error| CtlError::System("thread", error))? })
    }

    fn stop(self) -> Result<(), CtlError> {
        self.handle.stop();
        Ok(self.thread.join().unwrap_or(Err(DaemonError::Died))?)
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
