//! Triggers: what is refused, and what the defaults are.

use super::*;
use crate::config::When;
use crate::trigger::{Compared, TriggerRules};

/// One complaint about added lines of the channel, which has a force.
#[track_caller]
fn one_trigger(lines: &str, beginning: &str) {
    one(|c| c.lines("channel.thumb", lines), beginning);
}

fn rules(change: impl FnOnce(&mut ConfigFile) -> &mut ConfigFile) -> TriggerRules {
    config(change).triggers().unwrap()[0].rules
}

#[test]
fn thresholds_and_times_that_cannot_work() {
    for (lines, beginning) in [
        (
            "on-above = '2 N'\noff-below = '2 N'",
            "off-below: 2 N is not below on-above = 2 N; try \"1.6 N\", or",
        ),
        (
            "on-below = '2 N'\noff-above = '1 N'",
            "off-above: 1 N is not above on-below = 2 N; try \"2.5 N\", or",
        ),
        (
            "on-above = '2 N'\noff-above = '1 N'",
            "off-above: it does not go with on-above; try on-above with off-below",
        ),
        ("on-above = '2 N'\non-below = '1 N'", "on-below: it does not go with on-above"),
        (
            "on-above = '2 N'\noff-below = '1 kohm'",
            "off-below: 1 kohm is not of the same kind as on-above = 2 N",
        ),
        ("on-above = '0 N'", "on-above: 0 N is not above zero"),
        ("on-above = '-5 kohm'", "on-above: -5 kohm is not above zero; try \"5 kohm\""),
        ("on-above = '2 N'\noff-below = '0 N'", "off-below: 0 N is not above zero"),
        ("off-below = '1 N'", "off-below: the channel has no threshold"),
        ("hold = '20 ms'", "hold: the channel has no threshold"),
        ("stale = '1 s'", "stale: the channel has no threshold"),
        ("output = { line = 17 }", "output: the channel has no threshold"),
        ("on-above = '2 N'\nhold = '61 s'", "hold: 61 s is not between 0 and 1 min"),
        ("on-above = '2 N'\nhold = '-1 ms'", "hold: -1 ms is not between 0 and 1 min"),
        ("on-above = '2 N'\nstale = '0 s'", "stale: 0 s is not above 0 and up to 1 min"),
        ("on-above = '2 N'\nstale = '100 ms'", "stale: 100 ms is shorter than"),
    ] {
        one_trigger(lines, &format!("error: channel.thumb.{beginning}"));
    }
    one(
        |c| c.unset(&["channel.thumb.force"]).set("channel.thumb.on-above", "2 N"),
        "error: channel.thumb.on-above: \"2 N\" is no resistance, and the channel shows nothing else; try \"5 kohm\"",
    );
    // Prefixes and other units of force.
    for good in ["on-above = '500 g'", "on-below = '5 kohm'", "on-above = '2 N'\noff-below = '50 g'"] {
        assert_eq!(complaints(&config(|c| c.lines("channel.thumb", good))), Vec::<String>::new(), "{good}");
    }
}

#[test]
fn what_is_no_threshold_is_refused_with_what_would_be_one() {
    for wrong in ["2 volt", "2", "40 degC", "", "inf N", "1e999 N"] {
        let expected = format!(
            "error: channel.thumb.on-above: {wrong:?} is neither in N, which the channel shows, nor a resistance; try \"2 N\" or \"5 kohm\""
        );
        one_trigger(&format!("on-above = '{wrong}'"), &expected);
    }
}

/// A channel with a law and these lines.
fn with_law(law: &str, lines: &str) -> Config {
    config(|c| {
        c.unset(&["channel.thumb.force"]);
        c.lines("channel.thumb", &format!("law = {law}\n{lines}"))
    })
}

const NTC: &str = "{ kind = 'ntc', r25 = '10 kohm', beta = '3950 K', u = '1 %' }";

