//! The part of `cermctl check` that touches hardware: the kernel, the rights, the lines, the circuit, the latencies.

use super::{latency, wiring};
use crate::config::backend::{self, CONSUMER, OpenError};
use crate::config::{Backend, Config, Finding};
use crate::ctl::CtlError;
use crate::ctl::stream::Stream;
use crate::pins::realtime::{Realtime, Right};
use crate::pins::{Pins, PinsError};

/// The first kernel with GPIO uAPI v2.
const FIRST_V2: (u32, u32) = (5, 10);

/// Adds what there is to say of the hardware that a configuration names; answers the latencies, as text.
pub fn check(config: &Config, findings: &mut Vec<Finding>) -> String {
    if config.gpio.backend == Backend::Mock {
        return String::new();
    }
    findings.push(kernel(config.gpio.backend));
    let realtime = Realtime::request(&config.realtime);
    match backend::open(config, crate::pins::monotonic()) {
        Ok(mut pins) => {
            findings.extend(rights(&realtime));
            findings.push(Finding::info("gpio", "the chip is there, and every line can be had"));
            let spots = pins.particulars().blind_spots.to_vec();
            findings.extend(spots.into_iter().map(|spot| Finding::info("gpio.backend", spot)));
            measure(&mut *pins, config, findings).unwrap_or_else(|failed| {
                findings.push(Finding::error("gpio", failed.to_string()));
                String::new()
            })
        }
        Err(refusal) if is_held_by_cermd(&refusal) => {
            findings.push(ask_the_daemon(config).unwrap_or_else(|silence| {
                Finding::error("gpio", format!("{refusal}; and at its socket: {silence}"))
                    .try_this("`systemctl stop cermd`, then this again")
            }));
            String::new()
        }
        Err(refusal) => {
            findings.push(Finding::error("gpio", refusal.to_string()));
            String::new()
        }
    }
}

fn measure(pins: &mut dyn Pins, config: &Config, findings: &mut Vec<Finding>) -> Result<String, PinsError> {
    findings.extend(wiring::test(pins, config)?);
    let (wake_ups, stamps) = (latency::wake_ups(), latency::stamps(pins, config)?);
    Ok(format!(
        "\nHow late a sleep of 1 ms ends:\n{wake_ups}How late equal crossings are stamped, after the earliest of them:\n{stamps}"
    ))
}

fn kernel(backend: Backend) -> Finding {
    let release = nix::sys::utsname::uname().map(|name| name.release().to_string_lossy().into_owned());
    let release = release.unwrap_or_default();
    let has_v2 = version(&release).is_none_or(|version| version >= FIRST_V2);
    match (backend, has_v2) {
        (Backend::Chardev, false) => Finding::error(
            "gpio.backend",
            format!("Linux {release} has no GPIO uAPI v2, which came with 5.10"),
        )
        .try_this("backend = \"chardev-v1\", or a newer kernel"),
        (Backend::ChardevV1, true) => Finding::warning(
            "gpio.backend",
            format!("Linux {release} has GPIO uAPI v2, which notices more than v1"),
        )
        .try_this("backend = \"chardev\""),
        (_, true) => Finding::info("kernel", format!("Linux {release}, GPIO uAPI v2")),
        (_, false) => Finding::info("kernel", format!("Linux {release}, GPIO uAPI v1")),
    }
}

/// The first two numbers of a release: `6.12.34+rpt-rpi-2712`.
fn version(release: &str) -> Option<(u32, u32)> {
    let mut numbers = release.split(|c: char| !c.is_ascii_digit()).map(str::parse);
    Some((numbers.next()?.ok()?, numbers.next()?.ok()?))
}

fn rights(realtime: &Realtime) -> Vec<Finding> {
    let finding = |(key, outcome): (&str, Right)| match outcome {
        Right::NotAsked => None,
        Right::Granted => {
            Some(Finding::info(format!("realtime.{key}"), "granted to this program as this user"))
        }
        Right::Denied(why) => Some(
            Finding::warning(
                format!("realtime.{key}"),
                format!("denied to this program as this user: {why}"),
            )
            .try_this("cermd's own log, or `cermctl stats`: its unit grants more"),
        ),
    };
    realtime.rights.clone().into_iter().filter_map(finding).collect()
}

fn is_held_by_cermd(refusal: &OpenError) -> bool {
    matches!(refusal, OpenError::Hardware(error) if error.is_held_by(CONSUMER))
}

/// The daemon holds the lines: it tells how it fares.
fn ask_the_daemon(config: &Config) -> Result<Finding, CtlError> {
    let (_, stats) = Stream::connect(&config.server.socket, &[])?.stats()?;
    let readings = stats.instrument.readings;
    let faults: u64 = stats.instrument.faults.values().sum();
    let reason = format!(
        "cermd holds the lines and measures: {readings} readings, {faults} of them faults; the circuit was not tested"
    );
    Ok(Finding::info("gpio", reason)
        .try_this("`cermctl stats` for more, or `systemctl stop cermd`, then this again"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn releases_of_kernels_are_read() {
        assert_eq!(version("6.12.34+rpt-rpi-2712"), Some((6, 12)));
        assert_eq!(version("5.4.0-150-generic"), Some((5, 4)));
        assert_eq!(version("7.2-rc1"), Some((7, 2)));
        assert_eq!(version("unknown"), None);
        assert!(version("5.9.16").unwrap() < FIRST_V2 && version("5.10.1").unwrap() >= FIRST_V2);
    }

    #[test]
    fn a_simulated_circuit_has_no_hardware() {
        let config = Config::parse(include_str!("../../../hw/cermd.toml"), "test").unwrap();
        let mut findings = Vec::new();
        let mock = Config { gpio: crate::config::Gpio::default(), ..config.clone() };
        assert_eq!(check(&mock, &mut findings), "");
        assert!(findings.is_empty());
        let missing = Config {
            gpio: crate::config::Gpio { chip: Some("no-such-chip".into()), ..config.gpio.clone() },
            ..config
        };
        assert_eq!(check(&missing, &mut findings), "");
        assert!(
            findings.last().unwrap().to_string().starts_with("error: gpio: there is no GPIO chip"),
            "{findings:?}"
        );
    }
}
