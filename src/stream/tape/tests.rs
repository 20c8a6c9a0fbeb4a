//! What goes onto a tape comes off it, and nothing else does.

use super::*;
use crate::estimate::look::Found;

const HEADER: &str = r#"{"class":"TAPE","proto_major":1,"circuit":{"kind":"two-capacitor","r_c1_ohm":2320,"r_c2_ohm":12700},"offset_ns":8000,"channels":[{"id":"thumb","force":{"fc1_n":5.75,"fc2_n":1.05}}]}"#;
const SWITCHED: &str = r#"{"class":"DISCHARGE","seq":3,"t_ns":81234567890,"channel":"thumb","through":"x","switch":{"at_ns":74700.5,"on_ns":74950,"to":"c2","u_ns":31.25},"a_ns":911000,"b_ns":1742000,"later_ns":40.5}"#;

#[test]
fn lines_come_out_as_they_went_in() {
    let header = Header::parse(HEADER).unwrap();
    assert_eq!(Header::parse(&serde_json::to_string(&header).unwrap()).unwrap(), header);
    let entry = header.parse_discharge(2, SWITCHED).unwrap();
    assert_eq!(
        serde_json::to_string(&header.discharge(entry.seq, &entry.record, entry.is_held)).unwrap(),
        SWITCHED
    );
}

