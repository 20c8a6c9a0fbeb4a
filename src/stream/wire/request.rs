//! What a client may ask.

use super::{ErrorCode, ErrorLine, LineTooLong, MAX_LINE_BYTES, to_line};
use crate::stream::limits::{COMPLAINT, EXCERPT};
use crate::stream::line::{is_unknown, time};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// A request.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "class", rename_all = "UPPERCASE")]
pub enum Request {
    /// Choose what is streamed.
    Watch(Watch),
    /// The last reading of each channel.
    Poll,
    /// Figures of the daemon.
    Stats,
}

/// The subscription of one client. Each WATCH replaces the one before; a field left out has its default.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Watch {
    /// Whether anything is streamed. Default: true.
    pub enable: bool,
    /// Ids of the channels that are wanted. Default: every channel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub channels: Option<Vec<String>>,
    /// At most so many readings a second of each channel, Hz. Default: every reading.
    #[serde(serialize_with = "time", skip_serializing_if = "is_unknown")]
    pub max_hz: Option<f64>,
    /// The discharges themselves, as lines of a tape, in the place of readings. Default: false.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub raw: bool,
}

impl Default for Watch {
    fn default() -> Watch {
        Watch { enable: true, channels: None, max_hz: None, raw: false }
    }
}

impl Request {
    /// As a line, with its newline.
    pub fn to_line(&self) -> Vec<u8> {
        to_line(self)
    }

    /// Reads a request.
    ///
    /// # Errors
    /// What is wrong with it, as the answer to its sender.
    pub fn parse(line: Result<&[u8], LineTooLong>) -> Result<Request, ErrorLine> {
        let bytes = line.map_err(|LineTooLong| {
            let message =
                format!("a line has at most {MAX_LINE_BYTES} bytes; skipped up to the next newline");
            ErrorLine::new(ErrorCode::LineTooLong, message)
        })?;
        let text = std::str::from_utf8(bytes).map_err(|error| {
            bad(format!("not UTF-8 after byte {}: send JSON as UTF-8", error.valid_up_to()))
        })?;
        let value: Value = serde_json::from_str(text).map_err(|error| {
            bad(format!("not JSON ({error}): send one object a line, such as {{\"class\":\"POLL\"}}"))
        })?;
        let Value::Object(mut fields) = value else {
            return Err(bad("not a JSON object: send one object a line, such as {\"class\":\"POLL\"}"));
        };
        if let Some((key, _)) = fields.iter().find(|(_, value)| value.is_null()) {
            return Err(bad(format!("\"{}\" is null: leave a field out instead", excerpt(key))));
        }
        match fields.remove("class") {
            Some(Value::String(class)) => Request::of_class(&class, fields),
            Some(_) => Err(bad("\"class\" is not a string")),
            None => Err(bad("no \"class\": it is one of \"WATCH\", \"POLL\", \"STATS\"")),
        }
    }

    fn of_class(class: &str, fields: Map<String, Value>) -> Result<Request, ErrorLine> {
        let request = match class {
            "WATCH" => return Watch::read(fields).map(Request::Watch),
            "POLL" => Request::Poll,
            "STATS" => Request::Stats,
            _ => {
                let message =
                    format!("no class \"{}\": it is one of \"WATCH\", \"POLL\", \"STATS\"", excerpt(class));
                return Err(ErrorLine::new(ErrorCode::UnknownClass, message));
            }
        };
        match fields.keys().next() {
            Some(key) => Err(bad(format!("{class} has no field \"{}\": leave it out", excerpt(key)))),
            None => Ok(request),
        }
    }
}

impl Watch {
    fn read(fields: Map<String, Value>) -> Result<Watch, ErrorLine> {
        let mut watch: Watch = serde_json::from_value(Value::Object(fields))
            .map_err(|error| bad(format!("WATCH: {}", shortened(&error.to_string(), COMPLAINT))))?;
        if watch.channels.as_ref().is_some_and(Vec::is_empty) {
            return Err(bad("WATCH: \"channels\" is empty: leave it out for every channel, or name some"));
        }
        if let Some(channels) = &mut watch.channels {
            // Said a thousand times it would be kept as often, and looked through for each reading.
            channels.sort_unstable();
            channels.dedup();
            channels.shrink_to_fit();
        }
        if watch.max_hz.is_some_and(|hz| hz <= 0.0) {
            return Err(bad("WATCH: \"max_hz\" must be above 0: leave it out for every reading"));
        }
        if watch.raw && watch.max_hz.is_some() {
            return Err(bad("WATCH: \"raw\" does not go with \"max_hz\": a tape has no gaps"));
        }
        Ok(watch)
    }
}

fn bad(message: impl Into<String>) -> ErrorLine {
    ErrorLine::new(ErrorCode::BadRequest, message)
}

/// As much of a client's own text as an answer repeats.
pub(crate) fn excerpt(text: &str) -> String {
    shortened(text, EXCERPT)
}

