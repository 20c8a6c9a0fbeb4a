//! `cermctl bridge` and `cermctl web`: the bridges, each until Ctrl-C.

use super::CtlError;
use super::interrupt::Interrupt;
use crate::bridge::mqtt::{self, Broker, Login};
use crate::bridge::{Upstream, iio, prometheus, web};
use crate::ctl::{cli, log};
use std::time::Duration;

/// Runs one of them.
pub fn run(to: cli::BridgeTo) -> Result<(), CtlError> {
    let interrupt = Interrupt::new()?;
    log::start();
    let wish = || interrupt.is_set();
    match to {
        cli::BridgeTo::Prometheus(cli::Prometheus { listen, page, feeding }) => {
            Ok(prometheus::run(source(feeding), listen, &page.hosts, &wish)?)
        }
        cli::BridgeTo::Iio(cli::Iio { listen, feeding }) => Ok(iio::run(source(feeding), listen, &wish)?),
        cli::BridgeTo::Mqtt(arguments) => {
            let (broker, options) = (broker(&arguments), options(&arguments));
            Ok(mqtt::run(source(arguments.feeding), broker, options, &wish)?)
        }
    }
}

/// `cermctl web`.
pub fn web(arguments: cli::Web) -> Result<(), CtlError> {
    let cli::Web { listen, page, feeding } = arguments;
    let interrupt = Interrupt::new()?;
    log::start();
    Ok(web::run(source(feeding), listen, &page.hosts, &|| interrupt.is_set())?)
}

/// Where Debian and its relatives keep the authorities that a machine believes.
const AUTHORITIES: &str = "/etc/ssl/certs/ca-certificates.crt";

fn broker(arguments: &cli::Mqtt) -> Broker {
    let ca = arguments.ca.clone().or_else(|| arguments.tls.then(|| AUTHORITIES.into()));
    let login = arguments.user.clone().zip(arguments.password_file.clone());
    Broker {
        host: arguments.broker.clone(),
        port: arguments.port.unwrap_or(if ca.is_some() { 8883 } else { 1883 }),
        ca,
        login: login.map(|(user, password_file)| Login { user, password_file }),
    }
}

fn options(arguments: &cli::Mqtt) -> mqtt::Options {
    mqtt::Options {
        id: arguments.id.clone().unwrap_or_else(host_id),
        discovery: (!arguments.no_discovery).then(|| arguments.discovery.clone()),
        change: arguments.change,
        every: Duration::from_secs_f64(arguments.every.0),
        at_least: Duration::from_secs_f64(arguments.at_most_every.0),
    }
}

/// The name of this machine, as far as a topic may have it.
fn host_id() -> String {
    let name = nix::unistd::gethostname().unwrap_or_default();
    let fit = |c: char| if c.is_ascii_alphanumeric() || c == '-' || c == '_' { c } else { '-' };
    let id: String = name.to_string_lossy().chars().take(64).map(fit).collect();
    if id.is_empty() { "cermd".to_owned() } else { id }
}

fn source(feeding: cli::Feeding) -> Upstream {
    let patience = Duration::from_secs_f64(feeding.stale.0);
    Upstream { socket: feeding.connection.socket, patience }
}
