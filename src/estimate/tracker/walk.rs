//! How the state goes on between calibration discharges: as it has gone, and at random.

use super::Tracker;
use super::speeds::Speeds;
use crate::estimate::law::{RATE, State, UNKNOWNS};
use crate::estimate::limits::{LONGEST_AHEAD_S, RATE_WALK, UNKNOWN_JITTER_NS};
use crate::units::Nanos;

impl Tracker {
    /// By how much the variance of v times the state grows in a second.
    pub fn growth(&self, v: &State) -> f64 {
        let walks: f64 = self.walks().iter().zip(v).map(|(walk, v)| (walk * v).powi(2)).sum();
        let with_state = self.with_state(v);
        walks + (0..2).map(|node| 2.0 * v[node] * self.state[node] * with_state[RATE + node]).sum::<f64>()
    }

    /// Lets the state go on as it has gone, but not for longer than that can be believed, and walk.
    pub fn advance(&mut self, now: Nanos) {
        let elapsed = (now - self.at).as_seconds().max(0.0);
        let seconds = elapsed.min(LONGEST_AHEAD_S);
        self.at = now;
        for node in 0..self.nodes {
            let by_rate = self.state[node] * seconds;
            self.state[node] += by_rate * self.state[RATE + node];
            for j in 0..UNKNOWNS {
                self.covariance[node][j] += by_rate * self.covariance[RATE + node][j];
            }
            for j in 0..UNKNOWNS {
                self.covariance[j][node] += by_rate * self.covariance[j][RATE + node];
            }
        }
        for (index, walk) in self.walks().into_iter().enumerate() {
            self.covariance[index][index] += walk * walk * elapsed;
        }
    }

    /// What a covariance with the state at an instant has become since.
    pub fn carried(&self, mut c: State, since: Nanos) -> State {
        let seconds = (self.at - since).as_seconds();
        for node in 0..self.nodes {
            c[node] += self.state[node] * seconds * c[RATE + node];
        }
        c
    }

    /// [`Noise::jitter_ns`](crate::estimate::noise::Noise::jitter_ns), that of any board as long as it is not known.
    pub(super) fn jitter_ns(&self) -> f64 {
        self.noise.jitter_ns().unwrap_or(UNKNOWN_JITTER_NS)
    }

    /// Since when the state is as it is.
    pub fn at(&self) -> Nanos {
        self.at
    }

    /// How fast each part of the state walks, per root second.
    fn walks(&self) -> State {
        let [walk_d, walk_g, walk_r_o] = self.speeds.each_ref().map(Speeds::walk);
        let walk_d = walk_d * self.jitter_ns();
        let walk_d_b = if self.nodes == 2 { walk_d } else { 0.0 };
        let [rate, rate_b] = [RATE_WALK, if self.nodes == 2 { RATE_WALK } else { 0.0 }];
        [walk_g * self.state[0], walk_g * self.state[1], walk_r_o, walk_d, walk_d_b, rate, rate_b]
    }
}
