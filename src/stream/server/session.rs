//! One client's part of the conversation, without its socket.
//!
//! For: which line the client gets next. Must not know: descriptors, or other clients.

use super::hub::Hub;
use super::ring::{Entry, Kind};
use super::subscription::{RateLimit, Subscription};
use crate::stream::wire::{self, ErrorCode, LineSplitter, Object, Refusal, Request, Watch};

/// An output buffer above this size is given back as soon as it is empty.
const KEPT_OUTPUT_BYTES: usize = 1024;

/// What is remembered of a client: a position, a subscription, and at most one answer that it has not read yet.
///
/// A client whose output is not empty is neither answered nor sent anything new, so what it holds is bounded by
/// one answer and one unfinished request.
#[derive(Debug)]
pub(super) struct Session {
    input: LineSplitter,
    /// Whole lines; the first `sent` bytes are with the kernel.
    output: Vec<u8>,
    sent: usize,
    /// The position in the ring of the line that comes next.
    cursor: u64,
    /// Wanted lines that were overwritten since the last one it got.
    lost: u64,
    subscription: Subscription,
    /// The number of the VERSION that it got last; 0: none yet.
    version: u64,
    /// The header of a tape is due, before the line at this position in the ring: older ones belong to the one before it.
    tape_header_due: Option<u64>,
    /// May change the instrument: root, or the daemon's own user.
    privileged: bool,
}

impl Session {
    pub fn new(hub: &Hub, privileged: bool) -> Session {
        Session {
            input: LineSplitter::default(),
            output: Vec::new(),
            sent: 0,
            cursor: hub.ring.next(),
            lost: 0,
            subscription: Subscription::default(),
            version: 0,
            tape_header_due: None,
            privileged,
        }
    }

    /// Bytes from the client. Only while [`is_listening`](Session::is_listening).
    pub fn receive(&mut self, chunk: &[u8]) {
        self.input.feed(chunk);
    }

    /// The client has closed its side. It may go on reading.
    ///
    /// A last line without a newline is taken as ended: a truncated JSON object is never a valid one.
    pub fn receive_end(&mut self) {
        if self.input.is_amid_line() {
            self.input.feed(b"\n");
        }
    }

    /// Whether there is room for more requests.
    pub fn is_listening(&self) -> bool {
        self.output.is_empty() && !self.input.has_line()
    }

    pub fn watches(&self) -> bool {
        self.subscription.enable
    }

    pub fn wants_raw(&self) -> bool {
        self.watches() && self.subscription.raw
    }

    pub fn wants_readings(&self) -> bool {
        self.watches() && !self.subscription.raw
    }

    /// Another tape, of which the line at position `at` is the first that may be.
    pub fn announce_tape_header(&mut self, at: u64) {
        self.tape_header_due = self.wants_raw().then_some(at);
    }

    /// The line at `position` is about to be overwritten. Returns whether that is a loss for this client.
    pub fn overtaken(&mut self, position: u64, entry: &Entry) -> bool {
        if self.cursor != position {
            return false;
        }
        self.cursor += 1;
        let is_lost = self.subscription.wants(entry);
        self.lost += u64::from(is_lost);
        is_lost
    }

    /// Readings (or, if `raw`, discharges) were lost to everybody before they could be published. Of which
    /// channel they were is unknown, so they count whatever the filter. Returns how many count.
    pub fn miss(&mut self, lines: u64, raw: bool) -> u64 {
        let counted = if self.subscription.enable && self.subscription.raw == raw { lines } else { 0 };
        self.lost += counted;
        counted
    }

