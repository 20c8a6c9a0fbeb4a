//! The map of the rooms in `src/lib.rs`, held against the imports of the code.

#![allow(clippy::unwrap_used)]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The rooms in the order of the table: each may import from those before it.
fn map() -> Vec<String> {
    let text = std::fs::read_to_string("src/lib.rs").unwrap();
    let rows = text.lines().filter_map(|line| line.strip_prefix("//! | [`"));
    rows.map(|row| row.split('`').next().unwrap().to_owned()).collect()
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// The module of a file, `["estimate", "noise"]` for src/estimate/noise.rs; the program's own for src/bin.
fn module(path: &Path) -> Vec<String> {
    let relative = path.strip_prefix("src").unwrap().with_extension("");
    let mut parts: Vec<String> = relative.iter().map(|part| part.to_string_lossy().into_owned()).collect();
    if parts.last().is_some_and(|last| last == "mod") {
        parts.pop();
    }
    parts
}

/// Production code alone: no comments, nothing from the first `#[cfg(test)]` module on.
fn code(path: &Path) -> String {
    let text = std::fs::read_to_string(path).unwrap();
    let text = text.split("\n#[cfg(test)]\nmod ").next().unwrap();
    let text = text.split("\n#[cfg(test)]\npub(crate) mod ").next().unwrap();
    text.lines().map(|line| line.split("//").next().unwrap()).collect::<Vec<_>>().join("\n")
}

/// Every `crate::a::b...` in a text, groups opened: `crate::a::{b, c::D}` is `a::b` and `a::c::D`.
fn imports(code: &str) -> BTreeSet<Vec<String>> {
    let mut found = BTreeSet::new();
    for tail in code.split("crate::").skip(1) {
        paths(tail, &mut Vec::new(), &mut found);
    }
    found
}

fn paths<'a>(mut text: &'a str, before: &mut Vec<String>, found: &mut BTreeSet<Vec<String>>) -> &'a str {
    let depth = before.len();
    loop {
        let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
        before.push(text[..end].to_owned());
        text = &text[end..];
        let Some(rest) = text.strip_prefix("::") else { break };
        text = rest;
        if let Some(group) = rest.strip_prefix('{') {
            text = group.trim_start();
            while !text.starts_with('}') && !text.is_empty() {
                text = paths(text, before, found).trim_start_matches(|c: char| c == ',' || c.is_whitespace());
            }
            text = text.strip_prefix('}').unwrap_or(text);
            before.truncate(depth);
            return text;
        }
    }
    found.insert(before.clone());
    before.truncate(depth);
    text
}

fn production() -> Vec<(Vec<String>, BTreeSet<Vec<String>>)> {
    let mut files = Vec::new();
    sources(Path::new("src"), &mut files);
    files.sort();
    let is_test = |path: &PathBuf| path.file_name().is_some_and(|name| name == "tests.rs");
    let files = files.iter().filter(|path| !is_test(path));
    files.map(|path| (module(path), imports(&code(path)))).collect()
}

#[test]
fn every_arrow_points_up_the_map() {
    let map = map();
    let place = |room: &str| map.iter().position(|name| name == room);
    let mut wrong = Vec::new();
    for (module, imports) in production() {
        let room = &module[0];
        if room == "bin" || room == "lib" {
            continue;
        }
        let Some(own) = place(room) else {
            wrong.push(format!("src/{} is missing from the map", module.join("/")));
            continue;
        };
        for import in imports {
            match place(&import[0]) {
                Some(other) if other > own => {
                    wrong.push(format!("{} points back at {}", module.join("::"), import.join("::")));
                }
                _ => {}
            }
        }
    }
    for room in &map {
        let is_there = Path::new(&format!("src/{room}/mod.rs")).exists()
            || Path::new(&format!("src/{room}.rs")).exists();
        if !is_there {
            wrong.push(format!("{room} is on the map and not in src"));
        }
    }
    assert!(wrong.is_empty(), "the map in src/lib.rs is not true:\n{}", wrong.join("\n"));
    assert!(map.len() > 5, "the map has {} rooms", map.len());
}

/// Modules beside each other in a room form no circle: what a module's folder holds counts as the module.
#[test]
fn no_room_has_a_circle_inside() {
    let files = production();
    let modules: BTreeSet<&Vec<String>> = files.iter().map(|(module, _)| module).collect();
    let mut arrows: BTreeMap<Vec<String>, BTreeSet<Vec<String>>> = BTreeMap::new();
    for (module, imports) in &files {
        let from = &module[..module.len().min(2)];
        for import in imports {
            let to: Vec<String> = import.iter().take(2).cloned().collect();
            // Names of the room's own root are not modules.
            if modules.contains(&to) && to[..] != *from && to.len() == 2 {
                arrows.entry(from.to_vec()).or_default().insert(to);
            }
        }
    }
    for start in arrows.keys().filter(|module| module.len() == 2) {
        let mut reached = BTreeSet::new();
        let mut open: Vec<&Vec<String>> = arrows[start].iter().collect();
        while let Some(next) = open.pop() {
            assert!(next != start, "{} imports itself by way of others", start.join("::"));
            if reached.insert(next) {
                open.extend(arrows.get(next).into_iter().flatten());
            }
        }
    }
}

#[test]
fn imports_are_read_as_the_compiler_reads_them() {
    let found = imports("use crate::a::{b, c::{D, E}};\nlet x = crate::f::g();");
    let found: Vec<String> = found.iter().map(|path| path.join("::")).collect();
    assert_eq!(found, ["a::b", "a::c::D", "a::c::E", "f::g"]);
}
