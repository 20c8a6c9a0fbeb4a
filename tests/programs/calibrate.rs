//! `cermctl calibrate` with the real programs: a daemon on a simulated board, answers on standard input, and a
//! configuration file that changes after a yes and only then.

mod changes;

use crate::cermctl::daemon::{Daemon, config, ctl, json_lines, scene};
use crate::cermctl::terminal::on_a_terminal;
use crate::common::config::ConfigFile;
use crate::waiting::until_so;
use assert_cmd::Command;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

/// Before Rc1 and Rc2 there are pins of 40 ohm, before these sensors others: the zeros are 4 and -6 ohm.
const PINS: &str = "r-o-of = { x0 = \"44 ohm\", x1 = \"34 ohm\" }";
/// Far below what any of this resolves.
const SHORT: &str = "1 uohm";
const CSV: &str = "force_n,r_ohm\n# of the paper\n1.20,11122\n6.06,2200\n";

fn daemon(thumb: &str, index: &str) -> Daemon {
    daemon_by("cerm", thumb, index)
}

fn daemon_by(method: &str, thumb: &str, index: &str) -> Daemon {
    daemon_with(method, PINS, [thumb, index])
}

fn daemon_with(method: &str, pins: &str, [thumb, index]: [&str; 2]) -> Daemon {
    let mut scene = scene();
    scene.lines("circuit", pins).set("sensor.0.constant", thumb).set("sensor.1.constant", index);
    // Nobody has looked at its pins yet.
    let unknown =
        ["thumb", "index"].map(|id| [format!("channel.{id}.zero-ohm"), format!("channel.{id}.scale")]);
    let unknown: Vec<&str> = unknown.as_flattened().iter().map(String::as_str).collect();
    Daemon::start_as(config().set("measure.method", method).unset(&unknown), &scene)
}

/// `cermctl calibrate` for the daemon's own configuration.
fn calibrate(daemon: &Daemon, arguments: &[&str]) -> Command {
    let config = daemon.path("cermd.toml");
    let mut command = daemon.ctl(&["calibrate"]);
    command.args(arguments).args(["--config", config.to_str().unwrap()]);
    command
}

fn config_of(daemon: &Daemon) -> String {
    fs::read_to_string(daemon.path("cermd.toml")).unwrap()
}

fn stdout(command: &mut Command) -> String {
    String::from_utf8(command.assert().success().get_output().stdout.clone()).unwrap()
}

/// The copies of the old file that are kept.
fn kept(folder: &Path) -> Vec<PathBuf> {
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    files.filter(|path| path.to_str().unwrap().contains(".toml.bak-")).collect()
}

/// The zero that a line of JSON tells, which must be right within 4 of its sigma.
fn zero(json: &str, truth_ohm: f64) -> f64 {
    let line: Value = serde_json::from_str(json).unwrap();
    let (zero_ohm, u_ohm) = (line["zero_ohm"].as_f64().unwrap(), line["zero_u_ohm"].as_f64().unwrap());
    assert!(u_ohm < 0.5 && (zero_ohm - truth_ohm).abs() < 4.0 * u_ohm, "{json}");
    zero_ohm
}

#[test]
fn a_short_circuit_tells_zeros_of_both_signs() {
    let daemon = daemon(SHORT, SHORT);
    for (id, truth_ohm) in [("thumb", 4.0), ("index", -6.0)] {
        let before = config_of(&daemon);
        let arguments = ["zero", "--channel", id, "--count", "100", "--yes", "--json"];
        let json = stdout(&mut calibrate(&daemon, &arguments));
        let line: Value = serde_json::from_str(&json).unwrap();
        assert_eq!((&line["channel"], &line["updated"]), (&id.into(), &true.into()));
        let kept = line["kept"].as_str().unwrap();
        assert_eq!(fs::read_to_string(kept).unwrap(), before);
        let after = config_of(&daemon);
        let new: Vec<&str> = after.lines().filter(|line| !before.contains(line)).collect();
        let written: f64 = new[0].strip_prefix("zero-ohm = ").unwrap().parse().unwrap();
        assert!(new.len() == 1 && (written - zero(&json, truth_ohm)).abs() < 1e-4, "{new:?}");
        assert_eq!(after.replace(&format!("{}\n", new[0]), ""), before);
    }
}

#[test]
fn a_zero_is_found_while_every_reading_says_short() {
    let daemon = daemon_with("cerm", "r-o-of = { x0 = \"34 ohm\", x1 = \"34 ohm\" }", [SHORT; 2]);
    let arguments = ["zero", "--channel", "thumb", "--count", "100", "--yes", "--json"];
    zero(&stdout(&mut calibrate(&daemon, &arguments)), -6.0);
}

