//! What a tracked calibration must show, on simulated boards in virtual time. Every seed is fixed.

use crate::common::chance::{Figure, WITHIN_2U, share_is_in};
use crate::common::{Bench, Errors, read, settle, spread_of};
use cermd::pins::sim::Kind;
use cermd::pins::sim::scene::{DelayScene, DriftScene};
use cermd::reading::{Fault, Method, Status};
use cermd::units::{Farad, Seconds, Volt};
use std::fmt::Write;

const INSTRUMENTS: u64 = 40;
const READINGS: usize = 150;
/// Cycles before the first reading counts.
const BEFORE: usize = 600;

/// More readings are within 2u: a walk of g that is never assumed slower than a drift makes u greater than the errors on a
/// board that does not drift, by up to 8 %.
const SLOWEST_WALK: f64 = 0.012;
/// By how much more are within 2u below Rc1 in the first seconds: how much switches scatter is a prior by the length of calls,
/// twice what they do on this board, until split discharges have shown it.
const UNSEEN_SCATTER: f64 = 0.03;

/// What is promised of readings of `r_ohm` in the first seconds.
fn promised(r_ohm: f64) -> std::ops::RangeInclusive<f64> {
    WITHIN_2U..=WITHIN_2U + if r_ohm < 500.0 { UNSEEN_SCATTER } else { SLOWEST_WALK }
}

/// 1-sigma error times the root of the time that a reading takes, charging included, ohm sqrt(s); and the mean
/// Cramer-Rao bound of a reading, as a sigma (0 where there is none), and the sigma.
fn figure(method: Method, r_ohm: f64, measure: &str) -> (Figure, f64, Figure) {
    let (mut all, mut bounds, mut seconds) = (Errors::default(), Vec::new(), 0.0);
    for seed in 0..INSTRUMENTS {
        all.next_board();
        let mut instrument = Bench::new("pi4", method, r_ohm, seed, measure).instrument();
        settle(&mut instrument);
        read(&mut instrument, BEFORE, |_| {});
        let mut readings = 0;
        let mut last = None;
        while readings < READINGS {
            let mut ok = false;
            instrument
                .step(&mut |message| match message {
                    cermd::instrument::Message::Reading(reading) => {
                        readings += 1;
                        seconds += reading.duration.as_seconds();
                        all.add(&reading, r_ohm);
                        ok = matches!(reading.status, Status::Ok { .. });
                    }
                    cermd::instrument::Message::Discharge { record, .. } => last = Some(record),
                })
                .unwrap();
            let record = last.take().filter(|record| ok && record.through.channel().is_some());
            if let Some(record) = record {
                let estimator = instrument.cycle().estimator();
                let predicted = estimator.predict_tracked(
                    r_ohm,
                    record.switch,
                    record.u_switch_ns.unwrap_or(0.0),
                    if record.b_ns.is_some() { cermd::circuit::Node::B } else { cermd::circuit::Node::A },
                );
                bounds.extend(predicted.map(|predicted| predicted.bound));
            }
        }
    }
    let per_reading = seconds / (INSTRUMENTS as usize * READINGS) as f64;
    let sigma = all.together(spread_of);
    let bound = (bounds.iter().sum::<f64>() / bounds.len().max(1) as f64).sqrt();
    (sigma.times(per_reading.sqrt()), bound, sigma)
}

#[test]
fn is_better_than_cerm_at_equal_time_and_close_to_its_bound() {
    let mut table = String::from("pi4 (simulated), ohm sqrt(s)\n");
    let mut failed = false;
    for (r_ohm, gains) in [(100.0, 10.0..=30.0), (1000.0, 5.0..=15.0), (16_200.0, 2.0..=6.0)] {
        let (cerm, _, _) = figure(Method::Cerm, r_ohm, "offset = \"auto\"");
        let (tracked, bound, sigma) = figure(Method::Tracked, r_ohm, "");
        let (gain, excess) = (cerm.over(tracked), sigma.times(1.0 / bound));
        table += &format!(
            "{r_ohm:7} ohm: cerm {cerm:.4}, tracked {tracked:.4}: {gain:.2} times; sigma {sigma:.3} ohm is {excess:.3} of the bound\n"
        );
        failed |= !gain.is_in(gains) || !excess.is_in(1.0..=1.2);
    }
    println!("{table}");
    assert!(!failed, "seeds 0..{INSTRUMENTS}\n{table}");
}

