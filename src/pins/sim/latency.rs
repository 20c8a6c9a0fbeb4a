//! How long things take on a computer that does other things as well.
//!
//! For: drawing durations in ns. Must not know: what takes that long.

use rand::{Rng, RngExt};
use rand_distr::{Exp1, StandardNormal};

/// A rare long delay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tail {
    /// How often it happens, 0..=1.
    pub probability: f64,
    /// Mean of its exponentially distributed length, ns.
    pub mean_ns: f64,
}

impl Tail {
    fn draw_ns(&self, rng: &mut impl Rng) -> f64 {
        if rng.random::<f64>() < self.probability { self.mean_ns * rng.sample::<f64, _>(Exp1) } else { 0.0 }
    }
}

/// A delay that is never negative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Delay {
    /// Without the tail, ns.
    pub mean_ns: f64,
    /// Standard deviation without the tail, ns.
    pub jitter_ns: f64,
    /// What comes on top, rarely.
    pub tail: Option<Tail>,
}

impl Delay {
    /// One delay, ns.
    pub fn draw_ns(&self, rng: &mut impl Rng) -> f64 {
        let gaussian = match self.jitter_ns {
            0.0 => self.mean_ns,
            sigma => (self.mean_ns + sigma * rng.sample::<f64, _>(StandardNormal)).max(0.0),
        };
        gaussian + self.tail.map_or(0.0, |tail| tail.draw_ns(rng))
    }
}

/// The duration of a call that switches lines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calls {
    /// Half of it before the first line moves, half after the last, ns.
    pub fixed_ns: f64,
    /// Slot of each line, ns.
    pub per_line_ns: f64,
    /// Standard deviation of the whole call's duration, relative.
    pub jitter: f64,
    /// Where in its slot a line moves, as fractions: uniform between these.
    pub moves_at: [f64; 2],
    /// Preemption in the middle of a call.
    pub tail: Option<Tail>,
}

/// One call's timing.
#[derive(Debug, Clone, Copy)]
pub struct Call {
    scale: f64,
    pause_ns: f64,
    /// The pause comes before the line of this position.
    pause_before: usize,
    lines: usize,
}

impl Calls {
    /// Draws what is common to one call that switches so many lines.
    pub fn begin(&self, lines: usize, rng: &mut impl Rng) -> Call {
        let scale = match self.jitter {
            0.0 => 1.0,
            // A call is never faster than a tenth of its usual duration.
            jitter => (1.0 + jitter * rng.sample::<f64, _>(StandardNormal)).max(0.1),
        };
        let pause_ns = self.tail.map_or(0.0, |tail| tail.draw_ns(rng));
        let pause_before = if pause_ns > 0.0 { rng.random_range(0..=lines as u32) as usize } else { 0 };
        Call { scale, pause_ns, pause_before, lines }
    }

    /// When the line at `position` moves, ns since the call began.
    pub fn moves_ns(&self, call: &Call, position: usize, rng: &mut impl Rng) -> f64 {
        let [low, high] = self.moves_at;
        let within = if low == high { low } else { low + (high - low) * rng.random::<f64>() };
        let pause = if position >= call.pause_before { call.pause_ns } else { 0.0 };
        (self.fixed_ns / 2.0 + (position as f64 + within) * self.per_line_ns) * call.scale + pause
    }

    /// How long the call takes, ns.
    pub fn duration_ns(&self, call: &Call) -> f64 {
        (self.fixed_ns + call.lines as f64 * self.per_line_ns) * call.scale + call.pause_ns
    }
}
