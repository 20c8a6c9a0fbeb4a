//! Circuits at the edge of what the equations allow, and circuits that do not stay what they are.

use crate::by_hand::ByHand;
use crate::charged::Charged;
use crate::common::chance::{Figure, Verdict, mean_of, share_below, sigmas};
use crate::common::seed::rng;
use crate::common::{Errors, read, settle};
use crate::paper::{self, Noise, Parts, R_O, Times, V_DD};
use crate::scenario::{Board, FIRST_ORDER, Scenario, is_true, rms, truth};
use crate::switching::PI4_NOISE;

use cermd::config::Severity;
use cermd::pins::sim::SimPins;
use cermd::pins::sim::scene::DriftScene;
use cermd::pins::{Armed, Bracket, Drives, Edge, Levels, Particulars, Pins, PinsError};
use cermd::reading::{Measured, Method, Status};
use cermd::units::{Nanos, Volt};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::fmt::Write;

/// What the check of the configuration says about a key, if anything.
fn finding(board: &Board, method: Method, key: &str) -> Option<Severity> {
    let config = board.bench(method, 1000.0, 0).config.parse();
    config.check().0.iter().filter(|finding| finding.key == key).map(|finding| finding.severity).min()
}

fn expect_errors(it: &mut Scenario, method: Method, errors: &Errors, predicted: f64) {
    it.expect(
        format!("{}: error, of the predicted {predicted:.2} ohm", method.as_str()),
        errors.rms_ratio(predicted),
        1.0,
        FIRST_ORDER,
    );
}

/// What Cramer and Rao allow to a discharge in full.
fn bound(parts: &Parts, noise: Noise, r_ohm: f64) -> f64 {
    let sigma = noise.sigma(parts, r_ohm);
    parts.g().iter().zip(sigma).map(|(g, sigma)| (g / sigma).powi(2)).sum::<f64>().powf(-0.5)
}

pub fn node_b() -> Scenario {
    let (limit, r_ohm) = (Parts::PI4.c_a * 1.1 / (V_DD - 1.1), 5000.0);
    let parts = Parts { c_b: 0.96 * limit, ..Parts::PI4 };
    let board = Board::quiet(parts);
    let mut it = Scenario::new(
        "C_B at 96 % of the value from which node B never crosses, 5 kohm",
        "error below 0.2 %",
        "0..40",
    );
    for method in [Method::Tpcm, Method::Tcdic, Method::Cerm, Method::Tracked] {
        let errors = board.errors(method, r_ohm, 40, 100);
        if let Some(charged) = Charged::new(&board, method, r_ohm) {
            expect_errors(&mut it, method, &errors, charged.error(0.0));
        }
        if method == Method::Tracked {
            let of_bound = errors.rms_ratio(bound(&parts, PI4_NOISE, r_ohm));
            // It is switched, and tells more than that.
            it.promise("tracked: error, of the bound of a discharge in full", of_bound, 0.7..=1.0);
        }
        let good = errors.rms_ratio(r_ohm).below(0.002) & is_true(&errors);
        it.cell_of(
            method,
            truth(&errors, r_ohm),
            &errors,
            good,
            matches!(method, Method::Tpcm | Method::Tracked),
        );
    }
    let warned = finding(&board, Method::Tracked, "circuit.c-b") == Some(Severity::Warning);
    let beyond = Board::pi4(Parts { c_b: 1.01 * limit, ..parts });
    let refused = finding(&beyond, Method::Tracked, "circuit.c-b") == Some(Severity::Error);
    it.require("the configuration's check warns, and refuses C_B beyond", warned && refused);
    let [a, b] = parts.s_per_volt_ohm();
    it.why = format!(
        "node B falls {:.0} times more slowly than A where it crosses, and eq. (11) gives both the same weight. Weighted by their \
         noise, B does no harm. The check of the configuration warns of such a C_B, and refuses a larger one.",
        b / a
    );
    it
}

