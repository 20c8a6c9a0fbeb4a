use super::*;
use crate::chance::{rms_of, sigmas};

const KNOWN: [f64; 2] = [2320.0, 12_700.0];
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal, Uniform};

/// The FSR 402 of the paper, by least squares from 17 pairs. Two of them are in its text; the others are only drawn.
const ALPHA: f64 = 13346.46;
/// What one FSR 402 repeats to: +-2 %, one standard deviation by the mean at 1000 g (Interlink, "FSR 400 Series Data Sheet",
/// force repeatability of a single part).
const REPEATABILITY: f64 = 0.02;

fn pair(f_n: f64, r_ohm: f64) -> Weighing {
    Weighing { f_n, r_ohm }
}

#[test]
fn the_sensor_of_the_paper_is_found_again() {
    // Two pairs that the paper names; alpha hangs on the light one, which is rounded to 0.01 N.
    let pairs = [pair(6.06, 2200.0), pair(1.20, 11122.0)];
    let fit = alpha(&pairs).unwrap();
    let Law::Alpha { alpha_n_ohm } = fit.law else { panic!("{fit:?}") };
    let rounding = ALPHA * 0.005 / 1.2;
    assert!((alpha_n_ohm - ALPHA).abs() < rounding, "{alpha_n_ohm}");
    for pair in pairs {
        let of_paper = Fit { law: Law::Alpha { alpha_n_ohm: ALPHA }, u: [None; 2] };
        assert!(of_paper.residual(pair).abs() < REPEATABILITY, "{pair:?}");
        let at = |r_ohm| format!("{:.2}", Force::from(of_paper.law.clone()).at_bound(r_ohm, KNOWN).unwrap());
        assert_eq!([at(2320.0), at(12_700.0)], ["5.75", "1.05"]);
        assert!(fit.residual(pair).abs() < REPEATABILITY, "{pair:?}");
    }
    // F_c1 and F_c2 at its calibration resistors.
    let force = Force::from(fit.law.clone());
    assert_eq!(format!("{:.2}", force.at_bound(2320.0, KNOWN).unwrap()), "5.75");
    assert_eq!(format!("{:.2}", force.at_bound(12_700.0, KNOWN).unwrap()), "1.05");
}

/// (value - truth) / u over many random sensors: its root mean square, and how many there were.
fn pulls(mut draw: impl FnMut(&mut ChaCha8Rng) -> (f64, Measured)) -> f64 {
    const TIMES: usize = 2000;
    let mut rng = crate::seed::rng(402);
    let pull = |(truth, found): (f64, Measured)| (found.value - truth) / found.u.unwrap();
    let squares: f64 = (0..TIMES).map(|_| pull(draw(&mut rng)).powi(2)).sum();
    (squares / TIMES as f64).sqrt()
}