#[test]
fn a_reference_is_taken_off() {
    let daemon = daemon("10 ohm", SHORT);
    let arguments = ["reference", "10 ohm", "--channel", "thumb", "--count", "100", "--json"];
    let json = stdout(calibrate(&daemon, &arguments).write_stdin("n\n"));
    zero(&json, 4.0);
    assert_eq!(serde_json::from_str::<Value>(&json).unwrap()["updated"], false);
    assert!(kept(daemon.folder.path()).is_empty());
}

/// Rc1 and Rc2 seem to be 22 ohm closer together than they are.
#[test]
fn a_reference_of_kilohms_takes_out_what_a_zero_leaves() {
    let pins = "r-o-of = { c1 = \"55 ohm\", c2 = \"33 ohm\" }";
    let daemon = daemon_with("cerm", pins, [SHORT, "12 kohm"]);
    let reference = ["reference", "12000", "--channel", "index", "--count", "200", "--yes", "--json"];
    let error =
        String::from_utf8(calibrate(&daemon, &reference).assert().code(1).get_output().stderr.clone())
            .unwrap();
    assert!(error.contains("first `cermctl calibrate zero`"), "{error}");
    let mut file = ConfigFile::of(&config_of(&daemon));
    fs::write(daemon.path("cermd.toml"), file.set("channel.index.zero-ohm", -15.87).to_string()).unwrap();
    let line: Value = serde_json::from_str(&stdout(&mut calibrate(&daemon, &reference))).unwrap();
    let (scale, u) = (line["scale"].as_f64().unwrap(), line["scale_u"].as_f64().unwrap());
    assert!(u < 2e-4 && (scale - 12_230.0 / 12_208.0).abs() < 4.0 * u, "{line}");
    assert!(
        config_of(&daemon).lines().any(|line| line.starts_with("scale = 1.00")),
        "{}",
        config_of(&daemon)
    );
}

#[test]
fn a_tracked_calibration_tells_a_zero_too() {
    let daemon = daemon_by("tracked", "10 ohm", SHORT);
    let arguments = ["reference", "10 ohm", "--channel", "thumb", "--count", "400", "--yes", "--json"];
    zero(&stdout(&mut calibrate(&daemon, &arguments)), 4.0);
}

#[test]
fn a_sensor_is_no_short_circuit() {
    let daemon = daemon("100 ohm", "2 kohm");
    let before = config_of(&daemon);
    let mut command = calibrate(&daemon, &["zero", "--channel", "index", "--count", "20", "--yes"]);
    let error = String::from_utf8(command.assert().code(1).get_output().stderr.clone()).unwrap();
    assert!(error.contains("more than pins and a series resistor make up; is the short circuit"), "{error}");
    let mut command = calibrate(&daemon, &["zero", "--yes"]);
    let error = String::from_utf8(command.assert().code(1).get_output().stderr.clone()).unwrap();
    assert!(error.contains("--channel; there is thumb, index"), "{error}");
    assert_eq!(config_of(&daemon), before);
    let manual = include_str!("../../docs/commissioning.md");
    assert!(manual.contains(&format!("A zero of more than {} ohm", cermd::config::LARGEST_ZERO_OHM)));
}

#[test]
fn an_open_sensor_is_not_waited_for_without_end() {
    for method in ["tracked", "cerm"] {
        let daemon = daemon_by(method, "100 Mohm", SHORT);
        let mut command = calibrate(&daemon, &["zero", "--channel", "thumb", "--count", "20", "--yes"]);
        let error = String::from_utf8(command.assert().code(1).get_output().stderr.clone()).unwrap();
        assert!(error.contains("of 20 discharges gave a number"), "{method}: {error}");
        assert!(error.contains("is the short circuit in the sensor's place?"), "{method}: {error}");
    }
}

#[test]
fn a_resistor_that_limits_the_current_is_part_of_the_zero() {
    let daemon = daemon("220 ohm", SHORT);
    let arguments = ["zero", "--channel", "thumb", "--count", "50", "--yes", "--json"];
    zero(&stdout(&mut calibrate(&daemon, &arguments)), 224.0);
}

#[test]
fn weights_are_measured_while_they_lie_on_the_sensor() {
    for method in ["cerm", "tracked"] {
        // 13346 N ohm at 1.2 N, and pins that differ by 4 ohm, not yet calibrated.
        weights(&daemon_by(method, "11122 ohm", SHORT));
    }
}

