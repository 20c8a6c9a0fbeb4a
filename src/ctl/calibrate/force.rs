//! `cermctl calibrate force`: how the resistance of a sensor becomes a force, from weights.
//!
//! Pairs come from a file, from the keyboard, or are measured while weights lie on the sensor.

use super::{CtlError, Target, Value, plot, typed_line, wait_for};
use crate::circuit::Circuit;
use crate::config::pairs;
use crate::ctl::cli::{Connection, Force, Model};
use crate::ctl::limits::WORST_FIT;
use crate::ctl::progress::Progress;
use crate::ctl::stream::Stream;
use crate::estimate::fit::{self, Fit, Weighing};
use crate::sensor::{self, Law};
use crate::stream::wire::{ReadingLine, ServerMessage, StatusName};
use crate::units::{Newton, Ohm, measured, rounded};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::io::{self, IsTerminal};

/// Columns of the bar that stands for the greatest residual, to either side.
const BAR: usize = 12;

/// Fits, shows, and asks.
pub fn run(arguments: &Force) -> Result<(), CtlError> {
    let target = Target::new(&arguments.update)?;
    let pairs = match &arguments.csv {
        Some(path) => {
            let text = fs::read_to_string(path).map_err(CtlError::file(path))?;
            let name = path.display().to_string();
            let pairs = pairs::of_csv(&text, &name).map_err(CtlError::said)?;
            pairs::in_order(&text)
                .map_err(|why| CtlError::Said(format!("{name}: {why}; nothing was changed")))?;
            pairs
        }
        None => typed(&target, arguments)?,
    };
    let fit = match arguments.model {
        Model::Alpha => fit::alpha(&pairs),
        Model::Power => fit::power(&pairs),
        Model::Table => fit::table(&pairs),
    };
    let fit = fit.map_err(CtlError::said)?;
    let force = fit.force(&pairs);
    target.say(&report(&fit, &force, &pairs, &target.config.circuit))?;
    if let Some(refusal) = refusal(&fit, &pairs, arguments.model) {
        return Err(CtlError::Said(refusal));
    }
    if let Some(path) = &arguments.plot {
        fs::write(path, plot::svg(&fit, &pairs, &target.id)).map_err(CtlError::file(path))?;
        target.say(&format!("plot: {}", path.display()))?;
    }
    let line = ForceLine::new(&fit, &force, &pairs, &target);
    target.offer(&Value::Force(force, pairs), line)
}

/// Pairs from standard input, up to an empty line. Its end without one may be a line that was cut off: no pairs.
fn typed(target: &Target, arguments: &Force) -> Result<Vec<Weighing>, CtlError> {
    eprintln!("Put a weight on the sensor, wait until it rests, then type it: \"1.2 N\" or \"120 g\".");
    eprintln!("With a resistance behind it (\"1.2 N, 11122 ohm\") nothing is measured. An empty line ends.");
    let mut pairs = Vec::new();
    for number in 1.. {
        let typed = typed_line(&format!("weight {}: ", pairs.len() + 1))?;
        let wrong = |reason: String| CtlError::Said(format!("standard input, line {number}: {reason}"));
        let Some(text) = typed else {
            eprintln!();
            return Err(wrong("the input ends before the empty line that ends the weights".to_owned()));
        };
        if text.trim().is_empty() {
            break;
        }
        // A pair that is typed stands alone: what others come to does not put it right.
        let parsed = pairs::parse(&text).and_then(|pair| pairs::in_order(&text).map(|()| pair));
        let pair = match parsed {
            Ok((f_n, Some(r_ohm))) => Ok(Weighing { f_n, r_ohm }),
            Ok((f_n, None)) => {
                let r_ohm = measure(target, &arguments.connection, arguments.count)?;
                r_ohm.map(|r_ohm| Weighing { f_n, r_ohm })
            }
            // Somebody at the keyboard types it again; a script does not know that it has to.
            Err(reason) if !io::stdin().is_terminal() => return Err(wrong(reason)),
            Err(reason) => Err(reason),
        };
        match pair {
            Ok(pair) => pairs.push(pair),
            Err(reason) => eprintln!("not taken: {reason}"),
        }
    }
    Ok(pairs)
}

