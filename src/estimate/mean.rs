//! The mean of readings of one sensor, with all that they share.
//!
//! What each reading has of its own averages out. The error of the tracked state does not: it is the same in readings between
//! two calibration discharges, and goes on in part after each. With e the error of the state, v_i how reading i depends on it, and
//! S = sum v_i e,
//!
//! ```text
//! a reading:                 Var S += 2 v c + v P v,   c += P v        c = Cov(S, e)
//! a calibration discharge:   c -= K H c                                e becomes e - K (H e + noise)
//! ```
//!
//! so that the variance of the mean is what the filter itself says of it, whatever the time.

use crate::estimate::law::{State, UNKNOWNS};
use crate::estimate::limits::{STEPS_LACK, STEPS_OF_A_MEAN, STEPS_SHOW};
use crate::estimate::tracker::Tracker;
use crate::reading::Measured;
use crate::units::Nanos;

/// What the uncertainty of a reading is made of, ohm².
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Basis {
    /// What no other reading shares.
    pub own: f64,
    /// How it depends on the tracked state, if it does.
    pub by_state: Option<State>,
    /// How it depends on the instant of a switch, ohm/ns, if there was one.
    pub by_switch: Option<f64>,
}

impl Basis {
    /// The same reading with 1 sigma of only what other readings share with it.
    pub fn shared(&self, Measured { value, u }: Measured) -> Measured {
        Measured { value, u: u.map(|u| (u * u - self.own).max(0.0).sqrt()) }
    }
}

/// Readings of a sensor, summed.
#[derive(Debug, Clone, Copy, Default)]
pub struct Mean {
    count: f64,
    /// The first one and the last, and the sum of what each is beside the first, ohm.
    first_ohm: f64,
    last_ohm: f64,
    sum: f64,
    /// The sum of what they have of their own, of the squares of their steps, and of what is alike in all of them as sigmas.
    own: f64,
    steps: f64,
    alike_ohm: f64,
    /// Var S and c.
    shared: f64,
    with_state: State,
    with_state_at: Nanos,
    /// How often the state had begun anew when it was that.
    of_state: u64,
    /// A reading has come without an uncertainty.
    is_unknown: bool,
}

impl Mean {
    /// How many there are.
    pub fn count(&self) -> usize {
        self.count as usize
    }

    /// Takes a reading; `tracker`: the calibration that it was made with.
    pub fn add(&mut self, r_ohm: Measured, basis: &Basis, tracker: Option<&Tracker>) {
        if self.count == 0.0 {
            (self.first_ohm, self.last_ohm) = (r_ohm.value, r_ohm.value);
        }
        self.count += 1.0;
        self.sum += r_ohm.value - self.first_ohm;
        self.steps += (r_ohm.value - self.last_ohm).powi(2);
        self.last_ohm = r_ohm.value;
        self.own += basis.own;
        let mut by_state = 0.0;
        if let (Some(v), Some(tracker)) = (basis.by_state, tracker) {
            by_state = tracker.variance(&v);
            self.carry(tracker);
            let with_state = tracker.with_state(&v);
            let dot = |u: &State| (0..UNKNOWNS).map(|i| v[i] * u[i]).sum::<f64>();
            self.shared += 2.0 * dot(&self.with_state) + dot(&with_state);
            for (sum, one) in self.with_state.iter_mut().zip(with_state) {
                *sum += one;
            }
        }
        match r_ohm.u {
            Some(u) => self.alike_ohm += (u * u - basis.own - by_state).max(0.0).sqrt(),
            None => self.is_unknown = true,
        }
    }

    /// After a calibration discharge that the tracked state has taken in.
    pub fn calibrated(&mut self, tracker: &Tracker) {
        self.carry(tracker);
        self.with_state = tracker.after_correction(&self.with_state);
    }

    fn carry(&mut self, tracker: &Tracker) {
        // A state that has begun anew shares nothing with the one before.
        self.with_state = match tracker.steps() == self.of_state {
            true => tracker.carried(self.with_state, self.with_state_at),
            false => State::default(),
        };
        (self.with_state_at, self.of_state) = (tracker.at(), tracker.steps());
    }

