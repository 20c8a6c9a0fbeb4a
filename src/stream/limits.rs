//! The constants of the stream: what is agreed with clients, and what bounds the cost of one.

/// Changes when old clients can no longer understand the stream; a tape has the same.
pub const PROTO_MAJOR: u32 = 1;
/// Changes when fields or classes are added.
pub const PROTO_MINOR: u32 = 0;
/// The longest line either side may send, bytes, its newline included.
pub const MAX_LINE_BYTES: usize = 64 * 1024;

/// Significant digits of a value: more than any reading has of its own.
pub const VALUE_DIGITS: usize = 7;
/// Significant digits of an uncertainty (GUM 7.2.6: two are enough, one more against rounding).
pub const UNCERTAINTY_DIGITS: usize = 3;
/// Significant digits of a time since the start, and of a rate: ns in a second.
pub const TIME_DIGITS: usize = 9;

/// Significant digits of a time on a tape: 0.1 ns in a discharge of a second, and far below what a clock of 1 ns tells.
pub const TAPE_DIGITS: usize = 10;

/// Characters of a client's own text that an answer repeats: answers stay short whatever was sent.
pub const EXCERPT: usize = 40;
/// Characters of serde's complaint about a request, which may repeat that text, too.
pub const COMPLAINT: usize = 200;

/// The longest time on a tape, ns (one hour): a greater number is a mistake of units.
pub const LONGEST_NS: f64 = 3.6e12;
/// The largest leak on a tape, siemens: 1 ohm, beside which no capacitor is charged.
pub const LARGEST_LEAK_SIEMENS: f64 = 1.0;
/// The most that d may change with an error of switches: that is about 1 / (1 - R_1 / R_2).
pub const LARGEST_BY_SWITCH: f64 = 1e6;

/// What the server spends on one turn and one client.
#[cfg(feature = "programs")]
pub mod serving {
    use crate::units::Nanos;

    /// What readings come to is said of at least so long, s: at 1 reading a second their rate is known to a tenth.
    pub const ACHIEVED_OVER_S: f64 = 10.0;
    /// Clients at a time; the next one is told "busy" and closed.
    pub const CLIENTS: usize = 1024;
    /// Of these, kept for root and the daemon's own user.
    pub const CLIENTS_KEPT: usize = 16;
    /// Clients of one other user at a time: two of them at least are needed to shut out a third.
    pub const CLIENTS_OF_A_USER: usize = 504;
    /// Descriptors of the daemon that are not clients: pins, signals, epoll, the log, files while they are read.
    pub const OTHER_DESCRIPTORS: usize = 64;
    /// Lines that wait for a client that reads slowly: 10 s at 100 lines/s.
    pub const QUEUE_LINES: usize = 1024;
    /// Rounds of calibration discharges that a tape begins with: a state takes 32, and some may be spikes.
    pub const ROUNDS: usize = 40;
    /// `SO_SNDBUF` of each client, bytes: 32 MiB in the kernel when 1024 clients do not read.
    pub const SEND_BUFFER_BYTES: usize = 16 * 1024;
    /// Connections that are accepted in one turn.
    pub const ACCEPTS_PER_TURN: usize = 64;
    /// Ready descriptors of one turn; the others stay ready.
    pub const EVENTS_PER_TURN: usize = 64;
    /// How long accepting rests when the process or the system is out of descriptors or memory.
    pub const ACCEPT_PAUSE: Nanos = Nanos(100_000_000);
    /// How long that is not said again: it may come and go with each client.
    pub const ACCEPT_SAID_FOR: Nanos = Nanos(600_000_000_000);
    /// Bytes that are read of one client before the next one has its turn.
    pub const READ_BYTES: usize = 4096;
    /// Lines that are written to one client before the next one has its turn.
    pub const LINES_PER_TURN: usize = 32;
    /// An output buffer above this size is given back as soon as it is empty, bytes.
    pub const KEPT_OUTPUT_BYTES: usize = 1024;
    /// A queue with room for more than this is given back as soon as it is empty, lines.
    pub const KEPT_QUEUE_LINES: usize = 32;
}
