//! Against the law with noise: the truth lies within the stated covariance, a step is found, a spike is not believed.

use super::*;
use crate::chance::{mean_of, rms_of, share_is_in, sigmas};
use crate::estimate::law::RATE;
use crate::estimate::limits::{AWAKE_YOUNG, BY_ELSEWHERE, ELSEWHERE_YOUNG, NEVER_SO_LATE, ROUGH_ROUNDS};
use crate::estimate::mean::{Basis, Mean};
use crate::reading::Measured;
use crate::record::Switch;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const R: [f64; 2] = [2320.0, 12_700.0];
const TRUTH: State = [570.0, 1070.0, 40.0, 8000.0, 300.0, 0.0, 0.0];

struct Plant {
    rng: ChaCha8Rng,
    state: State,
    now: Nanos,
}

impl Plant {
    fn new(seed: u64) -> Plant {
        Plant { rng: crate::seed::rng(seed), state: TRUTH, now: Nanos::ZERO }
    }

    /// A calibration discharge, every 30 ms; jitter 1.5 us and trigger noise of both nodes.
    fn record(&mut self, kind: CalibrationKind) -> Record {
        self.switched(kind, 0.88)
    }

    /// The same with the switch of a split one at another part of node A's time.
    fn switched(&mut self, kind: CalibrationKind, fraction: f64) -> Record {
        self.now = self.now + Nanos(30_000_000);
        let at_ns = fraction * self.state[0] * (R[0] + self.state[R_O]);
        let (through, switch) = match kind {
            CalibrationKind::First => (Through::C1, None),
            CalibrationKind::Second => (Through::C2, None),
            CalibrationKind::Split => {
                (Through::C1, Some(Switch { at_ns, on_ns: at_ns + 500.0, to: Through::C2 }))
            }
        };
        let first_ohm = if kind == CalibrationKind::Second { R[1] } else { R[0] };
        let route = Route { first_ohm, switch: switch.map(|switch| (switch, R[1])) };
        let late = route.late_ns(&self.state);
        let [a_ns, b_ns] = [0, 1].map(|node| {
            let mut normal = || -> f64 { StandardNormal.sample(&mut self.rng) };
            Some(route.crossing(&self.state, node).ns + 1500.0 * normal() + 5e-4 * late[node] * normal())
        });
        Record {
            through,
            start: self.now,
            second_ns: None,
            switch,
            a_ns,
            b_ns,
            u_switch_ns: Some(100.0),
            waited_ns: None,
            later_ns: None,
        }
    }

    fn round(&mut self, tracker: &mut Tracker) {
        for kind in CalibrationKind::ALL {
            let record = self.record(kind);
            let _ = tracker.add(&record);
        }
    }
}

fn tracked(seed: u64, rounds: usize) -> (Plant, Tracker) {
    let (mut plant, mut tracker) = (Plant::new(seed), Tracker::new(R, 2, 1.0));
    (0..rounds).for_each(|_| plant.round(&mut tracker));
    (plant, tracker)
}

#[test]
fn the_truth_lies_within_the_stated_covariance() {
    const SEEDS: u64 = 200;
    let mut pulls = [const { Vec::new() }; UNKNOWNS];
    for seed in 0..SEEDS {
        let (_, tracker) = tracked(seed, FIRST_ROUNDS + 30);
        for (index, pulls) in pulls.iter_mut().enumerate() {
            let away = tracker.state()[index] - TRUTH[index];
            pulls.push(away / tracker.covariance[index][index].sqrt());
        }
    }
    // The walk that the truth does not make leaves some room below.
    for (index, pulls) in pulls.into_iter().enumerate() {
        let rms = rms_of(&pulls);
        assert!(rms.is_in(0.65..=1.0), "state {index}: rms of pulls {rms}, seeds 0..{SEEDS}");
    }
}

#[test]
fn nothing_is_known_before_the_first_rounds() {
    let r_o_ohm = |rounds: usize| tracked(1, rounds).1.rough_r_o_ohm();
    assert_eq!(r_o_ohm(ROUGH_ROUNDS - 1), None);
    assert!(r_o_ohm(ROUGH_ROUNDS).is_some_and(|ohm| (ohm - TRUTH[R_O]).abs() < 5.0));
    assert!(!tracked(1, ROUGH_ROUNDS + FIRST_ROUNDS - 1).1.is_ready());
    assert!(tracked(1, ROUGH_ROUNDS + FIRST_ROUNDS).1.is_ready());
}