    /// The bytes to be sent next: to the end of one line. Empty when there is nothing to say.
    ///
    /// One line at a time, because the kernel takes a short write whole or not at all: a client sees no half
    /// line even when the daemon is killed.
    pub fn next_output(&mut self, hub: &Hub, stats: &mut dyn FnMut(&mut Object<'_>)) -> &[u8] {
        while self.output.is_empty() && self.compose(hub, stats) {}
        let rest = &self.output[self.sent..];
        let end = rest.iter().position(|&byte| byte == b'\n').map_or(rest.len(), |newline| newline + 1);
        &rest[..end]
    }

    /// The kernel has taken so many bytes of [`next_output`](Session::next_output).
    pub fn sent(&mut self, bytes: usize) {
        self.sent += bytes;
        if self.sent >= self.output.len() {
            self.sent = 0;
            self.output.clear();
            self.output.shrink_to(KEPT_OUTPUT_BYTES);
        }
    }

    /// Does one thing that is due. Returns false when nothing is.
    fn compose(&mut self, hub: &Hub, stats: &mut dyn FnMut(&mut Object<'_>)) -> bool {
        let cursor = self.cursor;
        let is_due = |at: &mut u64| cursor >= *at;
        if let Some(version) = hub.version(cursor, self.version) {
            self.version = version.number;
            self.output.extend_from_slice(&version.line);
        } else if self.tape_header_due.take_if(is_due).is_some() {
            self.output.extend_from_slice(&hub.tape_header);
        } else if let Some(line) = self.input.next_line() {
            if !is_blank(&line) {
                self.answer(&line, hub, stats);
            }
        } else if let Some(entry) = hub.ring.get(self.cursor) {
            self.cursor += 1;
            if self.subscription.wants(entry) {
                self.write_entry(entry);
            }
        } else {
            return false;
        }
        true
    }

    fn write_entry(&mut self, entry: &Entry) {
        let lost = std::mem::take(&mut self.lost);
        match entry.kind {
            Kind::Reading(_) => {
                self.output.extend_from_slice(&entry.line);
                wire::end_reading(&mut self.output, lost);
            }
            Kind::Raw(_) => {
                if lost > 0 {
                    let message = format!("{lost} lines of the tape were lost here: read faster");
                    Refusal::new(ErrorCode::Lost, message).write(&mut self.output);
                }
                self.output.extend_from_slice(&entry.line);
            }
        }
    }

    fn answer(&mut self, line: &wire::Line, hub: &Hub, stats: &mut dyn FnMut(&mut Object<'_>)) {
        let outcome = Request::parse(line).and_then(|request| match request {
            Request::Watch(watch) => self.watch(&watch, hub),
            Request::Poll => {
                hub.write_last_readings(&mut self.output);
                Ok(())
            }
            Request::Stats => {
                let mut object = Object::line(&mut self.output, "STATS");
                object.integer("clients", hub.clients as u64);
                object.integer("published", hub.published);
                object.integer("lost", hub.lost);
                stats(&mut object);
                object.end();
                Ok(())
            }
            Request::Instrument(_) => Err(self.refuse_instrument()),
        });
        if let Err(refusal) = outcome {
            refusal.write(&mut self.output);
        }
    }

    fn watch(&mut self, watch: &Watch, hub: &Hub) -> Result<(), Refusal> {
        let channels = watch.channels.as_deref().map(|ids| hub.resolve(ids)).transpose()?;
        let was_raw = self.wants_raw();
        if !self.subscription.enable || watch.raw != self.subscription.raw {
            // Another stream begins: it has no past, and nothing of it was lost. Otherwise what is still to be
            // sent goes through the new filter.
            self.cursor = hub.ring.next();
            self.lost = 0;
        }
        let limit = watch.max_hz.map(RateLimit::new);
        self.subscription = Subscription { enable: watch.enable, channels, raw: watch.raw, limit };
        if !was_raw || !self.wants_raw() {
            self.tape_header_due = self.wants_raw().then_some(0);
        }
        Ok(())
    }

    /// Where requests that change the instrument will be passed on to it.
    fn refuse_instrument(&self) -> Refusal {
        if self.privileged {
            let message = "this release cannot calibrate over the socket";
            Refusal::new(ErrorCode::Unsupported, message)
        } else {
            let message = "only root and the user that cermd runs as may change the instrument: try sudo";
            Refusal::new(ErrorCode::Forbidden, message)
        }
    }
}

fn is_blank(line: &wire::Line) -> bool {
    matches!(line, wire::Line::Whole(bytes) if bytes.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reading::{Fault, Method, Reading, Status};
    use crate::stream::wire::{ChannelInfo, Unit, UnixTime};
    use crate::units::Nanos;
    use proptest::prelude::*;

    fn hub(ring_lines: usize) -> Hub {
        Hub::new(&[ChannelInfo { id: "thumb".into(), unit: Unit::Newton }], ring_lines)
    }

    fn publish(hub: &mut Hub, session: &mut Session, seq: u64) {
        if let Some((position, entry)) = hub.ring.oldest_to_go() {
            session.overtaken(position, entry);
        }
        let status = Status::Fault(Fault::MissedEdge);
        let at = Nanos(seq as i64);
        let reading = Reading {
            channel: 0,
            seq,
            at,
            status,
            suspect: None,
            method: Method::Cerm,
            duration: Nanos::ZERO,
        };
        hub.keep_reading(&reading, UnixTime(0));
        hub.push_reading(0);
    }

    /// Sends at most so many bytes, as a kernel with little room would.
    fn send(hub: &Hub, session: &mut Session, mut room: usize, stream: &mut Vec<u8>) {
        while room > 0 {
            let line = session.next_output(hub, &mut |_| ());
            let length = line.len().min(room);
            if length == 0 {
                return;
            }
            stream.extend_from_slice(&line[..length]);
            session.sent(length);
            room -= length;
        }
    }

    fn answers(session: &mut Session, hub: &Hub, request: &str) -> String {
        let mut stream = Vec::new();
        session.receive(request.as_bytes());
        send(hub, session, usize::MAX, &mut stream);
        String::from_utf8(stream).unwrap()
    }

    #[test]
    fn the_instrument_is_for_the_privileged() {
        let hub = hub(4);
        for request in ["{\"class\":\"CALIBRATE\"}\n", "{\"class\":\"ZERO\",\"channel\":\"thumb\"}\n"] {
            let [mut other, mut owner] = [false, true].map(|privileged| Session::new(&hub, privileged));
            assert!(answers(&mut other, &hub, request).contains("\"code\":\"forbidden\""));
            assert!(answers(&mut owner, &hub, request).contains("\"code\":\"unsupported\""));
        }
    }

    #[test]
    fn a_tape_begins_with_its_header_and_has_no_past() {
        let mut hub = hub(4);
        hub.tape_header = b"{\"class\":\"TAPE\"}\n".to_vec();
        let mut session = Session::new(&hub, false);
        let discharge =
            |hub: &mut Hub, line: &[u8]| hub.ring.push(Kind::Raw(None), Nanos(0), |out| out.extend(line));
        discharge(&mut hub, b"before\n");
        let watch = answers(&mut session, &hub, "{\"class\":\"WATCH\",\"raw\":true}\n");
        assert!(watch.ends_with("]}\n{\"class\":\"TAPE\"}\n"), "{watch}");
        discharge(&mut hub, b"after\n");
        assert_eq!(answers(&mut session, &hub, ""), "after\n");
        assert_eq!(answers(&mut session, &hub, "{\"class\":\"WATCH\",\"raw\":true}\n"), "");
    }

    #[test]
    fn an_idle_client_holds_next_to_nothing() {
        let hub = hub(4);
        let mut session = Session::new(&hub, false);
        answers(&mut session, &hub, &"{\"class\":\"POLL\"}\n".repeat(1000));
        answers(&mut session, &hub, &format!("{{\"x\":\"{}\"}}\n", "y".repeat(60_000)));
        assert!(session.output.capacity() <= KEPT_OUTPUT_BYTES && session.is_listening());
    }

    #[test]
    fn a_slow_client_gets_old_lines_before_what_is_announced_after_them() {
        let mut hub = hub(4);
        let mut session = Session::new(&hub, false);
        answers(&mut session, &hub, "");
        (1..=2).for_each(|seq| publish(&mut hub, &mut session, seq));
        hub.set_channels(&[ChannelInfo { id: "thumb".into(), unit: Unit::Ohm }]);
        publish(&mut hub, &mut session, 3);
        let classes = |stream: String| -> Vec<String> {
            let lines = stream.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
            lines.map(|line| line["class"].as_str().unwrap().to_owned()).collect()
        };
        assert_eq!(classes(answers(&mut session, &hub, "")), ["READING", "READING", "VERSION", "READING"]);

        hub.set_channels(&[ChannelInfo { id: "thumb".into(), unit: Unit::Ohm }]);
        (4..=9).for_each(|seq| publish(&mut hub, &mut session, seq));
        let overtaken = classes(answers(&mut session, &hub, ""));
        assert_eq!(overtaken, ["VERSION", "READING", "READING", "READING", "READING"]);

        hub.set_channels(&[ChannelInfo { id: "thumb".into(), unit: Unit::Ohm }]);
        publish(&mut hub, &mut session, 10);
        session.announce_tape_header(hub.ring.next());
        assert_eq!(
            classes(answers(&mut session, &hub, "")),
            ["VERSION", "READING"],
            "a tape is no reason to wait"
        );
    }

    #[test]
    fn every_reading_comes_after_its_own_version() {
        let mut hub = hub(4);
        let mut session = Session::new(&hub, false);
        answers(&mut session, &hub, "");
        let channels = |unit| [ChannelInfo { id: "thumb".into(), unit }];
        publish(&mut hub, &mut session, 1);
        hub.set_channels(&channels(Unit::Ohm));
        publish(&mut hub, &mut session, 2);
        // Two at once: nothing was said under the first of them.
        hub.set_channels(&channels(Unit::Ohm));
        hub.set_channels(&channels(Unit::Newton));
        publish(&mut hub, &mut session, 3);
        let stream = answers(&mut session, &hub, "");
        let wanted = ["\"seq\":1,", "\"unit\":\"ohm\"", "\"seq\":2,", "\"unit\":\"N\"", "\"seq\":3,"];
        let lines: Vec<&str> = stream.lines().collect();
        assert!(
            lines.len() == 5 && lines.iter().zip(wanted).all(|(line, part)| line.contains(part)),
            "{stream}"
        );
        for seq in 4..1000 {
            hub.set_channels(&channels(Unit::Ohm));
            publish(&mut hub, &mut session, seq);
        }
        assert!(hub.versions() <= 5, "{} are kept", hub.versions());
    }

    proptest! {
        #![proptest_config(crate::seed::cases(256))]

        /// However little the kernel takes at a time: whole lines in order, and received + lost = published.
        #[test]
        fn every_reading_is_received_or_counted(
            steps in prop::collection::vec((0u64..12, 0usize..900), 1..60),
            ring_lines in 1usize..9,
        ) {
            let mut hub = hub(ring_lines);
            let mut session = Session::new(&hub, false);
            let (mut stream, mut published) = (Vec::new(), 0);
            for (readings, room) in steps {
                for _ in 0..readings {
                    published += 1;
                    publish(&mut hub, &mut session, published);
                }
                send(&hub, &mut session, room, &mut stream);
            }
            send(&hub, &mut session, usize::MAX, &mut stream);
            let mut previous = 0;
            for line in stream.split_inclusive(|&byte| byte == b'\n').skip(1) {
                let line: serde_json::Value = serde_json::from_slice(line).unwrap();
                let (seq, lost) = (line["seq"].as_u64().unwrap(), line["lost"].as_u64().unwrap());
                prop_assert_eq!(seq, previous + lost + 1);
                previous = seq;
            }
            prop_assert_eq!(previous, published, "the newest is never lost");
        }
    }
}
