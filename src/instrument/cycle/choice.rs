//! Which x discharge lowers the variance of what is published most for its time: one rule, whatever the resistance.
//!
//! Considered are full discharges and switched ones: where they are switched, to R_2 or to R_1, and whether they wait for A or
//! for B. Each is priced by variance times time. For single readings that is the whole variance; of a mean over a time W, what
//! discharges have in common does not average, so that it is `own T + common W` there. All 38 of two nodes take 16 us to price on
//! one core of a server, the 19 of one node 8 us.

use crate::circuit::Node;
use crate::estimate::Estimator;
use crate::estimate::law::{D, Route, d_ns};
use crate::estimate::method::tracked::Solution;
use crate::instrument::limits::{CHATTER, CLEAR_NS, RESTLESS, SHORTEST_TAIL_NS, SWITCH_FRACTIONS};
use crate::record::{Switch, Through};
use crate::units::Nanos;

/// What is given for a choice. Times in ns.
#[derive(Debug, Clone, Copy)]
pub struct Terms {
    /// The resistance to be expected, zero included, ohm.
    pub r_ohm: f64,
    /// By how much it may be another, relative.
    pub restless: f64,
    /// 1 sigma of a switch by the length of calls.
    pub u_switch_ns: f64,
    /// How long a call usually takes that releases the sensor: a line moves anywhere in it.
    pub call_ns: f64,
    /// What goes before a discharge that waits for A, or for B; calls and waking included.
    pub before_ns: [f64; 2],
    /// The longest discharge through the sensor.
    pub deadline_ns: f64,
    /// What is published is the mean over this time; 0: each reading.
    pub mean_ns: f64,
    /// What R_2 discharges through.
    pub second: Through,
    /// The nodes there are.
    pub nodes: usize,
}

/// An x discharge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Choice {
    /// When it is switched, ns, and to what; `None`: never.
    pub switch: Option<(f64, Through)>,
    /// The node that it waits for.
    pub last: Node,
    /// Where in the list of what is considered it stands.
    index: usize,
    /// Variance times time, ohm² ns.
    pub price: f64,
}

impl Choice {
    /// After how long to switch, and to what.
    pub fn planned(&self) -> Option<(Nanos, Through)> {
        self.switch.filter(|(at_ns, _)| *at_ns >= 1.0).map(|(at_ns, to)| (Nanos(at_ns as i64), to))
    }
}

/// The best for what is given; that which is `in_use` stays while another is hardly better. `None` without a tracked state.
pub fn best(estimator: &Estimator, terms: &Terms, in_use: Option<Choice>) -> Option<Choice> {
    let is_in_use = |choice: &Choice| in_use.is_some_and(|used| used.index == choice.index);
    let priced = considered(terms).filter_map(|choice| priced(estimator, terms, choice)).map(|choice| {
        let factor = if is_in_use(&choice) { CHATTER } else { 1.0 };
        (factor * choice.price, choice)
    });
    priced.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, choice)| choice)
}

/// Everything that could be done: switches as a fraction of the time in which the last node crosses.
fn considered(terms: &Terms) -> impl Iterator<Item = (usize, Node, Option<(f64, Through)>)> {
    let resistors = [terms.second, Through::C1];
    let ends = &Node::BOTH[..terms.nodes];
    let switches = resistors.into_iter().flat_map(|to| SWITCH_FRACTIONS.map(|fraction| Some((fraction, to))));
    let each = std::iter::once(None).chain(switches);
    ends.iter()
        .flat_map(move |last| each.clone().map(move |switch| (*last, switch)))
        .enumerate()
        .map(|(index, (last, switch))| (index, last, switch))
}

fn priced(
    estimator: &Estimator,
    terms: &Terms,
    (index, last, switch): (usize, Node, Option<(f64, Through)>),
) -> Option<Choice> {
    let tracker = estimator.tracker()?;
    let (state, node) = (tracker.state(), last.index());
    let crosses = |node: usize, switch| {
        let route = Route { first_ohm: terms.r_ohm, switch };
        route.crossing(state, node).ns - d_ns(state, node)
    };
    let full_ns = crosses(node, None);
    let planned = match switch {
        // Finished through R_1 when the deadline has come.
        None if full_ns > terms.deadline_ns => Some((terms.deadline_ns, Through::C1)),
        None => None,
        // A node that crosses within the call has crossed through one resistor or the other, and its interrupt waits for the end.
        Some((fraction, to)) => {
            Some(((fraction * full_ns.min(terms.deadline_ns)).min(full_ns - terms.call_ns), to))
        }
    };
    let made = planned.map(|(at_ns, to)| {
        let switch = Switch { at_ns, on_ns: at_ns, to };
        (switch, estimator.ohm_after(switch))
    });
    let takes_ns = crosses(node, made);
    if let Some((at_ns, _)) = planned {
        let is_early_enough = at_ns <= (1.0 - RESTLESS * terms.restless) * full_ns;
        // The interrupt of A's crossing delays a call that comes then.
        let a_ns = crosses(0, None);
        let doubt_ns = CLEAR_NS + RESTLESS * terms.restless * a_ns;
        let is_clear = last == Node::A || !(a_ns - doubt_ns..=a_ns + state[D] + doubt_ns).contains(&at_ns);
        if !is_early_enough || !is_clear || takes_ns - at_ns < SHORTEST_TAIL_NS {
            return None;
        }
    }
    let switch_made = made.map(|(switch, _)| switch);
    let found = estimator.predict_tracked(terms.r_ohm, switch_made, terms.u_switch_ns, last)?;
    let takes_ns = terms.before_ns[node] + takes_ns;
    let switch = switch.and(planned);
    Some(Choice { switch, last, index, price: price(&found, takes_ns, terms.mean_ns) })
}

