use super::*;
use crate::chance::{WITHIN_2U, share_is, share_is_in};
use crate::seed::rng;
use crate::sensor::ldr::Ldr;
use crate::sensor::ntc::{Curve, Ntc};
use crate::sensor::position::Position;
use crate::sensor::pt1000::{Class, Pt1000};
use crate::sensor::table::{Pairs, Tabled};
use proptest::prelude::*;
use rand_distr::{Distribution, StandardNormal, Uniform};

const KNOWN: [f64; 2] = [2320.0, 12700.0];

/// Pins of their own at R_1, R_2 and the sensor, by the two-point formula.
#[test]
fn what_pins_make_of_a_reading_is_in_its_uncertainty_until_it_is_known() {
    let reads = |r: f64, [c1, c2, x]: [f64; 3]| {
        KNOWN[0] + (r + x - KNOWN[0] - c1) / (KNOWN[1] + c2 - KNOWN[0] - c1) * (KNOWN[1] - KNOWN[0])
    };
    let sensor = |zero_ohm, scale| Channel { zero_ohm, scale, ..Channel::default() };
    for r in [0.0, 100.0, 2320.0, 5000.0, 12_700.0, 50_000.0] {
        let mut squares = [0.0; 2];
        for pin in 0..3 {
            let mut pins = [0.0; 3];
            pins[pin] = UNLIKE_PINS_OHM;
            let zero = reads(0.0, pins);
            let known = sensor(Some(zero), Some((reads(12_000.0, pins) - zero) / 12_000.0));
            assert!((known.corrected(reads(r, pins)) - r).abs() < 1e-9 && known.pins_u_ohm(r, KNOWN) == 0.0);
            assert!((known.corrected(known.as_read(r)) - r).abs() < 1e-9);
            for (square, zero_ohm) in squares.iter_mut().zip([None, Some(zero)]) {
                *square += (sensor(zero_ohm, None).corrected(reads(r, pins)) - r).powi(2);
            }
        }
        for (square, zero_ohm) in squares.into_iter().zip([None, Some(0.0)]) {
            let u = sensor(zero_ohm, None).pins_u_ohm(r, KNOWN);
            assert!((u - square.sqrt()).abs() < 0.003 * u + 1e-9, "{r} {zero_ohm:?}: {u} {}", square.sqrt());
        }
    }
}

/// What a sensor with a law of this kind has at a value, ohm: the equations the other way round, written anew.
fn r_ohm_of(law: &Transducer, value: f64) -> f64 {
    match law {
        Transducer::Ntc(Ntc { curve: Curve::Beta { r25_ohm, beta_k, .. }, .. }) => {
            r25_ohm * (beta_k * (1.0 / (value + 273.15) - 1.0 / 298.15)).exp()
        }
        // Steinhart and Hart's own inversion of the cubic.
        Transducer::Ntc(Ntc {
            curve: Curve::SteinhartHart { a_per_k: a, b_per_k: b, c_per_k: c }, ..
        }) => {
            let x = (a - 1.0 / (value + 273.15)) / c;
            let y = ((b / (3.0 * c)).powi(3) + x * x / 4.0).sqrt();
            ((y - x / 2.0).cbrt() - (y + x / 2.0).cbrt()).exp()
        }
        Transducer::Pt1000(_) => {
            let below = if value < 0.0 { -4.183e-12 * (value - 100.0) * value.powi(3) } else { 0.0 };
            1000.0 * (1.0 + 3.9083e-3 * value - 5.775e-7 * value * value + below)
        }
        Transducer::Ldr(Ldr { at_10_lx_ohm, gamma, .. }) => at_10_lx_ohm * (value / 10.0).powf(-gamma),
        Transducer::Position(Position { r0_ohm, r1_ohm, span, .. }) => {
            r0_ohm + value / span * (r1_ohm - r0_ohm)
        }
        Transducer::Table(_) => 1e5 * 10f64.powf((40.0 - value) / 20.0),
    }
}

