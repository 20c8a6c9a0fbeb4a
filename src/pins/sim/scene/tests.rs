use super::*;
use crate::pins::sim::network::line_index;

const IDEAL: &str = include_str!("../../../../hw/scenes/ideal.toml");

fn error(text: &str) -> String {
    Scene::parse(text, Path::new("test.toml")).unwrap_err().to_string()
}

fn changed(from: &str, to: &str) -> String {
    assert!(IDEAL.contains(from), "{from}");
    error(&IDEAL.replace(from, to))
}

#[test]
fn every_built_in_scene_is_sound_and_serves_every_kind() {
    for name in Scene::builtin_names() {
        for kind in [Kind::OneCapacitor, Kind::SeriesCalibration, Kind::TwoCapacitor] {
            let scene = Scene::builtin(name).unwrap().with_kind(kind).unwrap();
            let v_th = scene.circuit.threshold.falling.0;
            let (c_a, c_b) = (scene.circuit.c_a.unwrap().0, scene.circuit.c_b.unwrap().0);
            assert!(
                v_th * (c_a + c_b) > 1.3 * scene.circuit.v_dd.0 * c_b,
                "{name}: B crosses, with a margin"
            );
        }
    }
    assert!(Scene::builtin("pi9").unwrap_err().to_string().contains("fpga-paper"));
}

#[test]
fn errors_name_the_key_and_the_remedy() {
    let unknown = changed("v-dd", "vdd");
    assert!(unknown.contains("vdd") && unknown.contains("expected one of"), "{unknown}");
    let unit = changed("2.2 uF", "2.2 uH");
    assert!(unit.contains("line 6") && unit.contains("such as \"2.2 uF\""), "{unit}");
    for (from, to, key) in [
        ("680 nF", "0 F", "circuit.c-b: has to be above 0"),
        ("falling = \"1.3 V\"", "falling = \"3.4 V\"", "circuit.threshold: has to be below v-dd"),
        (
            "falling = \"1.3 V\"",
            "falling = \"1.3 V\", rising = \"1 V\"",
            "circuit.threshold.rising: must not",
        ),
        ("c-b = \"680 nF\"", "", "circuit: has to have c-a and c-b"),
        ("40 ohm", "-40 ohm", "circuit.r-o: has to be above 0"),
        ("constant = \"1 kohm\"", "constant = \"-1 ohm\"", "sensor 0: must not be negative"),
        (
            "v-dd =",
            "absorption = { c-b = [{ share = 2.5, tau = \"1 ms\" }] }\nv-dd =",
            "circuit.absorption.c-b.share: is of the capacitor",
        ),
        (
            "v-dd =",
            "absorption = { c-a = [{ share = 0.1, tau = \"0 s\" }] }\nv-dd =",
            "circuit.absorption.c-a.tau: has to be above 0",
        ),
    ] {
        let error = changed(from, to);
        assert!(error.starts_with(&format!("test.toml: {key}")), "{error}");
    }
    for (effect, key) in [
        ("[events]\nlost = 1.5", "events.lost: is a probability"),
        ("[events]\ncoalesced = 0.5", "events: coalesced and bounce belong together"),
        ("[events]\nbuffer = 0", "events.buffer"),
        ("[stamps]\nmean = \"1 us\"\ntail-mean = \"1 us\"", "stamps: tail-probability and tail-mean"),
        (
            "[calls]\nfixed = \"1 us\"\nper-line = \"1 us\"\nwakes-in = \"2 us\"",
            "calls: asleep-after and wakes-in",
        ),
        (
            "[calls]\nfixed = \"1 us\"\nper-line = \"1 us\"\njitter = 1e300",
            "calls.jitter: is a part of a call's time: write a number from 0 to 1",
        ),
        ("[stamps]\nmean = \"-1 us\"", "stamps.mean: has to be from 0 s to 1 s"),
        // A thread that sleeps for ever cannot be stopped.
        ("[stamps]\nmean = \"1 us\"\njitter = \"1e30 s\"", "stamps.jitter: has to be from 0 s to 1 s"),
        ("[sleep]\nmean = \"1.1 s\"", "sleep.mean: has to be"),
        ("[wake]\nmean = \"1 us\"\ntail-probability = 0.1\ntail-mean = \"1e9 s\"", "wake.tail-mean: has to"),
        ("[calls]\nfixed = \"1e30 s\"\nper-line = \"1 us\"", "calls.fixed: has to be"),
        ("[reads]\nlevels = \"1e30 s\"", "reads.levels: has to be"),
        ("[events]\ncoalesced = 0.1\nbounce = \"1e30 s\"", "events.bounce: has to be"),
        ("[calls]\nfixed = \"1 us\"\nper-line = \"1 us\"\nmoves-at = [0.7, 0.2]", "calls.moves-at"),
        (
            "[calls]\nfixed = \"1 us\"\nper-line = \"1 us\"\nmoves-at = [0.0, 101.0]",
            "calls.moves-at: is [from, to] in slots",
        ),
        ("[events]\nb-later = \"-1 us\"", "events.b-later: has to be from 0 s to 1 s"),
        (
            "[events]\ndeep-sleep-late = \"1 us\"",
            "events: deep-sleep-after and deep-sleep-late belong together",
        ),
        ("[ticks]\nevery = \"0 s\"\ntakes = \"1 us\"", "ticks.every: has to be above 0"),
        ("[ticks]\nevery = \"1 ms\"\ntakes = \"0.6 ms\"", "ticks.takes: has to be at most half of every"),
        ("[walk]\nr-o = \"-1 ohm\"", "walk.r-o: has to be above 0"),
        ("[noise]\nvoltage = \"0 V\"", "noise.voltage: has to be above 0"),
        (
            "[[sensor]]\nsine = { mean = \"1 ohm\", amplitude = \"2 ohm\", frequency = \"1 Hz\" }",
            "sensor 1.amplitude",
        ),
    ] {
        let error = error(&format!("{IDEAL}\n{effect}"));
        assert!(error.starts_with(&format!("test.toml: {key}")), "{error}");
    }
    let branch = "{ share = 0.01, tau = \"1 ms\" }, ".repeat(7);
    let many = changed("v-dd =", &format!("absorption = {{ c = [{branch}] }}\nv-dd ="));
    assert!(many.contains("circuit.absorption.c: can have at most 6 branches"), "{many}");
    let clock = error(&format!("clock-period = \"20 ns\"\n{IDEAL}\n[wake]\nmean = \"1 us\""));
    assert!(clock.contains("clock-period: excludes"), "{clock}");
    let clock = error(&format!("clock-period = \"1e30 s\"\n{IDEAL}"));
    assert!(clock.contains("clock-period: has to be a whole number"), "{clock}");
}

