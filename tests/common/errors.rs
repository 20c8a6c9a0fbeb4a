//! Errors of readings against the truth, and what is said of them, board by board.

use super::chance::{Figure, mean_of, of_boards};
use super::name_of;
use cermd::characterize::watch::{Deviation, Found};
use cermd::reading::{Branch, Reading, Status};

fn mean_square(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64
}

/// The root mean square.
pub fn rms(values: &[f64]) -> f64 {
    mean_square(values).sqrt()
}

/// Errors of readings against the truth.
#[derive(Debug, Clone, Default)]
pub struct Errors {
    pub errors: Vec<f64>,
    pub us: Vec<f64>,
    pub inferred: usize,
    pub without_u: usize,
    /// Of each error, whether its reading says that the sensor moves.
    pub moving: Vec<bool>,
    /// How many say that they settle.
    pub settling: usize,
    /// Numbers off by more than ten of their sigma that neither move nor settle.
    pub wild: usize,
    /// States, of faults their names.
    pub not_ok: Vec<&'static str>,
    /// Where the errors of each board begin.
    boards: Vec<usize>,
}

impl Errors {
    /// Those of a cell, one board after the other.
    pub fn of(found: &[Found]) -> Errors {
        let mut all = Errors::default();
        for board in found {
            all.next_board();
            for told in &board.told {
                match told.what {
                    Ok(Deviation { u_ohm: None, .. }) => all.without_u += 1,
                    Ok(Deviation { error_ohm, u_ohm: Some(u_ohm), is_moving, .. }) => {
                        all.errors.push(error_ohm);
                        all.us.push(u_ohm);
                        all.moving.push(is_moving);
                    }
                    Err(state) => all.not_ok.push(state),
                }
            }
        }
        all
    }

    /// What is added from now on is of another board, whose errors have nothing to do with those before.
    pub fn next_board(&mut self) {
        self.boards.push(self.errors.len());
    }

    /// Adds the errors of another board.
    pub fn add_board(&mut self, board: Errors) {
        self.next_board();
        self.errors.extend(board.errors);
        self.us.extend(board.us);
        self.moving.extend(board.moving);
        self.not_ok.extend(board.not_ok);
        self.inferred += board.inferred;
        self.without_u += board.without_u;
        self.settling += board.settling;
        self.wild += board.wild;
    }

    /// Something of the errors of all boards together.
    pub fn together(&self, of: impl Fn(&[f64]) -> f64) -> Figure {
        let boards: Vec<&[f64]> = self.by_boards().map(|(errors, _)| errors).collect();
        of_boards(&boards, of)
    }

    /// Errors and uncertainties of each board that has any.
    fn by_boards(&self) -> impl Iterator<Item = (&[f64], &[f64])> {
        let ends = self.boards.iter().skip(1).copied().chain([self.count()]);
        let boards = self.boards.iter().copied().zip(ends).filter(|(from, to)| from < to);
        boards.map(|(from, to)| (&self.errors[from..to], &self.us[from..to]))
    }

    /// The mean over boards of something of each, from its errors and its uncertainties.
    pub fn by_board(&self, of: impl Fn(&[f64], &[f64]) -> f64) -> Figure {
        mean_of(&self.by_boards().map(|(errors, us)| of(errors, us)).collect::<Vec<_>>())
    }

    /// The share of readings within two of their own sigma.
    pub fn within_2u(&self) -> Figure {
        let by_board = self.by_board(|errors, us| {
            let hits = errors.iter().zip(us).filter(|(error, u)| error.abs() <= 2.0 * **u).count();
            hits as f64 / errors.len() as f64
        });
        // Boards have more numbers and fewer: the share is that of all of them, its error that of the boards.
        Figure { value: self.coverage(), ..by_board }
    }

    /// The root mean square error, of what is predicted.
    pub fn rms_ratio(&self, predicted: f64) -> Figure {
        self.by_board(|errors, _| mean_square(errors)).sqrt().times(1.0 / predicted)
    }

    /// The root mean square of errors in their own sigma.
    pub fn pulls(&self) -> Figure {
        let pulls =
            |errors: &[f64], us: &[f64]| errors.iter().zip(us).map(|(e, u)| e / u).collect::<Vec<_>>();
        self.by_board(|errors, us| mean_square(&pulls(errors, us))).sqrt()
    }

    pub fn mean_error(&self) -> Figure {
        let by_board = self.by_board(|errors, _| errors.iter().sum::<f64>() / errors.len() as f64);
        Figure { value: self.mean(), ..by_board }
    }

    pub fn add(&mut self, reading: &Reading, truth: f64) {
        match reading.status {
            Status::Ok { branch, r_ohm, is_moving, is_settling, .. } => {
                let Some(u) = r_ohm.u else {
                    self.without_u += 1;
                    return;
                };
                self.errors.push(r_ohm.value - truth);
                self.us.push(u);
                self.moving.push(is_moving);
                self.settling += usize::from(is_settling);
                let is_wild = !is_moving && !is_settling && (r_ohm.value - truth).abs() > 10.0 * u;
                self.wild += usize::from(is_wild);
                self.inferred += usize::from(branch == Branch::Inferred);
            }
            Status::Fault(fault) => self.not_ok.push(fault.as_str()),
            status => self.not_ok.push(name_of(&status)),
        }
    }

    /// Without the readings that say that the sensor moves: these are counted as states.
    pub fn at_rest(&self) -> Errors {
        let mut rest = Errors { not_ok: self.not_ok.clone(), ..Errors::default() };
        let mut boards = self.boards.iter().peekable();
        for (index, is_moving) in self.moving.iter().enumerate() {
            while boards.next_if(|first| **first <= index).is_some() {
                rest.next_board();
            }
            if *is_moving {
                rest.not_ok.push("moving");
            } else {
                rest.errors.push(self.errors[index]);
                rest.us.push(self.us[index]);
                rest.moving.push(false);
            }
        }
        rest
    }

    pub fn count(&self) -> usize {
        self.errors.len()
    }

    pub fn mean(&self) -> f64 {
        self.errors.iter().sum::<f64>() / self.count() as f64
    }

    pub fn sd(&self) -> f64 {
        let mean = self.mean();
        (self.errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / (self.count() - 1) as f64).sqrt()
    }

    /// Half the width that the middle 68.27 % of the errors take: what one spike of a thousand does not change.
    pub fn spread(&self) -> f64 {
        spread_of(&self.errors)
    }

    pub fn max(&self) -> f64 {
        self.errors.iter().fold(0.0, |max, e| e.abs().max(max))
    }

    pub fn mean_u(&self) -> f64 {
        rms(&self.us)
    }

    /// The share of readings within two of their own sigma.
    pub fn coverage(&self) -> f64 {
        let within = self.errors.iter().zip(&self.us).filter(|(e, u)| e.abs() <= 2.0 * **u).count();
        within as f64 / self.count() as f64
    }
}

/// See [`Errors::spread`].
pub fn spread_of(errors: &[f64]) -> f64 {
    let mut errors = errors.to_vec();
    errors.sort_by(f64::total_cmp);
    let at = |share: f64| errors[(share * (errors.len() - 1) as f64) as usize];
    (at(0.841_345) - at(0.158_655)) / 2.0
}
