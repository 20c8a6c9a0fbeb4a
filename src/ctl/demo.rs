//! `cermctl demo`: an instrument on a simulated circuit, and somebody watching it.
//!
//! For: showing on any Linux machine what the daemon and its clients do: the real daemon on a thread, the real socket in a
//! private directory that is gone afterwards. Must not know: how a circuit is simulated.

mod board;
mod summary;

use super::CtlError;
use super::interrupt::Interrupt;
use super::panel::Panel;
use super::stream::{Next, Stream};
use super::terminal::{Line, Style, Terminal};
use crate::ctl::cli;
use crate::daemon::{Daemon, DaemonError, Loaded, Signals, StopHandle};
use crate::pins::monotonic;
use crate::stream::wire::{Request, ServerMessage, StatsLine};
use board::Board;
use std::path::Path;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};
use summary::Tally;

/// The live lines change at most so often.
const REDRAW_AFTER: Duration = Duration::from_millis(40);
/// On anything but a terminal, one reading in this time is shown.
const SAY_AFTER: Duration = Duration::from_millis(500);
/// The daemon answers a request well within this.
const ANSWER: Duration = Duration::from_secs(2);

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
        let mut daemon = Daemon::start(loaded, signals, |_| Ok(Box::new(board.pins())))?;
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
    terminal: Terminal,
    panel: Panel,
    stream: Stream,
    tally: Tally,
    until: Instant,
    seconds: f64,
    shown: Option<Instant>,
}

impl Show {
    fn begin(board: &Board, seconds: f64, socket: &Path) -> Result<Show, CtlError> {
        let stream = Stream::connect(socket, &[])?;
        let mut terminal = Terminal::new();
        let panel = Panel::new(stream.version().channels.iter(), terminal.unicode());
        for line in board.introduction(seconds) {
            terminal.say(&line)?;
        }
        let until = Instant::now() + Duration::from_secs_f64(seconds);
        Ok(Show { terminal, panel, stream, tally: Tally::default(), until, seconds, shown: None })
    }

    /// Until the time is over; what the daemon then says of itself.
    fn go_on(&mut self, interrupt: &Interrupt) -> Result<StatsLine, CtlError> {
        let mut asked = None;
        loop {
            if asked.is_none() && (interrupt.is_set() || Instant::now() >= self.until) {
                self.stream.request(&Request::Stats)?;
                asked = Some(Instant::now());
            }
            match self.stream.next()? {
                Next::Line(_, ServerMessage::Stats(stats)) => return Ok(*stats),
                Next::Line(_, ServerMessage::Reading(reading)) if asked.is_none() => {
                    self.panel.feed(&reading);
                    self.tally.add(&reading);
                    self.show(&reading.channel)?;
                }
                Next::Line(..) | Next::Quiet => {}
                Next::Ended => return Err(crate::stream::client::ClientError::Closed.into()),
            }
            if asked.is_some_and(|asked| asked.elapsed() > ANSWER) {
                return Err(crate::stream::client::ClientError::TimedOut(ANSWER).into());
            }
        }
    }

    fn show(&mut self, channel: &str) -> Result<(), CtlError> {
        let pause = if self.terminal.is_live() { REDRAW_AFTER } else { SAY_AFTER };
        if self.shown.is_some_and(|shown| shown.elapsed() < pause) {
            return Ok(());
        }
        self.shown = Some(Instant::now());
        if self.terminal.is_live() {
            let lines = self.live_lines();
            self.terminal.draw(&lines)
        } else {
            let line = Line::default().add(Style::Plain, "simulated  ").join(self.panel.plain(channel));
            self.terminal.say(&line)
        }
    }

    fn live_lines(&self) -> Vec<Line> {
        let width = self.terminal.width();
        let mut lines = self.panel.lines(width);
        lines.extend(self.panel.history(self.seconds.min(10.0), width));
        lines
    }

    fn end(&mut self, board: &Board, stats: &StatsLine) -> Result<(), CtlError> {
        if self.terminal.is_live() {
            let lines = self.live_lines();
            self.terminal.draw(&lines)?;
        }
        for line in self.tally.summary(board, stats, self.terminal.unicode()) {
            self.terminal.say(&line)?;
        }
        Ok(())
    }
}

impl Board {
    fn introduction(&self, seconds: f64) -> Vec<Line> {
        let method = self.config.method().as_str();
        let first = Line::default()
            .add(Style::Bold, " cermd demo")
            .add(Style::Notable, "  simulated")
            .add(Style::Plain, format!("  {}, method {method}, {seconds} s, Ctrl-C ends it", self.title));
        let second = Line::default().add(Style::Dim, format!(" {}; open: untouched", self.connected));
        vec![first, second, Line::default()]
    }

    /// The simulated circuit, from now on.
    fn pins(&self) -> crate::pins::sim::SimPins {
        let now = monotonic();
        self.epoch.set(now);
        self.simulation().paced(now)
    }
}
