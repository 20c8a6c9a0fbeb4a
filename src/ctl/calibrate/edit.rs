//! One value of a configuration file, changed in place.
//!
//! Every other byte stays; the new file is checked before it counts, and the old one is kept.

use super::CtlError;
use crate::config::{Config, ForceSource};
use crate::ctl::check;
use crate::estimate::fit::Weighing;
use crate::files;
use crate::sensor::{Force, Law};
use crate::units::{Newton, NewtonOhm, rounded, to_places};
use jiff::Timestamp;
use nix::sys::signal::SigSet;
use std::fs;
use std::path::{Path, PathBuf};
use toml_edit::{DocumentMut, InlineTable, Item, TableLike};

/// What is put into the configuration.
#[derive(Debug)]
pub enum Value {
    /// `zero-ohm`.
    ZeroOhm(f64),
    /// `scale`.
    Scale(f64),
    /// `force`; a table becomes a file beside the configuration.
    Force(Force, Vec<Weighing>),
    /// `tare` of a force that is there; `None` takes it out.
    Tare(Option<f64>),
}

/// Changes a channel of the file, and gives the path of the file as it was.
///
/// # Errors
/// Then the file is as it was.
pub fn update(path: &Path, id: &str, value: &Value) -> Result<PathBuf, CtlError> {
    // A link stays one.
    let real = fs::canonicalize(path).map_err(CtlError::file(path))?;
    let text = files::read_text(&real, files::SETTINGS_BYTES).map_err(CtlError::file(&real))?;
    let (table, kept) = free_names(&real, id);
    let table_name = table.file_name().unwrap_or_default().to_string_lossy();
    let edited = edit(&text, id, value, &table_name)
        .map_err(|reason| CtlError::Said(format!("{}: {reason}; nothing was changed", path.display())))?;
    check_before(&real, &edited, id, value)?;
    // A signal between two of these steps would leave files behind that nobody needs.
    let signals = SigSet::all();
    signals.thread_block().map_err(|errno| CtlError::system("signals")(errno.into()))?;
    let outcome = put(&real, &edited, (value, &table), &kept);
    let _ = signals.thread_unblock();
    outcome.map(|()| kept)
}

/// A name for the file as it was: [`free_names`].
pub fn free_name(path: &Path) -> PathBuf {
    free_names(path, "").1
}

/// Names for the table of a force and for the file as it was, with the second in them (`20261121T034000Z`), and a number if
/// there are such files already.
fn free_names(path: &Path, id: &str) -> (PathBuf, PathBuf) {
    let stamp = Timestamp::now().strftime("%Y%m%dT%H%M%SZ");
    let mut number = 1;
    loop {
        let stamp = if number == 1 { stamp.to_string() } else { format!("{stamp}-{number}") };
        let table = path.with_file_name(format!("force-{}-{stamp}.csv", file_name(id)));
        let mut kept = path.as_os_str().to_owned();
        kept.push(format!(".bak-{stamp}"));
        let kept = PathBuf::from(kept);
        if [&table, &kept].iter().all(|path| fs::symlink_metadata(path).is_err()) {
            return (table, kept);
        }
        number += 1;
    }
}

/// Whether the new text would be usable, before anything is written: with the table that is no file yet.
fn check_before(path: &Path, text: &str, id: &str, value: &Value) -> Result<(), CtlError> {
    let mut config = Config::of_file(text, path);
    let channels = config.iter_mut().flat_map(|config| &mut config.channels);
    let force = channels.filter(|channel| channel.id == id).find_map(|channel| channel.force.as_mut());
    if let (Some(force), Value::Force(Force { law: law @ Law::Table { .. }, .. }, _)) = (force, value) {
        force.law = ForceSource::Given(law.clone());
    }
    let report = check::usable(path, config);
    let refusal = || {
        let errors = report.errors();
        CtlError::Said(format!("nothing was changed, for the configuration would not be usable:\n{errors}"))
    };
    report.is_usable().then_some(()).ok_or_else(refusal)
}