#[test]
fn a_spike_is_rejected() {
    let (mut plant, mut tracker) = tracked(2, FIRST_ROUNDS + 10);
    let before = *tracker.state();
    let mut record = plant.record(CalibrationKind::First);
    record.a_ns = record.a_ns.map(|a_ns| a_ns + 200_000.0);
    assert_eq!(tracker.add(&record), Err(Fault::LatencyOutlier));
    assert_eq!(tracker.steps(), 0);
    // Both g have gone on as they went, and that is all.
    let went = |node: usize| before[node] * (1.0 + 0.03 * before[RATE + node]);
    assert_eq!(&tracker.state()[2..], &before[2..]);
    assert!((0..2).all(|node| (tracker.state()[node] - went(node)).abs() < 1e-9));
}

#[test]
fn after_a_step_the_filter_begins_anew() {
    let (mut plant, mut tracker) = tracked(3, FIRST_ROUNDS + 10);
    plant.state[0] *= 1.02;
    plant.state[1] *= 1.02;
    plant.round(&mut tracker);
    assert_eq!((tracker.steps(), tracker.is_ready()), (1, false));
    (0..FIRST_ROUNDS + 10).for_each(|_| plant.round(&mut tracker));
    assert_eq!((tracker.steps(), tracker.is_ready()), (1, true));
    for (index, truth) in plant.state.into_iter().enumerate() {
        let u = tracker.covariance[index][index].sqrt();
        assert!(
            (tracker.state()[index] - truth).abs() < sigmas() * u,
            "{index}: {:?}, u {u}",
            tracker.state()
        );
    }
}

#[test]
fn a_steady_drift_is_followed_without_lag_and_a_faster_one_by_a_faster_walk() {
    const PLANTS: u64 = 40;
    // Relative, per round of 90 ms: 1 % and 7 % in a minute.
    let follow = |seed: u64, drift: f64| {
        let (mut plant, mut tracker) = tracked(seed, FIRST_ROUNDS);
        for _ in 0..300 {
            plant.state[0] *= 1.0 + drift;
            plant.state[1] *= 1.0 + drift;
            plant.round(&mut tracker);
        }
        assert_eq!(tracker.steps(), 0);
        let lag = (tracker.state()[0] - plant.state[0]) / tracker.covariance[0][0].sqrt();
        (tracker.speeds[1].walk(), lag)
    };
    let of = |drift: f64| -> (Vec<f64>, Vec<f64>) { (0..PLANTS).map(|seed| follow(seed, drift)).unzip() };
    let ((still, _), (_, lags), (fast, far)) = (of(0.0), of(1.5e-5), of(1e-4));
    let lag = mean_of(&lags);
    assert!(lag.is(0.0, 0.3), "lags by {lag} sigma");
    let (faster, lag) = (mean_of(&fast).over(mean_of(&still)), mean_of(&far));
    assert!(faster.is_in(2.0..=f64::INFINITY) && lag.is(0.0, 1.5), "{faster} times, lags by {lag} sigma");
}

#[test]
fn a_pin_that_walks_is_as_uncertain_as_it_is_off() {
    const PINS: u64 = 400;
    for walk in [0.05, 0.3, 1.0] {
        let is_within = |seed: &u64| {
            let (mut plant, mut tracker) = tracked(*seed, ROUGH_ROUNDS + FIRST_ROUNDS);
            for _ in 0..600 {
                let normal: f64 = StandardNormal.sample(&mut plant.rng);
                plant.state[R_O] = (plant.state[R_O] + walk * 0.09f64.sqrt() * normal).abs();
                plant.round(&mut tracker);
            }
            let u = tracker.covariance[R_O][R_O].sqrt();
            (tracker.state()[R_O] - plant.state[R_O]).abs() < 2.0 * u
        };
        let within = (0..PINS).filter(is_within).count();
        assert!(
            share_is_in(within, PINS as usize, 0.93..=0.99),
            "{walk} ohm in a second: {within} of {PINS} within 2u"
        );
    }
}

