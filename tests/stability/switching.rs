//! Where a switch makes a method fail: made too late, counted by another clock than the crossings, made too early, or made
//! now and not the next time.

use crate::common::{read, records, settle};
use crate::paper::{self, Noise, Parts, R_O, Times, V_DD, normal_below};
use crate::scenario::{Board, ByHand, Scenario, is_true, moments, percent, rms, truth};
use cermd::circuit::Node;
use cermd::pins::{Drives, Pins};
use cermd::reading::{Branch, Method, Status};
use cermd::units::Nanos;

/// Latency of `pi4`: stamp, wake-up, half the call that switches.
pub const STAMP: f64 = 8e-6;
const REACTION: f64 = STAMP + 53e-6 + 0.6e-6;
const REACTION_JITTER: f64 = 5.2e-6;
pub const PI4_NOISE: Noise = Noise { jitter: 1.5e-6, voltage: 0.5e-3 };

/// The share of discharges in which B crosses before a switch that is made when the edge of A has come.
fn too_late(board: &Board, r_ohm: f64, seed: u64) -> f64 {
    const DISCHARGES: usize = 400;
    let mut pins = ByHand::new(board, r_ohm, seed).pins;
    let late = (0..DISCHARGES).filter(|_| {
        pins.drive(Drives::CHARGE).unwrap();
        let charged = pins.now() + Nanos(2_000_000);
        pins.sleep_until(charged).unwrap();
        pins.drive(Drives::NONE).unwrap();
        pins.arm().unwrap();
        pins.drive(Drives::x(0)).unwrap();
        pins.edge(Nanos::MAX).unwrap();
        pins.drive(Drives::C2).unwrap();
        let changes = pins.truth().changes();
        let (released_ns, _) = changes.iter().find(|(_, on)| !on.contains(Drives::x(0))).unwrap();
        let is_late = pins.truth().crossing_ns(Node::B).is_some_and(|b_ns| b_ns < *released_ns);
        pins.drive(Drives::NONE).unwrap();
        is_late
    });
    late.count() as f64 / DISCHARGES as f64
}

/// The share of planned switches after which the last node crosses.
fn in_time(board: &Board, method: Method, r_ohm: f64) -> f64 {
    let mut instrument = board.bench(method, r_ohm, 1).instrument();
    settle(&mut instrument);
    let (mut planned, mut in_time) = (0, 0);
    for record in records(&mut instrument, 2000) {
        let last_ns = record.b_ns.or(record.a_ns);
        if let (Some(_), Some(switch), Some(last_ns)) = (record.through.channel(), record.switch, last_ns) {
            planned += 1;
            in_time += i32::from(last_ns - 1e9 * STAMP > switch.on_ns);
        }
    }
    assert!(planned > 300, "{planned}");
    f64::from(in_time) / f64::from(planned)
}

