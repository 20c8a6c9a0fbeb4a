//! `cermctl stats`: what the daemon has counted and learned.
//!
//! Names and units are in the keys of STATS, so that fields of later releases are shown, too.

use super::stream::Stream;
use super::terminal::Terminal;
use super::{CtlError, achieved, print};
use crate::ctl::cli;
use crate::stream::wire::{ChannelStats, Unit};
use crate::units::{ForceUnit, measured};
use console::{Alignment, measure_text_width, pad_str};
use serde::Deserialize;
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// Prints.
pub fn run(arguments: &cli::Stats) -> Result<(), CtlError> {
    let mut stream = Stream::connect(&arguments.connection.socket, &[])?;
    let (line, _) = stream.stats()?;
    if arguments.json {
        return print(&(line + "\n"));
    }
    let mut terminal = Terminal::new();
    table(&line, &stream.units(), terminal.unicode).lines().try_for_each(|line| terminal.say(line))
}

/// The fields that are known, in the order in which a person asks; later releases have more.
const ORDER: &str = "backend method uptime_s clients published lost cycles readings ok moving open short faults retried \
                     offset_known offset_ns r_o_ohm";

/// One line for each field of STATS that says something; `units`: of the channels.
pub fn table(line: &str, units: &BTreeMap<String, Unit>, unicode: bool) -> String {
    let mut stats: Map<String, Value> = serde_json::from_str(line).unwrap_or_default();
    stats.remove("class");
    let place = |key: &str| ORDER.split(' ').position(|known| known == key).unwrap_or(usize::MAX);
    let mut fields: Vec<_> = stats.iter().collect();
    fields.sort_by_key(|(key, _)| place(key));
    let (channels, fields): (Vec<_>, Vec<_>) = fields.into_iter().partition(|(key, _)| *key == "channels");
    let rows = fields.into_iter().filter_map(|(key, value)| row(&stats, key, value, unicode));
    let rows: Vec<_> =
        rows.chain(channels.into_iter().flat_map(|(_, value)| channel_rows(value, units))).collect();
    let width = rows.iter().map(|(name, _)| measure_text_width(name)).max().unwrap_or(0);
    let padded = |name: &str| pad_str(name, width, Alignment::Left, None).into_owned();
    rows.iter().map(|(name, value)| format!("{}  {value}\n", padded(name))).collect()
}

/// What the last readings of each channel came to.
fn channel_rows(channels: &Value, units: &BTreeMap<String, Unit>) -> Vec<(String, String)> {
    let channels = BTreeMap::<String, ChannelStats>::deserialize(channels).unwrap_or_default();
    let row = |(id, stats): (String, ChannelStats)| {
        let unit = units.get(&id).map(Unit::as_str).unwrap_or_default();
        let words = achieved::in_words(&stats, ForceUnit::Newton, unit);
        (format!("channel {id}"), format!("{words}; the last {:.1} s", stats.span_s))
    };
    channels.into_iter().filter(|(_, stats)| stats.readings > 0).map(row).collect()
}

fn row(stats: &Map<String, Value>, key: &str, value: &Value, unicode: bool) -> Option<(String, String)> {
    let (stem, unit) = unit_of(key);
    // An uncertainty stands beside its value.
    if stem.ends_with("_u") {
        return None;
    }
    let text = match value {
        Value::Object(counts) => {
            let counts = counts.iter().filter(|(_, count)| count.as_u64() != Some(0));
            let named: Vec<String> = counts
                .map(|(name, count)| match count {
                    Value::String(text) => format!("{name} {text}"),
                    count => format!("{count} {name}"),
                })
                .collect();
            if named.is_empty() { "none".to_owned() } else { named.join(", ") }
        }
        Value::Bool(flag) => (if *flag { "yes" } else { "no" }).to_owned(),
        Value::String(text) => text.clone(),
        Value::Number(number) => match unit {
            Some((unit, scale)) => {
                let u = key.strip_prefix(stem).map(|suffix| format!("{stem}_u{suffix}"));
                let u = u.and_then(|key| stats.get(&key)).and_then(Value::as_f64);
                measured(number.as_f64()? * scale, u.map(|u| u * scale), unit, unicode)
            }
            None => number.to_string(),
        },
        other => other.to_string(),
    };
    Some((name(stem), text))
}

/// A key without its unit, and the unit that is shown with what it takes to get there.
fn unit_of(key: &str) -> (&str, Option<(&'static str, f64)>) {
    const UNITS: [(&str, &str, f64); 5] =
        [("_ns", "us", 1e-3), ("_us", "us", 1.0), ("_s", "s", 1.0), ("_ohm", "ohm", 1.0), ("_n", "N", 1.0)];
    let found = UNITS
        .iter()
        .find_map(|(suffix, unit, scale)| key.strip_suffix(suffix).map(|stem| (stem, Some((*unit, *scale)))));
    found.unwrap_or((key, None))
}

fn name(stem: &str) -> String {
    match stem {
        "offset" => "latency offset".to_owned(),
        "offset_known" => "latency offset known".to_owned(),
        "r_o" => "pin resistance".to_owned(),
        "retried" => "discharges retried".to_owned(),
        "lost" => "readings lost by clients".to_owned(),
        "published" => "readings published".to_owned(),
        other => other.replace('_', " "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_and_uncertainties_come_from_the_keys() {
        let stats = serde_json::json!({
            "backend": "mock", "uptime_s": 12.3456, "readings": 7, "faults": {"missed-edge": 0, "no-charge": 2},
            "channels": {"thumb": {"span_s": 10.2, "readings": 11, "rate_hz": 0.98, "ok": 11, "moving": 0,
                "settling": 0, "open": 0, "short": 0, "faults": 0}},
            "offset_known": true, "offset_ns": 8012.3, "offset_u_ns": 110, "r_o_ohm": 40.61, "new_field": [1],
        });
        insta::assert_snapshot!(table(&stats.to_string(), &BTreeMap::new(), false), @r"
        backend               mock
        uptime                12.35 s
        readings              7
        faults                2 no-charge
        latency offset known  yes
        latency offset        8.01 +- 0.11 us
        pin resistance        40.61 ohm
        new field             [1]
        channel thumb         1.0/s, 100 % ok; the last 10.2 s
        ");
    }
}
