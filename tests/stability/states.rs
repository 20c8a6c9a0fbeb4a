//! Defects of the circuit, one at a time: they come while the instrument runs, stay, and go again.

use crate::common::{Bench, kind_of, name_of, times};
use crate::picture;
use crate::scenario::Mark;
use cermd::circuit::Node;
use cermd::instrument::cycle::longest_reading;
use cermd::instrument::{Instrument, Message};
use cermd::pins::Pins;
use cermd::pins::sim::{SimCircuit, SimPins};
use cermd::reading::Suspect;
use cermd::reading::{Fault, Method, Reading, Status};
use cermd::units::Nanos;
use std::collections::BTreeMap;
use std::fmt::Write;

const R_OHM: f64 = 1000.0;
/// Boards of each method and defect; the page has what the first one says. `CERMD_BOARDS=10` takes ten times as many.
const BOARDS: u64 = 4;
/// Longer than any pin's output resistance: nothing there.
const BROKEN: f64 = 1e12;
/// Readings before, with and after the defect.
const BEFORE: usize = 400;
const DURING: usize = 200;
const AFTER: usize = 400;
/// Readings and time that a method has to find out, and to find back: where each reading shows the defect, and where only the
/// discharges do that are held back every 5 s.
const TO_NOTICE: (usize, Nanos) = (100, Nanos(3_000_000_000));
const TO_NOTICE_HELD: (usize, Nanos) = (500, Nanos(12_000_000_000));
/// A number farther from the truth is wrong: 5 of its own sigma and 1 %.
const WRONG: (f64, f64) = (5.0, 0.01);
/// What the system may add to a reading.
const FOR_THE_SYSTEM: Nanos = Nanos(20_000_000);

/// A defect, and what a fault because of it may look like.
struct Defect {
    name: &'static str,
    change: fn(&mut SimCircuit),
    suspects: &'static [Suspect],
    to_notice: (usize, Nanos),
}

const fn defect(name: &'static str, change: fn(&mut SimCircuit), suspects: &'static [Suspect]) -> Defect {
    Defect { name, change, suspects, to_notice: TO_NOTICE }
}

fn capacitors(circuit: &mut SimCircuit, factor_a: f64, factor_b: f64) {
    let (first, second) = circuit.network.capacitors();
    first.0 *= factor_a;
    second.into_iter().for_each(|c_b| c_b.0 *= factor_b);
}

const DEFECTS: [Defect; 14] = [
    defect("no sensor", |c| c.r_x[0] = f64::INFINITY, &[]),
    defect("short circuit of the sensor", |c| c.r_x[0] = 0.0, &[]),
    defect("broken wire to Rc1", |c| c.r_c1 = BROKEN, &[Suspect::FirstOpen, Suspect::BothOpen]),
    defect("broken wire to Rc2", |c| c.r_c2 = BROKEN, &[Suspect::SecondOpen]),
    defect("Rc1 and Rc2 swapped", |c| std::mem::swap(&mut c.r_c1, &mut c.r_c2), &[Suspect::ResistorsSwapped]),
    defect("C_A missing", |c| capacitors(c, 1e-5, 1.0), &[Suspect::NoCA, Suspect::NoCapacitor]),
    defect("C_B missing", |c| capacitors(c, 1.0, 1e-5), &[Suspect::NoCB, Suspect::NoCapacitor]),
    defect("20 kohm of leakage at node A", |c| c.sense[0].to_ground = 1.0 / 20e3, &[Suspect::Leak]),
    Defect {
        to_notice: TO_NOTICE_HELD,
        ..defect("150 kohm of leakage at node A", |c| c.sense[0].to_ground = 1.0 / 150e3, &[Suspect::Leak])
    },
    defect(
        "pull-up of 50 kohm left on at A and B",
        |c| c.sense.iter_mut().for_each(|sense| sense.to_v_dd = 1.0 / 50e3),
        &[Suspect::Pull, Suspect::StaysHigh(Node::B)],
    ),
    defect("V_DD 20 % low", |c| c.v_dd *= 0.8, &[]),
    defect(
        "sense line A stuck high",
        |c| c.sense[0].falling = -1.0,
        &[Suspect::StaysHigh(Node::A), Suspect::BothOpen],
    ),
    defect("sense line B stuck high", |c| c.sense[1].falling = -1.0, &[Suspect::StaysHigh(Node::B)]),
    defect(
        "sense line B stuck low",
        |c| (c.sense[1].falling, c.sense[1].rising) = (98.0, 99.0),
        &[Suspect::Uncharged(Node::B)],
    ),
];

