//! Boards that nobody has chosen: circuit, processor, kernel, dielectrics, leaks and drifts are drawn at random, each effect within
//! what boards have, and so is the resistance. Whatever holds only for the boards that it was made with shows here.

use crate::common::chance::{Figure, share_is_in};
use crate::common::config::ConfigFile;
use crate::common::{Bench, Errors, check_page, file_for, next_with_truth, seed, times};
use cermd::pins::Pins;
use cermd::pins::sim::{Kind, Scene};
use cermd::reading::Method;
use cermd::units::Nanos;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::fmt::Write;
use std::path::Path;

/// Of each method. `CERMD_BOARDS=10` draws ten times as many.
const BOARDS: u64 = 100;
/// Each is read from its start to this.
const END: Nanos = Nanos(10_000_000_000);
/// The share within two sigma that is promised of the readings that are numbers.
const PROMISED: f64 = 0.93;
/// On one board most of what is off is the same in all readings, so that one of 20 may be off by twice its sigma in all of them: of
/// boards with a smaller share than this there are no more than that.
const FEW: f64 = 0.8;
const FEW_BOARDS: f64 = 0.05;
/// Of the numbers that do not say that they move or settle, beyond ten sigma.
const WILD: f64 = 1e-5;
/// The same where the sensor moves: a stamp that is late as the sensor would have moved looks like it.
const WILD_IN_MOTION: f64 = 1e-4;

/// What a sensor does, as a scene says it.
type Sensor = fn(&mut Draw) -> String;
/// What a configuration asks for, and of how many sensors.
type Asked = fn(&mut Draw, &mut ConfigFile) -> usize;

struct Draw(ChaCha8Rng);

impl Draw {
    fn linear(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.0.random::<f64>()
    }

    /// Each decade as likely as the others.
    fn decades(&mut self, from: f64, to: f64) -> f64 {
        self.linear(from.ln(), to.ln()).exp()
    }

    fn is(&mut self, probability: f64) -> bool {
        self.0.random_bool(probability)
    }

    /// A table of delays, s.
    fn delays(&mut self, name: &str, [mean, jitter]: [f64; 2]) -> String {
        let (probability, tail) = (self.decades(1e-4, 1e-2), self.decades(10e-6, 200e-6));
        format!(
            "[{name}]\nmean = '{mean} s'\njitter = '{} s'\ntail-probability = {probability}\ntail-mean = '{tail} s'\n",
            jitter.min(mean)
        )
    }
}

/// The circuit, as it is and as the configuration says it, whose resistors somebody has measured; and how long its discharge takes for
/// each ohm of the sensor, at most, s.
fn circuit(draw: &mut Draw, kind: Kind, method: Method) -> (String, ConfigFile, f64) {
    let r_c1 = draw.decades(220.0, 2400.0);
    let r_c2 = draw.decades(5.0 * r_c1, (6.0 * r_c1).max(25e3));
    let (r_p, r_o) = (draw.decades(220.0, 470.0), draw.linear(15.0, 80.0));
    let known = format!("r-c1 = '{r_c1:.1} ohm'\nr-c2 = '{r_c2:.1} ohm'\n");
    let ([named, real], seconds_per_ohm) = match kind {
        Kind::TwoCapacitor => {
            let (a, ratio) = (draw.decades(0.68e-6, 4.7e-6), draw.linear(2.5, 5.0));
            let real = (a * draw.linear(0.9, 1.1), a / ratio * draw.linear(0.9, 1.1));
            let lines = [(a, a / ratio), real].map(|(a, b)| format!("c-a = '{a} F'\nc-b = '{b} F'\n"));
            (lines, 2.5 * a / (1.0 + ratio))
        }
        Kind::OneCapacitor | Kind::SeriesCalibration => {
            let c = draw.decades(0.22e-6, 2.2e-6);
            ([c, c * draw.linear(0.9, 1.1)].map(|c| format!("c = '{c} F'\n")), 1.3 * c)
        }
    };
    let falling = draw.linear(0.95, 1.5);
    let rising = falling + draw.linear(0.05, 0.4);
    let mut scene = format!(
        "[circuit]\nkind = '{kind}'\nv-dd = '3.3 V'\nr-p = '{r_p} ohm'\nr-o = '{r_o} ohm'\n{known}{real}\
         threshold = {{ falling = '{falling} V', rising = '{rising} V' }}\n"
    );
    let nodes: &[&str] = if kind == Kind::TwoCapacitor { &["a", "b"] } else { &["a"] };
    for node in nodes {
        if draw.is(0.25) {
            let leak = draw.decades(1e6, 200e6);
            let to = if draw.is(0.5) { "leakage-resistance" } else { "pull-up" };
            writeln!(scene, "[circuit.node-{node}]\n{to} = '{leak} ohm'").unwrap();
        }
    }
    if draw.is(0.5) {
        scene += "[circuit.absorption]\n";
        let capacitors: &[&str] = if kind == Kind::TwoCapacitor { &["c-a", "c-b"] } else { &["c"] };
        for capacitor in capacitors {
            let (share, tau) = (draw.decades(1e-5, 2.5e-3), draw.decades(100e-6, 1.0));
            writeln!(scene, "{capacitor} = [{{ share = {share}, tau = '{tau} s' }}]").unwrap();
        }
    }
    let lines = format!("{known}{named}r-charge = '{r_p} ohm'\n");
    (scene, file_for(kind, method, &lines, "pi4"), seconds_per_ohm)
}