pub fn reaction() -> Scenario {
    let parts = Parts { v_th: 1.1, ..Parts::PAPER };
    let board = Board::quiet(parts);
    let mut it = Scenario::new(
        "CERM switched in reaction to the edge of A: the paper's 330 nF / 22 nF, 1 kohm",
        "the switch comes before B, and the numbers are true",
        "0..40",
    );
    let [g_a, g_b] = parts.g();
    let window = |r: f64| (g_b - g_a) * (r + R_O);
    let bound = REACTION / (g_b - g_a) - R_O;
    for share in [0.75, 1.0, 1.25] {
        let r_ohm = share * bound;
        let predicted = normal_below((REACTION - window(r_ohm)) / REACTION_JITTER);
        let found = too_late(&board, r_ohm, 1);
        // Four standard errors of 400 discharges, and 0.5 us of doubt in the mean reaction.
        it.expect(
            format!("{r_ohm:.0} ohm: B crosses first"),
            found,
            (predicted - 0.14).max(0.0)..=(predicted + 0.14).min(1.0),
        );
    }
    let late = too_late(&board, 1000.0, 1);
    it.expect("1 kohm: B crosses first", late, 0.999..=1.0);
    it.cell(Method::Cerm, format!("in reaction: B first in {:.0} %", 100.0 * late), late < 0.01, false);
    for method in [Method::Cerm, Method::Tracked] {
        let errors = board.errors(method, 1000.0, 40, 100);
        let in_time = in_time(&board, method, 1000.0);
        let figure = format!("planned: in time in {:.0} %, {}", 100.0 * in_time, truth(&errors, 1000.0));
        it.cell(method, figure, in_time > 0.99 && is_true(&errors), true);
        if method == Method::Cerm {
            let times = Times::of(&parts, 1000.0, 0.9 * g_a * 1040.0);
            let noise = PI4_NOISE.of_times(&parts, parts.r_c2);
            let predicted = times.scatter(noise, |times| paper::cerm(&parts, times));
            it.expect("planned: error of CERM, of the predicted", errors.sd() / predicted, 0.9..=1.1);
        }
    }
    let longest = parts.c * (parts.r_series() / parts.r_c2).ln() * (parts.r_series() + R_O);
    it.why = format!(
        "from A's crossing to B's there are {:.1} us at 1 kohm; an edge takes {:.0} us to the program and a call. Below {:.1} kohm B \
         comes first. (QERM's node between Rc1 and Rc2 would give {:.0} us at the most.) A planned switch needs no reaction.",
        1e6 * window(1000.0),
        1e6 * REACTION,
        1e-3 * bound,
        1e6 * longest
    );
    it
}

/// -2 d/(g_A + g_B) (Rc2 - Rx)/(Rc2 + Ro) of CERM; QERM has one g, and Rc1 + Rc2.
pub fn bias_of_offset(parts: &Parts, method: Method, d: f64, r_x: f64) -> f64 {
    let (g, last) = match method {
        Method::Qerm => (parts.g_single(), parts.r_series()),
        _ => (parts.g().iter().sum::<f64>() / 2.0, parts.r_c2),
    };
    -d / g * (last - r_x) / (last + R_O)
}

pub fn offset() -> Scenario {
    let board = Board::quiet(Parts::PI4);
    let mut it = Scenario::new(
        "Stamps 8 us late, switches not: 1 kohm",
        "the mean is off by less than 0.2 %",
        "0..40",
    );
    for method in Method::ALL {
        let switches = matches!(method, Method::Qerm | Method::Cerm);
        if switches {
            for r_ohm in [100.0, 1000.0, 5000.0] {
                let uncorrected = board.with("offset = \"0 us\"\nt-l = \"1 s\"");
                let bias = uncorrected.errors(method, r_ohm, 40, 100).mean();
                let predicted = bias_of_offset(&board.parts, method, STAMP, r_ohm);
                it.expect(
                    format!("{}, {r_ohm} ohm: bias, of the predicted {predicted:.2} ohm", method.as_str()),
                    bias / predicted,
                    0.95..=1.05,
                );
                if r_ohm == 1000.0 {
                    it.cell(
                        method,
                        format!("as printed {}", percent(bias / r_ohm)),
                        bias.abs() < 0.002 * r_ohm,
                        false,
                    );
                }
            }
        }
        let errors = board.errors(method, 1000.0, 40, 100);
        let figure =
            format!("{}{}", if switches { "offset found " } else { "" }, percent(errors.mean() / 1000.0));
        it.cell(method, figure, errors.mean().abs() < 2.0, true);
    }
    it.why = "a switch is a call of our own and is not late; only crossings are. In differences of crossings the lateness cancels, \
              in eq. (16) it does not: the bias is -2 d/(g_A + g_B) (Rc2 - Rx)/(Rc2 + Ro). Split calibration finds d."
        .to_owned();
    it
}

