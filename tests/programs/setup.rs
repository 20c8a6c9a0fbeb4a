//! `cermctl setup` on a simulated board: what it writes is usable and runs, what was there comes back.

use std::fs;

fn setup(folder: &std::path::Path, more: &[&str]) -> assert_cmd::assert::Assert {
    let config = folder.join("cermd.toml");
    let mut command = assert_cmd::Command::new(env!("CARGO_BIN_EXE_cermctl"));
    command.args(["setup", "--config"]).arg(config).args(more).assert()
}

fn said(assert: &assert_cmd::assert::Assert, is_error: bool) -> String {
    let output = assert.get_output();
    String::from_utf8_lossy(if is_error { &output.stderr } else { &output.stdout }).into_owned()
}

#[test]
fn a_setup_is_usable_and_can_be_taken_back() {
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("cermd.toml");
    let options = ["--scene", "pi4", "--no-service", "--wiring", "one", "--r-c1", "468 ohm"];
    for old in [None, Some("# mine\n")] {
        if let Some(old) = old {
            fs::write(&config, old).unwrap();
        }
        let done = said(&setup(folder.path(), &[&options[..], &["--yes"]].concat()).success(), false);
        assert!(done.contains("cermd.toml: usable") && done.contains("not started"), "{done}");
        // Once more changes nothing of what it takes back.
        setup(folder.path(), &[&options[..], &["--yes"]].concat()).success();
        let text = fs::read_to_string(&config).unwrap();
        assert!(text.contains("r-c1 = \"468 ohm\"") && text.contains("one-capacitor"), "{text}");
        setup(folder.path(), &["--undo"]).success();
        assert_eq!(fs::read_to_string(&config).ok().as_deref(), old);
    }
    let refused = said(&setup(folder.path(), &["--undo"]).failure(), true);
    assert!(refused.contains("was not written by `cermctl setup`"), "{refused}");
    let names =
        fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let (kept, there): (Vec<String>, Vec<String>) =
        names.partition(|name| name.starts_with("cermd.toml.bak-"));
    assert_eq!((kept.len(), there), (2, vec!["cermd.toml".to_owned()]), "what was undone is kept, too");
}

#[test]
fn a_name_alone_is_of_the_folder_that_one_is_in() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = assert_cmd::Command::new(env!("CARGO_BIN_EXE_cermctl"));
    command.args(["setup", "--scene", "pi4", "--no-service", "--yes", "--config", "mine.toml"]);
    command.current_dir(folder.path()).assert().success();
    assert!(folder.path().join("mine.toml").exists());
}

#[test]
fn what_is_asked_may_be_answered_wrongly_and_again() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = assert_cmd::Command::new(env!("CARGO_BIN_EXE_cermctl"));
    command
        .args(["setup", "--scene", "pi4", "--no-service", "--config"])
        .arg(folder.path().join("cermd.toml"));
    let done = said(&command.write_stdin("three\none\n1 henry\n\n\n\nohm\n").assert().success(), false);
    assert!(done.contains("one, or two") && done.contains("usable: 0 error(s)"), "{done}");
    let ended = said(&command.write_stdin("two\n").assert().failure(), true);
    assert!(ended.contains("--yes"), "{ended}");
}

#[test]
fn no_chip_and_no_place_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let refused = said(&setup(folder.path(), &["--yes", "--chip", "no-such-chip"]).failure(), true);
    assert!(refused.contains("no-such-chip") && refused.contains("--scene pi4"), "{refused}");
    let refused = ["--yes", "--scene", "pi4", "--set", "measure.average=-1 s"];
    let refused = said(&setup(folder.path(), &refused).failure(), true);
    assert!(refused.contains("measure.average"), "{refused}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is written that cannot be used");
    let nowhere =
        said(&setup(std::path::Path::new("/proc/none"), &["--yes", "--scene", "pi4"]).failure(), true);
    assert!(nowhere.contains("/proc/none"), "{nowhere}");
}
