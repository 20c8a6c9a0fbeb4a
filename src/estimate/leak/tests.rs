use super::*;

const R2_OHM: f64 = 12_700.0;

fn lost(ns: f64) -> Lost {
    Lost { to_a: [ns, 2.0 * 3000f64.powi(2)], more_to_b: None, held_ns: LEAK_HOLD.as_ns(), r_ohm: R2_OHM }
}

/// What a discharge through as much is shorter by for a leak to ground, as it was held.
fn lost_by(siemens: f64) -> f64 {
    LEAK_HOLD.as_ns() * R2_OHM * siemens
}

fn tested(count: usize, lost_ns: impl Fn(usize) -> f64) -> LeakTest {
    let mut test = LeakTest::default();
    for index in 0..count {
        test.add(Some(lost(lost_ns(index))), Nanos::ZERO);
    }
    test
}

#[test]
fn a_megohm_shows_at_once_and_spikes_do_not() {
    assert_eq!(tested(LEAK_FIRST - 1, |_| 508_000.0).siemens(), None);
    assert_eq!(tested(LEAK_FIRST - 1, |_| 0.0).likely_siemens(), LIKELY_LEAK_SIEMENS);
    for sign in [1.0, -1.0] {
        let found = tested(LEAK_FIRST, |_| lost_by(sign * 1e-6)).siemens().unwrap();
        assert!((found * 1e6 - sign).abs() < 1e-9, "{found}");
    }
    let spikes = tested(LEAK_FIRST, |index| if index % 5 == 0 { 200_000.0 } else { 1000.0 });
    assert_eq!(spikes.siemens(), None);
    // What does not show may still be there.
    assert!((lost_by(spikes.likely_siemens()) - 1000.0).abs() < 1e-9);
    // One that goes is forgotten.
    let gone = tested(4 * LEAK_REMEMBERED, |index| if index < 2 * LEAK_REMEMBERED { 508_000.0 } else { 0.0 });
    assert_eq!((gone.siemens(), gone.likely_siemens()), (None, 0.0));
}

#[test]
fn what_was_found_is_known_elsewhere_until_other_looks_replace_it() {
    let found = tested(2 * LEAK_REMEMBERED, |_| 508_000.0);
    let mut known = LeakTest::default().knows(found.found().unwrap(), None, false);
    let [of_found, of_known] = [&found, &known].map(|test| [test.likely_siemens(), test.u_siemens()]);
    assert!(of_found.iter().zip(of_known).all(|(found, known)| (found / known - 1.0).abs() < 1e-9));
    assert!(known.siemens().is_some() && !known.has_changed() && !known.is_wanting());
    for _ in 0..2 * LEAK_REMEMBERED {
        known.add(Some(lost(0.0)), Nanos::ZERO);
    }
    assert_eq!((known.siemens(), known.likely_siemens()), (None, 0.0));
    assert_eq!(tested(1, |_| 508_000.0).found(), None);
}

#[test]
fn a_defect_is_known_by_the_first_looks_and_one_spike_is_none() {
    // 40 ms / 50 kohm * 12.7 kohm.
    let defect = |count| tested(count, |_| 10.16e6);
    assert!(defect(LEAK_GROSS_FIRST - 1).is_wanting() && !defect(LEAK_GROSS_FIRST).is_wanting());
    assert!(LeakTest::default().is_wanting() && !tested(1, |_| 1000.0).is_wanting());
    assert_eq!(defect(LEAK_GROSS_FIRST - 1).siemens(), None);
    assert!(defect(LEAK_GROSS_FIRST).siemens().unwrap() > GROSS_LEAK_SIEMENS);
    let spike = tested(LEAK_GROSS_FIRST, |index| if index == 0 { 30e6 } else { 0.0 });
    assert!(!spike.is_known() && spike.siemens().is_none());
    assert!(!tested(LEAK_GROSS_FIRST, |index| if index == 0 { 30e6 } else { -30e6 }).is_known());
    let mut failed = LeakTest::default();
    (0..LEAK_GROSS_FIRST).for_each(|_| failed.add(None, Nanos::ZERO));
    assert!(!failed.is_wanting() && !failed.is_known());
}

/// What a node loses while a discharge is held, in time, for 1 uA into it, a pull-up of 1 Mohm, or both of that and a leak of as much.
#[test]
fn what_is_no_resistor_to_ground_shows_by_the_two_levels() {
    let of = |current_ua: fn(f64) -> f64| {
        let mut test = LeakTest::default();
        for _ in 0..LEAK_FIRST {
            let v = 3.3 * 3f64.powf(-test.held_at());
            test.add(Some(lost(lost_by(1e-6 * current_ua(v) / v))), Nanos::ZERO);
        }
        test
    };
    let bent = |test: &LeakTest| 1e6 * test.left().bent;
    let to_ground = of(|v| v);
    assert!(bent(&to_ground) < 1e-9 && (1e6 * to_ground.likely_siemens() - 1.0).abs() < 1e-9);
    // On average over a discharge from 3.3 to 1.1 V: (1/1.1 V - 1/3.3 V) / ln 3 for each ampere.
    let current = of(|_| -1.0);
    let average = (1.0 / 1.1 - 1.0 / 3.3) / 3f64.ln();
    assert!((1e6 * current.likely_siemens() / -average - 1.0).abs() < 0.03, "{current:?}");
    assert!((0.2..0.3).contains(&bent(&current)), "{current:?}");
    let hidden = of(|v| v - (3.3 - v));
    assert!((0.7..0.9).contains(&bent(&hidden)), "{hidden:?}");
    assert!(hidden.likely_siemens().abs() < 0.2e-6, "{hidden:?}");
}