pub fn close_resistors() -> Scenario {
    let parts = Parts { r_c1: 10_000.0, ..Parts::PI4 };
    let (board, r_ohm) = (Board::quiet(parts), 1000.0);
    let mut it = Scenario::new(
        "Rc1 at 10 kohm, close to Rc2 at 12.7 kohm; 1 kohm",
        "error below 2 %, and true",
        "0..40",
    );
    for method in Method::ALL {
        let (errors, usual) =
            (board.errors(method, r_ohm, 40, 100), Board::quiet(Parts::PI4).errors(method, r_ohm, 40, 100));
        if let Some(charged) = Charged::new(&board, method, r_ohm) {
            expect_errors(&mut it, method, &errors, charged.error(0.0));
        }
        // The walk of `tracked`, never assumed slower than a drift, counts as much more as the noise does.
        let most = if method == Method::Tracked { 1.0 / 1.3 } else { 1.0 - FIRST_ORDER };
        it.promise(format!("{}: error, of u", method.as_str()), errors.pulls(), most..=1.0 + FIRST_ORDER);
        let figure =
            format!("{}, {:.0} times that of 470 ohm", truth(&errors, r_ohm), rms(&errors) / rms(&usual));
        let good = errors.rms_ratio(r_ohm).below(0.02) & is_true(&errors);
        it.cell_of(method, figure, &errors, good, matches!(method, Method::Qerm | Method::Tracked));
    }
    let warned = finding(&board, Method::Tracked, "circuit.r-c2") == Some(Severity::Warning);
    it.require("the configuration's check warns", warned);
    let ratio = (r_ohm - parts.r_c1) / (parts.r_c2 - parts.r_c1);
    it.why = format!(
        "R_x is extrapolated: the noise of both calibration discharges counts {:.1} and {:.1} times. u grows with it. In the circuit of \
         QERM the second resistor is Rc1 + Rc2, far from Rc1. The check of the configuration warns.",
        1.0 - ratio,
        -ratio
    );
    it
}

pub fn slow_drift() -> Scenario {
    let mut it = Scenario::new(
        "C drifts by 1 %/min, V_Th by 5 mV/min, V_DD by 20 mV/min",
        "the numbers are true at 100 ohm, 1 kohm and 16.2 kohm",
        "0..20",
    );
    let mut board = Board::quiet(Parts::PI4);
    board.scene.drift = Some(DriftScene {
        c_per_minute: 0.01,
        v_th_per_minute: Some(Volt(5e-3)),
        v_dd_per_minute: Some(Volt(20e-3)),
    });
    for method in Method::ALL {
        let mut all = Errors::default();
        // The same seeds for each of them: not three boards.
        let (mut worst, mut holds) = (0.0f64, Verdict::from(true));
        for r_ohm in [100.0, 1000.0, 16_200.0] {
            let errors = board.errors(method, r_ohm, 20, 200);
            worst = worst.max(errors.mean().abs() / errors.sd());
            holds = holds & is_true(&errors) & errors.mean_error().times(1.0 / errors.sd()).within(0.5);
            let what = format!("{}, {r_ohm} ohm: within 2u", method.as_str());
            it.promise(what, errors.within_2u(), 0.93..=0.97);
            all.add_board(errors);
        }
        let figure = format!("mean off by {worst:.2} sigma, {:.0} % in 2u", 100.0 * all.coverage());
        it.cell(method, figure, holds, true);
    }
    // A calibration of an hour ago, as many use it: C alone has gone 60 % by then, and 1 % in a minute.
    it.why = "a calibration in each reading is 50 ms old at the most. The tracked one takes the drift for a random walk, whose speed it \
              learns, and calibrates more often."
        .to_owned();
    it
}

/// How fast C drifts, per second.
const FAST: f64 = 0.02;