/// The paper's section IV: 2^13 cycles of charge, no pause. All boards have the same components, and differ by the draws
/// of their noise; the paper's own CERM had 0.88 % on its one board.
///
/// The greatest error of 500 readings is below 0.2 % on most boards and not on all: readings of one board share the
/// quantisation that its calibration had. The share is stated, and no seed is chosen.
#[test]
fn the_paper_s_board_is_below_0_2_percent_at_100_ohm() {
    let (mut worst, mut offsets) = (Vec::new(), Vec::new());
    for seed in 0..100 {
        let measure = "charge-time = \"163.84 us\"\nsettle-time = \"0 us\"\n";
        let mut instrument = Bench::new("fpga-paper", Method::Tracked, 100.0, seed, measure).instrument();
        settle(&mut instrument);
        read(&mut instrument, BEFORE, |_| {});
        let mut errors = Errors::default();
        read(&mut instrument, 500, |reading| errors.add(reading, 100.0));
        assert_eq!(errors.count(), 500, "seed {seed}: {:?}", errors.not_ok);
        worst.push(errors.max());
        offsets.push(errors.mean());
    }
    let below = |limit: f64| worst.iter().filter(|worst| **worst < limit).count();
    let [below_005, below_015, below] = [0.05, 0.15, 0.2].map(below);
    worst.sort_by(f64::total_cmp);
    println!(
        "fpga-paper (simulated), 100 ohm: below 0.2 % on {below} boards of 100, median {:.3} %, worst {:.3} %; sd between boards {:.3} ohm",
        worst[50],
        worst[99],
        spread_of(&offsets)
    );
    let median_is_between = share_is_in(below_005, 100, 0.0..=0.5) && share_is_in(below_015, 100, 0.5..=1.0);
    assert!(share_is_in(below, 100, 0.9..=1.0) && median_is_between && worst[99] < 0.88, "{below} {worst:?}");
}

/// Errors of so many instruments on a changed board, over so many seconds, and the faults that they counted.
fn changed(
    name: &str,
    r_ohm: f64,
    seconds: f64,
    instruments: u64,
    change: impl Fn(&mut Bench),
) -> (Errors, [u64; Fault::ALL.len()]) {
    let mut all = Errors::default();
    let mut faults = [0; Fault::ALL.len()];
    for seed in 0..instruments {
        let mut bench = Bench::new(name, Method::Tracked, r_ohm, seed, "");
        change(&mut bench);
        let mut instrument = bench.instrument();
        settle(&mut instrument);
        read(&mut instrument, 30, |_| {});
        let before = instrument.stats().faults;
        let mut elapsed = 0.0;
        all.next_board();
        while elapsed < seconds {
            read(&mut instrument, 1, |reading| {
                elapsed += reading.duration.as_seconds();
                all.add(reading, r_ohm);
            });
        }
        for (index, sum) in faults.iter_mut().enumerate() {
            *sum += instrument.stats().faults[index] - before[index];
        }
    }
    (all, faults)
}

#[test]
fn finds_everything_within_two_seconds_of_a_cold_start() {
    let mut table = String::new();
    let mut failed = false;
    for r_ohm in [100.0, 1000.0, 16_200.0] {
        // The readings around t = 2 s: at whatever they stand, by what they say of themselves.
        let (mut all, mut tracked) = (Errors::default(), 0);
        for seed in 0..400 {
            let mut instrument = Bench::new("pi4", Method::Tracked, r_ohm, seed, "").instrument();
            let mut elapsed = 0.0;
            all.next_board();
            while elapsed < 2.3 {
                read(&mut instrument, 1, |reading| {
                    elapsed += reading.duration.as_seconds();
                    if elapsed > 2.0 {
                        all.add(reading, r_ohm);
                    }
                });
            }
            tracked += u32::from(instrument.stats().offset_is_known);
        }
        let row = format!(
            "{r_ohm} ohm: sd {:.3}, u {:.3}, within 2u {}, tracked already: {tracked} of 400",
            all.sd(),
            all.mean_u(),
            all.within_2u()
        );
        writeln!(table, "{row}").unwrap();
        // Until it tracks, readings are of the method that it begins with, whose noise is known from few discharges.
        failed |= !all.within_2u().is_in(promised(r_ohm)) || all.without_u > 0;
    }
    println!("pi4 (simulated), 2 s after a cold start\n{table}");
    assert!(!failed, "seeds 0..400\n{table}");
}

