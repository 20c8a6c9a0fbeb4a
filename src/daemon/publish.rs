//! What the daemon tells: results to the server in the words of the stream, and itself to the log and the service manager.

use super::Loaded;
use super::limits::GONE_AFTER;
use super::measuring::{Lost, Update};
use super::rounds::Round;
use super::triggering::ChannelEvent;
use crate::config::Config;
use crate::config::backend::OpenError;
use crate::estimate::look::Found;
use crate::instrument::Message;
use crate::instrument::stats::Stats;
use crate::pins::realtime::{self, Right};
use crate::reading::{Fault, Reading, Status, Suspect};
use crate::sensor::Channel;
use crate::stream::server::Server;
use crate::stream::tape::DischargeLine;
use crate::stream::wire::{ChannelInfo, EventLine, EventName, InstrumentStats, Unit};
use crate::trigger::{State, Why};
use crate::units::{Nanos, Ohm};
use jiff::Timestamp;

/// The channels as VERSION announces them.
pub fn channels(loaded: &Loaded) -> Vec<ChannelInfo> {
    let info = |(index, channel): (usize, &Channel)| ChannelInfo {
        id: channel.id.clone(),
        unit: Unit::named(channel.unit()),
        trigger: loaded.triggers.iter().any(|trigger| trigger.channel == index),
    };
    loaded.settings.channels.iter().enumerate().map(info).collect()
}

/// What is known of the measuring thread and its board.
#[derive(Debug, Default)]
pub struct Known {
    /// Its counters.
    pub stats: Stats,
    /// What its looks have found.
    pub found: Found,
    /// What became of the wishes of `[realtime]`; `None` before its first word.
    pub realtime: Option<realtime::Rights>,
    /// Of calibration discharges, as far as it has come.
    round: Round,
    /// Why the GPIO lines cannot be used; they are tried again.
    away: Option<String>,
    /// The suspect that the log has named last, and when a fault pointed to it last: named once, not with each reading.
    suspect: Option<(Suspect, Nanos)>,
    /// Whether the log has named a leak.
    leak: bool,
    /// The same of what capacitors absorb.
    absorbs: bool,
    sleeps: bool,
    unlike: bool,
}

impl Known {
    /// Of a measuring thread that starts with these pins, or without any.
    pub fn of<T>(pins: &Result<T, OpenError>) -> Known {
        Known { away: pins.as_ref().err().map(OpenError::to_string), ..Known::default() }
    }

    /// One line for `systemctl status`: why there are no lines, or this.
    pub fn away_or(&self, otherwise: &str) -> String {
        self.away.as_ref().map_or_else(|| otherwise.to_owned(), |why| format!("waiting: {why}"))
    }

    fn log_suspect(&mut self, reading: &Reading) {
        match (reading.status, reading.suspect, self.suspect) {
            (Status::Fault(fault), Some(suspect), before) => {
                if before.is_none_or(|(before, _)| before != suspect) {
                    log::warn!("{fault}: {suspect}");
                }
                self.suspect = Some((suspect, reading.at));
            }
            // A fault that names no suspect says nothing of the board.
            (Status::Fault(_), None, _) => {}
            (_, _, Some((_, seen))) if reading.at - seen > GONE_AFTER => {
                self.suspect = None;
                log::info!("nothing is wrong with the board any more");
            }
            _ => {}
        }
    }

    fn log_absorption(&mut self, stats: &Stats) {
        if let (Some(share), false) = (stats.absorbed, self.absorbs) {
            self.absorbs = true;
            log::warn!(
                "the capacitors absorb charge: discharges are {:.2} % longer after a rest, and readings less certain by what \
                 that does to them; take film capacitors (PP, PET) or C0G, or a longer charge-time",
                100.0 * share
            );
        }
    }

    fn log_sleep(&mut self, stats: &Stats) {
        if let (Some(late_ns), false) = (stats.late_after_waits_ns, self.sleeps) {
            self.sleeps = true;
            log::warn!(
                "crossings are stamped {:.1} us later after long waits, and readings are less certain by what that does to them: \
                 processors sleep deeply; dma-latency in [realtime] keeps them from it",
                late_ns / 1e3
            );
        }
    }

