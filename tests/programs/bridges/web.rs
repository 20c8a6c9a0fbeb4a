use super::bench::{Bridge, ask, get};
use crate::cermctl::daemon::Daemon;
use crate::waiting::until_so;
use serde_json::Value;
use std::io::{BufRead, BufReader, Lines};
use std::net::TcpStream;

/// Events of a page, by their names.
struct Events(Lines<BufReader<TcpStream>>);

impl Events {
    fn next_of(&mut self, name: &str) -> Value {
        loop {
            let line = self.0.next().unwrap().unwrap();
            if line.strip_prefix("event: ") == Some(name) {
                let data = self.0.next().unwrap().unwrap();
                return serde_json::from_str(data.strip_prefix("data: ").unwrap()).unwrap();
            }
        }
    }
}

#[test]
fn a_page_hears_readings_figures_and_outages() {
    let mut daemon = Daemon::start();
    let mut bridge = Bridge::start(&daemon, &["web", "--listen", "127.0.0.1:0"]);
    let address = bridge.address();
    for (path, kind) in [("/", "text/html"), ("/page.js", "text/javascript"), ("/page.css", "text/css")] {
        let (head, body) = get(address, path, "");
        assert!(head.contains(&format!("Content-Type: {kind}; charset=utf-8\r\n")), "{head}");
        assert!(head.contains("Content-Security-Policy: default-src 'none'; script-src 'self'"), "{head}");
        // Whatever the policy forbids is not there.
        assert!(
            !body.contains("http://") && !body.contains("https://") && !body.contains("style=\""),
            "{path}"
        );
    }
    let mut events = Events(BufReader::new(ask(address, "/events", "")).lines());
    assert_eq!(events.next_of("up")["channels"][0]["id"], "thumb");
    assert!(events.next_of("stats")["readings"].is_u64());
    let reading = events.next_of("reading");
    assert!(reading["class"] == "READING" && reading["status"].is_string(), "{reading}");
    // This page and 31 more, and not one beyond.
    let status = || {
        let mut line = String::new();
        BufReader::new(ask(address, "/events", "")).read_line(&mut line).unwrap();
        line
    };
    let mut pages: Vec<_> =
        (1..32).map(|_| Events(BufReader::new(ask(address, "/events", "")).lines())).collect();
    for page in &mut pages {
        page.next_of("up");
    }
    assert_eq!(status(), "HTTP/1.1 503 Service Unavailable\r\n");
    drop(pages);
    until_so("a place that has come free", || status().starts_with("HTTP/1.1 200"));
    daemon.kill();
    events.next_of("down");
    daemon.run();
    events.next_of("up");
    events.next_of("reading");
    bridge.process.interrupt();
    assert_eq!(bridge.process.end().0, Some(0));
}
