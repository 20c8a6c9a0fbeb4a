//! The circuit with one capacitor: what a second crossing does not check.

use crate::common::Errors;
use crate::common::chance::Verdict;
use crate::paper::Parts;
use crate::scenario::{Board, Scenario, is_true, percent, rms};
use cermd::pins::sim::Kind;
use cermd::pins::sim::scene::{DelayScene, DriftScene};
use cermd::reading::Method;
use cermd::units::Seconds;

const METHODS: [Method; 2] = [Method::Tpcm, Method::Tracked];
const SENSORS: [f64; 3] = [100.0, 1000.0, 16_200.0];

fn board() -> Board {
    Board { kind: Some(Kind::OneCapacitor), ..Board::quiet(Parts::PI4) }
}

/// A row whose numbers are true at each of the resistances.
fn row(title: &'static str, board: &Board, why: &str) -> Scenario {
    let mut it = Scenario::new(title, "the numbers are true at 100 ohm, 1 kohm and 16.2 kohm", "0..20");
    for method in METHODS {
        let (mut all, mut holds, mut figures) = (Errors::default(), Verdict::from(true), Vec::new());
        for r_ohm in SENSORS {
            let errors = board.errors(method, r_ohm, 20, 200);
            holds = holds & is_true(&errors);
            figures.push(percent(rms(&errors) / r_ohm));
            all.add_board(errors);
        }
        let figure = format!("error {}, {:.0} % in 2u", figures.join(", "), 100.0 * all.coverage());
        it.cell(method, figure, holds, true);
    }
    it.why = why.to_owned();
    it
}

pub fn alone() -> Scenario {
    row(
        "One capacitor, 470 nF, one charger, one sense line",
        &board(),
        "a planned switch and a tracked calibration need no second node.",
    )
}

pub fn drifting() -> Scenario {
    let mut board = board();
    board.scene.drift = Some(DriftScene { c_per_minute: 0.01, ..DriftScene::default() });
    row("One capacitor, which drifts by 1 %/min", &board, "as with two: the tracked calibration follows.")
}

pub fn spikes() -> Scenario {
    let mut board = board();
    board.scene.stamps = board.scene.stamps.map(|stamps| DelayScene {
        tail_probability: Some(0.01),
        tail_mean: Some(Seconds(200e-6)),
        ..stamps
    });
    row(
        "One capacitor, 1 % of stamps late by another 200 us",
        &board,
        "a late stamp contradicts nothing within its discharge: what is far from the reading before is `moving`, what is not is a \
         number that is off by less than that.",
    )
}
