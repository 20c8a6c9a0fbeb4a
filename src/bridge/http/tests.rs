use super::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

const PATIENCE: Duration = Duration::from_secs(60);

/// A server for the time of a test.
struct Bench {
    address: SocketAddr,
    end: Arc<AtomicBool>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Bench {
    fn new() -> Bench {
        let listener = listen("127.0.0.1:0".parse().unwrap()).unwrap();
        let (address, end) = (listener.local_addr().unwrap(), Arc::new(AtomicBool::new(false)));
        let wish = Arc::clone(&end);
        let handler: Handler = Box::new(|request: &Request| match &*request.path {
            "/" => Answer::text("200 OK", &request.accept),
            "/pieces" => {
                let mut count = 0;
                let next = move || {
                    count += 1;
                    (count <= 3).then(|| vec![b'0' + count; 2])
                };
                Answer { body: Body::Pieces(Box::new(next)), ..Answer::text("200 OK", "") }
            }
            _ => Answer::not_found("/"),
        });
        let names = ["bench".to_owned()];
        let thread =
            std::thread::spawn(move || serve(&listener, &names, handler, &|| wish.load(Ordering::Relaxed)));
        Bench { address, end, thread: Some(thread) }
    }

    fn connect(&self) -> TcpStream {
        let socket = TcpStream::connect(self.address).unwrap();
        socket.set_read_timeout(Some(PATIENCE)).unwrap();
        socket
    }

    fn ask(&self, request: &str) -> String {
        let mut socket = self.connect();
        socket.write_all(request.as_bytes()).unwrap();
        let mut answer = String::new();
        socket.read_to_string(&mut answer).unwrap();
        answer
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        self.end.store(true, Ordering::Relaxed);
        self.thread.take().unwrap().join().unwrap();
    }
}

fn status(answer: &str) -> &str {
    answer.split(' ').nth(1).unwrap_or(answer)
}

#[test]
fn requests_are_answered_or_refused() {
    let bench = Bench::new();
    let answer = bench.ask("GET /?x HTTP/1.1\r\nHost: 127.0.0.1:1\r\naccept: a/b\r\n\r\n");
    assert!(answer.contains("\r\nContent-Length: 4\r\n") && answer.ends_with("\r\n\r\na/b\n"), "{answer}");
    let head = bench.ask("HEAD / HTTP/1.1\r\nHost: bench\r\nAccept: a/b\r\n\r\n");
    assert!(status(&head) == "200" && head.ends_with("\r\n\r\n"), "{head}");
    assert!(bench.ask("GET /pieces HTTP/1.1\r\nHost: [::1]:80\r\n\r\n").ends_with("\r\n\r\n112233"));
    for (request, wanted) in [
        ("GET /no HTTP/1.1\r\nHost: localhost\r\n\r\n", "404"),
        ("POST / HTTP/1.1\r\nHost: localhost\r\n\r\n", "405"),
        ("GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n", "403"),
        ("GET / HTTP/1.1\r\n\r\n", "403"),
        ("GET /\r\n\r\n", "400"),
        ("GET / HTTP/2\r\nHost: localhost\r\n\r\n", "400"),
        ("\r\n\r\n", "400"),
    ] {
        assert_eq!(status(&bench.ask(request)), wanted, "{request:?}");
    }
}

#[test]
fn a_request_that_never_ends_is_cut() {
    let bench = Bench::new();
    let mut socket = bench.connect();
    let mut answer = String::new();
    let _ = socket.write_all(&b"GET / HTTP/1.1\r\nx: ".repeat(600));
    // The end may come as a reset, since there was more to read.
    let _ = socket.read_to_string(&mut answer);
    assert!(answer.is_empty() || status(&answer) == "431", "{answer}");
}

#[test]
fn names_of_elsewhere_are_refused() {
    let names = ["localhost".to_owned(), "pi.local".to_owned()];
    for own in ["localhost", "LocalHost:80", "192.168.1.7:80", "[::1]", "[fe80::1]:80", "pi.local"] {
        assert!(is_own(own, &names), "{own}");
    }
    for other in ["", "evil.example", "localhost.evil.example:80", "127.0.0.1.evil.example", "[localhost"] {
        assert!(!is_own(other, &names) || other == "[localhost", "{other}");
    }
}

#[test]
fn a_thousand_that_say_nothing_do_not_shut_out_the_one_that_asks() {
    let bench = Bench::new();
    let silent: Vec<_> = (0..1000)
        .map(|_| {
            let socket = bench.connect();
            if socket.peer_addr().is_err() {
                panic!("not connected")
            };
            socket
        })
        .collect();
    let since = Instant::now();
    assert_eq!(status(&bench.ask("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n")), "200");
    assert!(since.elapsed() < PATIENCE);
    // Those that were shut out end as soon as they get to it; other tests have threads of their own.
    let threads = || std::fs::read_dir("/proc/self/task").unwrap().count();
    while threads() >= PAGE_WAITING + 64 {
        let (count, crowd) = (threads(), silent.len());
        assert!(since.elapsed() < PATIENCE, "{count} threads for {crowd} connections");
        std::thread::sleep(Duration::from_millis(10));
    }
}
