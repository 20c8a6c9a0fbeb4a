//! The configuration that a setup writes: the commented one of the project, with what was answered.

use crate::config::Server;
use crate::ctl::calibrate::edit;
use crate::ctl::cli::Setup;
use crate::units::{Farad, Ohm};
use std::str::FromStr;
use toml_edit::{DocumentMut, InlineTable, Item, Table, TableLike, Value};

/// The first words of a file that a setup has written.
pub const MARK: &str = "# Written by `cermctl setup`";

const TEMPLATE: &str = include_str!("../../../hw/cermd.toml");

/// What a setup wants to know, in the order in which it asks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Key {
    /// `one` capacitor, or `two`.
    Wiring,
    /// Capacitors as printed, and calibration resistors as measured.
    CA,
    CB,
    C,
    RC1,
    RC2,
    /// `fsr402`, or `ohm`: no force.
    Sensor,
}

impl Key {
    pub const ALL: [Key; 7] = [Key::Wiring, Key::CA, Key::CB, Key::C, Key::RC1, Key::RC2, Key::Sensor];

    /// What it is of.
    fn name(self) -> &'static str {
        match self {
            Key::Wiring => "capacitors",
            Key::CA => "C_A, between the nodes A and B, as printed",
            Key::CB => "C_B, from node B to ground, as printed",
            Key::C => "the capacitor as printed",
            Key::RC1 => "Rc1 as measured",
            Key::RC2 => "Rc2 as measured",
            Key::Sensor => "sensor",
        }
    }

    /// What is asked, with the words that it may be where these are few.
    pub fn question(self) -> String {
        match self {
            Key::Wiring => format!("{}: one, or two", self.name()),
            Key::Sensor => format!("{}: fsr402, or ohm for no force", self.name()),
            _ => self.name().to_owned(),
        }
    }

    /// What the drawings have.
    fn usual(self) -> &'static str {
        match self {
            Key::Wiring => "two",
            Key::CA => "2.2 uF",
            Key::CB => "680 nF",
            Key::C => "470 nF",
            Key::RC1 => "470 ohm",
            Key::RC2 => "12.7 kohm",
            Key::Sensor => "fsr402",
        }
    }

    fn check(self, text: &str) -> Result<(), String> {
        let one_of = |words: [&str; 2]| match words.contains(&text) {
            true => Ok(()),
            false => Err(format!("{}, or {}", words[0], words[1])),
        };
        match self {
            Key::Wiring => one_of(["one", "two"]),
            Key::Sensor => one_of(["fsr402", "ohm"]),
            Key::CA | Key::CB | Key::C => quantity::<Farad>(text),
            Key::RC1 | Key::RC2 => quantity::<Ohm>(text),
        }
    }
}

fn quantity<T: FromStr<Err: ToString>>(text: &str) -> Result<(), String> {
    text.parse::<T>().map(drop).map_err(|error| error.to_string())
}

/// What is known by now, as it is typed.
#[derive(Debug)]
pub struct Answers<'a> {
    arguments: &'a Setup,
    chip: Option<String>,
    texts: [String; Key::ALL.len()],
}

impl<'a> Answers<'a> {
    /// What the options say, and the drawings where they say nothing. `chip`: `None` for a simulated board.
    ///
    /// # Errors
    /// Which option cannot be, and why.
    pub fn new(arguments: &'a Setup, chip: Option<String>) -> Result<Answers<'a>, String> {
        let mut answers = Answers { arguments, chip, texts: Key::ALL.map(|key| key.usual().to_owned()) };
        for key in Key::ALL {
            if let Some(text) = answers.given(key) {
                answers.answer(key, text).map_err(|error| format!("{}: {error}", key.name()))?;
            }
        }
        if let Some(text) = &arguments.r_charge {
            quantity::<Ohm>(text).map_err(|error| format!("--r-charge: {error}"))?;
        }
        Ok(answers)
    }

    /// Rp and 40 ohm of its pin: Rp is by what the pins of a board may carry (hw/wiring.md).
    pub fn r_charge(&self) -> &str {
        self.arguments.r_charge.as_deref().unwrap_or(match self.chip.as_deref() {
            Some("pinctrl-rp1") => "370 ohm",
            Some("pinctrl-bcm2711") => "510 ohm",
            _ => "260 ohm",
        })
    }

    fn given(&self, key: Key) -> Option<&'a str> {
        let Setup { wiring, c_a, c_b, c, r_c1, r_c2, sensor, .. } = self.arguments;
        let given = match key {
            Key::Wiring => wiring,
            Key::CA => c_a,
            Key::CB => c_b,
            Key::C => c,
            Key::RC1 => r_c1,
            Key::RC2 => r_c2,
            Key::Sensor => sensor,
        };
        given.as_deref()
    }