#[test]
fn the_first_tests_follow_each_other_and_failed_ones_end_too() {
    assert!(LeakTest::default().is_due(Nanos(1)) && tested(LEAK_FIRST - 1, |_| 0.0).is_due(Nanos(1)));
    let test = tested(LEAK_FIRST, |_| 0.0);
    assert!(!test.is_due(Nanos(1)) && test.is_due(LEAK_EVERY));
    let mut failed = LeakTest::default();
    (0..LEAK_FIRST).for_each(|_| failed.add(None, LEAK_EVERY));
    assert!(!failed.is_due(LEAK_EVERY + Nanos(1)) && failed.siemens().is_none());
}

#[test]
fn a_leak_that_comes_is_looked_at_again_at_once() {
    let mut test = tested(2 * LEAK_REMEMBERED, |_| 0.0);
    let mut more = 0;
    while !test.has_changed() {
        test.add(Some(lost(508_000.0)), Nanos::ZERO);
        more += 1;
        assert!(test.is_due(Nanos(1)) || test.siemens().is_some());
    }
    assert!(test.siemens().is_some() && !test.has_changed());
    assert!((LEAK_REMEMBERED - 2..=LEAK_REMEMBERED + 2).contains(&more), "{more}");
}

/// Some that lost this much until A and more until B, siemens.
fn add(test: &mut LeakTest, count: usize, to_a: f64, more_to_b: Option<f64>) {
    for _ in 0..count {
        let more_to_b = more_to_b.map(|siemens| [lost_by(siemens), 4.0 * 3000f64.powi(2)]);
        test.add(Some(Lost { more_to_b, ..lost(lost_by(to_a)) }), Nanos::ZERO);
    }
}

#[test]
fn what_shows_is_undone_with_two_nodes_once_others_have_told_where_it_is() {
    let mut one = LeakTest::new(1, R2_OHM);
    add(&mut one, LEAK_FIRST, 1e-6, None);
    assert!(!one.waits_for_b() && one.has_changed());
    let mut two = LeakTest::new(2, R2_OHM);
    add(&mut two, LEAK_FIRST, 1e-6, None);
    assert!(two.waits_for_b() && two.is_due(Nanos(1)) && !two.has_changed() && !two.undone().is_any());
    add(&mut two, LEAK_FIRST, 1e-6, Some(5e-7));
    assert!(two.is_at_b() && !two.is_due(Nanos(1)) && two.has_changed() && !two.has_changed());
    for (lost, expected) in [(one.undone().lost(), 0.0), (two.undone().lost(), 5e-7)] {
        let [at_a, at_b] = lost;
        assert!(at_a.iter().all(|k| (k / 1e-6 - 1.0).abs() < 1e-9), "{lost:?}");
        assert!(at_b.iter().all(|k| (k - expected).abs() < 1e-15), "{lost:?}");
    }
    let left = two.left();
    assert!(left.likely.abs() < 1e-15 && left.noise > 0.0 && left.at_b > 0.0 && left.at_b < 5e-8, "{left:?}");
    // One that goes is undone no longer.
    add(&mut two, 4 * LEAK_REMEMBERED, 0.0, Some(0.0));
    assert!(two.has_changed() && !two.undone().is_any());
}

#[test]
fn where_nobody_waits_for_b_it_may_all_be_there() {
    for (nodes, at_b) in [(1, 0.0), (2, 1e-6)] {
        let mut test = LeakTest::new(nodes, R2_OHM);
        add(&mut test, 2 * LEAK_FIRST, 1e-6, None);
        assert!(test.has_changed() && test.found_at_b().is_none());
        assert!((test.left().at_b - at_b).abs() < 1e-15, "{test:?}");
    }
}

#[test]
fn a_dielectric_is_no_leak() {
    let mut test = LeakTest::new(1, R2_OHM);
    add(&mut test, LEAK_FIRST, 1e-6, None);
    assert!(test.has_changed());
    test.set_dielectric(true);
    assert!(test.has_changed() && !test.undone().is_any() && !test.has_changed());
    assert!((test.left().likely / 1e-6 - 1.0).abs() < 1e-9);
}

#[test]
fn what_is_just_no_defect_takes_a_held_discharge_no_further_than_to_its_end() {
    for takes_ns in [25e3, 1e6, 7e6, 50e6] {
        let goes_on = hold(takes_ns, R2_OHM).as_ns() * R2_OHM * GROSS_LEAK_SIEMENS / takes_ns;
        assert!(LEAK_HELD_AT[1] + goes_on < 1.0, "{takes_ns}: {goes_on}");
        // And nearly to it, unless that takes longer than any is held.
        assert!(goes_on > 0.38 || hold(takes_ns, R2_OHM) == LEAK_HOLD, "{takes_ns}: {goes_on}");
    }
}

#[test]
fn more_is_left_of_a_large_leak_at_b() {
    let [small, large] = [1e-6, 4e-6].map(|at_b| {
        let mut test = LeakTest::new(2, R2_OHM);
        add(&mut test, LEAK_FIRST, 1e-6, None);
        add(&mut test, 2 * LEAK_FIRST, 1e-6, Some(at_b));
        assert!(test.has_changed());
        test.left().at_b / at_b
    });
    assert!(large > 3.0 * small && large > 0.1, "{small} {large}");
}
