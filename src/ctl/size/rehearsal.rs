//! The best few candidates, rehearsed with the configuration that would be written, and tuned until they do what is asked for.

use super::asked::Asked;
use super::file;
use crate::ctl::CtlError;
use crate::ctl::check::expect::{Expected, built, rehearse};
use crate::ctl::limits::{CONFIRMING, ENOUGH, GOOD, REHEARSED_RESISTANCES, TOO_GOOD, TUNINGS};
use crate::size::limits::LONGEST_MEAN_S;
use crate::size::{Design, Pace, Price, Ranked, Shares};
use crate::units::{Nanos, rounded};

/// A circuit and what is to be expected of it.
#[derive(Debug, Clone)]
pub struct Rehearsed {
    pub design: Design,
    pub price: Price,
    /// Over the range; a resistance that gives no number is missing.
    pub expected: Vec<Expected>,
    /// Over the whole range; else the first resistance that gives no number, ohm.
    pub overall: Result<Overall, f64>,
    /// It does all that is asked for.
    pub meets: bool,
    /// Where it is worst by closed forms, and why.
    pub worst: (f64, Shares),
    /// On how many boards it was rehearsed.
    pub boards: usize,
}

/// The worst of a circuit over a range of which every resistance gives a number.
#[derive(Debug, Clone, Copy)]
pub struct Overall {
    /// How many times the error that is asked for; of the reading, where none is.
    pub error: f64,
    /// Readings per second.
    pub rate_hz: f64,
}

/// The shortlist of what is ranked.
pub fn all(asked: &Asked, ranked: &[Ranked]) -> Result<Vec<Rehearsed>, CtlError> {
    let candidates = shortlist(asked, ranked);
    let tuned = std::thread::scope(|scope| {
        let running: Vec<_> = candidates
            .iter()
            .map(|one| scope.spawn(move || tuned(asked, &one.design, one.worst, 1)))
            .collect();
        running.into_iter().map(|one| one.join()).collect::<Vec<_>>()
    });
    let died = |_| CtlError::said("a rehearsal has died: this is a mistake in cermctl");
    tuned.into_iter().map(|one| one.map_err(died)?).collect()
}

/// In the order of how well they do what is asked for; those without a number at some resistance come last.
fn sort(asked: &Asked, all: &mut [Rehearsed]) {
    let merit = |one: &Rehearsed| one.merit(asked).unwrap_or(f64::INFINITY);
    all.sort_by(|a, b| b.meets.cmp(&a.meets).then(merit(a).total_cmp(&merit(b))));
    prefer_cheap(asked, all);
}

impl Rehearsed {
    /// The less the better: error where a rate is asked for, seconds where an error is; how much it lacks where it lacks something.
    fn merit(&self, asked: &Asked) -> Option<f64> {
        let overall = self.overall.ok()?;
        Some(match asked.search.need.rate_hz {
            _ if !self.meets => overall.lacks(asked).into_iter().fold(0.0, f64::max),
            Some(_) => overall.error,
            None => 1.0 / overall.rate_hz,
        })
    }
}

impl Overall {
    /// How many times too inaccurate and too slow it is.
    pub fn lacks(&self, asked: &Asked) -> [f64; 2] {
        let need = &asked.search.need;
        let slow = need.rate_hz.map_or(0.0, |wanted| wanted / self.rate_hz);
        [if need.tolerance.is_some() { self.error } else { 0.0 }, slow]
    }
}

/// The cheapest comes first of those that do all that is asked for, or that are hardly worse where only one thing is.
fn prefer_cheap(asked: &Asked, all: &mut [Rehearsed]) {
    let need = &asked.search.need;
    let both = need.tolerance.is_some() && need.rate_hz.is_some();
    let Some(best) = all.first().filter(|best| best.meets).and_then(|best| best.merit(asked)) else { return };
    let is_near = |one: &Rehearsed| one.merit(asked).is_some_and(|merit| merit <= ENOUGH * best);
    let is_good = |one: &Rehearsed| one.meets && (both || is_near(one));
    let first =
        (0..all.len()).filter(|index| is_good(&all[*index])).min_by_key(|index| (all[*index].price, *index));
    if let Some(first) = first {
        all[..=first].rotate_right(1);
    }
}

/// The best of each wiring and price class, and of all the next best with other capacitors.
fn shortlist<'a>(asked: &Asked, ranked: &'a [Ranked]) -> Vec<&'a Ranked> {
    let class = |one: &Ranked| (one.design.kind(), one.design.price(&asked.search.stock));
    let mut list: Vec<&Ranked> = Vec::new();
    for one in ranked {
        let others = list.iter().filter(|other| class(other) == class(one)).count();
        let is_new = list.iter().all(|other| other.design.network != one.design.network);
        if others == 0 || (others == 1 && is_new) {
            list.push(one);
        }
    }
    list
}

