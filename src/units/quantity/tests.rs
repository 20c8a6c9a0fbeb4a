//! Quantities as people write them, and as they are written.

use super::*;
use crate::units::Nanos;
use proptest::prelude::*;

#[test]
fn accepts_what_people_write() {
    for (text, farad) in [
        ("2.2 uF", 2.2e-6),
        ("680 nF", 680e-9),
        ("680nF", 680e-9),
        (" 10 \u{b5}F ", 10e-6),
        ("10\u{3bc}F", 10e-6),
        ("1e-6 F", 1e-6),
        ("22 pF", 22e-12),
    ] {
        assert_eq!(text.parse(), Ok(Farad(farad)), "{text}");
    }
    assert_eq!("12.7 kohm".parse(), Ok(Ohm(12_700.0)));
    assert_eq!("12.7k\u{3a9}".parse(), Ok(Ohm(12_700.0)));
    assert_eq!("12.7 k\u{2126}".parse(), Ok(Ohm(12_700.0)));
    assert_eq!("5.75 N".parse(), Ok(Newton(5.75)));
    assert_eq!("50 MHz".parse(), Ok(Hertz(50e6)));
    assert_eq!("1.3 V".parse(), Ok(Volt(1.3)));
    assert_eq!("8 us".parse(), Ok(Nanos(8_000)));
    assert_eq!("3 ms".parse(), Ok(Nanos(3_000_000)));
    for alpha in ["13346 N ohm", "13346Nohm", "13.346 kN \u{3a9}"] {
        assert_eq!(alpha.parse(), Ok(NewtonOhm(13_346.0)), "{alpha}");
    }
}

#[test]
fn what_is_beyond_the_prefixes_has_an_exponent() {
    assert_eq!(Ohm(1e300).to_string(), "1e300 ohm");
    assert_eq!(Farad(-2.2e-30).to_string(), "-2.2e-30 F");
    assert_eq!(Ohm(1e11).to_string(), "100000 Mohm");
    assert_eq!("1e300 ohm".parse(), Ok(Ohm(1e300)));
}

#[test]
fn milli_is_not_mega() {
    assert_eq!("5 mohm".parse(), Ok(Ohm(0.005)));
    assert_eq!("5 Mohm".parse(), Ok(Ohm(5e6)));
}

#[test]
fn a_weight_is_a_force() {
    assert_eq!("500 g".parse(), Ok(Newton(4.903325)));
    assert_eq!("0.5kg".parse(), "500 g".parse::<Newton>());
    assert_eq!("1 lbf".parse(), Ok(Newton(4.448_221_615_260_5)));
    assert!("500 g".parse::<Ohm>().is_err());
}

#[test]
fn what_other_sensors_show() {
    assert_eq!(("3950 K".parse(), "3.95kK".parse()), (Ok(Kelvin(3950.0)), Ok(Kelvin(3950.0))));
    assert_eq!(("-10 degC".parse(), "-10\u{b0}C".parse()), (Ok(Celsius(-10.0)), Ok(Celsius(-10.0))));
    assert_eq!(("10 lux".parse(), "1 klx".parse()), (Ok(Lux(10.0)), Ok(Lux(1000.0))));
    assert_eq!(("100 mm".parse(), "10 cm".parse()), (Ok(Metre(0.1)), Ok(Metre(0.1))));
    assert_eq!("270 deg".parse(), Ok(Degree(270.0)));
    assert!("25 C".parse::<Celsius>().is_err() && "25 degC".parse::<Kelvin>().is_err());
}

#[test]
fn a_missing_unit_is_named() {
    let says = |text: &str| text.parse::<Ohm>().unwrap_err().to_string();
    let of = |got, right| {
        format!(
            "expected a resistance such as \"2.32 kohm\", got {got}: the unit is missing, write \"{right}\""
        )
    };
    assert_eq!(says("2.32k"), of("\"2.32k\"", "2.32 kohm"));
    assert_eq!(says("2320"), of("\"2320\"", "2.32 kohm"));
    let says_farad = |text: &str| text.parse::<Farad>().unwrap_err().to_string();
    for (wrong, right) in
        [("2.2", "2.2 uF"), ("0.47", "470 nF"), ("470", "470 nF"), ("2.2u", "2.2 uF"), ("2.2e-6", "2.2 uF")]
    {
        assert!(says_farad(wrong).ends_with(&format!("write \"{right}\"")), "{}", says_farad(wrong));
    }
    let says_part = |text: &str| text.parse::<Percent>().unwrap_err().to_string();
    assert!(says_part("0.1").ends_with("write \"10 %\""), "{}", says_part("0.1"));
    assert!(says_part("8.7").ends_with("write \"8.7 %\""), "{}", says_part("8.7"));
    let says = |json: &str| {
        let text = serde_json::from_str::<Ohm>(json).unwrap_err().to_string();
        text.split(" at line").next().unwrap().to_owned()
    };
    assert_eq!((says("2320"), says("2.5")), (of("2320", "2.32 kohm"), of("2.5", "2.5 ohm")));
    // What lacks more than that gets no wrong advice.
    assert!(!says("\"2.32 uF\"").contains("missing") && !says("-1e400").contains("missing"));
}