fn shortened(text: &str, characters: usize) -> String {
    match text.char_indices().nth(characters) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn parse(text: &str) -> Result<Request, ErrorLine> {
        Request::parse(Ok(text.as_bytes()))
    }

    fn code(text: &str) -> ErrorCode {
        parse(text).unwrap_err().code
    }

    #[test]
    fn the_requests_of_the_protocol() {
        let watch = Watch { channels: Some(vec!["thumb".into()]), max_hz: Some(10.0), ..Watch::default() };
        assert_eq!(
            parse(r#"{"class":"WATCH","enable":true,"channels":["thumb"],"max_hz":10}"#),
            Ok(Request::Watch(watch))
        );
        let off = Watch { enable: false, ..Watch::default() };
        assert_eq!(parse(r#"{"class":"WATCH","enable":false}"#), Ok(Request::Watch(off)));
        assert_eq!(parse(r#"{"class":"WATCH"}"#), Ok(Request::Watch(Watch::default())));
        assert_eq!(parse(r#" {"class" : "POLL"} "#), Ok(Request::Poll));
        assert_eq!(parse(r#"{"class":"STATS"}"#), Ok(Request::Stats));
    }

    #[test]
    fn a_channel_that_is_named_often_is_kept_once() {
        let often = format!(r#"{{"class":"WATCH","channels":["b"{}]}}"#, r#","a","b""#.repeat(1000));
        let Ok(Request::Watch(watch)) = parse(&often) else { panic!() };
        let channels = watch.channels.unwrap();
        assert_eq!((channels.capacity(), channels), (2, vec!["a".to_owned(), "b".to_owned()]));
    }

    #[test]
    fn what_is_written_is_read_back() {
        let requests = [
            Request::Watch(Watch { enable: false, ..Watch::default() }),
            Request::Watch(Watch {
                channels: Some(vec!["ä\"".into()]),
                max_hz: Some(0.5),
                ..Watch::default()
            }),
            Request::Watch(Watch { raw: true, ..Watch::default() }),
            Request::Poll,
            Request::Stats,
        ];
        for request in requests {
            let mut line = request.to_line();
            assert_eq!(line.pop(), Some(b'\n'));
            assert_eq!(Request::parse(Ok(&line)), Ok(request));
        }
    }

    #[test]
    fn bad_requests_are_named() {
        let bad_requests = [
            "",
            "hello",
            "[]",
            "null",
            "7",
            "{}",
            r#"{"class":7}"#,
            r#"{"class":null}"#,
            r#"{"class":"POLL"} trailing"#,
            r#"{"class":"POLL","channel":"thumb"}"#,
            r#"{"class":"STATS","x":1}"#,
            r#"{"class":"WATCH","enabled":true}"#,
            r#"{"class":"WATCH","enable":1}"#,
            r#"{"class":"WATCH","channels":"thumb"}"#,
            r#"{"class":"WATCH","channels":[]}"#,
            r#"{"class":"WATCH","channels":null}"#,
            r#"{"class":"WATCH","max_hz":0}"#,
            r#"{"class":"WATCH","max_hz":-1}"#,
            r#"{"class":"WATCH","max_hz":1e999}"#,
            r#"{"class":"WATCH","max_hz":"10"}"#,
            r#"{"class":"WATCH","raw":true,"max_hz":10}"#,
        ];
        for text in bad_requests {
            assert_eq!(code(text), ErrorCode::BadRequest, "{text}");
        }
        assert_eq!(code(r#"{"class":"watch"}"#), ErrorCode::UnknownClass);
        // What changes the instrument is a matter of the configuration file, not of a request.
        assert_eq!(code(r#"{"class":"CALIBRATE"}"#), ErrorCode::UnknownClass);
        assert_eq!(code(r#"{"class":"ZERO","channel":"thumb"}"#), ErrorCode::UnknownClass);
        assert_eq!(Request::parse(Err(LineTooLong)).unwrap_err().code, ErrorCode::LineTooLong);
        let binary = Request::parse(Ok(&[b'{', 0xff, 0x00])).unwrap_err();
        assert_eq!((binary.code, binary.message.contains("UTF-8")), (ErrorCode::BadRequest, true));
        assert_eq!(code(&"[".repeat(60_000)), ErrorCode::BadRequest);
    }

    #[test]
    fn answers_stay_short_whatever_was_sent() {
        let long = "ü".repeat(20_000);
        let bad_requests =
            [format!(r#"{{"class":"{long}"}}"#), format!(r#"{{"class":"WATCH","{long}":1}}"#), long.clone()];
        for text in bad_requests {
            let answer = to_line(&parse(&text).unwrap_err());
            assert!(answer.len() < 600, "{} bytes", answer.len());
        }
    }

    proptest! {
        #![proptest_config(crate::seed::cases(256))]

        #[test]
        fn any_bytes_get_an_answer(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = Request::parse(Ok(&bytes));
        }
    }
}
