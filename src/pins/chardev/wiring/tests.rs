use super::super::chips::LineListing;
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
    wiring.lines(|name| name.trim_start_matches("GPIO").parse::<u32>()).unwrap()
}

#[test]
fn lines_stand_in_switching_order() {
    let lines = lines(&wiring());
    let parts: Vec<Drives> = lines.drives.iter().map(|drive| drive.part).collect();
    let order: Vec<Drives> = lines.wired().lines().collect();
    assert_eq!(parts, order);
    assert_eq!(lines.drives[2].title, "sink-c1 (GPIO20)");
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
fn a_wiring_is_resolved_on_a_chip_or_refused_with_the_reason() {
    let listing = |offset| LineListing { offset, name: Some(format!("GPIO{offset}")), ..Default::default() };
    let chip = Chip::of_lines((0..28).map(listing).collect());
    assert_eq!(wiring().resolve(&chip).unwrap(), lines(&wiring()));
    let missing = Wiring { sink_c1: "GPIO40".into(), ..wiring() };
    assert!(missing.resolve(&chip).unwrap_err().to_string().contains("no line \"GPIO40\""));
    let many = Wiring { sinks_x: vec!["GPIO1".into(); MAX_CHANNELS + 1], ..wiring() };
    assert!(many.resolve(&chip).unwrap_err().to_string().contains("at most 16"));
}
