//! Made-up crossings whose noise is known.

use super::*;
use crate::chance::{Figure, mean_of, share_is_in};
use crate::estimate::limits::{NEVER_SO_LATE, NOISE_WARM_UP, OFTEN_LATE};
use rand::RngExt;
use rand_distr::{Distribution, Exp1, StandardNormal};

const LATENCY: f64 = 1500.0;
const TRIGGER: f64 = 4e-4;

/// Times with shared start jitter, latency jitter and trigger noise, a slow drift and some spikes.
fn learned(seed: u64, count: usize, spikes: bool) -> Noise {
    let mut rng = crate::seed::rng(seed);
    let mut normal = move || -> f64 { StandardNormal.sample(&mut rng) };
    let mut noise = Noise::new(2, 1.0);
    for round in 0..count {
        let drift = 1.0 + 1e-6 * round as f64;
        let mut crossings = |times: [f64; 2]| {
            let start = 500.0 * normal();
            let spike = if spikes && round % 37 == 5 { 40_000.0 } else { 0.0 };
            times.map(|t| t * drift + start + LATENCY * normal() + TRIGGER * t * normal() + spike)
        };
        let (c1, c2) = (crossings([1.1e6, 1.3e6]), crossings([6.2e6, 7.4e6]));
        let _ = noise.add(CalibrationKind::First, c1.map(Some), [0.0; 2]);
        let _ = noise.add(CalibrationKind::Second, c2.map(Some), [0.0; 2]);
    }
    noise
}

/// The mean of something of what each has learned.
fn of_each(noises: &[Noise], times: [f64; 2], of: impl Fn(&Covariance) -> f64) -> Figure {
    mean_of(&noises.iter().map(|noise| of(&noise.covariance(times).unwrap())).collect::<Vec<_>>())
}

#[test]
fn both_parts_of_the_noise_are_found() {
    for spikes in [false, true] {
        let noises: Vec<Noise> = (0..20).map(|seed| learned(seed, 4000, spikes)).collect();
        for t in [1e5, 1.2e6, 7e6] {
            let truth = 500f64.powi(2) + LATENCY.powi(2) + (TRIGGER * t).powi(2);
            for found in [of_each(&noises, [t, t], |one| one.aa), of_each(&noises, [t, t], |one| one.bb)] {
                let found = found.times(1.0 / truth);
                assert!(found.is_in(0.9..=1.1), "T {t}: {found} of the variance, {spikes}");
            }
            let shared = of_each(&noises, [t, t], |one| one.ab).times(1.0 / 500f64.powi(2));
            assert!(shared.is_in(0.5..=1.5), "{shared}");
        }
    }
}

#[test]
fn nothing_is_said_before_the_warm_up() {
    assert_eq!(learned(2, NOISE_WARM_UP - 1, false).covariance([1e6, 1e6]), None);
    assert!(learned(2, NOISE_WARM_UP, false).covariance([1e6, 1e6]).is_some());
}

#[test]
fn a_spike_is_an_outlier_and_a_step_is_followed() {
    let mut noise = learned(3, 100, false);
    let away = [1.1e6 + 60_000.0, 1.3e6 + 60_000.0];
    assert_eq!(noise.add(CalibrationKind::First, away.map(Some), [0.0; 2]), Err(Fault::LatencyOutlier));
    assert_eq!(
        noise.add(CalibrationKind::First, [1.1e6 * 1.0001, 1.3e6 * 1.0001].map(Some), [0.0; 2]),
        Ok(())
    );
    assert_eq!(noise.add(CalibrationKind::First, away.map(Some), [0.0; 2]), Err(Fault::LatencyOutlier));
    assert_eq!(noise.add(CalibrationKind::First, away.map(Some), [0.0; 2]), Err(Fault::LatencyOutlier));
    assert_eq!(noise.add(CalibrationKind::First, away.map(Some), [0.0; 2]), Ok(()));
    assert_eq!(noise.add(CalibrationKind::First, away.map(Some), [0.0; 2]), Ok(()));
}

/// Crossings that never scatter.
fn silent(resolution_ns: f64) -> Noise {
    let mut noise = Noise::new(2, resolution_ns);
    for _ in 0..50 {
        let _ = noise.add(CalibrationKind::First, [1e6, 1.2e6].map(Some), [0.0; 2]);
        let _ = noise.add(CalibrationKind::Second, [6e6, 7e6].map(Some), [0.0; 2]);
    }
    noise
}

#[test]
fn a_silent_circuit_still_has_the_rounding_of_stamps() {
    let found = silent(1000.0).covariance([1e5, 2e5]).unwrap();
    assert!((found.aa - 1e6 / 12.0).abs() < 1e-6 && found.ab == 0.0, "{found:?}");
}

