//! One client: commands as lines, answers as numbers and what they count.

use super::context::{Context, DEVICE, EINVAL, ENOENT, Element};
use super::rows::Rows;
use super::{SharedBuffers, lock, now};
use crate::bridge::limits::{IIO_COMMAND_BYTES, IIO_SILENCE};
use crate::bridge::queue::Outlet;
use crate::bridge::server::Place;
use crate::stream::wire::ReadingLine;
use crate::units::Nanos;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::time::{Duration, Instant};

// errno(3).
const ENODEV: i32 = 19;
const EBUSY: i32 = 16;
const EBADF: i32 = 9;
const ETIMEDOUT: i32 = 110;

/// The release of the protocol that is spoken, and seven characters of a version.
const VERSION: &str = "0.24.cermd00\n";

pub struct Session<'a> {
    place: &'a Place,
    input: BufReader<TcpStream>,
    output: TcpStream,
    hub: SharedBuffers,
    /// The device as this connection has it: a client opens its buffer on another one than that which it read the
    /// description on.
    context: Option<Context>,
    buffer: Option<Buffer>,
    /// The longest wait of the client for an answer.
    patience: Duration,
}

/// An open buffer.
struct Buffer {
    /// The device as it was when this was opened: the description may be asked for anew meanwhile.
    context: Context,
    rows: Rows,
    mask: u64,
    /// A reading that has waited for longer is no row.
    fresh: Nanos,
    readings: Outlet<Arc<ReadingLine>>,
}

