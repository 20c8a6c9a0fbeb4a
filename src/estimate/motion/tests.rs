use super::*;

/// Progress at A and B, ns/ohm, and 1 sigma of a crossing, ns.
const G: [f64; 2] = [570.0, 1070.0];
const SIGMA_NS: f64 = 1500.0;
const R_O: f64 = 40.0;

/// What a full discharge tells whose crossings come at `t_ns`, weighted as eq. (11) does.
fn seen(t_ns: [f64; 2]) -> ([f64; 2], Evidence) {
    let alone = [0, 1].map(|node| t_ns[node] / G[node] - R_O);
    let weights = G.map(|g| g / (G[0] + G[1]));
    let r_ohm = weights[0] * alone[0] + weights[1] * alone[1];
    let u_ohm = SIGMA_NS * std::f64::consts::SQRT_2 / (G[0] + G[1]);
    let u_difference = SIGMA_NS * (1.0 / G[0]).hypot(1.0 / G[1]);
    ([r_ohm, u_ohm], Evidence::over_two(t_ns, weights, alone, Some(u_difference)))
}

/// The crossings of a discharge from `start_s` on through a sensor that changes, in steps of 1 us.
fn crossings(start_s: f64, r_ohm: &dyn Fn(f64) -> f64) -> [f64; 2] {
    let (mut progress, mut t_ns, mut found) = (0.0, 0.0, [0.0; 2]);
    for node in 0..2 {
        while progress < G[node] {
            progress += 1000.0 / (r_ohm(start_s + 1e-9 * (t_ns + 500.0)) + R_O);
            t_ns += 1000.0;
        }
        found[node] = t_ns - (progress - G[node]) * (r_ohm(start_s + 1e-9 * t_ns) + R_O);
    }
    found
}

/// The error of a discharge, and what it was judged.
type Judged = (f64, Result<Moved, Fault>);

const AT_REST: Result<Moved, Fault> = Ok(Moved { u_ohm: 0.0, is_moving: false });

/// Judges discharges every 20 ms from `from` on.
fn judge(motion: &mut Motion, from: usize, count: usize, r_ohm: &dyn Fn(f64) -> f64) -> Vec<Judged> {
    (from..from + count)
        .map(|index| {
            let start = Nanos(index as i64 * 20_000_000);
            let (estimate, evidence) = seen(crossings(start.as_seconds(), r_ohm));
            let error = estimate[0] - r_ohm(start.as_seconds() + 1e-9 * evidence.at_ns);
            (error, motion.judge(start, estimate, Some(R_O), &evidence, 0.0))
        })
        .collect()
}

#[test]
fn the_instant_of_a_steady_change_is_right_to_the_first_order() {
    // 10 % in a second: 0.05 % in a discharge, of which the second order leaves a millionth part.
    let judged = judge(&mut Motion::default(), 0, 20, &|t| 1.0 / (1.0 / 5000.0 * (1.0 + 0.1 * t)));
    assert!(judged.iter().all(|(error, result)| error.abs() < 0.02 && result.is_ok()), "{judged:?}");
}

#[test]
fn a_sensor_at_rest_adds_nothing_and_an_oscillation_its_second_order() {
    let rest = judge(&mut Motion::default(), 0, 20, &|_| 5000.0);
    assert!(rest.iter().all(|(_, result)| *result == AT_REST), "{rest:?}");
    let mut motion = Motion::default();
    let sine = |t: f64| 5000.0 * (1.0 + 0.2 * (std::f64::consts::TAU * 9.3 * t).sin());
    judge(&mut motion, 0, 20, &sine);
    let judged = judge(&mut motion, 20, 200, &sine);
    let rms = |of: &dyn Fn(&Judged) -> f64| {
        (judged.iter().map(|one| of(one).powi(2)).sum::<f64>() / judged.len() as f64).sqrt()
    };
    let (error, stated) = (rms(&|one| one.0), rms(&|one| one.1.unwrap().u_ohm));
    assert!(error > 1.0 && (0.8..1.5).contains(&(stated / error)), "{error} {stated}");
}

#[test]
fn one_late_stamp_is_an_outlier_and_forgotten() {
    for late_ns in [[60_000.0, 0.0], [0.0, 60_000.0], [3_000_000.0, 600_000.0]] {
        let mut motion = Motion::default();
        judge(&mut motion, 0, 10, &|_| 5000.0);
        let mut t_ns = crossings(0.0, &|_| 5000.0);
        (0..2).for_each(|node| t_ns[node] += late_ns[node]);
        let (estimate, evidence) = seen(t_ns);
        let start = Nanos(200_000_000);
        assert_eq!(
            motion.judge(start, estimate, Some(R_O), &evidence, 0.0),
            Err(Fault::LatencyOutlier),
            "{late_ns:?}"
        );
        let after = judge(&mut motion, 11, 3, &|_| 5000.0);
        assert!(after.iter().all(|(_, result)| *result == AT_REST), "{after:?}");
    }
}

