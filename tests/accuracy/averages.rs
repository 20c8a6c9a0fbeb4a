//! `tracked` at full speed: single readings, and means over a time that the instrument itself publishes.
//!
//! Writes `docs/averages.md` with `UPDATE_DOCS=1 cargo test --test accuracy averages`, and fails when it is out of date.

use crate::common::{Bench, Errors, check_page, hear_between, published_s, rms};
use cermd::instrument::Message;
use cermd::pins::sim::scene::WalkScene;
use cermd::pins::sim::{Kind, Sensor};
use cermd::reading::Method;
use cermd::units::{Nanos, Ohm};
use std::fmt::Write;

const INSTRUMENTS: u64 = 200;
/// Those of means over a second, in which the errors of two of a board are nearly the same.
const MANY_BOARDS: u64 = 600;
/// Those of means over 10 s, which take their time.
const FEW: u64 = 40;
const RESISTANCES: [f64; 4] = [100.0, 1000.0, 16_200.0, 100_000.0];

const HEAD: &str = "# Single readings, and means over a time

Every figure on this page is **simulated**: scene `pi4` (2.2 uF / 680 nF, or one capacitor of 470 nF; Rc 470 / 12700 ohm), method
`tracked`, a constant resistor; 200 instruments, 600 for the means over a second, 40 for those over 10 s, from 4 to 6 s after their starts on, evenly spread (each kind of
calibration is seen once in two seconds at least): 50 single readings, 5
means over 0.1 s, 2 over a second or 1 over 10 s. Calibration, charges and the looks for a leak are in the rate. Written by
`UPDATE_DOCS=1 cargo test --test accuracy averages`, and the same test fails when it is out of date.

The means are what `average = \"1 s\"` publishes, not what single readings would give: the plan apportions calibration discharges
for the time that is averaged, and the uncertainty contains what readings share of the calibration
([src/estimate/mean.rs](../src/estimate/mean.rs)). `error` is the root mean square against the truth of the scene, `u` that of what is
stated, both 1 sigma. On a board that neither drifts nor walks, as this one, errors of long means are smaller than u, which allows
for what cannot be excluded of both yet.

| capacitors | R_x / ohm | mean over | error / ohm | u / ohm | within 2u | readings/s |
|---|--:|--:|--:|--:|--:|--:|
";

/// What is promised of single readings: error, ohm, and readings a second; of means over a second, ohm.
const PROMISED: [(Kind, f64, f64, f64, f64); 6] = [
    (Kind::TwoCapacitor, 100.0, 0.30, 350.0, 0.06),
    (Kind::TwoCapacitor, 1000.0, 0.75, 350.0, 0.10),
    (Kind::TwoCapacitor, 16_200.0, 8.0, 80.0, 1.5),
    (Kind::OneCapacitor, 100.0, 0.55, 600.0, 0.06),
    (Kind::OneCapacitor, 1000.0, 0.80, 500.0, 0.10),
    (Kind::OneCapacitor, 16_200.0, 8.5, 95.0, 1.5),
];

struct Cell {
    errors: Errors,
    rate_hz: f64,
}

fn measure(kind: Kind, r_ohm: f64, average: &str, readings: usize, boards: u64) -> Cell {
    let bench = Bench::with_kind("pi4", kind, Method::Tracked, r_ohm, 0, average);
    let found = bench.cell(r_ohm, boards, readings).measure(&|| false).unwrap().unwrap();
    Cell { errors: Errors::of(&found).at_rest(), rate_hz: 1.0 / published_s(&found) }
}

/// All cells of one circuit, two of them at a time.
fn cells(kind: Kind) -> Vec<(f64, &'static str, Cell)> {
    let ways = [("", 50, INSTRUMENTS), ("0.1 s", 5, INSTRUMENTS), ("1 s", 2, MANY_BOARDS), ("10 s", 1, FEW)];
    let mut all = Vec::new();
    for r_ohm in RESISTANCES {
        for (time, readings, boards) in ways {
            // What a higher resistance shares is what 16.2 kohm shares.
            if r_ohm > 20_000.0 && !time.is_empty() {
                continue;
            }
            let average = if time.is_empty() { String::new() } else { format!("average = \"{time}\"") };
            all.push((r_ohm, time, measure(kind, r_ohm, &average, readings, boards)));
        }
    }
    all
}

const MANY: &str = "
## Many sensors

All channels share the calibration. One capacitor, 8 instruments for 10 s (30 s in the last row) from 10 s after the start on, when noise is known with all of them. Sensors
that are pressed have 1 kohm, the others 20 Mohm, for which a discharge lasts until the deadline:

