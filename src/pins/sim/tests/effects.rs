//! What a scene may name besides the plain board: each effect by its exact size.

use super::*;

/// From the start of the first move to the stamps of A and B, ns.
fn stamps(scene: &Scene) -> [f64; 2] {
    let mut pins = SimPins::new(scene, None);
    let (start, edges) = discharge(&mut pins, Drives::C1);
    [0, 1].map(|i| (edges[i].at - start.before).as_ns())
}

#[test]
fn posted_writes_move_lines_after_their_call_in_the_order_of_writing() {
    let scene = with("[calls]\nfixed = \"0 s\"\nper-line = \"1 us\"\nmoves-at = [3.0, 3.0]");
    let mut pins = SimPins::new(&scene, None);
    assert_eq!(pins.drive(Drives::C1).unwrap().width(), Nanos(1000));
    // Written, and on its way until 3 us.
    assert_eq!((pins.driving(), pins.analog.on()), (Drives::C1, Drives::NONE));
    // A read waits for it: so does arming.
    pins.levels().unwrap();
    assert_eq!((pins.now(), pins.analog.on()), (Nanos(3000), Drives::C1));
    pins.drive(Drives::NONE).unwrap();
    pins.arm().unwrap();
    assert_eq!((pins.now(), pins.analog.on()), (Nanos(6000), Drives::NONE));
    // Two lines, written one after the other: the second call does not overtake the first.
    pins.drive(Drives::C1).unwrap();
    pins.drive(Drives::C2).unwrap();
    pins.levels().unwrap();
    let moves = [(0.0, Drives::C1), (1000.0, Drives::NONE), (2000.0, Drives::C2)];
    assert_eq!(pins.truth().changes(), moves);
    assert_eq!(pins.now(), Nanos(11_000));
}

#[test]
fn scattered_writes_never_overtake_each_other() {
    let scene = with("[calls]\nfixed = \"0 s\"\nper-line = \"1 us\"\nmoves-at = [0.0, 100.0]");
    let mut pins = SimPins::new(&scene, None);
    for _ in 0..200 {
        pins.arm().unwrap();
        let began = pins.drive(Drives::C1).unwrap().before;
        pins.drive(Drives::NONE).unwrap();
        pins.drive(Drives::C2).unwrap();
        pins.drive(Drives::NONE).unwrap();
        pins.levels().unwrap();
        let changes = pins.truth().changes();
        assert_eq!(
            changes.iter().map(|change| change.1).collect::<Vec<_>>(),
            [Drives::C1, Drives::NONE, Drives::C2, Drives::NONE]
        );
        assert!(changes.windows(2).all(|pair| pair[0].0 <= pair[1].0), "{changes:?}");
        let last = changes[3].0;
        assert!(pins.now() <= began + Nanos(103_000) && last <= 103_000.0, "{last}");
    }
}

#[test]
fn a_crossing_counts_from_when_its_line_has_moved() {
    let calls = "[calls]\nfixed = \"0 s\"\nper-line = \"1 us\"\nmoves-at = ";
    let within = stamps(&with(&format!("{calls}[0.0, 0.0]")));
    let posted = stamps(&with(&format!("{calls}[40.0, 40.0]")));
    // The chargers let go later, too: what they add in 40 us after 20 ms is less than a nanosecond of a crossing.
    for (within, posted) in within.into_iter().zip(posted) {
        assert!((posted - within - 40_000.0).abs() <= 1.0, "{posted} {within}");
    }
}

#[test]
fn stamps_of_b_are_later_by_a_constant() {
    let ([a, b], [later_a, later_b]) = (stamps(&with("")), stamps(&with("[events]\nb-later = \"3 us\"")));
    assert_eq!((later_a - a, later_b - b), (0.0, 3000.0));
}

