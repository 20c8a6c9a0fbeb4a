//! What readings are to be expected, by a rehearsal: the instrument with its own plan, estimator and settings on the simulated
//! circuit, in virtual time, for every method alike.

use crate::characterize::cell::staggered;
use crate::circuit::{Circuit, Network, Node};
use crate::config::backend;
use crate::config::{Backend, Config, Findings};
use crate::ctl::limits::{
    BEYOND_CHANCE, COLD, LONGEST_REHEARSED, REHEARSED, REHEARSED_BOARDS, REHEARSED_READINGS, SHARES_OF_R_2,
    WARM,
};
use crate::estimate::scatter::{self, median};
use crate::instrument::settings::Settings;
use crate::instrument::{Instrument, Message};
use crate::pins::Pins;
use crate::pins::sim::{Scene, Sensor, SimPins};
use crate::reading::{Measured, MeasuredValue, Status};
use crate::sensor::Channel;
use crate::units::{Nanos, Ohm, Seconds, Volt, measured, rough, rounded};

/// What to expect of readings of a resistance on each channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expected {
    /// The resistance.
    pub r_ohm: f64,
    /// Root mean square of what is stated of numbers, 1 sigma, ohm, or of their errors where these are larger by more than chance;
    /// `None` where there are none.
    pub u_ohm: Option<f64>,
    /// Readings of a channel in a second.
    pub rate_hz: f64,
    /// Discharges of all kinds in a second.
    pub discharges_hz: f64,
}

/// The board that is rehearsed on, and where its noise is known from. `jitter`: of stamps, as it was measured.
pub fn board(config: &Config, jitter: Option<Seconds>) -> Option<(Scene, String)> {
    if config.gpio.backend == Backend::Mock {
        return backend::scene(config).ok().map(|scene| (scene, "the scene".to_owned()));
    }
    let name = match config.gpio.chip.as_deref().unwrap_or_default() {
        chip if chip.contains("rp1") => "pi5",
        chip if chip.contains("bcm2835") => "pi-zero",
        _ => "pi4",
    };
    let mut scene = Scene::builtin(name).ok()?;
    let mut how = format!("calls and noise of the scene {name}");
    if let (Some(jitter), Some(stamps)) = (jitter, &mut scene.stamps) {
        stamps.jitter = Some(jitter);
        how = format!("the jitter that was measured, {jitter:.2}, else {how}");
    }
    Some((built(scene, &config.circuit)?, how))
}

/// A board with another circuit on it; `None` if a scene cannot have it.
pub fn built(mut scene: Scene, nominal: &Circuit) -> Option<Scene> {
    let circuit = &mut scene.circuit;
    match nominal.network {
        Network::TwoCapacitor { c_a, c_b } => (circuit.c_a, circuit.c_b) = (Some(c_a), Some(c_b)),
        Network::OneCapacitor { c } | Network::SeriesCalibration { c } => circuit.c = Some(c),
    }
    (circuit.r_c1, circuit.r_c2, circuit.r_o, circuit.v_dd) =
        (nominal.r_c1, nominal.r_c2, nominal.r_o, nominal.v_dd);
    circuit.r_p = Some(Ohm((nominal.r_charge.0 - nominal.r_o.0).max(0.0)));
    circuit.threshold.falling = nominal.v_th;
    circuit.threshold.rising = circuit.threshold.rising.map(|rising| Volt(rising.0.max(nominal.v_th.0)));
    scene.with_kind(nominal.kind()).ok()
}

/// From a hundredth of R_2 up to what the deadline resolves, ohm.
pub fn resistances(config: &Config, settings: &Settings) -> Vec<f64> {
    let highest = config.circuit.resistance(Node::A, config.deadline().into()).unwrap_or_default();
    let all = SHARES_OF_R_2.into_iter().map(|share| rounded(share * settings.r_ohm()[1], 1));
    all.filter(|r_ohm| *r_ohm < highest.0).collect()
}

/// At these [`resistances`].
pub fn expected(config: &Config, settings: &Settings, scene: &Scene) -> Vec<Expected> {
    let short = shortened(settings);
    // What is the mean over a part of the time comes as much more often.
    let part = short.average.zip(settings.average).filter(|(short, long)| short < long);
    let slower = part.map_or(1.0, |(short, long)| short.as_seconds() / long.as_seconds());
    let rehearsed = |r_ohm| rehearse(&short, scene, r_ohm, REHEARSED_BOARDS);
    let slowed = |found: Expected| Expected { rate_hz: slower * found.rate_hz, ..found };
    resistances(config, settings).into_iter().filter_map(rehearsed).map(slowed).collect()
}