#[test]
fn single_pins_may_differ() {
    let text = IDEAL.replace("v-dd =", "r-o-of = { x2 = \"55 ohm\", c1 = \"41 ohm\" }\nv-dd =");
    let circuit = Scene::parse(&text, Path::new("")).unwrap().network();
    assert_eq!(circuit.r_o[line_index(Drives::x(2))], 55.0);
    assert_eq!(circuit.r_o[line_index(Drives::C1)], 41.0);
    assert_eq!(circuit.r_o[line_index(Drives::C2)], 40.0);
    assert!(error(&text.replace("x2", "x16")).contains("is no line"));
}

#[test]
fn a_sensor_may_come_from_a_file_beside_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    let text = IDEAL.replace("constant = \"1 kohm\"", "file = { path = \"r.csv\" }");
    std::fs::write(&scene, text).unwrap();
    assert!(Scene::load(&scene).unwrap_err().to_string().contains("r.csv"));
    std::fs::write(folder.path().join("r.csv"), "time_s,ohm\n0,100\n1.5, 200\n").unwrap();
    let loaded = Scene::load(&scene).unwrap();
    assert!(
        matches!(&loaded.sensors[0], Sensor::File { points, .. } if *points == [(0.0, 100.0), (1.5, 200.0)])
    );
    std::fs::write(folder.path().join("r.csv"), "0,100\n0,200\n").unwrap();
    assert!(Scene::load(&scene).unwrap_err().to_string().contains("line 2"));
}
