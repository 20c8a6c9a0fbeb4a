//! What the next discharge is planned to do: full or switched, and when; which calibration discharge pays.

use super::choice::{self, Choice, Terms};
use super::window::Window;
use super::{Branch, CalibrationKind, Cycle, Estimator, Fault, Judged, Look, Plan, Record, Status, Through};
use crate::circuit::Node;
use crate::estimate::Predicted;
use crate::estimate::awake;
use crate::estimate::law::State;
use crate::estimate::leak;
use crate::estimate::limits::{ABSORPTION_REST, BEYOND_NOISE, LEAK_HOLD, SPLIT_FRACTION, UNKNOWN_JITTER_NS};
use crate::estimate::method::Switching;
use crate::estimate::motion::Motion;
use crate::estimate::offset::{is_late, latest_ns};
use crate::estimate::scatter::expected_ns;
use crate::instrument::discharge::Charge;
use crate::instrument::limits::{
    B_FORGOTTEN, B_LEFT_ALONE, CALIBRATION_PAYS, CHARGE_STEP, HYSTERESIS, LONGEST_IDLE, LONGEST_UNSEEN,
    MOST_LONGER, OFFSET_SHARE, OUTLIERS_OF_DOUBT, RESTLESS_KEEPS, RETRY_EARLIER, SHOWN_LASTS, YOUNG,
    YOUNG_EVERY, YOUNG_PAUSE,
};
use crate::instrument::settings::Charges;
use crate::record::Crossings;
use crate::sensor::Channel;
use crate::units::Nanos;

/// What is remembered of a channel for the plan of its next discharge.
#[derive(Debug, Clone, Copy, Default)]
pub struct Memory {
    /// The last resistance as it was measured, zero included; `None` after anything but a number.
    r_ohm: Option<f64>,
    inferred: bool,
    u_switch_ns: f64,
    /// Outliers in a row: the crossings contradict each other, or the calibration does them.
    outliers: u32,
    /// The last two readings in a row that were switched alike, ohm.
    switched_ohm: [Option<f64>; 2],
    /// How the sensor has changed lately.
    pub(super) motion: Motion,
    /// How the last estimate depends on the tracked state, and its variance but for that, ohm².
    dependence: Option<(State, f64)>,
    /// What its discharges are like.
    choice: Option<Choice>,
    /// How far it has gone from reading to reading lately, relative.
    restless: f64,
    /// Whether it moves, and has only just begun to: the sensor, or else the calibration.
    is_moving: bool,
    pub(super) is_startled: bool,
    /// What has come since it was last published.
    pub(super) window: Window,
}

impl Memory {
    /// Learns from a reading.
    pub fn take(
        &mut self,
        Judged { status, basis, .. }: &Judged,
        record: Option<Record>,
        sensor: &Channel,
        estimator: &mut Estimator,
    ) {
        if let Some(record) = record {
            self.u_switch_ns = expected_ns(&record);
        }
        let is_moving =
            matches!(status, Status::Ok { is_moving: true, .. } | Status::Fault(Fault::Unsettled));
        self.is_startled |= is_moving && !self.is_moving;
        self.is_moving = is_moving;
        if !matches!(status, Status::Ok { .. }) {
            self.switched_ohm = [None; 2];
        }
        let is_outlier = matches!(status, Status::Fault(Fault::LatencyOutlier | Fault::Unsettled));
        self.outliers = if is_outlier { self.outliers.saturating_add(1) } else { 0 };
        match status {
            Status::Ok { branch, r_ohm, is_moving, .. } => {
                self.inferred = *branch == Branch::Inferred;
                self.moved_to(sensor.as_read(r_ohm.value));
                self.dependence = basis.by_state.map(|by_state| (by_state, basis.own));
                let switched = basis.by_switch.filter(|_| !is_moving).map(|by_switch| {
                    let steady = basis.own / by_switch.powi(2);
                    let u_ns = estimator.offset().scatter.u_ns(self.u_switch_ns);
                    (by_switch, (steady - u_ns * u_ns).max(0.0))
                });
                self.steadiness(r_ohm.value, switched, estimator);
            }
            // Where it is by now is known well enough for a plan.
            Status::Fault(Fault::Unsettled) => {
                self.restless = 1.0;
                self.r_ohm = self.motion.last_ohm(estimator.offset().r_o());
            }
            // One spike says nothing about the sensor.
            Status::Fault(Fault::LatencyOutlier | Fault::WideBracket) => {}
            Status::Short { .. } | Status::Open { .. } | Status::Fault(_) => {
                (self.r_ohm, self.dependence) = (None, None);
            }
        }
    }