/// Whether what is published is the mean over more time than somebody waits for. Where cycles rest between readings, however
/// rare, few discharges have to be simulated.
fn is_shortened(settings: &Settings) -> bool {
    settings.period.is_none() && settings.average.is_some_and(|average| average > LONGEST_REHEARSED)
}

/// The same with means that do not take minutes to simulate. They are no better than longer ones: what is expected of them holds.
pub(super) fn shortened(settings: &Settings) -> Settings {
    let average = if is_shortened(settings) { Some(LONGEST_REHEARSED) } else { settings.average };
    Settings { average, ..settings.clone() }
}

/// What so many boards of a kind do together: each has another noise, and has learned another u from it. At each channel is a sensor
/// of `r_ohm`, behind what its zero says. `None` if one of them does not find its own state.
pub fn rehearse(settings: &Settings, scene: &Scene, r_ohm: f64, boards: usize) -> Option<Expected> {
    let sensors = settings.channels.iter().map(|channel| Sensor::Constant(Ohm(channel.as_read(r_ohm))));
    let mut scene = scene.clone().with_sensors(sensors.collect()).ok()?;
    let mut each = Vec::new();
    for index in 0..boards {
        each.push(rehearse_board(settings, &scene, r_ohm, staggered(index as u64, boards as u64))?);
        scene.seed = scene.seed.wrapping_add(1);
    }
    let all = each.iter().fold(RehearsalSum::default(), RehearsalSum::and);
    let stated = stated_by(&each);
    Some(Expected {
        r_ohm,
        u_ohm: (2 * all.numbers > all.readings).then(|| refuted_by(&each, stated).unwrap_or(stated).sqrt()),
        rate_hz: all.readings as f64 / settings.channels.len() as f64 / all.until_last,
        discharges_hz: all.discharges as f64 / all.seconds,
    })
}

/// The mean square of what is stated on half of the boards, ohm²: a few state much more, to which chance looks like a leak or a dielectric.
fn stated_by(boards: &[RehearsalSum]) -> f64 {
    median(&mut mean_squares(boards, |board| board.stated))
}

/// The mean square of errors, ohm², where it is above what is stated by more than boards scatter. Those of one board have their
/// calibration in common, so that of one alone nothing is known.
fn refuted_by(boards: &[RehearsalSum], stated: f64) -> Option<f64> {
    let mean = scatter::mean(mean_squares(boards, |board| board.errors).into_iter())?;
    mean.u.filter(|u| mean.value - BEYOND_CHANCE * u > stated).map(|_| mean.value)
}

/// The mean of squares on each board that has numbers, ohm².
fn mean_squares(boards: &[RehearsalSum], sum: fn(&RehearsalSum) -> f64) -> Vec<f64> {
    let with_numbers = boards.iter().filter(|board| board.numbers > 0);
    with_numbers.map(|board| sum(board) / board.numbers as f64).collect()
}

/// What came of boards; `stated`, `errors`: the sum of the squares of u, and of what it is said of, ohm².
#[derive(Default)]
struct RehearsalSum {
    readings: usize,
    numbers: usize,
    stated: f64,
    errors: f64,
    discharges: usize,
    seconds: f64,
    /// Until the last reading, s: few of them would be counted short otherwise.
    until_last: f64,
}

impl RehearsalSum {
    fn and(self, other: &RehearsalSum) -> RehearsalSum {
        RehearsalSum {
            readings: self.readings + other.readings,
            numbers: self.numbers + other.numbers,
            stated: self.stated + other.stated,
            errors: self.errors + other.errors,
            discharges: self.discharges + other.discharges,
            seconds: self.seconds + other.seconds,
            until_last: self.until_last + other.until_last,
        }
    }
}

/// Lets an instrument find its state and its offset; when it has them and `later` has passed, `None` if that takes too long.
pub(super) fn warm_up<P: Pins>(
    instrument: &mut Instrument<P>,
    settings: &Settings,
    later: Nanos,
) -> Option<Nanos> {
    let until = cold(settings);
    loop {
        let now = instrument.pins().now();
        if now > WARM + later && instrument.cycle().offset_is_known() {
            return Some(now);
        }
        if now > until {
            return None;
        }
        instrument.step(&mut |_| {}).ok()?;
    }
}

