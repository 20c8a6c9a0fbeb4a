//! What a client may ask, and how it is refused.
//!
//! For: requests in both directions of translation; refusals that say what to do. Must not know: who asks, or
//! what the answer is.

use super::{Line, MAX_LINE_BYTES, Object};
use serde::Deserialize;
use serde_json::{Map, Value};

/// A request.
#[derive(Debug, Clone, PartialEq)]
pub enum Request {
    /// Choose what is streamed.
    Watch(Watch),
    /// The last reading of each channel.
    Poll,
    /// Figures of the daemon.
    Stats,
    /// What changes the instrument; for root and the daemon's own user.
    Instrument(Instrument),
}

/// A request that changes the instrument.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Instrument {
    /// Calibrate again.
    Calibrate,
    /// Take the present resistance of a channel as a short circuit.
    Zero,
}

/// The subscription of one client. Each WATCH replaces the one before; a field left out has its default.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Watch {
    /// Whether anything is streamed. Default: true.
    #[serde(default = "enabled")]
    pub enable: bool,
    /// Ids of the channels that are wanted. Default: every channel.
    pub channels: Option<Vec<String>>,
    /// At most so many readings a second of each channel, Hz. Default: every reading.
    pub max_hz: Option<f64>,
    /// The discharges themselves, as lines of a tape, in the place of readings. Default: false.
    #[serde(default)]
    pub raw: bool,
}

fn enabled() -> bool {
    true
}

impl Default for Watch {
    fn default() -> Watch {
        Watch { enable: true, channels: None, max_hz: None, raw: false }
    }
}

/// Why a request is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ErrorCode {
    /// Not a JSON object with a class, or not the fields of that class.
    BadRequest,
    /// No request has this class.
    UnknownClass,
    /// No channel has this id.
    UnknownChannel,
    /// More than [`MAX_LINE_BYTES`].
    LineTooLong,
    /// POLL, but a channel has no reading yet.
    NoReading,
    /// Discharges of a raw stream were lost, because the client reads too slowly.
    Lost,
    /// Only for root and the daemon's own user.
    Forbidden,
    /// Not possible in this version.
    Unsupported,
    /// Too many clients.
    Busy,
}

impl ErrorCode {
    /// The name in the stream.
    pub fn as_str(self) -> &'static str {
        match self {
            ErrorCode::BadRequest => "bad-request",
            ErrorCode::UnknownClass => "unknown-class",
            ErrorCode::UnknownChannel => "unknown-channel",
            ErrorCode::LineTooLong => "line-too-long",
            ErrorCode::NoReading => "no-reading",
            ErrorCode::Lost => "lost",
            ErrorCode::Forbidden => "forbidden",
            ErrorCode::Unsupported => "unsupported",
            ErrorCode::Busy => "busy",
        }
    }
}

/// An ERROR of the server: what was wrong, and what to do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal {
    /// For programs.
    pub code: ErrorCode,
    /// For people.
    pub message: String,
}

impl Refusal {
    /// From its parts.
    pub fn new(code: ErrorCode, message: impl Into<String>) -> Refusal {
        Refusal { code, message: message.into() }
    }

    /// Appends it as a line.
    pub fn write(&self, out: &mut Vec<u8>) {
        let mut object = Object::line(out, "ERROR");
        object.text("code", self.code.as_str());
        object.text("message", &self.message);
        object.end();
    }
}

