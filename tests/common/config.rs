//! Files of tests, configurations and scenes: what most have in common, and what one changes.
//!
//! Shared by the tests of the crate (tests/common) and those of its modules (src/lib.rs).
#![allow(clippy::unwrap_used, clippy::panic, reason = "of tests and benchmarks")]

use cermd::config::Config;
use std::fmt;
use toml::{Table, Value};

/// The text of a file, as a table. A value has the name that findings give it: `circuit.c-a`, `channel.thumb.sink`; of a list
/// whose tables have no `id`, `sensor.0.constant`.
#[derive(Debug, Clone)]
pub struct ConfigFile(Table);

/// 2.2 uF / 680 nF, and what `change` does to that.
pub fn config(change: impl FnOnce(&mut ConfigFile) -> &mut ConfigFile) -> ConfigFile {
    let mut file = ConfigFile(Table::new());
    file.set("circuit.kind", "two-capacitor").set("circuit.c-a", "2.2 uF").set("circuit.c-b", "680 nF");
    file.set("circuit.r-c1", "470 ohm").set("circuit.r-c2", "12.7 kohm");
    change(&mut file);
    file
}

impl ConfigFile {
    /// That of a file that stands somewhere else.
    pub fn of(text: &str) -> ConfigFile {
        ConfigFile(text.parse().unwrap())
    }

    pub fn set(&mut self, name: &str, value: impl Into<Value>) -> &mut ConfigFile {
        let (table, key) = name.rsplit_once('.').unwrap();
        self.table(table).insert(key.to_owned(), value.into());
        self
    }

    /// Takes values or whole tables out, which have to be there.
    pub fn unset(&mut self, names: &[&str]) -> &mut ConfigFile {
        for name in names {
            let removed = match name.rsplit_once('.') {
                Some((table, key)) => self.table(table).remove(key),
                None => self.0.remove(*name),
            };
            assert!(removed.is_some(), "{name}");
        }
        self
    }

    /// Lines of a table, as they stand in a file.
    pub fn lines(&mut self, table: &str, lines: &str) -> &mut ConfigFile {
        let lines: Table = lines.parse().unwrap();
        self.table(table).extend(lines);
        self
    }

    /// Another circuit, with one capacitor.
    pub fn one_capacitor(&mut self, kind: &str, c: &str) -> &mut ConfigFile {
        self.unset(&["circuit.c-a", "circuit.c-b"]).set("circuit.kind", kind).set("circuit.c", c)
    }

    /// One more channel, whose pin is known to be like the others.
    pub fn channel(&mut self, id: &str) -> &mut ConfigFile {
        self.one_more("channel", "id", id);
        self.set(&format!("channel.{id}.zero-ohm"), 0.0).set(&format!("channel.{id}.scale"), 1.0)
    }

    /// One more sensor of a scene.
    pub fn sensor(&mut self, r: &str) -> &mut ConfigFile {
        self.one_more("sensor", "constant", r)
    }

    fn one_more(&mut self, list: &str, key: &str, value: &str) -> &mut ConfigFile {
        let list = self.0.entry(list).or_insert_with(|| Value::Array(Vec::new()));
        let table = Table::from_iter([(key.to_owned(), value.into())]);
        list.as_array_mut().unwrap().push(Value::Table(table));
        self
    }

    pub fn parse(&self) -> Config {
        Config::parse(&self.to_string(), "test").map_err(|error| format!("{error}\n{self}")).unwrap()
    }

    /// The table of this name; made if it is not there.
    fn table(&mut self, name: &str) -> &mut Table {
        let (first, rest) = name.split_once('.').map_or((name, None), |(first, rest)| (first, Some(rest)));
        let mut at = self.0.entry(first).or_insert_with(|| Value::Table(Table::new()));
        for part in rest.into_iter().flat_map(|rest| rest.split('.')) {
            at = match at {
                Value::Array(list) => {
                    let is_it = |table: &Value| table.get("id").is_some_and(|id| id.as_str() == Some(part));
                    let index = list.iter().position(is_it).unwrap_or_else(|| part.parse().unwrap());
                    &mut list[index]
                }
                table => &mut table[part],
            };
        }
        at.as_table_mut().unwrap()
    }
}

impl fmt::Display for ConfigFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let is_line = |value: &Value| !value.is_table() && !value.is_array();
        write_lines(f, self.0.iter().filter(|(_, value)| is_line(value)))?;
        for (name, value) in &self.0 {
            match value {
                Value::Table(table) => {
                    writeln!(f, "[{name}]")?;
                    write_lines(f, table)?;
                }
                Value::Array(list) => {
                    for table in list {
                        writeln!(f, "[[{name}]]")?;
                        write_lines(f, table.as_table().unwrap())?;
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }
}

/// As a person writes them: a table in a table stands in its line.
fn write_lines<'a>(
    f: &mut fmt::Formatter<'_>,
    lines: impl IntoIterator<Item = (&'a String, &'a Value)>,
) -> fmt::Result {
    lines.into_iter().try_for_each(|(key, value)| writeln!(f, "{key} = {value}"))
}
