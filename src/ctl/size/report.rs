//! What was found, as a person and as a program reads it.

use super::asked::{Asked, milliampere};
use super::rehearsal::{Overall, Rehearsed};
use crate::circuit::{Kind, Network};
use crate::sensor::{Channel, UNCALIBRATED_U};
use crate::size::limits::{EXACT, SENSE_OHM};
use crate::size::{Design, Pace, Tolerance};
use crate::units::{Ampere, Hertz, Newton, Ohm, Seconds, measured, rough, rounded};
use serde::Serialize;
use std::collections::BTreeMap;

/// Capacitors and calibration resistors.
pub fn parts(design: &Design) -> String {
    let [r_c1, r_c2] = design.r_c;
    let capacitors = match design.network {
        Network::TwoCapacitor { c_a, c_b } => format!("two capacitors of {c_a} and {c_b}"),
        Network::OneCapacitor { c } | Network::SeriesCalibration { c } => format!("one capacitor of {c}"),
    };
    format!("{capacitors} with {r_c1} and {r_c2}")
}

/// All of it; each line ends in a line feed.
pub fn text(asked: &Asked, found: &[Rehearsed], why_not: Option<&str>) -> String {
    let Some(best) = found.first() else { return String::new() };
    let mut lines = vec![title(asked), String::new()];
    if why_not.is_some() {
        lines.push(" This comes nearest, and is not enough:".to_owned());
    }
    lines.extend(build(asked, best));
    lines.push(String::new());
    lines.extend(expectation(asked, best));
    lines.push(String::new());
    lines.extend(truth(asked, best));
    lines.extend(runner_up(asked, found));
    lines.join("\n") + "\n"
}

fn title(asked: &Asked) -> String {
    let need = &asked.search.need;
    let [from, to] = need.r_ohm.map(|r_ohm| format!("{:.3}", Ohm(r_ohm)));
    let error = need.tolerance.map(|tolerance| match tolerance {
        Tolerance::Share(share) => format!("{} %", rounded(100.0 * share, 3)),
        Tolerance::Ohm(ohm) => Ohm(ohm).to_string(),
        Tolerance::Newton { f_n, .. } => Newton(f_n).to_string(),
    });
    let error = error.map_or("the least error".to_owned(), |error| format!("{error} (1 sigma)"));
    let rate = need.rate_hz.map_or("as fast as can be".to_owned(), |hertz| format!("at {}", Hertz(hertz)));
    format!(
        " {from} to {to}, {error}, {rate}\n board {}, simulated, with pins of {}",
        asked.name,
        Ampere(asked.search.pin_a)
    )
}

/// The parts and settings.
fn build(asked: &Asked, best: &Rehearsed) -> Vec<String> {
    let (design, stock) = (&best.design, &asked.search.stock);
    let row = |name: &str, value: String, what: &str| format!("   {name:<9}{value:<15}{what}");
    let mut lines = vec![match design.kind() {
        Kind::TwoCapacitor => {
            " two capacitors, a charger for each, 7 lines: second drawing of hw/wiring.md".to_owned()
        }
        _ => " one capacitor, with a charger, 5 lines: first drawing of hw/wiring.md".to_owned(),
    }];
    let names: &[&str] = if design.nodes() == 2 { &["C_A", "C_B"] } else { &["C"] };
    let film = "film, PP or PET, 5 or 10 %";
    let film_b = if design.nodes() == 2 { "film, PP or PET, 5 %" } else { film };
    lines.extend(names.iter().zip(design.capacitors()).map(|(name, c)| row(name, c.to_string(), film_b)));
    let [r_c1, r_c2] = design.r_c;
    lines.push(row("Rc1", r_c1.to_string(), "metal film, 0.1 %; or any, measured: just as good"));
    lines.push(row("Rc2", r_c2.to_string(), "the same"));
    let bought = |r: Ohm, what: &str| format!("{what}{}", if stock.has(r) { ", there" } else { "" });
    lines.push(row("Rp", design.r_p.to_string(), &bought(design.r_p, "1 %, between charger and node")));
    lines.push(row(
        "R_lim",
        design.r_lim.to_string(),
        &bought(design.r_lim, "1 %, 50 ppm/K, in series with the sensor"),
    ));
    lines.push(row(
        "R_s",
        Ohm(SENSE_OHM).to_string(),
        &bought(Ohm(SENSE_OHM), "any, between node and input"),
    ));
    lines.push(row("price", best.price.to_string(), "all parts but the sensor, single pieces, roughly"));
    lines.push(row("settings", settings(asked, design), ""));
    lines.extend(currents(asked, design));
    lines.into_iter().map(|line| line.trim_end().to_owned()).collect()
}