pub fn fast_drift() -> Scenario {
    let (mut board, r_ohm) = (Board::quiet(Parts::PI4), 16_200.0);
    board.scene.drift = Some(DriftScene { c_per_minute: 60.0 * FAST, ..DriftScene::default() });
    let parts = board.parts;
    let mut it = Scenario::new(
        "C drifts by 2 %/s: within a cycle; 16.2 kohm",
        "the mean is off by less than a fifth of sigma, and the numbers are true",
        "0..20",
    );
    // Discharges begin one charge and one discharge apart; the drift is linear from the start of the simulation on.
    let mut by_hand = ByHand::new(&board, r_ohm, 1);
    let (mut errors, mut predictions) = (Vec::new(), Vec::new());
    for _ in 0..200 {
        let begin = by_hand.pins.now().as_seconds();
        let times = by_hand.cycle(None).unwrap();
        let mut at = begin;
        let charge = by_hand.charge_s();
        let mut grown = |exact: [f64; 2], found: [f64; 2]| {
            let factor = 1.0 + FAST * at;
            at += charge + 20e-6 + found[1];
            exact.map(|t| t * (factor - 1.0))
        };
        let exact = Times::of(&parts, r_ohm, 0.0);
        let late = Times {
            c1: grown(exact.c1, times.c1),
            c2: grown(exact.c2, times.c2),
            x: grown(exact.x, times.x),
            switch: 0.0,
        };
        predictions.push(paper::tcdic(&parts, &exact.plus(late)) - r_ohm);
        errors.push(paper::tcdic(&parts, &times) - r_ohm);
    }
    let (bias, predicted) = (mean_of(&errors), mean_of(&predictions).value);
    it.expect("tcdic as printed: bias, ohm", bias, predicted, FIRST_ORDER * predicted);
    it.require("the sample is large enough to show it", bias.margin < predicted);
    for method in Method::ALL {
        let errors = board.errors(method, r_ohm, 20, 100);
        let off = errors.mean_error().times(1.0 / errors.sd());
        let figure = format!("mean off by {:+.2} sigma, {}", off.value, truth(&errors, r_ohm));
        it.cell_of(method, figure, &errors, off.within(0.2) & is_true(&errors), false);
    }
    it.why = "between the calibration discharges and that of the sensor C grows by as much as the noise. The filter of `tracked` rejects \
              such a circuit and never begins; until it does, each reading has its own calibration."
        .to_owned();
    it
}

/// The supply changes from charge to charge, V rms.
const SUPPLY: f64 = 5e-3;

/// Pins whose supply has another voltage whenever charging lines switch.
struct Restless {
    inner: SimPins,
    rng: ChaCha8Rng,
}

impl Pins for Restless {
    fn now(&mut self) -> Nanos {
        self.inner.now()
    }
    fn drive(&mut self, on: Drives) -> Result<Bracket, PinsError> {
        if on.contains(Drives::CHARGE_A) {
            // The sum of twelve uniform numbers: near enough to a normal one.
            let z = (0..12).map(|_| self.rng.random::<f64>()).sum::<f64>() - 6.0;
            self.inner.alter(|circuit| circuit.v_dd = V_DD + SUPPLY * z);
        }
        self.inner.drive(on)
    }
    fn arm(&mut self) -> Result<Armed, PinsError> {
        self.inner.arm()
    }
    fn edge(&mut self, until: Nanos) -> Result<Option<Edge>, PinsError> {
        self.inner.edge(until)
    }
    fn sleep_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.inner.sleep_until(at)
    }
    fn levels(&mut self) -> Result<Levels, PinsError> {
        self.inner.levels()
    }
    fn rest_until(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.inner.rest_until(at)
    }
    fn rest_before_edge(&mut self, at: Nanos) -> Result<(), PinsError> {
        self.inner.rest_before_edge(at)
    }
    fn particulars(&self) -> Particulars<'_> {
        self.inner.particulars()
    }
}

fn restless_errors(board: &Board, method: Method, r_ohm: f64) -> Errors {
    board.errors_with(method, r_ohm, 20, 100, |inner, seed| Restless { inner, rng: rng(1000 + seed) })
}

