//! Leakage, by discharges that were held back.
//!
//! A discharge is interrupted [early or late](LEAK_HELD_AT) on its way for the time h. While everything floats, a leak of conductance
//! G takes G h off the rest of it, so that it ends G h (R_2+Ro) earlier; what feeds the node, as a pull-up does, makes it
//! later. At the voltage [between](LEAK_AVERAGE) either does what it does on average over a discharge, so that one number tells both. What
//! both levels differ by tells whether it is a resistor to ground at all: a current, a pull-up, a pull-up beside a leak and a
//! dielectric that takes charge in or gives it back are none. By how much more node B loses meanwhile tells at which node it is.
//!
//! What shows is [taken out](Undone) of the times of every other discharge; what is [left](Course) of it, and what does not show, is in the
//! uncertainty.

mod beside;
mod left;
mod undone;

use crate::estimate::limits::{
    BEYOND_LATE, COVERAGE, GROSS_LEAK_SIEMENS, LEAK_AVERAGE, LEAK_EVERY, LEAK_FIRST, LEAK_GROSS_FIRST,
    LEAK_HELD_AT, LEAK_HOLD, LEAK_LARGE_AT_B, LEAK_REMEMBERED, LEAK_TAKES, LIKELY_LEAK_SIEMENS, LOOK_SHOWS,
};
use crate::estimate::look::{Looks, beyond};
use crate::units::Nanos;
pub use beside::{Beside, Ways};
pub use left::{Course, Left};
pub use undone::Undone;

/// What discharges that were held early and late have shown.
type Levels = [Looks<LEAK_REMEMBERED>; 2];

/// By how much a held discharge was shorter, with the variance of that, ns and ns².
#[derive(Debug, Clone, Copy)]
pub struct Lost {
    /// Until node A crossed.
    pub to_a: [f64; 2],
    /// By how much more until B did; `None`: it was not waited for.
    pub more_to_b: Option<[f64; 2]>,
    /// How long it was held, ns.
    pub held_ns: f64,
    /// R_2 with Ro, ohm.
    pub r_ohm: f64,
}

impl Lost {
    /// The leak that makes a discharge shorter by so long, with its variance, siemens and its square.
    fn siemens_of(&self, [ns, variance]: [f64; 2]) -> [f64; 2] {
        let by = 1.0 / (self.held_ns * self.r_ohm);
        [by * ns, by * by * variance]
    }
}

/// How long a discharge through R_2 is to be held that takes so long as a rule; `r_ohm`: R_2 with Ro. Small capacitors lose as much in less
/// time.
pub fn hold(takes_ns: f64, r_ohm: f64) -> Nanos {
    Nanos((LEAK_TAKES * takes_ns / (GROSS_LEAK_SIEMENS * r_ohm)) as i64).min(LEAK_HOLD)
}

/// The held discharges so far, siemens, at either level.
#[derive(Debug, Clone, Copy, Default)]
pub struct LeakTest {
    at_a: Levels,
    more_at_b: Levels,
    undone: Undone,
    /// There was one beside which nothing can be measured.
    was_defect: bool,
    /// A dielectric looks like a leak, and is none: nothing is undone.
    is_dielectric: bool,
    /// There is a node B, for which others wait, too.
    has_b: bool,
    r2_ohm: f64,
    /// What all of them tell: found once for each of them, since every reading asks.
    told: Told,
    left: Left,
}

#[derive(Debug, Clone, Copy, Default)]
struct Told {
    is_known: bool,
    at_a: Shown,
    more_at_b: Shown,
    /// Beside what is undone.
    rest: [Shown; 2],
}

impl LeakTest {
    /// Of a circuit with one or two `nodes`; `r2_ohm`: the higher one of the resistors of calibration.
    pub fn new(nodes: usize, r2_ohm: f64) -> LeakTest {
        LeakTest { has_b: nodes == 2, r2_ohm, ..LeakTest::default() }
    }

    /// What others have [found](Self::found) at A, and [beyond that](Self::found_at_b) at B.
    pub fn knows(
        self,
        at_a: [[f64; 2]; 2],
        more_at_b: Option<[[f64; 2]; 2]>,
        is_dielectric: bool,
    ) -> LeakTest {
        let (at_a, more_at_b) = (at_a.map(Looks::known), more_at_b.map(|levels| levels.map(Looks::known)));
        let more_at_b = more_at_b.unwrap_or_default();
        let mut test = LeakTest { at_a, more_at_b, is_dielectric, ..self };
        test.tell();
        test.undone = test.undoable();
        test.tell();
        test
    }

    /// The leak at either level with 1 sigma, siemens, once it is known. A level of which nothing is known is as the other.
    pub fn found(&self) -> Option<[[f64; 2]; 2]> {
        self.is_known().then(|| found(&self.at_a)).flatten()
    }

    /// The same of what B loses more; `None` where nobody has waited for it.
    pub fn found_at_b(&self) -> Option<[[f64; 2]; 2]> {
        self.is_known().then(|| found(&self.more_at_b)).flatten()
    }

