//! Noise of every kind: of the clock, at the threshold, wide-band, and rare long delays.

use crate::by_hand::ByHand;
use crate::common::chance::{Figure, mean_of, sd_of};
use crate::common::seed::rng;
use crate::common::{Errors, read, settle, spread_of};
use crate::paper::{self, Noise, Parts, R_O, Times};
use crate::scenario::{Board, FIRST_ORDER, Scenario, moving, percent, rms, without_number};
use crate::switching::{PI4_NOISE, STAMP, bias_of_offset};
use cermd::pins::sim::scene::{DelayScene, NoiseScene};
use cermd::reading::Method;
use cermd::units::{Hertz, Seconds, Volt};
use rand::RngExt;
use std::fmt::{Display, Write};
use std::ops::RangeInclusive;

/// The paper's board with capacitors within 1 % of theirs: where in a cycle a crossing falls differs from board to board.
fn paper_s_boards(method: Method, boards: u64) -> (Errors, Figure) {
    let (mut all, mut largest) = (Errors::default(), Vec::new());
    for seed in 0..boards {
        let mut rng = rng(seed);
        let mut near = |value: f64| value * rng.random_range(0.99..1.01);
        let mut board = Board::paper();
        let Parts { c_a, c_b, c, .. } = board.parts;
        board.parts = Parts { c_a: near(c_a), c_b: near(c_b), c: near(c), ..board.parts };
        let mut instrument = board.bench(method, 100.0, seed).instrument();
        settle(&mut instrument);
        read(&mut instrument, 600, |_| {});
        let mut errors = Errors::default();
        read(&mut instrument, 500, |reading| errors.add(reading, 100.0));
        largest.push(errors.max());
        all.add_board(errors);
    }
    (all, mean_of(&largest))
}

pub fn quantisation() -> Scenario {
    let mut it = Scenario::new(
        "A clock of 20 ns, the paper's board, 100 ohm",
        "the largest of 500 errors is below 0.88 %, the paper's figure for CERM",
        "0..60",
    );
    let parts = Parts::PAPER;
    let noise = Noise { jitter: 20e-9 / 12f64.sqrt(), voltage: 0.22e-3 };
    let full = Times::of(&parts, 100.0, 0.0);
    let split = Times::of(&parts, 100.0, 0.9 * parts.g()[0] * 140.0);
    let predicted = |method: Method| match method {
        Method::Tpcm => Some(full.scatter(noise.of_times(&parts, 100.0), |times| paper::tpcm(&parts, times))),
        Method::Tcdic => {
            Some(full.scatter(noise.of_times(&parts, 100.0), |times| paper::tcdic(&parts, times)))
        }
        Method::Cerm => {
            Some(split.scatter(noise.of_times(&parts, parts.r_c2), |times| paper::cerm(&parts, times)))
        }
        _ => None,
    };
    let mut of_cerm = 0.0;
    for method in Method::ALL {
        let (errors, largest) = paper_s_boards(method, 60);
        if let Some(predicted) = predicted(method) {
            // CERM has the error of its offset besides, the more so as 20 ns are much to it.
            let budget = if method == Method::Cerm { 0.1 } else { FIRST_ORDER };
            it.expect(
                format!("{}: error, of the predicted {predicted:.3} ohm", method.as_str()),
                errors.rms_ratio(predicted),
                1.0,
                budget,
            );
            of_cerm = predicted;
        }
        if method == Method::Tracked {
            it.promise("tracked: error, of that predicted for CERM", errors.rms_ratio(of_cerm), 0.0..=0.2);
        }
        let figure =
            format!("error {}, largest {}", percent(rms(&errors) / 100.0), percent(largest.value / 100.0));
        it.cell_of(method, figure, &errors, largest.below(0.88), method == Method::Tracked);
    }
    let cycle = 20e-9 / parts.g()[0];
    it.why = format!(
        "a cycle is {cycle:.2} ohm of node A, whatever R_x. CERM takes it out of the x discharge; that through Rc1 has it as well, \
         and each reading has one of these. Tracking averages over many."
    );
    it
}

