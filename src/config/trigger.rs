//! The trigger of a channel: `on-above = "2 N"`, `off-below = "1.5 N"`, or downwards `on-below`, `off-above`; `hold`, `stale`, and
//! the line that follows it, `output = { line = "GPIO17" }`.

use super::backend::{CONSUMER, OpenError};
use super::limits::{HYSTERESIS, SHORTEST_STALE, STALE_READINGS};
use super::{Backend, ChannelTable, Config, LawSource, LineName};
use crate::pins::output::OutputLine;
use crate::trigger::{Compared, State, TriggerRules};
use crate::units::{Celsius, Degree, Lux, Metre, Nanos, Newton, Ohm, Seconds, named};
use serde::{Deserialize, Serialize};
use std::fmt;

/// A threshold, in what its channel shows or in ohm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Level<'a> {
    /// In the unit.
    pub value: f64,
    /// That of the channel, or "ohm".
    pub unit: &'a str,
}

impl<'a> Level<'a> {
    /// As it is written: in the unit of the channel, which has other spellings where it is a known one, or in ohm.
    fn read(text: &str, unit: &'a str) -> Option<Level<'a>> {
        let verbatim = text.trim().strip_suffix(unit).and_then(|number| number.trim().parse().ok());
        let spelled = match unit {
            "N" => text.parse().ok().map(|Newton(force)| force),
            "degC" => text.parse().ok().map(|Celsius(temperature)| temperature),
            "lx" => text.parse().ok().map(|Lux(illuminance)| illuminance),
            "mm" => text.parse().ok().map(|Metre(length)| 1e3 * length),
            "deg" => text.parse().ok().map(|Degree(angle)| angle),
            _ => None,
        };
        let shown = verbatim.or(spelled).filter(|value: &f64| value.is_finite());
        let resistance = || text.parse().ok().map(|Ohm(value)| Level { value, unit: "ohm" });
        shown.map(|value| Level { value, unit }).or_else(resistance)
    }

    fn quantity(self) -> Compared {
        if self.unit == "ohm" { Compared::Resistance } else { Compared::Shown }
    }

    /// Whether a part of it means something: 0 is none of it. Of what a law shows, nobody has said that.
    pub fn is_of_a_ratio(self) -> bool {
        matches!(self.unit, "N" | "ohm")
    }
}

impl fmt::Display for Level<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.unit {
            "N" => Newton(self.value).fmt(f),
            "ohm" => Ohm(self.value).fmt(f),
            unit => write!(f, "{} {unit}", self.value),
        }
    }
}

/// Where a channel becomes pressed, and where released.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thresholds<'a> {
    /// The names of their keys.
    pub keys: [&'static str; 2],
    /// Pressed from here on.
    pub on: Level<'a>,
    /// Released from here on, the other way.
    pub off: Level<'a>,
}

/// A threshold that says nothing: the name of its key, what is wrong, and what to write.
pub type NoLevel = (&'static str, String, String);

named! {
    /// While what is known an output is active; while nothing is known it never is.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    When {
        /// While it is known that the channel is pressed.
        #[default]
        Pressed = "pressed",
        /// While it is known that it is not.
        Released = "released",
    }
}

impl When {
    /// Whether an output is active then.
    pub fn is_active(self, state: State) -> bool {
        match self {
            When::Pressed => state == State::Pressed,
            When::Released => state == State::Released,
        }
    }
}

/// `output = { .. }`: a line that follows the trigger.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct OutputTable {
    /// The line. Required.
    pub line: LineName,
    /// Its chip. Default: that of `[gpio]`.
    pub chip: Option<String>,
    /// Whether it is low while it is active. Default: no.
    #[serde(default)]
    pub active_low: bool,
    /// When it is active. Default: while pressed.
    #[serde(default)]
    pub when: When,
}

/// The trigger of one channel with every default filled in.
#[derive(Debug, Clone, PartialEq)]
pub struct TriggerSettings {
    /// Index of the channel.
    pub channel: usize,
    /// Its name.
    pub id: String,
    /// When it is what.
    pub rules: TriggerRules,
    /// The line that follows it, and when that is active.
    pub output: Option<(OutputLine, When)>,
}