impl Request {
    /// Reads a request.
    ///
    /// # Errors
    /// What is wrong with it, as the answer to its sender.
    pub fn parse(line: &Line) -> Result<Request, Refusal> {
        let bytes = match line {
            Line::Whole(bytes) => bytes,
            Line::TooLong => {
                let message =
                    format!("a line has at most {MAX_LINE_BYTES} bytes; skipped up to the next newline");
                return Err(Refusal::new(ErrorCode::LineTooLong, message));
            }
        };
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

    fn of_class(class: &str, fields: Map<String, Value>) -> Result<Request, Refusal> {
        let request = match class {
            "WATCH" => return Request::watch(fields),
            "POLL" => Request::Poll,
            "STATS" => Request::Stats,
            "CALIBRATE" => Request::Instrument(Instrument::Calibrate),
            "ZERO" => Request::Instrument(Instrument::Zero),
            _ => {
                let message =
                    format!("no class \"{}\": it is one of \"WATCH\", \"POLL\", \"STATS\"", excerpt(class));
                return Err(Refusal::new(ErrorCode::UnknownClass, message));
            }
        };
        match fields.keys().next() {
            // The fields of what changes the instrument are judged where it is done.
            Some(key) if !matches!(request, Request::Instrument(_)) => {
                Err(bad(format!("{class} has no field \"{}\": leave it out", excerpt(key))))
            }
            _ => Ok(request),
        }
    }

    fn watch(fields: Map<String, Value>) -> Result<Request, Refusal> {
        let watch: Watch = serde_json::from_value(Value::Object(fields))
            .map_err(|error| bad(format!("WATCH: {}", excerpt_of(&error.to_string(), 200))))?;
        if watch.channels.as_ref().is_some_and(Vec::is_empty) {
            return Err(bad("WATCH: \"channels\" is empty: leave it out for every channel, or name some"));
        }
        if watch.max_hz.is_some_and(|hz| hz <= 0.0) {
            return Err(bad("WATCH: \"max_hz\" must be above 0: leave it out for every reading"));
        }
        if watch.raw && watch.max_hz.is_some() {
            return Err(bad("WATCH: \"raw\" does not go with \"max_hz\": a tape has no gaps"));
        }
        Ok(Request::Watch(watch))
    }

    /// Appends it as a line.
    pub fn write(&self, out: &mut Vec<u8>) {
        let class = match self {
            Request::Watch(_) => "WATCH",
            Request::Poll => "POLL",
            Request::Stats => "STATS",
            Request::Instrument(Instrument::Calibrate) => "CALIBRATE",
            Request::Instrument(Instrument::Zero) => "ZERO",
        };
        let mut object = Object::line(out, class);
        if let Request::Watch(watch) = self {
            object.flag("enable", watch.enable);
            if let Some(channels) = &watch.channels {
                object.texts("channels", channels.iter().map(String::as_str));
            }
            object.number("max_hz", watch.max_hz, 9);
            if watch.raw {
                object.flag("raw", true);
            }
        }
        object.end();
    }
}

fn bad(message: impl Into<String>) -> Refusal {
    Refusal::new(ErrorCode::BadRequest, message)
}

/// As much of a client's own text as an answer repeats: answers stay short whatever was sent.
pub(crate) fn excerpt(text: &str) -> String {
    excerpt_of(text, 40)
}

fn excerpt_of(text: &str, characters: usize) -> String {
    match text.char_indices().nth(characters) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn parse(text: &str) -> Result<Request, Refusal> {
        Request::parse(&Line::Whole(text.as_bytes().to_vec()))
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
        assert_eq!(parse(r#"{"class":"ZERO","channel":"thumb"}"#), Ok(Request::Instrument(Instrument::Zero)));
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
            Request::Instrument(Instrument::Calibrate),
        ];
        for request in requests {
            let mut line = Vec::new();
            request.write(&mut line);
            assert_eq!(line.pop(), Some(b'\n'));
            assert_eq!(Request::parse(&Line::Whole(line)), Ok(request));
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
        assert_eq!(Request::parse(&Line::TooLong).unwrap_err().code, ErrorCode::LineTooLong);
        let binary = Request::parse(&Line::Whole(vec![b'{', 0xff, 0x00])).unwrap_err();
        assert_eq!((binary.code, binary.message.contains("UTF-8")), (ErrorCode::BadRequest, true));
        assert_eq!(code(&"[".repeat(60_000)), ErrorCode::BadRequest);
    }

    #[test]
    fn answers_stay_short_whatever_was_sent() {
        let long = "ü".repeat(20_000);
        let bad_requests =
            [format!(r#"{{"class":"{long}"}}"#), format!(r#"{{"class":"WATCH","{long}":1}}"#), long.clone()];
        for text in bad_requests {
            let mut answer = Vec::new();
            parse(&text).unwrap_err().write(&mut answer);
            assert!(answer.len() < 600, "{} bytes", answer.len());
        }
    }

    proptest! {
        #![proptest_config(crate::seed::cases(256))]

        #[test]
        fn any_bytes_get_an_answer(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = Request::parse(&Line::Whole(bytes));
        }
    }
}