    fn log_unlike_calls(&mut self, stats: &Stats) {
        if let (Some(longer_ns), false) = (stats.unlike_calls_ns, self.unlike) {
            self.unlike = true;
            log::warn!(
                "calls that switch a line in the middle of a discharge take {:.1} us {} than those that start it: something sleeps \
                 between them, the chip, the way to it or the processor; switched readings may be off by what the line moves {} in \
                 its call, so compare one with a resistor that you know; dma-latency in [realtime] keeps processors awake",
                longer_ns.abs() / 1e3,
                if longer_ns > 0.0 { "longer" } else { "less" },
                if longer_ns > 0.0 { "later" } else { "earlier" },
            );
        }
    }

    fn log_leak(&mut self, stats: &Stats) {
        if let (Some(siemens), false) = (stats.leak_siemens, self.leak) {
            self.leak = true;
            let (what, suspect) = match siemens > 0.0 {
                true => ("a leak", Suspect::Leak),
                false => ("something that feeds node A, as a pull-up does,", Suspect::Pull),
            };
            log::warn!(
                "{what} of about {:.2}: readings are less certain by what it does to them; {}",
                Ohm(1.0 / siemens.abs()),
                suspect.look()
            );
        }
    }
}

/// An instant of `CLOCK_MONOTONIC` on the wall clock as it is set now.
fn time_of(at: Nanos, to_wall: Nanos) -> Timestamp {
    // 64 bits of nanoseconds end in 2262, long before the calendar of jiff does.
    Timestamp::from_nanosecond((at + to_wall).0.into()).unwrap_or_default()
}

/// Tells of a trigger. `to_wall`: as in [`publish`].
pub fn publish_event(server: &mut Server, loaded: &Loaded, told: &ChannelEvent, to_wall: Nanos) {
    let Some(channel) = loaded.settings.channels.get(told.channel) else { return };
    let (event, reason) = match told.event.state {
        State::Pressed => (EventName::Pressed, None),
        State::Released => (EventName::Released, None),
        State::Unknown(Why::Fault) => (EventName::Released, Some("fault")),
        State::Unknown(Why::Stale) => (EventName::Released, Some("stale")),
    };
    server.publish_event(&EventLine {
        channel: channel.id.clone(),
        event,
        reason: reason.map(str::to_owned),
        time: format!("{:.9}", time_of(told.event.at, to_wall)),
        t_mono_ns: told.event.at.0,
    });
}

/// Passes one result on. `to_wall`: from `CLOCK_MONOTONIC` to `CLOCK_REALTIME`.
pub fn publish(server: &mut Server, known: &mut Known, loaded: &Loaded, update: Update, to_wall: Nanos) {
    match update {
        Update::Message(Message::Reading(reading)) => {
            known.log_suspect(&reading);
            if reading.status == Status::Fault(Fault::CalibrationStep) {
                // A state begins anew: no round of before it belongs to that.
                known.round = Round::default();
                server.forget_rounds();
            }
            let time = time_of(reading.at, to_wall);
            server.publish_reading(&reading, time);
        }
        Update::Message(Message::Discharge { seq, record, is_held, as_read_ohm, .. }) => {
            // What was held back is no calibration.
            let round = (!is_held)
                .then(|| known.round.add(&loaded.settings, &loaded.tape_header, (seq, &record)))
                .flatten();
            if let Some(round) = round {
                server.keep_round(&round);
            }
            if server.wants_raw() {
                let line = loaded.tape_header.discharge(seq, &record, is_held);
                let shared_u_ohm = as_read_ohm.and_then(|as_read| as_read.u);
                let as_read_ohm = as_read_ohm.map(|as_read| as_read.value);
                server.publish_discharge(DischargeLine { as_read_ohm, shared_u_ohm, ..line });
            }
        }
        Update::Lost(Lost { readings, discharges }) => server.miss(readings, discharges),
        Update::Found(found) => known.found = found,
        Update::Stats(stats) => {
            known.log_leak(&stats);
            known.log_absorption(&stats);
            known.log_sleep(&stats);
            known.log_unlike_calls(&stats);
            known.stats = stats;
        }
        Update::Realtime(report) => {
            log_realtime(&report);
            known.realtime = Some(report);
        }
        Update::Failed(error) => {
            log::error!("{error}; trying again every second");
            known.away = Some(error.to_string());
        }
        Update::NotOpened(error) => {
            log::warn!("{error}; trying again every second");
            known.away = Some(error.to_string());
        }
        Update::Recovered => {
            known.away = None;
            log::info!("the GPIO lines work again");
        }
    }
}

