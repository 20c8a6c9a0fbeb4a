//! Where a switch makes a method fail: made too late, counted by another clock than the crossings, made too early, or made
//! now and not the next time.

use crate::by_hand::ByHand;
use crate::common::chance::{Figure, Verdict, mean_of, share_below};
use crate::common::{read, records, settle};
use crate::paper::{self, Noise, Parts, R_O, Times, V_DD, normal_below};
use crate::scenario::{Board, FIRST_ORDER, Scenario, is_true, percent, rms, truth};
use cermd::circuit::Node;
use cermd::pins::{Drives, Pins};
use cermd::reading::{Branch, Method, Status};
use cermd::units::Nanos;

/// Latency of `pi4`: stamp, wake-up, half the call that switches.
pub const STAMP: f64 = 8e-6;
/// On average, the line moves so long after its call has begun.
pub const HALF_CALL: f64 = 0.6e-6;
const REACTION: f64 = STAMP + 53e-6 + HALF_CALL;
const REACTION_JITTER: f64 = 5.2e-6;
pub const PI4_NOISE: Noise = Noise { jitter: 1.5e-6, voltage: 0.5e-3 };

const DISCHARGES: usize = 400;

/// In how many of [`DISCHARGES`] B crosses before a switch that is made when the edge of A has come.
fn too_late(board: &Board, r_ohm: f64, seed: u64) -> usize {
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
    late.count()
}

/// How many planned switches came too late for the last node, of how many.
fn behind(board: &Board, method: Method, r_ohm: f64) -> [usize; 2] {
    let mut instrument = board.bench(method, r_ohm, 1).instrument();
    settle(&mut instrument);
    let (mut planned, mut behind) = (0, 0);
    for record in records(&mut instrument, 2000) {
        let last_ns = record.b_ns.or(record.a_ns);
        if let (Some(_), Some(switch), Some(last_ns)) = (record.through.channel(), record.switch, last_ns) {
            planned += 1;
            behind += usize::from(last_ns - 1e9 * STAMP <= switch.on_ns);
        }
    }
    assert!(planned > 300, "{planned}");
    [behind, planned]
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
        // Where in its call the line moves scatters.
        let doubt = HALF_CALL;
        let share = |reaction: f64| normal_below((reaction - window(r_ohm)) / REACTION_JITTER);
        it.expect_share(
            format!("{r_ohm:.0} ohm: B crosses first"),
            too_late(&board, r_ohm, 1),
            DISCHARGES,
            share(REACTION - doubt)..=share(REACTION + doubt),
        );
    }
    let late = too_late(&board, 1000.0, 1);
    it.expect_share("1 kohm: B crosses first", late, DISCHARGES, 1.0..=1.0);
    let figure = format!("in reaction: B first in {:.0} %", 100.0 * late as f64 / DISCHARGES as f64);
    it.published(Method::Cerm, figure, share_below(late, DISCHARGES, 0.01), false);
    for method in [Method::Cerm, Method::Tracked] {
        let errors = board.errors(method, 1000.0, 40, 100);
        let [behind, planned] = behind(&board, method, 1000.0);
        let in_time = 100.0 * (1.0 - behind as f64 / planned as f64);
        let figure = format!("planned: in time in {in_time:.0} %, {}", truth(&errors, 1000.0));
        it.cell(method, figure, share_below(behind, planned, 0.01) & is_true(&errors), true);
        if method == Method::Cerm {
            let times = Times::of(&parts, 1000.0, 0.9 * g_a * 1040.0);
            let noise = PI4_NOISE.of_times(&parts, parts.r_c2);
            let predicted = times.scatter(noise, |times| paper::cerm(&parts, times));
            // It has the error of its offset besides, as with the clock.
            it.expect("planned: error of CERM, of the predicted", errors.rms_ratio(predicted), 1.0, 0.1);
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
                let bias = uncorrected.errors(method, r_ohm, 40, 100).mean_error();
                let predicted = bias_of_offset(&board.parts, method, STAMP, r_ohm);
                let what = format!("{}, {r_ohm} ohm: bias, ohm", method.as_str());
                it.expect(what, bias, predicted, FIRST_ORDER * predicted.abs());
                if r_ohm == 1000.0 {
                    it.published(method, percent(bias.value / r_ohm), bias.within(0.002 * r_ohm), false);
                }
            }
        }
        let errors = board.errors(method, 1000.0, 40, 100);
        let figure =
            format!("{}{}", if switches { "offset found " } else { "" }, percent(errors.mean() / 1000.0));
        it.cell(method, figure, errors.mean_error().within(2.0), true);
    }
    it.why = "a switch is a call of our own and is not late; only crossings are. In differences of crossings the lateness cancels, \
              in eq. (16) it does not: the bias is -2 d/(g_A + g_B) (Rc2 - Rx)/(Rc2 + Ro). Split calibration finds d."
        .to_owned();
    it
}

