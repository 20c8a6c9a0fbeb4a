//! How long things take on a computer that does other things as well, drawn in ns.

use super::scene::{CallsScene, DelayScene, TicksScene};
use crate::pins::limits::{MIDDLE_OF_SLOT, SHORTEST_CALL};
use crate::units::Seconds;
use rand::{Rng, RngExt};
use rand_distr::{Exp1, StandardNormal};

/// A duration of a scene in ns; an absent one is 0.
pub(super) fn ns(duration: impl Into<Option<Seconds>>) -> f64 {
    duration.into().map_or(0.0, |duration| duration.0 * 1e9)
}

/// The same in whole ns.
pub(super) fn whole_ns(duration: impl Into<Option<Seconds>>) -> i64 {
    ns(duration).round() as i64
}

/// A rare long delay, exponentially distributed; none is drawn where the scene names none.
fn tail_ns(probability: Option<f64>, mean: Option<Seconds>, rng: &mut impl Rng) -> f64 {
    match probability.zip(mean) {
        Some((probability, mean)) if rng.random::<f64>() < probability => {
            ns(mean) * rng.sample::<f64, _>(Exp1)
        }
        _ => 0.0,
    }
}

impl DelayScene {
    /// One delay, never negative.
    pub(super) fn draw_ns(&self, rng: &mut impl Rng) -> f64 {
        let gaussian = match ns(self.jitter) {
            0.0 => ns(self.mean),
            sigma => (ns(self.mean) + sigma * rng.sample::<f64, _>(StandardNormal)).max(0.0),
        };
        gaussian + tail_ns(self.tail_probability, self.tail_mean, rng)
    }
}

impl TicksScene {
    /// How long the tick goes on that there is at an instant, ns; 0: there is none.
    pub(super) fn remaining_ns(&self, at_ns: i64) -> i64 {
        let since_ns = at_ns.rem_euclid(whole_ns(self.every).max(1));
        (whole_ns(self.takes) - since_ns).max(0)
    }

    /// When the next one begins, ns after an instant at which there is none, and for how long.
    pub(super) fn next_ns(&self, at_ns: i64) -> [f64; 2] {
        let every_ns = whole_ns(self.every).max(1);
        [(every_ns - at_ns.rem_euclid(every_ns)) as f64, ns(self.takes)]
    }
}

/// The timing of one call that switches lines.
#[derive(Debug, Clone, Copy)]
pub(super) struct CallTiming {
    fixed_ns: f64,
    slot_ns: f64,
    moves_at: [f64; 2],
    scale: f64,
    pause_ns: f64,
    /// The pause comes before the line of this position.
    pause_before: usize,
    lines: usize,
    wakes_ns: f64,
    /// When a tick interrupts it, and for how long.
    tick_ns: Option<[f64; 2]>,
}

impl CallsScene {
    /// Draws what is common to one call that switches so many lines of a chip that was left alone for `idle_ns`; `tick_ns`: when the next
    /// tick begins, and for how long.
    pub(super) fn begin(
        &self,
        lines: usize,
        idle_ns: i64,
        tick_ns: Option<[f64; 2]>,
        rng: &mut impl Rng,
    ) -> CallTiming {
        let scale = match self.jitter {
            None | Some(0.0) => 1.0,
            Some(jitter) => (1.0 + jitter * rng.sample::<f64, _>(StandardNormal)).max(SHORTEST_CALL),
        };
        let pause_ns = tail_ns(self.tail_probability, self.tail_mean, rng);
        let pause_before = if pause_ns > 0.0 { rng.random_range(0..=lines as u32) as usize } else { 0 };
        let (fixed_ns, slot_ns) = (ns(self.fixed), ns(self.per_line));
        let moves_at = self.moves_at.unwrap_or(MIDDLE_OF_SLOT);
        let is_asleep = self.asleep_after.is_some_and(|after| idle_ns > whole_ns(after));
        let wakes_ns = if is_asleep { ns(self.wakes_in) } else { 0.0 };
        CallTiming { fixed_ns, slot_ns, moves_at, scale, pause_ns, pause_before, lines, wakes_ns, tick_ns }
    }
}

impl CallTiming {
    /// Later by a tick that comes before.
    fn interrupted(&self, after_ns: f64) -> f64 {
        let tick = self.tick_ns.filter(|[begins_ns, _]| *begins_ns <= after_ns);
        after_ns + tick.map_or(0.0, |[_, lasts_ns]| lasts_ns)
    }

    /// When the line at `position` moves, ns since the call began; it may be over by then.
    pub fn moves_ns(&self, position: usize, rng: &mut impl Rng) -> f64 {
        let [low, high] = self.moves_at;
        let within = if low == high { low } else { low + (high - low) * rng.random::<f64>() };
        let pause = if position >= self.pause_before { self.pause_ns } else { 0.0 };
        let moves_ns = (self.fixed_ns / 2.0 + (position as f64 + within) * self.slot_ns) * self.scale;
        self.interrupted(moves_ns + pause + self.wakes_ns)
    }

    /// How long the call takes, ns.
    pub fn duration_ns(&self) -> f64 {
        self.interrupted((self.fixed_ns + self.lines as f64 * self.slot_ns) * self.scale + self.pause_ns)
    }
}
