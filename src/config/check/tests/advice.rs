//! Advice that is followed.

use super::*;

/// Puts the number of a remedy ("at least \"207 ohm\", ..", "at most 0.45, ..") in the place of what was complained of.
fn follow(file: &mut ConfigFile, key: &str) -> String {
    let of_key = |config: &Config| complaints(config).into_iter().find(|text| text.contains(key));
    let complaint = of_key(&file.parse()).unwrap();
    let words = complaint.rsplit("; try at ").next().unwrap();
    let value = words.split_once(' ').unwrap().1.split(',').next().unwrap();
    match value.strip_prefix('"') {
        Some(text) => file.set(key, text.trim_end_matches(" or without it").trim_end_matches('"')),
        None => file.set(key, value.parse::<f64>().unwrap()),
    };
    assert_eq!(of_key(&file.parse()), None, "who followed {complaint:?} hears it again");
    complaint
}

#[test]
fn who_follows_a_bound_does_not_hear_of_it_again() {
    let good = config_file::config(|c| c.set("gpio.backend", "mock").set("mock.scene", "pi4").channel("x"));
    for (key, wrong) in [
        ("circuit.r-c1", "90 ohm"),
        ("circuit.r-charge", "100 ohm"),
        ("measure.deadline", "1 ms"),
        ("measure.charge-time", "100 us"),
    ] {
        follow(good.clone().set(key, wrong), key);
    }
    for rate in [90.0, 1000.0] {
        follow(good.clone().set("measure.rate-hz", rate), "measure.rate-hz");
    }
    // A circuit so slow that a tenth of a hertz is too much.
    let slow = |r_c2: &str| {
        config_file::config(|c| {
            let c = c.one_capacitor("one-capacitor", "1 mF").set("circuit.r-c2", r_c2);
            c.set("gpio.backend", "mock").set("mock.scene", "pi4").channel("x").set("measure.rate-hz", 5.0)
        })
    };
    let complaint = follow(&mut slow("12.7 kohm"), "measure.rate-hz");
    assert!(complaint.contains("mHz") && !complaint.contains(" 0.0,"), "{complaint}");
    // One so slow that no rate is right: none is proposed.
    let complaints = complaints(&slow("100 kohm").parse());
    let complaint = complaints.iter().find(|text| text.contains("measure.rate-hz")).unwrap();
    assert!(complaint.contains("; try without it: as fast as the circuit allows"), "{complaint}");
}