#[test]
fn a_step_inside_of_a_discharge_is_a_number_that_says_so_and_over_at_once() {
    for after in [1000.0, 4000.0, 4800.0] {
        let mut motion = Motion::default();
        let step = |t: f64| if t < 0.202 { 5000.0 } else { after };
        judge(&mut motion, 0, 10, &step);
        let judged = judge(&mut motion, 10, 10, &step);
        let (error, moved) = (judged[0].0, judged[0].1);
        match moved {
            Ok(moved) => {
                assert!(moved.is_moving && error.abs() < 2.0 * moved.u_ohm, "to {after}: {judged:?}")
            }
            // As large as the value.
            Err(fault) => assert!(fault == Fault::Unsettled && after < 2000.0, "to {after}: {judged:?}"),
        }
        let settled = judged[1..].iter().filter(|(error, result)| error.abs() < 1.0 && result.is_ok());
        assert!(settled.count() >= 8, "to {after}: {judged:?}");
    }
}

/// Whether it says that it moves, and by how much it may be off, ohm.
fn told(judged: &Result<Moved, Fault>) -> (bool, f64) {
    judged.map_or((true, f64::INFINITY), |moved| (moved.is_moving, moved.u_ohm))
}

#[test]
fn what_creeps_is_at_rest_and_a_late_stamp_in_it_is_not() {
    let mut motion = Motion::default();
    let creep: Vec<f64> = (0..30).map(|index| 5000.0 + 3.0 * f64::from(index)).collect();
    let judged = judge_alone(&mut motion, 0, &creep);
    assert!(judged.iter().all(|one| !told(one).0), "{judged:?}");
    // Back by less than the noise of two readings, and 50 ohm beside the way that it went.
    let mut motion = Motion::default();
    let fall: Vec<f64> = (0..12).map(|index| 5000.0 - 40.0 * f64::from(index)).collect();
    judge_alone(&mut motion, 0, &fall);
    let late = judge_alone(&mut motion, 12, &[fall[11] + 10.0]);
    assert!(told(&late[0]).0 && told(&late[0]).1 > 25.0, "{late:?}");
}

/// A hand that turns round: what follows its bend is a number, what is above it may be late, what is below cannot be.
#[test]
fn a_late_stamp_is_told_on_a_way_that_bends() {
    let way: Vec<f64> = (0..8).map(|index| 5000.0 * (0.3 * (0.35 * f64::from(index)).sin()).exp()).collect();
    for (beside, is_told) in [(0.0, false), (250.0, true), (-250.0, false)] {
        let mut motion = Motion::default();
        judge_alone(&mut motion, 0, &way[..7]);
        let u_ohm = judge_alone(&mut motion, 7, &[way[7] + beside])[0].unwrap().u_ohm;
        assert_eq!(2.0 * u_ohm > 250.0, is_told, "{beside}: {u_ohm}");
    }
}

/// The last three tell where it would be now with 4.4 times their noise, all of them with 1.9 times that.
#[test]
fn a_late_stamp_of_ten_sigma_is_told_where_the_way_is_long() {
    let noise = [1.5, -2.0, 0.5, 1.0, -1.5, 2.0];
    for (speed, bend) in [(0.0, 0.0), (-30.0, 0.0), (25.0, -4.0), (10.0, 1.0)] {
        let way = |index: f64| 5000.0 + speed * index + bend * index * index;
        let before = [0, 1, 2, 3, 4, 5].map(|index| way(f64::from(index)) + noise[index as usize]);
        for (beside, is_told) in [(0.0, false), (22.0, true)] {
            let mut motion = Motion::default();
            judge_alone(&mut motion, 0, &before);
            let u_ohm = told(&judge_alone(&mut motion, 6, &[way(6.0) + beside])[0]).1;
            assert_eq!(2.0 * u_ohm > 20.0, is_told, "{speed}, {bend}, {beside}: {u_ohm}");
        }
    }
}

