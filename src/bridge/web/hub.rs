//! From one feed to many pages.

use crate::bridge::feed::Heard;
use crate::bridge::limits::{PAGE_EVENTS, PAGES, STILL_THERE};
use crate::bridge::queue::{Inlet, Outlet, queue};
use crate::units::Nanos;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

/// An event as it is sent.
type Event = Arc<[u8]>;

/// The pages that listen, and what a new one must know.
#[derive(Debug)]
pub struct Pages {
    /// A reading that is older is not told.
    patience: Nanos,
    /// The daemon, or that there is none.
    daemon: Event,
    stats: Option<Event>,
    /// The channels of the daemon, each with the last event of its trigger, if there was one.
    pressed: BTreeMap<String, Option<Event>>,
    /// Those that listen.
    pages: Vec<Inlet<Event>>,
}

/// The end of a page.
#[derive(Debug)]
pub struct Listener(Outlet<Event>);

impl Listener {
    /// The next event, or after a while a comment, by which whoever has gone without a word is found; `None`: it was sent
    /// away.
    pub fn next(&self) -> Option<Vec<u8>> {
        // What still waits for it would keep a slow page, with its thread, for many minutes.
        if !self.0.is_fed() {
            return None;
        }
        match self.0.next(STILL_THERE) {
            Ok(event) => Some(event.to_vec()),
            Err(RecvTimeoutError::Timeout) => Some(b":\n\n".to_vec()),
            Err(RecvTimeoutError::Disconnected) => None,
        }
    }
}

impl Pages {
    pub fn new(patience: Duration) -> Pages {
        let patience = Nanos::from_seconds(patience.as_secs_f64());
        Pages {
            patience,
            daemon: event("down", "{}"),
            stats: None,
            pressed: BTreeMap::new(),
            pages: Vec::new(),
        }
    }

    /// A page more; `None`: there are too many.
    pub fn join(&mut self) -> Option<Listener> {
        // Where no daemon is, nothing is sent that would show who has gone.
        self.pages.retain(Inlet::is_read);
        if self.pages.len() >= PAGES {
            return None;
        }
        let (page, events) = queue(PAGE_EVENTS);
        let first = [Some(&self.daemon), self.stats.as_ref()];
        let first = first.into_iter().flatten().chain(self.pressed.values().flatten());
        if !first.map(Arc::clone).all(|event| page.offer(event)) {
            return None;
        }
        self.pages.push(page);
        Some(Listener(events))
    }

    pub fn hear(&mut self, heard: &Heard, now: Nanos) {
        match heard {
            Heard::Up(version) => {
                let patience_s = self.patience.as_seconds();
                let text = serde_json::json!({
                    "release": version.release, "channels": version.channels, "patience_s": patience_s,
                });
                (self.daemon, self.stats) = (event("up", &text.to_string()), None);
                self.pressed = version.channels.iter().map(|channel| (channel.id.clone(), None)).collect();
                self.send(&Arc::clone(&self.daemon));
            }
            Heard::Down => {
                (self.daemon, self.stats) = (event("down", "{}"), None);
                self.pressed.clear();
                self.send(&Arc::clone(&self.daemon));
            }
            Heard::Stats(_, line) => {
                let stats = event("stats", line);
                self.send(&stats);
                self.stats = Some(stats);
            }
            // Of no other channels, however many ids a daemon may send.
            Heard::Event(told, line) if self.pressed.contains_key(&told.channel) => {
                let pressed = event("event", line);
                self.send(&pressed);
                self.pressed.insert(told.channel.clone(), Some(pressed));
            }
            Heard::Reading(reading, line) if now - Nanos(reading.t_mono_ns) <= self.patience => {
                self.send(&event("reading", line));
            }
            Heard::Reading(..) | Heard::Event(..) | Heard::Nothing => {}
        }
    }

    /// A page that does not keep up is sent away: it comes again by itself, and knows then that it has missed something.
    fn send(&mut self, event: &Event) {
        self.pages.retain(|page| page.offer(Arc::clone(event)));
    }
}

/// `data` is one line: that of a message.
fn event(name: &str, data: &str) -> Event {
    format!("event: {name}\ndata: {data}\n\n").into_bytes().into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bridge::latest::tests::{event as tests_event, ok, reading, up};
    use crate::stream::wire::EventName;

    fn said(listener: &Listener) -> Vec<String> {
        listener.0.waiting().map(|event| String::from_utf8_lossy(&event).into_owned()).collect()
    }

    #[test]
    fn a_page_hears_what_is_so_and_then_what_comes() {
        let mut hub = Pages::new(Duration::from_nanos(10));
        let early = hub.join().unwrap();
        assert_eq!(said(&early), ["event: down\ndata: {}\n\n"]);
        hub.hear(&up(&["thumb"]), Nanos(0));
        hub.hear(&reading("thumb", 0, ok(1.0)), Nanos(10));
        hub.hear(&reading("thumb", 0, ok(2.0)), Nanos(11));
        let told = said(&early);
        assert!(told.len() == 2 && told[0].starts_with("event: up\n"), "{told:?}");
        assert!(
            told[1].starts_with("event: reading\ndata: {\"class\":\"READING\"") && told[1].ends_with("}\n\n")
        );
        for id in ["thumb", "nobody"] {
            hub.hear(&tests_event(id, EventName::Pressed, None), Nanos(11));
        }
        let pressed = said(&early);
        assert!(pressed.len() == 1 && pressed[0].starts_with("event: event\ndata: {\"class\":\"EVENT\""));
        let late = hub.join().unwrap();
        let so_far = [told[0].clone(), pressed[0].clone()];
        assert_eq!(said(&late), so_far, "what is so, and no reading of before it came");
        hub.hear(&Heard::Down, Nanos(12));
        assert_eq!(said(&late), ["event: down\ndata: {}\n\n"]);
    }

    #[test]
    fn a_page_that_sleeps_is_sent_away_and_places_come_free() {
        let mut hub = Pages::new(Duration::from_secs(1));
        hub.hear(&up(&["thumb"]), Nanos(0));
        let asleep = hub.join().unwrap();
        for _ in 0..2 * PAGE_EVENTS {
            hub.hear(&reading("thumb", 0, ok(1.0)), Nanos(0));
        }
        assert!(hub.pages.is_empty() && asleep.next().is_none(), "what waits for it keeps it");
        assert_eq!(said(&asleep).len(), PAGE_EVENTS);
        let pages: Vec<_> = (0..PAGES).map(|_| hub.join().unwrap()).collect();
        assert!(hub.join().is_none());
        drop(pages);
        assert!(hub.join().is_some());
    }
}
