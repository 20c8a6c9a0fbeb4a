//! From readings to the rows of a buffer: one of each channel that is wanted, all with a number.

use super::context::{Context, Element, sample};
use crate::stream::wire::ReadingLine;
use crate::units::Nanos;
use jiff::Timestamp;
use std::sync::Arc;

/// The row that is being filled.
#[derive(Debug)]
pub struct Rows {
    elements: Vec<Element>,
    /// Of each channel of the context: whether it is wanted, and its reading since the last row.
    slots: Vec<(bool, Option<Arc<ReadingLine>>)>,
    /// The readings of a row are no farther apart.
    patience: Nanos,
}

impl Rows {
    /// `mask`: a bit for each element of the context; `None`: it asks for what is not there, or for nothing.
    pub fn new(context: &Context, mask: u64, patience: Nanos) -> Option<Rows> {
        let count = context.elements.len();
        if mask == 0 || count > 64 || (count < 64 && mask >> count != 0) {
            return None;
        }
        let wanted = context.elements.iter().enumerate().filter(|(index, _)| mask >> index & 1 == 1);
        let elements: Vec<Element> = wanted.map(|(_, element)| *element).collect();
        let of_channel = |at: usize| {
            elements
                .iter()
                .any(|element| matches!(element, Element::Resistance(n) | Element::Shown(n, _) if *n == at))
        };
        // A timestamp alone is that of every channel's.
        let all = elements == [Element::Timestamp];
        let slots = (0..context.channels.len()).map(|at| (all || of_channel(at), None)).collect();
        Some(Rows { elements, slots, patience })
    }

    /// Bytes of a row.
    pub fn size(&self) -> usize {
        8 * self.elements.len()
    }

    /// Takes a reading; the row that it completes.
    pub fn feed(&mut self, context: &Context, reading: &Arc<ReadingLine>) -> Option<Vec<u8>> {
        let at = context.channels.iter().position(|channel| channel.id == reading.channel)?;
        let (is_wanted, slot) = &mut self.slots[at];
        if !*is_wanted {
            return None;
        }
        *slot = Some(Arc::clone(reading));
        // A row has one time: what is from before an outage is no part of it.
        let least_ns = reading.t_mono_ns - self.patience.0;
        for (_, slot) in &mut self.slots {
            *slot = slot.take().filter(|reading| reading.t_mono_ns >= least_ns);
        }
        if self.slots.iter().any(|(is_wanted, slot)| *is_wanted && slot.is_none()) {
            return None;
        }
        let row = self.row(reading);
        self.slots.iter_mut().for_each(|(_, slot)| *slot = None);
        row
    }

    /// `None`: not all have a number.
    fn row(&self, last: &ReadingLine) -> Option<Vec<u8>> {
        let time: Timestamp = last.time.parse().ok()?;
        let time_ns = i64::try_from(time.as_nanosecond()).ok()?;
        let mut row = Vec::with_capacity(self.size());
        for element in &self.elements {
            let reading = match element {
                Element::Resistance(at) | Element::Shown(at, _) => self.slots[*at].1.as_deref(),
                Element::Timestamp => None,
            };
            row.extend(sample(*element, reading, time_ns)?.to_le_bytes());
        }
        Some(row)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bridge::feed::Heard;
    use crate::bridge::latest::tests::{ok, reading, up};
    use crate::stream::wire::StateLine;

    fn context() -> Context {
        let Heard::Up(version) = up(&["thumb", "index"]) else { unreachable!() };
        Context::new(&version)
    }

    const PATIENCE: Nanos = Nanos(10);

    fn line(id: &str, state: StateLine) -> Arc<ReadingLine> {
        line_at(id, 0, state)
    }

    fn line_at(id: &str, t_mono_ns: i64, state: StateLine) -> Arc<ReadingLine> {
        let Heard::Reading(line, _) = reading(id, t_mono_ns, state) else { unreachable!() };
        Arc::new(*line)
    }

    fn numbers(row: &[u8]) -> Vec<i64> {
        row.chunks(8).map(|bytes| i64::from_le_bytes(bytes.try_into().unwrap())).collect()
    }

    #[test]
    fn a_row_has_a_number_of_each_channel_or_is_none() {
        // resistance0, force0, resistance1, force1, timestamp
        let mut rows = Rows::new(&context(), 0b10101, PATIENCE).unwrap();
        let mut feed = |id, state| rows.feed(&context(), &line(id, state)).map(|row| numbers(&row));
        assert_eq!(feed("thumb", ok(1.5)), None);
        assert_eq!(feed("other", ok(1.5)), None);
        assert_eq!(feed("thumb", ok(2.5)), None);
        assert_eq!(feed("index", ok(3.0)), Some(vec![2_500, 3_000, 1_795_232_400_500_000_000]));
        assert_eq!(feed("index", ok(3.0)), None);
        assert_eq!(feed("thumb", StateLine::default()), None, "a fault is no row");
        assert_eq!(feed("thumb", ok(1.0)), None, "nor is half of one");
        assert_eq!(feed("index", ok(4.0)), Some(vec![1_000, 4_000, 1_795_232_400_500_000_000]));
    }

    #[test]
    fn a_row_has_nothing_of_before_an_outage() {
        let mut rows = Rows::new(&context(), 0b10101, PATIENCE).unwrap();
        let mut feed = |id, at| rows.feed(&context(), &line_at(id, at, ok(1.0))).is_some();
        assert!(!feed("thumb", 0) && !feed("index", 11) && feed("thumb", 21));
    }

    #[test]
    fn what_is_not_there_cannot_be_asked_for() {
        assert!(Rows::new(&context(), 0, PATIENCE).is_none());
        assert!(Rows::new(&context(), 1 << 5, PATIENCE).is_none());
        assert_eq!(Rows::new(&context(), 0b11111, PATIENCE).unwrap().size(), 40);
        let mut rows = Rows::new(&context(), 0b00001, PATIENCE).unwrap();
        assert!(rows.feed(&context(), &line("index", ok(1.0))).is_none());
        assert_eq!(numbers(&rows.feed(&context(), &line("thumb", ok(1.0))).unwrap()), [1_000]);
    }
}