impl<'a> Session<'a> {
    pub fn new(socket: TcpStream, hub: SharedBuffers, place: &'a Place) -> io::Result<Session<'a>> {
        let input = BufReader::new(socket.try_clone()?);
        Ok(Session { place, input, output: socket, hub, context: None, buffer: None, patience: IIO_SILENCE })
    }

    /// Until the client leaves.
    pub fn run(mut self) -> io::Result<()> {
        loop {
            let mut line = Vec::new();
            let length = (&mut self.input).take(IIO_COMMAND_BYTES).read_until(b'\n', &mut line)?;
            // The end, or a command without one.
            if length == 0 || line.last() != Some(&b'\n') {
                return Ok(());
            }
            self.place.keep();
            let line = String::from_utf8_lossy(&line).into_owned();
            let words: Vec<&str> = line.split_whitespace().collect();
            match words[..] {
                [] => {}
                ["EXIT"] => return Ok(()),
                ["READBUF", DEVICE, bytes] => self.read_buffer(bytes)?,
                _ => {
                    let answer = self.answer(&words);
                    self.output.write_all(&answer)?;
                }
            }
        }
    }

    fn answer(&mut self, words: &[&str]) -> Vec<u8> {
        match words {
            ["VERSION"] => VERSION.into(),
            ["PRINT"] => self.print(),
            ["TIMEOUT", ms] => status(ms.parse().map_err(|_| EINVAL).map(|ms| {
                // 0: for ever.
                let asked = if ms == 0 { IIO_SILENCE } else { Duration::from_millis(ms) };
                self.patience = asked.min(IIO_SILENCE);
            })),
            ["READ", DEVICE, "INPUT", channel, attribute] => text(self.attribute(channel, attribute)),
            ["READ", ..] => status(Err(ENOENT)),
            ["OPEN", DEVICE, _, mask] => status(self.open(mask)),
            ["CLOSE", DEVICE] => status(self.buffer.take().map(drop).ok_or(EBADF)),
            ["OPEN" | "CLOSE" | "READBUF", ..] => status(Err(ENODEV)),
            // The size of the queue of buffers: there is one, whatever is asked for.
            ["SET", DEVICE, "BUFFERS_COUNT", _] => status(Ok(())),
            // No triggers, nothing to write, and what later releases ask for.
            _ => status(Err(EINVAL)),
        }
    }

    fn print(&mut self) -> Vec<u8> {
        // Anew: the channels may have changed.
        self.context = None;
        // Not as an attribute: the description is not ended by a zero.
        match self.context().map(Context::xml) {
            Ok(xml) => format!("{}\n{xml}\n", xml.len()).into_bytes(),
            Err(errno) => status(Err(errno)),
        }
    }

    /// Without a daemon there is no device.
    fn context(&mut self) -> Result<&Context, i32> {
        if self.context.is_none() {
            self.context = lock(&self.hub).latest.version().map(Context::new);
        }
        self.context.as_ref().ok_or(ENODEV)
    }

    fn attribute(&mut self, channel: &str, attribute: &str) -> Result<String, i32> {
        let hub = Arc::clone(&self.hub);
        let context = self.context()?;
        let element = context.element(channel).ok_or(ENOENT)?;
        let (Element::Resistance(at) | Element::Shown(at, _)) = element else { return Err(ENOENT) };
        let shared = lock(&hub);
        let mut fresh = shared.latest.fresh(now());
        let reading =
            fresh.find(|(info, _)| info.id == context.channels[at].id).and_then(|(_, reading)| reading);
        context.attribute(element, attribute, reading)
    }

    /// The mask is in hexadecimal, a word of 32 bits after the other, the highest first.
    fn open(&mut self, mask: &str) -> Result<(), i32> {
        if self.buffer.is_some() {
            return Err(EBUSY);
        }
        let mask = u64::from_str_radix(mask, 16).map_err(|_| EINVAL)?;
        let fresh = lock(&self.hub).patience;
        let context = self.context()?.clone();
        let rows = Rows::new(&context, mask, fresh).ok_or(EINVAL)?;
        self.buffer = Some(Buffer { context, rows, mask, fresh, readings: lock(&self.hub).open() });
        Ok(())
    }

    /// Rows as they come, each with its length; the first with the mask. A short answer is ended by a 0.
    fn read_buffer(&mut self, bytes: &str) -> io::Result<()> {
        let Some(buffer) = &mut self.buffer else {
            return self.output.write_all(&status(Err(EBADF)));
        };
        let size = buffer.rows.size();
        let Some(count) = bytes.parse().ok().filter(|bytes| *bytes >= size).map(|bytes: usize| bytes / size)
        else {
            return self.output.write_all(&status(Err(EINVAL)));
        };
        let words = if buffer.context.elements.len() > 32 { 2 } else { 1 };
        let mut mask = format!("{:0width$x}\n", buffer.mask, width = 8 * words);
        for done in 0..count {
            let Some(row) = buffer.next(self.patience) else {
                let end = if done == 0 { status(Err(ETIMEDOUT)) } else { status(Ok(())) };
                return self.output.write_all(&end);
            };
            self.output.write_all(&[format!("{size}\n{mask}").as_bytes(), &row].concat())?;
            mask.clear();
            self.place.keep();
        }
        // The client asks for whole rows only, but may count otherwise.
        if bytes.parse() == Ok(count * size) { Ok(()) } else { self.output.write_all(b"0\n") }
    }
}

impl Buffer {
    fn next(&mut self, patience: Duration) -> Option<Vec<u8>> {
        let until = Instant::now() + patience;
        loop {
            let left = until.saturating_duration_since(Instant::now());
            let reading = self.readings.next(left).ok()?;
            if now() - Nanos(reading.t_mono_ns) > self.fresh {
                continue;
            }
            if let Some(row) = self.rows.feed(&self.context, &reading) {
                return Some(row);
            }
        }
    }
}

/// 0, or the negative number of an error.
fn status(result: Result<(), i32>) -> Vec<u8> {
    format!("{}\n", result.map_or_else(|errno| -errno, |()| 0)).into_bytes()
}

/// The length with its zero, and the text with it.
fn text(result: Result<String, i32>) -> Vec<u8> {
    match result {
        Ok(text) => format!("{}\n{text}\0\n", text.len() + 1).into_bytes(),
        Err(errno) => status(Err(errno)),
    }
}