    /// Whether a held discharge is due.
    pub fn is_due(&self, now: Nanos) -> bool {
        let are_due =
            |levels: &Levels| levels.iter().any(|looks| looks.is_due(now, LEAK_FIRST / 2, LEAK_EVERY));
        // Nothing is measured meanwhile, so it is seen at once when that is over.
        self.is_defect() || are_due(&self.at_a) || self.waits_for_b() && are_due(&self.more_at_b)
    }

    /// Whether it goes on to B: once something shows at A, at which node it is.
    pub fn waits_for_b(&self) -> bool {
        self.has_b && self.is_known() && (self.undone.is_any() || self.told.at_a.is_any())
    }

    /// After which part of it the next one is to be held.
    pub fn held_at(&self) -> f64 {
        LEAK_HELD_AT[self.next()]
    }

    /// The first ones at the end, where a defect of any kind shows, then by turns.
    fn next(&self) -> usize {
        let [early, late] = self.at_a.each_ref().map(Looks::tried);
        usize::from(early + late < LEAK_GROSS_FIRST || late <= early)
    }

    /// Takes the one that was [due](Self::held_at), whether it told something or not.
    pub fn add(&mut self, lost: Option<Lost>, now: Nanos) {
        let next = self.next();
        if self.waits_for_b() {
            let more = lost.and_then(|lost| Some(lost.siemens_of(lost.more_to_b?)));
            self.more_at_b[next].add(more, now);
        }
        self.at_a[next].add(lost.map(|lost| lost.siemens_of(lost.to_a)), now);
        self.tell();
    }

    fn tell(&mut self) {
        let [of_a, of_b] = self.undone.lost();
        self.told = Told {
            is_known: self.are_enough(),
            at_a: Shown::of(&self.at_a, [0.0; 2]),
            more_at_b: Shown::of(&self.more_at_b, [0.0; 2]),
            rest: [Shown::of(&self.at_a, of_a), Shown::of(&self.more_at_b, of_b)],
        };
        self.left = self.what_is_left();
    }

    /// The leak, siemens, if there is one that shows; negative for what feeds the node.
    pub fn siemens(&self) -> Option<f64> {
        let leak = self.likely_siemens();
        (self.is_known() && leak.abs() > LOOK_SHOWS * self.u_siemens()).then_some(leak)
    }

    /// 1 sigma of that, siemens.
    pub fn u_siemens(&self) -> f64 {
        self.told.at_a.average[1]
    }

    /// The likely leak, siemens, whether it shows or not: nobody has seen that there is none. Before there has been a look, one
    /// that could be.
    pub fn likely_siemens(&self) -> f64 {
        if self.is_known() { self.told.at_a.average[0] } else { LIKELY_LEAK_SIEMENS }
    }

    /// Whether what shows is at B.
    pub fn is_at_b(&self) -> bool {
        self.is_known() && self.told.more_at_b.is_any()
    }

    /// What is taken out of times.
    pub fn undone(&self) -> &Undone {
        &self.undone
    }

    /// Whether there is a leak beside which nothing can be measured.
    pub fn is_defect(&self) -> bool {
        self.is_known() && self.likely_siemens().abs() > GROSS_LEAK_SIEMENS
    }

    /// Capacitors absorb, or do not.
    pub fn set_dielectric(&mut self, is_dielectric: bool) {
        self.is_dielectric = is_dielectric;
    }

    /// What is to be undone from now on, if that is something else: a leak has come, grown or gone, or shows at another place.
    pub fn has_changed(&mut self) -> bool {
        let undoable = self.undoable();
        // Of a defect nothing is measured, however it changes.
        let is_defect = self.is_defect();
        let was_defect = std::mem::replace(&mut self.was_defect, is_defect);
        let tried: usize = self.more_at_b.iter().map(Looks::tried).sum();
        let is_ready = self.is_known() && (tried >= LEAK_FIRST || !self.waits_for_b());
        let is_other = self.told.rest.iter().any(Shown::is_any) || !undoable.is_any();
        let has_changed = is_defect != was_defect || is_ready && is_other && undoable != self.undone;
        if has_changed {
            self.undone = undoable;
            self.tell();
        }
        has_changed
    }

    /// What shows; beside a defect a discharge that is held may end meanwhile, and shows no more how much it is.
    fn undoable(&self) -> Undone {
        if self.is_dielectric || self.is_defect() {
            return Undone::default();
        }
        Undone::of([self.told.at_a.levels(), self.told.more_at_b.levels()])
    }

    /// What is left in times that it is [undone](Self::undone) in.
    pub fn left(&self) -> Left {
        if self.is_known() { self.left } else { Left { likely: LIKELY_LEAK_SIEMENS, ..Left::default() } }
    }

