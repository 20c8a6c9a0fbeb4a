use super::super::chardev::wiring::tests::wiring;
use super::*;
use embedded_hal::digital::{ErrorKind, ErrorType};
use std::cell::RefCell;
use std::rc::Rc;

#[test]
fn a_wiring_without_chargers_is_refused_with_the_reason() {
    let wiring = Wiring { charge_a: None, charge_b: None, ..wiring() };
    let message = open(&wiring).err().unwrap().to_string();
    assert!(message.contains("charge-a") && message.contains("uAPI v1"), "{message}");
}

#[test]
fn stamps_of_the_wall_clock_become_monotonic() {
    let (before, wall) = (monotonic(), clock(ClockId::CLOCK_REALTIME));
    let at = to_monotonic(wall.0 as u64);
    let slack = monotonic() - before;
    assert!(at >= before - slack && at <= before + slack + slack, "{at} is not near {before}");
}

#[test]
fn the_answer_of_the_kernel_is_kept() {
    let missing = gpio_cdev::Chip::new("/nonexistent").unwrap_err();
    assert_eq!(last_call(&missing).raw_os_error(), Some(libc::ENOENT));
    let file = tempfile::NamedTempFile::new().unwrap();
    let no_chip = gpio_cdev::Chip::new(file.path()).unwrap_err();
    assert_eq!(last_call(&no_chip).raw_os_error(), Some(libc::ENOTTY));
}

/// Writes down its changes; the one called "broken" refuses.
struct FakePin {
    name: &'static str,
    log: Rc<RefCell<Vec<String>>>,
}

impl ErrorType for FakePin {
    type Error = ErrorKind;
}

impl OutputPin for FakePin {
    fn set_low(&mut self) -> Result<(), ErrorKind> {
        self.log.borrow_mut().push(format!("{} low", self.name));
        if self.name == "broken" { Err(ErrorKind::Other) } else { Ok(()) }
    }
    fn set_high(&mut self) -> Result<(), ErrorKind> {
        self.log.borrow_mut().push(format!("{} high", self.name));
        Ok(())
    }
}

fn switches(c2: &'static str) -> (Vec<DriveLine<FakePin>>, Rc<RefCell<Vec<String>>>) {
    let log = Rc::default();
    let lines = [(Drives::x(0), "x0"), (Drives::C2, c2), (Drives::CHARGE_A, "charge-a")];
    let switch = |(part, name): (Drives, &'static str)| {
        let line = WiredLine { part, offset: 0, title: name.to_string() };
        DriveLine { line, pin: FakePin { name, log: Rc::clone(&log) } }
    };
    (lines.map(switch).into(), log)
}

#[test]
fn releases_come_before_drives_and_nothing_else_is_touched() {
    let (mut switches, log) = switches("c2");
    let mut driving = Drives::NONE;
    for on in [Drives::C2, Drives::x(0), Drives::x(0), Drives::CHARGE_A, Drives::NONE] {
        switch(&mut switches, driving, on).unwrap();
        driving = on;
    }
    let expected = [
        "c2 low", // drives
        "c2 high",
        "x0 low", // released before driven, against the order of the lines
        "x0 high",
        "charge-a high", // an open-source line charges when high
        "charge-a low",
    ];
    assert_eq!(*log.borrow(), expected);
}

#[test]
fn a_line_that_failed_is_named_and_those_after_it_are_left() {
    let (mut switches, log) = switches("broken");
    let failed = switch(&mut switches, Drives::NONE, Drives::C2.and(Drives::CHARGE_A));
    assert_eq!(failed, Err(("broken".to_owned(), ErrorKind::Other)));
    assert_eq!(*log.borrow(), ["broken low"]);
}