#[test]
fn a_late_stamp_that_is_over_does_not_hide_the_next() {
    let mut motion = Motion::default();
    let judged = judge_alone(&mut motion, 0, &[5000.0, 5001.0, 4999.0, 5000.0, 5060.0, 5001.0, 5080.0]);
    let moving: Vec<bool> = judged.iter().map(|one| told(one).0).collect();
    assert_eq!(moving, [false, false, false, false, true, true, true], "{judged:?}");
}

#[test]
fn a_way_is_not_believed_for_longer_than_it_was_seen() {
    let mut motion = Motion::default();
    let rise: Vec<f64> = (0..6).map(|index| 5000.0 * (0.2 * f64::from(index)).exp()).collect();
    judge_alone(&mut motion, 0, &rise);
    // A second later: on its way it would be some million ohm by now.
    let judged = judge_alone(&mut motion, 56, &[rise[5]]);
    assert!(judged[0].is_ok(), "{judged:?}");
}

/// Judges full discharges every 20 ms that tell of one stretch alone.
fn judge_alone(motion: &mut Motion, from: usize, r_ohm: &[f64]) -> Vec<Result<Moved, Fault>> {
    let judge = |(index, r_ohm): (usize, &f64)| {
        motion.judge(
            Nanos((from + index) as i64 * 20_000_000),
            [*r_ohm, 2.0],
            Some(R_O),
            &Evidence::over(5e6),
            0.0,
        )
    };
    r_ohm.iter().enumerate().map(judge).collect()
}

#[test]
fn one_stretch_alone_that_is_far_off_costs_one_reading_if_it_is_over_at_once() {
    let mut motion = Motion::default();
    judge_alone(&mut motion, 0, &[5000.0; 10]);
    // Late, once in three and then twice in a row, and at rest again.
    let judged = judge_alone(
        &mut motion,
        10,
        &[5300.0, 5000.0, 5003.0, 9000.0, 4998.0, 5000.0, 5200.0, 6100.0, 5000.0, 5000.0],
    );
    let at_rest: Vec<bool> = judged
        .iter()
        .map(|result| result.is_ok_and(|moved| !moved.is_moving && moved.u_ohm < 0.01))
        .collect();
    assert_eq!(at_rest, [false, true, true, false, true, true, false, false, true, true], "{judged:?}");
    // The mean conductance of 5300 ohm may be that of 5000 and of more, half of the time each.
    let most = 1.0 / (2.0 / (5300.0 + R_O) - 1.0 / (5000.0 + R_O)) - R_O - 5300.0;
    let moved = judged[0].unwrap();
    assert!(moved.is_moving && (moved.u_ohm * 3f64.sqrt() / most - 1.0).abs() < 1e-3, "{judged:?}");
}

/// A finger that lets go: of the last readings only the way was seen, and nothing before them is remembered.
#[test]
fn what_follows_readings_that_were_all_on_their_way_is_not_at_rest() {
    for (next, fault) in [(2e6, Some(Fault::Unsettled)), (30e3, None)] {
        let mut motion = Motion::default();
        for index in 0..MOTION_POINTS {
            let (at, r_ohm) = (Nanos(index as i64 * 20_000_000), 5000.0 * 1.5f64.powi(index as i32));
            motion.push(Point { at, z: r_ohm.ln(), u: 1e-4, slope: Some([20.0, 0.1]), trust: Trust::Mixed });
        }
        let judged = judge_alone(&mut motion, MOTION_POINTS, &[next, next, next]);
        assert_eq!(judged[0].err(), fault, "{judged:?}");
        assert!(told(&judged[0]).0 && told(&judged[0]).1 > 0.1 * next, "{judged:?}");
        assert!(judged[2].is_ok(), "{judged:?}");
    }
}

/// A reading that is less certain than the others hides no late stamp of the next one.
#[test]
fn a_late_stamp_after_an_uncertain_reading_is_still_sudden() {
    let mut motion = Motion::default();
    let mut take = |index: i64, r_ohm: f64, u_ohm: f64| {
        motion
            .judge(Nanos(index * 2_000_000), [r_ohm, u_ohm], Some(R_O), &Evidence::over(300e3), 0.0)
            .unwrap()
    };
    (0..6).for_each(|index| assert!(!take(index, 1000.0, 0.8).is_moving));
    assert!(!take(6, 1001.0, 2.6).is_moving);
    let late = take(7, 1008.3, 0.8);
    assert!(late.is_moving && late.u_ohm > 2.0, "{late:?}");
}

