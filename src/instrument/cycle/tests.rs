//! A cycle by itself: its discharges come out as a test says.

use super::*;
use crate::config_file::config;
use crate::record::Switch;

const R_OHM: f64 = 1000.0;

fn begun() -> Cycle {
    // Without discharges that show the offset, which is not needed.
    let config = config(|c| {
        c.set("measure.method", "tcdic").set("measure.offset", "0 us").channel("thumb").channel("finger")
    });
    Cycle::new(config.parse().settings().unwrap())
}

/// At the start of a cycle, after the looks for leaks.
fn cycle() -> Cycle {
    let mut cycle = begun();
    while cycle.leak.is_wanting() {
        course(&mut cycle, &[], 1);
    }
    cycle.step = Step::Start;
    cycle
}

/// A discharge that takes 600 ns/ohm to node A and 700 to node B.
fn discharged(through: Through) -> Outcome {
    let r_ohm = match through {
        Through::C1 => 470.0,
        Through::C2 | Through::C12 => 12700.0,
        Through::X(_) | Through::XWithC12(_) => R_OHM,
    };
    let record = Record {
        through,
        start: Nanos::ZERO,
        second_ns: None,
        switch: None,
        a_ns: Some(600.0 * r_ohm),
        b_ns: Some(700.0 * r_ohm),
        u_switch_ns: None,
        waited_ns: None,
        later_ns: None,
    };
    Outcome { result: Ok(record), calls: [Some(Nanos(1000)), None, None], charged: None }
}

fn failed(fault: Fault) -> Outcome {
    Outcome { result: Err(fault), calls: [None; 3], charged: None }
}

/// What each next discharge runs through and, if that ends a reading, its status; `outcomes` in order, then sound ones.
fn course(cycle: &mut Cycle, outcomes: &[Result<(), Fault>], count: usize) -> Vec<(Through, Option<Status>)> {
    let outcomes = outcomes.iter().copied().chain(std::iter::repeat(Ok(())));
    outcomes
        .take(count)
        .map(|outcome| {
            let Next::Discharge(plan) = cycle.next(Nanos::ZERO) else {
                panic!("a report without a discharge")
            };
            let outcome = outcome.map_or_else(failed, |()| discharged(plan.through));
            (plan.through, cycle.done(&outcome, Nanos::ZERO).map(|reading| reading.status))
        })
        .collect()
}

fn is_right(status: Option<Status>) -> bool {
    matches!(status, Some(Status::Ok { r_ohm, .. }) if (r_ohm.value - R_OHM).abs() < 1e-6)
}

const WIDE: Result<(), Fault> = Err(Fault::WideBracket);

#[test]
fn nothing_is_said_of_a_sensor_before_there_has_been_a_look_for_leaks() {
    let seen = course(&mut begun(), &[], 7);
    let (c1, c2) = (Through::C1, Through::C2);
    let through: Vec<_> = seen.iter().map(|(through, _)| *through).collect();
    assert_eq!(through, [c1, c2, c2, c1, c2, c2, Through::X(0)]);
}

#[test]
fn a_sensors_interrupted_discharge_is_taken_again() {
    let mut cycle = cycle();
    let seen = course(&mut cycle, &[Ok(()), Ok(()), WIDE, WIDE, Ok(()), WIDE], 7);
    let through = [0, 0, 0, 1, 1].map(Through::X);
    assert_eq!(seen.iter().map(|(through, _)| *through).collect::<Vec<_>>()[2..], through);
    // Each sensor has retakes of its own; only the last discharge of each is a reading.
    let readings: Vec<_> = seen.iter().filter_map(|(_, status)| *status).collect();
    assert!(readings.len() == 2 && is_right(seen[4].1) && is_right(seen[6].1), "{seen:?}");
    assert_eq!((cycle.stats().retried, cycle.stats().readings, cycle.stats().ok), (3, 2, 2));
    assert!(cycle.is_at_start() || cycle.is_holding());
}