| sensors | pressed | readings/s of each | of all | calibration discharges for each reading | within 2u |
|--:|--:|--:|--:|--:|--:|
";

/// Rate of each channel, calibration discharges for each reading, and errors, with so many sensors, the first ones of 1 kohm, and
/// the others untouched.
fn many(channels: usize, pressed: usize) -> (f64, f64, Errors) {
    let (mut errors, mut readings, mut discharges, mut seconds) = (Errors::default(), 0usize, 0usize, 0.0);
    let before = Nanos(10_000_000_000);
    for seed in 0..8 {
        errors.next_board();
        let mut bench = Bench::with_kind("pi4", Kind::OneCapacitor, Method::Tracked, 1000.0, seed, "");
        (1..channels).for_each(|index| {
            let id = format!("y{index}");
            bench.config.channel(&id).lines(&format!("channel.{id}"), "zero-ohm = 0\nscale = 1");
        });
        let sensors =
            (0..channels).map(|index| Sensor::Constant(Ohm(if index < pressed { 1000.0 } else { 20e6 })));
        bench.scene = bench.scene.with_sensors(sensors.collect()).unwrap();
        let mut instrument = bench.instrument();
        // As long as from one look for a leak to the next; longer where few readings come.
        let end = before + Nanos::from_seconds(if pressed < channels { 30.0 } else { 10.0 });
        hear_between(&mut instrument, [before, end], |message| match message {
            Message::Reading(reading) => {
                readings += 1;
                if reading.channel < pressed {
                    errors.add(&reading, 1000.0);
                }
            }
            Message::Discharge { .. } => discharges += 1,
        });
        seconds += (end - before).as_seconds();
    }
    let each_hz = readings as f64 / channels as f64 / seconds;
    (each_hz, (discharges - readings) as f64 / readings as f64, errors)
}

/// Means that each instrument is heard for where pins walk.
const READINGS: f64 = 4.0;

const WALKING: &str = "
## Pins that walk

The same means with two capacitors and a sensor of 100 ohm, where the output resistance of all pins walks at random: a mean over a
second has little noise of its own, so that what is believed of the calibration shows in it first. 100 instruments, each for the time of 4
means from so long after the start on. How fast Ro walks has to be found ([src/estimate/tracker/speeds.rs](../src/estimate/tracker/speeds.rs)):
as long as little has been seen, a fast walk is taken for a slower one, and what stands still for a walk.

| Ro walks in a second | from | mean over | error / ohm | u / ohm | within 2u |
|--:|--:|--:|--:|--:|--:|
";

/// Means over so many seconds where the pins walk, from so long after the start on.
fn walking(walk_ohm: f64, from_s: f64, mean_s: f64) -> Errors {
    let mut errors = Errors::default();
    let window = [from_s, from_s + READINGS * mean_s].map(Nanos::from_seconds);
    for seed in 0..INSTRUMENTS / 2 {
        errors.next_board();
        let average = format!("average = \"{mean_s} s\"");
        let mut bench = Bench::with_kind("pi4", Kind::TwoCapacitor, Method::Tracked, 100.0, seed, &average);
        bench.scene.walk = Some(WalkScene { r_o: Ohm(walk_ohm) });
        hear_between(&mut bench.instrument(), window, |message| {
            if let Message::Reading(reading) = message {
                errors.add(&reading, 100.0);
            }
        });
    }
    errors.at_rest()
}

/// A table of them, and what is not true in it.
fn all_walking() -> (String, String) {
    let (mut table, mut wrong) = (WALKING.to_owned(), String::new());
    let each = |walk_ohm| [4.0, 20.0].map(|from_s| [0.1, 1.0].map(|mean_s| (walk_ohm, from_s, mean_s)));
    for (walk_ohm, from_s, mean_s) in [0.05, 0.3, 1.0].map(each).into_iter().flatten().flatten() {
        let errors = walking(walk_ohm, from_s, mean_s);
        let row = format!(
            "| {walk_ohm} ohm | {from_s} s | {mean_s} s | {:.3} | {:.3} | {:.1} % |",
            rms(&errors.errors),
            rms(&errors.us),
            100.0 * errors.coverage()
        );
        writeln!(table, "{row}").unwrap();
        let least = if from_s < 20.0 { 0.85 } else { 0.92 };
        if !errors.within_2u().is_in(least..=1.0) {
            writeln!(wrong, "{row}").unwrap();
        }
    }
    (table, wrong)
}