/// Four sigma of noise now and then are no motion that would explain a late stamp.
#[test]
fn a_spike_of_noise_is_no_speed() {
    let mut motion = Motion::default();
    let mut take = |index: i64, r_ohm: f64| {
        motion.judge(Nanos(index * 1_100_000), [r_ohm, 5.0], Some(R_O), &Evidence::over(770e3), 0.0).unwrap()
    };
    for (index, r_ohm) in [5008.0, 4997.0, 5004.0, 5007.0, 4979.0, 5006.0].into_iter().enumerate() {
        take(index as i64, r_ohm);
    }
    let late = take(6, 5075.0);
    assert!(late.is_moving && late.u_ohm > 30.0, "{late:?}");
}

#[test]
fn the_first_reading_that_does_not_settle_does_so_still() {
    let mut motion = Motion::default();
    assert_eq!(
        [false, true, false, false].map(|is_settling| motion.settles(is_settling)),
        [true, true, true, false]
    );
}

#[test]
fn a_step_within_one_stretch_alone_is_in_two_readings_there_and_two_back() {
    let mut motion = Motion::default();
    judge_alone(&mut motion, 0, &[5000.0; 10]);
    let mut before = 5000.0;
    for (from, mixed, after) in [(10, 5500.0, 6000.0), (20, 5300.0, 5000.0)] {
        let judged =
            judge_alone(&mut motion, from, &[mixed, after, after, after, after, after, after, after]);
        let [first, second] = [judged[0].unwrap(), judged[1].unwrap()];
        assert!(first.is_moving && second.is_moving, "to {after}: {judged:?}");
        // Whichever of the two it had in the middle.
        for truth in [before, after] {
            assert!(f64::abs(mixed - truth) < 2.0 * first.u_ohm, "to {after}: {judged:?}");
        }
        before = after;
        assert!(
            judged[2..].iter().all(|result| matches!(result, Ok(moved) if moved.u_ohm < 5.0)),
            "{judged:?}"
        );
    }
    // Whatever comes after an open sensor is no return to it.
    let mut motion = Motion::default();
    motion.is_open(Nanos(0), 1e6);
    assert_eq!(judge_alone(&mut motion, 1, &[5000.0, 200e3]), [Err(Fault::Unsettled); 2]);
}

#[test]
fn two_late_stamps_alike_are_no_change_where_one_stretch_is_all_that_there_is() {
    for (risen, is_over) in [(5040.0, true), (5040.0, false), (5400.0, true), (5400.0, false)] {
        let mut motion = Motion::default();
        judge_alone(&mut motion, 0, &[5000.0; 10]);
        let after = if is_over { 5000.0 } else { risen };
        let judged = judge_alone(&mut motion, 10, &[risen, risen + 2.0, after, after, after]);
        for one in &judged[..2] {
            let (is_moving, u_ohm) = told(one);
            assert!(is_moving && risen - 5000.0 < 2.0 * u_ohm, "{risen} {is_over}: {judged:?}");
        }
        // A third one has proven it.
        assert!(is_over || !told(&judged[2]).0, "{risen}: {judged:?}");
        assert!(!told(&judged[4]).0, "{risen} {is_over}: {judged:?}");
    }
}

/// Judges readings (value, 1 sigma, ohm), each of one stretch, one every 2 ms.
fn judge_noisy(r_o_ohm: Option<f64>, readings: &[[f64; 2]]) -> Vec<Result<Moved, Fault>> {
    let mut motion = Motion::default();
    let one = |(index, reading): (usize, &[f64; 2])| {
        motion.judge(Nanos(2_000_000 * index as i64), *reading, r_o_ohm, &Evidence::over(50_000.0), 0.0)
    };
    readings.iter().enumerate().map(one).collect()
}

#[test]
fn a_late_stamp_after_what_was_no_more_than_noise_is_no_number() {
    let judged = judge_noisy(Some(R_O), &[12.0, -30.0, 4.0, 18.0, 2000.0].map(|r_ohm| [r_ohm, 60.0]));
    assert!(judged[..4].iter().all(Result::is_ok), "{judged:?}");
    assert_eq!(judged[4], Err(Fault::Unsettled));
    // One that has really come is one from the third reading on.
    let judged = judge_noisy(None, &[[[-60.0, 2.0]; 10], [[1000.0, 2.0]; 10]].concat());
    assert!(judged[..10].iter().all(Result::is_ok), "{judged:?}");
    assert!(judged[12..].iter().all(|judged| *judged == AT_REST), "{judged:?}");
    // Of what is hardly more than noise, what counts is how far it went in ohm.
    let judged = judge_noisy(None, &[41.0, 52.0, 38.0, 45.0, 52.0, 260.0].map(|r_ohm| [r_ohm, 20.0]));
    assert!(judged[..5].iter().all(Result::is_ok) && told(&judged[5]).0, "{judged:?}");
}

