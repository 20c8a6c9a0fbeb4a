//! What Home Assistant is told about a board: one device with its entities.
//! <https://www.home-assistant.io/integrations/mqtt/#device-discovery-payload>

use super::Topics;
use crate::bridge::limits::{SILENCES, STATS_EVERY};
use crate::stream::wire::{ChannelInfo, StatusName, Unit, VersionLine};
use serde_json::{Map, Value, json};
use std::time::Duration;

/// The device with an entity for each number and state. `every`: the longest silence of a channel that is read.
pub fn device(topics: &Topics, version: &VersionLine, every: Duration) -> Value {
    let mut entities = Map::new();
    for channel in &version.channels {
        of_channel(topics, channel, every, &mut entities);
        if channel.trigger {
            of_trigger(topics, &channel.id, every, &mut entities);
        }
    }
    of_instrument(topics, every, &mut entities);
    json!({
        "dev": {"ids": [format!("cermd-{}", topics.id)], "name": topics.id, "mf": "cermd", "sw": version.release},
        "o": {"name": "cermd", "sw": version.release},
        "availability_topic": topics.availability(),
        "cmps": entities,
    })
}

/// The same, and what takes back the entities of channels that there were before; `None`: there are none of these.
pub fn device_without(
    topics: &Topics,
    version: &VersionLine,
    before: &VersionLine,
    every: Duration,
) -> Option<Value> {
    let (mut device, before) = (device(topics, version, every), device(topics, before, every));
    let (entities, before) = (device["cmps"].as_object_mut()?, before["cmps"].as_object()?);
    let gone: Vec<_> = before.iter().filter(|(key, _)| !entities.contains_key(*key)).collect();
    // An entity with nothing but its platform is removed.
    entities.extend(gone.iter().map(|(key, entity)| ((*key).clone(), json!({"p": entity["p"]}))));
    (!gone.is_empty()).then_some(device)
}

fn of_channel(topics: &Topics, channel: &ChannelInfo, every: Duration, entities: &mut Map<String, Value>) {
    let id = &channel.id;
    // Of each number: what it is, its unit and the digits that are shown, its keys in the payload, and what Home Assistant calls it.
    let force = ("force", "N", 3, "f_n", ["f_u_n", "f_repeat_u_n", "f_min_n", "f_max_n"]);
    let resistance = ("resistance", "\u{3a9}", 1, "r_ohm", ["r_u_ohm", "r_min_ohm", "r_max_ohm", "method"]);
    let of_value = ["value_u", "value_repeat_u", "value_min", "value_max"];
    let (name, class) = quantity(&channel.unit);
    let value = (name, channel.unit.symbol(), 2, "value", of_value);
    let numbers = match channel.unit {
        Unit::Newton => vec![force, resistance],
        Unit::Ohm => vec![resistance],
        Unit::Other(_) => vec![value, resistance],
    };
    for (name, unit, digits, key, attributes) in numbers {
        let mut more = json!({
            "unit_of_measurement": unit, "state_class": "measurement", "suggested_display_precision": digits,
            // No number is no number: unknown, not the last one and not 0.
            "value_template": template(key),
        });
        if let Some(class) = class.filter(|_| key == "value") {
            more["device_class"] = class.into();
        }
        let attributes: Vec<&str> =
            attributes.into_iter().chain(["moving", "settling", "extrapolated"]).collect();
        add(topics, id, name, every, more, &attributes, entities);
    }
    let options = [StatusName::Ok, StatusName::Open, StatusName::Short, StatusName::Fault];
    let more = json!({
        "device_class": "enum", "options": options, "entity_category": "diagnostic",
        "value_template": template("status"),
    });
    add(topics, id, "status", every, more, &["fault", "hint"], entities);
}

/// What a channel with a law measures, by its unit, and the device class of that in Home Assistant, if there is one.
/// <https://www.home-assistant.io/integrations/sensor/#device-class>
fn quantity(unit: &Unit) -> (&'static str, Option<&'static str>) {
    match unit.as_str() {
        "degC" => ("temperature", Some("temperature")),
        "lx" => ("illuminance", Some("illuminance")),
        "mm" => ("position", Some("distance")),
        "deg" => ("angle", None),
        _ => ("value", None),
    }
}

/// There is no "." in the name of a board: "hall" and "thumb-index" are not "hall-thumb" and "index".
fn unique(topics: &Topics, entity: &str) -> String {
    format!("cermd-{}.{entity}", topics.id)
}

fn template(key: &str) -> String {
    format!("{{{{ value_json.{key} if value_json.{key} is defined else None }}}}")
}

fn add(
    topics: &Topics,
    channel: &str,
    name: &str,
    every: Duration,
    more: Value,
    attributes: &[&str],
    entities: &mut Map<String, Value>,
) {
    let topic = topics.channel(channel);
    let kept: Vec<_> = attributes.iter().map(|name| format!("'{name}'")).collect();
    let mut entity = json!({
        "p": "sensor", "name": format!("{channel} {name}"), "state_topic": topic,
        "unique_id": unique(topics, &format!("{channel}-{name}")),
        "expire_after": expiry(every),
        "json_attributes_topic": topic,
        "json_attributes_template": format!(
            "{{{{ dict(value_json.items() | selectattr(0, 'in', [{}])) | tojson }}}}", kept.join(", ")
        ),
    });
    merge(&mut entity, more);
    entities.insert(format!("{channel}_{name}"), entity);
}

/// Pressed or not; not known is neither.
fn of_trigger(topics: &Topics, channel: &str, every: Duration, entities: &mut Map<String, Value>) {
    let topic = topics.trigger(channel);
    let entity = json!({
        "p": "binary_sensor", "name": format!("{channel} pressed"), "state_topic": topic,
        "unique_id": unique(topics, &format!("{channel}-pressed")),
        "value_template":
            "{{ None if value_json.reason is defined else ('ON' if value_json.event == 'pressed' else 'OFF') }}",
        "expire_after": expiry(every.max(STATS_EVERY)),
        "json_attributes_topic": topic,
    });
    entities.insert(format!("{channel}_pressed"), entity);
}

fn of_instrument(topics: &Topics, every: Duration, entities: &mut Map<String, Value>) {
    let rate = json!({
        "p": "sensor", "name": "Readings", "unit_of_measurement": "Hz", "device_class": "frequency",
        "state_class": "measurement", "value_template": template("rate_hz"),
        "json_attributes_topic": topics.instrument(),
    });
    let trouble = json!({
        "p": "binary_sensor", "name": "GPIO", "device_class": "problem",
        "value_template": "{{ 'OFF' if value_json.gpio_works else 'ON' }}",
    });
    // The two names are no channel's: those end in what they measure.
    for (key, mut entity) in [("rate", rate), ("gpio", trouble)] {
        let more = json!({
            "unique_id": unique(topics, key), "state_topic": topics.instrument(),
            "entity_category": "diagnostic", "expire_after": expiry(every.max(STATS_EVERY)),
        });
        merge(&mut entity, more);
        entities.insert(key.to_owned(), entity);
    }
}

/// After so many seconds of silence nothing is known any more, of what is told at such intervals.
fn expiry(every: Duration) -> u64 {
    (every * SILENCES).as_secs_f64().ceil() as u64
}

fn merge(entity: &mut Value, more: Value) {
    if let (Value::Object(entity), Value::Object(more)) = (entity, more) {
        entity.extend(more);
    }
}