#[test]
fn stamps_are_later_after_a_long_wait_alone() {
    let sleepy =
        |after: &str| with(&format!("[events]\ndeep-sleep-after = \"{after}\"\ndeep-sleep-late = \"2 us\""));
    let [a, b] = stamps(&with(""));
    assert!((240e3..250e3).contains(&a) && (165e3..175e3).contains(&(b - a)), "{a} {b}");
    // The wait for A begins with the discharge, that for B with A's edge.
    let waited = |after: &str| {
        let [later_a, later_b] = stamps(&sleepy(after));
        [later_a - a, later_b - b]
    };
    assert_eq!(waited("100 us"), [2000.0, 2000.0]);
    assert_eq!(waited("200 us"), [2000.0, 0.0]);
    assert_eq!(waited("260 us"), [0.0, 0.0]);
    // A sleep is a wait as well, and what does not sleep long does not sleep deeply.
    for (naps, late) in [(1, 2000.0), (4, 0.0)] {
        let mut pins = SimPins::new(&sleepy("200 us"), None);
        pins.drive(Drives::CHARGE).unwrap();
        pins.sleep_until(Nanos(20 * MS)).unwrap();
        pins.drive(Drives::NONE).unwrap();
        pins.arm().unwrap();
        let start = pins.drive(Drives::C1).unwrap().before;
        for nap in 1..=naps {
            pins.sleep_until(start + Nanos(MS / 2 / naps * nap)).unwrap();
        }
        let edge = pins.edge(Nanos::MAX).unwrap().unwrap();
        assert_eq!((edge.at - start).as_ns() - a, late, "{naps} naps");
    }
}

#[test]
fn r_o_walks_as_the_root_of_time_and_stays_positive() {
    let scene = with("[walk]\nr-o = \"2 ohm\"");
    let steps = |wait_ns: i64| -> Vec<f64> {
        let mut pins = SimPins::new(&scene, None);
        let mut last = pins.circuit().r_o;
        (0..2000)
            .map(|_| {
                let now = pins.now();
                pins.sleep_until(now + Nanos(wait_ns)).unwrap();
                pins.drive(Drives::NONE).unwrap();
                pins.drive(Drives::CHARGE).unwrap();
                let r_o = pins.circuit().r_o;
                assert!(r_o.iter().all(|one| *one >= 0.0 && *one == r_o[0]), "{r_o:?}");
                let step = r_o[0] - last[0];
                last = r_o;
                step
            })
            .collect()
    };
    // 2 ohm in a second: 0.02 ohm in 0.1 ms. 2000 such steps go some 0.9 ohm far, not down to zero.
    assert_normal(&steps(100_000), 0.0, 0.02);
    assert_normal(&steps(25_000), 0.0, 0.01);
    // Far enough to turn back.
    steps(10_000 * MS);
    let plain = SimPins::new(&with(""), None);
    assert_eq!(plain.circuit().r_o[0], 40.0);
}

#[test]
fn the_walk_of_r_o_is_in_the_crossings() {
    let mut pins = SimPins::new(&with("[walk]\nr-o = \"3 ohm\""), None);
    for _ in 0..5 {
        let now = pins.now();
        pins.sleep_until(now + Nanos(4000 * MS)).unwrap();
        discharge(&mut pins, Drives::C1);
        let exact = exact_discharge(pins.circuit(), Charge::Full, Drives::C1, None).a.unwrap() * 1e9;
        let found = pins.truth().crossing_ns(Node::A).unwrap();
        assert!((found / exact - 1.0).abs() < 1e-6, "{found} {exact}");
    }
}

#[test]
fn single_pins_are_in_the_crossings() {
    let text = include_str!("../../../../hw/scenes/ideal.toml");
    let text =
        text.replace("r-o = \"40 ohm\"", "r-o = \"40 ohm\"\nr-o-of = { c1 = \"55 ohm\", x0 = \"47 ohm\" }");
    let mut pins = SimPins::new(&Scene::parse(&text, std::path::Path::new("test")).unwrap(), None);
    let c_t = 2.2e-6 * 680e-9 / 2.88e-6 * (3.3f64 / 1.3).ln() * 1e9;
    for (on, ohm) in [(Drives::C1, 525.0), (Drives::C2, 12_740.0), (Drives::x(0), 1047.0)] {
        discharge(&mut pins, on);
        let found = pins.truth().crossing_ns(Node::A).unwrap();
        assert!((found / (ohm * c_t) - 1.0).abs() < 1e-7, "{on}: {found}");
    }
}

#[test]
fn a_pull_left_on_makes_a_discharge_longer_and_can_prevent_it() {
    let plain = discharge(&mut ideal(), Drives::C2).1;
    let mut scene = Scene::builtin("ideal").unwrap();
    scene.circuit.node_a.pull_up = Some(Ohm(50e3));
    let pulled = discharge(&mut SimPins::new(&scene, None), Drives::C2).1;
    assert!(pulled[0].at > plain[0].at && pulled[1].at > plain[1].at);
    scene.circuit.node_a.pull_up = Some(Ohm(10e3));
    assert!(discharge(&mut SimPins::new(&scene, None), Drives::C2).1.is_empty());
}

