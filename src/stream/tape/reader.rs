//! A tape, line after line as it comes.

use super::{Entry, Header, TapeError};
use crate::stream::limits::MAX_LINE_BYTES;
use std::io::{BufRead, Read};

/// Reads a tape from a file or a pipe: each discharge as soon as its line is there. An error ends it.
#[derive(Debug)]
pub struct Reader<R> {
    input: R,
    header: Header,
    /// Lines that were read.
    lines: usize,
    last_seq: Option<u64>,
    has_ended: bool,
}

impl<R: BufRead> Reader<R> {
    /// Reads the header.
    ///
    /// # Errors
    /// [`TapeError`] of line 1.
    pub fn open(mut input: R) -> Result<Reader<R>, TapeError> {
        let (text, _) = line(&mut input, 1)?;
        if text.is_empty() {
            return Err(TapeError { line: 1, reason: "the tape is empty".to_owned(), is_cut: false });
        }
        Ok(Reader { header: Header::parse(&text)?, input, lines: 1, last_seq: None, has_ended: false })
    }

    /// What all discharges belong to.
    pub fn header(&self) -> &Header {
        &self.header
    }

    fn read(&mut self) -> Result<Option<Entry>, TapeError> {
        loop {
            self.lines += 1;
            let (text, is_whole) = line(&mut self.input, self.lines)?;
            if !text.trim().is_empty() {
                let entry = self.header.parse_discharge(self.lines, &text);
                return self
                    .in_order(entry.map_err(|error| TapeError { is_cut: !is_whole, ..error })?)
                    .map(Some);
            }
            if !is_whole {
                return Ok(None);
            }
        }
    }

    fn in_order(&mut self, entry: Entry) -> Result<Entry, TapeError> {
        match self.last_seq.replace(entry.seq).filter(|before| *before >= entry.seq) {
            None => Ok(entry),
            Some(before) => {
                let seq = entry.seq;
                let reason = format!(
                    "seq {seq} comes after {before}; the lines are out of order, or two tapes were joined"
                );
                Err(TapeError { line: self.lines, reason, is_cut: false })
            }
        }
    }
}

impl<R: BufRead> Iterator for Reader<R> {
    type Item = Result<Entry, TapeError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.has_ended {
            return None;
        }
        let next = self.read().transpose();
        self.has_ended = !matches!(next, Some(Ok(_)));
        next
    }
}

/// The next line, and whether its end is there; empty at the end.
fn line(input: &mut impl BufRead, number: usize) -> Result<(String, bool), TapeError> {
    let wrong = |reason: String| TapeError { line: number, reason, is_cut: false };
    let mut bytes = Vec::new();
    let read = input.take(MAX_LINE_BYTES as u64).read_until(b'\n', &mut bytes);
    read.map_err(|error| wrong(error.to_string()))?;
    let is_whole = bytes.ends_with(b"\n");
    if !is_whole && bytes.len() == MAX_LINE_BYTES {
        return Err(wrong(format!("too long; a line has {MAX_LINE_BYTES} bytes at most")));
    }
    // Half a letter at the end is half a line.
    let text = String::from_utf8_lossy(&bytes).into_owned();
    Ok((text, is_whole))
}