/// What was hardly known before a change is no place to come back to, which would forget the change again and again.
#[test]
fn what_is_near_both_is_no_return() {
    let known = |r_ohm: f64, count| vec![[r_ohm, 3.7]; count];
    let judged = judge_noisy(None, &[known(1000.0, 3), vec![[9800.0, 3400.0]], known(7700.0, 10)].concat());
    assert!(judged[10..].iter().all(|judged| !told(judged).0), "{judged:?}");
}

#[test]
fn what_contradicts_itself_in_the_same_way_again_and_again_is_no_change() {
    let mut motion = Motion::default();
    for index in 0..20 {
        let mut t_ns = crossings(0.0, &|_| 5000.0);
        t_ns[1] += 20_000.0;
        let (estimate, evidence) = seen(t_ns);
        let judged = motion.judge(Nanos(index * 20_000_000), estimate, Some(R_O), &evidence, 0.0);
        assert_eq!(judged, Err(Fault::LatencyOutlier));
    }
}

#[test]
fn the_first_number_after_an_open_sensor_has_only_what_its_stretches_tell() {
    let mut motion = Motion::default();
    motion.is_open(Nanos(0), 1e6);
    let judged = judge(&mut motion, 1, 1, &|_| 5000.0);
    // Its stretches agree within their noise; more is not known of it.
    assert!(matches!(judged[0].1, Ok(moved) if (1.0..20.0).contains(&moved.u_ohm)), "{judged:?}");
    let mut motion = Motion::default();
    motion.is_open(Nanos(0), 1e6);
    let start = Nanos(20_000_000);
    let alone = motion.judge(start, [5000.0, 2.0], Some(R_O), &Evidence::over(5e6), 0.0);
    assert_eq!(alone, Err(Fault::Unsettled), "one stretch alone tells nothing of a change from open");
}

#[test]
fn nothing_makes_it_panic_or_answer_nan() {
    let values = [0.0, -40.0, -1e9, 1.0, 1e12, f64::MAX];
    for r_ohm in values {
        for end in [0.0, 1.0, 1e9] {
            let mut motion = Motion::default();
            for index in 0..8 {
                let at = Nanos(index / 2 * 1000);
                let evidence =
                    Evidence::over_two([end, 2.0 * end], [0.5, 0.5], [r_ohm, 2.0 * r_ohm], Some(1.0));
                if let Ok(moved) = motion.judge(at, [r_ohm, 1.0], Some(R_O), &evidence, 0.0) {
                    assert!(moved.u_ohm.is_finite() && moved.u_ohm >= 0.0, "{r_ohm} {end} {moved:?}");
                }
            }
            motion.forget();
            assert_eq!(motion.last_ohm(None), None);
        }
    }
}

/// At 100 ohm those 40 of a pin are a third of what there is.
#[test]
fn a_sensor_does_not_move_by_what_becomes_known_of_the_pins() {
    for r_ohm in [10.0, 100.0, 1000.0] {
        for late in [0.0, 0.05] {
            let mut motion = Motion::default();
            for index in 0..30 {
                let known = if index % 10 < 5 { None } else { Some(R_O) };
                let (estimate, evidence) = seen(G.map(|g| g * (r_ohm + R_O)));
                let judged = motion.judge(Nanos(index * 20_000_000), estimate, known, &evidence, late);
                assert_eq!(judged.map(|moved| moved.is_moving), Ok(false), "{r_ohm} ohm, reading {index}");
            }
        }
    }
}

/// Of direct readings the next one is inferred, and late by what those cannot tell: it says so, and the second one need not.
#[test]
fn the_first_that_is_known_much_better_may_be_late() {
    for late_ohm in [0.0, 4.0] {
        let mut readings: Vec<[f64; 2]> =
            (0..5).map(|index| [1000.0 + f64::from(index % 3) - 1.0, 2.5]).collect();
        readings.push([1000.0 + late_ohm, 0.3]);
        readings.extend([[1000.1, 0.3]; 4]);
        let judged = judge_noisy(Some(R_O), &readings);
        let u_ohm = |index: usize| judged[index].as_ref().unwrap().u_ohm;
        assert!((1.0..4.0).contains(&u_ohm(5)) && late_ohm < 2.5 * u_ohm(5), "{judged:?}");
        assert!(!judged[5].as_ref().unwrap().is_moving && u_ohm(9) < 0.1, "{judged:?}");
    }
}
