//! The part of `cermctl check` that touches hardware: the kernel, the rights, the lines, the circuit, the latencies.

use super::{expect, latency, processor, wiring};
use crate::config::backend::{self, CONSUMER, OpenError};
use crate::config::{Backend, Config, Findings, Severity};
use crate::ctl::CtlError;
use crate::ctl::limits::DISCHARGES;
use crate::ctl::stream::Stream;
use crate::estimate::scatter::Usual;
use crate::pins::output::Output;
use crate::pins::realtime::{Realtime, Right};
use crate::pins::{Pins, PinsError};
use crate::units::{Nanos, Seconds};

/// The first kernel with GPIO uAPI v2.
const FIRST_V2: (u32, u32) = (5, 10);

/// What trying the hardware out has shown.
#[derive(Debug, Default, PartialEq)]
pub struct Tried {
    /// The latencies, as text.
    pub latencies: String,
    /// The processor time that a discharge took; `None`: the hardware was not tried.
    pub busy: Option<Nanos>,
}

/// Adds what there is to say of the hardware that a configuration names.
pub fn check(config: &Config, findings: &mut Findings) -> Tried {
    if config.gpio.backend == Backend::Mock {
        return Tried::default();
    }
    kernel(config.gpio.backend, findings);
    let realtime = Realtime::request(&config.realtime);
    match backend::open(config, crate::pins::monotonic()) {
        Ok(mut pins) => {
            rights(&realtime, findings);
            findings.info("gpio", "the chip is there, and every line can be had");
            outputs(config, findings);
            for spot in pins.particulars().blind_spots {
                findings.info("gpio.backend", spot);
            }
            return measure(&mut *pins, config, findings).unwrap_or_else(|failed| {
                findings.add(Severity::Error, "gpio", failed, None);
                Tried::default()
            });
        }
        Err(OpenError::Hardware(error)) if error.is_held_by(CONSUMER) => match ask_the_daemon(config) {
            Ok(reason) => {
                let remedy = "`cermctl stats` for more, or `systemctl stop cermd`, then this again";
                findings.add(Severity::Info, "gpio", reason, Some(remedy));
            }
            Err(silence) => {
                let reason = format!("{error}; and at its socket: {silence}");
                findings.error("gpio", reason, "`systemctl stop cermd`, then this again");
            }
        },
        Err(refusal) => findings.add(Severity::Error, "gpio", refusal, None),
    }
    Tried::default()
}

/// Takes each output, inactive, and lets go of it.
fn outputs(config: &Config, findings: &mut Findings) {
    let way = backend::way(config.gpio.backend);
    for trigger in config.triggers().into_iter().flatten() {
        let Some((line, _)) = trigger.output else { continue };
        let key = format!("channel.{}.output", trigger.id);
        match Output::open(&line, way) {
            Ok(_) => findings.info(key, format!("{} can be had, and was inactive for a moment", line.line)),
            Err(refusal) => findings.add(Severity::Error, key, refusal, None),
        }
    }
}

fn measure(pins: &mut dyn Pins, config: &Config, findings: &mut Findings) -> Result<Tried, PinsError> {
    wiring::test(pins, config, findings)?;
    let wake_ups = latency::histogram(&latency::wake_ups());
    let before = processor::time();
    let mut late_us = latency::stamps(pins, config)?;
    let busy = Nanos((processor::time() - before).0 / DISCHARGES as i64);
    let stamps = latency::histogram(&late_us);
    let jitter_s = 1e-6 * Usual::of(&mut late_us).sigma();
    if let Ok(settings) = config.settings() {
        expect::readings(config, &settings, Some(Seconds(jitter_s)), findings);
    }
    let latencies = format!(
        "\nHow late a sleep of 1 ms ends:\n{wake_ups}How late equal crossings are stamped, after the earliest of them:\n{stamps}"
    );
    Ok(Tried { latencies, busy: Some(busy) })
}

fn kernel(backend: Backend, findings: &mut Findings) {
    let (release, version) = crate::pins::kernel();
    let has_v2 = version.is_none_or(|version| version >= FIRST_V2);
    match (backend, has_v2) {
        (Backend::Chardev, false) => findings.error(
            "gpio.backend",
            format!("Linux {release} has no GPIO uAPI v2, which came with 5.10"),
            "backend = \"chardev-v1\", or a newer kernel",
        ),
        (Backend::ChardevV1, true) => findings.warning(
            "gpio.backend",
            format!("Linux {release} has GPIO uAPI v2, which notices more than v1"),
            "backend = \"chardev\"",
        ),
        (_, true) => findings.info("kernel", format!("Linux {release}, GPIO uAPI v2")),
        (_, false) => findings.info("kernel", format!("Linux {release}, GPIO uAPI v1")),
    }
}

fn rights(realtime: &Realtime, findings: &mut Findings) {
    for (name, outcome) in &realtime.rights {
        let key = format!("realtime.{name}");
        match outcome {
            Right::NotAsked => {}
            Right::Granted => findings.info(key, "granted to this program as this user"),
            Right::Denied(why) => findings.warning(
                key,
                format!("denied to this program as this user: {why}"),
                "cermd's own log, or `cermctl stats`: its unit grants more",
            ),
        }
    }
}

/// The daemon holds the lines: it tells how it fares.
fn ask_the_daemon(config: &Config) -> Result<String, CtlError> {
    let (_, stats) = Stream::connect(&config.server.socket, &[])?.stats()?;
    let readings = stats.instrument.readings;
    let faults: u64 = stats.instrument.faults.values().sum();
    Ok(format!(
        "cermd holds the lines and measures: {readings} readings, {faults} of them faults; the circuit was not tested"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_simulated_circuit_has_no_hardware() {
        let config = Config::parse(include_str!("../../../hw/cermd.toml"), "test").unwrap();
        let mut findings = Findings::default();
        let mock = Config { gpio: crate::config::Gpio::default(), ..config.clone() };
        assert_eq!(check(&mock, &mut findings), Tried::default());
        assert!(findings.0.is_empty());
        let missing = Config {
            gpio: crate::config::Gpio { chip: Some("no-such-chip".into()), ..config.gpio.clone() },
            ..config
        };
        assert_eq!(check(&missing, &mut findings), Tried::default());
        assert!(
            findings.0.last().unwrap().to_string().starts_with("error: gpio: there is no GPIO chip"),
            "{findings:?}"
        );
    }
}
