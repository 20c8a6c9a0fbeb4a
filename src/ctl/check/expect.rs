//! What readings are to be expected, by a rehearsal: the instrument with its own plan, estimator and settings on the simulated
//! circuit, in virtual time, for every method alike.

use crate::circuit::{Network, Node};
use crate::config::backend;
use crate::config::{Backend, Config, Findings};
use crate::ctl::limits::{COLD, REHEARSED, REHEARSED_READINGS, SHARES_OF_R_2, WARM};
use crate::instrument::settings::Settings;
use crate::instrument::{Instrument, Message};
use crate::pins::Pins;
use crate::pins::sim::{Scene, Sensor, SimPins};
use crate::reading::{Measured, MeasuredForce, Status};
use crate::units::{Nanos, Ohm, Seconds, Volt, measured, rough, rounded};

/// What to expect of readings of a resistance on each channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expected {
    /// The resistance.
    pub r_ohm: f64,
    /// Root mean square of what is stated of numbers, 1 sigma, ohm; `None` where there are none.
    pub u_ohm: Option<f64>,
    /// Readings of a channel, and discharges of all kinds, in a second.
    pub rate_hz: f64,
    /// See there.
    pub discharges_hz: f64,
}

/// The board that is rehearsed on, and where its noise is known from. `jitter`: of stamps, as it was measured.
pub fn board(config: &Config, jitter: Option<Seconds>) -> Option<(Scene, String)> {
    if config.gpio.backend == Backend::Mock {
        return backend::scene(config).ok().map(|scene| (scene, "the scene".to_owned()));
    }
    let is_5 = config.gpio.chip.as_deref().is_some_and(|chip| chip.contains("rp1"));
    let name = if is_5 { "pi5" } else { "pi4" };
    let mut scene = Scene::builtin(name).ok()?;
    let mut how = format!("calls and noise of the scene {name}");
    if let (Some(jitter), Some(stamps)) = (jitter, &mut scene.stamps) {
        stamps.jitter = Some(jitter);
        how = format!("the jitter that was measured, {jitter:.2}, else {how}");
    }
    let (circuit, nominal) = (&mut scene.circuit, &config.circuit);
    match nominal.network {
        Network::TwoCapacitor { c_a, c_b } => (circuit.c_a, circuit.c_b) = (Some(c_a), Some(c_b)),
        Network::OneCapacitor { c } | Network::SeriesCalibration { c } => circuit.c = Some(c),
    }
    (circuit.r_c1, circuit.r_c2, circuit.r_o, circuit.v_dd) =
        (nominal.r_c1, nominal.r_c2, nominal.r_o, nominal.v_dd);
    circuit.r_p = Some(Ohm((nominal.r_charge.0 - nominal.r_o.0).max(0.0)));
    circuit.threshold.falling = nominal.v_th;
    circuit.threshold.rising = circuit.threshold.rising.map(|rising| Volt(rising.0.max(nominal.v_th.0)));
    Some((scene.with_kind(nominal.kind()).ok()?, how))
}

/// From a hundredth of R_2 up to what the deadline resolves.
pub fn expected(config: &Config, settings: &Settings, scene: &Scene) -> Vec<Expected> {
    let highest = config.circuit.resistance(Node::A, config.deadline().into()).unwrap_or_default();
    SHARES_OF_R_2
        .into_iter()
        .map(|share| rounded(share * settings.r_ohm()[1], 1))
        .filter(|r_ohm| *r_ohm < highest.0)
        .filter_map(|r_ohm| rehearse(settings, scene, r_ohm))
        .collect()
}

fn rehearse(settings: &Settings, scene: &Scene, r_ohm: f64) -> Option<Expected> {
    let sensors = vec![Sensor::Constant(Ohm(r_ohm)); settings.channels.len()];
    let scene = scene.clone().with_sensors(sensors).ok()?;
    let mut instrument = Instrument::new(SimPins::new(&scene, None), settings.clone());
    let channels = settings.channels.len();
    let (mut began, mut readings, mut discharges) = (None, 0usize, 0usize);
    let (mut squares, mut numbers, mut now) = (0.0, 0usize, Nanos::ZERO);
    let least = settings.average.unwrap_or_default().max(settings.period.unwrap_or_default());
    let end = |began: Nanos| began + REHEARSED.max(Nanos(3 * least.0));
    while readings < REHEARSED_READINGS * channels && began.is_none_or(|began| now < end(began)) {
        // What is settling, with the offset or the state still to be found, is not what comes after it.
        let is_warm = began.is_some() || now > WARM && instrument.cycle().offset_is_known();
        if !is_warm && now > COLD.max(Nanos(2 * least.0)) {
            return None;
        }
        let step = instrument.step(&mut |message| match message {
            Message::Reading(reading) if began.is_some() => {
                readings += 1;
                if let Status::Ok { r_ohm: Measured { u: Some(u), .. }, .. } = reading.status {
                    squares += u * u;
                    numbers += 1;
                }
            }
            Message::Reading(_) if is_warm => began = Some(now),
            Message::Discharge { .. } if began.is_some() => discharges += 1,
            _ => {}
        });
        step.ok()?;
        now = instrument.pins().now();
    }
    let seconds = (now - began?).as_seconds();
    Some(Expected {
        r_ohm,
        u_ohm: (2 * numbers > readings).then(|| (squares / numbers as f64).sqrt()),
        rate_hz: readings as f64 / channels as f64 / seconds,
        discharges_hz: discharges as f64 / seconds,
    })
}

/// Adds what readings are to be expected: their errors, their forces, and how often they come.
pub fn readings(config: &Config, settings: &Settings, jitter: Option<Seconds>, findings: &mut Findings) {
    let Some((scene, how)) = board(config, jitter) else { return };
    let all = expected(config, settings, &scene);
    let says = |Expected { r_ohm, u_ohm, rate_hz, discharges_hz }: &Expected| match u_ohm {
        Some(_) => {
            let r_ohm = measured(*r_ohm, *u_ohm, "ohm", false);
            format!("{r_ohm} at {rate_hz:.1} Hz ({discharges_hz:.0} discharges a second)")
        }
        None => format!("{:.0}: no number", Ohm(*r_ohm)),
    };
    let text = all.iter().map(says).collect::<Vec<_>>().join(", ");
    findings.info("measure.method", format!("{} simulated, by {how}: {text}", config.method()));
    for channel in &settings.channels {
        if channel.force.is_none() {
            continue;
        }
        let says = |Expected { r_ohm, u_ohm, .. }: &Expected| {
            let r_ohm = Measured { value: *r_ohm, u: Some((*u_ohm)?) };
            let MeasuredForce { value, u, repeat_u, .. } = channel.force_at(r_ohm, settings.r_ohm())?;
            let repeat = repeat_u.map(|u| rough(u, "N")).unwrap_or_default();
            Some(format!("{} (readout {repeat})", measured(value, u, "N", false)))
        };
        let text = all.iter().filter_map(says).collect::<Vec<_>>().join(", ");
        findings.info(format!("channel.{}.force", channel.id), format!("at these resistances: {text}"));
    }
}

#[cfg(test)]
mod tests;
