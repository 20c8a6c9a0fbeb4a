//! `cermctl watch`: readings as they come.
//!
//! For: a live line per channel, or the lines of the stream. Must not know: how either is drawn. It outlives the daemon:
//! when the connection ends, it waits for the next one and says so.

use super::interrupt::Interrupt;
use super::panel::Panel;
use super::stream::{Next, Stream, is_wanted};
use super::terminal::{Line, Style, Terminal};
use super::{CtlError, print};
use crate::ctl::cli;
use crate::stream::client::ClientError;
use crate::stream::wire::{ServerMessage, VersionLine};
use std::time::{Duration, Instant};

/// From one attempt to connect again to the next.
const RETRY_AFTER: Duration = Duration::from_millis(250);
/// A live line changes at most so often: faster than the eye, slower than a slow terminal.
const REDRAW_AFTER: Duration = Duration::from_millis(40);

/// Watches until Ctrl-C.
pub fn run(arguments: &cli::Watch) -> Result<(), CtlError> {
    let interrupt = Interrupt::new()?;
    let mut stream = connect(arguments)?;
    let mut view = View::new(arguments, stream.version());
    loop {
        view.follow(&mut stream, &interrupt)?;
        if interrupt.is_set() {
            return Ok(());
        }
        view.note("cermd closed the connection; waiting for it to come back")?;
        match reconnect(arguments, &interrupt)? {
            Some(again) => stream = again,
            None => return Ok(()),
        }
        view.restart(stream.version());
        view.note("connected again")?;
    }
}

fn connect(arguments: &cli::Watch) -> Result<Stream, CtlError> {
    let mut stream = Stream::connect(&arguments.connection.socket, &arguments.channels)?;
    if !arguments.channels.is_empty() || arguments.max_hz.is_some() {
        stream.watch(&arguments.channels, arguments.max_hz, false)?;
    }
    Ok(stream)
}

/// Tries until the daemon is there again; `None`: interrupted.
fn reconnect(arguments: &cli::Watch, interrupt: &Interrupt) -> Result<Option<Stream>, CtlError> {
    while !interrupt.is_set() {
        match connect(arguments) {
            Ok(stream) => return Ok(Some(stream)),
            Err(CtlError::Client(error)) if is_passing(&error) => std::thread::sleep(RETRY_AFTER),
            Err(error) => return Err(error),
        }
    }
    Ok(None)
}

/// What a daemon that starts or stops looks like.
fn is_passing(error: &ClientError) -> bool {
    use ClientError::{Closed, Io, NoSocket, NobodyThere, TimedOut};
    matches!(error, NoSocket(_) | NobodyThere(_) | Closed | TimedOut(_) | Io(_))
}

/// What is shown of the stream.
struct View<'a> {
    arguments: &'a cli::Watch,
    terminal: Terminal,
    panel: Panel,
    drawn: Option<Instant>,
}

impl<'a> View<'a> {
    fn new(arguments: &'a cli::Watch, version: &VersionLine) -> View<'a> {
        let terminal = Terminal::new();
        let panel = panel(arguments, version, &terminal);
        View { arguments, terminal, panel, drawn: None }
    }

    fn restart(&mut self, version: &VersionLine) {
        self.panel = panel(self.arguments, version, &self.terminal);
    }

    /// Shows lines until the connection ends.
    fn follow(&mut self, stream: &mut Stream, interrupt: &Interrupt) -> Result<(), CtlError> {
        if self.arguments.json {
            return follow_json(stream, interrupt, self.arguments);
        }
        while !interrupt.is_set() {
            match stream.next()? {
                Next::Line(_, ServerMessage::Reading(reading)) => {
                    self.panel.feed(&reading);
                    if is_wanted(&self.arguments.channels, &reading.channel) {
                        self.show(&reading.channel)?;
                    }
                }
                // The channels have changed.
                Next::Line(_, ServerMessage::Version(version)) => self.restart(&version),
                Next::Line(_, ServerMessage::Error(error)) => {
                    return Err(CtlError::Refused(error.message));
                }
                Next::Line(..) => {}
                Next::Quiet => self.redraw()?,
                Next::Ended => break,
            }
        }
        Ok(())
    }

    fn show(&mut self, channel: &str) -> Result<(), CtlError> {
        if !self.terminal.is_live() {
            return self.terminal.say(&self.panel.plain(channel));
        }
        if self.drawn.is_none_or(|drawn| drawn.elapsed() >= REDRAW_AFTER) {
            self.redraw()?;
        }
        Ok(())
    }

    fn redraw(&mut self) -> Result<(), CtlError> {
        if self.terminal.is_live() {
            self.drawn = Some(Instant::now());
            let lines = self.panel.lines(self.terminal.width());
            self.terminal.draw(&lines)?;
        }
        Ok(())
    }

    /// Where the readings do not go, so that they stay readings.
    fn note(&mut self, text: &str) -> Result<(), CtlError> {
        if self.terminal.is_live() && !self.arguments.json {
            self.terminal.say(&Line::default().add(Style::Notable, format!(" {text}")))
        } else {
            eprintln!("cermctl: {text}");
            Ok(())
        }
    }
}

fn panel(arguments: &cli::Watch, version: &VersionLine, terminal: &Terminal) -> Panel {
    let wanted = version.channels.iter().filter(|channel| is_wanted(&arguments.channels, &channel.id));
    Panel::new(wanted, terminal.unicode())
}

fn follow_json(stream: &mut Stream, interrupt: &Interrupt, arguments: &cli::Watch) -> Result<(), CtlError> {
    while !interrupt.is_set() {
        match stream.next()? {
            // Measured before the daemon knew what is wanted.
            Next::Line(_, ServerMessage::Reading(reading))
                if !is_wanted(&arguments.channels, &reading.channel) => {}
            Next::Line(line, _) => print(&(String::from_utf8_lossy(&line) + "\n"))?,
            Next::Quiet => {}
            Next::Ended => break,
        }
    }
    Ok(())
}