#[test]
fn stays_true_while_the_circuit_drifts() {
    let mut table = String::new();
    let mut failed = false;
    for (name, drift) in [
        ("C 1 %/min", DriftScene { c_per_minute: 0.01, ..DriftScene::default() }),
        ("V_Th 5 mV/min", DriftScene { v_th_per_minute: Some(Volt(5e-3)), ..DriftScene::default() }),
        ("V_DD 20 mV/min", DriftScene { v_dd_per_minute: Some(Volt(20e-3)), ..DriftScene::default() }),
        (
            "all of them",
            DriftScene {
                c_per_minute: 0.01,
                v_th_per_minute: Some(Volt(5e-3)),
                v_dd_per_minute: Some(Volt(20e-3)),
            },
        ),
    ] {
        for r_ohm in [100.0, 1000.0, 16_200.0] {
            let (all, _) =
                changed("pi4", r_ohm, 3.0, 5 * INSTRUMENTS, |bench| bench.scene.drift = Some(drift));
            let row = format!(
                "{name}, {r_ohm} ohm: mean {:.3}, sd {:.3}, u {:.3}, within 2u {}",
                all.mean(),
                all.sd(),
                all.mean_u(),
                all.within_2u()
            );
            writeln!(table, "{row}").unwrap();
            failed |= !all.within_2u().is_in(promised(r_ohm));
        }
    }
    println!("pi4 (simulated)\n{table}");
    assert!(!failed, "seeds 0..{INSTRUMENTS}\n{table}");
}

#[test]
fn spikes_are_counted_and_do_not_bias() {
    let mut table = String::new();
    let mut failed = false;
    for r_ohm in [100.0, 1000.0, 16_200.0] {
        let with = |probability: Option<f64>| {
            // Errors of one instrument hang together: 640 of them leave 0.03 sigma of chance to a mean.
            changed("pi4", r_ohm, 3.0, 16 * INSTRUMENTS, |bench| {
                let stamps = bench.scene.stamps.unwrap();
                let mean = probability.map(|_| Seconds(200e-6));
                bench.scene.stamps =
                    Some(DelayScene { tail_probability: probability, tail_mean: mean, ..stamps });
            })
        };
        let ((quiet, _), (all, faults)) = (with(None), with(Some(0.01)));
        // A stamp that nothing contradicts is a change that came all at once, and told as that.
        let (quiet, all) = (quiet.at_rest(), all.at_rest());
        let told = all.not_ok.iter().filter(|name| **name == "moving").count();
        let moved = all.mean_error().less(quiet.mean_error()).times(1.0 / quiet.sd());
        let (spikes, readings) = (faults[Fault::LatencyOutlier as usize], all.count() + all.not_ok.len());
        let row = format!(
            "{r_ohm} ohm: mean moved by {moved:.3} sigma, within 2u {}, late stamps told {:.2} %, other faults {}",
            all.within_2u(),
            100.0 * (spikes as f64 + told as f64) / readings as f64,
            faults.iter().sum::<u64>() - spikes
        );
        writeln!(table, "{row}").unwrap();
        failed |= !moved.is(0.0, 0.1)
            || !all.within_2u().is_in(promised(r_ohm))
            || !share_is_in(spikes as usize + told, readings, 0.005..=0.03);
    }
    println!("pi4 (simulated), 1 % of stamps late by 200 us on average\n{table}");
    assert!(!failed, "seeds 0..{}\n{table}", 16 * INSTRUMENTS);
}

#[test]
fn light_touches_are_measured_within_a_deadline_of_60_ms() {
    let mut table = String::new();
    let mut failed = false;
    for (r_ohm, share) in [(100e3, 0.01), (1e6, 0.1)] {
        let mut all = Errors::default();
        let mut longest = 0.0f64;
        for seed in 0..INSTRUMENTS {
            let mut instrument =
                Bench::new("pi4", Method::Tracked, r_ohm, seed, "deadline = \"60 ms\"").instrument();
            settle(&mut instrument);
            read(&mut instrument, 100, |_| {});
            all.next_board();
            read(&mut instrument, 50, |reading| {
                all.add(reading, r_ohm);
                longest = longest.max(reading.duration.as_seconds());
            });
        }
        let sigma = all.together(spread_of).times(1.0 / r_ohm);
        let row = format!(
            "{r_ohm} ohm: mean {:+.4}, sigma {sigma:.4}, within 2u {}, {} of {} with a number, longest reading {:.1} ms",
            all.mean() / r_ohm,
            all.within_2u(),
            all.count(),
            INSTRUMENTS * 50,
            1e3 * longest
        );
        writeln!(table, "{row}").unwrap();
        failed |= longest > 0.2
            || !(sigma.below(share) & all.mean_error().within(share * r_ohm)).may_be(true)
            // So far up u is what a leak too small to show may do.
            || !all.within_2u().is_in(WITHIN_2U..=1.0);
    }
    println!("pi4 (simulated)\n{table}");
    assert!(!failed, "seeds 0..{INSTRUMENTS}\n{table}");
}