    fn what_is_left(&self) -> Left {
        let ([at_a, at_b], [of_a, of_b]) = (self.told.rest, self.undone.lost());
        let (is_undone, undone) = (self.undone.is_any(), middle(of_a));
        let noise = |shown: [f64; 2]| if is_undone { shown[1] } else { 0.0 };
        // Where nobody has waited for B, it may all be there.
        let alone = match self.more_at_b.iter().all(|looks| looks.taken() == 0) {
            true => self.told.at_a.average[0],
            false => at_b.average[0].hypot(2.0 * at_b.average[1]).hypot(at_b.bent()),
        };
        let [early, late] = [0, 1].map(|level| of_a[level] + of_b[level]);
        let large = LEAK_LARGE_AT_B * middle(of_b).powi(2) * self.r2_ohm;
        let alone = alone.hypot(BEYOND_LATE * (late - early)).hypot(large);
        let is_at_b = self.has_b && (is_undone || self.siemens().is_some());
        Left {
            likely: at_a.average[0],
            noise: noise(at_a.average),
            bent: at_a.bent().hypot(noise(at_a.bend)),
            at_b: if is_at_b { alone } else { 0.0 },
            undone,
        }
    }

    /// Whether the look is wanting without which nothing is to be said of a sensor, or those that make sure of a defect.
    pub fn is_wanting(&self) -> bool {
        let tried: usize = self.at_a.iter().map(Looks::tried).sum();
        tried == 0 || tried < LEAK_GROSS_FIRST && self.is_gross()
    }

    /// Whether there have been looks enough.
    pub fn is_known(&self) -> bool {
        self.told.is_known
    }

    /// For a defect a few that agree, since nothing else is so large.
    fn are_enough(&self) -> bool {
        let taken: usize = self.at_a.iter().map(Looks::taken).sum();
        taken >= if self.is_gross() { LEAK_GROSS_FIRST } else { LEAK_FIRST }
    }

    /// Whether each look so far has shown a defect.
    fn is_gross(&self) -> bool {
        let all = || self.at_a.iter().flat_map(|looks| looks.remembered());
        [1.0, -1.0].iter().any(|sign| all().all(|siemens| sign * siemens > GROSS_LEAK_SIEMENS))
    }
}

/// What looks show beside something that is known already, siemens: on average over a discharge, and by how much more late in it than
/// early, each with 1 sigma.
#[derive(Debug, Clone, Copy, Default)]
struct Shown {
    average: [f64; 2],
    bend: [f64; 2],
    both: [f64; 2],
}

impl Shown {
    fn of(looks: &Levels, [early, late]: [f64; 2]) -> Shown {
        let [at_early, at_late] = looks.each_ref().map(Looks::median);
        let ([value, u], noise) = (average(looks), looks.each_ref().map(Looks::noise_among));
        let is_both = looks.iter().all(|looks| looks.taken() > 0);
        let bend = if is_both { at_late - late - (at_early - early) } else { 0.0 };
        Shown {
            average: [value - middle([early, late]), u],
            bend: [bend, noise[0].hypot(noise[1])],
            both: [at_early, at_late],
        }
    }

    fn is_any(&self) -> bool {
        shows(self.average) || shows(self.bend)
    }

    /// Early and late: alike as long as a difference does not show.
    fn levels(&self) -> [f64; 2] {
        match (shows(self.bend), shows(self.average)) {
            (true, _) => self.both,
            (false, true) => [self.average[0]; 2],
            _ => [0.0; 2],
        }
    }

    /// By how much it bends beyond what noise does once in twenty times.
    fn bent(&self) -> f64 {
        beyond(self.bend[0], COVERAGE * self.bend[1])
    }
}

fn shows([value, u]: [f64; 2]) -> bool {
    value.abs() > LOOK_SHOWS * u
}

fn found(levels: &Levels) -> Option<[[f64; 2]; 2]> {
    let [early, late] = levels;
    if early.taken() + late.taken() == 0 {
        return None;
    }
    let known = [[early, late], [late, early]].map(|[own, other]| if own.taken() > 0 { own } else { other });
    Some(known.map(|looks| [looks.median(), looks.noise_among()]))
}

/// What leaks on average over a discharge, with 1 sigma; as at the other level where nothing is known of one.
fn average(levels: &Levels) -> [f64; 2] {
    let [early, late] = levels;
    match (early.taken(), late.taken()) {
        (0, _) => [late.median(), late.noise_among()],
        (_, 0) => [early.median(), early.noise_among()],
        _ => {
            let [of_early, of_late] = WEIGHTS;
            let u = (of_early * early.noise_among()).hypot(of_late * late.noise_among());
            [middle([early.median(), late.median()]), u]
        }
    }
}

/// The parts of both levels in what a leak does on average over a discharge.
const WEIGHTS: [f64; 2] = {
    let [early, late] = LEAK_HELD_AT;
    let of_late = (LEAK_AVERAGE - early) / (late - early);
    [1.0 - of_late, of_late]
};

fn middle([early, late]: [f64; 2]) -> f64 {
    WEIGHTS[0] * early + WEIGHTS[1] * late
}

#[cfg(test)]
mod tests;