#[test]
fn a_silent_circuit_still_remembers_the_discharge_before() {
    let found = silent(1.0).covariance([6e6, 7e6]).unwrap();
    let least = [6e6, 7e6].map(|ns| (REMEMBERED * ns).powi(2));
    assert!(
        (found.aa / least[0] - 1.0).abs() < 1e-9 && (found.bb / least[1] - 1.0).abs() < 1e-9,
        "{found:?}"
    );
}

const C1: [f64; 2] = [1.1e6, 1.3e6];
const C2: [f64; 2] = [6.2e6, 7.4e6];

/// Each crossing late by itself by `own_ns` and `own` of its time, both together by `start_ns` and, as after a charge to another
/// voltage, by `charge` of their times.
fn with_shared(seed: u64, count: usize, own_ns: f64, own: f64, start_ns: f64, charge: f64) -> Noise {
    let mut rng = crate::seed::rng(seed);
    let mut normal = move || -> f64 { StandardNormal.sample(&mut rng) };
    let mut noise = Noise::new(2, 1.0);
    let mut crossings = |times: [f64; 2]| {
        let (start, charge) = (start_ns * normal(), charge * normal());
        times.map(|t| t * (1.0 + charge + own * normal()) + start + own_ns * normal())
    };
    for _ in 0..count {
        let _ = noise.add(CalibrationKind::First, crossings(C1).map(Some), [0.0; 2]);
        let _ = noise.add(CalibrationKind::Second, crossings(C2).map(Some), [0.0; 2]);
    }
    noise
}

#[test]
fn what_a_charge_does_to_both_crossings_goes_by_their_times() {
    let (own_ns, own, start_ns, charge) = (300.0, 1e-4, 500.0, 5e-4);
    // One of them is off by a tenth now and then, where it extrapolates.
    let noises: Vec<Noise> =
        (0..20).map(|seed| with_shared(seed, 4000, own_ns, own, start_ns, charge)).collect();
    for [a_ns, b_ns] in [[1e5, 1.2e5], C1, [3e6, 3.6e6], C2, [20e6, 24e6]] {
        let mean = |of: fn(&Covariance) -> f64| of_each(&noises, [a_ns, b_ns], of);
        let shared = |one: f64, other: f64| start_ns.powi(2) + charge.powi(2) * one * other;
        let alone = |t: f64| own_ns.powi(2) + (own * t).powi(2);
        let truth = Covariance {
            aa: shared(a_ns, a_ns) + alone(a_ns),
            bb: shared(b_ns, b_ns) + alone(b_ns),
            ab: shared(a_ns, b_ns),
        };
        for (found, truth) in
            [(mean(|one| one.aa), truth.aa), (mean(|one| one.bb), truth.bb), (mean(|one| one.ab), truth.ab)]
        {
            let found = found.times(1.0 / truth);
            assert!(found.is_in(0.9..=1.1), "{a_ns}: {found} of {truth}");
        }
        // What both share is no noise of their ratio, and as much as is left is not made light of.
        let of_ratio = |one: &Covariance| one.of(1.0 / a_ns, -1.0 / b_ns);
        let found = of_each(&noises, [a_ns, b_ns], of_ratio).times(1.0 / of_ratio(&truth));
        assert!(found.is_in(1.0..=2.0), "{a_ns}: {found} of that of the ratio");
    }
}

/// However late stamps are, and however many of them are near enough to be taken for noise, that they are often so is not forgotten.
#[test]
fn stamps_that_are_often_late_stay_so() {
    let forgets = |seed: &u64| {
        let mut rng = crate::seed::rng(*seed);
        let mut noise = Noise::new(2, 1.0);
        let mut late = move || {
            let jitter: f64 = rng.sample::<f64, _>(StandardNormal);
            let tail: f64 = if rng.random_bool(0.3) { 1e6 * rng.sample::<f64, _>(Exp1) } else { 0.0 };
            10_000.0 * jitter + tail
        };
        for _ in 0..100 {
            let _ = noise.add(CalibrationKind::First, C1.map(|ns| Some(ns + late())), [0.0; 2]);
            let _ = noise.add(CalibrationKind::Second, C2.map(|ns| Some(ns + late())), [0.0; 2]);
        }
        noise.late_share() < OFTEN_LATE
    };
    assert_eq!((0..400).filter(forgets).count(), 0);
}

