//! Dielectric absorption: beside each capacitor branches of a resistor and a capacitor in series, the Debye model.
//!
//! With x the voltages across all capacitors, those of branches included, C dx/dt = s - K x, and the matrix K of
//! conductances is symmetric. So, in the coordinates sqrt(C) x, the modes are orthogonal and decay with real rates, as
//! those of the plain circuit, and there is one for each capacitor.

use super::{Flow, Load, SimCircuit};
use crate::circuit::Network;
use crate::pins::limits::{MOST_BRANCHES, MOST_SWEEPS};
use crate::pins::sim::waveform::Waveform;

/// One for each capacitor and each branch.
const MODES: usize = 2 + 2 * MOST_BRANCHES;

type Matrix = [[f64; MODES]; MODES];

/// Every capacitor of the circuit: C_A (or the only one), C_B if there is one, the branches of C_A, those of C_B.
struct Dense {
    count: usize,
    farad: [f64; MODES],
    voltage: [f64; MODES],
    /// What flows into each at the start, ampere.
    current: [f64; MODES],
    conductance: Matrix,
}

impl SimCircuit {
    /// How the nodes go on; branches that were not there before begin at the voltage of their capacitor.
    pub(super) fn absorbing(&self, start: [f64; 2], branches: &[f64], a: Load, b: Load) -> Flow {
        let (dense, mains) = self.dense(start, branches, a, b);
        let (rates, shapes) = dense.modes();
        let waveform = |start, slope_of: &dyn Fn(usize) -> f64| {
            Waveform::of_many(start, (0..dense.count).map(|mode| (rates[mode], slope_of(mode))).collect())
        };
        let of_capacitor = |i: usize| waveform(dense.voltage[i], &|mode: usize| shapes[mode][i]);
        let nodes = match mains {
            1 => [of_capacitor(0), Waveform::of_many(start[1], Vec::new())],
            _ => [waveform(start[0], &|mode: usize| shapes[mode][0] + shapes[mode][1]), of_capacitor(1)],
        };
        Flow { nodes, branches: (mains..dense.count).map(of_capacitor).collect() }
    }

    fn dense(&self, start: [f64; 2], branches: &[f64], a: Load, b: Load) -> (Dense, usize) {
        let mut dense = Dense {
            count: 0,
            farad: [0.0; MODES],
            voltage: [0.0; MODES],
            current: [0.0; MODES],
            conductance: [[0.0; MODES]; MODES],
        };
        let (i_a, i_b) = (a.current(start[0]), b.current(start[1]));
        match self.network {
            Network::OneCapacitor { c } | Network::SeriesCalibration { c } => {
                dense.add(c.0, start[0], i_a, a.conductance);
            }
            Network::TwoCapacitor { c_a, c_b } => {
                dense.add(c_a.0, start[0] - start[1], i_a, a.conductance);
                dense.add(c_b.0, start[1], i_a + i_b, a.conductance + b.conductance);
                (dense.conductance[0][1], dense.conductance[1][0]) = (a.conductance, a.conductance);
            }
        }
        let mains = dense.count;
        let all = (0..mains).flat_map(|main| self.absorption[main].iter().map(move |branch| (main, branch)));
        let is_known = branches.len() == all.clone().count();
        for (index, (main, branch)) in all.enumerate() {
            let farad = branch.share * dense.farad[main];
            let siemens = farad / branch.tau;
            let voltage = if is_known { branches[index] } else { dense.voltage[main] };
            let ampere = siemens * (dense.voltage[main] - voltage);
            let own = dense.count;
            dense.add(farad, voltage, ampere, siemens);
            dense.current[main] -= ampere;
            dense.conductance[main][main] += siemens;
            (dense.conductance[main][own], dense.conductance[own][main]) = (-siemens, -siemens);
        }
        (dense, mains)
    }
}

impl Dense {
    fn add(&mut self, farad: f64, voltage: f64, ampere: f64, siemens: f64) {
        let i = self.count;
        (self.farad[i], self.voltage[i], self.current[i]) = (farad, voltage, ampere);
        self.conductance[i][i] = siemens;
        self.count += 1;
    }

    /// The rates, the fastest first, and of each mode its slope at every capacitor, V/s.
    fn modes(&self) -> ([f64; MODES], Matrix) {
        let n = self.count;
        let roots = self.farad.map(f64::sqrt);
        let mut matrix = self.conductance;
        for (i, row) in matrix.iter_mut().enumerate().take(n) {
            for (j, value) in row.iter_mut().enumerate().take(n) {
                *value /= roots[i] * roots[j];
            }
        }
        let vectors = diagonalise(&mut matrix, n);
        let mut order: [usize; MODES] = std::array::from_fn(|i| i);
        order[..n].sort_by(|i, j| matrix[*j][*j].total_cmp(&matrix[*i][*i]));
        let (mut rates, mut shapes) = ([0.0; MODES], [[0.0; MODES]; MODES]);
        for (mode, &k) in order[..n].iter().enumerate() {
            rates[mode] = matrix[k][k].max(0.0);
            let along: f64 = (0..n).map(|i| vectors[i][k] * self.current[i] / roots[i]).sum();
            for i in 0..n {
                shapes[mode][i] = along * vectors[i][k] / roots[i];
            }
        }
        (rates, shapes)
    }
}

/// Jacobi's method: turns the symmetric matrix of `n` rows into its eigenvalues, and answers the eigenvectors, one a column.
fn diagonalise(matrix: &mut Matrix, n: usize) -> Matrix {
    let mut vectors = [[0.0; MODES]; MODES];
    for (i, row) in vectors.iter_mut().enumerate() {
        row[i] = 1.0;
    }
    for _ in 0..MOST_SWEEPS {
        let mut is_diagonal = true;
        for p in 0..n {
            for q in p + 1..n {
                let coupling = matrix[p][q];
                if coupling.abs() <= f64::EPSILON * (matrix[p][p] * matrix[q][q]).abs().sqrt() {
                    continue;
                }
                is_diagonal = false;
                let theta = (matrix[q][q] - matrix[p][p]) / (2.0 * coupling);
                let tan = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
                let cos = 1.0 / (tan * tan + 1.0).sqrt();
                turn(matrix, &mut vectors, n, (p, q), (cos, tan * cos));
            }
        }
        if is_diagonal {
            break;
        }
    }
    vectors
}

/// Rotates rows and columns p and q.
fn turn(matrix: &mut Matrix, vectors: &mut Matrix, n: usize, (p, q): (usize, usize), (cos, sin): (f64, f64)) {
    let rotate = |x: f64, y: f64| (cos * x - sin * y, sin * x + cos * y);
    for row in matrix.iter_mut().take(n).chain(vectors.iter_mut().take(n)) {
        (row[p], row[q]) = rotate(row[p], row[q]);
    }
    let (at_p, at_q) = (matrix[p], matrix[q]);
    matrix[p] = std::array::from_fn(|j| rotate(at_p[j], at_q[j]).0);
    matrix[q] = std::array::from_fn(|j| rotate(at_p[j], at_q[j]).1);
    (matrix[p][q], matrix[q][p]) = (0.0, 0.0);
}