/// What an instrument said in some readings.
#[derive(Default)]
struct Said {
    names: BTreeMap<String, usize>,
    suspects: BTreeMap<&'static str, usize>,
    wrong: usize,
    readings: usize,
    longest: Nanos,
}

impl Said {
    fn add(&mut self, reading: &Reading, truth: f64) {
        let name = match reading.status {
            Status::Ok { r_ohm, .. } => {
                // Any number of ohms is infinitely far from an open circuit, and all of itself in conductance.
                let away = if truth.is_finite() { (r_ohm.value - truth).abs() / r_ohm.value } else { 1.0 };
                let u = r_ohm.u.unwrap_or(f64::INFINITY) / r_ohm.value;
                let wrong = away > WRONG.0 * u && away > WRONG.1;
                self.wrong += usize::from(wrong);
                if wrong { "wrong number".to_owned() } else { "ok".to_owned() }
            }
            Status::Fault(fault) => fault.as_str().to_owned(),
            status => {
                let sound = match status {
                    Status::Open { r_min_ohm, .. } => r_min_ohm <= truth * 1.01,
                    _ => truth <= 50.0,
                };
                self.wrong += usize::from(!sound);
                if sound { name_of(&status).to_owned() } else { format!("wrong {}", name_of(&status)) }
            }
        };
        *self.names.entry(name).or_default() += 1;
        self.readings += 1;
        if let Some(suspect) = reading.suspect {
            *self.suspects.entry(suspect.seen()).or_default() += 1;
        }
        self.longest = Nanos(self.longest.0.max(reading.duration.0));
    }

    /// Right numbers and bounds, or that there is none, or what is neither.
    fn mark(&self) -> Mark {
        let faults =
            self.names.iter().filter(|(name, _)| Fault::ALL.iter().any(|fault| fault.as_str() == *name));
        let faults: usize = faults.map(|(_, count)| count).sum();
        match (self.wrong * 20 > self.readings, faults * 20 > self.readings) {
            (true, _) => Mark::Fails,
            (false, true) => Mark::Told,
            (false, false) => Mark::Holds,
        }
    }

    /// The commonest first, those of less than 2 % left out.
    fn in_words(&self) -> String {
        let mut names: Vec<_> = self.names.iter().filter(|(_, count)| **count * 50 > self.readings).collect();
        names.sort_by_key(|(name, count)| (usize::MAX - **count, (*name).clone()));
        names.into_iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", ")
    }
}

fn listen(instrument: &mut Instrument<SimPins>, (count, time): (usize, Nanos), truth: f64) -> Said {
    let mut said = Said::default();
    let end = instrument.pins().now() + time;
    while said.readings < count || instrument.pins().now() < end {
        instrument
            .step(&mut |message| {
                if let Message::Reading(reading) = message {
                    said.add(&reading, truth);
                }
            })
            .unwrap();
    }
    said
}