#[test]
fn a_comma_is_told_from_a_point() {
    let says = |text: &str| text.parse::<Ohm>().unwrap_err().to_string();
    assert!(says("12,7 kohm").ends_with("got \"12,7 kohm\": decimals have a point"), "{}", says("12,7 kohm"));
    assert!(!says("12 ko").contains("point"));
}

#[test]
fn says_what_was_expected() {
    let error = "2.2 uH".parse::<Farad>().unwrap_err();
    assert_eq!(error.to_string(), "expected a capacitance such as \"2.2 uF\", got \"2.2 uH\"");
    for wrong in
        ["", "uF", "2.2", "2.2 u", "2.2 UF", "2.2 k uF", "nan F", "inf F", "1e999 F", "1e308 MF", "2,2 uF"]
    {
        assert!(wrong.parse::<Farad>().is_err(), "{wrong}");
    }
    assert!("13346 N ohm".parse::<Ohm>().is_err());
    assert!("5.75 ohm".parse::<Newton>().is_err());
}

#[test]
fn writes_an_engineering_prefix() {
    assert_eq!(Farad(2.2e-6).to_string(), "2.2 uF");
    assert_eq!(Farad(680e-9).to_string(), "680 nF");
    assert_eq!(Ohm(12_700.0).to_string(), "12.7 kohm");
    assert_eq!(Ohm(999.9999).to_string(), "999.9999 ohm");
    assert_eq!(format!("{:.3}", Ohm(999.9999)), "1 kohm");
    assert_eq!(format!("{:.3}", Seconds(0.010_421)), "10.4 ms");
    assert_eq!(NewtonOhm(13_346.0).to_string(), "13.346 kN ohm");
    assert_eq!(Volt(0.0).to_string(), "0 V");
    assert_eq!(Volt(-0.5).to_string(), "-500 mV");
    assert_eq!(Farad(1e-15).to_string(), "0.001 pF");
}

#[test]
fn a_bare_number_has_no_unit() {
    let error = serde_json::from_str::<Farad>("2.2e-6").unwrap_err();
    assert!(error.to_string().contains("expected a capacitance such as \"2.2 uF\""), "{error}");
    assert_eq!(serde_json::from_str::<Farad>("\"2.2 uF\"").unwrap(), Farad(2.2e-6));
    assert_eq!(serde_json::from_str::<Nanos>("\"3 ms\"").unwrap(), Nanos(3_000_000));
}

proptest! {
    #![proptest_config(crate::seed::cases(256))]

    #[test]
    fn round_trips(mantissa in -10.0..10.0f64, exponent in -18..15i32) {
        let value = mantissa * 10f64.powi(exponent);
        let ohm: Ohm = Ohm(value).to_string().parse().unwrap();
        prop_assert!((ohm.0 - value).abs() <= 1e-12 * value.abs(), "{} became {}", value, ohm.0);
        let alpha: NewtonOhm = NewtonOhm(value).to_string().parse().unwrap();
        prop_assert!((alpha.0 - value).abs() <= 1e-12 * value.abs());
    }

    #[test]
    fn whole_nanoseconds_round_trip(ns in -1_000_000_000_000i64..1_000_000_000_000) {
        let text = Seconds::from(Nanos(ns)).to_string();
        prop_assert_eq!(text.parse(), Ok(Nanos(ns)));
    }

    #[test]
    fn any_text_is_read_or_refused(text in "\\PC{0,12}") {
        if let Ok(ohm) = text.parse::<Ohm>() {
            prop_assert!(ohm.0.is_finite());
        }
    }
}
