//! `cermctl lines`: the chips and lines of this machine, with the names that a configuration needs, and who holds which.

use super::{CtlError, line, print};
use crate::ctl::cli;
use crate::pins::chardev::{self, ChipListing, LineListing};

/// Prints. A chip that may not be opened is told on standard error.
pub fn run(arguments: &cli::Lines) -> Result<(), CtlError> {
    let opened = |chip: Result<_, _>| chip.inspect_err(|refused| eprintln!("cermctl: {refused}")).ok();
    let chips: Vec<ChipListing> = chardev::list().filter_map(opened).collect();
    if chips.is_empty() {
        return Err(CtlError::said("no GPIO chip to list; without hardware try `cermctl demo`"));
    }
    if arguments.json { chips.iter().try_for_each(|chip| print(&line(chip))) } else { print(&tables(&chips)) }
}

fn tables(chips: &[ChipListing]) -> String {
    chips.iter().map(table).collect::<Vec<_>>().join("\n")
}

/// A heading, then a line for each line: offset, name, direction with settings, holder.
fn table(chip: &ChipListing) -> String {
    let name = |line: &LineListing| line.name.clone().unwrap_or_else(|| "-".to_owned());
    let state = |line: &LineListing| [&[line.direction], line.flags.as_slice()].concat().join(" ");
    let width = |text: &dyn Fn(&LineListing) -> String| {
        chip.lines.iter().map(|line| text(line).chars().count()).max().unwrap_or(0)
    };
    let (names, states) = (width(&name), width(&state));
    let mut table =
        format!("{} [{}] {}, {} lines\n", chip.name, chip.label, chip.path.display(), chip.lines.len());
    for line in &chip.lines {
        let row =
            format!("  {:>4}  {:names$}  {:states$}  {}", line.offset, name(line), state(line), holder(line));
        table.push_str(row.trim_end());
        table.push('\n');
    }
    table
}

fn holder(line: &LineListing) -> String {
    match (&line.consumer, line.used) {
        (Some(consumer), _) => format!("held by \"{consumer}\""),
        (None, true) => "held".to_owned(),
        (None, false) => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    fn chip() -> ChipListing {
        let input = LineListing { direction: "input", ..LineListing::default() };
        let free = LineListing { offset: 4, name: Some("GPIO4".into()), ..input.clone() };
        let sink = LineListing {
            offset: 20,
            name: Some("GPIO20".into()),
            direction: "output",
            flags: vec!["open-drain"],
            used: true,
            consumer: Some("cermd".into()),
        };
        let unnamed = LineListing { offset: 28, used: true, ..input };
        ChipListing {
            name: "gpiochip0".into(),
            label: "pinctrl-rp1".into(),
            path: "/dev/gpiochip0".into(),
            lines: vec![free, sink, unnamed],
        }
    }

    #[test]
    fn a_table_shows_who_holds_what() {
        insta::assert_snapshot!(tables(&[chip()]), @r#"
        gpiochip0 [pinctrl-rp1] /dev/gpiochip0, 3 lines
             4  GPIO4   input
            20  GPIO20  output open-drain  held by "cermd"
            28  -       input              held
        "#);
    }

    #[test]
    fn an_object_leaves_out_what_is_not_known() {
        let text = line(&chip());
        assert_eq!(text.lines().count(), 1);
        let chip: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(
            chip["lines"][1],
            json!({ "offset": 20, "name": "GPIO20", "direction": "output",
            "flags": ["open-drain"], "used": true, "consumer": "cermd" })
        );
        assert!(chip["lines"][2].get("name").is_none() && chip["lines"][2].get("consumer").is_none());
    }
}
