//! From `[gpio]` and `[mock]` to pins: the one place that knows which backends there are.

use crate::circuit::{Circuit, Kind, NOMINAL_R_CHARGE};
use crate::config::{Backend, Config, LineName};
use crate::pins::Pins;
use crate::pins::chardev::{self, Chardev, Wiring};
use crate::pins::chardev_v1;
use crate::pins::output::Way;
use crate::pins::sim::{Scene, SceneError, SimPins};
use crate::units::{Nanos, Ohm};

/// What other programs see as the holder of the lines (gpioinfo).
pub const CONSUMER: &str = "cermd";

/// Pins of any backend.
pub type AnyPins = Box<dyn Pins + Send>;

/// Why there are no pins.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The scene of the simulated circuit is not usable.
    #[error("mock.scene: {0}")]
    Scene(#[from] SceneError),
    /// The configuration names no scene.
    #[error("gpio.backend is \"mock\", and [mock] names no scene; write [mock] scene = \"pi4\"")]
    NoScene,
    /// A name that hardware needs is not in the configuration.
    #[error("{0} is missing; `cermctl lines` shows what there is")]
    Missing(String),
    /// The hardware is not usable.
    #[error(transparent)]
    Hardware(#[from] chardev::ChardevError),
}

/// Opens the pins that a checked configuration names. Simulated ones keep step with the wall clock, from `now` on.
///
/// # Errors
/// What is wrong with the scene or the hardware.
pub fn open(config: &Config, now: Nanos) -> Result<AnyPins, OpenError> {
    match config.gpio.backend {
        Backend::Mock => {
            let mock = config.mock.as_ref().ok_or(OpenError::NoScene)?;
            Ok(Box::new(SimPins::new(&scene(config)?, mock.seed).paced(now)))
        }
        Backend::Chardev => Ok(Box::new(Chardev::open(&wiring(config)?)?)),
        Backend::ChardevV1 => Ok(Box::new(chardev_v1::open(&wiring(config)?)?)),
    }
}

/// Makes every line of a wiring an input: for after a kill. A simulated circuit has none.
///
/// # Errors
/// The first line that could not be had; the others are inputs all the same.
pub fn release_lines(backend: Backend, wiring: &Wiring) -> Result<(), OpenError> {
    match backend {
        Backend::Mock => {}
        Backend::Chardev => chardev::release_lines(wiring)?,
        Backend::ChardevV1 => chardev_v1::release_lines(wiring)?,
    }
    Ok(())
}

/// By way of what single lines of a backend are held.
pub fn way(backend: Backend) -> Way {
    match backend {
        Backend::Chardev => Way::V2,
        Backend::ChardevV1 => Way::V1,
        Backend::Mock => Way::Simulated,
    }
}

/// The lines of the configured circuit.
///
/// # Errors
/// The key of the first line that is needed and not named.
pub fn wiring(config: &Config) -> Result<Wiring, OpenError> {
    let gpio = &config.gpio;
    let two_nodes = config.circuit.kind() == Kind::TwoCapacitor;
    let name = |line: &Option<LineName>| line.clone().map(|line| line.0);
    let needed = |key: &str, name: Option<String>| name.ok_or_else(|| OpenError::Missing(key.to_owned()));
    let sinks_x = config
        .channels
        .iter()
        .map(|channel| needed(&format!("channel.{}.sink", channel.id), name(&channel.sink)));
    Ok(Wiring {
        chip: needed("gpio.chip", gpio.chip.clone())?,
        sense_a: needed("gpio.sense-a", name(&gpio.sense_a))?,
        sense_b: two_nodes.then(|| needed("gpio.sense-b", name(&gpio.sense_b))).transpose()?,
        charge_a: name(&gpio.charge_a),
        charge_b: name(&gpio.charge_b).filter(|_| two_nodes),
        sink_c1: needed("gpio.sink-c1", name(&gpio.sink_c1))?,
        sink_c2: needed("gpio.sink-c2", name(&gpio.sink_c2))?,
        sinks_x: sinks_x.collect::<Result<_, _>>()?,
        consumer: CONSUMER.to_owned(),
    })
}

/// The scene that a configuration names: a file (`*.toml`, beside the configuration), or one that is built in.
///
/// # Errors
/// The scene does not exist, or is wrong.
pub fn scene(config: &Config) -> Result<Scene, OpenError> {
    let mock = config.mock.as_ref().ok_or(OpenError::NoScene)?;
    Ok(Scene::named(&mock.scene, &config.base)?.with_kind(config.circuit.kind())?)
}

/// The nominal values that somebody with this board would write into the configuration.
pub fn circuit_of(scene: &Scene) -> Circuit {
    let circuit = &scene.circuit;
    let r_charge = circuit.r_p.map_or(0.0, |r_p| r_p.0) + circuit.r_o.0;
    Circuit {
        network: scene.network().network,
        r_c1: circuit.r_c1,
        r_c2: circuit.r_c2,
        v_dd: circuit.v_dd,
        v_th: circuit.threshold.falling,
        r_charge: if r_charge > 0.0 { Ohm(r_charge) } else { NOMINAL_R_CHARGE },
        r_o: circuit.r_o,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shipped() -> Config {
        Config::parse(include_str!("../../hw/cermd.toml"), "hw/cermd.toml").unwrap()
    }

    #[test]
    fn the_wiring_is_that_of_the_configuration() {
        let wiring = wiring(&shipped()).unwrap();
        assert_eq!((wiring.chip.as_str(), wiring.consumer.as_str()), ("pinctrl-rp1", "cermd"));
        assert_eq!((wiring.sense_a.as_str(), wiring.sense_b.as_deref()), ("GPIO5", Some("GPIO6")));
        assert_eq!(
            (wiring.charge_a.as_deref(), wiring.charge_b.as_deref()),
            (Some("GPIO13"), Some("GPIO19"))
        );
        assert_eq!((wiring.sink_c1.as_str(), wiring.sink_c2.as_str()), ("GPIO20", "GPIO21"));
        assert_eq!(wiring.sinks_x, ["GPIO16"]);
    }

    #[test]
    fn one_capacitor_needs_no_second_node_and_uses_none() {
        let mut config = shipped();
        config.circuit.network = crate::circuit::Network::OneCapacitor { c: crate::units::Farad(470e-9) };
        let wiring = wiring(&config).unwrap();
        assert_eq!((wiring.sense_b, wiring.charge_b), (None, None));
    }

    #[test]
    fn a_line_that_is_missing_is_named_by_its_key() {
        let mut config = shipped();
        config.gpio.sense_b = None;
        assert!(wiring(&config).unwrap_err().to_string().starts_with("gpio.sense-b is missing"));
        config = shipped();
        config.channels[0].sink = None;
        assert!(wiring(&config).unwrap_err().to_string().starts_with("channel.thumb.sink is missing"));
    }
}