fn settings(asked: &Asked, design: &Design) -> String {
    let config = design.config(&asked.search.platform);
    let pace = match design.pace {
        Pace::Each => "each discharge a reading".to_owned(),
        Pace::Mean(time) => format!("means over {}", Seconds::from(time)),
        Pace::Hertz(hertz) => format!("means at {hertz} Hz"),
    };
    let deadline = Seconds::from(config.deadline());
    // As `cermctl check` says it of what is written.
    format!("charge {}, longest discharge {deadline:.2}, {pace}", config.charge_in_words())
}

fn currents(asked: &Asked, design: &Design) -> [String; 3] {
    let each = design.currents(&asked.search.platform);
    each.map(|(name, ampere)| format!("   {:<9}{:<15}{name}", "current", milliampere(ampere)))
}

/// What readings are to be expected.
fn expectation(asked: &Asked, best: &Rehearsed) -> Vec<String> {
    let has_force = asked.alpha_n_ohm.is_some();
    let force = if has_force { format!("{:>22}", "force") } else { String::new() };
    let mut lines =
        vec![format!("   {:>24}{:>10}{force}{:>12}", "reading, error (1 sigma)", "of it", "readings/s")];
    lines.extend(best.expected.iter().map(|one| {
        let u_ohm = one.u_ohm.unwrap_or_default();
        let force = asked.alpha_n_ohm.map(|alpha| alpha / one.r_ohm);
        let force = force.map_or(String::new(), |f_n| {
            format!("{:>22}", measured(f_n, Some(f_n * u_ohm / one.r_ohm), "N", false))
        });
        let value = measured(one.r_ohm, Some(u_ohm), "ohm", false);
        format!(
            "   {value:>24}{:>8} %{force}{:>12}",
            rounded(100.0 * u_ohm / one.r_ohm, 2),
            rate(one.rate_hz)
        )
    }));
    lines
}

/// To three digits.
fn rate(rate_hz: f64) -> String {
    let places = if rate_hz < 10.0 { 2 } else { usize::from(rate_hz < 100.0) };
    format!("{rate_hz:.places$}")
}

/// What is not in the errors above.
fn truth(asked: &Asked, best: &Rehearsed) -> Vec<String> {
    let unknown = Channel::default();
    let known = best.design.r_c.map(|r| r.0);
    let pins_ohm = unknown.pins_u_ohm(asked.search.need.r_ohm[0] + best.design.r_lim.0, known);
    let pins = rough(pins_ohm, "ohm");
    let mut lines = vec![
        " Not in it: each reading is off by the share that Rc1 and Rc2 are off by, and no".to_owned(),
        " mean takes that out. Parts of 0.1 % or any parts that an ohmmeter has measured to".to_owned(),
        " 0.1 % are equally good. And what pins differ by, until it has been measured:".to_owned(),
        format!(" {pins} before `cermctl calibrate zero` and `calibrate reference`."),
    ];
    let shares = asked.search.need.r_ohm.map(|r_ohm| asked.search.need.ohm_at(r_ohm) / r_ohm);
    let least = shares[0].min(shares[1]);
    if least < EXACT {
        let percent = rounded(100.0 * least, 2);
        lines.push(format!(
            " For {percent} % Rc1 and Rc2 have to be known to that: measure them, at 25 ppm/K or better."
        ));
    }
    if asked.alpha_n_ohm.is_some() {
        let percent = 100.0 * UNCALIBRATED_U;
        lines.push(format!(
            " A sensor that nobody has measured is off by {percent:.1} %: `cermctl calibrate force`."
        ));
    }
    lines
}

/// The best of the other wiring, or else the second.
fn runner_up(asked: &Asked, found: &[Rehearsed]) -> Vec<String> {
    let (Some(best), Some((second, overall))) = (found.first(), second(found)) else { return Vec::new() };
    let error = match asked.search.need.tolerance {
        Some(_) => format!("{} times the error asked for", rounded(overall.error, 2)),
        None => format!("an error of {} %", rounded(100.0 * overall.error, 2)),
    };
    let enough = if second.meets { "" } else { ": not enough" };
    let mut lines = vec![
        String::new(),
        format!(" Runner-up, {}: {}:", second.price, parts(&second.design)),
        format!("   {error} at its worst, {} readings/s at the slowest{enough}.", rate(overall.rate_hz)),
    ];
    if second.design.nodes() > best.design.nodes() {
        lines.push("   A second crossing checks each of its readings.".to_owned());
    }
    lines
}