    /// The mean; `None` of none. `tracker`: as it is now.
    pub fn result(&self, tracker: Option<&Tracker>) -> Option<Measured> {
        if self.count == 0.0 {
            return None;
        }
        let misfit = tracker.map_or(1.0, Tracker::misfit);
        let shared = misfit * self.shared.max(0.0) / self.count.powi(2);
        let (own, rounded) = self.own();
        let u = (own / self.count + rounded + shared + (self.alike_ohm / self.count).powi(2)).sqrt();
        Some(Measured { value: self.first_ohm + self.sum / self.count, u: (!self.is_unknown).then_some(u) })
    }

    /// The variance of a reading for itself, as it is stated or by their steps where those show that it is more; and what of it is
    /// alike in all of them: a coarse clock that starts go by rounds the same time to the same count.
    fn own(&self) -> (f64, f64) {
        let (stated, steps) = (self.own / self.count, self.count - 1.0);
        if steps < STEPS_OF_A_MEAN {
            return (stated, 0.0);
        }
        let shown = self.steps / (2.0 * steps);
        // Half the mean square of successive differences has two degrees of freedom for three of them.
        let chance = STEPS_SHOW * (3.0 / steps).sqrt();
        match shown / stated {
            ratio if ratio > 1.0 + chance => (shown, 0.0),
            ratio if ratio < STEPS_LACK.min(1.0 - chance) => (shown, stated - shown),
            _ => (stated, 0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_alike_stays_and_what_is_not_goes() {
        let mut mean = Mean::default();
        assert_eq!(mean.result(None), None);
        // 0.3 of its own, 0.4 alike.
        for index in 0..100 {
            let value = 1000.0 + if index % 2 == 0 { 0.2 } else { -0.2 };
            let basis = Basis { own: 0.09, ..Basis::default() };
            mean.add(Measured { value, u: Some(0.5) }, &basis, None);
        }
        let Measured { value, u } = mean.result(None).unwrap();
        assert!((value - 1000.0).abs() < 1e-9 && mean.count() == 100);
        assert!((u.unwrap() - (0.0009f64 + 0.16).sqrt()).abs() < 1e-9, "{u:?}");
        mean.add(Measured { value: 1000.0, u: None }, &Basis::default(), None);
        assert_eq!(mean.result(None).unwrap().u, None);
    }

    #[test]
    fn readings_that_differ_by_more_than_they_say_are_believed() {
        let mut mean = Mean::default();
        for index in 0..100 {
            let value = if index % 2 == 0 { 1001.0 } else { 999.0 };
            mean.add(Measured { value, u: Some(0.1) }, &Basis { own: 0.01, ..Basis::default() }, None);
        }
        // Steps of 2 are a scatter of 1.4.
        let u = mean.result(None).unwrap().u.unwrap();
        assert!((u - 2f64.sqrt() / 10.0).abs() < 1e-9, "{u}");
    }

    #[test]
    fn what_steps_do_not_show_does_not_average_out() {
        let of = |count: usize, step: f64| {
            let mut mean = Mean::default();
            for index in 0..count {
                let value = if index % 2 == 0 { 1000.0 } else { 1000.0 + step };
                mean.add(Measured { value, u: Some(0.3) }, &Basis { own: 0.09, ..Basis::default() }, None);
            }
            mean.result(None).unwrap().u.unwrap()
        };
        assert!((of(400, 0.0) - 0.3).abs() < 1e-9, "the same count each time: {}", of(400, 0.0));
        assert!((of(10, 0.0) - 0.3 / 10f64.sqrt()).abs() < 1e-9, "few steps tell nothing: {}", of(10, 0.0));
        // Steps of 0.3 are a variance of half of what is stated: no more than it is often overstated.
        assert!((of(400, 0.3) - 0.3 / 20.0).abs() < 1e-9, "{}", of(400, 0.3));
    }
}
