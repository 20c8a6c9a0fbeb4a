//! EVENT: a channel has passed a threshold, or nothing is known of it any more.

use serde::{Deserialize, Serialize};

/// EVENT.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "class", rename = "EVENT")]
pub struct EventLine {
    /// The id of the channel.
    pub channel: String,
    /// What it is now.
    pub event: EventName,
    /// Released without being so: why nothing is known any more, "fault" or "stale"; a text, because later releases may know
    /// more. Absent: a reading says so.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// When that reading was taken; with a reason, when it was noticed. RFC 3339, UTC.
    pub time: String,
    /// The same on `CLOCK_MONOTONIC`, ns.
    pub t_mono_ns: i64,
}

/// What a channel with a trigger is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EventName {
    /// Beyond its threshold.
    Pressed,
    /// Not, or not known to be: then there is a reason.
    Released,
}

impl EventLine {
    /// Whether the channel is pressed; `None`: not known.
    pub fn is_pressed(&self) -> Option<bool> {
        match (self.event, &self.reason) {
            (_, Some(_)) => None,
            (event, None) => Some(event == EventName::Pressed),
        }
    }
}