fn second(found: &[Rehearsed]) -> Option<(&Rehearsed, Overall)> {
    let (best, others) = found.split_first()?;
    let complete = || others.iter().filter_map(|one| Some((one, one.overall.ok()?)));
    complete().find(|(one, _)| one.design.kind() != best.design.kind()).or_else(|| complete().next())
}

/// A line of JSON.
#[derive(Serialize)]
#[serde(tag = "class", rename = "SIZE")]
pub struct SizeLine {
    scene: String,
    simulated: bool,
    r_from_ohm: f64,
    r_to_ohm: f64,
    meets: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    why_not: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    best: Option<CircuitLine>,
    #[serde(skip_serializing_if = "Option::is_none")]
    runner_up: Option<CircuitLine>,
}

#[derive(Serialize)]
struct CircuitLine {
    kind: Kind,
    capacitors_f: Vec<f64>,
    r_c1_ohm: f64,
    r_c2_ohm: f64,
    r_p_ohm: f64,
    r_lim_ohm: f64,
    r_s_ohm: f64,
    charge_s: f64,
    /// Before a discharge that waits for B.
    #[serde(skip_serializing_if = "Option::is_none")]
    charge_b_s: Option<f64>,
    deadline_s: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    average_s: Option<f64>,
    currents_a: BTreeMap<&'static str, f64>,
    price: &'static str,
    meets: bool,
    expected: Vec<ExpectedLine>,
}

#[derive(Serialize)]
struct ExpectedLine {
    r_ohm: f64,
    r_u_ohm: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    f_repeat_u_n: Option<f64>,
    rate_hz: f64,
}

impl SizeLine {
    pub fn new(asked: &Asked, found: &[Rehearsed], why_not: Option<&str>) -> SizeLine {
        let [r_from_ohm, r_to_ohm] = asked.search.need.r_ohm.map(|r_ohm| rounded(r_ohm, 6));
        SizeLine {
            scene: asked.name.clone(),
            simulated: true,
            r_from_ohm,
            r_to_ohm,
            meets: why_not.is_none(),
            why_not: why_not.map(str::to_owned),
            best: found.first().map(|one| CircuitLine::new(asked, one)),
            runner_up: second(found).map(|(one, _)| CircuitLine::new(asked, one)),
        }
    }
}

impl CircuitLine {
    fn new(asked: &Asked, one: &Rehearsed) -> CircuitLine {
        let design = &one.design;
        let config = design.config(&asked.search.platform);
        let seconds = |time: crate::units::Nanos| rounded(time.as_seconds(), 6);
        let [charger, c1, x] = design.currents(&asked.search.platform).map(|(_, ampere)| rounded(ampere, 4));
        let expected = one.expected.iter().map(|one| {
            let r_u_ohm = one.u_ohm.unwrap_or_default();
            let force = asked.alpha_n_ohm.map(|alpha| rounded(alpha * r_u_ohm / one.r_ohm.powi(2), 4));
            ExpectedLine {
                r_ohm: rounded(one.r_ohm, 6),
                r_u_ohm: rounded(r_u_ohm, 4),
                f_repeat_u_n: force,
                rate_hz: rounded(one.rate_hz, 4),
            }
        });
        CircuitLine {
            kind: design.kind(),
            capacitors_f: design.capacitors().into_iter().map(|c| c.0).collect(),
            r_c1_ohm: design.r_c[0].0,
            r_c2_ohm: design.r_c[1].0,
            r_p_ohm: design.r_p.0,
            r_lim_ohm: design.r_lim.0,
            r_s_ohm: SENSE_OHM,
            charge_s: seconds(config.charge_time()),
            charge_b_s: config.charge_for_b().map(seconds),
            deadline_s: seconds(config.deadline()),
            average_s: config.average().map(seconds),
            currents_a: [("charger", charger), ("c1", c1), ("x", x)].into(),
            price: one.price.as_str(),
            meets: one.meets,
            expected: expected.collect(),
        }
    }
}
