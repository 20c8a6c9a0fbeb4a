//! `cermctl size` as a person types it, and the page that shows what it prints.

use assert_cmd::Command;
use serde_json::Value;
use std::fs;
use std::path::Path;

fn size(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cermctl"));
    command.arg("size").args(arguments);
    command
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[test]
fn what_cannot_be_meant_is_refused_with_what_to_type() {
    for (arguments, says) in [
        (&["--r", "100ohm..100kohm"][..], "--error <ERROR>|--rate <HERTZ>"),
        (&["--error", "1%"], "--r <FROM..TO>|--sensor <SENSOR>"),
        (&["--r", "100..100kohm", "--error", "1%"], "\"100\" is not a resistance such as \"2.32 kohm\""),
        (&["--r", "100kohm..100ohm", "--error", "1%"], "the smaller value comes first"),
        (&["--r", "0ohm..1kohm", "--error", "1%"], "it is to lie between 1.00 ohm and 10.0 Mohm"),
        (&["--r", "1kohm..2kohm", "--error", "5"], "such as 0.5%, 2ohm or 0.02N"),
        (&["--r", "1kohm..2kohm", "--error", "0%"], "an error is above 0"),
        (&["--r", "1kohm..2kohm", "--error=-1ohm"], "an error is above 0"),
        (&["--r", "1kohm..2kohm", "--rate", "200"], "\"200\" is not a frequency such as \"50 MHz\""),
        (&["--r", "1kohm..2kohm", "--rate", "1MHz"], "it is to lie between"),
        (&["--r", "1kohm..2kohm", "--rate", "1Hz", "--pin-current", "2A"], "it is to lie between"),
        (&["--r", "1kohm..2kohm", "--rate", "1Hz..2Hz"], "one value is meant"),
        (&["--sensor", "fsr402", "--rate", "1Hz"], "--force <FROM..TO>"),
        (&["--r", "1kohm..2kohm", "--force", "1N..2N", "--rate", "1Hz"], "cannot be used with"),
        (&["--r", "1kohm..2kohm", "--rate", "1Hz", "--have", "470n"], "\"470n\" is neither a capacitor"),
    ] {
        let assert = size(arguments).assert().code(2);
        let complaint = text(&assert.get_output().stderr);
        assert!(complaint.contains(says), "{arguments:?}: {complaint}");
    }
    for (arguments, says) in [
        (&["--r", "1kohm..2kohm", "--error", "0.1N"][..], "--error in newton needs a sensor"),
        (&["--r", "1kohm..2kohm", "--rate", "1Hz", "--board", "pi9"], "there is no built-in scene \"pi9\""),
        (
            &["--r", "1kohm..2kohm", "--rate", "1Hz", "--have", "1uF,10ohm,1kohm"],
            "--have: two resistors are needed",
        ),
    ] {
        let assert = size(arguments).assert().code(1);
        let complaint = text(&assert.get_output().stderr);
        assert!(complaint.contains(says), "{arguments:?}: {complaint}");
    }
}

#[test]
fn the_configuration_that_it_writes_is_one_to_start_with() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cermd.toml");
    let name = path.to_str().unwrap();
    let arguments = ["--sensor", "fsr402", "--force", "1N..10N", "--rate", "50Hz", "--json", "--write", name];
    let assert = size(&arguments).assert().success().stderr("");
    let line: Value = serde_json::from_slice(&assert.get_output().stdout).unwrap();
    assert_eq!((&line["class"], &line["meets"]), (&"SIZE".into(), &true.into()));
    let best = &line["best"];
    for one in best["expected"].as_array().unwrap() {
        assert!(
            one["rate_hz"].as_f64().unwrap() >= 50.0 && one["f_repeat_u_n"].as_f64().unwrap() > 0.0,
            "{one}"
        );
    }
    // Nothing that a pin may carry is exceeded, and it says so itself.
    let currents = best["currents_a"].as_object().unwrap();
    assert!(
        currents.len() == 3 && currents.values().all(|ampere| ampere.as_f64().unwrap() <= 0.008),
        "{best}"
    );

    let check =
        Command::new(env!("CARGO_BIN_EXE_cermd")).args(["--check", "--config", name]).assert().success();
    let said = text(&check.get_output().stdout);
    assert!(said.contains("usable: 0 error(s), 0 warning(s)"), "{said}");
    let written = fs::read_to_string(&path).unwrap();
    assert!(written.contains(&format!("r-c1 = \"{} ohm\"", best["r_c1_ohm"].as_f64().unwrap())), "{written}");

    // What is there stays.
    let again = size(&arguments).assert().code(1);
    assert!(text(&again.get_output().stderr).contains("is there already, and was not changed"));
    assert_eq!(fs::read_to_string(&path).unwrap(), written);
}

#[test]
fn the_page_shows_what_it_prints() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/sizing.md");
    let kept = fs::read_to_string(&path).unwrap();
    let mut fresh = String::new();
    for (index, block) in kept.split("```\n").enumerate() {
        if index % 2 == 0 {
            fresh += block;
            continue;
        }
        let command = block.lines().next().unwrap();
        let arguments = command.strip_prefix("$ cermctl size ").unwrap().split(' ').collect::<Vec<_>>();
        let output = size(&arguments).output().unwrap();
        fresh += &format!("```\n{command}\n{}{}```\n", text(&output.stdout), text(&output.stderr));
    }
    if std::env::var_os("UPDATE_DOCS").is_some() {
        fs::write(&path, &fresh).unwrap();
    }
    assert!(fresh == kept, "docs/sizing.md: UPDATE_DOCS=1 cargo test --test programs size\n{fresh}");
}
