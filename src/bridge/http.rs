//! As much of an HTTP server as a page and its events need: GET, one request a connection, bounded in everything.

use super::limits::{PAGE_PATIENCE, PAGE_WAITING, REQUEST_BYTES};
use super::server::{self, Place, Places};
use super::{BridgeError, Wish};
use std::io::{self, Read, Write};
use std::net::{IpAddr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::time::{Duration, Instant};

/// What is asked for.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Request {
    /// Without what follows a "?".
    pub path: String,
    /// The header Accept.
    pub accept: String,
}

/// What is answered.
pub struct Answer {
    /// 200 and its like, with its words.
    pub status: &'static str,
    /// The type of the body.
    pub content_type: &'static str,
    /// More headers, each with its line end.
    pub headers: &'static str,
    /// The body.
    pub body: Body,
}

/// The body of an answer.
pub enum Body {
    /// All of it.
    Whole(Vec<u8>),
    /// Piece by piece, until there is none. Whoever takes too long for a piece gets no other.
    Pieces(Box<dyn FnMut() -> Option<Vec<u8>> + Send>),
}

impl Answer {
    /// A line of text.
    pub fn text(status: &'static str, text: &str) -> Answer {
        let body = Body::Whole(format!("{text}\n").into_bytes());
        Answer { status, content_type: "text/plain; charset=utf-8", headers: "", body }
    }

    /// There is no such page.
    pub fn not_found(known: &str) -> Answer {
        Answer::text("404 Not Found", &format!("there is {known}"))
    }
}

/// What answers; called from many threads.
pub type Handler = Box<dyn Fn(&Request) -> Answer + Send + Sync>;

/// Listens.
///
/// # Errors
/// The address is taken, not of this machine, or not for this user.
pub fn listen(address: SocketAddr) -> Result<TcpListener, BridgeError> {
    let (listener, bound) = server::listen(address)?;
    log::info!("serving http://{bound}/");
    Ok(listener)
}

/// Answers until somebody wants the end. `names`: host names by which a browser may call this machine, beside its own.
pub fn serve(listener: &TcpListener, names: &[String], handler: Handler, wish: Wish<'_>) {
    let names: Vec<String> = names.iter().cloned().chain(own_names()).collect();
    // Who waits for its answer has said all: the oldest gives way at once.
    let places = Places::new(PAGE_WAITING, Duration::ZERO);
    server::serve(listener, &places, move |socket, place| converse(socket, &names, &handler, place), wish);
}

fn converse(mut socket: TcpStream, names: &[String], handler: &Handler, place: &Place) -> io::Result<()> {
    let (request, is_head) = match read_head(&mut socket)? {
        Ok(head) => match parse(&head, names) {
            Ok(request) => request,
            Err(refusal) => return write(&mut socket, refusal, false, place),
        },
        Err(refusal) => return write(&mut socket, refusal, false, place),
    };
    write(&mut socket, handler(&request), is_head, place)
}

/// Request line and headers.
fn read_head(socket: &mut TcpStream) -> io::Result<Result<String, Answer>> {
    let until = Instant::now() + PAGE_PATIENCE;
    let (mut head, mut chunk) = (Vec::new(), [0; 1024]);
    while !head.windows(4).any(|end| end == b"\r\n\r\n") {
        if head.len() > REQUEST_BYTES {
            return Ok(Err(Answer::text("431 Request Header Fields Too Large", "the request is too long")));
        }
        socket.set_read_timeout(Some(left(until)?))?;
        match socket.read(&mut chunk)? {
            0 => return Err(io::ErrorKind::UnexpectedEof.into()),
            length => head.extend_from_slice(&chunk[..length]),
        }
    }
    Ok(String::from_utf8(head).map_err(|_| Answer::text("400 Bad Request", "the request is not text")))
}

/// The request, and whether only the head of its answer is wanted.
fn parse(head: &str, names: &[String]) -> Result<(Request, bool), Answer> {
    let mut lines = head.split("\r\n");
    let mut words = lines.next().unwrap_or_default().split(' ');
    let (method, target, version) = (words.next(), words.next(), words.next());
    let (Some(method), Some(target), Some("HTTP/1.1" | "HTTP/1.0")) = (method, target, version) else {
        return Err(Answer::text("400 Bad Request", "this is no HTTP/1"));
    };
    let is_head = match method {
        "GET" => false,
        "HEAD" => true,
        _ => {
            return Err(Answer::text(
                "405 Method Not Allowed",
                "GET and HEAD only: nothing can be changed here",
            ));
        }
    };
    let headers = || lines.clone().filter_map(|line| line.split_once(':'));
    let header = |wanted: &str| {
        let mut found = headers().filter(|(name, _)| name.eq_ignore_ascii_case(wanted));
        found.next().map_or("", |(_, value)| value.trim())
    };
    if !is_own(header("host"), names) {
        let why = "this host name is not of this machine; name it with --host";
        return Err(Answer::text("403 Forbidden", why));
    }
    let path = target.split('?').next().unwrap_or_default().to_owned();
    Ok((Request { path, accept: header("accept").to_owned() }, is_head))
}

/// Whether a browser that uses this name can only mean this machine: a page of somewhere else can have its own name point
/// here (DNS rebinding), but it cannot take an address or a name of ours for its own.
fn is_own(host: &str, names: &[String]) -> bool {
    let name = match host.strip_prefix('[') {
        Some(rest) => rest.split(']').next().unwrap_or_default(),
        None => host.split(':').next().unwrap_or_default(),
    };
    name.parse::<IpAddr>().is_ok() || names.iter().any(|own| own.eq_ignore_ascii_case(name))
}

fn own_names() -> Vec<String> {
    let mut names = vec!["localhost".to_owned()];
    if let Some(name) = nix::unistd::gethostname().ok().and_then(|name| name.into_string().ok()) {
        names.extend([format!("{name}.local"), name]);
    }
    names
}

fn write(socket: &mut TcpStream, answer: Answer, is_head: bool, place: &Place) -> io::Result<()> {
    let Answer { status, content_type, headers, body } = answer;
    let length = match &body {
        Body::Whole(bytes) => format!("Content-Length: {}\r\n", bytes.len()),
        Body::Pieces(_) => String::new(),
    };
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {content_type}\r\n{length}{headers}Cache-Control: no-store\r\n\
         X-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n"
    );
    write_by(socket, head.as_bytes())?;
    match body {
        _ if is_head => {}
        Body::Whole(bytes) => write_by(socket, &bytes)?,
        Body::Pieces(mut next) => {
            place.give_back();
            while let Some(piece) = next() {
                write_by(socket, &piece)?;
            }
        }
    }
    socket.shutdown(Shutdown::Write)
}

/// All of it within the patience.
fn write_by(socket: &mut TcpStream, mut bytes: &[u8]) -> io::Result<()> {
    let until = Instant::now() + PAGE_PATIENCE;
    while !bytes.is_empty() {
        socket.set_write_timeout(Some(left(until)?))?;
        match socket.write(bytes)? {
            0 => return Err(io::ErrorKind::WriteZero.into()),
            length => bytes = &bytes[length..],
        }
    }
    Ok(())
}

fn left(until: Instant) -> io::Result<Duration> {
    let left = until.saturating_duration_since(Instant::now());
    if left.is_zero() { Err(io::ErrorKind::TimedOut.into()) } else { Ok(left) }
}

#[cfg(test)]
mod tests;
