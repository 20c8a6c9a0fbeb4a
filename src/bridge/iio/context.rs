//! The channels as a device of IIO: its description, and what its attributes say.

use crate::stream::wire::{ChannelInfo, ReadingLine, StatusName, Unit, VersionLine};
use crate::units::markup::escaped;
use std::fmt::Write;

/// The one device.
pub const DEVICE: &str = "iio:device0";
/// What the description may hold; libiio validates it.
const TYPES: &str = "<!DOCTYPE context [<!ELEMENT context (device)*><!ELEMENT device (channel | attribute)*>\
                     <!ELEMENT channel (scan-element?, attribute*)><!ELEMENT attribute EMPTY><!ELEMENT scan-element EMPTY>\
                     <!ATTLIST context name CDATA #REQUIRED description CDATA #IMPLIED>\
                     <!ATTLIST device id CDATA #REQUIRED name CDATA #IMPLIED>\
                     <!ATTLIST channel id CDATA #REQUIRED type (input|output) #REQUIRED name CDATA #IMPLIED>\
                     <!ATTLIST scan-element index CDATA #REQUIRED format CDATA #REQUIRED scale CDATA #IMPLIED>\
                     <!ATTLIST attribute name CDATA #REQUIRED filename CDATA #IMPLIED>]>";
/// Thousandths of the unit of a channel are finer than any reading, and 64 bits hold every one.
const SCALE: f64 = 0.001;

// errno(3), as the protocol has them.
pub const EINVAL: i32 = 22;
pub const ENOENT: i32 = 2;
pub const ENODATA: i32 = 61;

/// What an element of a scan is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Element {
    /// The resistance of the channel of this number.
    Resistance(usize),
    /// What it shows: its force, or what its law gives.
    Shown(usize, ChannelType),
    /// When: ns since 1970.
    Timestamp,
}

/// What a channel shows, and with it the name and the unit that IIO has for that (Documentation/ABI/testing/sysfs-bus-iio).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChannelType {
    /// Newton; IIO has none.
    Force,
    /// Thousandths of a degC.
    Temperature,
    /// Lux.
    Illuminance,
    /// Metre.
    Distance,
    /// In the unit of the channel; IIO has none.
    Value,
}

impl ChannelType {
    fn of(unit: &Unit) -> Option<ChannelType> {
        Some(match unit.as_str() {
            "ohm" => return None,
            "N" => ChannelType::Force,
            "degC" => ChannelType::Temperature,
            "lx" => ChannelType::Illuminance,
            "mm" => ChannelType::Distance,
            _ => ChannelType::Value,
        })
    }

    fn name(self) -> &'static str {
        match self {
            ChannelType::Force => "force",
            ChannelType::Temperature => "temp",
            ChannelType::Illuminance => "illuminance",
            ChannelType::Distance => "distance",
            ChannelType::Value => "value",
        }
    }

    /// One of the channel's unit in that of IIO.
    fn factor(self) -> f64 {
        match self {
            ChannelType::Temperature => 1000.0,
            ChannelType::Distance => 0.001,
            ChannelType::Force | ChannelType::Illuminance | ChannelType::Value => 1.0,
        }
    }
}

/// The device as one client was told of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Context {
    release: String,
    pub channels: Vec<ChannelInfo>,
    /// In the order of a row.
    pub elements: Vec<Element>,
}

impl Context {
    pub fn new(version: &VersionLine) -> Context {
        let channels = version.channels.clone();
        let of = |(at, channel): (usize, &ChannelInfo)| {
            let shown = ChannelType::of(&channel.unit).map(|quantity| Element::Shown(at, quantity));
            [Element::Resistance(at)].into_iter().chain(shown)
        };
        let elements = channels.iter().enumerate().flat_map(of).chain([Element::Timestamp]).collect();
        Context { release: version.release.clone(), channels, elements }
    }

