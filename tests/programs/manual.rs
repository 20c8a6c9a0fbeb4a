//! The man pages and shell completions in docs/ are those of the present command lines.
//!
//! `UPDATE=1 cargo test --test programs manual` writes them anew.

use cermd::ctl::cli::{Cermctl, Cermd};
use clap::CommandFactory;
use clap_complete::Shell;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Every file below a directory, by its name.
fn files(folder: &Path) -> BTreeMap<String, String> {
    let entries = fs::read_dir(folder).map(|entries| entries.map(Result::unwrap).collect());
    let entries: Vec<fs::DirEntry> = entries.unwrap_or_default();
    entries
        .into_iter()
        .map(|entry| (entry.file_name().into_string().unwrap(), fs::read_to_string(entry.path()).unwrap()))
        .collect()
}

fn write_pages(folder: &Path) {
    for program in [Cermd::command(), Cermctl::command()] {
        clap_mangen::generate_to(program.disable_help_subcommand(true), folder).unwrap();
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
    if std::env::var_os("UPDATE").is_some() {
        let _ = fs::remove_dir_all(&kept);
        fs::create_dir_all(&kept).unwrap();
        write(&kept);
    }
    let fresh = tempfile::tempdir().unwrap();
    write(fresh.path());
    let (kept, fresh) = (files(&kept), files(fresh.path()));
    let names = |files: &BTreeMap<String, String>| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&kept), names(&fresh), "docs/{name}: UPDATE=1 cargo test --test programs manual");
    for (file, text) in &fresh {
        assert!(
            kept[file] == *text,
            "docs/{name}/{file} is out of date: UPDATE=1 cargo test --test programs manual"
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