#[test]
fn the_page_is_up_to_date_and_keeps_what_is_promised() {
    let (two, one) = std::thread::scope(|scope| {
        let two = scope.spawn(|| cells(Kind::TwoCapacitor));
        let one = scope.spawn(|| cells(Kind::OneCapacitor));
        (two.join().unwrap(), one.join().unwrap())
    });
    let (mut page, mut wrong) = (HEAD.to_owned(), String::new());
    for (kind, name, cells) in [(Kind::TwoCapacitor, "two", two), (Kind::OneCapacitor, "one", one)] {
        for (r_ohm, time, Cell { errors, rate_hz }) in cells {
            let (error, shown) = (rms(&errors.errors), if time.is_empty() { "-" } else { time });
            let row = format!(
                "| {name} | {r_ohm} | {shown} | {error:.3} | {:.3} | {:.1} % | {rate_hz:.1} |",
                rms(&errors.us),
                100.0 * errors.coverage(),
            );
            writeln!(page, "{row}").unwrap();
            // Long means may be better than they say, and never much worse.
            let honest = errors.within_2u().is_in(0.93..=if time.is_empty() { 0.985 } else { 1.0 });
            let promised = PROMISED.iter().find(|one| one.0 == kind && one.1 == r_ohm);
            let ratio = |limit: f64| errors.rms_ratio(limit).is_in(0.0..=1.0);
            let kept = promised.is_none_or(|(_, _, single, rate, second)| match time {
                "" => ratio(*single) && rate_hz > *rate,
                "1 s" => ratio(*second),
                _ => true,
            });
            if !honest || !kept {
                writeln!(wrong, "{row} honest: {honest}, as promised: {kept}").unwrap();
            }
        }
    }
    let (table, walking) = all_walking();
    page += &table;
    wrong += &walking;
    page += MANY;
    let mut alone_hz = None;
    for (channels, pressed) in [(1, 1), (4, 4), (16, 16), (16, 1)] {
        let (each_hz, calibrations, errors) = many(channels, pressed);
        let (all_hz, within) = (each_hz * channels as f64, errors.at_rest().within_2u());
        let row = format!(
            "| {channels} | {pressed} | {each_hz:.1} | {all_hz:.0} | {calibrations:.3} | {:.1} % |",
            100.0 * within.value
        );
        writeln!(page, "{row}").unwrap();
        // More sensors take less than so many times what one takes.
        let is_slow = pressed == channels && all_hz < 0.97 * *alone_hz.get_or_insert(all_hz);
        if is_slow || !within.is_in(0.93..=0.985) {
            writeln!(wrong, "{row}").unwrap();
        }
    }
    println!("{page}");
    check_page("accuracy averages", "averages.md", &page);
    assert!(wrong.is_empty(), "seeds 0..{INSTRUMENTS}\n{wrong}");
}

/// Between two ticks there is one mean, of all discharges of its time; what is slept before it is no part of it.
#[test]
fn a_mean_now_and_then_is_of_all_its_time_and_a_rest_is_no_part_of_it() {
    for (measure, method, least, longest_s) in [
        ("rate-hz = 4\naverage = \"100 ms\"", Method::Tracked, 8, 0.11),
        ("rate-hz = 4\naverage = \"100 ms\"\nidle = true", Method::Tracked, 8, 0.11),
        ("rate-hz = 4\nidle = true", Method::Cerm, 1, 0.06),
    ] {
        let mut bench = Bench::new("pi4", method, 1000.0, 3, measure);
        bench.config.channel("finger").lines("channel.finger", "zero-ohm = 0\nscale = 1");
        bench.scene = bench.scene.with_sensors(vec![Sensor::Constant(Ohm(1000.0)); 2]).unwrap();
        let mut instrument = bench.instrument();
        let (mut discharges, mut readings) = ([0; 2], [0; 2]);
        hear_between(
            &mut instrument,
            [Nanos(3_000_000_000), Nanos(8_000_000_000)],
            |message| match message {
                Message::Discharge { record, .. } => {
                    record.through.channel().into_iter().for_each(|channel| discharges[channel] += 1);
                }
                Message::Reading(reading) => {
                    readings[reading.channel] += 1;
                    let took_s = reading.duration.as_seconds();
                    assert!(took_s < longest_s, "{measure}: {took_s} s");
                }
            },
        );
        for channel in 0..2 {
            assert!((19..=21).contains(&readings[channel]), "{measure}: {readings:?} readings in 5 s");
            let each = discharges[channel] / readings[channel];
            assert!(each >= least, "{measure}: {each} discharges for each reading");
        }
    }
}
