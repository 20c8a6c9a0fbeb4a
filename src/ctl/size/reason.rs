//! Why nothing does what is asked for: which limit stops the circuit that comes nearest.

use super::asked::{Asked, milliampere};
use super::rehearsal::{Overall, Rehearsed};
use super::report::parts;
use crate::size::Pace;
use crate::size::limits::LONGEST_MEAN_S;
use crate::units::{Hertz, Ohm, Seconds};

/// `None` if the best does it.
pub fn why_not(asked: &Asked, best: Option<&Rehearsed>) -> Option<String> {
    let Some(best) = best else { return Some(too_fast(asked)) };
    let nearest = format!("the nearest is {}", parts(&best.design));
    let is_slow = |[inaccurate, slow]: [f64; 2]| slow > inaccurate;
    let reason = match best.overall {
        _ if best.meets => return None,
        Err(r_ohm) => format!("in the time that there is it gives no number at {:.3}", Ohm(r_ohm)),
        Ok(overall) if is_slow(overall.lacks(asked)) => too_slow(best, overall),
        Ok(overall) => too_inaccurate(asked, best, overall),
    };
    Some(format!("nothing does that: {nearest}, and {reason}"))
}

fn too_slow(best: &Rehearsed, overall: Overall) -> String {
    let [charge, discharge, calls] = best.worst.1.time.map(Seconds);
    format!(
        "it gives {:.1} readings a second at its slowest: at {:.3} one takes {charge:.2} to charge, {discharge:.2} to discharge \
         and {calls:.2} for calls, and calibration comes on top",
        overall.rate_hz,
        Ohm(best.worst.0),
    )
}

fn too_inaccurate(asked: &Asked, best: &Rehearsed, overall: Overall) -> String {
    let (r_ohm, shares) = best.worst;
    let names =
        ["jitter of the kernel's stamps", "not knowing exactly when lines move", "noise at the inputs"];
    let (most, name) =
        shares.variance.into_iter().zip(names).max_by(|(a, _), (b, _)| a.total_cmp(b)).unwrap_or((0.0, ""));
    let percent = 100.0 * most / shares.variance();
    let remedy = match (best.design.pace, asked.search.need.rate_hz) {
        (Pace::Mean(time), _) => format!(
            "means over {:.2} are not enough, and means are not made over more than {}",
            Seconds::from(time),
            Seconds(LONGEST_MEAN_S)
        ),
        (_, Some(wanted)) => format!(
            "as errors of means go with the root of their time, about {:.2} would do",
            Hertz(wanted.min(overall.rate_hz) / overall.error.powi(2))
        ),
        _ => "a mean over some time is needed".to_owned(),
    };
    format!(
        "its error is {:.1} times what is asked for: at {:.3} {percent:.0} % of the variance is {name} of board {}; {remedy}",
        overall.error,
        Ohm(r_ohm),
        asked.name,
    )
}

/// No discharge is so short.
fn too_fast(asked: &Asked) -> String {
    let wanted = asked.search.need.rate_hz.unwrap_or_default();
    let Some((design, time)) = asked.search.quickest() else {
        return "nothing can be built: with two capacitors, C_B has to be so much smaller than C_A that node B falls below its \
                threshold; more capacitors to choose from are needed"
            .to_owned();
    };
    let [charge, discharge, calls] = time.map(Seconds);
    format!(
        "nothing is as fast as {:.3}: the quickest is {}, whose calibration takes {charge:.2} to charge (through {}, for \
         pins of {}), {discharge:.2} for the discharge and {calls:.2} for the calls of board {}",
        Hertz(wanted),
        parts(&design),
        design.r_p,
        milliampere(asked.search.pin_a),
        asked.name,
    )
}