/// An untouched force sensor is somewhere above 10 Mohm: a reading is a number only where the conductance is resolved, `open` with
/// a lower bound that holds elsewhere. What a late stamp makes of a reading is a state, or within ten sigma.
#[test]
fn an_untouched_sensor_is_open_and_never_a_number_that_it_is_not() {
    let mut table = String::new();
    let mut failed = false;
    for r_ohm in [1e5, 3e5, 1e6, 3e6, 1e7, 2e7, 1e8, 1e12] {
        let (mut numbers, mut opens, mut wild, mut unsettled) = (0, 0, 0, 0);
        for board in 0..4 {
            let mut instrument = Bench::new("pi4", Method::Tracked, r_ohm, board, "").instrument();
            settle(&mut instrument);
            read(&mut instrument, 1000, |reading| match reading.status {
                Status::Ok { r_ohm: found, .. } => {
                    numbers += 1;
                    let sigmas = found.u.map_or(0.0, |u| (found.value - r_ohm).abs() / u);
                    wild += usize::from(sigmas > 10.0);
                }
                Status::Open { r_min_ohm, .. } => {
                    opens += 1;
                    // A bound is at least two sigma of conductance: here, too, the truth is less than ten away.
                    wild += usize::from(2.0 * (r_min_ohm / r_ohm - 1.0) > 10.0);
                }
                Status::Fault(fault) => unsettled += usize::from(fault == Fault::Unsettled),
                Status::Short { .. } => wild += 1,
            });
        }
        let row =
            format!("{r_ohm:e} ohm: {numbers} numbers, {opens} open, {wild} wild, {unsettled} unsettled");
        writeln!(table, "{row}").unwrap();
        // Two late stamps of a thousand, without a reading before that was sudden, may look like motion.
        let are_few = share_is_in(unsettled, 4000, 0.0..=0.002);
        failed |= wild > 0 || !are_few || (r_ohm > 5e7 && numbers > 0) || (r_ohm < 2e6 && opens > 0);
    }
    println!("pi4 (simulated)\n{table}");
    assert!(!failed, "\n{table}");
}

/// Of a low resistance noise may hide much; it is a number, or short, and not open.
#[test]
fn what_is_low_beside_a_coarse_clock_is_not_open() {
    let mut bench = Bench::with_kind("pi4", Kind::OneCapacitor, Method::Tracked, 60.0, 1, "");
    bench.config.set("circuit.c", "100 nF");
    bench.scene.circuit.c = Some(Farad(100e-9));
    bench.scene.stamps.as_mut().unwrap().jitter = Some(Seconds(3.5e-6));
    let mut errors = Errors::default();
    errors.next_board();
    let mut instrument = bench.instrument();
    read(&mut instrument, 4000, |reading| errors.add(reading, 60.0));
    let open = errors.not_ok.iter().filter(|name| **name == "open").count();
    assert!(open == 0 && errors.count() > 1000, "{open} of 4000 are open, {} numbers", errors.count());
    assert!(share_is_in(errors.wild, errors.count(), 0.0..=1e-3), "{} wild", errors.wild);
}

/// A discharge that a known resistor finishes at the deadline, just when the sensor would have done it itself: noise has its
/// crossing on either side of the switch.
#[test]
fn a_crossing_at_the_switch_is_not_taken_for_one_before_it() {
    let bench = |r_ohm, seed| {
        let mut bench = Bench::with_kind("pi4", Kind::OneCapacitor, Method::Tracked, r_ohm, seed, "");
        bench.scene.noise = None;
        let calls = bench.scene.calls.as_mut().unwrap();
        (calls.fixed, calls.per_line) = (Seconds(1.8e-6), Seconds(3.8e-6));
        let stamps = bench.scene.stamps.as_mut().unwrap();
        (stamps.mean, stamps.jitter) = (Seconds(2e-6), Some(Seconds(2e-6)));
        bench
    };
    let deadline_ns = bench(1000.0, 0).parts().1.deadline.as_ns();
    // What the circuit takes for each ohm, ln(3.3 V / 1.1 V) 470 nF.
    let usual_ohm = deadline_ns / (3f64.ln() * 470.0) - 40.0;
    let mut errors = Errors::default();
    for seed in 0..40 {
        let r_ohm = usual_ohm * (1.0 + 5e-4 * seed as f64);
        errors.next_board();
        let mut instrument = bench(r_ohm, seed).instrument();
        settle(&mut instrument);
        read(&mut instrument, 60, |reading| errors.add(reading, r_ohm));
    }
    let share = errors.within_2u();
    assert!(errors.wild == 0 && share.is_in(0.93..=1.0), "{} wild, {share} within 2u", errors.wild);
}