/// Changes of branch, by reading, of the branches seen.
fn changes(board: &Board, method: Method, r_ohm: f64, seeds: u64) -> Figure {
    let mut shares = Vec::new();
    for seed in 0..seeds {
        let (mut changes, mut readings) = (0usize, 0usize);
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
        shares.push(changes as f64 / readings as f64);
    }
    mean_of(&shares)
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
    let [above, below] =
        [1.0, 0.0].map(|t_l| fixed(0.0, t_l).errors(Method::Cerm, r_l, 20, 200).mean_error());
    let jump = above.less(below);
    let predicted = bias_of_offset(&parts, Method::Cerm, STAMP, r_l);
    it.expect("as printed: jump of the mean, ohm", jump, predicted, FIRST_ORDER * predicted.abs());
    let chatter = changes(&fixed(STAMP, t_l), Method::Cerm, r_l, 20);
    it.promise("fixed T_L: changes of branch by reading, about half", chatter, 0.4..=0.6);
    let [jumps, change] = [jump.value, 100.0 * chatter.value];
    it.published(
        Method::Cerm,
        format!("the mean jumps by {jumps:.1} ohm; fixed T_L: {change:.0} % change"),
        chatter.below(0.05),
        false,
    );
    let direct = board.with("t-l = \"0 ns\"").errors(Method::Cerm, r_l, 40, 100);
    let inferred = board.with("t-l = \"1 s\"").errors(Method::Cerm, r_l, 40, 100);
    let ratio = inferred.rms_ratio(1.0).over(direct.rms_ratio(1.0));
    it.expect("offset found: errors of both branches", ratio, 1.0, FIRST_ORDER);
    let jump = inferred.mean_error().less(direct.mean_error());
    it.expect("offset found: jump of the mean, ohm", jump, 0.0, 0.0);
    for method in [Method::Qerm, Method::Cerm, Method::Tracked] {
        let (mut most, mut worst_coverage) = (0.0f64, 1.0f64);
        let mut holds = Verdict::from(true);
        for step in 0..16 {
            // From a third of it to three times: wherever this method's own threshold is.
            let r_ohm = r_l * 3f64.powf(f64::from(step) / 7.5 - 1.0);
            let (changes, within) =
                (changes(&board, method, r_ohm, 8), board.errors(method, r_ohm, 8, 50).within_2u());
            holds = holds & changes.below(0.05) & within.times(-1.0).below(-0.85);
            most = most.max(changes.value);
            worst_coverage = worst_coverage.min(within.value);
        }
        let figure =
            format!("{:.1} % change at the most, {:.0} % in 2u", 100.0 * most, 100.0 * worst_coverage);
        it.cell(method, figure, holds, true);
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
    let switch = mean_of(&cycles.iter().map(|times| times.switch).collect::<Vec<_>>()).value;
    let away = switch * (parts.r_c2 + R_O) / 1040.0 / (2f64.sqrt() * sigma);
    let as_planned = Figure::exact(away);
    it.expect(
        "the denominator's distance from zero, in sigma",
        as_planned,
        DENOMINATOR,
        FIRST_ORDER * DENOMINATOR,
    );
    let found: Vec<f64> = cycles.iter().map(|times| paper::cerm(&parts, times)).collect();
    let count = |of: &dyn Fn(f64) -> bool| found.iter().filter(|r| of((**r + R_O) / 1040.0)).count();
    let (negative, far) = (count(&|ratio| ratio < 0.0), count(&|ratio| !(0.5..1.5).contains(&ratio)));
    // The sigma in which it is so far away is of first order.
    let predicted = |of: &dyn Fn(f64) -> f64| of(away * (1.0 + FIRST_ORDER))..=of(away * (1.0 - FIRST_ORDER));
    let of_negative = predicted(&|away| normal_below(-away));
    let of_far = predicted(&|away| normal_below(-away / 3.0) + normal_below(-away));
    it.expect_share("as printed: below zero", negative, found.len(), of_negative);
    it.expect_share("as printed: off by half", far, found.len(), of_far);
    let percent = |count: usize| 100.0 * count as f64 / found.len() as f64;
    it.published(
        Method::Cerm,
        format!("{:.0} % off by half, {:.0} % below zero", percent(far), percent(negative)),
        share_below(far, found.len(), 0.001),
        false,
    );
    let fraction = switch / (parts.g()[0] * 1040.0);
    for method in [Method::Cerm, Method::Tracked] {
        let errors = board.with(&format!("switch-fraction = {fraction:.5}")).errors(method, 1000.0, 20, 100);
        it.cell(method, truth(&errors, 1000.0), is_true(&errors) & (errors.max() < 500.0).into(), true);
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
        let negative = cycles.iter().filter(below).count();
        let predicted = |by: f64| normal_below(-1.0 / (by * sigma));
        let what = format!("{} as printed: below zero", method.as_str());
        let range = predicted(1.0 - FIRST_ORDER)..=predicted(1.0 + FIRST_ORDER);
        it.expect_share(what, negative, cycles.len(), range);
        let figure = format!("{:.0} % below zero", 100.0 * negative as f64 / cycles.len() as f64);
        it.published(method, figure, share_below(negative, cycles.len(), 0.001), false);
    }
    for method in Method::ALL {
        let (mut sound, mut short, mut count, mut negative) = (0usize, 0usize, 0usize, 0usize);
        for seed in 0..20 {
            let mut instrument = board.bench(method, 1.0, seed).instrument();
            settle(&mut instrument);
            read(&mut instrument, 60, |_| {});
            read(&mut instrument, 100, |reading| {
                count += 1;
                match reading.status {
                    Status::Ok { r_ohm, .. } => {
                        negative += usize::from(r_ohm.value < 0.0);
                        sound += usize::from((r_ohm.value - 1.0).abs() <= 3.0 * r_ohm.u.unwrap());
                    }
                    Status::Short { r_max_ohm, .. } => {
                        short += 1;
                        sound += usize::from(r_max_ohm >= 1.0);
                    }
                    _ => {}
                }
            });
        }
        let share = |part: usize| part as f64 / count as f64;
        let figure = format!("{:.0} % short, {:.0} % true", 100.0 * share(short), 100.0 * share(sound));
        it.cell(method, figure, share_below(count - sound, count, 0.1) & (negative == 0).into(), true);
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
    assert!((normal_below(-2.0) - 0.022_750_132).abs() < 1e-8 && rms_of_one());
}

fn rms_of_one() -> bool {
    let mut errors = crate::common::Errors::default();
    errors.errors = vec![3.0, -4.0];
    (rms(&errors) - 12.5f64.sqrt()).abs() < 1e-12
}
