//! Seeded fault injection over a [`Pins`], to show that whatever goes wrong below becomes a named fault above.

use cermd::circuit::Node;
use cermd::pins::{Armed, Bracket, Drives, Edge, Levels, Particulars, Pins, PinsError};
use cermd::units::Nanos;
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

    fn rest_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.fail("rest_until")?;
        self.inner.rest_until(at)
    }

    fn rest_before_edge(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.inner.rest_before_edge(at)
    }

    fn levels(&mut self) -> Result<Levels, PinsError> {
        self.fail("levels")?;
        let levels = self.inner.levels()?;
        Ok(self.perhaps_wrong(levels))
    }

    fn particulars(&self) -> Particulars<'_> {
        self.inner.particulars()
    }
}