/// Each file is there whole or not at all; if one fails, none is.
fn put(path: &Path, text: &str, (value, table): (&Value, &Path), kept: &Path) -> Result<(), CtlError> {
    let old = fs::metadata(path).map_err(CtlError::file(path))?;
    let table = match value {
        Value::Force(Force { law: Law::Table { .. }, .. }, pairs) => {
            let new = files::beside(table, &csv(pairs), Some(&old)).map_err(CtlError::file(table))?;
            new.persist_noclobber(table).map_err(|error| CtlError::file(table)(error.error))?;
            Some(table)
        }
        _ => None,
    };
    let put = || {
        let new = files::beside(path, text, Some(&old)).map_err(CtlError::file(path))?;
        fs::hard_link(path, kept).map_err(CtlError::file(kept))?;
        new.persist(path).map_err(|error| {
            let _ = fs::remove_file(kept);
            CtlError::file(path)(error.error)
        })
    };
    if let Err(error) = put() {
        let _ = table.map(fs::remove_file);
        return Err(error);
    }
    files::sync_folder(path).map_err(CtlError::file(path))
}

/// The text with one value changed.
fn edit(text: &str, id: &str, value: &Value, table_name: &str) -> Result<String, String> {
    let mut document: DocumentMut = text.parse().map_err(|error| format!("{error}"))?;
    let channels = document.get_mut("channel").ok_or("there is no [[channel]]")?;
    let channel = find(channels, id).ok_or_else(|| format!("there is no [[channel]] with id = \"{id}\""))?;
    match value {
        Value::ZeroOhm(ohm) => set(channel, "zero-ohm", to_places(*ohm, 4).into()),
        Value::Scale(scale) => set(channel, "scale", to_places(*scale, 6).into()),
        Value::Force(force, _) => set(channel, "force", characteristic(force, table_name).into()),
        Value::Tare(tare_n) => {
            let force = channel.get_mut("force").ok_or_else(|| format!("channel {id:?} has no force"))?;
            let table =
                force.as_table_like_mut().ok_or_else(|| format!("the force of {id:?} is no table"))?;
            match tare_n {
                Some(tare_n) => set(table, "tare", Newton(to_places(*tare_n, 6)).to_string().into()),
                None => drop(table.remove("tare")),
            }
            // Blanks before a comma come of what stood before the brace.
            force.as_inline_table_mut().into_iter().for_each(InlineTable::fmt);
        }
    }
    Ok(document.to_string())
}

fn find<'a>(channels: &'a mut Item, id: &str) -> Option<&'a mut dyn TableLike> {
    let is_it = |table: &dyn TableLike| table.get("id").and_then(Item::as_str) == Some(id);
    match channels {
        Item::ArrayOfTables(tables) => {
            tables.iter_mut().find(|table| is_it(*table)).map(|table| table as &mut dyn TableLike)
        }
        Item::Value(toml_edit::Value::Array(array)) => array
            .iter_mut()
            .filter_map(toml_edit::Value::as_inline_table_mut)
            .find(|table| is_it(*table))
            .map(|table| table as &mut dyn TableLike),
        _ => None,
    }
}

/// A value that was there keeps the blanks and the comment around it.
pub fn set(table: &mut dyn TableLike, key: &str, mut new: toml_edit::Value) {
    match table.get_mut(key) {
        Some(Item::Value(old)) => {
            *new.decor_mut() = old.decor().clone();
            *old = new;
        }
        _ => {
            table.remove(key);
            table.insert(key, Item::Value(new));
        }
    }
}

