use super::*;

/// Two nodes, two channels, dedicated chargers.
pub fn wiring() -> Wiring {
    Wiring {
        chip: "pinctrl-rp1".into(),
        sense_a: "GPIO5".into(),
        sense_b: Some("GPIO6".into()),
        charge_a: Some("GPIO13".into()),
        charge_b: Some("GPIO19".into()),
        sink_c1: "GPIO20".into(),
        sink_c2: "GPIO21".into(),
        sinks_x: vec!["GPIO16".into(), "GPIO26".into()],
        consumer: "cermd".into(),
    }
}

/// What [`Wiring::resolve`] makes of a wiring whose lines are all called "GPIO<offset>".
pub fn lines(wiring: &Wiring) -> Lines {
    let at = |key: &str, name: &str| WiredLine {
        offset: name.trim_start_matches("GPIO").parse().unwrap(),
        title: format!("{key} ({name})"),
    };
    Lines {
        sense: wiring.sense_parts().map(|(key, name)| at(key, name)).collect(),
        drives: wiring
            .drive_parts()
            .map(|(part, key, name)| DriveLine { part, line: at(&key, name) })
            .collect(),
        sense_charges: wiring.sense_charges(),
    }
}

#[test]
fn lines_stand_in_switching_order() {
    let lines = lines(&wiring());
    let parts: Vec<Drives> = lines.drives.iter().map(|drive| drive.part).collect();
    let order: Vec<Drives> = lines.wired().lines().collect();
    assert_eq!(parts, order);
    assert_eq!(lines.drives[2].line.title, "sink-c1 (GPIO20)");
}

#[test]
fn without_chargers_the_sense_lines_charge() {
    let mut wiring = wiring();
    (wiring.charge_a, wiring.charge_b) = (None, None);
    assert!(lines(&wiring).wired().contains(Drives::CHARGE));
    wiring.sense_b = None;
    let wired = lines(&wiring).wired();
    assert!(wired.contains(Drives::CHARGE_A) && !wired.contains(Drives::CHARGE_B));
}

#[test]
fn a_line_may_play_one_part_only() {
    let mut wiring = wiring();
    wiring.sink_c2 = "GPIO5".into();
    let message = distinct(&lines(&wiring)).unwrap_err().to_string();
    assert_eq!(message, "sense-a (GPIO5) and sink-c2 (GPIO5) are the same line, offset 5");
}

#[test]
fn impossible_wirings_are_refused_with_the_reason() {
    let mut one = wiring();
    one.charge_a = None;
    assert!(one.check().unwrap_err().to_string().contains("node A would never be charged"));
    let mut two = wiring();
    two.sense_b = None;
    assert!(two.check().unwrap_err().to_string().contains("no node B"));
    let mut three = wiring();
    three.sinks_x = vec!["GPIO1".into(); MAX_CHANNELS + 1];
    assert!(three.check().unwrap_err().to_string().contains("at most 16"));
}