pub fn restless_supply() -> Scenario {
    let (board, r_ohm) = (Board::quiet(Parts::PI4), 5000.0);
    let mut it = Scenario::new(
        "V_DD changes from charge to charge by 5 mV rms, 5 kohm",
        "the numbers are true, and the error is below 0.15 %",
        "0..20",
    );
    for method in Method::ALL {
        let errors = restless_errors(&board, method, r_ohm);
        if let Some(charged) = Charged::new(&board, method, r_ohm) {
            expect_errors(&mut it, method, &errors, charged.error(SUPPLY));
        }
        let good = is_true(&errors) & errors.rms_ratio(r_ohm).below(0.0015);
        it.cell_of(method, truth(&errors, r_ohm), &errors, good, method == Method::Tracked);
    }
    it.why = "the charge is another one each time, and with it the crossings, in proportion to R + Ro: no calibration before or after \
              can take it out. What A and B share of it is learned, so that u is right, and `tracked` takes the greater part of it out \
              by the difference of both."
        .to_owned();
    it
}

pub fn ten_megohm() -> Scenario {
    let (board, r_ohm) = (Board::quiet(Parts::PI4).with("deadline = \"60 ms\""), 10e6);
    let parts = board.parts;
    let mut it = Scenario::new(
        "10 Mohm, deadline 60 ms",
        "a true bound or a true number, each reading within 200 ms",
        "0..10",
    );
    let [_, g_b] = parts.g();
    let endless = g_b * (r_ohm + R_O);
    let mut by_hand = ByHand::new(&board, r_ohm, 1);
    let found = by_hand.wait_for(100.0);
    // One discharge, whose noise is that of (7).
    let [_, sigma] = PI4_NOISE.sigma(&parts, r_ohm);
    let found_s = Figure { value: found, u: sigma, margin: sigmas() * sigma };
    it.expect("as printed: B crosses after, s", found_s, endless, 1e-3 * endless);
    it.published(Method::Tcdic, format!("{found:.1} s"), found < 0.2, false);
    for method in Method::ALL {
        let (mut open, mut sound, mut count) = (0usize, 0usize, 0usize);
        let (mut longest, mut lowest, mut relative) = (0.0f64, f64::INFINITY, 0.0f64);
        for seed in 0..10 {
            let mut instrument = board.bench(method, r_ohm, seed).instrument();
            settle(&mut instrument);
            read(&mut instrument, 20, |_| {});
            read(&mut instrument, 50, |reading| {
                count += 1;
                longest = longest.max(reading.duration.as_seconds());
                match reading.status {
                    Status::Open { r_min_ohm, .. } => {
                        open += 1;
                        sound += usize::from(r_min_ohm <= r_ohm);
                        lowest = lowest.min(r_min_ohm);
                    }
                    Status::Ok { r_ohm: Measured { value, u: Some(u) }, .. } => {
                        sound += usize::from((value - r_ohm).abs() <= 3.0 * u);
                        relative = relative.max(u / value);
                    }
                    _ => {}
                }
            });
        }
        let share = |part: usize| part as f64 / count as f64;
        let mut figure = format!("{:.0} % true, {:.0} ms", 100.0 * share(sound), 1e3 * longest);
        if open > 0 {
            write!(figure, ", {:.0} % above {:.0} kohm", 100.0 * share(open), 1e-3 * lowest).unwrap();
        }
        if relative > 0.0 {
            write!(figure, ", u up to {:.0} %", 100.0 * relative).unwrap();
        }
        let expected = method != Method::Qerm;
        it.cell(method, figure, share_below(count - sound, count, 0.03) & (longest < 0.2).into(), expected);
    }
    it.why = "a discharge through 10 Mohm takes seconds. Waiting ends at the deadline; then Rc1 finishes the discharge of `tracked`, which \
              knows it to some percent."
        .to_owned();
    it
}
