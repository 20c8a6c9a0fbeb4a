//! What one client wants of the stream: the filters of WATCH.

use super::hub::Content;
use crate::stream::wire::Watch;
use crate::units::Nanos;

/// What one client wants. A new client wants every reading.
#[derive(Debug, Default)]
pub(super) struct Subscription {
    pub watch: Watch,
    limit: Option<RateLimit>,
}

impl Subscription {
    pub fn new(watch: Watch) -> Subscription {
        Subscription { limit: watch.max_hz.map(RateLimit::new), watch }
    }

    /// Whether lines of this kind are a part of the stream at all.
    pub fn is_of(&self, content: &Content) -> bool {
        match content {
            Content::Version => true,
            Content::Reading(_) | Content::Event(_) => self.watch.enable && !self.watch.raw,
            Content::Tape | Content::Discharge(_) => self.watch.enable && self.watch.raw,
            Content::Lost { .. } => self.watch.enable,
        }
    }

    /// How many of what this client watches never came to the server.
    pub fn missed(&self, content: &Content) -> u64 {
        match *content {
            Content::Lost { readings, discharges } if self.watch.enable => {
                if self.watch.raw {
                    discharges
                } else {
                    readings
                }
            }
            _ => 0,
        }
    }

    /// Whether this line is wanted. To be asked once for each line, in their order: a wanted one counts
    /// against the rate.
    pub fn wants(&mut self, content: &Content) -> bool {
        match content {
            _ if !self.is_of(content) => false,
            Content::Version | Content::Tape | Content::Lost { .. } => true,
            Content::Discharge(None) => true,
            // No rate: each of them is a state of its own.
            Content::Discharge(Some(channel)) | Content::Event(channel) => self.wants_channel(channel),
            Content::Reading(reading) => {
                let (channel, at) = (&reading.channel, Nanos(reading.t_mono_ns));
                self.wants_channel(channel)
                    && self.limit.as_mut().is_none_or(|limit| limit.passes(channel, at))
            }
        }
    }

    fn wants_channel(&self, channel: &str) -> bool {
        self.watch.channels.as_ref().is_none_or(|wanted| wanted.iter().any(|id| id == channel))
    }
}

/// Thins the readings of each channel to a rate, by the instants at which they were measured.
#[derive(Debug)]
struct RateLimit {
    period: Nanos,
    /// From when on the next reading of a channel passes.
    due: Vec<(String, Nanos)>,
}

impl RateLimit {
    fn new(max_hz: f64) -> RateLimit {
        RateLimit { period: Nanos::from_seconds(1.0 / max_hz), due: Vec::new() }
    }

    /// Each passing reading moves the due instant on by at least one period, so the mean rate stays below
    /// `max_hz`; by the grid and not by the last reading, so that jitter of the readings does not turn "at most
    /// 10 Hz" into "every third of 20 Hz".
    fn passes(&mut self, channel: &str, at: Nanos) -> bool {
        let Some((_, due)) = self.due.iter_mut().find(|(id, _)| id == channel) else {
            self.due.push((channel.to_owned(), at + self.period));
            return true;
        };
        // `due` is never more than a period ahead, unless the clock was set back by a restarted simulation.
        let waiting = *due - at;
        if waiting > self.period {
            *due = at;
        } else if waiting > Nanos::ZERO {
            return false;
        }
        let half_a_period_on = at + Nanos(self.period.0 / 2);
        *due = (*due + self.period).max(half_a_period_on);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const THUMB: &str = "thumb";
    const INDEX: &str = "index";

    fn reading(channel: &str) -> Content {
        let line = format!(
            r#"{{"class":"READING","channel":"{channel}","seq":1,"time":"","t_mono_ns":0,"status":"open","lost":0}}"#
        );
        Content::Reading(Box::new(serde_json::from_str(&line).unwrap()))
    }

    fn discharge(channel: Option<&str>) -> Content {
        Content::Discharge(channel.map(str::to_owned))
    }

    fn passed(max_hz: f64, instants: impl IntoIterator<Item = i64>) -> Vec<i64> {
        let mut limit = RateLimit::new(max_hz);
        instants.into_iter().filter(|&at| limit.passes(THUMB, Nanos(at))).collect()
    }

    #[test]
    fn filters() {
        let mut all = Subscription::default();
        let of_thumb = Watch { channels: Some(vec![THUMB.to_owned()]), ..Watch::default() };
        let mut thumb = Subscription::new(of_thumb.clone());
        let mut raw_thumb = Subscription::new(Watch { raw: true, ..of_thumb });
        let mut none = Subscription::new(Watch { enable: false, ..Watch::default() });
        let mut wanted_by = |content: Content| {
            [all.wants(&content), thumb.wants(&content), raw_thumb.wants(&content), none.wants(&content)]
        };
        assert_eq!(wanted_by(reading(THUMB)), [true, true, false, false]);
        assert_eq!(wanted_by(reading(INDEX)), [true, false, false, false]);
        assert_eq!(wanted_by(discharge(Some(THUMB))), [false, false, true, false]);
        assert_eq!(wanted_by(discharge(Some(INDEX))), [false, false, false, false]);
        assert_eq!(wanted_by(discharge(None)), [false, false, true, false]);
        assert_eq!(wanted_by(Content::Tape), [false, false, true, false]);
        assert_eq!(wanted_by(Content::Version), [true; 4]);
    }

    #[test]
    fn jitter_does_not_lower_the_rate() {
        let jitter = [0, -700_000, 900_000, -100_000, 300_000];
        let instants = (0..200).map(|n| n * 50_000_000 + jitter[n as usize % 5]);
        let count = passed(10.0, instants).len();
        assert!((99..=101).contains(&count), "{count} of 200 readings at 20 Hz passed 10 Hz");
    }

    #[test]
    fn channels_have_their_own_rates() {
        let mut limit = RateLimit::new(1.0);
        assert!(limit.passes(THUMB, Nanos(0)) && limit.passes(INDEX, Nanos(1)));
        assert!(!limit.passes(THUMB, Nanos(2)) && !limit.passes(INDEX, Nanos(3)));
    }

    #[test]
    fn a_clock_that_starts_again_does_not_silence_the_stream() {
        assert_eq!(passed(1.0, [5_000_000_000, 0, 1_000_000_000]), [5_000_000_000, 0, 1_000_000_000]);
    }

    #[test]
    fn extreme_rates() {
        assert_eq!(passed(1e300, 0..5), [0, 1, 2, 3, 4]);
        assert_eq!(passed(1e-300, 0..5), [0]);
    }

    proptest! {
        #![proptest_config(crate::seed::cases(256))]

        #[test]
        fn never_above_the_rate(gaps in prop::collection::vec(0i64..300, 1..300), period in 1i64..200) {
            let mut at = 0;
            let instants: Vec<i64> = gaps.iter().map(|gap| { at += gap; at }).collect();
            let passed = passed(1e9 / period as f64, instants);
            for (first, &from) in passed.iter().enumerate() {
                for (last, &to) in passed.iter().enumerate().skip(first) {
                    // One reading in hand at the start, and half a period of grace against jitter.
                    let most = (to - from) as f64 / period as f64 + 2.0;
                    prop_assert!(((last - first + 1) as f64) <= most + 1e-9, "{from}..{to}: {}", last - first + 1);
                }
            }
        }
    }
}
