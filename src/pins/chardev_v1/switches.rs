//! Drive lines that are one embedded-hal output pin each, and the order in which they switch.
//!
//! uAPI v1 sets all lines of a request at once, without a mask; a request a line keeps the lines that do not change
//! untouched, at the price of a call for each that does.

use crate::pins::Drives;
use embedded_hal::digital::OutputPin;

/// A drive line.
#[derive(Debug)]
pub(super) struct Switch<P> {
    /// The part it plays.
    pub part: Drives,
    /// What errors call it.
    pub title: String,
    /// Open drain for a sink, open source for a charger.
    pub pin: P,
}

impl<P: OutputPin> Switch<P> {
    fn set(&mut self, on: bool) -> Result<(), P::Error> {
        // An open-drain line sinks when low, an open-source line charges when high; otherwise both are inputs.
        let high = on == Drives::CHARGE.contains(self.part);
        self.pin.set_state(high.into())
    }
}

/// The drive lines of a circuit, in switching order.
#[derive(Debug)]
pub(super) struct Switches<P> {
    switches: Vec<Switch<P>>,
    /// What drives; after a failed call, every line that may.
    driving: Drives,
}

impl<P: OutputPin> Switches<P> {
    /// Takes over lines that are all released.
    pub fn new(switches: Vec<Switch<P>>) -> Switches<P> {
        Switches { switches, driving: Drives::NONE }
    }

    /// What errors call the line that plays a part.
    pub fn title(&self, part: Drives) -> &str {
        self.switches.iter().find(|switch| switch.part == part).map_or("", |switch| &switch.title)
    }

    /// Makes exactly the lines of `on` drive: first releases, then drives, in order.
    ///
    /// # Errors
    /// The line that could not be switched, and its pin's error. It counts as driving, so that the next call releases it.
    pub fn drive(&mut self, on: Drives) -> Result<(), (Drives, P::Error)> {
        for driven in [false, true] {
            let change = if driven { on.without(self.driving) } else { self.driving.without(on) };
            for switch in self.switches.iter_mut().filter(|switch| change.contains(switch.part)) {
                self.driving = self.driving.and(switch.part);
                switch.set(driven).map_err(|error| (switch.part, error))?;
                if !driven {
                    self.driving = self.driving.without(switch.part);
                }
            }
        }
        Ok(())
    }

    /// Gives the pins back, all released as far as they can be.
    pub fn into_released(mut self) -> impl Iterator<Item = P> {
        self.switches.iter_mut().for_each(|switch| drop(switch.set(false)));
        self.switches.into_iter().map(|switch| switch.pin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_hal::digital::{ErrorKind, ErrorType};
    use std::cell::RefCell;
    use std::rc::Rc;

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

    fn switches(c2: &'static str) -> (Switches<FakePin>, Rc<RefCell<Vec<String>>>) {
        let log = Rc::default();
        let lines = [(Drives::x(0), "x0"), (Drives::C2, c2), (Drives::CHARGE_A, "charge-a")];
        let switch = |(part, name): (Drives, &'static str)| {
            let pin = FakePin { name, log: Rc::clone(&log) };
            Switch { part, title: name.to_string(), pin }
        };
        (Switches::new(lines.map(switch).into()), log)
    }

    #[test]
    fn releases_come_before_drives_and_nothing_else_is_touched() {
        let (mut switches, log) = switches("c2");
        for on in [Drives::C2, Drives::x(0), Drives::x(0), Drives::CHARGE_A, Drives::NONE] {
            switches.drive(on).unwrap();
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
    fn a_line_that_failed_is_released_by_the_next_call() {
        let (mut switches, log) = switches("broken");
        assert_eq!(switches.drive(Drives::C2), Err((Drives::C2, ErrorKind::Other)));
        log.borrow_mut().clear();
        switches.drive(Drives::NONE).unwrap();
        assert_eq!(*log.borrow(), ["broken high"]);
    }

    #[test]
    fn all_lines_are_released_at_the_end() {
        let (switches, log) = switches("c2");
        assert_eq!(switches.into_released().count(), 3);
        assert_eq!(*log.borrow(), ["x0 high", "c2 high", "charge-a low"]);
    }
}
