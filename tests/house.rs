//! The map of the rooms in `src/lib.rs`, held against the imports of the code.

#![allow(clippy::unwrap_used)]

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// `["estimate", "noise"]` for src/estimate/noise.rs.
type Module = Vec<String>;

/// The rooms in the order of the map, and what each module of production code imports from the crate.
struct House {
    rooms: Vec<String>,
    imports: BTreeMap<Module, BTreeSet<Module>>,
}

impl House {
    /// From the text of every source by its path below src.
    fn new(sources: &BTreeMap<String, String>) -> House {
        let rows = sources["lib.rs"].lines().filter_map(|line| line.strip_prefix("//! | [`"));
        let rooms = rows.map(|row| row.split('`').next().unwrap().to_owned()).collect();
        let (mut imports, mut of_tests) = (BTreeMap::new(), Vec::new());
        for (path, text) in sources.iter().filter(|(path, _)| !path.starts_with("bin/")) {
            let module: Module = path.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
            let module = match module.split_last().unwrap() {
                (last, rest) if last == "mod" || path == "lib.rs" => rest.to_vec(),
                _ => module,
            };
            let (code, tests) = production(text);
            of_tests.extend(tests.into_iter().map(|name| [module.clone(), vec![name]].concat()));
            imports.insert(module.clone(), paths(&module, &code));
        }
        imports
            .retain(|module, _| !module.is_empty() && !of_tests.iter().any(|test| module.starts_with(test)));
        House { rooms, imports }
    }

    /// Rooms that are missing, on the map or in src, and imports that point down the map.
    fn untrue(&self) -> Vec<String> {
        let place = |module: &Module| self.rooms.iter().position(|room| *room == module[0]);
        let mut untrue: Vec<String> = self
            .rooms
            .iter()
            .filter(|room| !self.imports.contains_key(&vec![room.to_string()]))
            .map(|room| format!("{room} is on the map and not in src"))
            .collect();
        for (module, imports) in &self.imports {
            let Some(own) = place(module) else {
                untrue.push(format!("src/{} is missing from the map", module.join("/")));
                continue;
            };
            let back = imports.iter().filter(|import| place(import).is_some_and(|other| other > own));
            untrue.extend(
                back.map(|import| format!("{} points back at {}", module.join("::"), import.join("::"))),
            );
        }
        untrue
    }

    /// Circles of modules that stand beside each other. What is in a module's folder counts as the module; a name from
    /// the root that both stand in is no arrow.
    fn circles(&self) -> BTreeSet<String> {
        let mut arrows: BTreeMap<&[String], BTreeSet<&[String]>> = BTreeMap::new();
        for (module, imports) in &self.imports {
            for import in imports {
                let shared = module.iter().zip(import).take_while(|(own, other)| own == other).count();
                let ends = [module.get(..=shared), import.get(..=shared)];
                if let [Some(from), Some(to)] = ends {
                    if self.imports.contains_key(to) {
                        arrows.entry(from).or_default().insert(to);
                    }
                }
            }
        }
        let circles = arrows.keys().filter_map(|start| way_back(&arrows, start));
        // Each circle once, from its first module on.
        let circles = circles.filter(|way| way.iter().all(|module| *module >= way[0]));
        circles
            .map(|way| way.iter().map(|module| module.join("::")).collect::<Vec<_>>().join(" -> "))
            .collect()
    }
}

/// A way along the arrows from a module that leads to itself.
fn way_back<'a>(
    arrows: &BTreeMap<&'a [String], BTreeSet<&'a [String]>>,
    start: &'a [String],
) -> Option<Vec<&'a [String]>> {
    let (mut seen, mut ways) = (BTreeSet::new(), vec![vec![start]]);
    while let Some(way) = ways.pop() {
        for &next in arrows.get(way[way.len() - 1]).into_iter().flatten() {
            if next == start {
                return Some(way);
            }
            if seen.insert(next) {
                ways.push([&way[..], &[next]].concat());
            }
        }
    }
    None
}

/// The text without comments and without the items that only tests compile, and the names of modules among these.
fn production(text: &str) -> (String, Vec<String>) {
    let (mut code, mut tests) = (String::new(), Vec::new());
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if line.trim_start().starts_with("#[cfg(test)]") {
            let indent = line.len() - line.trim_start().len();
            // rustfmt ends an item with a line that is as far in as it begins.
            for line in lines.by_ref() {
                let name = line.trim().strip_suffix(';').and_then(|line| line.split("mod ").nth(1));
                tests.extend(name.map(str::to_owned));
                if line.len() - line.trim_start().len() == indent && line.ends_with(['}', ';']) {
                    break;
                }
            }
        } else {
            code += line.split("//").next().unwrap();
            code.push('\n');
        }
    }
    (code, tests)
}

/// Every path in the code of a module that begins with `crate`, `self` or `super`, from the root of the crate.
fn paths(module: &Module, code: &str) -> BTreeSet<Module> {
    let mut found = BTreeSet::new();
    for (root, from) in [("crate::", &Module::new()), ("self::", module), ("super::", module)] {
        for (at, _) in code.match_indices(root) {
            if !code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':') {
                let text = if root == "super::" { &code[at..] } else { &code[at + root.len()..] };
                expand(text, from.clone(), &mut found);
            }
        }
    }
    found
}

