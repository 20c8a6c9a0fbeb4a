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
        // A state begins with discharges that are all alike: with those that the program slept through.
        let is_plain = record.complete(settings.nodes()).is_some() && !record.is_woken();
        let is_of_use = settings.tracked && is_plain;
        let kind = record.calibration_kind().filter(|_| is_of_use)?;
        self.0[kind as usize] = Some((seq, *record));
        let [Some(first), Some(second), Some(split)] = self.0 else { return None };
        self.0 = Default::default();
        let mut round = [first, second, split];
        round.sort_by_key(|(seq, _)| *seq);
        Some(round.map(|(seq, record)| header.discharge(seq, &record, false)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{Config, tape_header};
    use crate::record::{Switch, Through};
    use crate::units::Nanos;

    #[test]
    fn a_discharge_in_which_the_program_woke_is_in_no_round() {
        let text = "[circuit]\nkind = \"one-capacitor\"\nc = \"1 uF\"\nr-c1 = \"1 kohm\"\nr-c2 = \"9 kohm\"\n[[channel]]\nid = \"x\"\n";
        let settings = Config::parse(text, "test").unwrap().settings().unwrap();
        let (header, mut round) = (tape_header(&settings, None), Round::default());
        let record = |through, switched: Option<(f64, Through)>| Record {
            through,
            start: Nanos(1),
            second_ns: None,
            switch: switched.map(|(at_ns, to)| Switch { at_ns, on_ns: at_ns, to }),
            a_ns: Some(1e6),
            b_ns: None,
            u_switch_ns: None,
            waited_ns: None,
            later_ns: None,
        };
        let (c1, c2) = (Through::C1, Through::C2);
        let taken = [
            record(c1, None),
            record(c2, None),
            record(c1, Some((0.8e6, c1))),
            record(c2, Some((0.8e6, c2))),
            record(c1, Some((0.8e6, c2))),
        ];
        let ended =
            taken.iter().zip(1..).filter_map(|(record, seq)| round.add(&settings, &header, (seq, record)));
        let rounds: Vec<Vec<u64>> = ended.map(|lines| lines.iter().map(|line| line.seq).collect()).collect();
        assert_eq!(rounds, [[1, 2, 5]]);
    }
}
