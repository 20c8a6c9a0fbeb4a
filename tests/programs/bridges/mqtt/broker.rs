//! As much of a broker (MQTT 3.1.1) as one client needs.

use crate::waiting::PATIENCE;
use serde_json::Value;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};

/// Listens, and hands out one connection after the other.
pub struct Broker(TcpListener);

/// What a client asked for when it connected.
#[derive(Debug)]
pub struct Connect {
    pub client_id: String,
    pub will: [String; 2],
    pub login: Option<[String; 2]>,
}

/// A publication.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Publish {
    pub topic: String,
    pub payload: String,
    pub is_retained: bool,
}

impl Publish {
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.payload).unwrap()
    }
}

impl Broker {
    pub fn new() -> Broker {
        Broker(TcpListener::bind("127.0.0.1:0").unwrap())
    }

    pub fn address(&self) -> SocketAddr {
        self.0.local_addr().unwrap()
    }

    /// The next connection, answered with this code (0: welcome).
    pub fn accept(&self, code: u8) -> (Session, Connect) {
        let (socket, _) = self.0.accept().unwrap();
        socket.set_read_timeout(Some(PATIENCE)).unwrap();
        let mut session = Session(socket);
        let (kind, body) = session.packet().unwrap();
        assert_eq!(kind >> 4, 1, "not a CONNECT");
        let mut body = Body(&body);
        assert_eq!((body.text(), body.byte()), ("MQTT".to_owned(), 4));
        let flags = body.byte();
        let _keep_alive = body.u16();
        let client_id = body.text();
        let will = [body.text(), body.text()];
        let login = (flags & 0xc0 == 0xc0).then(|| [body.text(), body.text()]);
        session.0.write_all(&[0x20, 2, 0, code]).unwrap();
        (session, Connect { client_id, will, login })
    }
}

/// A connection.
pub struct Session(TcpStream);

impl Session {
    /// The next publication of the client, its other wishes fulfilled; `None`: it has left, with or without a word.
    pub fn next(&mut self) -> Option<Publish> {
        loop {
            let (head, bytes) = self.packet()?;
            let mut body = Body(&bytes);
            match head >> 4 {
                3 => {
                    let topic = body.text();
                    if head & 0b110 != 0 {
                        let id = body.u16().to_be_bytes();
                        self.answer(&[0x40, 2, id[0], id[1]]);
                    }
                    let payload = String::from_utf8(body.0.to_vec()).unwrap();
                    return Some(Publish { topic, payload, is_retained: head & 1 == 1 });
                }
                8 => self.answer(&[0x90, 3, bytes[0], bytes[1], 0]),
                12 => self.answer(&[0xd0, 0]),
                14 => return None,
                _ => {}
            }
        }
    }

    /// A client may leave with its last word, before any answer: what it has said is then still to be read.
    fn answer(&mut self, bytes: &[u8]) {
        let _ = self.0.write_all(bytes);
    }

    /// The next one on this topic.
    pub fn next_on(&mut self, topic: &str) -> Publish {
        std::iter::from_fn(|| self.next()).find(|publish| publish.topic == topic).unwrap()
    }

    /// Says something to the client.
    pub fn say(&mut self, topic: &str, payload: &str) {
        let mut bytes = vec![0x30, (2 + topic.len() + payload.len()) as u8, 0, topic.len() as u8];
        bytes.extend_from_slice(topic.as_bytes());
        bytes.extend_from_slice(payload.as_bytes());
        self.0.write_all(&bytes).unwrap();
    }

    fn packet(&mut self) -> Option<(u8, Vec<u8>)> {
        let mut byte = [0];
        self.0.read_exact(&mut byte).ok()?;
        let head = byte[0];
        let (mut length, mut shift) = (0, 0);
        loop {
            self.0.read_exact(&mut byte).ok()?;
            length |= usize::from(byte[0] & 0x7f) << shift;
            shift += 7;
            if byte[0] & 0x80 == 0 {
                break;
            }
        }
        let mut body = vec![0; length];
        self.0.read_exact(&mut body).ok()?;
        Some((head, body))
    }
}

struct Body<'a>(&'a [u8]);

impl Body<'_> {
    fn byte(&mut self) -> u8 {
        let (byte, rest) = self.0.split_first().unwrap();
        self.0 = rest;
        *byte
    }

    fn u16(&mut self) -> u16 {
        u16::from_be_bytes([self.byte(), self.byte()])
    }

    fn text(&mut self) -> String {
        let length = self.u16().into();
        let (text, rest) = self.0.split_at(length);
        self.0 = rest;
        String::from_utf8(text.to_vec()).unwrap()
    }
}