fn weights(daemon: &Daemon) {
    let arguments = ["force", "--channel", "thumb", "--count", "10", "--json"];
    let typed = "1.2 N\n6.06 N, 2204 ohm\n\ny\n";
    let json = stdout(calibrate(daemon, &arguments).write_stdin(typed));
    let line: Value = serde_json::from_str(&json).unwrap();
    let measured = line["pairs"][0]["r_ohm"].as_f64().unwrap();
    assert!((measured - 11_126.0).abs() < 30.0, "{json}");
    assert!(config_of(daemon).contains(&format!("force = {{ alpha = \"{} kN ohm\", u = ", {
        let alpha = line["alpha_n_ohm"].as_f64().unwrap();
        (alpha * 100.0).round() / 1e5
    })));
    // What reads "short" is no weight.
    let mut command = calibrate(daemon, &["force", "--channel", "index", "--count", "3"]);
    let assert = command.write_stdin("1 N\n\ny\n").assert().code(1);
    let error = String::from_utf8(assert.get_output().stderr.clone()).unwrap();
    assert!(error.contains("not taken: ") && error.contains("0 pair(s)"), "{error}");
}

/// A configuration in a folder of its own, for what needs no daemon.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Folder {
        let folder = Folder(tempfile::tempdir().unwrap());
        folder.configure(&Folder::file());
        fs::write(folder.path("weights.csv"), CSV).unwrap();
        folder
    }

    fn file() -> ConfigFile {
        let mut file = config();
        file.set("mock.scene", "ideal").unset(&["channel"]).channel("thumb");
        // Of the paper, as its F_c1 is.
        file.set("circuit.r-c1", "2.32 kohm");
        file.lines("channel.thumb", "force = { alpha = \"13346 N ohm\" }");
        file
    }

    fn configure(&self, file: &ConfigFile) {
        fs::write(self.path("cermd.toml"), format!("# kept\n{file}# kept, too\n")).unwrap();
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn config(&self) -> String {
        fs::read_to_string(self.path("cermd.toml")).unwrap()
    }

    fn force(&self, arguments: &[&str]) -> Command {
        let mut command = ctl(&["calibrate", "force"]);
        command.args(arguments).current_dir(self.0.path()).args(["--config", "cermd.toml"]);
        command
    }
}

#[test]
fn the_sensor_of_the_paper_comes_out_and_is_written_after_a_yes() {
    let folder = Folder::new();
    let before = folder.config();
    let arguments = ["--csv", "weights.csv", "--plot", "plot.svg"];
    let text = stdout(folder.force(&arguments).write_stdin("y\n"));
    for wanted in [
        "F_c1 = 5.75 N",
        "F_c2 = 1.05 N",
        "relative rms of the residuals: 0.0",
        "systemctl reload cermd",
        "alpha = 13345.9 +- 2.7 N ohm",
    ] {
        assert!(text.contains(wanted), "{wanted:?} is missing:\n{text}");
    }
    let stored = "\"13.34586 kN ohm\", u = \"0.1 %\", range = [\"1.2 N\", \"6.06 N\"]";
    assert_eq!(folder.config(), before.replace("\"13346 N ohm\"", stored));
    let kept = kept(folder.0.path());
    assert_eq!((kept.len(), fs::read_to_string(&kept[0]).unwrap()), (1, before));
    assert!(fs::read_to_string(folder.path("plot.svg")).unwrap().ends_with("</svg>\n"));
}

#[test]
fn anything_but_a_yes_changes_nothing() {
    let folder = Folder::new();
    let before = folder.config();
    for answer in ["", "n\n", "\n", "y", "perhaps\n"] {
        let text = stdout(folder.force(&["--csv", "weights.csv"]).write_stdin(answer));
        assert!(text.ends_with("cermd.toml is as it was\n"), "{answer:?}: {text}");
    }
    // Cut off while weights are typed.
    for typed in ["", "1.2 N, 11122 ohm\n", "1.2 N, 11122 ohm\n6.06 N, 22", "11122, 1.2\n\n"] {
        folder.force(&["--yes"]).write_stdin(typed).assert().code(1);
    }
    assert_eq!(folder.config(), before);
    assert_eq!(fs::read_dir(folder.0.path()).unwrap().count(), 2);
}

#[test]
fn bad_input_is_named_and_changes_nothing() {
    let folder = Folder::new();
    let before = folder.config();
    let cases = [
        ("alpha", "1.2,11122\n6.06;2200\n", "weights.csv, line 2: "),
        ("alpha", "", "0 pair(s) of force and resistance: it takes at least 1"),
        ("alpha", "1,NaN\n", "weights.csv, line 1: "),
        ("power", "1.2,11122\n1.2,11100\n", "all pairs have the same force"),
        ("power", "1.2,2200\n6.06,11122\n9,12000\n", "does not fall while the force rises"),
        ("table", "1.2,11122\n6.06,12000\n", "not monotone"),
        ("alpha", "11122,1.2\n2200,6.06\n", "weights.csv: the columns look swapped: forces of 11122 N"),
        ("power", "11122,1.2\n2200,6.06\n", "look swapped"),
        ("table", "r_ohm,force_n\n1.2,11122\n6.06,2200\n", "the columns are swapped: \"r_ohm\" comes first"),
        // One weight in gram among others in newton.
        ("alpha", "1.2,11122\n6.06,2200\n200,6670\n", "that is no fit: the weights are off it by "),
    ];
    for (model, csv, wanted) in cases {
        fs::write(folder.path("weights.csv"), csv).unwrap();
        let mut command = folder.force(&["--csv", "weights.csv", "--yes", "--model", model]);
        let error = String::from_utf8(command.assert().code(1).get_output().stderr.clone()).unwrap();
        assert!(error.contains(wanted), "{wanted}: {error}");
        assert_eq!(folder.config(), before);
    }
}

