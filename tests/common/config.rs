//! Configurations of tests: what most have in common, and what one changes.

use cermd::config::Config;
use std::fmt;
use toml::{Table, Value};

/// The text of a configuration file, as a table.
#[derive(Debug, Clone, Default)]
pub struct ConfigFile(Table);

/// A file with what `change` puts into it.
pub fn config(change: impl FnOnce(&mut ConfigFile)) -> ConfigFile {
    let mut file = ConfigFile::default();
    change(&mut file);
    file
}

impl ConfigFile {
    /// A key of a table; what was there before is gone.
    pub fn set(&mut self, table: &str, key: &str, value: impl Into<Value>) -> &mut ConfigFile {
        self.table(table).insert(key.to_owned(), value.into());
        self
    }

    /// Lines of a table, as they stand in a file.
    pub fn lines(&mut self, table: &str, lines: &str) -> &mut ConfigFile {
        let lines: Table = lines.parse().unwrap();
        self.table(table).extend(lines);
        self
    }

    /// One more channel.
    pub fn channel(&mut self, id: &str) -> &mut ConfigFile {
        let channels = self.0.entry("channel").or_insert_with(|| Value::Array(Vec::new()));
        let channel = Table::from_iter([("id".to_owned(), id.into())]);
        channels.as_array_mut().unwrap().push(Value::Table(channel));
        self
    }

    pub fn parse(&self) -> Config {
        Config::parse(&self.to_string(), "test").unwrap()
    }

    fn table(&mut self, name: &str) -> &mut Table {
        let table = self.0.entry(name).or_insert_with(|| Value::Table(Table::new()));
        table.as_table_mut().unwrap()
    }
}

impl fmt::Display for ConfigFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&toml::to_string(&self.0).unwrap())
    }
}