/// The processor and its kernel, and what changes with time.
fn surroundings(draw: &mut Draw, kind: Kind) -> String {
    let (fixed, per_line, jitter) =
        (draw.decades(0.1e-6, 3e-6), draw.decades(0.2e-6, 6e-6), draw.decades(0.01, 0.2));
    let from = draw.linear(0.0, 1.5);
    let (to, tail) = (from + draw.linear(0.0, 1.0), draw.decades(10e-6, 200e-6));
    let mut scene = format!(
        "[calls]\nfixed = '{fixed} s'\nper-line = '{per_line} s'\njitter = {jitter}\nmoves-at = [{from}, {to}]\n\
         tail-probability = {}\ntail-mean = '{tail} s'\n[reads]\nclock = '50 ns'\nlevels = '1 us'\narm = '1.2 us'\n\
         [noise]\nvoltage = '{} V'\n",
        draw.decades(1e-4, 1e-2),
        draw.decades(0.05e-3, 1.5e-3),
    );
    let stamps = [draw.decades(2e-6, 50e-6), draw.decades(0.2e-6, 6e-6)];
    let wake = [draw.linear(20e-6, 200e-6), 5e-6];
    for (name, delay) in [("stamps", stamps), ("wake", wake), ("sleep", [0.3e-6, 0.1e-6])] {
        scene += &draw.delays(name, delay);
    }
    if draw.is(0.5) {
        let (c, v_th) = (draw.linear(-0.01, 0.01), draw.linear(-5e-3, 5e-3));
        writeln!(scene, "[drift]\nc-per-minute = {c}\nv-th-per-minute = '{v_th} V'").unwrap();
    }
    if draw.is(0.3) {
        writeln!(scene, "[walk]\nr-o = '{} ohm'", draw.decades(0.003, 0.3)).unwrap();
    }
    if kind == Kind::TwoCapacitor && draw.is(0.3) {
        writeln!(scene, "[events]\nb-later = '{} s'", draw.linear(0.2e-6, 4e-6)).unwrap();
    }
    scene
}

/// A constant resistor.
fn resting(draw: &mut Draw) -> String {
    format!("constant = '{} ohm'", draw.decades(50.0, 30e3))
}

/// A hand, an oscillation, or a way from one resistance to another.
fn moving(draw: &mut Draw) -> String {
    let (from, to) = (draw.decades(100.0, 30e3), draw.decades(100.0, 30e3));
    match draw.linear(0.0, 3.0) as usize {
        0 => {
            let (peak, period) = (draw.decades(1.0, 30.0), draw.linear(1.0, 4.0));
            format!("hand = {{ peak = '{peak} N', period = '{period} s' }}")
        }
        1 => {
            let (amplitude, hertz) = (from * draw.linear(0.02, 0.3), draw.decades(0.2, 4.0));
            format!(
                "sine = {{ mean = '{from} ohm', amplitude = '{amplitude} ohm', frequency = '{hertz} Hz' }}"
            )
        }
        _ => {
            let (start, duration) = (draw.linear(0.0, 5.0), draw.linear(0.5, 5.0));
            format!(
                "ramp = {{ from = '{from} ohm', to = '{to} ohm', start = '{start} s', duration = '{duration} s' }}"
            )
        }
    }
}

/// As many readings as can be had.
fn plainly(_: &mut Draw, _: &mut ConfigFile) -> usize {
    1
}