    /// Whether no option says it, and it is a part of the wiring.
    pub fn is_open(&self, key: Key) -> bool {
        let is_there = match key {
            Key::CA | Key::CB => !self.is_one(),
            Key::C => self.is_one(),
            _ => true,
        };
        is_there && self.given(key).is_none()
    }

    /// What is taken now.
    pub fn text(&self, key: Key) -> &str {
        &self.texts[key as usize]
    }

    /// Takes an answer.
    ///
    /// # Errors
    /// What would be one.
    pub fn answer(&mut self, key: Key, text: &str) -> Result<(), String> {
        key.check(text)?;
        self.texts[key as usize] = text.to_owned();
        Ok(())
    }

    fn is_one(&self) -> bool {
        self.text(Key::Wiring) == "one"
    }

    /// The text of the file.
    ///
    /// # Errors
    /// What of `--set` cannot be.
    pub fn configuration(&self) -> Result<String, String> {
        let mut document: DocumentMut = TEMPLATE.parse().map_err(|error| format!("{error}"))?;
        let mut set = |path: &str, text: &str| put(&mut document, path, text.into());
        if self.is_one() {
            set("circuit.kind", "one-capacitor")?;
            set("circuit.c", self.text(Key::C))?;
        } else {
            set("circuit.c-a", self.text(Key::CA))?;
            set("circuit.c-b", self.text(Key::CB))?;
        }
        set("circuit.r-c1", self.text(Key::RC1))?;
        set("circuit.r-c2", self.text(Key::RC2))?;
        set("circuit.r-charge", self.r_charge())?;
        set("channel.id", &self.arguments.id)?;
        match &self.chip {
            Some(chip) => set("gpio.chip", chip)?,
            None => {
                set("gpio.backend", "mock")?;
                set("mock.scene", self.arguments.scene.as_deref().unwrap_or("pi4"))?;
            }
        }
        let socket = &self.arguments.connection.socket;
        if socket != &Server::default().socket {
            // What is asked for its readings afterwards.
            let path = socket.to_str().ok_or("--socket: not a path in UTF-8")?;
            set("server.socket", path)?;
        }
        for assignment in &self.arguments.set {
            let (path, text) = assignment
                .split_once('=')
                .ok_or_else(|| format!("--set {assignment}: KEY=VALUE, such as gpio.sense-a=GPIO5"))?;
            // A number or a switch is one; everything else is text, quantities too.
            let value = text
                .parse::<Value>()
                .ok()
                .filter(|value| value.is_integer() || value.is_float() || value.is_bool());
            put(&mut document, path.trim(), value.unwrap_or_else(|| text.into()))?;
        }
        if self.is_one() {
            for path in ["circuit.c-a", "circuit.c-b", "gpio.sense-b", "gpio.charge-b"] {
                take(&mut document, path);
            }
        }
        if self.text(Key::Sensor) == "ohm" {
            take(&mut document, "channel.force");
        }
        Ok(format!(
            "{MARK}, which takes it back with --undo; comments and values may be changed.\n#\n{document}"
        ))
    }
}

/// The table that a path such as `gpio.chip` or `channel.law.kind` names, made if it is not there, and the key in it; the first
/// channel is `channel`.
fn table<'a, 'b>(document: &'a mut DocumentMut, path: &'b str) -> Option<(&'a mut dyn TableLike, &'b str)> {
    let (tables, key) = path.rsplit_once('.')?;
    let mut names = tables.split('.');
    let item = document.entry(names.next()?).or_insert_with(|| Item::Table(Table::new()));
    let mut table: &mut dyn TableLike = match item {
        Item::ArrayOfTables(tables) => tables.get_mut(0)?,
        item => item.as_table_like_mut()?,
    };
    for name in names {
        let inner = table.entry(name).or_insert_with(|| Item::Value(InlineTable::new().into()));
        table = inner.as_table_like_mut()?;
    }
    Some((table, key))
}

fn put(document: &mut DocumentMut, path: &str, value: Value) -> Result<(), String> {
    let (table, key) =
        table(document, path).ok_or_else(|| format!("--set {path}: a key such as gpio.sense-a"))?;
    edit::set(table, key, value);
    Ok(())
}