/// The daemon's own fields of STATS.
pub fn stats(known: &Known, config: &Config, uptime: Nanos) -> InstrumentStats {
    let Known { stats, realtime, away, .. } = known;
    let offset = stats.offset_is_known.then_some(stats.offset);
    let r_o_ohm = offset.and_then(|offset| offset.r_o_ohm);
    let faults = Fault::ALL.map(|fault| (fault.as_str().to_owned(), stats.faults[fault as usize]));
    let wishes = realtime.iter().flatten();
    InstrumentStats {
        backend: config.gpio.backend.to_string(),
        method: config.method().to_string(),
        gpio_works: away.is_none(),
        uptime_s: uptime.as_seconds(),
        cycles: stats.cycles,
        readings: stats.readings,
        ok: stats.ok,
        moving: stats.moving,
        open: stats.open,
        short: stats.short,
        faults: faults.into(),
        hint: stats.suspect.map(|suspect| suspect.to_string()),
        leak_ohm: stats.leak_siemens.filter(|siemens| *siemens > 0.0).map(|siemens| 1.0 / siemens),
        feed_ohm: stats.leak_siemens.filter(|siemens| *siemens < 0.0).map(|siemens| -1.0 / siemens),
        absorbed_percent: stats.absorbed.map(|share| 100.0 * share),
        late_after_waits_ns: stats.late_after_waits_ns,
        unlike_calls_ns: stats.unlike_calls_ns,
        retried: stats.retried,
        offset_known: stats.offset_is_known,
        offset_ns: offset.map(|offset| offset.d_ns),
        offset_u_ns: offset.map(|offset| offset.u_d_ns),
        r_o_ohm: r_o_ohm.map(|(r_o, _)| r_o),
        r_o_u_ohm: r_o_ohm.map(|(_, u_r_o)| u_r_o),
        spin_margin_ns: stats.spin_margin.map(|margin| margin.0.unsigned_abs()),
        lines_renewed: stats.renewed,
        blind_spots: stats.blind_spots as u64,
        realtime: wishes.map(|(key, outcome)| ((*key).to_owned(), outcome.to_string())).collect(),
    }
}

fn log_realtime(report: &realtime::Rights) {
    for (key, outcome) in report {
        match outcome {
            Right::NotAsked => {}
            Right::Granted => log::info!("realtime.{key}: granted"),
            Right::Denied(why) => log::warn!("realtime.{key}: denied: {why}"),
        }
    }
}

/// Says what the split calibration has found.
pub fn log_offset(stats: &Stats) {
    if let Some((r_o, u_r_o)) = stats.offset.r_o_ohm {
        log::info!(
            "latency offset {:.2} us +- {:.2} us, pin resistance {r_o:.1} ohm +- {u_r_o:.1} ohm (1 sigma)",
            stats.offset.d_ns / 1e3,
            stats.offset.u_d_ns / 1e3
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_follow_the_wall_clock_from_before_it_was_set() {
        let (at, not_set, set) =
            (Nanos(5_000_000_000), Nanos(-3_000_000_000), Nanos(1_800_000_000_000_000_000));
        assert_eq!(time_of(at, not_set).to_string(), "1970-01-01T00:00:02Z");
        assert_eq!(time_of(at, set).to_string(), "2027-01-15T08:00:05Z");
        // A clock of nonsense is no panic.
        time_of(Nanos(i64::MAX), Nanos(i64::MAX));
        time_of(Nanos(i64::MIN), Nanos(i64::MIN));
    }
}
