use super::bench::Bridge;
use crate::cermctl::daemon::Daemon;
use crate::waiting::{PATIENCE, until_so};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};

/// A client of iiod's protocol.
struct Client(BufReader<TcpStream>);

impl Client {
    fn new(address: SocketAddr) -> Client {
        let socket = TcpStream::connect(address).unwrap();
        socket.set_read_timeout(Some(PATIENCE)).unwrap();
        Client(BufReader::new(socket))
    }

    fn send(&mut self, command: &str) {
        self.0.get_mut().write_all(format!("{command}\r\n").as_bytes()).unwrap();
    }

    fn line(&mut self) -> String {
        let mut line = String::new();
        self.0.read_line(&mut line).unwrap();
        line.trim_end().to_owned()
    }

    /// The number that answers a command.
    fn number(&mut self, command: &str) -> i64 {
        self.send(command);
        self.line().parse().unwrap()
    }

    /// The text that answers a command, or the number of an error.
    fn text(&mut self, command: &str) -> Result<String, i64> {
        let length = self.number(command);
        let length = usize::try_from(length).map_err(|_| length)?;
        let mut text = vec![0; length + 1];
        self.0.read_exact(&mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        Ok(text.trim_end_matches(['\n', '\0']).to_owned())
    }

    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        let mut bytes = [0; N];
        self.0.read_exact(&mut bytes).unwrap();
        bytes
    }
}

const INPUT: &str = "READ iio:device0 INPUT resistance1 input";
const STATUS: &str = "READ iio:device0 INPUT resistance1 status";
const ENODATA: i64 = -61;

/// A bridge with these arguments beside its address, that address, and a client.
fn serving(daemon: &Daemon, arguments: &[&str]) -> (Bridge, SocketAddr, Client) {
    let bridge = Bridge::start(daemon, &[&["bridge", "iio", "--listen", "127.0.0.1:0"], arguments].concat());
    let address = bridge.says("serving ip:").parse().unwrap();
    (bridge, address, Client::new(address))
}

#[test]
fn a_client_reads_attributes_and_buffers() {
    let mut daemon = Daemon::start();
    let (mut bridge, _, mut client) = serving(&daemon, &["--stale", "1 s"]);
    client.send("VERSION");
    assert_eq!(client.line(), "0.24.cermd00");
    until_so("a reading", || client.text(STATUS).as_deref() == Ok("ok"));
    let xml = client.text("PRINT").unwrap();
    assert!(xml.contains("<channel id=\"resistance1\" name=\"index\" type=\"input\">"), "{xml}");
    let ohm: f64 = client.text(INPUT).unwrap().parse().unwrap();
    assert!((ohm - 2000.0).abs() < 100.0, "{ohm}");

    // resistance0, force0, resistance1, timestamp: the last two.
    assert_eq!(client.number("OPEN iio:device0 4 0000000c"), 0);
    assert_eq!(client.number("OPEN iio:device0 4 0000000c"), -16, "EBUSY");
    client.send("READBUF iio:device0 32");
    for row in 0..2 {
        assert_eq!(client.line(), "16");
        if row == 0 {
            assert_eq!(client.line(), "0000000c");
        }
        let milliohm = i64::from_le_bytes(client.bytes());
        assert!((milliohm - 2_000_000).abs() < 100_000, "{milliohm}");
        let age_ns = jiff::Timestamp::now().as_nanosecond() - i128::from(i64::from_le_bytes(client.bytes()));
        assert!((0..10_000_000_000).contains(&age_ns), "{age_ns} ns");
    }

    daemon.kill();
    until_so("the news of a kill", || client.text(STATUS).as_deref() == Ok("unknown"));
    assert_eq!(client.text(INPUT), Err(ENODATA));
    assert_eq!(client.number("TIMEOUT 100"), 0);
    assert!(client.text("PRINT").is_err(), "a device without a daemon");
    // The open buffer is of the device before.
    // What was measured before the kill may still come.
    until_so("the end of the rows", || {
        let answer = client.number("READBUF iio:device0 16");
        if answer == 16 {
            // The mask and the row.
            client.line();
            let _: [u8; 16] = client.bytes();
        }
        answer == -110
    });
    assert_eq!(client.number("CLOSE iio:device0"), 0);
    daemon.run();
    until_so("readings of the next daemon", || client.text(INPUT).is_ok());
    bridge.process.interrupt();
    assert_eq!(bridge.process.end().0, Some(0));
}

#[test]
fn nonsense_is_refused() {
    let daemon = Daemon::start();
    let (_bridge, address, mut client) = serving(&daemon, &[]);
    until_so("a daemon", || client.text("PRINT").is_ok());
    for (command, errno) in [
        ("HELLO", -22),
        ("GETTRIG iio:device0", -22),
        ("WRITE iio:device0 INPUT resistance0 raw 1", -22),
        ("TIMEOUT soon", -22),
        ("READ iio:device0 INPUT resistance7 raw", -2),
        ("READ iio:device0 INPUT resistance0 colour", -2),
        ("READ iio:device0 sampling_frequency", -2),
        ("OPEN iio:device1 1 00000001", -19),
        ("OPEN iio:device0 1 00000000", -22),
        ("OPEN iio:device0 1 00000010", -22),
        ("OPEN iio:device0 1 mask", -22),
        ("READBUF iio:device0 8", -9),
        ("CLOSE iio:device0", -9),
    ] {
        assert_eq!(client.number(command), errno, "{command}");
    }
    assert_eq!(client.number("OPEN iio:device0 1 00000004"), 0);
    for bytes in ["0", "7", "-8", "many"] {
        assert_eq!(client.number(&format!("READBUF iio:device0 {bytes}")), -22, "{bytes}");
    }
    // A command without an end ends the connection, and no other one.
    let mut endless = Client::new(address);
    let _ = endless.0.get_mut().write_all(&[b'x'; 5000]);
    let mut rest = Vec::new();
    let _ = endless.0.read_to_end(&mut rest);
    assert!(rest.is_empty());
    assert!(client.text("PRINT").is_ok());
}

/// As many as there are places, and one of them that says something now and then.
#[test]
fn clients_that_say_nothing_make_room_for_one_that_asks() {
    let daemon = Daemon::start();
    let (_bridge, address, mut talking) = serving(&daemon, &[]);
    until_so("a daemon", || talking.text("PRINT").is_ok());
    let since = Instant::now();
    let _silent: Vec<Client> = (0..31).map(|_| Client::new(address)).collect();
    // Nobody has been silent for long yet: the next one is turned away at once.
    let turned_away = |command: &str| {
        let mut next = Client::new(address);
        let _ = next.0.get_mut().write_all(format!("{command}\r\n").as_bytes());
        let mut line = String::new();
        next.0.read_line(&mut line).map_or(true, |length| length == 0)
    };
    assert!(turned_away("VERSION") || since.elapsed() > Duration::from_secs(9));
    until_so("a place", || {
        assert!(talking.text("PRINT").is_ok(), "who talks stays");
        !turned_away("VERSION")
    });
    assert!(talking.text(STATUS).is_ok());
}
