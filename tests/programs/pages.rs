//! The pages as a reader meets them: every link leads somewhere, every page is in the contents of the site, and figures that the first
//! pages quote are those of the pages that are made by measuring.
//!
//! `UPDATE_DOCS=1 cargo test --test programs pages` writes the quoted figures anew.

use crate::cermctl::daemon::ctl;
use crate::common::config::{ConfigFile, config};
use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
/// Where a page may be.
const FOLDERS: [&str; 6] = ["", "docs", "hw", "clients/python", "tests/vm", "docs/site"];
/// The contents of the site: its links begin at the root.
const CONTENTS: &str = "docs/site/SUMMARY.md";

fn pages() -> Vec<PathBuf> {
    let folders = FOLDERS.iter().map(|folder| Path::new(ROOT).join(folder));
    let entries = folders.filter(|folder| folder.is_dir()).flat_map(|folder| fs::read_dir(folder).unwrap());
    let paths = entries.map(|entry| entry.unwrap().path());
    paths.filter(|path| path.extension().is_some_and(|extension| extension == "md")).collect()
}

fn text(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The links of a page, and the names of its headings as links spell them.
fn read(text: &str) -> (Vec<String>, BTreeSet<String>) {
    let (mut links, mut anchors, mut heading) = (Vec::new(), BTreeSet::new(), None);
    for event in Parser::new_ext(text, Options::ENABLE_TABLES) {
        match event {
            Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                links.push(dest_url.to_string());
            }
            Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
            Event::End(TagEnd::Heading(_)) => drop(anchors.insert(anchor(&heading.take().unwrap()))),
            Event::Text(text) | Event::Code(text) => {
                heading.iter_mut().for_each(|heading| heading.push_str(&text));
            }
            _ => {}
        }
    }
    (links, anchors)
}

/// Small letters, hyphens for blanks, and no other signs: as forges and mdBook make them.
fn anchor(heading: &str) -> String {
    let kept = heading.chars().filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c));
    kept.flat_map(char::to_lowercase).map(|c| if c == ' ' { '-' } else { c }).collect()
}

#[test]
fn every_link_leads_somewhere() {
    let mut seen = 0;
    for page in pages() {
        let base = if page.ends_with(CONTENTS) { Path::new(ROOT) } else { page.parent().unwrap() };
        for link in read(&text(&page)).0 {
            if link.contains("://") || link.starts_with("mailto:") {
                continue;
            }
            seen += 1;
            let (path, fragment) = link.split_once('#').unwrap_or((&link, ""));
            let target = if path.is_empty() { page.clone() } else { base.join(path) };
            assert!(target.exists(), "{}: ({link}) leads nowhere", page.display());
            let is_there = fragment.is_empty() || read(&text(&target)).1.contains(fragment);
            assert!(is_there, "{}: ({link}): no such heading", page.display());
        }
    }
    assert!(seen > 100, "{seen} links");
}

#[test]
fn the_contents_of_the_site_have_every_page_once() {
    let listed = read(&text(&Path::new(ROOT).join(CONTENTS))).0;
    let listed: Vec<PathBuf> = listed.iter().map(|link| Path::new(ROOT).join(link)).collect();
    let once: BTreeSet<&PathBuf> = listed.iter().collect();
    assert_eq!(once.len(), listed.len());
    for page in pages() {
        assert!(page.ends_with(CONTENTS) || once.contains(&page), "{CONTENTS} has no {}", page.display());
    }
}

/// The cells of the rows of a page that begin so.
fn row(page: &str, begin: &str) -> Vec<String> {
    let text = text(&Path::new(ROOT).join("docs").join(page));
    let line =
        text.lines().find(|line| line.starts_with(begin)).unwrap_or_else(|| panic!("{page}: no {begin}"));
    line.split('|').map(|cell| cell.trim().to_owned()).collect()
}