/// Changes of branch, by reading, of the branches seen.
fn changes(board: &Board, method: Method, r_ohm: f64, seeds: u64) -> f64 {
    let (mut changes, mut readings) = (0usize, 0usize);
    for seed in 0..seeds {
        let mut instrument = board.bench(method, r_ohm, seed).instrument();
        settle(&mut instrument);
        read(&mut instrument, 60, |_| {});
        let mut last = None;
        read(&mut instrument, 100, |reading| {
            if let Status::Ok { branch, .. } = reading.status {
                changes += usize::from(last.is_some_and(|last: Branch| last != branch));
                readings += 1;
                last = Some(branch);
            }
        });
    }
    changes as f64 / readings as f64
}

/// Where a discharge in full and a switched one have the same predicted scatter.
fn crossover(parts: &Parts, noise: Noise, fraction: f64) -> f64 {
    let excess = |r: f64| {
        let full = Times::of(parts, r, 0.0);
        let split = Times::of(parts, r, fraction * parts.g()[0] * (r + R_O));
        full.scatter(noise.of_times(parts, r), |times| paper::tcdic(parts, times))
            - split.scatter(noise.of_times(parts, parts.r_c2), |times| paper::cerm(parts, times))
    };
    let (mut low, mut high) = (10.0, 12_000.0);
    for _ in 0..60 {
        let middle = (low + high) / 2.0;
        if excess(middle) > 0.0 { low = middle } else { high = middle }
    }
    low
}

pub fn threshold() -> Scenario {
    let board = Board::quiet(Parts::PI4);
    let parts = board.parts;
    let [g_a, _] = parts.g();
    let r_l = crossover(&parts, PI4_NOISE, 0.9);
    let mut it = Scenario::new(
        "R_x at the threshold T_L",
        "mean and error go on across it; the branch changes in less than 5 % of readings",
        "0..20",
    );
    let t_l = g_a * (r_l + R_O);
    let fixed = |offset: f64, t_l: f64| {
        board.with(&format!("offset = \"{} us\"\nt-l = \"{} ns\"", 1e6 * offset, (t_l * 1e9).round()))
    };
    // Below and above T_L by a part in a thousand: the mean of one branch and of the other.
    let jump = fixed(0.0, 1.0).errors(Method::Cerm, r_l, 20, 200).mean()
        - fixed(0.0, 0.0).errors(Method::Cerm, r_l, 20, 200).mean();
    let predicted = bias_of_offset(&parts, Method::Cerm, STAMP, r_l);
    it.expect(
        format!("as printed: jump of the mean, of the predicted {predicted:.2} ohm"),
        jump / predicted,
        0.9..=1.1,
    );
    let chatter = changes(&fixed(STAMP, t_l), Method::Cerm, r_l, 20);
    it.expect("fixed T_L: changes of branch by reading, predicted 0.5", chatter, 0.4..=0.6);
    it.cell(
        Method::Cerm,
        format!("as printed: the mean jumps by {jump:.1} ohm; fixed T_L: {:.0} % change", 100.0 * chatter),
        chatter < 0.05,
        false,
    );
    let direct = board.with("t-l = \"0 ns\"").errors(Method::Cerm, r_l, 40, 100);
    let inferred = board.with("t-l = \"1 s\"").errors(Method::Cerm, r_l, 40, 100);
    it.expect("offset found: errors of both branches, predicted 1", inferred.sd() / direct.sd(), 0.9..=1.1);
    let [of_direct, of_inferred] =
        [&direct, &inferred].map(|errors| errors.sd() / (errors.count() as f64).sqrt());
    let standard_error = of_direct.hypot(of_inferred);
    it.expect(
        "offset found: jump of the mean, in standard errors",
        (inferred.mean() - direct.mean()) / standard_error,
        -4.0..=4.0,
    );
    for method in [Method::Qerm, Method::Cerm, Method::Tracked] {
        let mut most = 0.0f64;
        let mut worst_coverage = 1.0f64;
        for step in 0..16 {
            // From a third of it to three times: wherever this method's own threshold is.
            let r_ohm = r_l * 3f64.powf(f64::from(step) / 7.5 - 1.0);
            most = most.max(changes(&board, method, r_ohm, 8));
            worst_coverage = worst_coverage.min(board.errors(method, r_ohm, 8, 50).coverage());
        }
        let figure =
            format!("{:.1} % change at the most, {:.0} % in 2u", 100.0 * most, 100.0 * worst_coverage);
        it.cell(method, figure, most < 0.05 && worst_coverage > 0.85, true);
    }
    it.why = format!(
        "on a fixed threshold noise alone decides, half of the time each way, and an offset left in shows in one branch only. The \
         branch in use stays until the other promises 20 % less variance; both agree at {r_l:.0} ohm here."
    );
    it
}

