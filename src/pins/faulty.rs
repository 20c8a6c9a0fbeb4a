//! Seeded fault injection over a [`Pins`].
//!
//! For: showing that whatever goes wrong below becomes a named fault above. Must not know: who listens.

use super::{Armed, Bracket, Drives, Edge, Levels, Node, Pins, PinsError};
use crate::units::Nanos;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::Exp1;

/// What can be made to go wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Injection {
    /// An edge never comes and leaves no gap: lost in hardware.
    LostEdge,
    /// An edge is stamped, and comes, later by [`DELAY_MEAN`] on average.
    DelayedStamp,
    /// An edge comes twice, with a number of its own each time.
    DuplicatedEdge,
    /// A call fails with EIO and does nothing.
    FailingCall,
    /// One level, drawn at random, is told wrongly.
    WrongLevel,
    /// A call that switches takes longer by [`DELAY_MEAN`] on average, after the lines have moved.
    LongBracket,
    /// Both sequence numbers skip one, as if the buffer had been full.
    SeqnoGap,
}

impl Injection {
    /// Everything that can be made to go wrong.
    pub const ALL: [Injection; 7] = [
        Injection::LostEdge,
        Injection::DelayedStamp,
        Injection::DuplicatedEdge,
        Injection::FailingCall,
        Injection::WrongLevel,
        Injection::LongBracket,
        Injection::SeqnoGap,
    ];
}

/// Mean of the exponentially distributed delays.
pub const DELAY_MEAN: Nanos = Nanos(200_000);

/// EIO, asm-generic/errno-base.h.
const EIO: i32 = 5;

/// Any [`Pins`], with faults at random.
#[derive(Debug)]
pub struct Faulty<P> {
    inner: P,
    probabilities: [f64; Injection::ALL.len()],
    counts: [u64; Injection::ALL.len()],
    again: Option<Edge>,
    seqno_shift: u32,
    line_seqno_shift: [u32; 2],
    rng: ChaCha8Rng,
}

impl<P: Pins> Faulty<P> {
    /// Without any fault until [`Faulty::with`] names some.
    pub fn new(inner: P, seed: u64) -> Faulty<P> {
        Faulty {
            inner,
            probabilities: [0.0; Injection::ALL.len()],
            counts: [0; Injection::ALL.len()],
            again: None,
            seqno_shift: 0,
            line_seqno_shift: [0; 2],
            rng: ChaCha8Rng::seed_from_u64(seed),
        }
    }

    /// With this fault at each occasion (edge or call) with a probability of 0..=1.
    pub fn with(mut self, injection: Injection, probability: f64) -> Faulty<P> {
        self.probabilities[injection as usize] = probability;
        self
    }

    /// How often it has happened.
    pub fn count(&self, injection: Injection) -> u64 {
        self.counts[injection as usize]
    }

    /// The pins themselves.
    pub fn inner(&mut self) -> &mut P {
        &mut self.inner
    }

    fn strikes(&mut self, injection: Injection) -> bool {
        let probability = self.probabilities[injection as usize];
        let strikes = probability > 0.0 && self.rng.random::<f64>() < probability;
        self.counts[injection as usize] += u64::from(strikes);
        strikes
    }

    fn fail(&mut self, call: &'static str) -> Result<(), PinsError> {
        if !self.strikes(Injection::FailingCall) {
            return Ok(());
        }
        Err(PinsError::Call {
            call,
            line: "an injected fault".to_owned(),
            source: std::io::Error::from_raw_os_error(EIO),
            hint: "nothing is wrong: this failure was asked for",
        })
    }

    fn delay(&mut self) -> Nanos {
        Nanos((DELAY_MEAN.as_ns() * self.rng.sample::<f64, _>(Exp1)).round() as i64)
    }

    fn shift(&mut self, node: Node, by: u32) {
        self.seqno_shift = self.seqno_shift.wrapping_add(by);
        let line = &mut self.line_seqno_shift[node.index()];
        *line = line.wrapping_add(by);
    }

    fn numbered(&self, edge: Edge) -> Edge {
        let line_shift = self.line_seqno_shift[edge.node.index()];
        Edge {
            seqno: edge.seqno.wrapping_add(self.seqno_shift),
            line_seqno: edge.line_seqno.wrapping_add(line_shift),
            ..edge
        }
    }

    fn perhaps_wrong(&mut self, levels: Levels) -> Levels {
        if !self.strikes(Injection::WrongLevel) {
            return levels;
        }
        match self.rng.random::<bool>() {
            true => Levels { a: !levels.a, ..levels },
            false => Levels { b: !levels.b, ..levels },
        }
    }
}

impl<P: Pins> Pins for Faulty<P> {
    fn now(&mut self) -> Nanos {
        self.inner.now()
    }

    fn drive(&mut self, on: Drives) -> Result<Bracket, PinsError> {
        self.fail("drive")?;
        let mut bracket = self.inner.drive(on)?;
        if self.strikes(Injection::LongBracket) {
            let end = bracket.after + self.delay();
            self.inner.sleep_until(end)?;
            bracket.after = self.inner.now();
        }
        Ok(bracket)
    }

    fn arm(&mut self) -> Result<Armed, PinsError> {
        self.fail("arm")?;
        self.again = None;
        let armed = self.inner.arm()?;
        let [a, b] = self.line_seqno_shift;
        Ok(Armed {
            levels: self.perhaps_wrong(armed.levels),
            seqno: armed.seqno.wrapping_add(self.seqno_shift),
            line_seqno: [armed.line_seqno[0].wrapping_add(a), armed.line_seqno[1].wrapping_add(b)],
        })
    }

