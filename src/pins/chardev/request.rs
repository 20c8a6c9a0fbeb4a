//! The structs of the uAPI v2 calls (include/uapi/linux/gpio.h): which flags each line gets, which values switch it, and
//! in how many calls.
//!
//! The kernel walks the lines of a request in request order (`gpiod_set_array_value_complex` in
//! drivers/gpio/gpiolib.c), and an open-drain or open-source line that is "off" becomes an input. So one SET_VALUES
//! changes the direction of several lines one after the other, and as the lines stand in switching order (sinks
//! before chargers), most changes release before they drive within one call. The others take two.

use super::wiring::{Lines, WiredLine};
use crate::pins::Drives;
use gpiocdev_uapi::v2::{LineConfig, LineFlags, LineRequest, LineValues, Offsets};

/// An undisturbed input.
pub(super) const INPUT: LineFlags = LineFlags::INPUT.union(LineFlags::BIAS_DISABLED);
/// An input whose threshold crossings are stamped. Falling edges only: with both, the kernel finds out the kind of
/// edge after the stamp, and can be wrong.
pub(super) const SENSE: LineFlags = INPUT.union(LineFlags::EDGE_FALLING);
/// "on" drives low, "off" is an input.
const SINK: LineFlags = LineFlags::OUTPUT.union(LineFlags::OPEN_DRAIN).union(LineFlags::BIAS_DISABLED);
/// "on" drives high, "off" is an input.
const CHARGER: LineFlags = LineFlags::OUTPUT.union(LineFlags::OPEN_SOURCE).union(LineFlags::BIAS_DISABLED);
/// A sense line that charges.
const CHARGING: LineFlags = LineFlags::OUTPUT.union(LineFlags::BIAS_DISABLED);

/// All drive lines in one request, every one released: the request itself drives nothing.
pub(super) fn drive_request(lines: &Lines, consumer: &str) -> LineRequest {
    let offsets: Vec<u32> = lines.drives.iter().map(|drive| drive.offset).collect();
    request(&offsets, drive_config(lines), consumer)
}

/// The same for lines that are held already.
pub(super) fn drive_config(lines: &Lines) -> LineConfig {
    let mut config = all(SINK);
    let chargers = mask(lines, Drives::CHARGE);
    if chargers != 0 {
        config.add_flags(CHARGER, chargers);
    }
    config.add_values(&released(lines));
    config
}

/// Sense lines in one request, watched from the start and, where they do not charge, for ever. The kernel keeps its default
/// of edges, 16 a line.
pub(super) fn sense_request(sense: &[WiredLine], consumer: &str) -> LineRequest {
    let offsets: Vec<u32> = sense.iter().map(|line| line.offset).collect();
    request(&offsets, all(SENSE), consumer)
}

/// One line as an input and nothing else, its bias as it is.
pub(super) fn release_request(line: &WiredLine, consumer: &str) -> LineRequest {
    request(&[line.offset], all(LineFlags::INPUT), consumer)
}

fn request(offsets: &[u32], config: LineConfig, consumer: &str) -> LineRequest {
    LineRequest {
        offsets: Offsets::from_slice(offsets),
        consumer: consumer.into(),
        config,
        num_lines: offsets.len() as u32,
        ..Default::default()
    }
}

/// Every line of a request with these flags.
pub(super) fn all(flags: LineFlags) -> LineConfig {
    LineConfig { flags, ..Default::default() }
}

/// The sense lines of `chargers` high, the other one an input.
pub(super) fn charging(chargers: Drives) -> LineConfig {
    let mut config = all(INPUT);
    let bit = |part, bit| if chargers.contains(part) { bit } else { 0 };
    let mask = bit(Drives::CHARGE_A, 0b01) | bit(Drives::CHARGE_B, 0b10);
    if mask != 0 {
        config.add_flags(CHARGING, mask);
        config.add_values(&LineValues { bits: mask, mask });
    }
    config
}