pub fn trigger() -> Scenario {
    let mut board = Board::quiet(Parts::PI4);
    let noise = Noise { voltage: 2e-3, ..PI4_NOISE };
    board.scene.noise = Some(NoiseScene { voltage: Volt(noise.voltage), bandwidth: None });
    let (parts, r_ohm) = (board.parts, 16_200.0);
    let mut it = Scenario::new("2 mV of noise at the threshold, 16.2 kohm", "error below 0.2 %", "0..40");
    let times = Times::of(&parts, r_ohm, 0.0);
    let of_times = noise.of_times(&parts, r_ohm);
    let of_tcdic = times.scatter(of_times, |times| paper::tcdic(&parts, times));
    let information: f64 =
        parts.g().iter().zip(noise.sigma(&parts, r_ohm)).map(|(g, sigma)| (g / sigma).powi(2)).sum();
    for method in Method::ALL {
        let predicted = match method {
            Method::Tpcm => Some(times.scatter(of_times, |times| paper::tpcm(&parts, times))),
            Method::Tcdic | Method::Cerm => Some(of_tcdic),
            // The bound of Cramer and Rao of its discharge.
            Method::Tracked => Some(information.powf(-0.5)),
            Method::Qerm => None,
        };
        let errors = board.errors(method, r_ohm, 40, 200);
        if let Some(predicted) = predicted {
            let (what, found) = (format!("{}: error, of", method.as_str()), errors.rms_ratio(predicted));
            match method {
                Method::Tracked => it.promise(format!("{what} its bound"), found, 1.0..=1.2),
                _ => it.expect(format!("{what} the predicted {predicted:.1} ohm"), found, 1.0, FIRST_ORDER),
            }
        }
        let holds = errors.rms_ratio(r_ohm).below(0.002);
        it.cell_of(method, percent(rms(&errors) / r_ohm), &errors, holds, method == Method::Tracked);
    }
    it.why = "trigger noise grows with R: its share of the time stays the same (eq. (8)). Two nodes are better than one only if B falls \
              as fast as A (C_A >> C_B); tracking weights each by its own noise, and does not add that of two calibration \
              discharges to each reading."
        .to_owned();
    it
}

const VOLTAGE: f64 = 5e-3;
const BANDWIDTH: f64 = 10e6;
/// The share of readings within 2u where u contains that they are early.
const TOLD: RangeInclusive<f64> = 0.9..=0.985;

fn wide_band(parts: Parts) -> Board {
    let mut board = Board::quiet(parts);
    board.scene.noise = Some(NoiseScene { voltage: Volt(VOLTAGE), bandwidth: Some(Hertz(BANDWIDTH)) });
    board
}

/// Means of the first crossings of a cycle whose x discharge ends through `last`.
fn early(parts: &Parts, last: f64) -> Times {
    let [c1, c2, x] = [parts.r_c1, parts.r_c2, last].map(|r| paper::early(parts, VOLTAGE, BANDWIDTH, r));
    Times { c1, c2, x, switch: 0.0 }
}

/// The first dip below the threshold is one of samples in steps of half a period of the bandwidth.
fn expect_bias(it: &mut Scenario, what: impl Display, mean: Figure, predicted: f64) {
    it.expect(format!("{what}: bias, ohm"), mean, predicted, (FIRST_ORDER * predicted).abs());
}

