use crate::common::seed::rng;
use crate::common::{Bench, Errors, kind_of, read};
use cermd::pins::sim::{Kind, Scene, Sensor};
use cermd::reading::Method;
use cermd::units::*;

fn one(name: &str, method: Method, r: f64, warm_s: f64, change: &dyn Fn(&mut Scene)) -> Errors {
    let mut all = Errors::default();
    let n = std::env::var("BOARDS").ok().and_then(|s| s.parse().ok()).unwrap_or(30u64);
    for seed in 0..n {
        let mut bench = Bench::new("pi4", method, r, seed, "deadline = \"400 ms\"");
        change(&mut bench.scene);
        if let Ok(r) = std::env::var("RC1") {
            bench.config.set("circuit", "r-c1", format!("{r} ohm"));
            bench.scene.circuit.r_c1 = Ohm(r.parse().unwrap());
        }
        let mut instrument = bench.instrument();
        while instrument.pins().now() < Nanos((warm_s * 1e9) as i64) {
            let _ = instrument.step(&mut |_| {});
        }
        all.next_board();
        if std::env::var("SHOW").is_ok() {
            let t = instrument.cycle().estimator().tracker().unwrap();
            println!(
                "   state {:?} u {:?} counts {:?} cycles {}",
                t.state(),
                [2, 3, 4].map(|i| t.covariance()[i][i].sqrt()),
                t.counts(),
                instrument.stats().cycles
            );
        }
        read(&mut instrument, 40, |reading| all.add(reading, r));
    }
    println!(
        "{name:28} {:8} {r:8} {} pull {:.2} sd {:.3} rms {:.3} u {:.3} n {}",
        method.as_str(),
        all.within_2u(),
        all.pulls().value,
        all.sd(),
        (all.errors.iter().map(|e| e * e).sum::<f64>() / all.count() as f64).sqrt(),
        all.mean_u(),
        all.count() as f64 / (40 * n) as f64
    );
    all
}
use cermd::pins::Pins;
#[test]
fn table() {
    let only = std::env::var("ROWS").unwrap_or_default();
    let scene = |extra: &'static str| {
        move |s: &mut Scene| {
            let text = format!("{extra}");
            apply(s, &text);
        }
    };
    let rows: Vec<(&str, &'static str)> = vec![
        ("clean", ""),
        ("whole-call", "calls.moves=-1.05,2.05"),
        ("call 2.3", "calls.per=1.7;calls.moves=0,1"),
        ("posted 0..3", "calls.moves=0,3"),
        ("b later 3", "b=3"),
        ("deep 4ms 2us", "deep=4,2"),
        ("ro walk 1", "walk=1"),
        ("ro walk .2", "walk=0.2"),
        ("ro pins 47/38/41", "pins"),
        ("PET worst 10ms", "abs=0.0025,10"),
        ("PET spread", "abs5=0.0005"),
        ("PP 10ms", "abs=0.0005,10"),
        ("X7R 5x0.5%", "abs5=0.005"),
        ("leak A 1M", "leaka=1e6"),
        ("leak A 100k", "leaka=1e5"),
        ("pull A 1M", "pull=1e6"),
        ("leak B 3M", "leakb=3e6"),
        ("-5uA at A", "cur=-5e-6"),
        ("tail 30% 1ms", "tail"),
    ];
    for (name, extra) in rows {
        if !only.is_empty() && !only.split(',').any(|o| name.contains(o)) {
            continue;
        }
        let warm = std::env::var("WARM").ok().and_then(|s| s.parse().ok()).unwrap_or(12.0);
        for r in [100.0, 1000.0, 5000.0, 16200.0] {
            one(name, Method::Tracked, r, warm, &scene(extra));
        }
        if std::env::var("CERM").is_ok() {
            for r in [100.0, 1000.0] {
                one(name, Method::Cerm, r, warm, &scene(extra));
            }
        }
    }
}
fn apply(s: &mut Scene, text: &str) {
    let f = |v: &str| -> Vec<f64> { v.split(',').map(|x| x.parse().unwrap()).collect() };
    for part in text.split(';').filter(|p| !p.is_empty()) {
        let (key, v) = part.split_once('=').unwrap_or((part, ""));
        match key {
            "calls.moves" => s.calls.as_mut().unwrap().moves_at = Some([f(v)[0].max(0.0), f(v)[1]]),
            "calls.per" => s.calls.as_mut().unwrap().per_line = Seconds(f(v)[0] * 1e-6),
            "b" => s.events = Some(toml::from_str(&format!("b-later = \"{v} us\"")).unwrap()),
            "deep" => {
                s.events = Some(
                    toml::from_str(&format!(
                        "deep-sleep-after = \"{} ms\"\ndeep-sleep-late = \"{} us\"",
                        f(v)[0],
                        f(v)[1]
                    ))
                    .unwrap(),
                )
            }
            "walk" => s.walk = Some(toml::from_str(&format!("r-o = \"{v} ohm\"")).unwrap()),
            "pins" => {
                for (k, r) in [("c1", 38.0), ("c2", 41.0), ("x0", 47.0)] {
                    s.circuit.r_o_of.insert(k.into(), Ohm(r));
                }
            }
            "abs" => {
                let b = format!(
                    "c-a = [{{share={},tau=\"{} ms\"}}]\nc-b = [{{share={},tau=\"{} ms\"}}]",
                    f(v)[0],
                    f(v)[1],
                    f(v)[0],
                    f(v)[1]
                );
                s.circuit.absorption = toml::from_str(&b).unwrap();
            }
            "abs5" => {
                let one: Vec<String> = [0.3, 3.0, 30.0, 300.0, 3000.0]
                    .iter()
                    .map(|t| format!("{{share={v},tau=\"{t} ms\"}}"))
                    .collect();
                let b = format!("c-a=[{}]\nc-b=[{}]", one.join(","), one.join(","));
                s.circuit.absorption = toml::from_str(&b).unwrap();
            }
            "leaka" => s.circuit.node_a.leakage_resistance = Some(Ohm(v.parse().unwrap())),
            "leakb" => s.circuit.node_b.leakage_resistance = Some(Ohm(v.parse().unwrap())),
            "pull" => s.circuit.node_a.pull_up = Some(Ohm(v.parse().unwrap())),
            "cur" => s.circuit.node_a.leakage = Some(Ampere(v.parse().unwrap())),
            "tail" => {
                let st = s.stamps.as_mut().unwrap();
                st.tail_probability = Some(0.3);
                st.tail_mean = Some(Seconds(1e-3));
            }
            _ => panic!("{key}"),
        }
    }
    let _ = (kind_of(Method::Tracked), Kind::TwoCapacitor, rng(1), Sensor::Constant(Ohm(1.0)));
}
