//! A bridge beside its daemon, and as much of an HTTP client as the tests need.

use crate::cermctl::daemon::{Daemon, Running};
use crate::waiting::PATIENCE;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::mpsc::{Receiver, channel};

/// A running bridge, and what it says.
pub struct Bridge {
    pub process: Running,
    said: Receiver<String>,
}

impl Bridge {
    pub fn start(daemon: &Daemon, arguments: &[&str]) -> Bridge {
        let mut process = daemon.spawn(arguments);
        let stderr = BufReader::new(process.child().stderr.take().unwrap());
        let (tell, said) = channel();
        std::thread::spawn(move || stderr.lines().map_while(Result::ok).try_for_each(|line| tell.send(line)));
        Bridge { process, said }
    }

    /// The rest of the next line that it says with these words in it.
    pub fn says(&self, words: &str) -> String {
        loop {
            let line = self.said.recv_timeout(PATIENCE).unwrap_or_else(|_| panic!("it never says {words:?}"));
            if let Some((_, rest)) = line.split_once(words) {
                return rest.to_owned();
            }
        }
    }

    /// Where it serves pages.
    pub fn address(&self) -> SocketAddr {
        self.says("serving http://").trim_end_matches('/').parse().unwrap()
    }
}

/// Connects and asks for a page.
pub fn ask(address: SocketAddr, path: &str, headers: &str) -> TcpStream {
    let mut socket = TcpStream::connect(address).unwrap();
    socket.set_read_timeout(Some(PATIENCE)).unwrap();
    write!(socket, "GET {path} HTTP/1.1\r\nHost: {address}\r\n{headers}\r\n").unwrap();
    socket
}

/// Head and body of a page.
pub fn get(address: SocketAddr, path: &str, headers: &str) -> (String, String) {
    let mut answer = String::new();
    ask(address, path, headers).read_to_string(&mut answer).unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    (head.to_owned(), body.to_owned())
}
