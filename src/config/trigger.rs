//! The trigger of a channel: `on-above = "2 N"`, `off-below = "1.5 N"`, or downwards `on-below`, `off-above`; `hold`, `stale`, and
//! the line that follows it, `output = { line = "GPIO17" }`.

use super::backend::{CONSUMER, OpenError};
use super::limits::{HYSTERESIS, SHORTEST_STALE, STALE_READINGS};
use super::{Backend, ChannelTable, Config, LineName};
use crate::pins::output::OutputLine;
use crate::trigger::{Quantity, Rules, State};
use crate::units::{Nanos, Newton, Ohm, Seconds, named};
use serde::{Deserialize, Serialize};
use std::fmt;

/// A threshold: a force, or a resistance.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "String")]
pub struct Level {
    /// What is compared.
    pub quantity: Quantity,
    /// In its unit.
    pub value: f64,
}

impl TryFrom<String> for Level {
    type Error = String;

    fn try_from(text: String) -> Result<Level, String> {
        let force = text.parse().map(|Newton(value)| Level { quantity: Quantity::Force, value });
        let resistance = || text.parse().map(|Ohm(value)| Level { quantity: Quantity::Resistance, value });
        force.or_else(|_| resistance()).map_err(|_| {
            format!("expected a force such as \"2 N\" or a resistance such as \"5 kohm\", got {text:?}")
        })
    }
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.quantity {
            Quantity::Force => Newton(self.value).fmt(f),
            Quantity::Resistance => Ohm(self.value).fmt(f),
        }
    }
}

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
    pub rules: Rules,
    /// The line that follows it, and when that is active.
    pub output: Option<(OutputLine, When)>,
}

impl ChannelTable {
    /// Where the channel becomes pressed, and released, with the names of their keys; `None`: it has no trigger.
    pub fn levels(&self) -> Option<([&'static str; 2], Level, Level)> {
        let (keys, on, off, default) = match (self.on_above, self.on_below) {
            (Some(on), _) => (["on-above", "off-below"], on, self.off_below, HYSTERESIS),
            (None, Some(on)) => (["on-below", "off-above"], on, self.off_above, 1.0 / HYSTERESIS),
            (None, None) => return None,
        };
        Some((keys, on, off.unwrap_or(Level { value: default * on.value, ..on })))
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
            let (_, on, off) = channel.levels()?;
            let hold = channel.hold.unwrap_or(Nanos::ZERO);
            let planned = Nanos(STALE_READINGS * self.longest_interval(channel).0);
            let stale = channel.stale.unwrap_or(planned.max(SHORTEST_STALE));
            let rules = Rules { quantity: on.quantity, on: on.value, off: off.value, hold, stale };
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