    fn edge(&mut self, until: Nanos) -> Result<Option<Edge>, PinsError> {
        self.fail("edge")?;
        if let Some(edge) = self.again.take() {
            self.shift(edge.node, 1);
            return Ok(Some(self.numbered(edge)));
        }
        while let Some(mut edge) = self.inner.edge(until)? {
            if self.strikes(Injection::LostEdge) {
                self.shift(edge.node, u32::MAX);
                continue;
            }
            if self.strikes(Injection::DelayedStamp) {
                edge.at = edge.at + self.delay();
                self.inner.sleep_until(edge.at)?;
            }
            if self.strikes(Injection::SeqnoGap) {
                self.shift(edge.node, 1);
            }
            if self.strikes(Injection::DuplicatedEdge) {
                self.again = Some(edge);
            }
            return Ok(Some(self.numbered(edge)));
        }
        Ok(None)
    }

    fn sleep_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.fail("sleep_until")?;
        self.inner.sleep_until(at)
    }

    fn levels(&mut self) -> Result<Levels, PinsError> {
        self.fail("levels")?;
        let levels = self.inner.levels()?;
        Ok(self.perhaps_wrong(levels))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pins::sim::{Scene, SimPins};

    fn faulty(injection: Injection, probability: f64) -> Faulty<SimPins> {
        Faulty::new(SimPins::new(&Scene::builtin("ideal").unwrap(), None), 7).with(injection, probability)
    }

    /// One discharge: what arming said, the start, and the edges.
    fn discharge(pins: &mut Faulty<SimPins>) -> Result<(Armed, Bracket, Vec<Edge>), PinsError> {
        pins.drive(Drives::CHARGE)?;
        let charged = pins.now() + Nanos(20_000_000);
        pins.sleep_until(charged)?;
        pins.drive(Drives::NONE)?;
        let armed = pins.arm()?;
        let start = pins.drive(Drives::C1)?;
        let until = start.after + Nanos(50_000_000);
        let mut edges = Vec::new();
        while let Some(edge) = pins.edge(until)? {
            edges.push(edge);
        }
        pins.drive(Drives::NONE)?;
        Ok((armed, start, edges))
    }

    fn clean() -> (Armed, Bracket, Vec<Edge>) {
        discharge(&mut faulty(Injection::LostEdge, 0.0)).unwrap()
    }

    #[test]
    fn a_lost_edge_leaves_no_gap() {
        let mut pins = faulty(Injection::LostEdge, 1.0);
        assert!(discharge(&mut pins).unwrap().2.is_empty());
        assert_eq!(pins.count(Injection::LostEdge), 2);
        pins.probabilities = [0.0; 7];
        let (armed, _, edges) = discharge(&mut pins).unwrap();
        assert_eq!(edges[0].seqno, armed.seqno.wrapping_add(1));
        assert_eq!(edges[0].line_seqno, armed.line_seqno[0].wrapping_add(1));
    }

    #[test]
    fn a_delayed_stamp_is_later_and_time_has_passed() {
        let mut pins = faulty(Injection::DelayedStamp, 1.0);
        let (_, _, edges) = discharge(&mut pins).unwrap();
        for (late, punctual) in edges.iter().zip(clean().2) {
            assert!(late.at > punctual.at);
        }
        assert!(pins.now() >= edges[1].at);
    }

    #[test]
    fn a_duplicate_has_a_number_of_its_own() {
        let mut pins = faulty(Injection::DuplicatedEdge, 1.0);
        let (armed, _, edges) = discharge(&mut pins).unwrap();
        let seqnos: Vec<_> = edges.iter().map(|edge| edge.seqno - armed.seqno).collect();
        assert_eq!(seqnos, [1, 2, 3, 4]);
        assert_eq!(edges[0].at, edges[1].at);
        assert_eq!(edges[3].line_seqno, 2);
        assert_eq!(pins.arm().unwrap().seqno, 4);
    }

    #[test]
    fn a_gap_shows_in_both_numbers() {
        let (armed, _, edges) = discharge(&mut faulty(Injection::SeqnoGap, 1.0)).unwrap();
        assert_eq!(edges[0].seqno - armed.seqno, 2);
        assert_eq!(edges[0].line_seqno - armed.line_seqno[0], 2);
    }

    #[test]
    fn a_failing_call_does_nothing() {
        let mut pins = faulty(Injection::FailingCall, 1.0);
        let error = pins.drive(Drives::CHARGE).unwrap_err();
        assert!(error.to_string().contains("drive"), "{error}");
        assert_eq!(pins.inner().driving(), Drives::NONE);
    }

    #[test]
    fn a_wrong_level_is_wrong_in_one_node() {
        let mut pins = faulty(Injection::WrongLevel, 1.0);
        let levels = pins.levels().unwrap();
        assert!(levels.a != levels.b, "both are low while nothing was charged");
    }

    #[test]
    fn a_long_bracket_is_as_long_as_it_says() {
        let mut pins = faulty(Injection::LongBracket, 1.0);
        let start = discharge(&mut pins).unwrap().1;
        assert!(start.width() > Nanos::ZERO);
        assert_eq!(clean().1.width(), Nanos::ZERO);
    }

    #[test]
    fn counts_what_it_does_and_repeats_itself() {
        let run = || {
            let mut pins = faulty(Injection::LostEdge, 0.2);
            let edges: Vec<_> = (0..100).map(|_| discharge(&mut pins).unwrap().2.len()).collect();
            let lost = pins.count(Injection::LostEdge);
            assert_eq!(edges.iter().sum::<usize>() as u64, 200 - lost);
            (edges, lost)
        };
        let (edges, lost) = run();
        // 200 times 0.2: 40 +- 5.7; five sigma.
        assert!((12..=68).contains(&lost), "{lost}");
        assert_eq!(run(), (edges, lost));
    }
}