/// How many standard deviations the denominator of (16) is away from zero.
const DENOMINATOR: f64 = 2.0;

pub fn denominator() -> Scenario {
    let board = Board::quiet(Parts::PI4);
    let parts = board.parts;
    let [_, sigma] = PI4_NOISE.sigma(&parts, parts.r_c2);
    let d = DENOMINATOR * 2f64.sqrt() * sigma;
    // A sleep ends 0.3 us late.
    let switch = d * 1040.0 / (parts.r_c2 + R_O) - 0.35e-6;
    let mut it = Scenario::new(
        "Switched too early: the denominator of (16), T_c2B - T_c2,x, at two of its own sigma; 1 kohm",
        "no number is off by half, none is negative",
        "1",
    );
    let mut by_hand = ByHand::new(&board, 1000.0, 1);
    by_hand.offset = STAMP;
    let cycles = by_hand.cycles(4000, Some(switch));
    let (switch, _) = moments(&cycles.iter().map(|times| times.switch).collect::<Vec<_>>());
    let away = switch * (parts.r_c2 + R_O) / 1040.0 / (2f64.sqrt() * sigma);
    it.expect(
        "the denominator's distance from zero, in sigma",
        away,
        0.97 * DENOMINATOR..=1.03 * DENOMINATOR,
    );
    let found: Vec<f64> = cycles.iter().map(|times| paper::cerm(&parts, times)).collect();
    let share = |of: &dyn Fn(f64) -> bool| {
        found.iter().filter(|r| of((**r + R_O) / 1040.0)).count() as f64 / found.len() as f64
    };
    let (negative, far) = (share(&|ratio| ratio < 0.0), share(&|ratio| !(0.5..1.5).contains(&ratio)));
    let (of_negative, of_far) = (normal_below(-away), normal_below(-away / 3.0) + normal_below(-away));
    it.expect("as printed: below zero, of the predicted", negative / of_negative, 0.6..=1.4);
    it.expect("as printed: off by half, of the predicted", far / of_far, 0.85..=1.15);
    it.cell(
        Method::Cerm,
        format!("as printed: {:.0} % off by half, {:.0} % below zero", 100.0 * far, 100.0 * negative),
        far < 0.001,
        false,
    );
    let fraction = switch / (parts.g()[0] * 1040.0);
    for method in [Method::Cerm, Method::Tracked] {
        let errors = board.with(&format!("switch-fraction = {fraction:.5}")).errors(method, 1000.0, 20, 100);
        it.cell(method, truth(&errors, 1000.0), errors.max() < 500.0 && is_true(&errors), true);
    }
    it.why = format!(
        "switched after {:.1} us, both times through Rc2 differ by {:.0} us only, less or more by their noise of {:.1} us each. The \
         predicted variance of both equations decides: a discharge in full is taken instead.",
        1e6 * switch,
        1e6 * d,
        1e6 * sigma
    );
    it
}

/// A force sensor of 2000 N ohm: 1 ohm is 2 kN.
const FORCES: f64 = 2000.0;

