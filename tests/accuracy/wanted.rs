//! Readings that are wanted at a rate come at it, whatever the sensor is.
//!
//! Writes `docs/rate.md` with `UPDATE_DOCS=1 cargo test --test accuracy wanted`, and fails when it is out of date.

use crate::common::{Bench, Errors, check_page, hear_between, rms};
use cermd::instrument::Message;
use cermd::pins::sim::Kind;
use cermd::reading::Method;
use cermd::units::Nanos;
use std::fmt::Write;

/// Nothing that conducts, ohm.
const UNTOUCHED: f64 = 1e12;
const BOARDS: u64 = 12;
const FROM: Nanos = Nanos(10_000_000_000);
/// From one pair of looks for a leak to the next.
const SECONDS: i64 = 10;
const RESISTANCES: [f64; 5] = [1000.0, 16_200.0, 100_000.0, 300_000.0, UNTOUCHED];
/// Of each circuit a rate that is to hold for every sensor, and one that does not.
const WANTED: [(Kind, &str, [Option<f64>; 3]); 2] = [
    (Kind::TwoCapacitor, "two", [None, Some(20.0), Some(30.0)]),
    (Kind::OneCapacitor, "one", [None, Some(40.0), Some(80.0)]),
];

const HEAD: &str = "# A wanted rate, and sensors that are slow

Every figure on this page is **simulated**: scene `pi4` (2.2 uF / 680 nF, or one capacitor of 470 nF; Rc 470 / 12700 ohm), method
`tracked`, 12 instruments from 10 s to 20 s after their start. Written by `UPDATE_DOCS=1 cargo test --test accuracy wanted`, and the
same test fails when it is out of date.

Without `rate-hz` each discharge is chosen for the most accuracy per time, and through a high resistance that is a long one. With it
(or with `average`) discharges through the sensors get what 0.9 of the time leaves beside one through R_2, in equal parts, but not less than
two through R_2 take, so that calibration has room on slow capacitors. What has not crossed by then is finished through R_1 or R_2. So nine
tenths of the rate at the least are kept for every sensor, up to rates of 0.3 over the time of a discharge through R_2 (`cermctl check`
tells that time), and above them for sensors up to about R_2; what is missing is the looks for a leak and calibration. One that nobody
touches is said to be open as soon, with a lower bound of less. A `deadline` in the configuration is kept instead; methods other than
`tracked` cannot finish early, and nothing changes for them.

| capacitors | rate-hz | R_x / ohm | readings/s | error / ohm | u / ohm | within 2u |
|---|--:|--:|--:|--:|--:|--:|
";

fn bench(kind: Kind, r_ohm: f64, rate_hz: Option<f64>, seed: u64) -> Bench {
    let rate = rate_hz.map_or_else(String::new, |hertz| format!("rate-hz = {hertz}"));
    Bench::with_kind("pi4", kind, Method::Tracked, r_ohm, seed, &rate)
}

/// Readings a second, and errors.
fn measure(kind: Kind, r_ohm: f64, rate_hz: Option<f64>) -> (f64, Errors) {
    let (mut errors, mut readings) = (Errors::default(), 0);
    let end = FROM + Nanos(SECONDS * 1_000_000_000);
    for seed in 0..BOARDS {
        errors.next_board();
        let mut instrument = bench(kind, r_ohm, rate_hz, seed).instrument();
        hear_between(&mut instrument, [FROM, end], |message| {
            if let Message::Reading(reading) = message {
                readings += 1;
                errors.add(&reading, r_ohm);
            }
        });
    }
    (readings as f64 / (BOARDS as f64 * SECONDS as f64), errors)
}

#[test]
fn readings_come_at_the_rate_that_is_wanted() {
    let (mut page, mut wrong) = (HEAD.to_owned(), String::new());
    for (kind, name, rates) in WANTED {
        let config = bench(kind, 1000.0, None, 0).config.parse();
        let holds_to_hz = 0.3 / config.discharge(config.circuit.r_second()).0;
        let mut freely = [0.0; RESISTANCES.len()];
        for wanted in rates {
            for (r_ohm, freely) in RESISTANCES.into_iter().zip(&mut freely) {
                let (achieved, errors) = measure(kind, r_ohm, wanted);
                let shown = wanted.map_or_else(|| "-".to_owned(), |hertz| hertz.to_string());
                let mut row = format!("| {name} | {shown} |");
                let is_open = r_ohm == UNTOUCHED;
                let honest = if is_open {
                    write!(row, " none | {achieved:.1} | open | | |").unwrap();
                    errors.errors.is_empty()
                } else {
                    let errors = errors.at_rest();
                    let (error, u) = (rms(&errors.errors), rms(&errors.us));
                    let within = 100.0 * errors.coverage();
                    write!(row, " {r_ohm} | {achieved:.1} | {error:.3} | {u:.3} | {within:.1} % |").unwrap();
                    errors.within_2u().is_in(0.93..=1.0)
                };
                writeln!(page, "{row}").unwrap();
                let kept = match wanted {
                    None => {
                        *freely = achieved;
                        true
                    }
                    Some(hertz) if hertz <= holds_to_hz => (0.9 * hertz..=1.02 * hertz).contains(&achieved),
                    Some(hertz) => (1.2 * *freely).min(0.9 * hertz) < achieved && achieved <= 1.02 * hertz,
                };
                if !honest || !kept {
                    writeln!(wrong, "{row} honest: {honest}, as wanted: {kept}").unwrap();
                }
            }
        }
    }
    println!("{page}");
    check_page("accuracy wanted", "rate.md", &page);
    assert!(wrong.is_empty(), "seeds 0..{BOARDS}\n{wrong}");
}
