//! `cermctl demo`: an instrument on a simulated circuit, and somebody watching it.
//!
//! What runs is the real daemon on a thread, with the real socket in a private directory that is gone afterwards.

pub(super) mod board;
mod compare;
pub(super) mod summary;

use super::CtlError;
use super::interrupt::Interrupt;
use super::limits::{HISTORY_S, SAY_AFTER};
use super::screen::Screen;
use super::stream::{Next, Stream};
use crate::ctl::cli;
use crate::daemon::{Daemon, DaemonError, Listening, Loaded, Signals, StopHandle};
use crate::pins::monotonic;
use crate::pins::sim::SimPins;
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
    if arguments.compare {
        return compare::run(arguments);
    }
    let interrupt = Interrupt::new()?;
    let folder = tempfile::Builder::new().prefix("cermctl-demo-").tempdir();
    let folder = folder.map_err(CtlError::system("a temporary directory for the socket"))?;
    let socket = folder.path().join("socket");
    let board = Board::new(arguments, &socket)?;
    // Two of them behave alike: one is measured, the other one tells the truth.
    let epoch = monotonic();
    let [measured, truth] = [(); 2].map(|()| board.simulation().paced(epoch));
    let daemon = Running::start(&board, measured)?;
    let mut stream = Stream::connect(&socket, &[])?;
    let screen = Screen::new(stream.channels(), arguments.shown.unit);
    let mut screen = screen.with_history(arguments.seconds.min(HISTORY_S), SAY_AFTER, "simulated  ");
    for line in introduction(&board, arguments) {
        screen.terminal.say(&line)?;
    }
    let mut tally = Tally::new(&board, truth);
    let until = Instant::now() + Duration::from_secs_f64(arguments.seconds);
    let is_over = || interrupt.is_set() || Instant::now() >= until;
    let shown = show(&mut stream, &mut screen, &mut tally, is_over);
    let stats = shown.and_then(|()| stream.stats());
    // What the daemon says of its end explains the failure of a client.
    daemon.stop()?;
    let (_, stats) = stats?;
    screen.redraw()?;
    let summary = tally.summary(&stats, screen.terminal.unicode);
    summary.iter().try_for_each(|line| screen.terminal.say(line))
}

fn show(
    stream: &mut Stream,
    screen: &mut Screen,
    tally: &mut Tally<'_>,
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
    fn start(board: &Board, pins: SimPins) -> Result<Running, CtlError> {
        let (signals, handle) = Signals::from_handle().map_err(CtlError::system("socketpair"))?;
        let loaded = Loaded::new(board.config.clone(), Path::new("the demo"))?;
        // Here, so that the socket is there when the client comes.
        let listening = Listening::new(&loaded).map_err(DaemonError::from)?;
        let mut daemon = Daemon::start(loaded, listening, signals, |_| Ok(Box::new(pins)))?;
        let thread = thread::Builder::new().name("cermd".to_owned()).spawn(move || daemon.serve(None));
        Ok(Running { handle, thread: thread.map_err(CtlError::system("thread"))? })
    }

    fn stop(self) -> Result<(), CtlError> {
        self.handle.stop();
        Ok(self.thread.join().unwrap_or(Err(DaemonError::Died))?)
    }
}

pub(super) fn introduction(board: &Board, arguments: &cli::Demo) -> [String; 3] {
    let cli::Demo { scene, seconds, .. } = arguments;
    let first = format!(
        " {}  {}  board {scene}, method {}, {seconds} s, Ctrl-C ends it",
        style("cermd demo").bold(),
        style("simulated").yellow(),
        board.config.method(),
    );
    let sensors =
        if board::is_file(scene) { "the sensors of the scene" } else { "a hand pressing an FSR 402" };
    let wiring = arguments.wiring.map_or_else(String::new, |_| format!("{}, ", board.config.circuit.kind()));
    [first, style(format!(" {wiring}{sensors}; open: untouched")).dim().to_string(), String::new()]
}