/// Two digits.
fn short(text: &str) -> String {
    let value: f64 = text.parse().unwrap();
    let places = if value < 1.0 { 2 } else { usize::from(value < 10.0) };
    format!("{value:.places$}")
}

/// Holds lines of a page, from the one that begins so on, against what they should be.
fn check_lines(page: &str, begin: &str, wanted: &[String]) {
    let path = Path::new(ROOT).join(page);
    let old = text(&path);
    let mut lines: Vec<&str> = old.lines().collect();
    let at =
        lines.iter().position(|line| line.starts_with(begin)).unwrap_or_else(|| panic!("{page}: no {begin}"));
    lines.splice(at..at + wanted.len(), wanted.iter().map(String::as_str));
    let new = lines.join("\n") + "\n";
    if std::env::var_os("UPDATE_DOCS").is_some() {
        fs::write(&path, &new).unwrap();
    }
    assert_eq!(text(&path), new, "{page} is out of date: UPDATE_DOCS=1 cargo test --test programs pages");
}

#[test]
fn quoted_figures_are_those_that_were_measured() {
    const R_OHM: [&str; 3] = ["100", "1000", "16200"];
    let line = |name: &str, cell: &dyn Fn(&str) -> String| {
        let cells: Vec<String> = R_OHM.iter().map(|r| cell(r)).collect();
        format!("| {name} | {} |", cells.join(" | "))
    };
    let single = |method: &'static str| {
        move |r: &str| {
            let cells = row("methods.md", &format!("| {method} | {r} |"));
            format!("{} ohm, {}/s", short(&cells[3]), cells[7])
        }
    };
    let weak = |kind: &'static str| {
        move |r: &str| {
            let cells = row("methods.md", &format!("| 8 mA | 470 | {kind} | {r} |"));
            format!("{} ohm, {}/s", short(&cells[5]), cells[7])
        }
    };
    let mean = |r: &str| format!("{} ohm", short(&row("averages.md", &format!("| one | {r} | 1 s |"))[4]));
    check_lines(
        "README.md",
        "| one capacitor, 5 lines",
        &[
            line("one capacitor, 5 lines", &single("tracked, one capacitor")),
            line("two capacitors, 7 lines", &single("tracked")),
            line("one capacitor, pins of 8 mA", &weak("one")),
            line("two capacitors, pins of 8 mA", &weak("two")),
            line("one capacitor, mean of 1 s", &mean),
        ],
    );
    check_lines(
        "docs/overview.md",
        "| `tpcm`",
        &[
            line("`tpcm`, one capacitor's worth of information", &single("tpcm")),
            line("`tcdic`, both nodes", &single("tcdic")),
            line("`cerm`, calibrated for each reading", &single("cerm")),
            line("`tracked`", &single("tracked")),
            line("`tracked`, one capacitor", &single("tracked, one capacitor")),
            line("the same, `average = \"1 s\"`", &mean),
        ],
    );
    // What capacitors remember: with time constants of five decades, and all at the worst.
    let absorbs = |name: &str, page_name: &str, share: &str| {
        let [all, worst] = ["five decades", "10 ms"]
            .map(|times| row("stability.md", &format!("| {page_name}, {share} % | {times} |")));
        let shift = |cell: &str| {
            let rounded = format!("{:+.1}", cell.split(' ').next().unwrap().parse::<f64>().unwrap());
            if rounded[1..] == *"0.0" { "0.0".to_owned() } else { rounded }
        };
        let cells = (3..9).map(|at| format!("{} .. {}", shift(&all[at]), shift(&worst[at])));
        let share: f64 = share.parse().unwrap();
        format!("| {name} | {share} % | {} |", cells.collect::<Vec<_>>().join(" | "))
    };
    check_lines(
        "hw/wiring.md",
        "| C0G, a good one |",
        &[
            absorbs("C0G, a good one", "C0G, a good one", "0.010"),
            absorbs("PP", "polypropylene (PP)", "0.050"),
            absorbs("PET", "polyester (PET)", "0.25"),
            absorbs("C0G, at the most", "C0G, at the most", "0.60"),
            absorbs("X7R", "X7R", "2.5"),
        ],
    );
    let rates =
        |method: &str| R_OHM.map(|r| row("methods.md", &format!("| {method} | {r} |"))[7].clone()).join(", ");
    check_lines(
        "hw/wiring.md",
        "| one capacitor | 5 lines",
        &[
            format!(
                "| one capacitor | 5 lines, 1 capacitor, 5 resistors | {} | for least parts and most speed |",
                rates("tracked, one capacitor")
            ),
            format!(
                "| two capacitors | 7 lines, 2 capacitors, 7 resistors | {} | for readings that are checked by a second \
                 crossing; for `cerm`, `tcdic` |",
                rates("tracked")
            ),
        ],
    );
}