/// The mean of so many readings that come next, ohm; or why there is none.
pub fn measure(
    target: &Target,
    connection: &Connection,
    count: u64,
) -> Result<Result<f64, String>, CtlError> {
    // Anew for each weight: readings that were waiting are of the weight before.
    let mut stream = Stream::connect(&connection.socket, std::slice::from_ref(&target.id))?;
    target.check_in_force(&mut stream)?;
    let (mut numbers, mut others) = (Vec::new(), 0);
    let mut progress = Progress::new();
    while (numbers.len() as u64) < count {
        progress.show(|| format!("  {} of {count} readings", numbers.len()));
        let reading = wait_for(&mut stream, "reading", |message| match message {
            ServerMessage::Reading(reading) => Some(reading),
            _ => None,
        })?;
        match (reading.state.status, reading.state.r_ohm) {
            (StatusName::Ok, Some(r_ohm)) => numbers.push(r_ohm),
            _ if others == count => return Ok(Err(format!("the sensor reads {}", said(&reading)))),
            _ => others += 1,
        }
    }
    drop(progress);
    let mean = fit::mean(&numbers);
    if let Some(mean) = mean {
        eprintln!("  {}", measured(mean.value, mean.u, "ohm", false));
    }
    Ok(mean.map(|mean| mean.value).filter(|r_ohm| *r_ohm > 0.0).ok_or_else(|| "no reading".to_owned()))
}

fn said(reading: &ReadingLine) -> String {
    match (&reading.state.fault, reading.state.status) {
        (Some(fault), _) => format!("fault {fault}"),
        (None, StatusName::Open) => {
            let over = reading.state.r_min_ohm.map(|r_ohm| format!(" (above {:.2})", Ohm(r_ohm)));
            let over = over.unwrap_or_default();
            format!("open{over}: a heavier weight, or a longer `deadline`; or is it not connected?")
        }
        (None, _) => "short: is there a short circuit in its place?".to_owned(),
    }
}

/// The forces at Rc1 and Rc2, newton; `None` where the characteristic gives none.
fn at_resistors(force: &sensor::Force, circuit: &Circuit) -> [Option<f64>; 2] {
    let known = [circuit.r_c1.0, circuit.r_c2.0];
    known.map(|r_ohm| force.at_bound(r_ohm, known))
}

/// The least and the greatest, newton.
fn weights(pairs: &[Weighing]) -> [f64; 2] {
    let forces = || pairs.iter().map(|pair| pair.f_n);
    [forces().fold(f64::INFINITY, f64::min), forces().fold(0.0, f64::max)]
}

/// What was fitted, and by how much each pair is off, with a bar to the side that it is off to.
fn report(fit: &Fit, force: &sensor::Force, pairs: &[Weighing], circuit: &Circuit) -> String {
    let mut text = "   force      resistance        fit    residual\n".to_owned();
    let largest = pairs.iter().map(|&pair| fit.residual(pair).abs()).fold(1e-6, f64::max);
    for &pair in pairs {
        let residual = fit.residual(pair);
        let bar = "#".repeat((residual.abs() / largest * BAR as f64).round() as usize);
        let (left, right) = if residual < 0.0 { (bar, String::new()) } else { (String::new(), bar) };
        let row = format!(
            "{:>8.4} N {:>11.2} ohm {:>10.2} {:>+9.2} %  {left:>BAR$}|{right}",
            pair.f_n,
            pair.r_ohm,
            fit.r_ohm(pair.f_n).unwrap_or(pair.r_ohm),
            100.0 * residual
        );
        let _ = writeln!(text, "{}", row.trim_end());
    }
    let number = |value, u, unit| measured(value, u, unit, false);
    let _ = match fit.law {
        Law::Power { at_1_kohm_n, exponent } => writeln!(
            text,
            "F = F_1k (R / 1 kohm)^-p    F_1k = {}, p = {}",
            number(at_1_kohm_n, fit.u[0], "N"),
            number(exponent, fit.u[1], "").trim_end()
        ),
        Law::Alpha { alpha_n_ohm } => {
            writeln!(text, "R = alpha / F    alpha = {}", number(alpha_n_ohm, fit.u[0], "N ohm"))
        }
        _ => writeln!(text, "table of {} pairs; no force outside them", pairs.len()),
    };
    let [least, greatest] = weights(pairs);
    let names = ["F_c1", "F_c2"].into_iter().zip(["Rc1", "Rc2"]);
    for ((name, resistor), f_n) in names.zip(at_resistors(force, circuit)) {
        let beyond = match f_n {
            Some(f_n) if f_n < least => "; below all weights",
            Some(f_n) if f_n > greatest => "; above all weights",
            _ => "",
        };
        let f_n = f_n.map_or("outside the table".to_owned(), |f_n| format!("{f_n:.2} N"));
        let _ = writeln!(text, "{name} = {f_n} (at {resistor}{beyond})");
    }
    if let Some(rms) = fit.relative_rms(pairs) {
        let _ = writeln!(text, "relative rms of the residuals: {:.2} %", 100.0 * rms);
    }
    text + &meaning(fit, force, pairs, [least, greatest])
}