#[test]
fn a_sensor_that_is_interrupted_each_time_is_told_so_and_costs_only_its_own_reading() {
    let mut cycle = cycle();
    let most = MOST_OF_SENSOR as usize;
    let outcomes: Vec<_> = [Ok(()); 2].into_iter().chain([WIDE].into_iter().cycle().take(most)).collect();
    let seen = course(&mut cycle, &outcomes, 2 + most + 1);
    assert!(seen[2..1 + most].iter().all(|seen| *seen == (Through::X(0), None)), "{seen:?}");
    assert_eq!(seen[1 + most], (Through::X(0), Some(Status::Fault(Fault::WideBracket))));
    assert!(seen[2 + most].0 == Through::X(1) && is_right(seen[2 + most].1), "{seen:?}");
}

#[test]
fn other_faults_of_a_sensor_are_readings_at_once() {
    for fault in Fault::ALL.into_iter().filter(|fault| *fault != Fault::WideBracket) {
        let mut cycle = cycle();
        let seen = course(&mut cycle, &[Ok(()), Ok(()), Err(fault)], 4);
        assert_eq!(seen[2], (Through::X(0), Some(Status::Fault(fault))));
        assert_eq!((seen[3].0, cycle.stats().retried), (Through::X(1), 0));
    }
}

#[test]
fn an_interrupted_calibration_leaves_the_sensor_its_retakes() {
    let mut cycle = cycle();
    let seen = course(&mut cycle, &[WIDE, WIDE, Ok(()), WIDE, Ok(()), WIDE, WIDE, Ok(())], 8);
    let through: Vec<_> = seen.iter().map(|(through, _)| *through).collect();
    let (x, c1, c2) = (Through::X(0), Through::C1, Through::C2);
    assert_eq!(through, [c1, c1, c1, c2, c2, x, x, x]);
    assert!(is_right(seen[7].1), "{seen:?}");
}

/// A program that sleeps past the crossing holds a discharge that has ended: A crossed as usual, and nothing leaks.
#[test]
fn a_discharge_that_is_held_too_late_shows_no_leak() {
    let look = |at_ns: f64, a_ns: f64| {
        let mut cycle = begun();
        course(&mut cycle, &[], 2);
        let Outcome { result, calls, charged } = discharged(Through::C2);
        let switch = Some(Switch { at_ns, on_ns: at_ns + 40e6, to: Through::C2 });
        let record = Record { switch, a_ns: Some(a_ns), ..result.unwrap() };
        let outcome = Outcome { result: Ok(record), calls, charged };
        (0..2).for_each(|_| cycle.held_done(Look::Leak, &outcome, Nanos::ZERO));
        cycle.leak.is_defect()
    };
    let usual_ns = 600.0 * 12_700.0;
    assert!(!look(50e6, usual_ns), "it had crossed");
    assert!(!look(0.9 * usual_ns, usual_ns + 40e6), "nothing was lost while it was held");
    assert!(look(0.9 * usual_ns, 0.95 * usual_ns), "it crossed while it was held");
    assert!(look(0.9 * usual_ns, 0.5 * usual_ns), "it is not as it was");
}

#[test]
fn that_lines_cannot_be_used_is_told_of_all_channels_and_nothing_is_left_planned() {
    let config = config(|c| {
        c.set("measure.method", "tcdic")
            .channel("thumb")
            .channel("finger")
            .lines("channel.finger", "every = 5")
    });
    let mut cycle = Cycle::new(config.parse().settings().unwrap());
    // The finger's turn comes first.
    while cycle.stats().cycles == 0 {
        course(&mut cycle, &[], 1);
    }
    // The look for a leak is over when the next one would be due.
    let late = Nanos(60_000_000_000);
    cycle.fail(Fault::Pins);
    let mut told = Vec::new();
    while !cycle.is_at_start() {
        let Next::Report(reading) = cycle.next(late) else {
            panic!("a discharge on lines that cannot be used")
        };
        assert_eq!(reading.status, Status::Fault(Fault::Pins));
        told.push(reading.channel);
    }
    assert_eq!(told, [0, 1]);
}
