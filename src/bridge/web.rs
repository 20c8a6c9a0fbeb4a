//! A page for browsers: every channel live, and the health of the instrument. What is heard goes out as server-sent events,
//! each line as the daemon wrote it.

mod hub;

use super::feed::Feed;
use super::http::{self, Answer, Body, Handler, Request};
use super::latest::now;
use super::limits::MAX_HZ;
use super::{BridgeError, Upstream, Wish, lock};
use hub::Pages;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex};

/// Nothing of elsewhere, nothing inline, in no frame: whatever a channel is called, it is text.
const POLICY: &str = "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; \
                      connect-src 'self'; img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n\
                      Referrer-Policy: no-referrer\r\n";

/// Serves the page until somebody wants the end. `names`: as in [`http::serve`].
///
/// # Errors
/// The address is not to be had.
pub fn run(
    source: Upstream,
    address: SocketAddr,
    names: &[String],
    wish: Wish<'_>,
) -> Result<(), BridgeError> {
    let listener = http::listen(address)?;
    let hub = Arc::new(Mutex::new(Pages::new(source.patience)));
    let handler: Handler = {
        let hub = Arc::clone(&hub);
        Box::new(move |request| answer(request, &hub))
    };
    std::thread::scope(|scope| {
        scope.spawn(|| {
            Feed::new(source.socket, Some(MAX_HZ)).hear(wish, |heard| lock(&hub).hear(heard, now()));
        });
        http::serve(&listener, names, handler, wish);
    });
    Ok(())
}

fn answer(request: &Request, hub: &Mutex<Pages>) -> Answer {
    match &*request.path {
        "/" => page("text/html; charset=utf-8", include_str!("web/page.html")),
        "/page.css" => page("text/css; charset=utf-8", include_str!("web/page.css")),
        "/page.js" => page("text/javascript; charset=utf-8", include_str!("web/page.js")),
        "/events" => events(hub),
        _ => Answer::not_found("/"),
    }
}

fn page(content_type: &'static str, text: &'static str) -> Answer {
    Answer { status: "200 OK", content_type, headers: POLICY, body: Body::Whole(text.into()) }
}

fn events(hub: &Mutex<Pages>) -> Answer {
    let Some(listener) = lock(hub).join() else {
        return Answer::text("503 Service Unavailable", "too many pages are open: close some");
    };
    let body = Body::Pieces(Box::new(move || listener.next()));
    Answer { status: "200 OK", content_type: "text/event-stream", headers: POLICY, body }
}