    /// The description that clients begin with.
    pub fn xml(&self) -> String {
        let release = escaped(&self.release);
        let mut xml = format!(
            "<?xml version=\"1.0\" encoding=\"utf-8\"?>{TYPES}<context name=\"network\" description=\"cermd {release}\">\
             <device id=\"{DEVICE}\" name=\"cermd\">"
        );
        for (index, element) in self.elements.iter().enumerate() {
            let id = id(*element);
            let (name, scale) = match element {
                Element::Resistance(at) | Element::Shown(at, _) => (
                    format!(" name=\"{}\"", escaped(&self.channels[*at].id)),
                    format!(" scale=\"{}\"", SCALE * factor(*element)),
                ),
                Element::Timestamp => (String::new(), String::new()),
            };
            let _ = write!(
                xml,
                "<channel id=\"{id}\"{name} type=\"input\"><scan-element index=\"{index}\" \
                 format=\"le:s64/64&gt;&gt;0\"{scale}/>"
            );
            for attribute in attributes(*element) {
                let _ = write!(xml, "<attribute name=\"{attribute}\" filename=\"in_{id}_{attribute}\"/>");
            }
            xml += "</channel>";
        }
        xml + "</device></context>"
    }

    /// The element that a client calls so.
    pub fn element(&self, wanted: &str) -> Option<Element> {
        self.elements.iter().copied().find(|element| id(*element) == wanted)
    }

    /// What an attribute says, or the number of an error. `reading`: the fresh one of the channel.
    pub fn attribute(
        &self,
        element: Element,
        name: &str,
        reading: Option<&ReadingLine>,
    ) -> Result<String, i32> {
        if !attributes(element).contains(&name) {
            return Err(ENOENT);
        }
        match name {
            "scale" => return Ok((SCALE * factor(element)).to_string()),
            "status" => return Ok(status(reading)),
            _ => {}
        }
        let (value, u) = reading.map_or((None, None), |reading| numbers(element, reading));
        let text = match name {
            "raw" => value.map(|value| thousandths(value).to_string()),
            "input" => value.map(|value| (value * factor(element)).to_string()),
            _ => u.map(|u| (u * factor(element)).to_string()),
        };
        text.ok_or(ENODATA)
    }
}

/// A value of a row; `None`: there is no number. `time_ns`: of the row.
pub fn sample(element: Element, reading: Option<&ReadingLine>, time_ns: i64) -> Option<i64> {
    match element {
        Element::Timestamp => Some(time_ns),
        element => numbers(element, reading?).0.map(thousandths),
    }
}

/// One of the channel's unit in that of IIO.
fn factor(element: Element) -> f64 {
    match element {
        Element::Shown(_, quantity) => quantity.factor(),
        Element::Resistance(_) | Element::Timestamp => 1.0,
    }
}

fn thousandths(value: f64) -> i64 {
    (value / SCALE).round() as i64
}

fn numbers(element: Element, reading: &ReadingLine) -> (Option<f64>, Option<f64>) {
    let state = &reading.state;
    match element {
        Element::Resistance(_) => (state.r_ohm, state.r_u_ohm),
        Element::Shown(_, ChannelType::Force) => (state.f_n, state.f_u_n),
        Element::Shown(..) => (state.value, state.value_u),
        Element::Timestamp => (None, None),
    }
}

fn status(reading: Option<&ReadingLine>) -> String {
    match reading.map(|reading| (reading.state.status, &reading.state.fault)) {
        None => "unknown".to_owned(),
        Some((StatusName::Ok, _)) => "ok".to_owned(),
        Some((StatusName::Open, _)) => "open".to_owned(),
        Some((StatusName::Short, _)) => "short".to_owned(),
        Some((StatusName::Fault, fault)) => format!("fault {}", fault.as_deref().unwrap_or_default()),
    }
}

fn id(element: Element) -> String {
    match element {
        Element::Resistance(at) => format!("resistance{at}"),
        Element::Shown(at, quantity) => format!("{}{at}", quantity.name()),
        Element::Timestamp => "timestamp".to_owned(),
    }
}