#[test]
fn thresholds_are_in_the_unit_of_a_law() {
    let slider =
        |span: &str| format!("{{ kind = 'position', r0 = '0 ohm', r1 = '10 kohm', span = '{span}' }}");
    let table = |unit: &str| format!("{{ kind = 'table', table = 'pairs.csv', unit = '{unit}' }}");
    for (law, [on, off], wanted) in [
        (NTC.to_owned(), ["40 degC", "38.5 °C"], [40.0, 38.5]),
        (NTC.to_owned(), ["0degC", "-10 degC"], [0.0, -10.0]),
        ("{ kind = 'pt1000' }".to_owned(), ["-20 degC", "-21 degC"], [-20.0, -21.0]),
        (
            "{ kind = 'ldr', at-10-lux = '15 kohm', gamma = 0.7 }".to_owned(),
            ["1 klx", "900 lux"],
            [1000.0, 900.0],
        ),
        (slider("100 mm"), ["6 cm", "55 mm"], [60.0, 55.0]),
        (slider("270 deg"), ["200 °", "190 deg"], [200.0, 190.0]),
        (slider("100 %"), ["60 %", "55%"], [60.0, 55.0]),
        // Of a table as it is written there, even where that is a spelling of something else.
        (table("kg"), ["2 kg", "1.5kg"], [2.0, 1.5]),
        (table("m3/h"), ["2 m3/h", "-1e-3 m3/h"], [2.0, -1e-3]),
    ] {
        let config = with_law(&law, &format!("on-above = '{on}'\noff-below = '{off}'"));
        assert_eq!(complaints(&config), Vec::<String>::new(), "{law}");
        let rules = config.triggers().unwrap()[0].rules;
        assert_eq!((rules.quantity, [rules.on, rules.off]), (Compared::Shown, wanted), "{law}");
        // Any channel has ohms, and their default.
        let rules = with_law(&law, "on-below = '5 kohm'").triggers().unwrap()[0].rules;
        assert_eq!((rules.quantity, rules.on, rules.off), (Compared::Resistance, 5e3, 6.25e3), "{law}");
    }
}

#[test]
fn thresholds_that_a_law_has_no_use_for() {
    for (lines, wanted) in [
        (
            "on-above = '2 N'",
            "on-above: \"2 N\" is neither in degC, which the channel shows, nor a resistance; try \"2 degC\" or",
        ),
        ("on-above = '40 K'", "on-above: \"40 K\" is neither in degC"),
        (
            "on-above = '40 degC'",
            "off-below: missing: only forces and resistances have a default; try what differs from on-above = 40 degC by",
        ),
        (
            "on-above = '40 degC'\noff-below = '41 degC'",
            "off-below: 41 degC is not below on-above = 40 degC; try what is below 40 degC by more than that wanders",
        ),
        (
            "on-below = '-5 degC'\noff-above = '-5 degC'",
            "off-above: -5 degC is not above on-below = -5 degC; try what is above",
        ),
        (
            "on-above = '40 degC'\noff-below = '1 kohm'",
            "off-below: 1 kohm is not of the same kind as on-above = 40 degC; try the same unit in both",
        ),
    ] {
        let said = complaints(&with_law(NTC, lines));
        assert!(
            said.len() == 1 && said[0].starts_with(&format!("error: channel.thumb.{wanted}")),
            "{said:#?}"
        );
    }
}

#[test]
fn outputs_are_lines_of_their_own() {
    let output = |output: &str| format!("on-above = '2 N'\noutput = {output}");
    for (line, beginning) in [
        ("{ line = 'GPIO16' }", "output: GPIO16 is channel.thumb.sink already"),
        ("{ line = 'GPIO13' }", "output: GPIO13 is gpio.charge-a already"),
        ("{ line = 'GPIO13', chip = 'pinctrl-bcm2835' }", "output: GPIO13 is gpio.charge-a already"),
    ] {
        one_trigger(&output(line), &format!("error: channel.thumb.{beginning}"));
    }
    // That of another chip may have the name.
    let elsewhere = output("{ line = 'GPIO13', chip = 'expander' }");
    assert_eq!(complaints(&config(|c| c.lines("channel.thumb", &elsewhere))), Vec::<String>::new());
    let two = |c: &mut ConfigFile| {
        c.channel("index").set("channel.index.sink", "GPIO26").set("channel.index.on-below", "5 kohm");
        c.lines("channel.index", "output = { line = 'GPIO17' }");
        c.lines("channel.thumb", &output("{ line = 'GPIO17' }")).clone()
    };
    one(
        |c| {
            *c = two(c);
            c
        },
        "error: channel.index.output: GPIO17 is channel.thumb.output already",
    );
}