/// Adds the path, or a whole group of them, that a text begins with; answers what comes behind.
fn expand<'a>(text: &'a str, mut path: Module, found: &mut BTreeSet<Module>) -> &'a str {
    if let Some(mut rest) = text.strip_prefix('{') {
        while !rest.is_empty() && !rest.starts_with('}') {
            rest = expand(rest.trim_start(), path.clone(), found);
            rest = rest.trim_start_matches(|c: char| !"_{}".contains(c) && !c.is_alphanumeric());
        }
        return rest.strip_prefix('}').unwrap_or(rest);
    }
    let (name, rest) =
        text.split_at(text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len()));
    match name {
        "super" => drop(path.pop()),
        "self" | "" => {}
        name => path.push(name.to_owned()),
    }
    match rest.strip_prefix("::") {
        Some(rest) => expand(rest, path, found),
        None => {
            found.insert(path);
            let other_name = rest.strip_prefix(" as ");
            other_name.map_or(rest, |rest| rest.trim_start_matches(|c: char| c.is_alphanumeric() || c == '_'))
        }
    }
}

fn read(folder: &Path, below: &str, sources: &mut BTreeMap<String, String>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = format!("{below}{}", path.file_name().unwrap().to_str().unwrap());
        if path.is_dir() {
            read(&path, &format!("{name}/"), sources);
        } else if name.ends_with(".rs") {
            sources.insert(name, std::fs::read_to_string(path).unwrap());
        }
    }
}

#[test]
fn every_arrow_points_up_the_map_and_there_is_no_circle() {
    let mut sources = BTreeMap::new();
    read(Path::new("src"), "", &mut sources);
    let house = House::new(&sources);
    assert!(
        house.rooms.len() > 5 && house.imports.len() > 50,
        "the sources are not where they are looked for"
    );
    let untrue = house.untrue();
    assert!(untrue.is_empty(), "the map in src/lib.rs is not true:\n{}", untrue.join("\n"));
    let circles: Vec<_> = house.circles().into_iter().collect();
    assert!(circles.is_empty(), "modules that import themselves by way of others:\n{}", circles.join("\n"));
}

/// A house of two rooms, `low` on top, with these sources besides.
fn made_up(sources: &[(&str, &str)]) -> House {
    let lib = ("lib.rs", "//! | [`low`] | it |\n//! | [`high`] | knows |\npub mod low;\npub mod high;\n");
    let rooms = [lib, ("low.rs", ""), ("high/mod.rs", "use crate::low::Thing;\nmod a;\nmod b;\n")];
    House::new(
        &rooms.iter().chain(sources).map(|(path, text)| ((*path).to_owned(), (*text).to_owned())).collect(),
    )
}

#[test]
fn a_map_that_is_not_true_is_told() {
    assert!(made_up(&[]).untrue().is_empty());
    assert_eq!(made_up(&[("attic/mod.rs", "")]).untrue(), ["src/attic is missing from the map"]);
    let mut house = made_up(&[]);
    house.rooms.push("cellar".to_owned());
    assert_eq!(house.untrue(), ["cellar is on the map and not in src"]);
    for import in
        ["use crate::high::Thing;", "use crate::{high::Thing};", "fn f() {\n    super::high::Thing::new()\n}"]
    {
        assert_eq!(
            made_up(&[("low.rs", import)]).untrue(),
            ["low points back at high::Thing"].map(|text| {
                if import.contains("new") { format!("{text}::new") } else { text.to_owned() }
            })
        );
    }
    let of_tests = "#[cfg(test)]\nmod tests {\n    use crate::high::Thing;\n}\n// crate::high\n";
    assert!(made_up(&[("low.rs", of_tests)]).untrue().is_empty());
    let before_code = "#[cfg(test)]\nmod bench;\nuse crate::high;\n";
    assert_eq!(made_up(&[("low.rs", before_code)]).untrue(), ["low points back at high"]);
    assert!(
        made_up(&[("low.rs", "#[cfg(test)]\nmod bench;\n"), ("low/bench.rs", "use crate::high;")])
            .untrue()
            .is_empty()
    );
}

#[test]
fn a_circle_is_told_however_it_is_spelled() {
    let circle = |a: &str, b: &str| made_up(&[("high/a.rs", a), ("high/b.rs", b)]).circles();
    for a in [
        "use crate::high::b::B;",
        "use super::b;",
        "use super::{Thing, b::{B, C}};",
        "fn f(b: super::b::B) {}",
    ] {
        assert!(circle(a, "use super::Thing;").is_empty(), "{a}");
        assert_eq!(
            circle(a, "use super::a::A as Other;").into_iter().collect::<Vec<_>>(),
            ["high::a -> high::b"]
        );
    }
    // By way of a folder, and deeper inside.
    let house = made_up(&[
        ("high/a.rs", "use self::deep::D;"),
        ("high/a/deep.rs", "use super::super::b::B;\nuse super::other::O;"),
        ("high/a/other.rs", "use super::deep::D;"),
        ("high/b.rs", "use super::a::A;"),
    ]);
    assert_eq!(
        house.circles().into_iter().collect::<Vec<_>>(),
        ["high::a -> high::b", "high::a::deep -> high::a::other"]
    );
}

#[test]
fn imports_are_read_as_the_compiler_reads_them() {
    let module: Module = ["high", "a"].map(str::to_owned).to_vec();
    let found = paths(
        &module,
        "use crate::a::{b, c::{D, E as F},\n    self};\nlet x = crate::f::g();\nuse super::*;",
    );
    let found: Vec<String> = found.iter().map(|path| path.join("::")).collect();
    assert_eq!(found, ["a", "a::b", "a::c::D", "a::c::E", "f::g", "high"]);
}