/// Variance times time.
fn price(found: &Solution, takes_ns: f64, mean_ns: f64) -> f64 {
    let common = (found.variance - found.bound).max(0.0);
    found.bound * takes_ns + common * takes_ns.max(mean_ns)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config_file::config;
    use crate::instrument::Instrument;
    use crate::pins::Pins;
    use crate::pins::sim::{Scene, SimPins};

    /// An instrument that has found its state, on another board each.
    fn settled(seed: u64) -> Instrument<SimPins> {
        let config = config(|c| c.set("circuit.v-th", "1.1 V").channel("x").set("mock.scene", "pi4")).parse();
        let pins = SimPins::new(&Scene::builtin("pi4").unwrap(), Some(crate::seed::seed(seed)));
        let mut instrument = Instrument::new(pins, config.settings().unwrap());
        while instrument.pins().now() < Nanos(3_000_000_000) {
            instrument.step(&mut |_| {}).unwrap();
        }
        instrument
    }

    fn terms(r_ohm: f64, mean_ns: f64) -> Terms {
        Terms {
            r_ohm,
            restless: 1e-3,
            u_switch_ns: 300.0,
            call_ns: 1500.0,
            before_ns: [1.2e6, 1.5e6],
            deadline_ns: 60e6,
            mean_ns,
            second: Through::C2,
            nodes: 2,
        }
    }

    #[test]
    fn what_is_chosen_is_hardly_worse_than_the_best_of_all() {
        for seed in 0..4 {
            let instrument = settled(seed);
            let estimator = instrument.cycle().estimator();
            for r_ohm in [30.0, 100.0, 300.0, 1000.0, 3000.0, 5000.0, 10_000.0, 16_200.0, 30_000.0, 100_000.0]
            {
                for mean_ns in [0.0, 1e8, 1e9] {
                    let terms = terms(r_ohm, mean_ns);
                    let chosen = best(estimator, &terms, None).unwrap();
                    let each = Node::BOTH.into_iter().flat_map(|last| {
                        [Through::C1, Through::C2].into_iter().flat_map(move |to| {
                            (1..995).map(move |part| (0, last, Some((f64::from(part) / 1000.0, to))))
                        })
                    });
                    let all = each.chain(Node::BOTH.map(|last| (0, last, None)));
                    let prices = all.filter_map(|one| priced(estimator, &terms, one)).map(|one| one.price);
                    let least = prices.fold(f64::INFINITY, f64::min);
                    assert!(
                        chosen.price <= 1.15 * least,
                        "{r_ohm} ohm, mean over {mean_ns} ns: {chosen:?} against {least:e}, seed {seed}"
                    );
                }
            }
        }
    }

    #[test]
    fn what_is_in_use_stays_while_another_is_hardly_better() {
        let instrument = settled(9);
        let mut used = None;
        let mut changes = 0;
        for step in 0..200 {
            // To and fro about where another plan becomes the better one.
            let r_ohm = 1000.0 * (1.0 + 0.02 * f64::from(step % 2));
            let terms = terms(r_ohm, 0.0);
            let choice = best(instrument.cycle().estimator(), &terms, used).unwrap();
            changes += u32::from(used.is_some_and(|used: Choice| used.index != choice.index));
            used = Some(choice);
        }
        assert!(changes <= 1, "{changes} changes");
    }

    /// With long calls, where A crosses soon after the start, that is before most of what is considered.
    #[test]
    fn the_call_of_a_switch_is_over_before_the_node_crosses() {
        let instrument = settled(5);
        let estimator = instrument.cycle().estimator();
        let state = estimator.tracker().unwrap().state();
        let mut switched = 0;
        for call_ns in [1000.0, 7000.0, 20_000.0] {
            for r_ohm in [0.0, 10.0, 30.0, 50.0, 70.0, 100.0, 200.0, 1000.0] {
                let terms = Terms { call_ns, ..terms(r_ohm, 0.0) };
                let Some(Choice { switch: Some((at_ns, _)), last, .. }) = best(estimator, &terms, None)
                else {
                    continue;
                };
                let node = last.index();
                let full_ns =
                    Route { first_ohm: r_ohm, switch: None }.crossing(state, node).ns - d_ns(state, node);
                assert!(
                    at_ns + call_ns <= full_ns,
                    "{r_ohm} ohm, calls of {call_ns} ns: at {at_ns}, crosses at {full_ns}"
                );
                switched += 1;
            }
        }
        assert!(switched >= 12, "{switched}");
    }
}