/// A dielectric that lags behind makes the end of a late split shorter; what disagrees has no part in the state.
#[test]
fn what_the_law_leaves_out_shows_where_nothing_was_fitted() {
    let left_out = |seed: u64, beside_ns: f64| {
        let (mut plant, mut tracker) = tracked(seed, 60);
        for _ in 0..64 {
            let record = plant.switched(CalibrationKind::Split, 0.98);
            let a_ns = record.a_ns.map(|a_ns| a_ns + beside_ns);
            let record = Record { a_ns, b_ns: None, ..record };
            let _ = tracker.add(&record);
            let first = plant.record(CalibrationKind::First);
            let _ = tracker.add(&first);
        }
        assert_eq!(tracker.steps(), 0);
        let beside = (tracker.state()[R_O] - TRUTH[R_O]) / tracker.offset().r_o_ohm.unwrap().1;
        assert!(beside.abs() < sigmas(), "it has brought Ro {beside} of its sigma off");
        [R[0], 4.0 * R[0], R[1]].map(|r_ohm| tracker.left_out_ohm(r_ohm))
    };
    let second_ns = TRUTH[0] * (R[1] + TRUTH[R_O]);
    for seed in 0..4 {
        let expected = BY_ELSEWHERE * R[0] * 40_000.0 / second_ns;
        let [shown, above, at_second] = left_out(seed, -40_000.0);
        assert!((shown / expected - 1.0).abs() < 0.5, "{seed}: {shown} for {expected} ohm");
        assert!(above > 1.5 * shown && at_second == shown, "{seed}: {above} above R_1, {at_second} at R_2");
    }
    // Three sigma, once for each plant.
    let false_alarms = (0..200).filter(|seed| left_out(1000 + seed, 0.0)[0] > 0.0).count();
    assert!(share_is_in(false_alarms, 200, 0.0..=0.01), "{false_alarms} of 200");
}

/// Each of the first split discharges is late, then one in two while that pays, and else one in four.
#[test]
fn late_splits_come_as_often_as_what_they_show_is_worth() {
    let (mut plant, mut tracker) = tracked(3, 60);
    let mut late = |tracker: &mut Tracker, pays: bool| {
        (0..8)
            .filter(|_| {
                let at_ns = tracker.elsewhere_ns(pays);
                let fraction = at_ns.map_or(0.88, |at_ns| at_ns / tracker.takes_ns()[0]);
                let _ = tracker.add(&plant.switched(CalibrationKind::Split, fraction));
                at_ns.is_some()
            })
            .count()
    };
    late(&mut tracker, false);
    let r_ohm = 3.0 * R[0];
    let [hidden, lowered] = tracker.hidden_elsewhere(r_ohm).unwrap();
    assert!(lowered < hidden && tracker.hidden_elsewhere(R[0]).unwrap()[0] == 0.0);
    // Half of the first ones, whether they pay or not.
    assert_eq!((late(&mut tracker, true), late(&mut tracker, false)), (4, 4));
    let [less, _] = tracker.hidden_elsewhere(r_ohm).unwrap();
    assert!(less < 0.7 * hidden, "{less} of {hidden} ohm² with twice as many");
    for _ in 0..ELSEWHERE_YOUNG / 2 {
        late(&mut tracker, false);
    }
    assert_eq!((late(&mut tracker, true), late(&mut tracker, false)), (4, 2));
}

/// All that waits long is stamped 30 us later: the state has that as its d, and only what waits shortly shows it.
#[test]
fn stamps_that_are_later_after_long_waits_show_and_are_no_step() {
    let late_ns = 30_000.0;
    let (mut plant, mut tracker) = (Plant::new(5), Tracker::new(R, 2, 1.0));
    plant.state[D] += late_ns;
    (0..FIRST_ROUNDS + ROUGH_ROUNDS).for_each(|_| plant.round(&mut tracker));
    assert!(tracker.is_ready() && tracker.awake().late_ns().is_none());
    for _ in 0..AWAKE_YOUNG {
        for kind in CalibrationKind::ALL {
            let record = plant.record(kind);
            let woken = tracker.wake_ns(kind).map(|at_ns| Record {
                switch: Some(Switch { at_ns, on_ns: at_ns, to: record.through }),
                a_ns: record.a_ns.map(|a_ns| a_ns - late_ns),
                b_ns: record.b_ns.map(|b_ns| b_ns - late_ns),
                ..record
            });
            // None after one that was rejected.
            assert_eq!(woken.is_some(), kind != CalibrationKind::Split && !tracker.is_doubted());
            let record = woken.unwrap_or(record);
            assert_eq!(record.calibration_kind(), Some(kind));
            let _ = tracker.add(&record);
        }
    }
    let shown_ns = tracker.awake().late_ns().unwrap();
    assert!((shown_ns / late_ns - 1.0).abs() < 0.1, "{shown_ns}");
    assert_eq!(tracker.steps(), 0);
    let direct = Record { through: Through::X(0), switch: None, ..plant.record(CalibrationKind::First) };
    let by_state = tracker.calibration()[0][0].by_state;
    let u_ns = tracker.asleep_ohm(R[0], &by_state, &direct);
    assert!((0.8..1.2).contains(&(u_ns / late_ns)), "{u_ns}");
}