/// What the residuals say, and what follows from it.
fn meaning(fit: &Fit, force: &sensor::Force, pairs: &[Weighing], [least, greatest]: [f64; 2]) -> String {
    let mut lines = Vec::new();
    if let Law::Table { .. } = fit.law {
        return format!("readings outside of {} to {} have no force", Newton(least), Newton(greatest));
    }
    lines.push(match force.u {
        Some(u) => format!(
            "a residual is how much more resistance than the fit a weight made; they make forces uncertain by {} % (1 sigma)",
            rounded(100.0 * u, 2)
        ),
        None if fit.freedom(pairs) > 0 => {
            "all weights are on the fit: residuals of 0 say nothing, so forces have no u of their own; weigh once more".to_owned()
        }
        None => "as many numbers were fitted as there are weights: residuals of 0 say nothing, take more weights".to_owned(),
    });
    if let Some(power) = bend(fit, pairs) {
        lines.push(format!(
            "they are no scatter but a bend: `--model power` leaves {:.2} % of them",
            100.0 * power
        ));
    }
    // As they are stored.
    lines.push(match force.range_n {
        Some([least, greatest]) => {
            format!(
                "readings outside of {} to {} are marked as extrapolated",
                Newton(least),
                Newton(greatest)
            )
        }
        None => "weights of one force make no range, and none is stored: that of a data sheet stands in"
            .to_owned(),
    });
    lines.join("\n")
}

/// What residuals of one parameter a second one would leave, relative, where it takes most of them away.
fn bend(fit: &Fit, pairs: &[Weighing]) -> Option<f64> {
    let [one, two] = [fit.relative_rms(pairs)?, fit::power(pairs).ok()?.relative_rms(pairs)?];
    (matches!(fit.law, Law::Alpha { .. }) && pairs.len() > 3 && two < 0.5 * one).then_some(two)
}

/// Why a fit is none.
fn refusal(fit: &Fit, pairs: &[Weighing], model: Model) -> Option<String> {
    let rms = fit.relative_rms(pairs)?;
    let other = match model {
        Model::Alpha => "or try `--model power` or `table`",
        _ => "or try `--model table`",
    };
    (rms > WORST_FIT).then(|| {
        format!(
            "that is no fit: the weights are off it by {:.0} % rms, more than {:.0} %; nothing was changed. Look for a weight in \
             another unit, or typed for another reading, {other}",
            100.0 * rms,
            100.0 * WORST_FIT
        )
    })
}

/// The same for a machine; what is not known is absent.
#[derive(Serialize)]
#[serde(tag = "class", rename = "FORCE")]
struct ForceLine {
    channel: String,
    relative_rms: Option<f64>,
    pairs: Vec<PairLine>,
    #[serde(flatten)]
    numbers: BTreeMap<&'static str, f64>,
}

#[derive(Serialize)]
struct PairLine {
    f_n: f64,
    r_ohm: f64,
    residual: f64,
}

impl ForceLine {
    fn new(fit: &Fit, force: &sensor::Force, pairs: &[Weighing], target: &Target) -> ForceLine {
        let [fc1_n, fc2_n] = at_resistors(force, &target.config.circuit);
        let [u, u_exponent] = fit.u;
        let numbers = match fit.law {
            Law::Alpha { alpha_n_ohm } => vec![("alpha_n_ohm", Some(alpha_n_ohm)), ("alpha_u_n_ohm", u)],
            Law::Power { at_1_kohm_n, exponent } => vec![
                ("at_1_kohm_n", Some(at_1_kohm_n)),
                ("at_1_kohm_u_n", u),
                ("exponent", Some(exponent)),
                ("exponent_u", u_exponent),
            ],
            _ => Vec::new(),
        };
        let numbers = numbers.into_iter().chain([("fc1_n", fc1_n), ("fc2_n", fc2_n), ("u", force.u)]);
        let line =
            |pair: &Weighing| PairLine { f_n: pair.f_n, r_ohm: pair.r_ohm, residual: fit.residual(*pair) };
        ForceLine {
            channel: target.id.clone(),
            relative_rms: fit.relative_rms(pairs),
            pairs: pairs.iter().map(line).collect(),
            numbers: numbers.filter_map(|(key, value)| Some((key, value?))).collect(),
        }
    }
}