#[test]
fn every_model_gives_a_usable_configuration() {
    for (model, wanted) in [("power", "at-1-kohm = "), ("table", "force-thumb-")] {
        let folder = Folder::new();
        stdout(folder.force(&["--csv", "weights.csv", "--model", model, "--yes"]).write_stdin(""));
        assert!(folder.config().contains(wanted), "{}", folder.config());
        let text = stdout(ctl(&["check", "--config", "cermd.toml"]).current_dir(folder.0.path()));
        assert!(text.contains(": usable: 0 error(s)"), "{text}");
    }
}

#[test]
fn weights_that_are_all_on_the_fit_state_no_uncertainty() {
    for (model, csv, says) in [
        ("alpha", "1,10000\n2,5000\n", "all weights are on the fit"),
        ("alpha", "1.2,11122\n1.2,11122\n", "all weights are on the fit"),
        ("power", "1,8000\n2,4000\n4,2000\n", "all weights are on the fit"),
        ("alpha", "1.2,11122\n", "as many numbers were fitted as there are weights"),
    ] {
        let folder = Folder::new();
        fs::write(folder.path("weights.csv"), csv).unwrap();
        let mut command = folder.force(&["--csv", "weights.csv", "--model", model, "--yes"]);
        let text = stdout(command.write_stdin(""));
        assert!(text.contains(says), "{csv}: {text}");
        let config = folder.config();
        assert!(!config.contains("u = \""), "{config}");
        // Only what is stored is announced.
        assert_eq!(text.contains("are marked as extrapolated"), config.contains("range = ["), "{text}");
    }
}

#[test]
fn a_configuration_that_would_not_be_usable_stays_as_it_is() {
    let folder = Folder::new();
    folder.configure(Folder::file().set("mock.scene", "pi9"));
    let broken = folder.config();
    let mut command = folder.force(&["--csv", "weights.csv", "--yes", "--model", "table"]);
    let error = String::from_utf8(command.assert().code(1).get_output().stderr.clone()).unwrap();
    assert!(error.contains("nothing was changed") && error.contains("error: mock.scene"), "{error}");
    assert_eq!(folder.config(), broken);
    assert_eq!(fs::read_dir(folder.0.path()).unwrap().count(), 2, "nothing is left behind");
}

#[test]
fn what_residuals_mean_is_said_with_them() {
    let folder = Folder::new();
    let bent: String =
        [0.5f64, 1.0, 2.0, 4.0].map(|f_n| format!("{f_n},{}\n", 13_346.0 * f_n.powf(-0.8))).concat();
    fs::write(folder.path("weights.csv"), bent).unwrap();
    let text = |model| stdout(folder.force(&["--csv", "weights.csv", "--model", model]).write_stdin("n\n"));
    let alpha = text("alpha");
    for wanted in [
        "a residual is how much more resistance than the fit a weight made",
        "they are no scatter but a bend: `--model power` leaves 0.00 % of them",
        "readings outside of 500 mN to 4 N are marked as extrapolated",
        // At 2.32 kohm more than the greatest, at 12.7 kohm more than the least, which has 23.2 kohm.
        "N (at Rc1; above all weights)",
        "N (at Rc2)",
    ] {
        assert!(alpha.contains(wanted), "{wanted:?} is missing:\n{alpha}");
    }
    let heavy: String = [2.0f64, 4.0].map(|f_n| format!("{f_n},{}\n", 13_346.0 / f_n)).concat();
    fs::write(folder.path("heavy.csv"), heavy).unwrap();
    let heavy = stdout(folder.force(&["--csv", "heavy.csv"]).write_stdin("n\n"));
    assert!(heavy.contains("F_c2 = 1.05 N (at Rc2; below all weights)"), "{heavy}");
    assert!(!text("power").contains("--model"), "a power law has no bend left");
    assert!(text("table").contains("outside of 500 mN to 4 N have no force"));
}

#[test]
fn progress_is_shown_on_a_terminal() {
    let daemon = daemon(SHORT, SHORT);
    let arguments = "calibrate zero --channel thumb --count 400 --yes --config cermd.toml";
    let text = on_a_terminal(&daemon, arguments, 60, |text| text.contains("is updated"));
    assert!(text.contains(" of 400 discharges: ") && text.contains("is updated"), "{text}");
}
