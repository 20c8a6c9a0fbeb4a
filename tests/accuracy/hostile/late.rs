//! Boards whose stamps are late often: that an interrupt is held up is no accident there.

use super::Row;
use super::rows::ROW;
use cermd::pins::sim::Kind;
use cermd::reading::Method;
use cermd::reading::Method::{Cerm, Qerm, Tcdic, Tpcm, Tracked};

const ALL: &[(Method, &[f64])] = &[
    (Tracked, &[100.0, 300.0, 1000.0, 5000.0]),
    (Cerm, &[100.0, 300.0, 5000.0]),
    (Tcdic, &[100.0, 5000.0]),
    (Tpcm, &[100.0, 5000.0]),
    (Qerm, &[100.0, 5000.0]),
];
const ONE: &[(Method, &[f64])] = &[(Tracked, &[100.0, 1000.0, 5000.0])];

/// So many of all stamps are late, by so much on average (exponential). That some in a row are so alike happens by chance, to a few
/// of a million readings.
const fn late(name: &'static str, scene: &'static str, least_numbers: f64) -> Row {
    Row { name, scene, least_numbers, wild: 3, cases: ALL, ..ROW }
}

const fn one_node(row: Row, name: &'static str) -> Row {
    Row { name, kind: Some(Kind::OneCapacitor), cases: ONE, ..row }
}

const TENTH_20_US: Row = late("10 % by 20 us", "[stamps]\ntail-probability = 0.1\ntail-mean = '20 us'", 0.8);
const TENTH_100_US: Row =
    late("10 % by 100 us", "[stamps]\ntail-probability = 0.1\ntail-mean = '100 us'", 0.7);
const TENTH_1_MS: Row = late("10 % by 1 ms", "[stamps]\ntail-probability = 0.1\ntail-mean = '1 ms'", 0.7);
const FIFTH_100_US: Row =
    late("20 % by 100 us", "[stamps]\ntail-probability = 0.2\ntail-mean = '100 us'", 0.5);
const THREE_TENTHS_100_US: Row =
    late("30 % by 100 us", "[stamps]\ntail-probability = 0.3\ntail-mean = '100 us'", 0.2);
const THREE_TENTHS_1_MS: Row =
    late("30 % by 1 ms", "[stamps]\ntail-probability = 0.3\ntail-mean = '1 ms'", 0.2);
const HALF_100_US: Row =
    late("half by 100 us", "[stamps]\ntail-probability = 0.5\ntail-mean = '100 us'", 0.0);

pub static LATE: [Row; 14] = [
    TENTH_20_US,
    one_node(TENTH_20_US, "10 % by 20 us, one node"),
    TENTH_100_US,
    one_node(TENTH_100_US, "10 % by 100 us, one node"),
    Row {
        name: "10 % by 100 us, the first readings",
        seconds: [0.0, f64::INFINITY],
        least_numbers: 0.5,
        ..TENTH_100_US
    },
    Row { name: "10 % by 100 us, beside a hand", beside_a_hand: true, ..TENTH_100_US },
    TENTH_1_MS,
    one_node(TENTH_1_MS, "10 % by 1 ms, one node"),
    FIFTH_100_US,
    THREE_TENTHS_100_US,
    one_node(THREE_TENTHS_100_US, "30 % by 100 us, one node"),
    THREE_TENTHS_1_MS,
    one_node(THREE_TENTHS_1_MS, "30 % by 1 ms, one node"),
    // One reading in thirty is a number, which says that it settles: it takes more boards for as many.
    Row { boards: 300, fails: &[(Tpcm, 100.0), (Qerm, 100.0)], ..HALF_100_US },
];