/// Means over a time, a rate, no more discharges than a rate needs, or several sensors; answers how many.
fn in_every_way(draw: &mut Draw, config: &mut ConfigFile) -> usize {
    let (time, rate) = (draw.decades(0.01, 1.0), draw.decades(1.0, 60.0));
    let sensors = 2 + draw.linear(0.0, 3.0) as usize;
    let way = draw.linear(0.0, 4.0) as usize;
    match way {
        0 => config.set("measure.average", format!("{time} s")),
        1 => config.set("measure.rate-hz", rate),
        2 => config.set("measure.rate-hz", rate).set("measure.idle", true),
        _ => config,
    };
    let sensors = if way < 3 { 1 } else { sensors };
    for sensor in 1..sensors {
        let id = format!("y{sensor}");
        config.channel(&id);
        if draw.is(0.5) {
            config.set(&format!("channel.{id}.every"), draw.linear(2.0, 12.0) as i64);
        }
    }
    sensors
}

/// A board that is drawn, with its sensors.
struct Board {
    number: u64,
    bench: Bench,
    /// Of a discharge, at most.
    seconds_per_ohm: f64,
}

impl Board {
    fn draw(number: u64, kind: Kind, method: Method, sensor: Sensor, asked: Asked) -> Board {
        let mut draw = Draw(seed::rng(number));
        let (circuit, mut config, seconds_per_ohm) = circuit(&mut draw, kind, method);
        let mut scene = circuit + &surroundings(&mut draw, kind);
        for _ in 0..asked(&mut draw, &mut config) {
            writeln!(scene, "[[sensor]]\n{}", sensor(&mut draw)).unwrap();
        }
        let scene =
            Scene::parse(&scene, Path::new("drawn")).unwrap_or_else(|error| panic!("{error}\n{scene}"));
        Board { number, bench: Bench { scene, config, seed: number }, seconds_per_ohm }
    }

    /// What it reads, except where the sensor changes so fast that a discharge has no one true value.
    fn read(&self) -> Errors {
        let (mut instrument, mut errors) = (self.bench.instrument(), Errors::default());
        errors.next_board();
        while instrument.pins().now() < END {
            next_with_truth(&mut instrument, self.seconds_per_ohm, |reading, truth| {
                errors.add(reading, truth)
            });
        }
        errors
    }
}

/// What became of the boards of a method.
#[derive(Default)]
struct Seen {
    boards: usize,
    few: usize,
    all: Errors,
}

impl Seen {
    fn add(&mut self, board: &Board) {
        let errors = board.read();
        self.boards += 1;
        if errors.count() > 0 {
            let share = errors.coverage();
            let (number, count, wild) = (board.number, errors.count(), errors.wild);
            let sensors = &board.bench.scene.sensors;
            println!("{number}: {sensors:?}, {count} numbers, {share:.3} within 2u, {wild} wild");
            self.few += usize::from(share < FEW);
        }
        self.all.add_board(errors);
    }

    fn row(&self, name: &str) -> String {
        let Errors { wild, not_ok, .. } = &self.all;
        let numbers = self.all.count();
        let (share, pulls) = (100.0 * self.all.coverage(), self.all.pulls().value);
        let states = 100.0 * not_ok.len() as f64 / (numbers + not_ok.len()) as f64;
        format!(
            "| {name} | {} | {numbers} | {states:.0} | {share:.1} | {pulls:.2} | {} | {wild} |\n",
            self.boards, self.few
        )
    }

    fn holds(&self, wild: f64) -> bool {
        let share: Figure = self.all.within_2u();
        println!("within 2u {share}, on few boards {} of {}, wild {}", self.few, self.boards, self.all.wild);
        share.is_in(PROMISED..=1.0)
            && share_is_in(self.few, self.boards, 0.0..=FEW_BOARDS)
            && share_is_in(self.all.wild, self.all.count(), 0.0..=wild)
    }
}

const HEAD: &str = "# Boards that nobody has chosen\n
Each board of this page is drawn at random: its wiring and parts, how long calls take and when lines move in them, how late stamps are and
how much that scatters, noise, thresholds, 1 to 200 Mohm from either node to ground or to the supply, capacitors that absorb up to 0.25 % with
any time constant from 0.1 ms to 1 s, drifts, and the resistance, from 50 ohm to 30 kohm. Each is read for ten seconds, the first reading
included. All of it is **simulated**; written by `UPDATE_DOCS=1 cargo test --test accuracy drawn`, do not edit. Another family
of seeds (`CERMD_SEED=1`) draws other boards, for which the test holds as well.

