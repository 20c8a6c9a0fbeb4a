//! What the daemon tells: results to the server, and itself to the log and the service manager.
//!
//! For: putting the instrument's results into the words of the stream. Must not know: threads, descriptors.

use super::Loaded;
use super::measuring::Report;
use crate::config::{Backend, Config};
use crate::instrument::Message;
use crate::instrument::diagnosis::LEAKS;
use crate::instrument::settings::Settings;
use crate::instrument::stats::Stats;
use crate::pins::realtime::{self, Right};
use crate::reading::Suspect;
use crate::reading::{Fault, Reading, Status};
use crate::stream::server::Server;
use crate::stream::wire::{ChannelInfo, Object, Unit, UnixTime};
use crate::units::{Nanos, Ohm};

/// The channels as VERSION announces them.
pub fn channels(settings: &Settings) -> Vec<ChannelInfo> {
    let info = |channel: &crate::instrument::settings::Channel| ChannelInfo {
        id: channel.id.clone(),
        unit: if channel.force.is_some() { Unit::Newton } else { Unit::Ohm },
    };
    settings.channels.iter().map(info).collect()
}

/// The header of a tape, as a line; `found`: the latency offset that a calibration has found, ns.
pub fn header(config: &Config, settings: &Settings, found: Option<f64>) -> String {
    let mut header = config.tape_header(settings);
    header.offset_ns = header.offset_ns.or(found);
    header.to_line() + "\n"
}

/// What the measuring thread has told about itself.
#[derive(Debug, Default)]
pub struct Told {
    /// Its counters.
    pub stats: Stats,
    /// What became of the wishes of `[realtime]`; `None` before its first word.
    pub realtime: Option<realtime::Rights>,
    /// The GPIO lines cannot be used, and are tried again.
    pub is_away: bool,
    /// What the log has about the board.
    board: Board,
}

/// A suspect that has not shown for so long is gone.
const GONE_AFTER: Nanos = Nanos(10_000_000_000);

/// What was said about the board, so that it is said once and not with each reading.
#[derive(Debug, Default)]
struct Board {
    suspect: Option<Suspect>,
    seen: Nanos,
    leaks: bool,
}

impl Board {
    fn reading(&mut self, reading: &Reading) {
        if let (Some(suspect), Status::Fault(fault)) = (reading.suspect, reading.status) {
            self.seen = reading.at;
            if self.suspect != Some(suspect) {
                self.suspect = Some(suspect);
                log::warn!("{fault}: {suspect}");
            }
        } else if self.suspect.is_some() && reading.at - self.seen > GONE_AFTER {
            self.suspect = None;
            log::info!("nothing is wrong with the board any more");
        }
    }

    fn stats(&mut self, stats: &Stats) {
        if let (Some(siemens), false) = (stats.leak_siemens, self.leaks) {
            self.leaks = true;
            log::warn!(
                "a leak of about {:.2}: readings are less certain by what it does to them; look for {LEAKS}",
                Ohm(1.0 / siemens)
            );
        }
    }
}

/// Passes one result on. `to_wall`: from `CLOCK_MONOTONIC` to `CLOCK_REALTIME`.
pub fn report(server: &mut Server, told: &mut Told, loaded: &Loaded, report: Report, to_wall: Nanos) {
    match report {
        Report::Message(Message::Reading(reading)) => {
            told.board.reading(&reading);
            server.publish_reading(&reading, UnixTime((reading.at + to_wall).0));
        }
        Report::Message(Message::Discharge { seq, record }) => {
            if server.wants_raw() {
                let line = loaded.config.tape_header(&loaded.settings).discharge_line(seq, &record) + "\n";
                server.publish_raw(record.through.channel(), record.start, &line);
            }
        }
        Report::Stats(counted) => {
            told.board.stats(&counted);
            told.stats = counted;
        }
        Report::Realtime(report) => {
            log_realtime(&report);
            told.realtime = Some(report);
        }
        Report::Failed(error) => {
            told.is_away = true;
            log::error!("{error}; trying again every second");
        }
        Report::NotOpened(error) => {
            told.is_away = true;
            log::warn!("{error}");
        }
        Report::Recovered => {
            told.is_away = false;
            log::info!("the GPIO lines work again");
        }
    }
}

/// The daemon's own fields of STATS.
pub fn stats(told: &Told, config: &Config, uptime: Nanos) -> impl FnMut(&mut Object<'_>) {
    let Told { stats, realtime, is_away, .. } = told;
    let backend = match config.gpio.backend {
        Backend::Chardev => "chardev",
        Backend::ChardevV1 => "chardev-v1",
        Backend::Mock => "mock",
    };
    let method = config.method().as_str();
    move |object| {
        object.text("backend", backend);
        object.text("method", method);
        object.flag("gpio_works", !is_away);
        object.number("uptime_s", uptime.as_seconds(), 9);
        object.integer("cycles", stats.cycles);
        object.integer("readings", stats.readings);
        object.integer("ok", stats.ok);
        object.integer("open", stats.open);
        object.integer("short", stats.short);
        object.object("faults", |object| {
            for fault in Fault::ALL {
                object.integer(fault.as_str(), stats.faults[fault as usize]);
            }
        });
        if let Some(suspect) = stats.suspect {
            object.text("hint", suspect.as_str());
        }
        object.number("leak_ohm", stats.leak_siemens.map(|siemens| 1.0 / siemens), 3);
        object.integer("retried", stats.retried);
        object.flag("offset_known", stats.offset_is_known);
        if stats.offset_is_known {
            object.number("offset_ns", stats.offset.d_ns, 7);
            object.number("offset_u_ns", stats.offset.u_d_ns, 3);
            object.number("r_o_ohm", stats.offset.r_o_ohm.map(|r_o| r_o.0), 5);
            object.number("r_o_u_ohm", stats.offset.r_o_ohm.map(|r_o| r_o.1), 3);
        }
        if let Some(margin) = stats.spin_margin {
            object.integer("spin_margin_ns", margin.0.unsigned_abs());
        }
        object.integer("blind_spots", stats.blind_spots as u64);
        object.object("realtime", |object| {
            for (key, outcome) in realtime.iter().flatten() {
                object.text(key, &outcome.to_string());
            }
        });
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

/// One line for `systemctl status`.
pub fn status_line(stats: &Stats, clients: usize) -> String {
    let faults: u64 = stats.faults.iter().sum();
    format!("{} readings, {} faults, {} clients", stats.readings, faults, clients)
}
