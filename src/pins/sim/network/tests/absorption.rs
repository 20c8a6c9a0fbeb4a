//! Capacitors whose dielectric absorbs charge.

use super::*;
use crate::units::Farad;

fn branches(of: &[(f64, f64)]) -> Vec<Branch> {
    of.iter().map(|&(share, tau)| Branch { share, tau }).collect()
}

#[test]
fn without_a_share_the_matrix_is_the_closed_form() {
    for network in [
        Network::OneCapacitor { c: Farad(470e-9) },
        Network::TwoCapacitor { c_a: Farad(2.2e-6), c_b: Farad(680e-9) },
        Network::TwoCapacitor { c_a: Farad(1e-6), c_b: Farad(1e-6) },
    ] {
        let mut plain = circuit(network);
        plain.sense[0].to_ground = 1e-6;
        plain.sense[1].to_v_dd = 3e-7;
        let absorbing =
            SimCircuit { absorption: [branches(&[(1e-15, 1e-3)]), branches(&[])], ..plain.clone() };
        for on in [Drives::NONE, Drives::CHARGE, Drives::C1, X.and(Drives::C2)] {
            for start in [[0.0, 0.0], [3.3, 3.3], [1.0, 2.5]] {
                for t in [1e-7, 1e-5, 1e-3, 0.1, 10.0] {
                    let (found, wanted) =
                        (absorbing.flow(start, on).after(t), plain.flow(start, on).after(t));
                    for (found, wanted) in found.into_iter().zip(wanted) {
                        assert!((found - wanted).abs() < 1e-11, "{on} {start:?} {t} s: {found} {wanted}");
                    }
                }
            }
        }
    }
}

/// A capacitor that was charged for ever, is shorted for a while and then left alone recovers: what its branch has kept,
/// V exp(-t / tau), spreads over both.
#[test]
fn a_shorted_capacitor_recovers_what_its_branch_kept() {
    let (share, tau) = (0.025, 10e-3);
    let mut circuit = circuit(Network::OneCapacitor { c: Farad(1e-6) });
    (circuit.r_c1, circuit.r_o) = (1e-6, [1e-6; LINES]);
    circuit.absorption[0] = branches(&[(share, tau)]);
    let shorted = circuit.flow([3.3; 2], Drives::C1);
    assert!(shorted.after(4e-3)[0].abs() < 1e-6);
    let released = circuit.flow_after(&shorted, 4e-3, Drives::NONE);
    let kept = 3.3 * (-0.4f64).exp();
    assert_close(released.after(10.0)[0], kept * share / (1.0 + share), 1e-5);
    // On the way with the time constant of both in series.
    let wanted = kept * share / (1.0 + share) * -(-2e-3 * (1.0 + share) / tau).exp_m1();
    assert_close(released.after(2e-3)[0], wanted, 1e-5);
    // Another discharge finds what this one left.
    let again =
        circuit.flow_after(&circuit.flow_after(&released, 2e-3, Drives::CHARGE_A), 1e-3, Drives::NONE);
    assert!(again.after(1.0)[0] < again.after(0.0)[0], "it is still taking in charge");
}