/// One node, a share of whose stamps is late by 100 us on average.
fn with_late(seed: u64, jitter_ns: f64, share: f64) -> Noise {
    let mut rng = crate::seed::rng(seed);
    let mut noise = Noise::new(1, 1.0);
    for index in 0..400 {
        let tail: f64 = if rng.random_bool(share) { 1e5 * rng.sample::<f64, _>(Exp1) } else { 0.0 };
        let late_ns = jitter_ns * rng.sample::<f64, _>(StandardNormal) + tail;
        let (kind, ns) = [(CalibrationKind::First, C1[0]), (CalibrationKind::Second, C2[0])][index % 2];
        let _ = noise.add(kind, [Some(ns + late_ns), None], [0.0; 2]);
    }
    noise
}

/// What is taken for noise of R_2 alone would be in proportion to the time, and nothing left for what every stamp has.
#[test]
fn late_stamps_do_not_make_short_discharges_exact() {
    let is_exact = |seed: &u64| {
        let found = with_late(*seed, LATENCY, 0.2).covariance([Some(1e5), None]);
        found.unwrap().aa < (0.6 * LATENCY).powi(2)
    };
    // It was one in five.
    let exact = (0..400).filter(is_exact).count();
    assert!(share_is_in(exact, 400, 0.0..=0.01), "{exact}");
}

#[test]
fn a_late_stamp_looks_like_any_other_where_they_are_often_late_or_noise_is_as_great() {
    let hides = |seed: &u64, jitter_ns, late| with_late(*seed, jitter_ns, late).hides_late();
    let hidden = |jitter_ns, late| (0..50).filter(|seed| hides(seed, jitter_ns, late)).count();
    assert_eq!([hidden(1_500.0, 0.0), hidden(1_500.0, 0.02), hidden(7_000.0, 0.0)], [0; 3]);
    assert_eq!([hidden(30_000.0, 0.0), hidden(1_500.0, 0.5)], [50; 2]);
}

/// Three in a row are a step where one in a hundred is late; where one in five is, they happen every hundred discharges or so.
#[test]
fn a_step_is_more_in_a_row_than_late_stamps_are() {
    assert!(!is_step(2, 0.0) && is_step(3, 0.01) && !is_step(3, 0.2));
    for late in [0.05, 0.1, 0.2, 0.3, 0.5] {
        let first = (1..100).find(|&in_row| is_step(in_row, late)).unwrap();
        let by_chance = late.powi(first as i32);
        assert!(
            first == NEVER_SO_LATE || by_chance < 1e-5 && by_chance > 1e-5 * late * late,
            "{late}: {first}"
        );
    }
}

/// That one is as late as the one before happens by chance, too.
#[test]
fn late_stamps_that_are_alike_are_no_step_where_many_are_late() {
    // After so many that were far off, and each later than the one before by so much.
    let taken_after = |far: usize, each_ns: f64| {
        let mut noise = with_late(0, LATENCY, 0.0);
        (0..far).for_each(|_| noise.tell_far(CalibrationKind::Second, true));
        let late_ns = |index: usize| 300_000.0 + each_ns * index as f64;
        let mut add =
            |index| noise.add(CalibrationKind::Second, [Some(C2[0] + late_ns(index)), None], [0.0; 2]);
        (1..100).find(|&index| add(index).is_ok()).unwrap()
    };
    assert_eq!([0, 16].map(|far| taken_after(far, 0.0)), [3, 4]);
    assert_eq!([0, 16].map(|far| taken_after(far, 100_000.0)), [3, 8]);
}

#[test]
fn nothing_in_proportion_is_shared_by_chance() {
    let claims = |charge: f64| {
        let claims = |seed: &u64| {
            let noise = with_shared(*seed, 60, 1500.0, 4e-4, 500.0, charge);
            noise.covariance([20e6, 24e6]).unwrap().ab > 10.0 * 500f64.powi(2)
        };
        (0..300).filter(claims).count()
    };
    assert!(share_is_in(claims(0.0), 300, 0.0..=0.01), "{}", claims(0.0));
    // With as much again that is shared, the same discharges tell.
    assert!(share_is_in(claims(8e-4), 300, 0.8..=1.0), "{}", claims(8e-4));
}

#[test]
fn crossings_that_share_everything_are_still_two() {
    for count in [20, 200, 2000] {
        let found = with_shared(5, count, 0.0, 0.0, 0.0, 1e-3).covariance(C2).unwrap();
        let left = found.of(1.0 / C2[0], -1.0 / C2[1]) / (found.aa / C2[0].powi(2));
        let freedom = count as f64 * 2.0 / 3.0;
        // 2 (1 - correlation), where that is believed up to 1 - 1/sqrt(freedom).
        assert!((1.5..3.0).contains(&(left * freedom.sqrt())), "{count}: {left}");
    }
}
