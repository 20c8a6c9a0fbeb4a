//! What a cell has other than its board and configuration say.

use super::limits::ALWAYS;
use super::table::Vary;
use crate::config::Config;
use crate::instrument::settings::OffsetSource;
use crate::pins::sim::scene::{DelayScene, Scene};
use crate::units::{Farad, Ohm, Seconds, named};

/// One change; amounts as [`Vary`] has them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Change {
    /// [`Vary::Jitter`].
    Jitter(Seconds),
    /// [`Vary::OffsetError`].
    OffsetError(Seconds),
    /// [`Vary::Capacitor`].
    Capacitor(f64),
    /// [`Vary::Leakage`].
    Leakage(Ohm),
    /// [`Vary::Speed`]: always as fast, back and forth about the resistance.
    Speed(f64),
    /// [`Vary::Without`].
    Without(Effect),
    /// [`Vary::SinceStart`]; all rows of it come out of one run.
    SinceStart,
    /// [`Vary::SwitchFraction`].
    SwitchFraction(f64),
}

named! {
    /// What a scene can be without.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    Effect {
        /// Scatter of the stamps of crossings.
        Jitter = "jitter",
        /// Stamps that are much later than others.
        LateStamps = "late-stamps",
        /// Scatter of the instants at which lines move.
        Moves = "moves",
        /// Calls and wake-ups in whose middle something else ran.
        Preemption = "preemption",
        /// Voltage noise.
        Noise = "noise",
        /// A clock that all is quantised by.
        Clock = "clock",
        /// Edges that are lost, bounce or come in bursts.
        Events = "events",
        /// Dielectric absorption.
        Absorption = "absorption",
        /// Leakage and pulls at the nodes.
        Leakage = "leakage",
        /// Pins that are unlike others.
        Pins = "pins",
        /// Drift and random walk.
        Drift = "drift",
    }
}

impl Effect {
    /// The effects that a scene has.
    pub fn of(scene: &Scene) -> impl Iterator<Item = Effect> {
        Effect::ALL.into_iter().filter(|effect| effect.without(scene.clone()) != *scene)
    }

    fn without(self, mut scene: Scene) -> Scene {
        let no_tail = |delay: &mut Option<DelayScene>| {
            if let Some(delay) = delay {
                (delay.tail_probability, delay.tail_mean) = (None, None);
            }
        };
        match self {
            Effect::Jitter => scene.stamps.iter_mut().for_each(|stamps| stamps.jitter = None),
            Effect::LateStamps => no_tail(&mut scene.stamps),
            Effect::Moves => {
                scene.calls.iter_mut().for_each(|calls| (calls.jitter, calls.moves_at) = (None, None));
            }
            Effect::Preemption => {
                scene.calls.iter_mut().for_each(|calls| {
                    (calls.tail_probability, calls.tail_mean) = (None, None);
                });
                [&mut scene.wake, &mut scene.sleep].into_iter().for_each(no_tail);
            }
            Effect::Noise => scene.noise = None,
            Effect::Clock => scene.clock_period = None,
            Effect::Events => scene.events = None,
            Effect::Absorption => scene.circuit.absorption = Default::default(),
            Effect::Leakage => {
                for node in [&mut scene.circuit.node_a, &mut scene.circuit.node_b] {
                    (node.leakage, node.leakage_resistance) = (None, None);
                    (node.pull_up, node.pull_down) = (None, None);
                }
            }
            Effect::Pins => scene.circuit.r_o_of.clear(),
            Effect::Drift => (scene.drift, scene.walk) = (None, None),
        }
        scene
    }
}

impl Change {
    /// Changes a board and how it is read.
    pub fn apply(self, scene: Scene, config: &mut Config) -> Scene {
        if let Change::Without(effect) = self {
            return effect.without(scene);
        }
        let mut scene = scene;
        match self {
            Change::Jitter(jitter) => {
                let none =
                    DelayScene { mean: Seconds(0.0), jitter: None, tail_probability: None, tail_mean: None };
                scene.stamps.get_or_insert(none).jitter = Some(jitter);
            }
            Change::OffsetError(error) => {
                let d = latency(&scene).0 + error.0;
                config.measure.offset = Some(OffsetSource::Given(d * 1e9));
            }
            Change::Capacitor(factor) => {
                let circuit = &mut scene.circuit;
                let (c, other) = config.circuit.network.capacitors();
                let all = [&mut circuit.c_a, &mut circuit.c_b, &mut circuit.c].into_iter().flatten();
                all.chain([c]).chain(other).for_each(|c| *c = Farad(c.0 * factor));
            }
            Change::Leakage(r) => {
                for node in [&mut scene.circuit.node_a, &mut scene.circuit.node_b] {
                    node.leakage_resistance = Some(r);
                }
            }
            Change::SwitchFraction(fraction) => {
                (config.measure.t_l, config.measure.switch_fraction) = (Some(ALWAYS), Some(fraction));
            }
            Change::Speed(_) | Change::Without(_) | Change::SinceStart => {}
        }
        scene
    }

    /// For the columns of a table: which, by how much, and its name.
    pub fn columns(self) -> (Vary, Option<f64>, Option<String>) {
        let (vary, value) = match self {
            Change::Jitter(jitter) => (Vary::Jitter, jitter.0),
            Change::OffsetError(error) => (Vary::OffsetError, error.0),
            Change::Capacitor(factor) => (Vary::Capacitor, factor),
            Change::Leakage(r) => (Vary::Leakage, r.0),
            Change::Speed(share_per_s) => (Vary::Speed, share_per_s),
            Change::Without(effect) => return (Vary::Without, None, Some(effect.to_string())),
            Change::SinceStart => return (Vary::SinceStart, None, None),
            Change::SwitchFraction(fraction) => (Vary::SwitchFraction, fraction),
        };
        (vary, Some(value), None)
    }
}

/// How late a crossing is stamped, without the rare long delays: what a latency offset should be.
fn latency(scene: &Scene) -> Seconds {
    let stamps = scene.stamps.map_or(0.0, |stamps| stamps.mean.0);
    Seconds(stamps + scene.clock_period.map_or(0.0, |period| period.0 / 2.0))
}