pub fn one_ohm() -> Scenario {
    let board = Board::quiet(Parts::PI4);
    let parts = board.parts;
    let mut it = Scenario::new(
        "1 ohm: the denominator of (27) near zero",
        "nothing is below zero, and the truth lies within the number's 3u or the bound of `short`",
        "0..20",
    );
    let mut by_hand = ByHand::new(&board, 1.0, 1);
    let cycles = by_hand.cycles(4000, None);
    let noise = PI4_NOISE.of_times(&parts, 1.0);
    let (f_n, exact) = ([FORCES / parts.r_c1, FORCES / parts.r_c2], Times::of(&parts, 1.0, 0.0));
    for (method, equation) in [(Method::Tpcm, paper::tpcm as paper::Equation), (Method::Tcdic, paper::tcdic)]
    {
        let sigma = exact.scatter(noise, |times| equation(&parts, times));
        let below = |times: &&Times| match method {
            Method::Tcdic => paper::force(times, f_n) < 0.0,
            _ => equation(&parts, times) < 0.0,
        };
        let share = cycles.iter().filter(below).count() as f64 / cycles.len() as f64;
        let predicted = normal_below(-1.0 / sigma);
        it.expect(
            format!("{} as printed: below zero, predicted {predicted:.3}", method.as_str()),
            share,
            predicted - 0.035..=predicted + 0.035,
        );
        it.cell(method, format!("as printed: {:.0} % below zero", 100.0 * share), share < 0.001, false);
    }
    for method in Method::ALL {
        let (mut sound, mut short, mut count, mut negative) = (0, 0, 0, 0);
        for seed in 0..20 {
            let mut instrument = board.bench(method, 1.0, seed).instrument();
            settle(&mut instrument);
            read(&mut instrument, 60, |_| {});
            read(&mut instrument, 100, |reading| {
                count += 1;
                match reading.status {
                    Status::Ok { r_ohm, .. } => {
                        negative += i32::from(r_ohm.value < 0.0);
                        sound += i32::from((r_ohm.value - 1.0).abs() <= 3.0 * r_ohm.u.unwrap());
                    }
                    Status::Short { r_max_ohm, .. } => {
                        short += 1;
                        sound += i32::from(r_max_ohm >= 1.0);
                    }
                    _ => {}
                }
            });
        }
        let share = |part: i32| f64::from(part) / f64::from(count);
        let figure = format!("{:.0} % short, {:.0} % true", 100.0 * share(short), 100.0 * share(sound));
        it.cell(method, figure, negative == 0 && share(sound) > 0.9, true);
    }
    it.why = "a resistance of less than its own uncertainty has a reciprocal that may be anything; it is `short`, with an upper bound \
              of R and a lower one of F."
        .to_owned();
    it
}

#[test]
fn the_law_is_that_of_the_circuit() {
    // Eq. (9) and (10), from the voltages: the charge of C_B's plate at B is shared with C_A.
    let parts = Parts::PI4;
    let (v_a, c_t) = (
        |theta: f64| V_DD * (-theta / (parts.c_a * parts.c_b / (parts.c_a + parts.c_b))).exp(),
        parts.c_a + parts.c_b,
    );
    let [g_a, g_b] = parts.g();
    assert!((v_a(g_a) - parts.v_th).abs() < 1e-12);
    assert!(((v_a(g_b) * parts.c_a + V_DD * parts.c_b) / c_t - parts.v_th).abs() < 1e-12);
    let times = Times::of(&parts, 1000.0, 0.5 * g_a * 1040.0);
    assert!((paper::cerm(&parts, &times) - 1000.0).abs() < 1e-9);
    let (mean, sd) = moments(&[1.0, 2.0, 3.0]);
    assert!((mean - 2.0).abs() < 1e-12 && (sd - 1.0).abs() < 1e-12);
    assert!((normal_below(-2.0) - 0.022_750_132).abs() < 1e-8 && rms_of_one());
}

fn rms_of_one() -> bool {
    let mut errors = crate::common::Errors::default();
    errors.errors = vec![3.0, -4.0];
    (rms(&errors) - 12.5f64.sqrt()).abs() < 1e-12
}
