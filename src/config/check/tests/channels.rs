//! Names, zeros, forces and laws of channels.

use super::*;

#[test]
fn channels() {
    one(|c| c.unset(&["channel"]), "error: channel: there is none");
    one(
        |c| {
            c.unset(&["channel"]);
            (0..=MAX_CHANNELS)
                .fold(c, |c, i| c.channel(&i.to_string()).set(&format!("channel.{i}.sink"), 100 + i as i64))
        },
        "error: channel: there are 17, more than the 16",
    );
    // Of which nothing more is said.
    one(|c| (1..40).fold(c, |c, _| c.channel("thumb")), "error: channel: there are 40, more than the 16");
    one(|c| c.set("channel.thumb.id", ""), "error: channel.#1.id: \"\" is empty or has control characters");
    one(|c| c.set("channel.thumb.id", "a\nb"), "error: channel.#1.id: \"a\\nb\" is empty or has control");
    one(|c| c.set("channel.thumb.id", "x".repeat(65)), "error: channel.xxx");
    one(
        |c| c.channel("thumb").set("channel.1.sink", 17),
        "error: channel.thumb.id: two channels have this id",
    );
    one(|c| c.set("channel.thumb.zero-ohm", f64::INFINITY), "error: channel.thumb.zero-ohm: not a number");
    one(|c| c.set("channel.thumb.zero-ohm", 1000), "warning: channel.thumb.zero-ohm: 1 kohm is more");
    one(|c| c.set("channel.thumb.zero-ohm", -1e308), "error: channel.thumb.zero-ohm: -1e308 ohm is more");
}

#[test]
fn forces() {
    one_force(
        "{ fc1 = \"1 N\", fc2 = \"1 N\" }",
        "error: channel.thumb.force: fc1 = 1 N at the lower resistance",
    );
    one_force("{ fc1 = \"1 N\", fc2 = \"-1 N\" }", "error: channel.thumb.force: fc1 = 1 N");
    one_force("{ alpha = \"0 N ohm\" }", "error: channel.thumb.force: alpha = 0 N ohm is not above zero");
    one_force("{ at-1-kohm = \"13 N\", exponent = -1 }", "error: channel.thumb.force: at-1-kohm = 13 N");
    one_force("{ table = \"\" }", "error: channel.thumb.force: table names no file");
    one_force("{ alpha = \"1e308 N ohm\" }", "error: channel.thumb.force: 1e308 N ohm is beyond any sensor");
    one_force(
        "{ fc1 = \"1e300 N\", fc2 = \"1 N\" }",
        "error: channel.thumb.force: 1e300 N is beyond any sensor",
    );
    one_force(
        "{ fc1 = \"1 N\", fc2 = \"1e-300 N\" }",
        "error: channel.thumb.force: 1e-300 N is beyond any sensor",
    );
    one_force(
        "{ at-1-kohm = \"13 N\", exponent = 1e300 }",
        "error: channel.thumb.force: exponent = 1e300 is not",
    );
    for force in
        ["{ alpha = \"13346 N ohm\" }", "{ at-1-kohm = \"13 N\", exponent = 1.1 }", "{ table = \"f.csv\" }"]
    {
        let config = config(|c| c.lines("channel.thumb", &format!("force = {force}")));
        assert_eq!(complaints(&config), Vec::<String>::new(), "{force}");
    }
}

/// In the place of its force.
fn with_law(law: &str) -> Config {
    config(|c| c.unset(&["channel.thumb.force"]).lines("channel.thumb", &format!("law = {law}")))
}

#[test]
fn laws() {
    let one_law = |law: &str, beginning: &str| {
        let found = complaints(&with_law(law));
        assert!(found.len() == 1 && found[0].starts_with(beginning), "{law}: {found:?}");
    };
    let ntc = "error: channel.thumb.law: ";
    one_law(r#"{ kind = "ntc", r25 = "10 mohm", beta = "0.395 K" }"#, &format!("{ntc}beta = 395 mK"));
    one_law(r#"{ kind = "ntc", r25 = "1e300 ohm", beta = "3950 K" }"#, &format!("{ntc}r25 = 1e300 ohm"));
    one_law(r#"{ kind = "ntc", r25 = "10 kohm", beta = "3950 K", u = "0 %" }"#, &format!("{ntc}u = 0 %"));
    one_law(r#"{ kind = "ntc", a = 1, b = 1, c = 1 }"#, &format!("{ntc}a, b, c"));
    one_law(r#"{ kind = "ldr", at-10-lux = "15 kohm", gamma = 0 }"#, &format!("{ntc}gamma = 0"));
    one_law(
        r#"{ kind = "position", r0 = "1 kohm", r1 = "1 kohm", span = "100 mm" }"#,
        &format!("{ntc}r0 and r1"),
    );
    one_law(r#"{ kind = "table", table = "", unit = "degC" }"#, &format!("{ntc}table names no file"));
    one_law(r#"{ kind = "table", table = "t.csv", unit = "N" }"#, &format!("{ntc}unit = \"N\""));
    let both = config(|c| c.lines("channel.thumb", r#"law = { kind = "pt1000" }"#));
    assert_eq!(complaints(&both).len(), 1);
    assert!(complaints(&both)[0].starts_with(&format!("{ntc}the channel has a force, too; try")), "{both:?}");
    let info = |law: &str| {
        let all: Vec<String> = with_law(law).check().0.iter().map(Finding::to_string).collect();
        all.into_iter().any(|text| text.starts_with("info: channel.thumb.law: it does not say how far"))
    };
    assert!(info(r#"{ kind = "pt1000" }"#) && !info(r#"{ kind = "pt1000", class = "A" }"#));
    for law in [
        r#"{ kind = "ntc", r25 = "10 kohm", beta = "3950 K", u = "0.6 %", beta-u = "0.6 %", range = ["0 degC", "60 degC"] }"#,
        r#"{ kind = "ntc", a = 1.125e-3, b = 2.347e-4, c = 8.566e-8 }"#,
        r#"{ kind = "ldr", at-10-lux = "15 kohm", gamma = 0.7, gamma-u = 0.06, u = "19 %", range = ["1 lx", "2 klx"] }"#,
        r#"{ kind = "position", r0 = "20 ohm", r1 = "10 kohm", span = "270 deg", u = "2 deg" }"#,
        r#"{ kind = "table", table = "t.csv", unit = "%RH", u = "2 %" }"#,
    ] {
        assert_eq!(complaints(&with_law(law)), Vec::<String>::new(), "{law}");
    }
}
