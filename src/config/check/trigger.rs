//! The triggers of the channels: thresholds that a reading can pass, times that can be kept, lines that are free.

use super::channels::key;
use crate::config::limits::{HYSTERESIS, LONGEST_WAIT};
use crate::config::trigger::{Level, Thresholds};
use crate::config::{ChannelTable, Config, Findings};
use crate::units::{Nanos, Seconds};

pub fn check(config: &Config, findings: &mut Findings) {
    for (index, channel) in config.channels.iter().enumerate() {
        let at = |name: &str| key(index, channel, name);
        match channel.levels() {
            Some(read) => {
                match read {
                    Ok(read) => {
                        keys_of_the_other_way(read.keys, channel, &at, findings);
                        levels(read, &at, findings);
                    }
                    Err((name, reason, remedy)) => findings.error(at(name), reason, remedy),
                }
                times(channel, &at, findings);
            }
            None => keys_without_a_threshold(channel, &at, findings),
        }
    }
    outputs(config, findings);
}

/// What a time that is given is compared with, and what to expect: to be called where times can be predicted.
pub fn predict(config: &Config, findings: &mut Findings) {
    for (index, channel) in config.channels.iter().enumerate() {
        let Some(Ok(Thresholds { keys, on, .. })) = channel.levels() else { continue };
        let interval = config.longest_interval(channel);
        // The reading of a mean is as old as half of it, and the next one comes as much later.
        let least = interval + interval;
        if let Some(stale) = channel.stale.filter(|stale| *stale < least) {
            findings.error(
                key(index, channel, "stale"),
                format!(
                    "{:.2} is shorter than from one reading to the one after the next, up to {:.2} with every sensor open",
                    Seconds::from(stale),
                    Seconds::from(least)
                ),
                format!("at least \"{:.2}\", or a shorter deadline or average", Seconds::from(least)),
            );
        }
        let hold = channel.hold.unwrap_or(Nanos::ZERO);
        let latest = Seconds::from(hold + interval + if hold > Nanos::ZERO { interval } else { Nanos::ZERO });
        findings.info(
            key(index, channel, keys[0]),
            format!("{on}: told {latest:.2} after it is so, or sooner, unless readings are faults"),
        );
    }
}

fn written(channel: &ChannelTable) -> [(&'static str, bool); 7] {
    [
        ("on-above", channel.on_above.is_some()),
        ("off-below", channel.off_below.is_some()),
        ("on-below", channel.on_below.is_some()),
        ("off-above", channel.off_above.is_some()),
        ("hold", channel.hold.is_some()),
        ("stale", channel.stale.is_some()),
        ("output", channel.output.is_some()),
    ]
}

fn keys_without_a_threshold(channel: &ChannelTable, at: &dyn Fn(&str) -> String, findings: &mut Findings) {
    for (name, _) in written(channel).into_iter().filter(|(_, is_there)| *is_there) {
        findings.error(
            at(name),
            "the channel has no threshold",
            "on-above = \"2 N\" beside it, or without it",
        );
    }
}

fn keys_of_the_other_way(
    keys: [&str; 2],
    channel: &ChannelTable,
    at: &dyn Fn(&str) -> String,
    findings: &mut Findings,
) {
    let others =
        written(channel).into_iter().take(4).filter(|(name, is_there)| *is_there && !keys.contains(name));
    for (name, _) in others {
        let [on, off] = keys;
        findings.error(at(name), format!("it does not go with {on}"), format!("{on} with {off}, one pair"));
    }
}

fn levels(Thresholds { keys, on, off }: Thresholds, at: &dyn Fn(&str) -> String, findings: &mut Findings) {
    for (key, level) in keys.into_iter().zip([on, off]) {
        if level.is_of_a_ratio() && level.value <= 0.0 {
            let example = if level.unit == "N" { "\"2 N\"" } else { "\"5 kohm\"" };
            findings.error(at(key), format!("{level} is not above zero"), example);
            return;
        }
    }
    if on.unit != off.unit {
        let reason = format!("{off} is not of the same kind as {} = {on}", keys[0]);
        findings.error(at(keys[1]), reason, "the same unit in both");
        return;
    }
    let is_above = keys[0] == "on-above";
    if is_above != (on.value > off.value) || on.value == off.value {
        let side = if is_above { "below" } else { "above" };
        let remedy = if on.is_of_a_ratio() {
            let usual = if is_above { HYSTERESIS * on.value } else { on.value / HYSTERESIS };
            format!("\"{:.3}\", or without it", Level { value: usual, ..on })
        } else {
            format!("what is {side} {on} by more than that wanders")
        };
        findings.error(at(keys[1]), format!("{off} is not {side} {} = {on}", keys[0]), remedy);
    }
}

fn times(channel: &ChannelTable, at: &dyn Fn(&str) -> String, findings: &mut Findings) {
    for (name, time, least, remedy) in [
        ("hold", channel.hold, Nanos::ZERO, "\"20 ms\", or without it"),
        ("stale", channel.stale, Nanos(1), "\"500 ms\", or without it"),
    ] {
        if let Some(time) = time.filter(|time| !(least..=LONGEST_WAIT).contains(time)) {
            let bounds = if least > Nanos::ZERO { "above 0 and up to" } else { "between 0 and" };
            let reason = format!("{:.3} is not {bounds} 1 min", Seconds::from(time));
            findings.error(at(name), reason, remedy);
        }
    }
}

/// Names of lines are compared as they are written; that a line is taken under another name, the kernel says.
fn outputs(config: &Config, findings: &mut Findings) {
    let chip_of = |channel: &ChannelTable| {
        let output = channel.output.as_ref()?;
        Some((output.chip.clone().or_else(|| config.gpio.chip.clone()), output.line.clone()))
    };
    let own = super::gpio::every_line(config);
    for (index, channel) in config.channels.iter().enumerate() {
        let Some((chip, line)) = chip_of(channel) else { continue };
        let at = key(index, channel, "output");
        let is_own_chip = chip == config.gpio.chip;
        if let Some((other, _)) = own.iter().find(|(_, other)| is_own_chip && **other == line) {
            findings.error(&at, format!("{} is {other} already", line.0), "a line of its own");
        }
        let before = config.channels[..index]
            .iter()
            .position(|other| chip_of(other) == Some((chip.clone(), line.clone())));
        if let Some(before) = before {
            let other = key(before, &config.channels[before], "output");
            findings.error(&at, format!("{} is {other} already", line.0), "a line of its own");
        }
        if chip.is_none() && config.gpio.backend != crate::config::Backend::Mock {
            findings.error(&at, "neither it nor [gpio] names a chip", "chip = \"pinctrl-rp1\" in it");
        }
    }
}
