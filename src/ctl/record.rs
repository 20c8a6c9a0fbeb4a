//! `cermctl record`: readings, or the timings they were made of, into a file.
//!
//! Lines are whole whatever ends the recording, and losses are said.

use super::CtlError;
use super::interrupt::Interrupt;
use super::stream::{Next, Stream};
use crate::ctl::cli::{self, Format};
use crate::stream::tape::Header;
use crate::stream::wire::{ReadingLine, ServerMessage};
use serde_json::{Map, Value};
use std::fs::File;
use std::io::{self, Write};
use std::time::{Duration, Instant};

/// The columns of CSV: fields of READING.
const COLUMNS: &str = "channel,seq,time,t_mono_ns,status,r_ohm,r_u_ohm,f_n,f_u_n,f_repeat_u_n,extrapolated,\
                       r_min_ohm,f_max_n,r_max_ohm,f_min_n,fault,method,branch,duration_us,lost,moving,settling,\
                       value,value_u,value_repeat_u,unit,value_min,value_max";

/// Records until the time, the count or Ctrl-C.
pub fn run(arguments: &cli::Record) -> Result<(), CtlError> {
    let interrupt = Interrupt::new()?;
    let mut stream = Stream::connect(&arguments.connection.socket, &arguments.channels)?;
    stream.watch(None, arguments.raw)?;
    let mut recording = Recording::begin(arguments)?;
    let outcome = recording.go_on(&mut stream, &interrupt);
    if recording.lost > 0 {
        let what = if arguments.raw { "discharges" } else { "readings" };
        eprintln!("cermctl: {} {what} were lost: the output takes them too slowly", recording.lost);
    }
    outcome
}

struct Recording<'a> {
    arguments: &'a cli::Record,
    out: Box<dyn Write>,
    /// Where that goes, and how many bytes of it are whole lines; `None`: standard output.
    file: Option<(File, u64)>,
    until: Option<Instant>,
    header: Option<Header>,
    /// Readings or discharges so far.
    count: u64,
    lost: u64,
}

impl<'a> Recording<'a> {
    fn begin(arguments: &'a cli::Record) -> Result<Recording<'a>, CtlError> {
        let (out, file): (Box<dyn Write>, _) = match &arguments.output {
            Some(path) => {
                let file = File::create(path).map_err(CtlError::file(path))?;
                (Box::new(file.try_clone().map_err(CtlError::file(path))?), Some((file, 0)))
            }
            None => (Box::new(io::stdout().lock()), None),
        };
        let until = arguments.seconds.map(|seconds| Instant::now() + Duration::from_secs_f64(seconds));
        let mut recording = Recording { arguments, out, file, until, header: None, count: 0, lost: 0 };
        if !arguments.raw && arguments.format == Format::Csv {
            recording.write(COLUMNS)?;
        }
        Ok(recording)
    }

    fn go_on(&mut self, stream: &mut Stream, interrupt: &Interrupt) -> Result<(), CtlError> {
        while !self.is_over(interrupt) {
            match stream.next()? {
                // A loss: any other ERROR has ended the recording.
                Next::Line(_, ServerMessage::Error(error)) => self.lost += error.lost.unwrap_or(1),
                Next::Line(line, ServerMessage::Reading(reading)) if !self.arguments.raw => {
                    self.reading(&line, &reading)?;
                }
                Next::Line(line, ServerMessage::Tape(header)) if self.arguments.raw => {
                    self.header(&line, *header)?;
                }
                Next::Line(line, ServerMessage::Discharge(_)) if self.header.is_some() => {
                    self.count += 1;
                    self.write(&line)?;
                }
                Next::Line(..) | Next::Quiet => {}
                Next::Ended => return Err(ended("cermd closed the connection")),
            }
        }
        Ok(())
    }

    fn is_over(&self, interrupt: &Interrupt) -> bool {
        interrupt.is_set()
            || self.until.is_some_and(|until| Instant::now() >= until)
            || self.arguments.count.is_some_and(|count| self.count >= count)
    }

    fn reading(&mut self, line: &str, reading: &ReadingLine) -> Result<(), CtlError> {
        self.count += 1;
        self.lost += reading.lost;
        match self.arguments.format {
            Format::Ndjson => self.write(line),
            Format::Csv => self.write(&csv_row(line)),
        }
    }

    /// A daemon that has just found its latency offset sends a second header: the first one stays, for this tape holds the
    /// discharges that the offset was found from.
    fn header(&mut self, line: &str, header: Header) -> Result<(), CtlError> {
        match &self.header {
            None => {
                self.header = Some(header);
                self.write(line)
            }
            Some(first) if *first == (Header { offset: first.offset, looks: first.looks, ..header }) => {
                Ok(())
            }
            Some(_) => Err(ended("the configuration of cermd has changed")),
        }
    }

    /// One line in one call, so that a process that is killed leaves no half line.
    fn write(&mut self, line: &str) -> Result<(), CtlError> {
        let line = format!("{line}\n");
        let written = self.out.write_all(line.as_bytes()).and_then(|()| self.out.flush());
        match (&mut self.file, &written) {
            (Some((_, whole)), Ok(())) => *whole += line.len() as u64,
            // A disk that is full took the first half of it. What is no file of the disk cannot be cut.
            (Some((file, whole)), Err(_)) => drop(file.set_len(*whole)),
            (None, _) => {}
        }
        written.map_err(|source| match &self.arguments.output {
            Some(path) => CtlError::file(path)(source),
            None => CtlError::Output(source),
        })
    }
}

fn ended(why: &str) -> CtlError {
    CtlError::Said(format!("the recording ends here: {why}"))
}

/// The fields of a line in the order of the columns, as they were sent; what is not known is empty.
fn csv_row(line: &str) -> String {
    let fields: Map<String, Value> = serde_json::from_str(line).unwrap_or_default();
    let cells = COLUMNS.split(',').map(|key| match fields.get(key) {
        None => String::new(),
        Some(Value::String(text)) => text.clone(),
        Some(number) => number.to_string(),
    });
    let mut writer = csv::Writer::from_writer(Vec::new());
    // Memory takes whatever is written into it.
    let _ = writer.write_record(cells.map(String::into_bytes));
    let row = String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default();
    row.trim_end_matches('\n').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_has_a_cell_for_each_column_whatever_is_in_it() {
        let row = csv_row(r#"{"class":"READING","channel":"a,\"b\"","r_ohm":2841.3,"lost":0,"new":1}"#);
        assert_eq!(row, format!("\"a,\"\"b\"\"\",,,,,2841.3{}0{}", ",".repeat(14), ",".repeat(8)));
    }
}
