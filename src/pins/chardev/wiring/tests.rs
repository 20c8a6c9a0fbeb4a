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

fn header() -> Vec<LineListing> {
    (0..28)
        .map(|offset| LineListing { offset, name: Some(format!("GPIO{offset}")), ..Default::default() })
        .collect()
}

#[test]
fn lines_are_found_by_name_and_by_offset() {
    assert_eq!(line_offset(&header(), "GPIO17", "chip").unwrap(), 17);
    assert_eq!(line_offset(&header(), "17", "chip").unwrap(), 17);
    let mut odd = header();
    odd[3].name = Some("17".to_string());
    assert_eq!(line_offset(&odd, "17", "chip").unwrap(), 3, "a name comes before an offset");
}

#[test]
fn an_unknown_line_is_answered_with_the_nearest_names() {
    let message = line_offset(&header(), "gpio71", "gpiochip0 [pinctrl-rp1]").unwrap_err().to_string();
    assert!(
        message.starts_with("chip gpiochip0 [pinctrl-rp1] has no line \"gpio71\"; did you mean GPIO1,"),
        "{message}"
    );
    let message = line_offset(&header(), "28", "chip").unwrap_err().to_string();
    assert!(message.contains("from 0 to 27"), "{message}");
    let bare = vec![LineListing::default(); 4];
    let message = line_offset(&bare, "GPIO1", "chip").unwrap_err().to_string();
    assert!(message.contains("no names: give an offset from 0 to 3"), "{message}");
}

#[test]
fn a_name_that_two_lines_have_is_refused() {
    let mut twice = header();
    twice[4].name = Some("GPIO9".to_string());
    let message = line_offset(&twice, "GPIO9", "chip").unwrap_err().to_string();
    assert!(message.contains("one of [4, 9]"), "{message}");
}

fn failure(errno: i32, line: &WiredLine) -> ChardevError {
    let source = std::io::Error::from_raw_os_error(errno);
    ChardevError::call("GET_LINE", line.title.clone(), source, std::path::Path::new("/nonexistent"))
}

fn held_by_another(line: &WiredLine) -> ChardevError {
    failure(libc::EBUSY, line).explained("held".to_owned(), vec!["gpioset".to_owned()])
}

#[test]
fn a_busy_line_is_asked_for_again() {
    let lines = lines(&wiring());
    let mut asked = 0;
    let outcome = lines.release_each("cermd", |line| {
        asked += 1;
        if asked < 3 { Err(failure(libc::EBUSY, line)) } else { Ok(()) }
    });
    assert!(outcome.is_ok());
    assert_eq!(asked, 10, "the first line three times, the other seven once");
}

#[test]
fn one_failure_does_not_spare_the_other_lines() {
    let lines = lines(&wiring());
    let mut released = Vec::new();
    let outcome = lines.release_each("cermd", |line| {
        released.push(line.offset);
        match line.offset {
            16 => Err(held_by_another(line)),
            20 => Err(failure(libc::EIO, line)),
            _ => Ok(()),
        }
    });
    assert!(outcome.unwrap_err().to_string().contains("sink-c1 (GPIO20)"));
    // The one that is held more than once.
    released.dedup();
    assert_eq!(released, [16, 26, 20, 21, 13, 19, 5, 6]);
}