*states*: readings that are none, such as `open` above what the deadline lets wait for, in percent. *within 2u*: of the numbers, in
percent; 95.4 is exact. *rms*: of the errors in units of their own sigma, the mean over boards (1 is exact, less is an uncertainty too
wide). *few*: boards on which fewer than 80 % are within 2u; what is off on a board is mostly the same in all its readings, so that one
board in 20 may have few. *beyond 10 u*: of the numbers that do not say that they move or settle.
";

const MOTION: &str = "
## Sensors that move

The same boards with what moves: a hand that presses an FSR 402 with 1 to 30 N, every one to four seconds; an oscillation of 0.2 to
4 Hz and 2 to 30 %; a way from one resistance between 100 ohm and 30 kohm to another within 0.5 to 5 s. Readings of a sensor that changes
by more than a tenth within its discharge have no one true value and are not counted.
";

const WAYS: &str = "
## Asked in other ways

The first boards again, with sensors at rest: each with a mean over 10 ms to 1 s, a rate of 1 to 60 Hz, such a rate with `idle`, or two to
four sensors, half of which are read only in every second to eleventh cycle.
";

const COLUMNS: &str = "
| method | boards | numbers | states / % | within 2u / % | rms | few | beyond 10 u |
|---|--:|--:|--:|--:|--:|--:|--:|\n";

/// Method and wiring, by name.
const CASES: [(&str, Kind, Method); 6] = [
    ("tracked", Kind::TwoCapacitor, Method::Tracked),
    ("tracked, one node", Kind::OneCapacitor, Method::Tracked),
    ("cerm", Kind::TwoCapacitor, Method::Cerm),
    ("tcdic", Kind::TwoCapacitor, Method::Tcdic),
    ("tpcm", Kind::OneCapacitor, Method::Tpcm),
    ("qerm", Kind::SeriesCalibration, Method::Qerm),
];

/// A line for each method, and the methods for which what is stated does not hold.
fn table(sensor: Sensor, asked: Asked, wild: f64) -> (String, Vec<&'static str>) {
    let (mut table, mut wrong) = (String::new(), Vec::new());
    for (name, kind, method) in CASES {
        let mut seen = Seen::default();
        (0..BOARDS * times()).for_each(|number| seen.add(&Board::draw(number, kind, method, sensor, asked)));
        table += &seen.row(name);
        if !seen.holds(wild) {
            wrong.push(name);
        }
    }
    print!("{table}");
    (table, wrong)
}

#[test]
fn what_is_stated_holds_on_boards_that_are_drawn_at_random() {
    let (rest, wrong) = table(resting, plainly, WILD);
    let (motion, wrong_in_motion) = table(moving, plainly, WILD_IN_MOTION);
    let (ways, wrong_in_ways) = table(resting, in_every_way, WILD);
    let wrong = [wrong, wrong_in_motion, wrong_in_ways];
    assert!(wrong.iter().all(Vec::is_empty), "at rest, in motion, asked in other ways: {wrong:?}");
    if times() == 1 {
        check_page(
            "accuracy",
            "drawn.md",
            &format!("{HEAD}{COLUMNS}{rest}{MOTION}{COLUMNS}{motion}{WAYS}{COLUMNS}{ways}"),
        );
    }
}

/// Of the numbers that an untouched sensor is, most of them first readings, beyond ten sigma: nothing is known yet to tell a late stamp of
/// the first calibration by.
const BY_ACCIDENT: f64 = 1e-3;

/// What may as well conduct nothing is no number, and least of all before much is known.
#[test]
fn an_untouched_sensor_is_no_number_on_boards_that_are_drawn_at_random() {
    let untouched = |draw: &mut Draw| format!("constant = '{} ohm'", draw.decades(1e6, 1e12));
    for (name, kind, method) in CASES {
        let (mut numbers, mut wrong) = (0, 0);
        for number in 0..BOARDS * times() {
            let errors = Board::draw(number, kind, method, untouched, plainly).read();
            numbers += errors.count();
            let off = errors.errors.iter().zip(&errors.us).filter(|(error, u)| error.abs() > 10.0 * **u);
            wrong += off.count();
        }
        println!("{name}: {numbers} numbers, {wrong} of them wrong");
        assert!(share_is_in(wrong, numbers, 0.0..=BY_ACCIDENT), "{name}: {wrong} of {numbers} numbers");
    }
}