pub fn wide_band_low() -> Scenario {
    let board = wide_band(Parts::PI4);
    let (parts, r_ohm) = (board.parts, 100.0);
    let mut it =
        Scenario::new("5 mV of noise, 10 MHz wide, 100 ohm", "the mean is off by less than 1 %", "0..40");
    let times = Times::of(&parts, r_ohm, 0.0).plus(early(&parts, r_ohm));
    let [of_tpcm, of_tcdic] = [paper::tpcm, paper::tcdic].map(|equation| equation(&parts, &times) - r_ohm);
    let split = Times::of(&parts, r_ohm, 0.9 * parts.g()[0] * (r_ohm + R_O)).plus(early(&parts, parts.r_c2));
    let of_cerm = paper::cerm(&parts, &split) - r_ohm;
    for (method, measure, name, predicted) in [
        (Method::Tpcm, "", "", of_tpcm),
        (Method::Tcdic, "", "", of_tcdic),
        (Method::Cerm, "offset = \"8 us\"\nt-l = \"1 s\"", "offset of the stamps ", of_cerm),
    ] {
        let errors = board.with(measure).errors(method, r_ohm, 40, 100);
        let mean = errors.mean_error();
        expect_bias(&mut it, format!("{} {name}", method.as_str()), mean, predicted);
        let figure = format!("{name}{}", percent(mean.value / r_ohm));
        it.cell_of(method, figure, &errors, mean.within(0.01 * r_ohm), false);
        if measure.is_empty() {
            it.promise(format!("{}: within 2u", method.as_str()), errors.within_2u(), TOLD);
        }
    }
    for (method, name) in [(Method::Qerm, ""), (Method::Cerm, "offset found "), (Method::Tracked, "")] {
        let measure = if method == Method::Cerm { "t-l = \"1 s\"" } else { "" };
        let errors = board.with(measure).errors(method, r_ohm, 40, 100);
        let (mean, missing) = (errors.mean_error(), without_number(&errors));
        let of_two_nodes = method == Method::Cerm;
        it.promise(
            format!("{} {name}: bias, of CERM's as printed", method.as_str()),
            mean.times(1.0 / of_cerm),
            if of_two_nodes { 0.1..=0.4 } else { -0.1..=0.1 },
        );
        let mut figure = format!("{name}{}", percent(mean.value / r_ohm));
        if missing > 0.005 {
            write!(figure, ", {:.0} % no number", 100.0 * missing).unwrap();
        }
        it.cell_of(method, figure, &errors, mean.within(0.01 * r_ohm), !of_two_nodes);
    }
    let [first, second] =
        [parts.r_c1, parts.r_c2].map(|r| -1e6 * paper::early(&parts, VOLTAGE, BANDWIDTH, r)[0]);
    it.why = format!(
        "the first dip of the noise below the threshold counts, and the slower the fall, the more dips there are: node A crosses \
         {first:.0} us early through Rc1, {second:.0} us through Rc2, and not in proportion. A discharge that ends through Rc2 is as \
         early as that of calibration, and the offset that split calibration finds contains what is left: but it is one offset, and \
         B is three times as early as A. `qerm` times A alone, and so does `tracked` at such a resistance. First dips scatter more to \
         the early side than to the late one: some dozens of discharges through Rc2 show it, and from then on u contains what it may do."
    );
    it
}

pub fn wide_band_high() -> Scenario {
    let board = wide_band(Parts::PI4);
    let (parts, r_ohm) = (board.parts, 100e3);
    let mut it =
        Scenario::new("5 mV of noise, 10 MHz wide, 100 kohm", "the mean is off by less than 0.1 %", "0..40");
    let times = Times::of(&parts, r_ohm, 0.0).plus(early(&parts, r_ohm));
    let [of_tpcm, of_tcdic] = [paper::tpcm, paper::tcdic].map(|equation| equation(&parts, &times) - r_ohm);
    let patient = board.with("deadline = \"400 ms\"");
    for (method, predicted) in [(Method::Tpcm, of_tpcm), (Method::Tcdic, of_tcdic), (Method::Cerm, of_tcdic)]
    {
        let errors = patient.errors(method, r_ohm, 40, 100);
        let mean = errors.mean_error();
        expect_bias(&mut it, method.as_str(), mean, predicted);
        it.cell_of(method, percent(mean.value / r_ohm), &errors, mean.within(0.001 * r_ohm), false);
        it.promise(format!("{}: within 2u", method.as_str()), errors.within_2u(), TOLD);
    }
    for (name, board, expected) in [
        ("in full", patient, false),
        ("finished through Rc1 after 30 ms", board.with("deadline = \"30 ms\""), true),
    ] {
        // Discharges of calibration are rare with it.
        let errors = board.errors(Method::Tracked, r_ohm, 40, 2000);
        let mean = errors.mean_error();
        it.promise(format!("tracked, {name}: within 2u"), errors.within_2u(), TOLD);
        let figure = format!("{name} {}", percent(mean.value / r_ohm));
        it.cell_of(Method::Tracked, figure, &errors, mean.within(0.001 * r_ohm), expected);
    }
    it.why = "as at 100 ohm; averaging takes nothing of it away, but u contains it, once it shows (of \
              `tracked`, which calibrates seldom, after some hundred readings). A discharge that a known resistor finishes is as early as \
              the calibration. A low-pass at the sense lines, or less noise, is the remedy."
        .to_owned();
    it
}

/// What is not of first order in a spike: 200 us are a sixth of the way from a switch to the end of a discharge.
const SPIKES_ARE_LONG: f64 = 0.1;
/// A reading that is so many sigma away from the one before it has changed, or has a late stamp.
const SUDDEN: f64 = 5.0;

