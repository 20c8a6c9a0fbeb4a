//! Prometheus: a page of metrics for its scrapes.

mod page;

use super::feed::Feed;
use super::http::{self, Answer, Body, Handler, Request};
use super::latest::{Latest, now};
use super::limits::MAX_HZ;
use super::{BridgeError, Upstream, Wish, lock};
use page::Format;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex};

/// Where the page is.
const PATH: &str = "/metrics";

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
    let latest = Arc::new(Mutex::new(Latest::new(source.patience)));
    let told = Arc::clone(&latest);
    let handler: Handler = Box::new(move |request: &Request| match &*request.path {
        PATH => answer(&lock(&told), Format::of(&request.accept)),
        _ => Answer::not_found(PATH),
    });
    std::thread::scope(|scope| {
        scope.spawn(|| Feed::new(source.socket, Some(MAX_HZ)).hear(wish, |heard| lock(&latest).hear(heard)));
        http::serve(&listener, names, handler, wish);
    });
    Ok(())
}

fn answer(latest: &Latest, format: Format) -> Answer {
    let body = Body::Whole(page::render(latest, now(), format).into_bytes());
    Answer { status: "200 OK", content_type: format.content_type(), headers: "", body }
}