/// A circuit as the page on wiring has it, with everything else by default.
fn circuit(parts: &str, r_charge: &str) -> ConfigFile {
    config(|file| {
        file.unset(&["circuit.c-a", "circuit.c-b"]).lines("circuit", parts).set("circuit.r-charge", r_charge);
        file.set("gpio.backend", "mock").set("mock.scene", "pi4").channel("x")
    })
}

const ONE: &str = "kind = \"one-capacitor\"\nc = \"470 nF\"";
const TWO: &str = "c-a = \"2.2 uF\"\nc-b = \"680 nF\"";

#[test]
fn charges_are_as_long_as_the_program_plans_them() {
    let charge = |parts: &str, r_charge: &str| circuit(parts, r_charge).parse().charge_in_words();
    /// A row with another last cell but so many.
    fn with(begin: &str, cell: usize, new: &str) -> String {
        let mut cells = row("../hw/wiring.md", begin);
        cells[cell] = new.to_owned();
        cells.join(" | ").replace("|  |", "| |").trim().to_owned()
    }
    for (pins, r_charge) in [("16", "260 ohm"), ("12", "370 ohm"), ("8", "510 ohm")] {
        let begin = format!("| {pins} mA | Pi");
        let charges = format!("{}, {}", charge(ONE, r_charge), charge(TWO, r_charge));
        check_lines("hw/wiring.md", &begin, &[with(&begin, 8, &charges)]);
    }
    for (begin, parts) in [
        ("| **470 nF alone**", ONE),
        ("| 330 nF / 22 nF", "c-a = \"330 nF\"\nc-b = \"22 nF\""),
        ("| **2.2 uF / 680 nF**", TWO),
        ("| 2.2 uF / 470 nF", "c-a = \"2.2 uF\"\nc-b = \"470 nF\""),
        ("| 10 uF / 680 nF", "c-a = \"10 uF\"\nc-b = \"680 nF\""),
    ] {
        check_lines("hw/wiring.md", begin, &[with(begin, 4, &charge(parts, "260 ohm"))]);
    }
}

/// The first pages have rates of a board whose threshold its configuration knows; these are of one that has the default.
#[test]
fn rates_as_shipped_are_those_that_check_says() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cermd.toml");
    let rates = |parts: &str| {
        fs::write(&path, circuit(parts, "220 ohm").to_string()).unwrap();
        let output = ctl(&["check", "--config", path.to_str().unwrap()]).output().unwrap();
        let said = String::from_utf8(output.stdout).unwrap();
        let rate = |r: &str| {
            let (_, after) = said.split_once(r).unwrap_or_else(|| panic!("{said}"));
            let (hertz, _) = after.split_once(" ohm at ").unwrap().1.split_once(" Hz").unwrap();
            format!("{:.0}/s", hertz.parse::<f64>().unwrap())
        };
        format!("{}, {}", rate("scene: 100"), rate(" 1000"))
    };
    let line =
        format!("at 100 ohm and 1 kohm, {} with one capacitor and {} with two.", rates(ONE), rates(TWO));
    check_lines("README.md", "at 100 ohm and 1 kohm, ", &[line]);
}