/// -5 uA into a node beside Rc2: A falls towards 5 uA (Rc2 + Ro), not towards 0.
#[test]
fn a_current_into_a_node_lifts_it() {
    let mut scene = Scene::builtin("ideal").unwrap().with_kind(Kind::OneCapacitor).unwrap();
    scene.circuit.node_a.leakage = Some(crate::units::Ampere(-5e-6));
    let mut pins = SimPins::new(&scene, None);
    discharge(&mut pins, Drives::C2);
    let (r, end) = (12_740.0, 5e-6f64 * 12_740.0);
    let charged = 3.3 + 5e-6 * 220.0f64;
    let exact = r * 470e-9 * ((charged - end) / (1.3 - end)).ln() * 1e9;
    let found = pins.truth().crossing_ns(Node::A).unwrap();
    assert!((found / exact - 1.0).abs() < 1e-7, "{found} {exact}");
}

/// A capacitor that has absorbed gives back: after a discharge that was held at ground the next one, from a short charge,
/// is quicker than the same one after a long charge, and without absorption it is not.
#[test]
fn absorption_remembers_the_discharge_before() {
    let crossing = |effects: &str, hold_ms: i64| {
        let text =
            include_str!("../../../../hw/scenes/ideal.toml").replace("v-dd =", &format!("{effects}\nv-dd ="));
        let text = text.replace("r-c1 = \"470 ohm\"", "r-c1 = \"2.32 kohm\"");
        let mut pins = SimPins::new(&Scene::parse(&text, std::path::Path::new("test")).unwrap(), None);
        discharge(&mut pins, Drives::C1);
        pins.drive(Drives::C1).unwrap();
        let held = pins.now() + Nanos(hold_ms * MS);
        pins.sleep_until(held).unwrap();
        discharge(&mut pins, Drives::C1);
        pins.truth().crossing_ns(Node::A).unwrap()
    };
    let pet = "absorption = { c-a = [{ share = 0.0025, tau = \"100 ms\" }], c-b = [{ share = 0.0025, tau = \"100 ms\" }] }";
    assert!((crossing("", 1) - crossing("", 300)).abs() < 0.01);
    let (short, long) = (crossing(pet, 1), crossing(pet, 300));
    // The branch is 0.45 V lower, and takes 0.25 % of C for 1.1 ms of its 100 ms: 12 uV of 1.3 V.
    assert!((5e-6..2e-5).contains(&(1.0 - long / short)), "{short} {long}");
}

#[test]
fn a_tick_holds_up_calls_stamps_and_sleepers() {
    let scene =
        with("[ticks]\nevery = \"1 ms\"\ntakes = \"30 us\"\n[calls]\nfixed = \"0 s\"\nper-line = \"1 us\"");
    let mut pins = SimPins::new(&scene, None);
    assert_eq!(pins.particulars().tick, Some(Nanos(MS)));
    let mut call_at = |at: i64| {
        pins.sleep_until(Nanos(at)).unwrap();
        let other = if pins.driving() == Drives::C1 { Drives::NONE } else { Drives::C1 };
        pins.drive(other).unwrap()
    };
    let took = |bracket: Bracket| (bracket.before.0, bracket.width().0);
    assert_eq!(took(call_at(MS - 2000)), (MS - 2000, 1000), "over before");
    assert_eq!(took(call_at(2 * MS - 200)), (2 * MS - 200, 31_000), "in the middle of it");
    assert_eq!(took(call_at(3 * MS + 10_000)), (3 * MS + 30_000, 1000), "woken when it is over");
    // The line is switched in the middle of its call, before the tick or after it.
    let moved = |before_ns: i64| {
        let mut pins = SimPins::new(&scene, None);
        pins.drive(Drives::CHARGE).unwrap();
        pins.sleep_until(Nanos(20 * MS)).unwrap();
        pins.drive(Drives::NONE).unwrap();
        pins.arm().unwrap();
        pins.sleep_until(Nanos(21 * MS - before_ns)).unwrap();
        let start = pins.drive(Drives::C1).unwrap().before;
        let edge = pins.edge(Nanos::MAX).unwrap().unwrap();
        (edge.at - start).0
    };
    let usual = moved(500_000);
    assert_eq!(moved(700), usual);
    assert_eq!(moved(300), usual + 30_000);
    // It falls 200 ns after the tick has begun, and is stamped when that is over.
    assert_eq!(moved(usual - 200), usual + 29_800);
}