/// Rehearsed on so many boards, with the mean as long as it has to be.
fn tuned(asked: &Asked, design: &Design, worst: (f64, Shares), boards: usize) -> Result<Rehearsed, CtlError> {
    let need = &asked.search.need;
    let mut best: Option<Rehearsed> = None;
    let mut design = design.clone();
    for _ in 0..TUNINGS {
        let done = rehearsed(asked, &design, worst, boards)?;
        let next = match (need.tolerance, need.rate_hz, &done.overall) {
            (Some(_), None, Ok(overall)) if !(TOO_GOOD..=GOOD).contains(&overall.error) => {
                longer(&design, overall)
            }
            _ => None,
        };
        let is_better = best.as_ref().is_none_or(|best| match (&done.overall, &best.overall) {
            (Ok(new), Ok(old)) if best.meets => done.meets && new.rate_hz > old.rate_hz,
            (Ok(new), Ok(old)) => done.meets || new.error < old.error,
            (new, old) => new.is_ok() && old.is_err(),
        });
        if is_better {
            best = Some(done);
        }
        match next {
            Some(next) => design.pace = next,
            None => break,
        }
    }
    best.ok_or_else(|| CtlError::said("nothing was rehearsed"))
}

/// Sorted, the first of them tuned on more boards of the kind: what was long enough on the first board alone may not be.
pub fn confirmed(asked: &Asked, all: &mut [Rehearsed]) -> Result<(), CtlError> {
    sort(asked, all);
    while let Some(first) = all.first_mut().filter(|first| first.boards < CONFIRMING) {
        *first = tuned(asked, &first.design, first.worst, CONFIRMING)?;
        sort(asked, all);
    }
    Ok(())
}

/// The mean that would do, as errors go with the root of the time; `None` if there is none.
fn longer(design: &Design, done: &Overall) -> Option<Pace> {
    let mean_s = match design.pace {
        Pace::Mean(time) => time.as_seconds(),
        _ if done.error > GOOD => 1.0 / done.rate_hz,
        _ => return None,
    };
    let wanted_s = rounded(mean_s * (done.error / (0.5 * (GOOD + TOO_GOOD))).powi(2), 2);
    let is_other = wanted_s != mean_s && wanted_s <= LONGEST_MEAN_S;
    is_other.then(|| Pace::Mean(Nanos::from_seconds(wanted_s)))
}

/// On so many boards.
pub(super) fn rehearsed(
    asked: &Asked,
    design: &Design,
    worst: (f64, Shares),
    boards: usize,
) -> Result<Rehearsed, CtlError> {
    let need = &asked.search.need;
    let mut config = file::parsed(asked, design)?;
    for channel in &mut config.channels {
        // As after commissioning.
        (channel.zero_ohm, channel.scale) = (Some(design.r_lim.0), Some(1.0));
    }
    let settings = config.settings().map_err(CtlError::said)?;
    let scene = built(asked.scene.clone(), &design.circuit(&asked.search.platform));
    let resistances = need.resistances(REHEARSED_RESISTANCES);
    let of =
        |r_ohm: &f64| rehearse(&settings, scene.as_ref()?, *r_ohm, boards).filter(|one| one.u_ohm.is_some());
    let expected: Vec<Expected> = resistances.iter().filter_map(of).collect();
    let silent = resistances.iter().find(|r_ohm| expected.iter().all(|one| one.r_ohm != **r_ohm));
    let overall = match silent {
        Some(r_ohm) => Err(*r_ohm),
        None => {
            let ratios = expected.iter().filter_map(|one| Some(one.u_ohm? / need.ohm_at(one.r_ohm)));
            let rate_hz = expected.iter().map(|one| one.rate_hz).fold(f64::INFINITY, f64::min);
            Ok(Overall { error: ratios.fold(0.0, f64::max), rate_hz })
        }
    };
    let is_good = |overall: &Overall| need.tolerance.is_none() || overall.error <= GOOD;
    let is_fast = |overall: &Overall| need.rate_hz.is_none_or(|wanted| overall.rate_hz >= wanted);
    let meets = overall.is_ok_and(|overall| is_good(&overall) && is_fast(&overall));
    let price = design.price(&asked.search.stock);
    Ok(Rehearsed { design: design.clone(), price, expected, overall, meets, worst, boards })
}