    fn moved_to(&mut self, r_ohm: f64) {
        let away = self.r_ohm.map_or(1.0, |before| (r_ohm / before).ln().abs());
        self.restless = away.max(RESTLESS_KEEPS * self.restless);
        self.r_ohm = Some(r_ohm);
    }

    /// Lets the estimator know by how much the reading before this one was beside its neighbours; `switched`: what the instant
    /// of the switch does to it, ohm/ns, and its variance but for that, as a time, ns².
    fn steadiness(&mut self, r_ohm: f64, switched: Option<(f64, f64)>, estimator: &mut Estimator) {
        if let (Some((by_switch, steady)), [Some(first), Some(second)]) = (switched, self.switched_ohm) {
            // Its variance is 6 times that of a reading; a steady change is not in it.
            estimator.add_reading((first - 2.0 * second + r_ohm) / 6f64.sqrt() / by_switch, steady);
        }
        self.switched_ohm = [self.switched_ohm[1], switched.map(|_| r_ohm)];
    }
}

impl Cycle {
    pub(super) fn calibration_plan(&self, kind: CalibrationKind, last: Node) -> Plan {
        let second = self.settings.second();
        let wakes_ns = self.estimator.tracker().and_then(|tracker| tracker.wake_ns(kind));
        let [wakes_ns, _] = self.estimator.with_leak_ns([wakes_ns, None], kind);
        let wakes = wakes_ns.map(|ns| Nanos(ns as i64));
        let (through, to, after) = match kind {
            CalibrationKind::First => (Through::C1, Through::C1, wakes),
            CalibrationKind::Second => (second, second, wakes),
            CalibrationKind::Split => (Through::C1, second, self.split_time()),
        };
        let switch = after.map(|after| (after, to));
        self.of_calibration(kind, self.plan(through, switch, last))
    }

    /// R_2 with a pause on the way, in which a leak would show, or with a longer charge before it, which fills dielectrics; R_1 or R_2
    /// with the program awake at its end.
    pub(super) fn held_plan(&self, look: Look) -> Plan {
        let second = self.settings.second();
        if look == Look::Absorption {
            let plan = self.plan(second, None, Node::A);
            let charge = Charge { together: plan.charge.together + ABSORPTION_REST, ..plan.charge };
            return Plan { charge, ..plan };
        }
        let usual = self.estimator.calibration();
        if let Look::Awake(resistor) = look {
            let through = [Through::C1, second][resistor];
            let kind = [CalibrationKind::First, CalibrationKind::Second][resistor];
            let wakes_ns = usual.and_then(|(c1, c2)| {
                let due = [c1, c2][resistor];
                let noise = self.estimator.noise().covariance(due);
                awake::wake_ns(due[0]?, noise.map_or(UNKNOWN_JITTER_NS, |noise| noise.aa.sqrt()))
            });
            let [wakes_ns, _] = self.estimator.with_leak_ns([wakes_ns, None], kind);
            let plan = self.plan(through, wakes_ns.map(|ns| (Nanos(ns as i64), through)), Node::A);
            // The program is awake: nothing is rested for.
            return Plan { expected: [None; 2], ..self.of_calibration(kind, plan) };
        }
        let [a_ns, _] =
            usual.map_or([None; 2], |(_, c2)| self.estimator.with_leak_ns(c2, CalibrationKind::Second));
        let at = a_ns.map(|a_ns| Nanos((self.leak.held_at() * a_ns) as i64));
        let last = if self.leak.waits_for_b() { Node::B } else { Node::A };
        let [_, r_ohm] = self.estimator.paths_ohm();
        let hold = a_ns.map_or(LEAK_HOLD, |a_ns| leak::hold(a_ns, r_ohm));
        Plan { hold, ..self.plan(second, at.map(|at| (at, second)), last) }
    }

