//! x
#![allow(clippy::unwrap_used, clippy::panic)]
mod common;
use cermd::reading::Method;
use common::{Bench, Errors, read, settle};

#[test]
fn explore() {
    for scene in ["pi4", "fpga-paper"] {
        for method in [Method::Cerm, Method::Tracked, Method::Tcdic] {
            for cal in ["each-reading", "tracked"] {
                for r in [100.0, 1000.0, 16200.0] {
                    let mut all = Errors::default();
                    let mut time = 0.0;
                    let mut counts = (0, 0, 0);
                    for seed in 0..20 {
                        let mut i = Bench::new(scene, method, r, seed, &format!("calibration = \"{cal}\""))
                            .instrument();
                        settle(&mut i);
                        read(&mut i, 40, |_| {});
                        let t0 = cermd::pins::Pins::now(i.pins());
                        read(&mut i, 100, |reading| all.add(reading, r));
                        time += (cermd::pins::Pins::now(i.pins()) - t0).as_seconds() / 2000.0;
                        if let Some(c) = i.stats().tracking {
                            counts = (counts.0 + c.used, counts.1 + c.rejected, counts.2 + c.steps);
                        }
                    }
                    println!(
                        "{scene:10} {:8} {cal:12} {r:7} n {:5} bias {:8.3} sd {:8.3} u {:8.3} cover {:.3} inf {:.2} nou {} notok {} ms {:.1} sd*sqrt(t) {:.3} {counts:?}",
                        method.as_str(),
                        all.count(),
                        all.mean(),
                        all.sd(),
                        all.mean_u(),
                        all.coverage(),
                        all.inferred as f64 / all.count() as f64,
                        all.without_u,
                        all.not_ok.len(),
                        time * 1e3,
                        all.sd() * time.sqrt()
                    );
                }
            }
        }
    }
}

#[test]
fn runs() {
    for (scene, r) in [("pi4", 300.0), ("pi-zero", 300.0)] {
        for seed in 0..24 {
            let mut i = Bench::new(scene, Method::Tracked, r, seed, "").instrument();
            settle(&mut i);
            read(&mut i, 40, |_| {});
            let mut all = Errors::default();
            read(&mut i, 100, |reading| all.add(reading, r));
            let e = i.cycle().estimator();
            let t = e.tracker().unwrap();
            let sw = cermd::record::Switch {
                at_ns: 0.8 * t.state()[1] * (r + 40.0),
                on_ns: 0.8 * t.state()[1] * (r + 40.0),
                to: cermd::record::Through::C2,
            };
            let f = e.foresee(r, Some(sw), 2.0e3).unwrap();
            println!(
                "{scene} {seed:2} mean {:7.3} sd {:6.3} u {:6.3} bound {:6.3} calpart {:6.3} walk {:.1e} d {:?} ro {:?} sw {:?} cov {:.2} {:?}",
                all.mean(),
                all.sd(),
                all.mean_u(),
                f.bound.sqrt(),
                cermd::tracker::quadratic(t.covariance(), &f.by_state).sqrt(),
                t.walk_g(),
                t.d_ns(),
                t.r_o_ohm(),
                t.switch_ns(),
                all.coverage(),
                t.counts()
            );
        }
    }
}

#[test]
fn fpga_truth() {
    let r = 100.0;
    let mut i = Bench::new("fpga-paper", Method::Tracked, r, 26, "").instrument();
    settle(&mut i);
    read(&mut i, 40, |_| {});
    for _ in 0..6 {
        let mut rec = None;
        while !matches!(rec, Some(cermd::record::Record { through: cermd::record::Through::X(_), .. })) {
            i.step(&mut |m| {
                if let cermd::instrument::Message::Discharge { record, .. } = m {
                    rec = Some(record)
                }
            })
            .unwrap();
        }
        println!("{:?}", rec);
        let t = i.pins().truth().clone();
        println!(
            "  truth changes {:?} a {:?} b {:?}",
            t.changes(),
            t.crossing_ns(cermd::pins::Node::A),
            t.crossing_ns(cermd::pins::Node::B)
        );
    }
    let t = *i.cycle().estimator().tracker().unwrap().state();
    let c = i.pins().circuit().clone();
    println!("[{t:?} {:?} {} {}", c.wiring, c.v_dd, c.sense[0].falling);
}