pub fn spikes() -> Scenario {
    let quiet = Board::quiet(Parts::PI4);
    let (parts, r_ohm) = (quiet.parts, 1000.0);
    let (probability, mean) = (0.01, 200e-6);
    let mut board = quiet.clone();
    board.scene.stamps = board.scene.stamps.map(|stamps| DelayScene {
        tail_probability: Some(probability),
        tail_mean: Some(Seconds(mean)),
        ..stamps
    });
    let mut it = Scenario::new(
        "1 % of stamps late by another 200 us, 1 kohm",
        "the mean moves by less than a tenth of sigma, and sigma by less than a fifth",
        "0..200",
    );
    let mut by_hand = ByHand::new(&board, r_ohm, 1);
    by_hand.offset = STAMP;
    // Variance of what is 0 in most cases and exponential in some.
    let jitter =
        (PI4_NOISE.jitter.powi(2) + (2.0 * probability - probability * probability) * mean * mean).sqrt();
    let noise = Noise { jitter, ..PI4_NOISE };
    let switch = 0.9 * parts.g()[0] * (r_ohm + R_O);
    for (method, equation, switch) in [
        (Method::Tpcm, paper::tpcm as paper::Equation, None),
        (Method::Tcdic, paper::tcdic, None),
        (Method::Cerm, paper::cerm, Some(switch)),
    ] {
        let found: Vec<f64> =
            by_hand.cycles(20_000, switch).iter().map(|times| equation(&parts, times)).collect();
        let (found_mean, found_sd) = (mean_of(&found), sd_of(&found));
        let last = if switch.is_some() { parts.r_c2 } else { r_ohm };
        let exact = Times::of(&parts, r_ohm, switch.unwrap_or(0.0));
        let [predicted, quiet] = [noise, PI4_NOISE]
            .map(|noise| exact.scatter(noise.of_times(&parts, last), |times| equation(&parts, times)));
        it.expect(
            format!("{} as printed: sigma, of the predicted {predicted:.1} ohm", method.as_str()),
            found_sd.times(1.0 / predicted),
            1.0,
            SPIKES_ARE_LONG,
        );
        if method == Method::Cerm {
            let bias = bias_of_offset(&parts, method, probability * mean, r_ohm);
            let found = Figure { value: found_mean.value - r_ohm, ..found_mean };
            it.expect("cerm as printed: bias, ohm", found, bias, SPIKES_ARE_LONG * bias.abs());
        }
        it.published(
            method,
            format!("sigma {:.0} times", found_sd.value / quiet),
            found_sd.below(1.2 * quiet),
            false,
        );
    }
    for method in Method::ALL {
        let [calm, with_spikes] = [&quiet, &board].map(|board| board.errors(method, r_ohm, 200, 60));
        let [calm, all] = [&calm, &with_spikes].map(Errors::at_rest);
        let moved = all.mean_error().less(calm.mean_error()).times(1.0 / calm.sd());
        let wider = all.together(spread_of).over(calm.together(spread_of));
        // Two late stamps in a row are told by nothing from a sensor that has changed.
        let wild = all.errors.iter().zip(&all.us).filter(|(error, u)| error.abs() > 10.0 * **u).count();
        let what = format!("{}: readings off by more than ten sigma", method.as_str());
        it.expect_share(what, wild, all.count(), 0.0..=probability * probability);
        if method == Method::Tpcm {
            // A jump of more than the noise of two readings is told.
            let hidden = SUDDEN * 2f64.sqrt() * calm.sd() * parts.g()[0];
            let predicted = probability * (-hidden / mean).exp();
            let readings = with_spikes.not_ok.len() + with_spikes.without_u + with_spikes.count();
            let what = "tpcm: readings that are moving or unsettled";
            it.expect_share(what, moving(&with_spikes), readings, predicted..=predicted);
        }
        let figure = format!("mean {:+.2} sigma, sigma {:.2} times", moved.value, wider.value);
        it.cell(method, figure, moved.within(0.1) & wider.below(1.2), true);
    }
    it.why = "one spike is many sigma. With two nodes, crossings that contradict each other are no number (`latency-outlier`), and \
              calibration discharges beyond 4 or 5 sigma are not used. A single node has nothing to compare its sensor's crossing with \
              but the reading before: what jumps by more than the noise of both has an uncertainty that contains the jump (`moving`), \
              and does not count any more when the next reading is back. Two late stamps in a row, one pair in 10 000 readings, look like a sensor that has changed."
        .to_owned();
    it
}
