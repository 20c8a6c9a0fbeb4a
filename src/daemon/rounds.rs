//! Rounds of calibration discharges that a tracked calibration can begin with: a tape that begins later than the daemon has them
//! from here.
//!
//! The first rounds time every node. Once there is a state, discharges that keep it end at node A mostly: a tape of those alone
//! would show how the calibration is followed, but never where it stands.

use crate::instrument::settings::Settings;
use crate::record::Record;
use crate::stream::tape::{DischargeLine, Header};

/// The discharges since the last whole round: the last one of each kind.
#[derive(Debug, Default)]
pub struct Round([Option<(u64, Record)>; 3]);

impl Round {
    /// Takes a discharge; the round in the order of time, as lines of a tape, if this ends one.
    pub fn add(
        &mut self,
        settings: &Settings,
        header: &Header,
        (seq, record): (u64, &Record),
    ) -> Option<[DischargeLine; 3]> {
        let is_of_use = settings.tracked && record.complete(settings.nodes()).is_some();
        let kind = record.calibration_kind().filter(|_| is_of_use)?;
        self.0[kind as usize] = Some((seq, *record));
        let [Some(first), Some(second), Some(split)] = self.0 else { return None };
        self.0 = Default::default();
        let mut round = [first, second, split];
        round.sort_by_key(|(seq, _)| *seq);
        Some(round.map(|(seq, record)| header.discharge(seq, &record, false)))
    }
}
