//! Pins whose answers are the bytes of an input.

use cermd::circuit::Node;
use cermd::pins::{Armed, Bracket, Drives, Edge, Levels, Particulars, Pins, PinsError};
use cermd::units::Nanos;

/// Answers as long as there are bytes, then the measurement is stopped.
#[derive(Debug)]
pub struct Hostile<'a> {
    bytes: &'a [u8],
    now: Nanos,
    on: Drives,
    seqno: u32,
    line_seqno: [u32; 2],
    conflicts: u32,
}

impl<'a> Hostile<'a> {
    pub fn new(bytes: &'a [u8]) -> Hostile<'a> {
        let now = Nanos(1_000_000_000);
        Hostile { bytes, now, on: Drives::NONE, seqno: 0, line_seqno: [0; 2], conflicts: 0 }
    }

    pub fn is_over(&self) -> bool {
        self.bytes.is_empty()
    }

    /// How often outputs were asked for that drive against each other.
    pub fn conflicts(&self) -> u32 {
        self.conflicts
    }

    /// The next byte; one in sixteen is the failure of a call.
    fn answer(&mut self) -> Result<u8, PinsError> {
        let (byte, rest) = self.bytes.split_first().ok_or(PinsError::Stopped)?;
        self.bytes = rest;
        if *byte >= 0xf0 { Err(PinsError::Unwired(Drives::NONE)) } else { Ok(*byte) }
    }

    /// Time goes on by up to 7 s; half of the answers mean less than a microsecond.
    fn pass(&mut self, byte: u8) {
        self.now = self.now + Nanos(if byte < 0x80 { i64::from(byte) * 7 } else { 1 << ((byte & 0x1f) + 2) });
    }

    fn levels_of(byte: u8) -> Levels {
        // Mostly high, or nothing would ever begin.
        Levels { a: byte & 0x07 != 1, b: byte & 0x38 != 8 }
    }
}

impl Pins for Hostile<'_> {
    fn now(&mut self) -> Nanos {
        self.now
    }
    fn drive(&mut self, on: Drives) -> Result<Bracket, PinsError> {
        self.conflicts += u32::from(on.conflicts());
        let before = self.now;
        let byte = self.answer()?;
        self.on = on;
        self.pass(byte);
        Ok(Bracket { before, after: self.now })
    }
    fn arm(&mut self) -> Result<Armed, PinsError> {
        let byte = self.answer()?;
        // Near its end now and then, where it wraps.
        self.seqno = if byte & 0x40 > 0 { u32::MAX - u32::from(byte & 3) } else { self.seqno };
        Ok(Armed { levels: Self::levels_of(byte), seqno: self.seqno, line_seqno: self.line_seqno })
    }
    fn edge(&mut self, until: Nanos) -> Result<Option<Edge>, PinsError> {
        let byte = self.answer()?;
        if byte & 0x07 == 0 {
            self.now = self.now.max(until);
            return Ok(None);
        }
        let late = self.answer()?;
        self.pass(late);
        let node = if byte & 0x08 > 0 { Node::B } else { Node::A };
        self.seqno = self.seqno.wrapping_add(if byte & 0x70 == 0x10 { 2 } else { 1 });
        let line = &mut self.line_seqno[node.index()];
        *line = line.wrapping_add(if byte & 0x70 == 0x20 { 2 } else { 1 });
        let line_seqno = *line;
        // Of the past, or of a moment to come.
        let at = match byte & 0x70 {
            0x30 => self.now - Nanos(i64::from(late) << 16),
            0x40 => self.now + Nanos(i64::from(late) << 16),
            _ => self.now,
        };
        Ok(Some(Edge { node, at, seqno: self.seqno, line_seqno }))
    }
    fn sleep_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        let byte = self.answer()?;
        self.now = self.now.max(at);
        self.pass(byte);
        Ok(())
    }
    fn rest_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.sleep_until(at)
    }
    fn rest_before_edge(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.sleep_until(at)
    }
    fn levels(&mut self) -> Result<Levels, PinsError> {
        self.answer().map(Self::levels_of)
    }
    fn particulars(&self) -> Particulars<'_> {
        Particulars::default()
    }
}