/// One row's cell for a method on one board, how the method fares, and what is wrong with it.
fn examine(defect: &Defect, method: Method, seed: u64) -> (String, Mark, Option<String>) {
    let bench = Bench::with_kind(
        "pi4",
        kind_of(method),
        method,
        R_OHM,
        seed,
        "deadline = \"60 ms\"\noffset = \"auto\"",
    );
    let (pins, settings) = bench.parts();
    let bound = longest_reading(&settings) + FOR_THE_SYSTEM;
    let mut instrument = Instrument::new(pins, settings);
    let well = listen(&mut instrument, (BEFORE, Nanos::ZERO), R_OHM);
    let healthy = instrument.pins().circuit().clone();
    instrument.pins().alter(defect.change);
    let truth = instrument.pins().circuit().r_x[0];
    let noticing = listen(&mut instrument, defect.to_notice, truth);
    let ill = listen(&mut instrument, (DURING, Nanos::ZERO), truth);
    instrument.pins().alter(|circuit| *circuit = healthy);
    let recovering = listen(&mut instrument, defect.to_notice, R_OHM);
    let cured = listen(&mut instrument, (AFTER, Nanos::ZERO), R_OHM);
    let longest = [&well, &noticing, &ill, &recovering, &cured].map(|said| said.longest.0).into_iter().max();

    let mut wrong = String::new();
    let sights: Vec<_> = defect.suspects.iter().map(|suspect| suspect.seen()).collect();
    if ill.suspects.keys().any(|sight| !sights.contains(sight)) {
        write!(wrong, "looks like {:?}; ", ill.suspects).unwrap();
    }
    let faults = ill.names.iter().filter(|(name, _)| Fault::ALL.iter().any(|fault| fault.as_str() == *name));
    let (faults, told): (usize, usize) = (faults.map(|(_, count)| count).sum(), ill.suspects.values().sum());
    if !sights.is_empty() && faults * 20 > ill.readings && told * 20 < faults * 19 {
        write!(wrong, "{faults} faults, {told} of them with a suspect; ").unwrap();
    }
    if ill.wrong * 20 > ill.readings {
        write!(wrong, "wrong {} of {}, {} before that; ", ill.wrong, ill.readings, noticing.wrong).unwrap();
    }
    if cured.wrong * 50 > AFTER || cured.names.get("ok").is_none_or(|ok| *ok * 20 < AFTER * 19) {
        write!(wrong, "does not recover: {:?}; ", cured.names).unwrap();
    }
    if longest > Some(bound.0) {
        write!(wrong, "took {longest:?} ns, bound {bound:?}; ").unwrap();
    }
    let wrong = (!wrong.is_empty())
        .then(|| format!("{}, {}, seed {seed}: {wrong}{:?}\n", defect.name, method.as_str(), ill.names));
    (ill.in_words(), ill.mark(), wrong)
}

/// The table, its rows in the picture, and what is not as it should be.
pub fn report() -> (String, Vec<picture::Row>, String) {
    let mut table = String::from("| defect | looks like |");
    let (mut rows, mut wrong) = (Vec::new(), String::new());
    for method in Method::ALL {
        write!(table, " {} |", method.as_str()).unwrap();
    }
    table.push_str("\n|---|---|---|---|---|---|---|\n");
    for defect in &DEFECTS {
        let sights: Vec<_> = defect.suspects.iter().map(|suspect| suspect.seen()).collect();
        write!(table, "| {} | {} |", defect.name, sights.join("; or: ")).unwrap();
        let mut marks = Vec::new();
        for method in Method::ALL {
            for seed in 1..=BOARDS * times() {
                let (cell, mark, failure) = examine(defect, method, seed);
                wrong.extend(failure);
                if seed == 1 {
                    write!(table, " {cell} |").unwrap();
                    marks.push([None, Some((mark, cell))]);
                }
            }
        }
        rows.push(picture::Row { name: defect.name.to_owned(), marks });
        table.push('\n');
    }
    (format!("{HEAD}\n{table}"), rows, wrong)
}

const HEAD: &str = "## Defects of the circuit\n\n\
Board `pi4`, a sensor of 1 kohm, deadline 60 ms, seed 1. Each comes while the instrument runs, and goes again; the table has what \
the readings say from the 100th and from 3 s on after it has come (150 kohm of leakage, found by the discharges of the next section: \
the 500th and 12 s), the commonest first (below 2 % left out). `wrong number`: off by more than 1 % and by more than 5 of its own sigma. Each \
method gives right numbers again by itself within as many readings and as much time after the defect is gone, and no reading takes longer than \
its bound. `looks like`: what the readings' `hint` begins with; what to look at follows there.\n";