proptest! {
    #![proptest_config(crate::seed::cases(64))]

    /// Against a Runge-Kutta integration of Kirchhoff's laws with the branches as capacitors of their own; cut in the middle, so
    /// that what the branches hold has to be carried on.
    #[test]
    fn absorbing_capacitors_obey_kirchhoff(
        any in anything(),
        a in prop::collection::vec((1e-4..0.1f64, -1.0..2.0f64), 0..4),
        b in prop::collection::vec((1e-4..0.1f64, -1.0..2.0f64), 0..4),
    ) {
        let Anything { mut circuit, start, on } = any;
        let scale = 1.0 / fastest(&circuit.flow(start, on));
        let sized = |shares: &[(f64, f64)]| -> Vec<(f64, f64)> {
            shares.iter().map(|(share, decades)| (*share, scale * 10f64.powf(*decades))).collect()
        };
        circuit.absorption = [branches(&sized(&a)), branches(&sized(&b))];
        if !circuit.has_b() {
            circuit.absorption[1].clear();
        }
        let half = circuit.flow(start, Drives::NONE);
        let flow = circuit.flow_after(&circuit.flow_after(&half, 0.3 * scale, on), 0.7 * scale, on);
        let found = flow.after(scale);
        let mut state = Kept::new(&circuit, start);
        state.integrate(&circuit, Drives::NONE, 0.3 * scale);
        state.integrate(&circuit, on, 1.7 * scale);
        let wanted = state.nodes(&circuit);
        for i in 0..if circuit.has_b() { 2 } else { 1 } {
            prop_assert!((found[i] - wanted[i]).abs() < 1e-6, "node {}: {} wanted {}", i, found[i], wanted[i]);
        }
        // Every turn is one, and between two of them the voltage is monotone.
        for node in Node::BOTH {
            let waveform = flow.waveform(node);
            let most = waveform.modes().map(|(_, slope)| slope.abs()).fold(0.0, f64::max);
            for turn in waveform.turns() {
                prop_assert!(waveform.slope(turn).abs() <= 1e-9 * most, "{} at {}", waveform.slope(turn), turn);
            }
            let mut sign = waveform.slope(0.0).signum();
            let mut turns = waveform.turns().count();
            for step in 1..400 {
                let slope = waveform.slope(scale * 1e-3 * 1.05f64.powi(step));
                if slope * sign < -1e-9 * most {
                    (sign, turns) = (slope.signum(), turns.checked_sub(1).ok_or_else(|| TestCaseError::fail("a turn is missing"))?);
                }
            }
        }
    }
}

/// The voltages across the capacitors and those of their branches, as Runge-Kutta takes them on.
#[derive(Clone)]
struct Kept {
    mains: [f64; 2],
    branches: [Vec<f64>; 2],
}

impl Kept {
    fn new(circuit: &SimCircuit, [v_a, v_b]: [f64; 2]) -> Kept {
        let mains = if circuit.has_b() { [v_a - v_b, v_b] } else { [v_a, 0.0] };
        Kept { mains, branches: [0, 1].map(|i| vec![mains[i]; circuit.absorption[i].len()]) }
    }

    fn nodes(&self, circuit: &SimCircuit) -> [f64; 2] {
        if circuit.has_b() { [self.mains[0] + self.mains[1], self.mains[1]] } else { self.mains }
    }

    fn slopes(&self, circuit: &SimCircuit, on: Drives) -> Kept {
        let [i_a, i_b] = currents(circuit, on, self.nodes(circuit));
        let (farad, mut into) = match circuit.network {
            Network::TwoCapacitor { c_a, c_b } => ([c_a.0, c_b.0], [i_a, i_a + i_b]),
            Network::OneCapacitor { c } | Network::SeriesCalibration { c } => ([c.0, 1.0], [i_a, 0.0]),
        };
        let mut branches = self.branches.clone();
        for i in 0..2 {
            for (place, branch) in branches[i].iter_mut().zip(&circuit.absorption[i]) {
                let across = self.mains[i] - *place;
                *place = across / branch.tau;
                into[i] -= across * branch.share * farad[i] / branch.tau;
            }
        }
        Kept { mains: [0, 1].map(|i| into[i] / farad[i]), branches }
    }

    fn plus(&self, slopes: &Kept, h: f64) -> Kept {
        let mut sum = self.clone();
        for i in 0..2 {
            sum.mains[i] += h * slopes.mains[i];
            sum.branches[i].iter_mut().zip(&slopes.branches[i]).for_each(|(v, slope)| *v += h * slope);
        }
        sum
    }

    fn integrate(&mut self, circuit: &SimCircuit, on: Drives, seconds: f64) {
        let fastest = 1.0 / seconds + 10.0 * fastest(&circuit.flow([0.0; 2], on));
        let steps = (20.0 * fastest * seconds).ceil();
        let h = seconds / steps;
        for _ in 0..steps as u64 {
            let k1 = self.slopes(circuit, on);
            let k2 = self.plus(&k1, h / 2.0).slopes(circuit, on);
            let k3 = self.plus(&k2, h / 2.0).slopes(circuit, on);
            let k4 = self.plus(&k3, h).slopes(circuit, on);
            for (k, weight) in [(k1, 1.0), (k2, 2.0), (k3, 2.0), (k4, 1.0)] {
                *self = self.plus(&k, weight * h / 6.0);
            }
        }
    }
}