fn attributes(element: Element) -> &'static [&'static str] {
    match element {
        Element::Timestamp => &[],
        _ => &["raw", "scale", "input", "uncertainty", "status"],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bridge::feed::Heard;
    use crate::bridge::latest::tests::{ok, reading, up};
    use crate::stream::wire::StateLine;

    #[test]
    fn a_device_has_a_channel_for_each_number() {
        let Heard::Up(version) = up(&["thumb", "<a> & \"b\""]) else { unreachable!() };
        let context = Context::new(&version);
        insta::assert_snapshot!(context.xml().replace("><", ">\n<"));
        assert_eq!(context.element("force1"), Some(Element::Shown(1, ChannelType::Force)));
        assert_eq!(context.element("force2"), None);
    }

    #[test]
    fn what_is_not_known_is_an_error_and_no_number() {
        let Heard::Up(version) = up(&["thumb"]) else { unreachable!() };
        let context = Context::new(&version);
        let Heard::Reading(good, _) = reading("thumb", 0, ok(2841.3)) else { unreachable!() };
        let open = StateLine { status: StatusName::Open, r_min_ohm: Some(1e6), ..StateLine::default() };
        let Heard::Reading(open, _) = reading("thumb", 0, open) else { unreachable!() };
        let say = |name, reading| context.attribute(Element::Resistance(0), name, reading);
        assert_eq!(say("raw", Some(&*good)).as_deref(), Ok("2841300"));
        assert_eq!(say("input", Some(&*good)).as_deref(), Ok("2841.3"));
        assert_eq!(say("uncertainty", Some(&*good)).as_deref(), Ok("1.2"));
        assert_eq!(say("status", Some(&*good)).as_deref(), Ok("ok"));
        assert_eq!(say("status", Some(&*open)).as_deref(), Ok("open"));
        assert_eq!(say("status", None).as_deref(), Ok("unknown"));
        for reading in [Some(&*open), None] {
            for name in ["raw", "input", "uncertainty"] {
                assert_eq!(say(name, reading), Err(ENODATA), "{name}");
            }
        }
        assert_eq!(say("offset", Some(&*good)), Err(ENOENT));
        // No characteristic: no force.
        assert_eq!(
            context.attribute(Element::Shown(0, ChannelType::Force), "raw", Some(&good)),
            Err(ENODATA)
        );
        assert_eq!(sample(Element::Resistance(0), Some(&open), 7), None);
        assert_eq!(sample(Element::Timestamp, None, 7), Some(7));
    }

    #[test]
    fn what_laws_give_is_in_the_units_of_iio() {
        let channel =
            |unit: &str| ChannelInfo { id: unit.to_owned(), unit: Unit::named(unit), trigger: false };
        let units = ["degC", "mm", "lx", "%RH"];
        let context = Context::new(&VersionLine::new(&units.map(channel)));
        let state = StateLine { value: Some(23.4567), value_u: Some(0.25), ..ok(1.0) };
        let Heard::Reading(line, _) = reading("degC", 0, state) else { unreachable!() };
        let say = |id, name| context.attribute(context.element(id).unwrap(), name, Some(&*line)).unwrap();
        for (id, scale, input, uncertainty) in [
            ("temp0", "1", 23_456.7, 250.0),
            ("distance1", "0.000001", 0.023_456_7, 0.000_25),
            ("illuminance2", "0.001", 23.4567, 0.25),
            ("value3", "0.001", 23.4567, 0.25),
        ] {
            assert_eq!((say(id, "scale").as_str(), say(id, "raw").as_str()), (scale, "23457"), "{id}");
            for (name, wanted) in [("input", input), ("uncertainty", uncertainty)] {
                let number: f64 = say(id, name).parse().unwrap();
                assert!((number / wanted - 1.0f64).abs() < 1e-9, "{id} {name}: {number}");
            }
        }
    }
}