impl ChannelTable {
    /// Its thresholds; `None`: it has no trigger.
    ///
    /// # Errors
    /// One is in no unit of this channel, or is missing where it has no default.
    pub fn levels(&self) -> Option<Result<Thresholds<'_>, NoLevel>> {
        let (keys, on, off, default) = match (&self.on_above, &self.on_below) {
            (Some(on), _) => (["on-above", "off-below"], on, &self.off_below, HYSTERESIS),
            (None, Some(on)) => (["on-below", "off-above"], on, &self.off_above, 1.0 / HYSTERESIS),
            (None, None) => return None,
        };
        let on = match self.level(keys[0], on) {
            Ok(on) => on,
            Err(none) => return Some(Err(none)),
        };
        let off = match off {
            Some(off) => self.level(keys[1], off),
            None if on.is_of_a_ratio() => Ok(Level { value: default * on.value, ..on }),
            None => Err((
                keys[1],
                "missing: only forces and resistances have a default".to_owned(),
                format!("what differs from {} = {on} by more than that wanders", keys[0]),
            )),
        };
        Some(off.map(|off| Thresholds { keys, on, off }))
    }

    fn level(&self, key: &'static str, text: &str) -> Result<Level<'_>, NoLevel> {
        let unit = self.unit();
        Level::read(text, unit).ok_or_else(|| match unit {
            "ohm" => (
                key,
                format!("{text:?} is no resistance, and the channel shows nothing else"),
                "\"5 kohm\", or a force or law for the channel".to_owned(),
            ),
            _ => (
                key,
                format!("{text:?} is neither in {unit}, which the channel shows, nor a resistance"),
                format!("\"2 {unit}\" or \"5 kohm\""),
            ),
        })
    }

    /// What its value is in, as [`sensor::Channel::unit`](crate::sensor::Channel::unit).
    fn unit(&self) -> &str {
        match (&self.force, &self.law) {
            (Some(_), _) => "N",
            (None, Some(LawSource::Given(law))) => law.unit(),
            (None, Some(LawSource::File { unit, .. })) => unit,
            (None, None) => "ohm",
        }
    }
}

impl Config {
    /// The longest time from one reading of a channel to the next, as far as it is planned: every sensor at the deadline.
    pub fn longest_interval(&self, channel: &ChannelTable) -> Nanos {
        let [_, cycle] = self.cycle(Seconds::from(self.deadline()));
        let cycle = Nanos::from_seconds(cycle.0).max(self.period().unwrap_or(Nanos::ZERO));
        let cycles = Nanos(cycle.0.saturating_mul(channel.every.into()));
        // A mean ends with the first reading after its time.
        cycles + self.average().unwrap_or(Nanos::ZERO)
    }

    /// The channels that have a trigger, of a configuration that has passed its check.
    ///
    /// # Errors
    /// An output's chip is not named.
    pub fn triggers(&self) -> Result<Vec<TriggerSettings>, OpenError> {
        let channels = self.channels.iter().enumerate();
        let of = |(index, channel): (usize, &ChannelTable)| {
            let Thresholds { on, off, .. } = channel.levels()?.ok()?;
            let hold = channel.hold.unwrap_or(Nanos::ZERO);
            let planned = Nanos(self.longest_interval(channel).0.saturating_mul(STALE_READINGS));
            let stale = channel.stale.unwrap_or(planned.max(SHORTEST_STALE));
            let rules = TriggerRules { quantity: on.quantity(), on: on.value, off: off.value, hold, stale };
            let output = channel
                .output
                .as_ref()
                .map(|output| self.output_line(output, &channel.id).map(|line| (line, output.when)));
            Some(output.transpose().map(|output| TriggerSettings {
                channel: index,
                id: channel.id.clone(),
                rules,
                output,
            }))
        };
        channels.filter_map(of).collect()
    }

    fn output_line(&self, output: &OutputTable, id: &str) -> Result<OutputLine, OpenError> {
        let chip = output.chip.clone().or_else(|| self.gpio.chip.clone());
        let is_simulated = self.gpio.backend == Backend::Mock;
        let chip = chip.or_else(|| is_simulated.then(|| "simulated".to_owned()));
        Ok(OutputLine {
            chip: chip.ok_or_else(|| OpenError::Missing(format!("channel.{id}.output.chip")))?,
            line: output.line.0.clone(),
            active_low: output.active_low,
            consumer: CONSUMER.to_owned(),
        })
    }
}
