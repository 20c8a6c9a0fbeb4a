//! Many cells at once, one on each processor.

use super::cell::{Cell, CellError};
use super::table::Row;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

/// Measures cells, in the order of the list as far as processors are free, and hands the rows of each to `done` with its place in
/// the list, until `is_stopped` or an error.
///
/// # Errors
/// The first one, of a cell or of `done`.
pub fn run<E: From<CellError>>(
    cells: &[Cell],
    is_stopped: &(dyn Fn() -> bool + Sync),
    mut done: impl FnMut(usize, Vec<Row>) -> Result<(), E>,
) -> Result<(), E> {
    let (next, failed) = (AtomicUsize::new(0), AtomicBool::new(false));
    let is_over = || failed.load(Ordering::Relaxed) || is_stopped();
    let threads = thread::available_parallelism().map_or(1, usize::from).min(cells.len());
    let (sender, results) = mpsc::channel();
    thread::scope(|scope| {
        for _ in 0..threads {
            let (sender, next, is_over) = (sender.clone(), &next, &is_over);
            scope.spawn(move || {
                while let Some((index, cell)) = take(cells, next).filter(|_| !is_over()) {
                    let rows = cell.measure(is_over).map(|found| Some(cell.rows(&found?)));
                    if sender.send((index, rows)).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        let mut all = results.iter().filter_map(|(index, rows)| Some((index, rows.transpose()?)));
        let result = all.try_for_each(|(index, rows)| done(index, rows?));
        // What the others are at is not wanted any more.
        failed.store(result.is_err(), Ordering::Relaxed);
        result
    })
}

fn take<'a>(cells: &'a [Cell], next: &AtomicUsize) -> Option<(usize, &'a Cell)> {
    let index = next.fetch_add(1, Ordering::Relaxed);
    cells.get(index).map(|cell| (index, cell))
}