    pub(super) fn sensor_plan(&mut self, channel: usize) -> Plan {
        let rules = self.settings.method.rules();
        let best = if rules.switching == Switching::WhereBest { self.best(channel) } else { None };
        let settings = &self.settings;
        let last = best.map_or(settings.last(), |choice| choice.last);
        let limit = match rules.switching {
            Switching::WhereBest => self.estimator.tracker().map(|_| Through::C1),
            _ => None,
        };
        let to_second = |after: Nanos| (after, settings.second());
        let switch = match rules.switching {
            Switching::Never => None,
            Switching::AtFraction => self.switch_time(channel).map(to_second),
            Switching::WhereBest => best.and_then(|choice| choice.planned()),
        };
        // What an interrupt has met it would meet again at the same instant.
        let earlier = 1.0 - RETRY_EARLIER * f64::from(self.retries);
        let switch = switch.map(|(after, to)| (Nanos((earlier * after.as_ns()) as i64), to));
        // A switch must not make a discharge longer than the deadline does.
        let switch = switch.filter(|(after, _)| *after < settings.deadline);
        let plan = self.plan(rules.sensor(channel), switch, last);
        Plan { limit, falls: self.sensor_falls(channel, &plan), ..plan }
    }

    fn plan(&self, through: Through, switch: Option<(Nanos, Through)>, last: Node) -> Plan {
        let settings = &self.settings;
        Plan {
            through,
            switch,
            hold: Nanos::ZERO,
            limit: None,
            chargers: settings.chargers(),
            last,
            drain: if self.ended_early { settings.drain } else { Nanos::ZERO },
            charge: self.charge(last),
            settle: settings.settle,
            expected: [None; 2],
            falls: [None; 2],
            timeout: settings.deadline,
            widest_bracket: self.calls.widest(through.drives().count()),
            calls: self.calls.usual(),
        }
    }

    /// B is put back as long as somebody waits for it: at once after another discharge that did so, else from anywhere.
    fn charge(&self, last: Node) -> Charge {
        let Charges { to_a, to_b, anew } = self.charges();
        // What leaks beside B pulls A along as far as B has sagged.
        let is_wanted = last == Node::B || self.waits_for_b() || self.leak.siemens().is_some();
        let is_within = |time: Nanos| self.b_charged.is_some_and(|at| self.asked - at < time);
        match is_wanted {
            _ if self.settings.kind.last() == Node::A => to_a,
            // Beside what leaks at B it would begin where the discharge before it has left it.
            true if self.b_is_kept && is_within(B_FORGOTTEN) && !self.leak.is_at_b() => to_b,
            false if is_within(B_LEFT_ALONE) => to_a,
            _ => anew,
        }
    }

    /// How to charge on this board: never shorter than by nominal values, and longer where its capacitors or pins are slower.
    fn charges(&self) -> Charges {
        let longer = ((self.slower().unwrap_or(1.0) - 1.0) / CHARGE_STEP).round() * CHARGE_STEP;
        if longer > 0.0 {
            self.settings.charge.times(1.0 + longer.min(MOST_LONGER))
        } else {
            self.settings.charge
        }
    }

    /// The time constant of charges in parts of the nominal one; `None` as long as it is not known.
    fn slower(&self) -> Option<f64> {
        let [r_charge, r_o] = self.settings.charge_ohm?;
        let ((c1, c2), r_o_ohm) = (self.estimator.calibration()?, self.estimator.r_o_ohm()?);
        let [r1, r2] = self.settings.r_ohm();
        let of_capacitors = (c2[0]? - c1[0]?) / (r2 - r1) / (self.settings.nominal.as_ns() / (r1 + r_o));
        Some(of_capacitors * (1.0 + (r_o_ohm - r_o) / r_charge))
    }

    /// Whether the sensors' discharges wait for B.
    fn waits_for_b(&self) -> bool {
        let settings = &self.settings;
        let is_planned = settings.method.is_tracked() && self.estimator.tracker().is_some();
        let mut choices = self.memory.iter().filter_map(|memory| memory.choice);
        if is_planned { choices.any(|choice| choice.last == Node::B) } else { settings.last() == Node::B }
    }

    /// Before A crosses, however large d is: by the difference of crossings, in which d cancels, and without Ro, which would
    /// make it later.
    fn split_time(&self) -> Option<Nanos> {
        let (c1, c2) = self.estimator.calibration()?;
        let [r1, r2] = self.settings.r_ohm();
        let pays = self.late_split_pays() > CALIBRATION_PAYS;
        let followed_ns = self.estimator.tracker().and_then(|tracker| tracker.elsewhere_ns(pays));
        let elsewhere_ns = followed_ns.or_else(|| self.late_round_ns());
        let usual_ns = SPLIT_FRACTION * (c2[0]? - c1[0]?) / (r2 - r1) * r1;
        Some(Nanos(elsewhere_ns.unwrap_or(usual_ns) as i64))
    }

