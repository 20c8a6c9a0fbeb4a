//! From `[gpio]` and `[mock]` to pins.
//!
//! For: the one place that knows which backends there are. Must not know: what is done with the pins.

use crate::circuit::Network;
use crate::config::{Backend, Config};
use crate::pins::sim::{Kind, Scene, SceneError, SimPins};
use crate::pins::{Pins, PinsError};
use crate::units::Nanos;
use std::path::Path;

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
    /// The hardware is not usable.
    #[error(transparent)]
    Pins(#[from] PinsError),
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
        Backend::Chardev | Backend::ChardevV1 => Err(OpenError::Pins(PinsError::Ended)),
    }
}

/// The scene that a configuration names: a file (`*.toml`, beside the configuration), or one that is built in.
///
/// # Errors
/// The scene does not exist, or is wrong.
pub fn scene(config: &Config) -> Result<Scene, OpenError> {
    let mock = config.mock.as_ref().ok_or(OpenError::NoScene)?;
    let scene = if mock.scene.ends_with(".toml") {
        Scene::load(&config.path(Path::new(&mock.scene)))?
    } else {
        Scene::builtin(&mock.scene)?
    };
    let kind = match config.circuit.network {
        Network::TwoCapacitor { .. } => Kind::TwoCapacitor,
        Network::OneCapacitor { .. } => Kind::OneCapacitor,
        Network::SeriesCalibration { .. } => Kind::SeriesCalibration,
    };
    Ok(scene.with_kind(kind)?)
}