fn take(document: &mut DocumentMut, path: &str) {
    if let Some((table, key)) = table(document, path) {
        table.remove(key);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::circuit::Kind;
    use crate::config::Config;
    use clap::Parser;

    #[derive(Parser)]
    struct Command {
        #[command(flatten)]
        setup: Setup,
    }

    fn written(options: &[&str], chip: Option<&str>) -> Result<String, String> {
        let arguments = Command::parse_from([&["setup"], options].concat()).setup;
        Answers::new(&arguments, chip.map(str::to_owned))?.configuration()
    }

    #[test]
    fn without_a_word_it_is_the_commented_one() {
        let text = written(&[], Some("pinctrl-rp1")).unwrap();
        assert!(text.starts_with(MARK) && text.ends_with(TEMPLATE));
    }

    #[test]
    fn the_socket_that_is_named_is_served() {
        let of = |options: &[&str]| {
            Config::parse(&written(options, Some("pinctrl-rp1")).unwrap(), "test").unwrap().server.socket
        };
        assert_eq!(of(&[]), Server::default().socket);
        assert_eq!(of(&["--socket", "/tmp/cermd.sock"]).to_str(), Some("/tmp/cermd.sock"));
    }

    #[test]
    fn the_charger_is_that_of_the_board_or_what_is_said() {
        for (chip, options, wanted) in [
            ("pinctrl-rp1", &[][..], 370.0),
            ("pinctrl-bcm2711", &[], 510.0),
            ("pinctrl-bcm2835", &[], 260.0),
            ("pinctrl-bcm2711", &["--r-charge", "300 ohm"], 300.0),
        ] {
            let config = Config::parse(&written(options, Some(chip)).unwrap(), "test").unwrap();
            assert_eq!(config.circuit.r_charge, Ohm(wanted), "{chip}");
        }
    }

    #[test]
    fn a_law_is_given_by_its_keys() {
        let law = ["channel.law.kind=ntc", "channel.law.r25=10 kohm", "channel.law.beta=3950 K"];
        let law = law.iter().flat_map(|assignment| ["--set", assignment]);
        let options: Vec<&str> = ["--sensor", "ohm"].into_iter().chain(law).collect();
        let config = Config::parse(&written(&options, Some("pinctrl-rp1")).unwrap(), "test").unwrap();
        assert!(
            config.channels[0].law.is_some() && !config.check().has_errors(),
            "{}",
            config.check().errors()
        );
        let force = written(&["--set", "channel.force.alpha=1 N ohm"], None).unwrap();
        assert!(force.contains("force = { alpha = \"1 N ohm\" }"), "{force}");
    }

    #[test]
    fn what_is_answered_stands_in_it_and_comments_stay() {
        let options =
            ["--wiring", "one", "--c", "330 nF", "--r-c1", "468.2 ohm", "--sensor", "ohm", "--id", "toe"];
        let options = [&options[..], &["--set", "gpio.sense-a=17", "--set", "measure.idle=true"]].concat();
        let text = written(&options, Some("pinctrl-bcm2711")).unwrap();
        let config = Config::parse(&text, "test").unwrap();
        assert_eq!(config.circuit.kind(), Kind::OneCapacitor);
        assert_eq!((config.circuit.r_c1, config.channels[0].id.as_str()), (Ohm(468.2), "toe"));
        assert!(config.channels[0].force.is_none() && config.gpio.chip.as_deref() == Some("pinctrl-bcm2711"));
        assert!(
            text.contains("sense-a = 17")
                && text.contains("idle = true")
                && text.contains("as measured: a reading")
        );
        assert!(!config.check().has_errors(), "{}", config.check().errors());
    }

    #[test]
    fn a_simulated_board_has_no_chip() {
        let text = written(&["--scene", "pi4"], None).unwrap();
        assert!(!Config::parse(&text, "test").unwrap().check().has_errors());
    }

    #[test]
    fn what_cannot_be_says_so() {
        for (options, wanted) in [
            (["--r-c1", "470"], "Rc1 as measured: "),
            (["--wiring", "three"], "capacitors: one, or two"),
            (["--set", "nonsense"], "KEY=VALUE"),
            (["--set", "gpio=5"], "a key such as"),
            (["--set", "gpio.chip.name=5"], "a key such as"),
            (["--r-charge", "470"], "--r-charge: "),
        ] {
            let error = written(&options, None).unwrap_err();
            assert!(error.contains(wanted) && error.matches("or two").count() < 2, "{error}");
        }
    }
}
