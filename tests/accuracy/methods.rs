//! Speed against accuracy: every method on the same simulated board.
//!
//! Writes `docs/methods.md` with `UPDATE_DOCS=1 cargo test --test accuracy methods`, and fails when it is out of date.

use crate::common::{Bench, Errors, check_page, kind_of, published_s, rms};
use cermd::characterize::watch::Found;
use cermd::pins::sim::Kind;
use cermd::reading::Method;
use cermd::units::Ohm;
use std::fmt::Write;

const INSTRUMENTS: u64 = 200;
const READINGS: usize = 50;

const HEAD: &str = "# Methods, speed against accuracy

Every figure on this page is **simulated**: scene `pi4` (2.2 uF / 680 nF, or one capacitor of 470 nF;
Rc 470 / 12700 ohm; latencies, noise and thresholds as `hw/scenes/pi4.toml` says, some of them assumed), no sensor but a
constant resistor, 200 instruments with 50 readings each, from 4 s after the start on (`tracked`: from 4 to 6 s, evenly spread over the
instruments, since each kind of calibration is seen once in two seconds at least). The page is written by
`UPDATE_DOCS=1 cargo test --test accuracy methods`, and the same test fails when it is out of date.

`error` is the root mean square of all errors, `u` that of the stated uncertainties (both 1 sigma), `within 2u` the share
of readings that are off by less than two of their own sigma (95 % is honest). `time` is all that passes for each reading: charges,
calibration discharges, the reading, looks for a leak. `error x sqrt(time)` compares methods at equal time. It is the error of a mean only as far as readings have nothing in common; those of `tracked` share a
state. What means over a time are worth is measured: [averages.md](averages.md).

![Error against time per published reading at 1 kohm: all methods, their bounds, and what one would take instead](front.svg)

| method | R_x / ohm | error / ohm | u / ohm | within 2u | time / ms | readings/s | error x sqrt(time) / ohm sqrt(s) |
|---|--:|--:|--:|--:|--:|--:|--:|
";

const PINS: &str = "
## What weaker pins cost

Above, Rp is 180 ohm, which with the pin's own 40 ohm makes 15 mA, for pins of 16 mA. The values of [hw/wiring.md](../hw/wiring.md#parts) count without
the pin, and are for pins of 16, 12 and 8 mA (Pi 1 to 3 and Zero, Pi 5, Pi 4 as it boots): charges take longer, errors stay. The same
board with other Rp, method `tracked`, 60 instruments. R_x is all that is between node A and its pin: with R_lim, which is as large as Rp,
a sensor of 0 ohm is one of 470 ohm on the weakest pins.

| pins | Rp / ohm | capacitors | R_x / ohm | error / ohm | within 2u | readings/s |
|---|--:|---|--:|--:|--:|--:|
";

/// What pins may carry, Rp for that, and Rp with such a pin.
const PIN_ROWS: [(&str, f64, &str); 3] =
    [("16 mA", 220.0, "260 ohm"), ("12 mA", 330.0, "370 ohm"), ("8 mA", 470.0, "510 ohm")];

struct Row {
    errors: Errors,
    seconds: f64,
}

/// A method on its usual circuit, or on another one.
type Way = (&'static str, Method, Option<Kind>);

const WAYS: [Way; 6] = [
    ("tpcm", Method::Tpcm, None),
    ("qerm", Method::Qerm, None),
    ("tcdic", Method::Tcdic, None),
    ("cerm", Method::Cerm, None),
    ("tracked", Method::Tracked, None),
    ("tracked, one capacitor", Method::Tracked, Some(Kind::OneCapacitor)),
];

fn measure((_, method, kind): Way, r_ohm: f64) -> Row {
    let kind = kind.unwrap_or(kind_of(method));
    let cell = Bench::with_kind("pi4", kind, method, r_ohm, 0, "").cell(r_ohm, INSTRUMENTS, READINGS);
    let found = cell.measure(&|| false).unwrap().unwrap();
    row(&found)
}

fn row(found: &[Found]) -> Row {
    // A late stamp of a single stretch says that the sensor moves.
    Row { errors: Errors::of(found).at_rest(), seconds: published_s(found) }
}

/// The table of pins, and what is not true in it.
fn pins() -> (String, String) {
    let (mut table, mut wrong) = (PINS.to_owned(), String::new());
    for (pins, r_p, r_charge) in PIN_ROWS {
        for (name, kind) in [("one", Kind::OneCapacitor), ("two", Kind::TwoCapacitor)] {
            for r_ohm in [100.0, 1000.0, 16_200.0] {
                let mut bench = Bench::with_kind("pi4", kind, Method::Tracked, r_ohm, 0, "");
                bench.scene.circuit.r_p = Some(Ohm(r_p));
                bench.config.set("circuit.r-charge", r_charge);
                let found = bench.cell(r_ohm, 60, READINGS).measure(&|| false).unwrap().unwrap();
                let Row { errors, seconds } = row(&found);
                let (error, within) = (rms(&errors.errors), 100.0 * errors.coverage());
                let hz = 1.0 / seconds;
                let row =
                    format!("| {pins} | {r_p} | {name} | {r_ohm} | {error:.2} | {within:.1} % | {hz:.0} |");
                writeln!(table, "{row}").unwrap();
                if !errors.within_2u().is_in(0.93..=0.985) {
                    writeln!(wrong, "{row}").unwrap();
                }
            }
        }
    }
    (table, wrong)
}

#[test]
fn the_page_is_up_to_date_and_tracking_pays() {
    let mut page = HEAD.to_owned();
    let pins = std::thread::spawn(pins);
    let mut figures = Vec::new();
    for way in WAYS {
        for r_ohm in [100.0, 1000.0, 5000.0, 16_200.0] {
            let method = way.0;
            let Row { errors, seconds } = measure(way, r_ohm);
            let error = rms(&errors.errors);
            figures.push((method, r_ohm, errors.rms_ratio(1.0).times(seconds.sqrt())));
            writeln!(
                page,
                "| {method} | {r_ohm} | {error:.2} | {:.2} | {:.1} % | {:.1} | {:.0} | {:.3} |",
                rms(&errors.us),
                100.0 * errors.coverage(),
                1e3 * seconds,
                1.0 / seconds,
                error * seconds.sqrt()
            )
            .unwrap();
        }
    }
    let of = |method: &str, r_ohm: f64| {
        figures.iter().find(|row| row.0 == method && row.1 == r_ohm).map(|row| row.2).unwrap()
    };
    for (r_ohm, factor) in [(100.0, 8.0), (1000.0, 4.0), (16_200.0, 2.0)] {
        let gain = of("cerm", r_ohm).over(of("tracked", r_ohm));
        assert!(
            gain.is_in(factor..=5.0 * factor),
            "{r_ohm} ohm: tracked is {gain:.2} times better, seeds 0..{INSTRUMENTS}"
        );
    }
    let (table, wrong) = pins.join().unwrap();
    page += &table;
    assert!(wrong.is_empty(), "not honest:\n{wrong}");
    check_page("accuracy methods", "methods.md", &page);
}