/// When a board that has no state or offset is given up.
fn cold(settings: &Settings) -> Nanos {
    COLD.max(longest(settings) + longest(settings))
}

/// The longest that readings may have to be waited for.
pub(super) fn longest(settings: &Settings) -> Nanos {
    settings.average.unwrap_or_default().max(settings.period.unwrap_or_default())
}

/// `None` if it has no offset or state in time.
fn rehearse_board(settings: &Settings, scene: &Scene, r_ohm: f64, later: Nanos) -> Option<RehearsalSum> {
    let mut instrument = Instrument::new(SimPins::new(scene, None), settings.clone());
    // What is settling, with the offset or the state still to be found, is not what comes after it.
    let mut now = warm_up(&mut instrument, settings, later)?;
    let (mut began, mut last) = (None, Nanos::ZERO);
    let mut found = RehearsalSum::default();
    let end = |began: Nanos| began + REHEARSED.max(Nanos(longest(settings).0.saturating_mul(3)));
    let enough = REHEARSED_READINGS * settings.channels.len();
    while found.readings < enough && began.is_none_or(|began| now < end(began)) {
        let step = instrument.step(&mut |message| match message {
            Message::Reading(reading) if began.is_some() => {
                found.readings += 1;
                last = now;
                if let Status::Ok { r_ohm: Measured { value, u: Some(u) }, .. } = reading.status {
                    found.stated += u * u;
                    found.errors += (value - r_ohm).powi(2);
                    found.numbers += 1;
                }
            }
            Message::Reading(_) => began = Some(now),
            Message::Discharge { .. } if began.is_some() => found.discharges += 1,
            _ => {}
        });
        step.ok()?;
        now = instrument.pins().now();
    }
    let began = began?;
    let [seconds, until_last] = [now, last].map(|end| (end - began).as_seconds().max(f64::MIN_POSITIVE));
    Some(RehearsalSum { seconds, until_last, ..found })
}

/// Adds what readings are to be expected: their errors, their forces, and how often they come.
pub fn readings(config: &Config, settings: &Settings, jitter: Option<Seconds>, findings: &mut Findings) {
    let Some((scene, mut how)) = board(config, jitter) else { return };
    if is_shortened(settings) {
        let rehearsed = Seconds::from(LONGEST_REHEARSED);
        how = format!("{how}, with means over {rehearsed:.0}, which longer ones are no worse than");
    }
    let all = expected(config, settings, &scene);
    let says = |Expected { r_ohm, u_ohm, rate_hz, discharges_hz }: &Expected| match u_ohm {
        Some(_) => {
            let r_ohm = measured(*r_ohm, *u_ohm, "ohm", false);
            // One in a minute is not none.
            let places = if *rate_hz < 0.05 { 3 } else { 1 };
            format!("{r_ohm} at {rate_hz:.places$} Hz ({discharges_hz:.0} discharges a second)")
        }
        None => format!("{:.0}: no number", Ohm(*r_ohm)),
    };
    if all.is_empty() {
        let cold = Seconds::from(cold(&shortened(settings)));
        findings.warning(
            "measure.method",
            format!(
                "{} simulated, by {how}: no calibration after {cold:.0}: until then there is no number",
                config.method()
            ),
            "more discharges: a shorter average or a higher rate-hz",
        );
    } else {
        let text = all.iter().map(says).collect::<Vec<_>>().join(", ");
        findings.info("measure.method", format!("{} simulated, by {how}: {text}", config.method()));
    }
    for channel in &settings.channels {
        let key = match channel {
            Channel { force: Some(_), .. } => "force",
            Channel { law: Some(_), .. } => "law",
            _ => continue,
        };
        let unit = channel.unit();
        let says = |Expected { r_ohm, u_ohm, .. }: &Expected| {
            let r_ohm = Measured { value: *r_ohm, u: Some((*u_ohm)?) };
            let MeasuredValue { value, u, repeat_u, .. } = channel.value_at(r_ohm, settings.r_ohm())?;
            let repeat = repeat_u.map(|u| rough(u, unit)).unwrap_or_default();
            Some(format!("{} (readout {repeat})", measured(value, u, unit, false)))
        };
        let text = all.iter().filter_map(says).collect::<Vec<_>>().join(", ");
        let text = if text.is_empty() { "none that its law says anything of".to_owned() } else { text };
        findings.info(format!("channel.{}.{key}", channel.id), format!("at these resistances: {text}"));
    }
}

#[cfg(test)]
mod tests;