/// One law of each form, and the values between which it is looked at.
fn laws() -> [(Transducer, [f64; 2]); 7] {
    let ntc = |curve| Transducer::Ntc(Ntc { curve, u: Some(0.01), range_degc: None });
    let position = |r0_ohm, r1_ohm| {
        Transducer::Position(Position { r0_ohm, r1_ohm, span: 100.0, unit: "mm".to_owned(), u: Some(0.5) })
    };
    let table = Pairs::try_from(vec![(1e6, 20.0), (1e5, 40.0), (1e3, 80.0)]).unwrap();
    [
        (ntc(Curve::Beta { r25_ohm: 1e4, beta_k: 3950.0, beta_u: None }), [-30.0, 100.0]),
        (
            ntc(Curve::SteinhartHart { a_per_k: 1.125e-3, b_per_k: 2.347e-4, c_per_k: 8.566e-8 }),
            [-30.0, 100.0],
        ),
        (Transducer::Pt1000(Pt1000 { class: Some(Class::B) }), [-190.0, 840.0]),
        (
            Transducer::Ldr(Ldr {
                at_10_lx_ohm: 15e3,
                gamma: 0.7,
                u: Some(0.01),
                gamma_u: None,
                range_lx: None,
            }),
            [1.5, 900.0],
        ),
        (position(20.0, 10_020.0), [1.0, 99.0]),
        (position(10_020.0, 20.0), [1.0, 99.0]),
        (Transducer::Table(Tabled { table, unit: "%RH".to_owned(), u: Some(0.01) }), [21.0, 79.0]),
    ]
}

proptest! {
    #![proptest_config(crate::seed::cases(256))]

    #[test]
    fn every_law_leads_back_and_its_slope_is_that_of_the_value(share in 0.0..1.0f64) {
        for (law, [low, high]) in laws() {
            let value = low + share * (high - low);
            let r_ohm = r_ohm_of(&law, value);
            let shown = law.shown(r_ohm).unwrap();
            prop_assert!((shown.value - value).abs() < 1e-8 * high, "{law:?} {value}: {shown:?}");
            let step = 1e-5 * r_ohm;
            let [before, after] = [-step, step].map(|step| law.shown(r_ohm + step).unwrap().value);
            let slope = (after - before) / (2.0 * step);
            // A table has corners.
            let is_corner = matches!(law, Transducer::Table(_)) && (r_ohm / 1e5).ln().abs() < 1e-4;
            prop_assert!(is_corner || (shown.slope / slope - 1.0).abs() < 1e-5, "{law:?} {value}: {slope} {shown:?}");
        }
    }
}

fn channel(law: Transducer) -> Channel {
    Channel { zero_ohm: Some(0.0), scale: Some(1.0), law: Some(law), ..Channel::default() }
}

/// Sensors that are off their laws, read with noise.
#[test]
fn two_u_contain_what_sensor_and_readout_are_off_by() {
    const SENSORS: usize = 2000;
    for (index, (law, [low, high])) in (0..).zip(laws()) {
        let mut rng = rng(index);
        let mut normal = || StandardNormal.sample(&mut rng);
        let mut hits = 0;
        let middle = low + 0.37 * (high - low);
        for _ in 0..SENSORS {
            let [own, noise]: [f64; 2] = [normal(), normal()];
            let r_ohm = match &law {
                Transducer::Position(_) => r_ohm_of(&law, middle + 0.5 * own),
                Transducer::Pt1000(_) => {
                    // Anywhere between the limits of class B.
                    let share = Uniform::new(-1.0, 1.0).unwrap().sample(&mut crate::seed::rng(own.to_bits()));
                    r_ohm_of(&law, middle + share * (0.3 + 0.005 * middle.abs()))
                }
                _ => r_ohm_of(&law, middle) * (1.0 + 0.01 * own),
            };
            let u_ohm = 0.003 * r_ohm;
            let read = Measured { value: r_ohm + u_ohm * noise, u: Some(u_ohm) };
            let shown = channel(law.clone()).value_at(read, KNOWN).unwrap();
            hits += usize::from((shown.value - middle).abs() <= 2.0 * shown.u.unwrap());
        }
        // What lies between limits lies nearer than two sigma more often than what is normal.
        let holds = match law {
            Transducer::Pt1000(_) => share_is_in(hits, SENSORS, WITHIN_2U..=1.0),
            _ => share_is(hits, SENSORS, WITHIN_2U),
        };
        assert!(holds, "{law:?}: {hits} of {SENSORS}");
    }
}

