//! Framing: from chunks of bytes to lines.

use super::MAX_LINE_BYTES;

/// A line had more than [`MAX_LINE_BYTES`]; its bytes were thrown away.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LineTooLong;

/// Cuts a stream of bytes into lines.
///
/// Holds at most one unfinished line and the chunk that was fed last, and nothing at all between lines. Feed
/// again only when [`next_line`](LineSplitter::next_line) has returned `None`; otherwise the bound is lost.
#[derive(Debug, Default)]
pub struct LineSplitter {
    buffer: Vec<u8>,
    /// Bytes of `buffer` that were already handed out.
    start: usize,
    /// Bytes of `buffer` that are known to hold no newline beyond `start`: a line that trickles in is searched once.
    searched: usize,
    /// The rest of a too long line is still coming.
    skipping: bool,
}

impl LineSplitter {
    /// Takes the next chunk.
    pub fn feed(&mut self, chunk: &[u8]) {
        let mut fresh = chunk;
        if self.skipping {
            let Some(newline) = position_of_newline(chunk) else { return };
            fresh = &chunk[newline + 1..];
            self.skipping = false;
        }
        self.buffer.drain(..self.start);
        self.searched -= self.start;
        self.start = 0;
        self.buffer.reserve_exact(fresh.len());
        self.buffer.extend_from_slice(fresh);
    }

    /// The next line, if all of it (or too much of it) has come, without its newline (and a carriage return before that).
    pub fn next_line(&mut self) -> Option<Result<Vec<u8>, LineTooLong>> {
        let line = match self.end_of_line() {
            Some(end) => {
                let bytes = &self.buffer[self.start..end];
                self.start = end + 1;
                if bytes.len() < MAX_LINE_BYTES { Ok(without_return(bytes)) } else { Err(LineTooLong) }
            }
            None if self.is_full() => {
                self.skipping = true;
                self.start = self.buffer.len();
                Err(LineTooLong)
            }
            None => {
                self.searched = self.buffer.len();
                return None;
            }
        };
        self.searched = self.start;
        if self.start == self.buffer.len() {
            *self = LineSplitter { skipping: self.skipping, ..LineSplitter::default() };
        }
        Some(line)
    }

    /// Whether [`next_line`](LineSplitter::next_line) would return one.
    pub fn has_line(&self) -> bool {
        self.is_full() || self.end_of_line().is_some()
    }

    /// Whether a line was begun and not ended.
    pub fn is_amid_line(&self) -> bool {
        self.start < self.buffer.len()
    }

    /// Where in `buffer` the newline of the next line stands.
    fn end_of_line(&self) -> Option<usize> {
        position_of_newline(&self.buffer[self.searched..]).map(|offset| self.searched + offset)
    }

    /// Whether what is left is too long to become a line, even if a newline came now.
    fn is_full(&self) -> bool {
        self.buffer.len() - self.start >= MAX_LINE_BYTES
    }
}

fn position_of_newline(bytes: &[u8]) -> Option<usize> {
    bytes.iter().position(|&byte| byte == b'\n')
}

fn without_return(line: &[u8]) -> Vec<u8> {
    line.strip_suffix(b"\r").unwrap_or(line).to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn split(stream: &[u8], chunk_lengths: impl Iterator<Item = usize>) -> Vec<Result<Vec<u8>, LineTooLong>> {
        let (mut splitter, mut lines, mut rest) = (LineSplitter::default(), Vec::new(), stream);
        for length in chunk_lengths {
            let (chunk, later) = rest.split_at(length.min(rest.len()));
            splitter.feed(chunk);
            while let Some(line) = splitter.next_line() {
                lines.push(line);
            }
            assert!(splitter.buffer.len() - splitter.start < MAX_LINE_BYTES, "an unfinished line is bounded");
            rest = later;
        }
        assert!(rest.is_empty(), "the chunks must cover the stream");
        lines
    }

    /// The same by the definition: everything between newlines.
    fn reference(stream: &[u8]) -> Vec<Result<Vec<u8>, LineTooLong>> {
        let mut pieces: Vec<&[u8]> = stream.split(|&byte| byte == b'\n').collect();
        let unfinished = pieces.pop().unwrap();
        let mut lines: Vec<Result<Vec<u8>, LineTooLong>> = pieces
            .into_iter()
            .map(
                |piece| {
                    if piece.len() < MAX_LINE_BYTES { Ok(without_return(piece)) } else { Err(LineTooLong) }
                },
            )
            .collect();
        if unfinished.len() >= MAX_LINE_BYTES {
            lines.push(Err(LineTooLong));
        }
        lines
    }

    proptest! {
        #![proptest_config(crate::seed::cases(256))]

        #[test]
        fn chunks_do_not_matter(
            pieces in prop::collection::vec((0usize..40, prop::bool::weighted(0.1)), 0..20),
            chunks in prop::collection::vec(1usize..5000, 1..50),
            ended in any::<bool>(),
        ) {
            let mut stream = Vec::new();
            for (index, (length, huge)) in pieces.iter().enumerate() {
                // Lengths around the bound when huge.
                let length = if *huge { MAX_LINE_BYTES - 20 + length } else { *length };
                stream.extend(std::iter::repeat_n(b'a' + (index % 26) as u8, length));
                stream.push(b'\n');
            }
            if !ended {
                stream.pop();
            }
            let lines = split(&stream, chunks.iter().copied().cycle().take(stream.len() + 1));
            prop_assert_eq!(lines, reference(&stream));
        }
    }

    #[test]
    fn nothing_is_held_between_lines() {
        let mut splitter = LineSplitter::default();
        splitter.feed(b"one\r\ntwo\nthr");
        assert_eq!(splitter.next_line(), Some(Ok(b"one".to_vec())));
        assert!(splitter.has_line());
        assert_eq!(splitter.next_line(), Some(Ok(b"two".to_vec())));
        assert!(!splitter.has_line() && splitter.is_amid_line());
        assert_eq!(splitter.next_line(), None);
        splitter.feed(b"ee\n");
        assert_eq!(splitter.next_line(), Some(Ok(b"three".to_vec())));
        assert!(!splitter.is_amid_line());
        assert_eq!(splitter.buffer.capacity(), 0);
    }

    #[test]
    fn a_too_long_line_is_told_once_and_skipped() {
        let mut splitter = LineSplitter::default();
        let mut told = 0;
        for _ in 0..256 {
            splitter.feed(&[b'x'; 4096]);
            while let Some(line) = splitter.next_line() {
                assert_eq!(line, Err(LineTooLong));
                told += 1;
            }
        }
        assert_eq!(told, 1);
        splitter.feed(b"xx\nnext\n");
        assert_eq!(splitter.next_line(), Some(Ok(b"next".to_vec())));
    }
}
