//! The man pages and shell completions in docs/ are those of the present command lines, and the page of the configuration
//! has its keys. What no command line knows (files, exit status, signals, examples) is added from docs/man-parts.
//!
//! `UPDATE_DOCS=1 cargo test --test programs manual` writes them anew.

use cermd::config::{ChannelTable, Config, Gpio, Measure, Mock, Server};
use cermd::ctl::cli::{Cermctl, Cermd};
use cermd::pins::realtime::Wishes;
use clap::CommandFactory;
use clap_complete::Shell;
use serde::de::{DeserializeOwned, Deserializer, Error, Visitor, value};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

const CONFIGURATION: &str = "cermd.toml.5";

/// Every file below a directory, by its name.
fn files(folder: &Path) -> BTreeMap<String, String> {
    let entries = fs::read_dir(folder).map(|entries| entries.map(Result::unwrap).collect());
    let entries: Vec<fs::DirEntry> = entries.unwrap_or_default();
    entries
        .into_iter()
        .map(|entry| (entry.file_name().into_string().unwrap(), fs::read_to_string(entry.path()).unwrap()))
        .collect()
}

fn parts() -> BTreeMap<String, String> {
    files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/man-parts"))
}

fn write_pages(folder: &Path) {
    for program in [Cermd::command(), Cermctl::command()] {
        clap_mangen::generate_to(program.disable_help_subcommand(true), folder).unwrap();
    }
    for (name, part) in parts() {
        let page = folder.join(&name);
        // The configuration has no command line; every other part has a page that it belongs to.
        let own = if name == CONFIGURATION { String::new() } else { fs::read_to_string(&page).unwrap() };
        fs::write(page, own + &part).unwrap();
    }
}

fn write_completions(folder: &Path) {
    for (mut program, name) in [(Cermd::command(), "cermd"), (Cermctl::command(), "cermctl")] {
        for shell in [Shell::Bash, Shell::Fish, Shell::Zsh] {
            clap_complete::generate_to(shell, &mut program, name, folder).unwrap();
        }
    }
}

fn compare(name: &str, write: impl Fn(&Path)) {
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs").join(name);
    if std::env::var_os("UPDATE_DOCS").is_some() {
        let _ = fs::remove_dir_all(&kept);
        fs::create_dir_all(&kept).unwrap();
        write(&kept);
    }
    let fresh = tempfile::tempdir().unwrap();
    write(fresh.path());
    let (kept, fresh) = (files(&kept), files(fresh.path()));
    let names = |files: &BTreeMap<String, String>| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&kept), names(&fresh), "docs/{name}: UPDATE_DOCS=1 cargo test --test programs manual");
    for (file, text) in &fresh {
        assert!(
            kept[file] == *text,
            "docs/{name}/{file} is out of date: UPDATE_DOCS=1 cargo test --test programs manual"
        );
    }
}

#[test]
fn the_man_pages_are_up_to_date() {
    compare("man", write_pages);
}

#[test]
fn the_completions_are_up_to_date() {
    compare("completions", write_completions);
}

/// Looks at which fields a struct wants to read, and gives it none.
struct Spy<'a>(&'a mut Vec<String>);

impl<'de> Deserializer<'de> for Spy<'_> {
    type Error = value::Error;

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, value::Error> {
        Err(value::Error::custom("no struct"))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        _: V,
    ) -> Result<V::Value, value::Error> {
        self.0.extend(fields.iter().map(|field| (*field).to_owned()));
        Err(value::Error::custom("seen"))
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf option unit unit_struct newtype_struct
        seq tuple tuple_struct map enum identifier ignored_any
    }
}

fn fields_of<T: DeserializeOwned>() -> Vec<String> {
    let mut fields = Vec::new();
    assert!(T::deserialize(Spy(&mut fields)).is_err() && !fields.is_empty());
    fields
}

/// The keys of a table of the shipped configurations, those of inline tables too.
fn written(table: &toml::Table, keys: &mut Vec<String>) {
    for (key, value) in table {
        keys.push(key.clone());
        match value {
            toml::Value::Table(inner) => written(inner, keys),
            toml::Value::Array(items) => {
                items.iter().filter_map(toml::Value::as_table).for_each(|inner| written(inner, keys));
            }
            _ => {}
        }
    }
}

#[test]
fn the_page_of_the_configuration_has_every_key() {
    let page = parts()[CONFIGURATION].replace("\\-", "-");
    let mut keys = [
        fields_of::<Gpio>(),
        fields_of::<Measure>(),
        fields_of::<ChannelTable>(),
        fields_of::<Server>(),
        fields_of::<Wishes>(),
        fields_of::<Mock>(),
    ]
    .concat();
    for file in ["hw/cermd.toml", "src/config/tests_full.toml"] {
        let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).unwrap();
        written(&text.parse().unwrap(), &mut keys);
    }
    // A key alone, among others, or within braces.
    let names = page.lines().filter(|line| line.starts_with("\\fB") || line.starts_with(".SH ["));
    let names: Vec<String> =
        names.map(|line| format!(" {} ", line.replace(['\\', ',', '[', ']'], " "))).collect();
    for key in keys {
        let forms = [format!(" {key} "), format!("fB{key} ")];
        assert!(
            names.iter().any(|line| forms.iter().any(|form| line.contains(form))),
            "cermd.toml(5) lacks {key}"
        );
    }
    // And none that there is not.
    let example = page.split(".nf\n").nth(1).unwrap().split(".fi").next().unwrap();
    assert!(!Config::parse(example, "cermd.toml(5)").unwrap().check().has_errors());
}