/// Values that release every drive line.
fn released(lines: &Lines) -> LineValues {
    let all = mask(lines, lines.wired());
    LineValues { bits: all & !mask(lines, Drives::CHARGE), mask: all }
}

/// The bits of the lines that play a part of `set`.
fn mask(lines: &Lines, set: Drives) -> u64 {
    let playing = lines.drives.iter().enumerate().filter(|(_, drive)| set.contains(drive.part));
    playing.fold(0, |mask, (bit, _)| mask | 1 << bit)
}

/// The calls that a change from one set of driving lines to another takes, in order: none, one if the request order
/// releases before it drives, else two. Only the lines that change are named.
pub(super) fn switching(lines: &Lines, from: Drives, to: Drives) -> impl Iterator<Item = LineValues> {
    let released = mask(lines, from.without(to));
    let driven = mask(lines, to.without(from));
    let chargers = mask(lines, Drives::CHARGE);
    // Open drain: 1 is released, 0 sinks. Open source: 1 charges, 0 is released.
    let release = LineValues { bits: released & !chargers, mask: released };
    let drive = LineValues { bits: driven & chargers, mask: driven };
    let both = LineValues { bits: release.bits | drive.bits, mask: released | driven };
    let in_order = released == 0 || driven == 0 || released.ilog2() < driven.trailing_zeros();
    let calls = match (both.mask, in_order) {
        (0, _) => [None, None],
        (_, true) => [Some(both), None],
        (_, false) => [Some(release), Some(drive)],
    };
    calls.into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::super::wiring::Wiring;
    use super::super::wiring::tests::{lines, wiring};
    use super::*;
    use gpiocdev_uapi::v2::LineAttributeValue;

    /// Request order of the example: x0, x1, c1, c2, charge-a, charge-b.
    const CHARGERS: u64 = 0b11_0000;

    /// The flags that the kernel finds for a line: the first attribute that names it, else the default.
    fn flags_of(config: &LineConfig, bit: usize) -> LineFlags {
        let attributes = config.attrs.0.iter().take(config.num_attrs as usize);
        let mut named = attributes.filter(|attribute| attribute.mask & 1 << bit != 0);
        match named.find_map(|attribute| {
            attribute.attr.to_value().filter(|v| matches!(v, LineAttributeValue::Flags(_)))
        }) {
            Some(LineAttributeValue::Flags(flags)) => flags,
            _ => config.flags,
        }
    }

    /// The output values of a configuration, for the lines that have one.
    fn values_of(config: &LineConfig) -> Option<LineValues> {
        config.attrs.0.iter().take(config.num_attrs as usize).find_map(|attribute| {
            match attribute.attr.to_value() {
                Some(LineAttributeValue::Values(bits)) => Some(LineValues { bits, mask: attribute.mask }),
                _ => None,
            }
        })
    }

    /// What the kernel makes of SET_VALUES: lines switch one by one in request order.
    fn walk(
        lines: &Lines,
        mut driving: Drives,
        calls: impl Iterator<Item = LineValues>,
        mut seen: impl FnMut(Drives),
    ) -> Drives {
        for call in calls {
            for (bit, drive) in lines.drives.iter().enumerate() {
                if let Some(value) = call.get(bit) {
                    let on = value == drive.charges();
                    driving = if on { driving.and(drive.part) } else { driving.without(drive.part) };
                    seen(driving);
                }
            }
        }
        driving
    }

    #[test]
    fn the_drive_request_drives_nothing() {
        let lines = lines(&wiring());
        let request = drive_request(&lines, "cermd");
        assert_eq!(request.num_lines, 6);
        assert_eq!(&request.offsets.0[..6], &[16, 26, 20, 21, 13, 19]);
        assert_eq!(values_of(&request.config).unwrap(), LineValues { bits: 0b00_1111, mask: 0b11_1111 });
        for bit in 0..6 {
            let flags = flags_of(&request.config, bit);
            assert!(flags.contains(LineFlags::OUTPUT | LineFlags::BIAS_DISABLED));
            assert_eq!(flags.contains(LineFlags::OPEN_SOURCE), CHARGERS & 1 << bit != 0);
            assert_eq!(flags.contains(LineFlags::OPEN_DRAIN), CHARGERS & 1 << bit == 0);
        }
        assert_eq!(request.consumer, "cermd".into());
    }

    #[test]
    fn dedicated_sense_lines_are_watched_for_ever() {
        let request = sense_request(&lines(&wiring()).sense, "cermd");
        assert_eq!(&request.offsets.0[..2], &[5, 6]);
        assert_eq!((request.num_lines, request.event_buffer_size), (2, 0));
        assert_eq!(
            request.config.flags,
            LineFlags::INPUT | LineFlags::EDGE_FALLING | LineFlags::BIAS_DISABLED
        );
        assert_eq!(request.config.num_attrs, 0);
    }

    #[test]
    fn where_sense_lines_charge_all_that_drives_sinks() {
        let lines = lines(&Wiring { charge_a: None, charge_b: None, ..wiring() });
        let drive = drive_request(&lines, "cermd");
        assert_eq!(drive.num_lines, 4);
        assert!((0..4).all(|bit| flags_of(&drive.config, bit).contains(LineFlags::OPEN_DRAIN)));
    }

    #[test]
    fn charging_by_sense_lines_drives_high_those_that_are_asked_for() {
        let both = charging(Drives::CHARGE);
        assert_eq!(values_of(&both).unwrap(), LineValues { bits: 0b11, mask: 0b11 });
        assert_eq!(flags_of(&both, 1), LineFlags::OUTPUT | LineFlags::BIAS_DISABLED);
        let one = charging(Drives::CHARGE_B);
        assert_eq!(values_of(&one).unwrap(), LineValues { bits: 0b10, mask: 0b10 });
        assert_eq!(flags_of(&one, 0), LineFlags::INPUT | LineFlags::BIAS_DISABLED);
        assert_eq!(charging(Drives::NONE).num_attrs, 0);
    }

    #[test]
    fn one_call_where_the_order_permits_two_where_not() {
        let lines = lines(&wiring());
        let calls = |from, to| switching(&lines, from, to).count();
        let x = Drives::x(0);
        for (from, to, expected) in [
            (Drives::NONE, Drives::CHARGE, 1),
            (Drives::CHARGE, Drives::NONE, 1),
            (Drives::NONE, x, 1),
            (x, Drives::C2, 1),
            (x, Drives::CHARGE, 1),
            (Drives::C1, Drives::C2, 1),
            (x.and(Drives::C2), x, 1),
            (x, x, 0),
            (Drives::C2, x, 2),
            (Drives::C2, Drives::C1, 2),
            (Drives::CHARGE, x, 2),
            (Drives::C1.and(Drives::C2), Drives::C2.and(x), 2),
        ] {
            assert_eq!(calls(from, to), expected, "{from} to {to}");
        }
    }

    #[test]
    fn every_change_arrives_and_releases_before_it_drives() {
        let lines = lines(&wiring());
        let sets: Vec<Drives> = (0..64u32)
            .map(|bits| lines.drives.iter().enumerate().filter(move |(bit, _)| bits & 1 << bit != 0))
            .map(|chosen| chosen.fold(Drives::NONE, |set, (_, drive)| set.and(drive.part)))
            .filter(|set| !set.conflicts())
            .collect();
        for from in &sets {
            for to in &sets {
                let mut driven_one = false;
                let mut last = *from;
                let end = walk(&lines, *from, switching(&lines, *from, *to), |now| {
                    assert!(!now.conflicts(), "{from} to {to} passes through {now}");
                    assert_ne!(now, last, "{from} to {to} touches a line that does not change");
                    let releases = now.count() < last.count();
                    assert!(!(driven_one && releases), "{from} to {to} drives before it releases");
                    driven_one |= !releases;
                    last = now;
                });
                assert_eq!(end, *to);
            }
        }
    }
}
