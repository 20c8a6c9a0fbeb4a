//! From what is typed to what is looked for: everything that cannot be meant is refused here, with what to type instead.

use crate::circuit::Kind;
use crate::config::{STRONGEST_PIN_A, pin_limit_a};
use crate::ctl::{CtlError, cli};
use crate::pins::sim::Scene;
use crate::sensor::FSR_402;
use crate::size::{Need, Platform, Search, Stock, Tolerance, Wanted};
use crate::units::rough;
use std::path::Path;

/// What is looked for, on which scene, and the sensor's alpha where it is one of force.
#[derive(Debug)]
pub struct Asked {
    pub search: Search,
    pub scene: Scene,
    pub name: String,
    pub alpha_n_ohm: Option<f64>,
}

/// Puts together what belongs together.
pub fn asked(arguments: &cli::Size) -> Result<Asked, CtlError> {
    let scene = Scene::named(&arguments.scene, Path::new(""))?;
    let alpha_n_ohm = arguments.sensor.map(|cli::SensorName::Fsr402| FSR_402.0);
    let r_ohm = match (arguments.r, arguments.force, alpha_n_ohm) {
        (Some([from, to]), ..) => [from.0, to.0],
        (_, Some([from, to]), Some(alpha)) => [alpha / to.0, alpha / from.0],
        _ => return Err(CtlError::said("--r, or --sensor and --force: the range of the sensor is needed")),
    };
    let tolerance = match (arguments.error, alpha_n_ohm) {
        (None, _) => None,
        (Some(Wanted::Percent(percent)), _) => Some(Tolerance::Share(percent.0 / 100.0)),
        (Some(Wanted::Ohm(ohm)), _) => Some(Tolerance::Ohm(ohm.0)),
        (Some(Wanted::Newton(force)), Some(alpha_n_ohm)) => {
            Some(Tolerance::Newton { f_n: force.0, alpha_n_ohm })
        }
        (Some(Wanted::Newton(_)), None) => {
            return Err(CtlError::said(
                "--error in newton needs a sensor: --sensor fsr402 --force 0.2N..20N instead of --r",
            ));
        }
    };
    let kinds = match arguments.wiring {
        None => vec![Kind::OneCapacitor, Kind::TwoCapacitor],
        Some(Kind::SeriesCalibration) => {
            return Err(CtlError::said(
                "--wiring series is for qerm, which is planned for by hand: size takes one or two",
            ));
        }
        Some(kind) => vec![kind],
    };
    let platform = Platform::of(&scene);
    let need = Need { r_ohm, tolerance, rate_hz: arguments.rate.map(|rate| rate.0) };
    let stock = arguments.have.clone().unwrap_or(Stock::Shop);
    let pin_a = arguments.pin_current.map_or(usual_pin_a(&arguments.scene), |current| current.0);
    let search = Search { need, platform, stock, pin_a, kinds };
    if !search.can_calibrate() {
        return Err(CtlError::said(format!(
            "--have: two resistors are needed to calibrate with, of at least {} so that no pin carries more than {}, the \
             second at least 1.5 times the first",
            rough(search.least_ohm(), "ohm"),
            milliampere(pin_a),
        )));
    }
    Ok(Asked { search, scene, name: arguments.scene.clone(), alpha_n_ohm })
}

/// The GPIO chip of a board; that of the weakest pins where nobody says.
pub fn chip_of(scene: &str) -> &'static str {
    match scene {
        "pi5" => "pinctrl-rp1",
        "pi-zero" => "pinctrl-bcm2835",
        _ => "pinctrl-bcm2711",
    }
}

fn usual_pin_a(scene: &str) -> f64 {
    pin_limit_a(chip_of(scene)).unwrap_or(STRONGEST_PIN_A)
}

pub fn milliampere(ampere: f64) -> String {
    format!("{:.1} mA", 1e3 * ampere)
}
