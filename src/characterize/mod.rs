//! Sweeps of whole instruments over resistances and settings, as a tidy table.
//!
//! For: the real instrument on a board, each cell of a sweep with its own circuit, method and effect, its errors against a known
//! truth and what its readings cost in time. Must not know: how a table is drawn, terminals.

pub mod cell;
pub mod change;
pub mod figures;
pub mod folder;
pub mod limits;
pub mod run;
pub mod sweep;
pub mod table;
pub mod watch;