/// What is late by a state that may be of another circuit is as usual, and tells that there was a step.
#[test]
fn while_there_is_doubt_no_split_discharge_is_elsewhere() {
    let (mut plant, mut tracker) = tracked(6, 60);
    let late = plant.switched(CalibrationKind::Split, 0.97);
    assert!(tracker.takes_elsewhere(CalibrationKind::Split, &late).is_some());
    plant.state[0] *= 2.0;
    plant.state[1] *= 2.0;
    assert_eq!(tracker.add(&plant.record(CalibrationKind::First)), Err(Fault::LatencyOutlier));
    for _ in 0..NEVER_SO_LATE {
        let split = plant.record(CalibrationKind::Split);
        assert_eq!(tracker.takes_elsewhere(CalibrationKind::Split, &split), None);
        if tracker.add(&split) == Err(Fault::CalibrationStep) {
            return;
        }
    }
    panic!("no step");
}

/// What a mean shares with the state is what it was after a discharge that has corrected nothing.
#[test]
fn a_discharge_that_corrects_nothing_leaves_what_is_shared() {
    let (mut plant, mut tracker) = tracked(4, 60);
    let v: State = std::array::from_fn(|index| 1.0 + index as f64);
    for _ in 0..64 {
        let _ = tracker.add(&plant.record(CalibrationKind::First));
        let record = plant.switched(CalibrationKind::Split, 0.98);
        let a_ns = record.a_ns.map(|a_ns| a_ns - 40_000.0);
        let _ = tracker.add(&Record { a_ns, b_ns: None, ..record });
    }
    assert_eq!(tracker.steps(), 0);
    assert_eq!(tracker.after_correction(&v), v);
    tracker.add(&plant.record(CalibrationKind::First)).unwrap();
    assert_ne!(tracker.after_correction(&v), v);
}

#[test]
fn what_nobody_has_looked_at_for_an_hour_has_walked_for_an_hour() {
    let (_, tracker) = tracked(4, FIRST_ROUNDS + 10);
    let walked = |seconds: f64| {
        let mut later = tracker.clone();
        later.advance(tracker.at() + Nanos::from_seconds(seconds));
        later.covariance[R_O][R_O] - tracker.covariance[R_O][R_O]
    };
    assert!((walked(3600.0) / walked(36.0) - 100.0).abs() < 1e-6, "{} {}", walked(3600.0), walked(36.0));
}

/// Both readings know Ro as the state does, and nothing else: of two states that are independent the variances add.
#[test]
fn a_mean_over_a_step_has_readings_that_share_nothing() {
    let (mut plant, mut tracker) = tracked(3, FIRST_ROUNDS + 10);
    let mut mean = Mean::default();
    let mut add = |tracker: &Tracker| {
        let mut v = State::default();
        v[R_O] = 1.0;
        let variance = tracker.variance(&v);
        let basis = Basis { own: 0.0, by_state: Some(v), by_switch: None };
        mean.add(Measured { value: 100.0, u: Some(variance.sqrt()) }, &basis, Some(tracker));
        variance
    };
    let before = add(&tracker);
    plant.state[0] *= 1.02;
    plant.state[1] *= 1.02;
    (0..FIRST_ROUNDS + 10).for_each(|_| plant.round(&mut tracker));
    assert_eq!((tracker.steps(), tracker.is_ready()), (1, true));
    let after = add(&tracker);
    let u = mean.result(Some(&tracker)).unwrap().u.unwrap();
    let expected = (tracker.misfit() * (before + after)).sqrt() / 2.0;
    assert!((u / expected - 1.0).abs() < 1e-9, "{u} for {expected}");
}
