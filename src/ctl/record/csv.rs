//! Readings as CSV (RFC 4180): a line of names, then one line each; what is not known is empty.
//!
//! For: spreadsheets and scripts. Must not know: where the lines go.

use crate::stream::wire::{ReadingLine, StatusName};

/// The columns: the fields of READING.
const COLUMNS: [&str; 18] = [
    "channel",
    "seq",
    "time",
    "t_mono_ns",
    "status",
    "r_ohm",
    "r_u_ohm",
    "f_n",
    "f_u_n",
    "r_min_ohm",
    "f_max_n",
    "r_max_ohm",
    "f_min_n",
    "fault",
    "method",
    "branch",
    "duration_us",
    "lost",
];

/// The first line.
pub fn header() -> String {
    COLUMNS.join(",")
}

/// A reading.
pub fn row(reading: &ReadingLine) -> String {
    let status = match reading.status {
        StatusName::Ok => "ok",
        StatusName::Open => "open",
        StatusName::Short => "short",
        StatusName::Fault => "fault",
    };
    let number = |value: Option<f64>| value.map(|value| value.to_string()).unwrap_or_default();
    let text = |value: &Option<String>| value.as_deref().map(quoted).unwrap_or_default();
    let cells: [String; COLUMNS.len()] = [
        quoted(&reading.channel),
        reading.seq.to_string(),
        reading.time.clone(),
        reading.t_mono_ns.to_string(),
        status.to_owned(),
        number(reading.r_ohm),
        number(reading.r_u_ohm),
        number(reading.f_n),
        number(reading.f_u_n),
        number(reading.r_min_ohm),
        number(reading.f_max_n),
        number(reading.r_max_ohm),
        number(reading.f_min_n),
        text(&reading.fault),
        text(&reading.method),
        text(&reading.branch),
        reading.duration_us.map(|us| us.to_string()).unwrap_or_default(),
        reading.lost.to_string(),
    ];
    cells.join(",")
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        return format!("\"{}\"", text.replace('"', "\"\""));
    }
    text.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_that_would_break_a_row_are_quoted() {
        assert_eq!(quoted("thumb"), "thumb");
        assert_eq!(quoted("a,\"b\""), "\"a,\"\"b\"\"\"");
    }
}