/// The root mean square of Student's t with `nu` degrees of freedom, and how far chance takes its estimate from 2000 draws.
fn student(nu: f64) -> std::ops::Range<f64> {
    let variance = nu / (nu - 2.0);
    let kurtosis = 3.0 + 6.0 / (nu - 4.0);
    let u = ((kurtosis - 1.0) / 2000.0).sqrt() / 2.0;
    variance.sqrt() * (1.0 - sigmas() * u)..variance.sqrt() * (1.0 + sigmas() * u)
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

fn between(rng: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    Uniform::new(low, high).unwrap().sample(rng)
}

#[test]
fn alpha_is_off_by_what_its_uncertainty_says() {
    let rms = pulls(|rng| {
        let (truth, sigma_ohm) = (between(rng, 1e3, 1e5), between(rng, 1.0, 100.0));
        let pairs: Vec<Weighing> = (0..12)
            .map(|_| {
                let f_n = between(rng, 0.5, 20.0);
                pair(f_n, truth / f_n + sigma_ohm * normal(rng))
            })
            .collect();
        match alpha(&pairs).unwrap() {
            Fit { law: Law::Alpha { alpha_n_ohm: value }, u: [u, _] } => (truth, Measured { value, u }),
            other => panic!("{other:?}"),
        }
    });
    assert!(student(11.0).contains(&rms), "{rms}");
}

fn random_power(rng: &mut ChaCha8Rng) -> ([f64; 2], [Measured; 2]) {
    let (f_1k, p) = (between(rng, 2.0, 30.0), between(rng, 0.6, 1.6));
    let pairs: Vec<Weighing> = (0..14)
        .map(|_| {
            let f_n = between(rng, 0.5, 20.0);
            pair(f_n, 1000.0 * (f_n / f_1k).powf(-1.0 / p) * (0.01 * normal(rng)).exp())
        })
        .collect();
    match power(&pairs).unwrap() {
        Fit { law: Law::Power { at_1_kohm_n, exponent }, u: [u_n, u] } => {
            ([f_1k, p], [Measured { value: at_1_kohm_n, u: u_n }, Measured { value: exponent, u }])
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_power_law_is_off_by_what_its_uncertainties_say() {
    for index in 0..2 {
        let rms = pulls(|rng| {
            let (truth, found) = random_power(rng);
            (truth[index], found[index])
        });
        assert!(student(12.0).contains(&rms), "{index}: {rms}");
    }
}

#[test]
fn every_fit_goes_through_pairs_that_follow_it() {
    let pairs: Vec<Weighing> = [0.5, 1.2, 6.06, 20.0].map(|f_n| pair(f_n, ALPHA / f_n)).to_vec();
    for fit in [alpha(&pairs).unwrap(), power(&pairs).unwrap(), table(&pairs).unwrap()] {
        assert!(fit.relative_rms(&pairs).unwrap() < 1e-12, "{fit:?}");
        for pair in &pairs {
            assert!(
                (fit.force(&pairs).at_bound(pair.r_ohm, KNOWN).unwrap() / pair.f_n - 1.0).abs() < 1e-9,
                "{fit:?}"
            );
        }
    }
    let off = [pair(1.0, 101.0), pair(1.0, 99.0)];
    assert!((alpha(&off).unwrap().relative_rms(&off).unwrap() - 0.01).abs() < 1e-12);
}

#[test]
fn what_cannot_be_fitted_is_refused() {
    assert!(matches!(alpha(&[]), Err(FitError::Few { found: 0, needed: 1 })));
    assert!(matches!(power(&[pair(1.0, 5.0)]), Err(FitError::Few { found: 1, needed: 2 })));
    assert!(matches!(power(&[pair(3.3, 5.0), pair(3.3, 6.0), pair(3.3, 7.0)]), Err(FitError::OneForce)));
    assert!(matches!(power(&[pair(1.0, 5.0), pair(2.0, 6.0)]), Err(FitError::Rising)));
    assert!(matches!(table(&[pair(1.0, 5.0), pair(2.0, 6.0)]), Err(FitError::Table(_))));
    // One pair has no scatter to tell from.
    assert!(matches!(alpha(&[pair(1.0, 5.0)]), Ok(Fit { u: [None, None], .. })));
}

#[test]
fn what_readings_share_is_in_the_uncertainty_of_their_mean() {
    assert_eq!(mean(&[]), None);
    assert_eq!(mean(&[2.0]), Some(Measured { value: 2.0, u: None }));
    let mut rng = crate::seed::rng(1);
    // 10 calibrations with 10 readings each: the shared part counts 10 times, not 100.
    let found: Vec<Measured> = (0..400)
        .map(|_| {
            let shared: Vec<f64> = (0..10).map(|_| normal(&mut rng)).collect();
            let readings: Vec<f64> =
                (0..100).map(|index| shared[index / 10] + 0.1 * normal(&mut rng)).collect();
            mean(&readings).unwrap()
        })
        .collect();
    let stated = rms_of(&found.iter().map(|one| one.u.unwrap()).collect::<Vec<_>>());
    let errors = rms_of(&found.iter().map(|one| one.value).collect::<Vec<_>>());
    assert!(errors.is(0.1001f64.sqrt(), 0.0), "{errors}");
    assert!(stated.over(errors).is_in(0.8..=1.2), "{stated} for {errors}");
}

#[test]
fn what_the_residuals_are_is_the_uncertainty_of_a_force() {
    // Off by 10 % to either side: with one parameter, three degrees of freedom.
    let pairs = [(1.0, 1.1), (2.0, 0.9), (4.0, 1.1), (8.0, 0.9)].map(|(f_n, off)| pair(f_n, 1e4 / f_n * off));
    let fit = Fit { law: Law::Alpha { alpha_n_ohm: 1e4 }, u: [None; 2] };
    let Force { u, range_n, .. } = fit.force(&pairs);
    assert!((u.unwrap() - 0.1 * (4.0f64 / 3.0).sqrt()).abs() < 1e-9, "{u:?}");
    assert_eq!(range_n, Some([1.0, 8.0]));
    // One pair, and a table, say nothing of how far the sensor is off between them.
    assert_eq!(fit.force(&pairs[..1]).u, None);
    assert_eq!(fit.force(&pairs[..1]).range_n, None, "one force is no range");
    assert_eq!(table(&pairs).unwrap().force(&pairs).u, None);
}