#[test]
fn what_is_left_out_follows_from_the_circuit() {
    let thumb = |line: &'static str| rules(move |c| c.lines("channel.thumb", line));
    let up = thumb("on-above = '2 N'");
    assert_eq!((up.quantity, up.on, up.off, up.hold), (Compared::Shown, 2.0, 1.6, Nanos::ZERO));
    // Three cycles of which each takes 67.1 ms at most: the prediction of the good configuration.
    assert!((up.stale.as_seconds() - 3.0 * 0.0671).abs() < 0.0005, "{:?}", up.stale);
    let down = thumb("on-below = '2 kohm'\nhold = '20 ms'\nstale = '1 s'");
    let expected = TriggerRules {
        quantity: Compared::Resistance,
        on: 2e3,
        off: 2.5e3,
        hold: Nanos(20_000_000),
        stale: Nanos(1_000_000_000),
    };
    assert_eq!(down, expected);
    assert!(config(|c| c).triggers().unwrap().is_empty());
    // What is read more rarely may be silent for longer.
    let rare = rules(|c| c.lines("channel.thumb", "on-above = '2 N'\nevery = 10"));
    assert_eq!(rare.stale.0, 10 * up.stale.0);
    let mean = rules(|c| c.lines("channel.thumb", "on-above = '2 N'").set("measure.average", "1 s"));
    assert_eq!(mean.stale.0, up.stale.0 + 3_000_000_000);
    // The slowest that there is: three times a thousand cycles of a minute, idle, or with one mean more.
    let slowest = |idle: bool| {
        rules(move |c| {
            c.lines("channel.thumb", "on-above = '2 N'\nevery = 1000");
            c.set("measure.rate-hz", 1.0 / 60.0).set("measure.idle", idle)
        })
    };
    assert_eq!(slowest(true).stale, Nanos(180_000_000_000_000));
    assert!(slowest(false).stale > Nanos(180_000_000_000));
}

#[test]
fn the_line_of_an_output_is_that_of_the_circuits_chip_unless_it_says_otherwise() {
    let output = |lines: &str| {
        let config = config(|c| c.lines("channel.thumb", &format!("on-above = '2 N'\noutput = {lines}")));
        config.triggers().unwrap().remove(0).output.unwrap()
    };
    let (line, when) = output("{ line = 17 }");
    assert_eq!((line.chip.as_str(), line.line.as_str(), line.active_low), ("pinctrl-bcm2835", "17", false));
    assert_eq!(when, When::Pressed);
    let (line, when) = output("{ line = 'P0', chip = 'expander', active-low = true, when = 'released' }");
    assert_eq!((line.chip.as_str(), line.line.as_str(), line.active_low), ("expander", "P0", true));
    assert_eq!(when, When::Released);
}

#[test]
fn what_is_not_known_makes_no_output_active() {
    use crate::trigger::{State, Why};
    for state in [State::Pressed, State::Released, State::Unknown(Why::Fault), State::Unknown(Why::Stale)] {
        assert_eq!(When::Pressed.is_active(state), state == State::Pressed);
        assert_eq!(When::Released.is_active(state), state == State::Released);
    }
}

#[test]
fn how_late_a_press_is_told_is_predicted() {
    let told = |hold: &str| {
        let config = config(|c| c.lines("channel.thumb", "on-above = '2 N'").set("channel.thumb.hold", hold));
        let findings = config.check();
        let told = findings.0.iter().find(|finding| finding.key == "channel.thumb.on-above");
        told.map(ToString::to_string).unwrap()
    };
    let words = |time| {
        format!(
            "info: channel.thumb.on-above: 2 N: told {time} after it is so, or sooner, unless readings are faults"
        )
    };
    assert_eq!(told("0 s"), words("67 ms"));
    assert_eq!(told("20 ms"), words("150 ms"));
}
