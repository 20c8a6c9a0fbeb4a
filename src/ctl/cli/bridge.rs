//! The arguments of what runs on its own: the bridges and the page.

use super::{Connection, number_of};
use crate::units::Seconds;
use clap::{Args, Subcommand};
use std::net::{Ipv6Addr, SocketAddr};
use std::path::PathBuf;

/// `cermctl bridge`.
#[derive(Debug, Args)]
pub struct Bridge {
    /// To which system.
    #[command(subcommand)]
    pub to: BridgeTo,
}

/// What `cermctl bridge` can talk to.
#[derive(Debug, Subcommand)]
pub enum BridgeTo {
    /// Serve a page of metrics for Prometheus, as text and as OpenMetrics
    Prometheus(Prometheus),
    /// Publish on an MQTT broker what changes beyond its uncertainty; Home Assistant shows it without being configured
    Mqtt(Mqtt),
    /// Serve the channels as an IIO device: for iio_info, iio_attr, iio_readdev and whatever else speaks with iiod
    Iio(Iio),
}

/// What is told of.
#[derive(Debug, Args)]
pub struct Feeding {
    /// A reading that is older is told no more: the channel is then of unknown state
    #[arg(long, value_name = "DURATION", default_value = "10 s", value_parser = duration)]
    pub stale: Seconds,
    #[command(flatten)]
    pub connection: Connection,
}

/// What browsers and scrapers ask.
#[derive(Debug, Args)]
pub struct Page {
    /// Also answer under this host name; addresses, localhost and the name of this machine need no mention
    #[arg(long = "host", value_name = "NAME")]
    pub hosts: Vec<String>,
}

/// `cermctl bridge prometheus`.
#[derive(Debug, Args)]
pub struct Prometheus {
    /// Where to listen; the page is /metrics. For other machines: 0.0.0.0:9839
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:9839", value_parser = address)]
    pub listen: SocketAddr,
    #[command(flatten)]
    pub page: Page,
    #[command(flatten)]
    pub feeding: Feeding,
}

/// `cermctl bridge iio`.
#[derive(Debug, Args)]
pub struct Iio {
    /// Where to listen, for iio_info -u ip:127.0.0.1. For other machines: 0.0.0.0:30431
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:30431", value_parser = address)]
    pub listen: SocketAddr,
    #[command(flatten)]
    pub feeding: Feeding,
}

/// `cermctl web`.
#[derive(Debug, Args)]
pub struct Web {
    /// Where to listen. For other machines: 0.0.0.0:8390
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:8390", value_parser = address)]
    pub listen: SocketAddr,
    #[command(flatten)]
    pub page: Page,
    #[command(flatten)]
    pub feeding: Feeding,
}

/// `cermctl bridge mqtt`.
#[derive(Debug, Args)]
pub struct Mqtt {
    /// Name or address of the broker
    #[arg(long, value_name = "HOST", value_parser = host)]
    pub broker: String,
    /// Its port [default: 1883, with TLS 8883]
    #[arg(long, value_name = "NUMBER")]
    pub port: Option<u16>,
    /// Encrypt, and believe brokers that the authorities of this machine vouch for: /etc/ssl/certs/ca-certificates.crt
    #[arg(long)]
    pub tls: bool,
    /// The same with the certificate authorities in this file (PEM), and no others
    #[arg(long, value_name = "FILE")]
    pub ca: Option<PathBuf>,
    /// Log in as this user
    #[arg(long, value_name = "NAME", requires = "password_file")]
    pub user: Option<String>,
    /// A file whose first line is the password; nobody else should be able to read it
    #[arg(long, value_name = "FILE", requires = "user")]
    pub password_file: Option<PathBuf>,
    /// What this board is called on the broker, where no other may have the same name: letters, digits, - and _
    /// [default: the name of this machine]
    #[arg(long, value_name = "NAME", value_parser = board_id)]
    pub id: Option<String>,
    /// The first level of the topics on which Home Assistant listens for new devices
    #[arg(long, value_name = "TOPIC", default_value = "homeassistant", value_parser = level)]
    pub discovery: String,
    /// Announce nothing to Home Assistant
    #[arg(long, conflicts_with = "discovery")]
    pub no_discovery: bool,
    /// Tell a resistance that has changed by so many of its standard uncertainties; at 3, noise alone tells one reading
    /// in 30
    #[arg(long, value_name = "NUMBER", default_value = "3", value_parser = number_of("uncertainties above 0, such as 3"))]
    pub change: f64,
    /// Tell every channel at least so often
    #[arg(long, value_name = "DURATION", default_value = "10 s", value_parser = duration)]
    pub every: Seconds,
    /// Tell a channel whose state stays at most so often
    #[arg(long, value_name = "DURATION", default_value = "200 ms", value_parser = duration)]
    pub at_most_every: Seconds,
    #[command(flatten)]
    pub feeding: Feeding,
}

fn address(text: &str) -> Result<SocketAddr, String> {
    text.parse().map_err(|_| "an address and a port, such as 127.0.0.1:8390 or [::1]:8390".to_owned())
}

/// A name or an address. What is none would be asked for without end, as a broker is that does not answer yet.
fn host(text: &str) -> Result<String, String> {
    let address = text.split('%').next().unwrap_or(text);
    let is_fit = !text.is_empty()
        && !text.contains(|c: char| c.is_whitespace() || c == '/')
        && (!text.contains(':') || address.parse::<Ipv6Addr>().is_ok());
    let wanted = "a name or an address alone, such as 192.168.1.10; a port goes to --port";
    is_fit.then(|| text.to_owned()).ok_or_else(|| wanted.to_owned())
}

fn board_id(text: &str) -> Result<String, String> {
    let is_fit = (1..=64).contains(&text.len())
        && text.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"-_".contains(&byte));
    if is_fit { Ok(text.to_owned()) } else { Err("up to 64 letters, digits, - and _".to_owned()) }
}

fn level(text: &str) -> Result<String, String> {
    let is_fit = !text.is_empty() && text.len() <= 256 && !text.contains(['+', '#', '\0']);
    if is_fit {
        Ok(text.to_owned())
    } else {
        Err("a topic without + and #, such as homeassistant".to_owned())
    }
}

/// At least so long that a daemon with a slow channel is not called silent by mistake, and no longer than a day.
fn duration(text: &str) -> Result<Seconds, String> {
    let duration: Seconds =
        text.parse().map_err(|error: crate::units::ParseQuantityError| error.to_string())?;
    if (0.01..=86_400.0).contains(&duration.0) {
        Ok(duration)
    } else {
        Err("a duration from 10 ms to 86400 s, such as \"10 s\"".to_owned())
    }
}
