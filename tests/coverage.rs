//! Honest uncertainty: 95 % of the readings lie within two of their own sigma.
mod common;

use cermd::reading::Method;
use common::{Bench, Errors, read, settle};

#[test]
#[ignore]
fn explore() {
    for scene in ["pi4", "pi-zero", "pi5", "fpga-paper"] {
        for method in Method::ALL {
            for r in [31.0, 310.0, 3100.0, 31000.0] {
                let mut all = Errors::default();
                for seed in 0..20 {
                    let mut instrument =
                        Bench::new(scene, method, r, seed, "deadline = \"400 ms\"").instrument();
                    settle(&mut instrument);
                    read(&mut instrument, 40, |_| {});
                    read(&mut instrument, 100, |reading| all.add(reading, r));
                }
                println!(
                    "{scene:10} {:5} {r:7} n {:5} bias {:8.3} sd {:8.3} u {:8.3} cover {:.3} inf {:.2} nou {} notok {} ",
                    method.as_str(),
                    all.count(),
                    all.mean(),
                    all.sd(),
                    all.mean_u(),
                    all.coverage(),
                    all.inferred as f64 / all.count() as f64,
                    all.without_u,
                    all.not_ok.len()
                );
            }
        }
    }
}