#[test]
fn u_is_that_of_readout_pins_and_law_and_unknown_where_one_is() {
    let law = || laws()[0].0.clone();
    let read = |u| Measured { value: 5000.0, u };
    let Shown { slope, own_u, .. } = law().shown(5000.0).unwrap();
    let known = channel(law()).value_at(read(Some(3.0)), KNOWN).unwrap();
    assert!((known.repeat_u.unwrap() - 3.0 * slope.abs()).abs() < 1e-12);
    assert!((known.u.unwrap() - (3.0 * slope).hypot(own_u.unwrap())).abs() < 1e-12);
    // As the instrument gives it: the uncertainty of a resistance contains that of the pins.
    let unlike = Channel { zero_ohm: None, scale: None, ..channel(law()) };
    let pins_u_ohm = unlike.pins_u_ohm(5000.0, KNOWN);
    let all = unlike.value_at(read(Some(pins_u_ohm.hypot(3.0))), KNOWN).unwrap();
    assert!((all.repeat_u.unwrap() - known.repeat_u.unwrap()).abs() < 1e-9);
    assert!((all.u.unwrap() - known.u.unwrap().hypot(pins_u_ohm * slope)).abs() < 1e-9);
    assert_eq!(channel(law()).value_at(read(None), KNOWN).unwrap().u, None);
    let Transducer::Ntc(ntc) = law() else { unreachable!() };
    let unsaid = channel(Transducer::Ntc(Ntc { u: None, ..ntc })).value_at(read(Some(3.0)), KNOWN).unwrap();
    assert_eq!((unsaid.u, unsaid.repeat_u), (None, known.repeat_u));
}

#[test]
fn a_bound_goes_where_the_law_goes() {
    let [falling, _, platinum, light, rising, reversed, _] = laws().map(|(law, _)| channel(law));
    let at = |channel: &Channel, r_ohm| channel.shown(r_ohm, KNOWN).unwrap().value;
    for channel in [&falling, &light, &reversed] {
        assert_eq!(channel.bound_above(6e4, KNOWN), Some(Bound::AtMost(at(channel, 6e4))));
        assert_eq!(channel.bound_below(2.0, KNOWN), Some(Bound::AtLeast(at(channel, 2.0))));
    }
    assert_eq!(rising.bound_above(6e4, KNOWN), Some(Bound::AtLeast(at(&rising, 6e4))));
    assert_eq!(rising.bound_below(2.0, KNOWN), Some(Bound::AtMost(at(&rising, 2.0))));
    // Platinum that is broken has no temperature.
    assert_eq!(platinum.bound_above(6e4, KNOWN), None);
    assert_eq!(Channel::default().bound_above(6e4, KNOWN), None);
}

#[test]
fn a_tape_carries_every_law() {
    let lines = laws().map(|(law, _)| serde_json::to_string(&law).unwrap());
    for (line, (law, _)) in lines.iter().zip(laws()) {
        assert_eq!(serde_json::from_str::<Transducer>(line).unwrap(), law, "{line}");
        assert_eq!(law.defect(), None, "{line}");
    }
    insta::assert_snapshot!(lines.join("\n"), @r#"
    {"kind":"ntc","r25_ohm":10000.0,"beta_k":3950.0,"u":0.01}
    {"kind":"ntc","a_per_k":0.001125,"b_per_k":0.0002347,"c_per_k":8.566e-8,"u":0.01}
    {"kind":"pt1000","class":"B"}
    {"kind":"ldr","at_10_lx_ohm":15000.0,"gamma":0.7,"u":0.01}
    {"kind":"position","r0_ohm":20.0,"r1_ohm":10020.0,"span":100.0,"unit":"mm","u":0.5}
    {"kind":"position","r0_ohm":10020.0,"r1_ohm":20.0,"span":100.0,"unit":"mm","u":0.5}
    {"kind":"table","table":[[1000.0,80.0],[100000.0,40.0],[1000000.0,20.0]],"unit":"%RH","u":0.01}
    "#);
    let both =
        Channel { force: Some(Force::from(Law::Alpha { alpha_n_ohm: 1e4 })), ..channel(laws()[0].0.clone()) };
    assert!(both.defect().is_some());
}