#[test]
fn what_looks_have_found_comes_off_it_too() {
    let found = Found {
        leak_siemens: Some([[1.25e-8, 2e-9], [-3e-7, 1e-9]]),
        leak_more_at_b: Some([[2e-8, 1e-9], [3e-8, 1e-9]]),
        late_ns: Some([[-4000.0, 100.0], [0.0, 60.5]]),
        absorbed: Some(0.0123),
    };
    let header = Header { looks: TapeLooks::of(&found), ..Header::parse(HEADER).unwrap() };
    let text = serde_json::to_string(&header).unwrap();
    assert!(
        text.contains(r#""leak_siemens":[1.25e-8,-3e-7],"leak_u_siemens":[2e-9,1e-9],"leak_b_siemens":[2e-8,3e-8],"leak_b_u_siemens":[1e-9,1e-9],"late_ns":[-4000,0]"#),
        "{text}"
    );
    assert_eq!(Header::parse(&text).unwrap().looks.found(), found);
}

#[test]
fn a_bad_header_is_refused_with_its_reason() {
    let message = |from: &str, to: &str| Header::parse(&HEADER.replace(from, to)).unwrap_err().to_string();
    for (from, to, reason) in [
        ("\"proto_major\":1", "\"proto_major\":2", "line 1: this is a tape of version 2"),
        ("2320", "12700", "are they swapped?"),
        (
            "2320",
            "-1",
            "r_c1_ohm = -1e0 is no resistor: write what was measured, in ohm, between 1 ohm and 100 Mohm",
        ),
        ("2320", "0.9", "r_c1_ohm = 9e-1 is no resistor"),
        ("12700", "null", "circuit.r_c2_ohm is null: leave it out"),
        ("TAPE", "TOPE", "line 1: not the header of a tape"),
        ("\"offset_ns\":8000", "\"offset_ns\":8e6", "below 1 ms"),
        ("two-capacitor", "three-capacitor", "unknown variant"),
        ("12700", "1e308", "r_c2_ohm = 1e308 is no resistor"),
        ("12700", "1.1e8", "r_c2_ohm = 1.1e8 is no resistor"),
        (
            "\"fc1_n\":5.75",
            "\"fc1_n\":0.5",
            "\"thumb\": fc1 = 500 mN at the lower resistance has to exceed fc2 = 1.05 N",
        ),
        ("\"fc2_n\":1.05", "\"fc2_n\":-1.05", "and both be above zero"),
        ("\"fc1_n\":5.75,\"fc2_n\":1.05", "\"alpha_n_ohm\":1e308", "1e308 N ohm is beyond any sensor"),
        ("\"fc1_n\":5.75", "\"f1_n\":5.75", "force is one of {\"fc1_n\", \"fc2_n\"}"),
        ("\"id\":\"thumb\"", "\"id\":\"thumb\",\"zero_ohm\":-1e308", "zero_ohm = -1e308 is more than pins"),
        (
            "\"id\":\"thumb\"",
            "\"id\":\"thumb\",\"zero_ohm\":1e12",
            "channel \"thumb\": zero_ohm = 1e12 is more than pins",
        ),
        (
            "\"offset_ns\"",
            "\"resolution_ns\":0.5,\"offset_ns\"",
            "resolution_ns = 5e-1 is no period of a clock",
        ),
        (
            "\"offset_ns\"",
            "\"resolution_ns\":2e6,\"offset_ns\"",
            "resolution_ns = 2e6 is no period of a clock",
        ),
        (
            "\"offset_ns\"",
            "\"offset_u_ns\":-1,\"offset_ns\"",
            "offset_u_ns = -1e0 is not between 0e0 and 1e6",
        ),
        ("\"offset_ns\"", "\"switch_u_ns\":1e12,\"offset_ns\"", "switch_u_ns = 1e12 is not between"),
        (
            "\"offset_ns\"",
            "\"offset_by_switch\":1e12,\"offset_ns\"",
            "offset_by_switch = 1e12 is not between",
        ),
        ("\"offset_ns\"", "\"r_o_ohm\":-1e12,\"offset_ns\"", "r_o_ohm = -1e12 is not between"),
        ("\"offset_ns\"", "\"r_o_u_ohm\":1e12,\"offset_ns\"", "r_o_u_ohm = 1e12 is not between"),
        ("\"id\":\"thumb\"", "\"id\":\"thumb\",\"scale\":0", "scale = 0e0 is not between 0.9 and 1.1"),
        (
            "\"offset_ns\"",
            "\"leak_siemens\":[0,2],\"offset_ns\"",
            "leak_siemens = 2e0 is not between -1e0 and 1e0",
        ),
        ("\"offset_ns\"", "\"leak_u_siemens\":[-1,0],\"offset_ns\"", "leak_u_siemens = -1e0 is not between"),
        (
            "\"offset_ns\"",
            "\"leak_siemens\":[0,0],\"offset_ns\"",
            "leak_siemens and leak_u_siemens belong together",
        ),
        ("\"offset_ns\"", "\"late_u_ns\":[0,0],\"offset_ns\"", "late_ns and late_u_ns belong together"),
        ("\"offset_ns\"", "\"late_ns\":[0,1e13],\"offset_ns\"", "late_ns = 1e13 is not between"),
        ("\"offset_ns\"", "\"absorbed\":1.5,\"offset_ns\"", "absorbed = 1.5e0 is not between 0e0 and 1e0"),
        ("[{", "[{\"id\":\"thumb\"},{", "two channels have the id \"thumb\""),
    ] {
        let message = message(from, to);
        assert!(message.contains(reason), "{message}");
    }
}

#[test]
fn a_bad_discharge_is_refused_with_its_line() {
    let header = Header::parse(HEADER).unwrap();
    for (from, to, reason) in [
        ("911000", "-911000", "a_ns is -911000"),
        ("911000", "0", "a_ns is 0"),
        ("1742000", "1e15", "nanoseconds"),
        ("\"on_ns\":74950", "\"on_ns\":74000", "released before"),
        ("thumb", "toe", "\"toe\" is not in the header"),
        ("\"to\":\"c2\"", "\"to\":\"c12\"", "series calibration"),
        ("\"channel\":\"thumb\",", "", "names its channel"),
        ("\"seq\":3", "\"seq\":-3", "expected u64"),
        ("911000", "null", "a_ns is null: leave it out"),
        ("74950", "null", "switch.on_ns is null: leave it out"),
        ("\"later_ns\":40.5}", "\"later_ns\":4", "EOF"),
        ("\"later_ns\":40.5", "\"later_ns\":-40.5", "later_ns is -40.5"),
    ] {
        let message = header.parse_discharge(7, &SWITCHED.replace(from, to)).unwrap_err().to_string();
        assert!(message.starts_with("line 7: ") && message.contains(reason), "{message}");
    }
}

#[test]
fn an_id_may_be_called_null() {
    let header = Header::parse(&HEADER.replace("thumb", "null")).unwrap();
    assert!(header.parse_discharge(2, &SWITCHED.replace("thumb", "null")).is_ok());
}