    /// The same of a round of split calibration that is to switch as late as it can, ns, once d is known: the call is over before A
    /// crosses.
    fn late_round_ns(&self) -> Option<f64> {
        self.split.as_ref().filter(|split| split.is_next_late())?;
        let (offset, (c1, _)) = (self.estimator.offset(), self.estimator.calibration()?);
        let first_ns = c1[0]? - offset.d_ns;
        let at_ns = latest_ns(first_ns, self.estimator.noise())?.min(first_ns - self.calls.longest_ns());
        (!offset.is_prior && is_late(at_ns, first_ns)).then_some(at_ns)
    }

    /// When to switch from the sensor to R_2, if the next x discharge of a channel is to be switched at all.
    fn switch_time(&self, channel: usize) -> Option<Nanos> {
        if !self.offset_is_known() {
            return None;
        }
        let (settings, memory) = (&self.settings, &self.memory[channel]);
        let (x_ns, predicted) = self.predicted(channel)?;
        let d_ns = self.estimator.offset().d_ns;
        let wanted = match settings.t_l {
            Some(t_l) => x_ns - d_ns < t_l.as_ns(),
            None => predicted.is_some_and(|Predicted { direct, inferred, .. }| {
                prefers_inferred(memory.inferred, direct, inferred)
            }),
        };
        let crosses_ns = self.estimator.x_discharge_ns(x_ns, 0)? - d_ns;
        let after = (settings.switch_fraction * crosses_ns).min(crosses_ns - self.calls.longest_ns());
        (wanted && after >= 1.0).then_some(Nanos(after as i64))
    }

    /// When A is expected to cross in the next x discharge of a channel, and how well either branch would tell R_x.
    fn predicted(&self, channel: usize) -> Option<(f64, Option<Predicted>)> {
        let u_switch_ns = self.memory[channel].u_switch_ns;
        let (ratio, [x_ns, _]) = self.through_sensor(channel)?;
        Some((x_ns?, self.estimator.predict(ratio, self.settings.switch_fraction, u_switch_ns)))
    }

    /// Where the last resistance of a channel is, from R_1 to R_2, and when nodes cross in a plain discharge through it, ns.
    pub(super) fn through_sensor(&self, channel: usize) -> Option<(f64, Crossings)> {
        let [r1, r2] = self.settings.r_ohm();
        let ratio = (self.memory[channel].r_ohm? - r1) / (r2 - r1);
        let (c1, c2) = self.estimator.calibration()?;
        Some((ratio, [0, 1].map(|node| Some(c1[node]? + ratio * (c2[node]? - c1[node]?)))))
    }

    /// Whether a reading that is switched, or would be if the offset were known exactly, owes more than a set share of its
    /// variance to the offset.
    pub(super) fn offset_is_poor(&self) -> bool {
        let d_ns = self.estimator.offset().d_ns;
        (0..self.memory.len()).filter_map(|channel| self.predicted(channel)).any(|(x_ns, predicted)| {
            let Some(Predicted { direct, inferred, by_offset }) = predicted else { return false };
            let wanted = match self.settings.t_l {
                Some(t_l) => x_ns - d_ns < t_l.as_ns(),
                None => inferred - by_offset < direct,
            };
            wanted && by_offset > OFFSET_SHARE * inferred
        })
    }

    /// The x discharge that pays best.
    fn best(&mut self, channel: usize) -> Option<Choice> {
        let memory = &self.memory[channel];
        let terms = Terms {
            r_ohm: memory.r_ohm?,
            restless: memory.restless,
            u_switch_ns: memory.u_switch_ns,
            call_ns: self.calls.longest_ns(),
            before_ns: self.before_ns(),
            deadline_ns: self.settings.deadline.as_ns(),
            mean_ns: self.settings.average.map_or(0.0, Nanos::as_ns),
            second: self.settings.second(),
            nodes: self.settings.nodes(),
        };
        let choice = choice::best(&self.estimator, &terms, memory.choice);
        self.memory[channel].choice = choice;
        choice
    }

    /// What goes before a discharge that waits for A, and for B, ns.
    fn before_ns(&self) -> [f64; 2] {
        let Charges { to_a, to_b, .. } = self.charges();
        [to_a, to_b].map(|charge| (charge.time() + self.settings.settle).as_ns() + self.overhead_ns)
    }

