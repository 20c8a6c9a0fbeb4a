//! The constants of the daemon.

use crate::units::Nanos;
use std::time::Duration;

/// How often the main thread looks after the measuring thread when nothing else wakes it.
pub const LOOK_AFTER: Duration = Duration::from_millis(500);
/// From one attempt to bind a socket, something being in its way, to the next.
pub const LISTEN_AGAIN: Duration = Duration::from_millis(500);
/// From one status line to the next where the service manager has no watchdog.
pub const STATUS_EVERY: Duration = Duration::from_secs(5);
/// A suspect of the board that has not shown for so long is gone.
pub const GONE_AFTER: Nanos = Nanos(10_000_000_000);

/// Results that wait between the threads: a second or more of the fastest cycle with all channels.
pub const RING: usize = 4096;
/// Events that wait for the main thread: a second of the fastest readings, each of them an event.
pub const EVENT_RING: usize = 1024;
/// From one attempt to have an output that failed to the next.
pub const OUTPUT_AGAIN: Nanos = Nanos(1_000_000_000);
/// How often the measuring thread tells its counters.
pub const STATS_EVERY: Nanos = Nanos(250_000_000);
/// The longest wait of the measuring thread without a look at whether to stop.
pub const NAP: Nanos = Nanos(100_000_000);
/// How long the end of each thread is waited for: many naps, and for both together half of what the service manager waits for the
/// end of this process (TimeoutStopSec= of systemd/cermd.service).
pub const STOP_PATIENCE: Nanos = Nanos(2_500_000_000);
/// How often it is looked for.
pub const STOP_LOOK: Duration = Duration::from_millis(1);
/// Naps before pins that failed are opened again: a second.
pub const NAPS_TO_REOPEN: usize = 10;
/// How long the kernel takes at most to take a chip apart.
pub const TAKEN_APART: Duration = Duration::from_millis(100);