fn characteristic(force: &Force, table_name: &str) -> InlineTable {
    let newton = |f_n: f64| toml_edit::Value::from(Newton(to_places(f_n, 6)).to_string());
    let pairs: Vec<(&str, toml_edit::Value)> = match force.law {
        Law::Alpha { alpha_n_ohm } => {
            vec![("alpha", NewtonOhm(to_places(alpha_n_ohm, 2)).to_string().into())]
        }
        Law::Power { at_1_kohm_n, exponent } => {
            vec![("at-1-kohm", newton(at_1_kohm_n)), ("exponent", to_places(exponent, 6).into())]
        }
        Law::Calibrated { fc1_n, fc2_n } => vec![("fc1", newton(fc1_n)), ("fc2", newton(fc2_n))],
        Law::Table { .. } => vec![("table", table_name.into())],
    };
    let u = force.u.map(|u| ("u", format!("{} %", rounded(100.0 * u, 2)).into()));
    let range = force.range_n.map(|range| ("range", range.map(newton).into_iter().collect()));
    pairs.into_iter().chain(u).chain(range).collect()
}

fn csv(pairs: &[Weighing]) -> String {
    let rows = pairs.iter().map(|pair| format!("{},{}\n", pair.f_n, pair.r_ohm));
    std::iter::once("force_n,r_ohm\n".to_owned()).chain(rows).collect()
}

/// A channel's id as part of a file name.
fn file_name(id: &str) -> String {
    id.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "# mine\n[circuit]  # parts\nc-a = \"2.2 uF\"\n\n[[channel]]\nid = \"thumb\"   # left\n\
        zero-ohm =  1.5  # measured in May\nforce = { alpha = \"1 N ohm\" }\n# the end of thumb\n\n[[channel]]\n\
        id = \"index\"\nsink = 5\n\n# served here\n[server]\nmode = \"0660\" # group\n";

    fn alpha(value: f64) -> Value {
        Value::Force(Law::Alpha { alpha_n_ohm: value }.into(), Vec::new())
    }

    #[test]
    fn every_other_byte_stays() {
        let edited = |id, value| edit(TEXT, id, &value, "t.csv").unwrap();
        assert_eq!(edited("thumb", Value::ZeroOhm(-0.12344)), TEXT.replace("1.5", "-0.1234"));
        assert_eq!(edited("thumb", alpha(2.0)), TEXT.replace("1 N ohm", "2 N ohm"));
        let inserted = TEXT.replace("sink = 5\n", "sink = 5\nzero-ohm = 2.0\n");
        assert_eq!(edited("index", Value::ZeroOhm(2.0)), inserted);
        let inserted = TEXT.replace("sink = 5\n", "sink = 5\nforce = { alpha = \"13.34646 kN ohm\" }\n");
        assert_eq!(edited("index", alpha(13_346.46)), inserted);
        let tare = TEXT.replace("\"1 N ohm\" }", "\"1 N ohm\", tare = \"523 mN\" }");
        assert_eq!(edited("thumb", Value::Tare(Some(0.523))), tare);
        assert_eq!(edit(&tare, "thumb", &Value::Tare(None), "").unwrap(), TEXT);
        assert!(edit(TEXT, "index", &Value::Tare(Some(1.0)), "").unwrap_err().contains("has no force"));
    }

    #[test]
    fn other_ways_to_write_a_channel_are_known() {
        let value = Value::ZeroOhm(2.0);
        let inline = "channel = [{ id = \"a\" }, { id = \"b\", zero-ohm = 1 }] # two\n";
        assert_eq!(edit(inline, "b", &value, "").unwrap(), inline.replace("= 1", "= 2.0"));
        let nested = "[[channel]]\nid = \"a\"\n[channel.force]\nalpha = \"1 N ohm\"\n[server]\n";
        let edited = edit(nested, "a", &alpha(3.0), "").unwrap();
        assert_eq!(edited, "[[channel]]\nid = \"a\"\nforce = { alpha = \"3 N ohm\" }\n[server]\n");
        assert!(edit(inline, "c", &value, "").unwrap_err().contains("id = \"c\""));
        assert!(edit("a = 1", "c", &value, "").is_err() && edit("a = ", "c", &value, "").is_err());
    }
}