    /// The calibration discharge that lowers the variance of what is published most for its time, if any pays.
    pub(super) fn wanted(&self) -> Option<(CalibrationKind, Node)> {
        let tracker = self.estimator.tracker()?;
        // Whether it was a spike, another one of the same kind tells.
        if self.doubted.is_some() {
            return self.doubted;
        }
        let dependences = || self.memory.iter().filter_map(|memory| memory.dependence);
        let readings = self.readings();
        let before_ns = self.before_ns();
        let all = CalibrationKind::ALL
            .into_iter()
            .flat_map(|kind| Node::BOTH[..self.settings.nodes()].iter().map(move |last| (kind, *last)));
        let value = |(kind, last): (CalibrationKind, Node)| {
            let gain = tracker.planned_gain(kind, last);
            let relative = |(by_state, own): (State, f64)| {
                let common = tracker.variance(&by_state);
                let lasts_ns = 1e9 * common / tracker.growth(&by_state);
                let lowered = gain.as_ref().map_or(0.0, |gain| gain.lowers(&by_state));
                lowered / (own / readings + common) * lasts_ns
            };
            let takes_ns = tracker.planned(kind).crossing(tracker.state(), last.index()).ns;
            let channels = self.memory.len() as f64;
            dependences().map(relative).sum::<f64>() / channels / (before_ns[last.index()] + takes_ns)
        };
        let (best, pays) =
            all.map(|discharge| (discharge, value(discharge))).max_by(|a, b| a.1.total_cmp(&b.1))?;
        let is_startled =
            self.memory.iter().any(|memory| memory.is_startled || memory.outliers >= OUTLIERS_OF_DOUBT);
        // How noisy all is has to be known, too, before a plan can trust it: each kind of discharge in turn.
        let is_older = |at: Option<Nanos>, pause| at.is_none_or(|at| self.asked - at > pause);
        let is_due = |pause| is_older(self.calibrated_at.into_iter().flatten().max(), pause);
        if self.young < YOUNG && (self.since_calibration >= YOUNG_EVERY || is_due(YOUNG_PAUSE)) {
            let kind = CalibrationKind::ALL[self.young as usize % 3];
            return Some((kind, best.1));
        }
        let longest = if is_startled { LONGEST_IDLE } else { LONGEST_UNSEEN };
        let unseen = CalibrationKind::ALL
            .into_iter()
            .find(|kind| is_older(self.calibrated_at[*kind as usize], longest));
        if let Some(kind) = unseen {
            return Some((kind, best.1));
        }
        if pays > CALIBRATION_PAYS || is_startled || is_due(LONGEST_IDLE) {
            return Some(best);
        }
        (self.late_split_pays() > CALIBRATION_PAYS).then_some((CalibrationKind::Split, Node::A))
    }

    /// How many readings there are in what is published: of a mean, what each has of its own is less.
    fn readings(&self) -> f64 {
        self.settings.average.map_or(1.0, |time| (time.as_ns() / self.cycle_ns).max(1.0))
    }

    /// What a split discharge that switches late is worth for its time: it shows what the law leaves out, which is in the
    /// uncertainty of readings as far as nothing excludes it.
    fn late_split_pays(&self) -> f64 {
        let Some(tracker) = self.estimator.tracker() else { return 0.0 };
        let relative = |memory: &Memory| {
            let ((by_state, own), r_ohm) = (memory.dependence?, memory.r_ohm?);
            // What moves is followed, not waited for, and is uncertain by more than that.
            if memory.restless * r_ohm > BEYOND_NOISE * own.sqrt() {
                return None;
            }
            let [hidden, lowered] = tracker.hidden_elsewhere(r_ohm)?;
            Some(lowered / (own / self.readings() + tracker.variance(&by_state) + hidden))
        };
        let all: f64 = self.memory.iter().filter_map(relative).sum();
        let ends_ns = tracker.planned(CalibrationKind::Split).crossing(tracker.state(), 0).ns;
        let takes_ns = self.before_ns()[0] + ends_ns;
        all / self.memory.len() as f64 * SHOWN_LASTS.as_ns() / takes_ns
    }
}

fn prefers_inferred(in_use: bool, direct: f64, inferred: f64) -> bool {
    if in_use { HYSTERESIS * inferred < direct } else { inferred < HYSTERESIS * direct }
}
