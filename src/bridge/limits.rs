//! The constants of the bridges.
//!
//! | constant | value | unit | reason |
//! |---|---|---|---|
//! | `LOOK_AROUND` | 0.1 | s | how long a wait lasts before somebody looks whether to stop |
//! | `ANSWER` | 2 | s | a busy daemon answers well within it; one that does not hangs |
//! | `RETRY_AFTER` | 0.5 | s | from one attempt to reach the daemon to the next |
//! | `STATS_EVERY` | 1 | s | the figures of the daemon change slowly |
//! | `MAX_HZ` | 20 | Hz | readings of a channel a second: more than an eye, a broker or a scrape takes in |
//! | `PAGE_WAITING` | 64 | | connections whose answer is not yet written; the next one ends the oldest |
//! | `PAGE_PATIENCE` | 5 | s | for a request and for its answer, each as a whole |
//! | `REQUEST_BYTES` | 8192 | bytes | of a request with all its headers |
//! | `STACK_BYTES` | 131 072 | bytes | of a thread that answers; what it needs is some 20 kB |
//! | `SILENCES` | 3 | | longest silences after which Home Assistant takes a channel for gone: two may be lost |
//! | `KEEP_ALIVE_S` | 5 | s | a dead network shows within twice that (MQTT 3.1.1, 3.1.2.10) |
//! | `BROKER_PATIENCE_S` | 5 | s | to connect, and to hand something to the network |
//! | `BROKER_RETRY_AFTER` | 2 | s | from one attempt to reach the broker to the next: a crowd of boards does not storm it |
//! | `BROKER_QUEUE` | 64 | messages | that wait for the network: the introduction and one reading of many channels |
//! | `SEND_BYTES` | 16 384 | bytes | that wait in the kernel: some 50 readings |
//! | `PACKET_BYTES` | 262 144 | bytes | of a message: the announcement of some 150 channels |
//! | `BROKER_GOODBYE` | 1 | s | for the last word to get out |
//! | `TAKEOVER` | 3 | s | a connection that ends sooner was not wanted |
//! | `MOST_ANNOUNCED` | 256 | channels | that Home Assistant may still have: those of many reloads, and few enough to be told at once |
//! | `PAGES` | 32 | pages | that listen at a time: a family's, not a crowd's |
//! | `PAGE_EVENTS` | 256 | events | that wait for a slow page: some seconds |
//! | `STILL_THERE` | 10 | s | of silence after which a page is looked for |
//! | `IIO_CLIENTS` | 32 | | at a time; an open buffer takes a connection of its own |
//! | `IIO_IDLE` | 10 | s | of silence after which a client gives its place to another one, where all are taken: longer than a program pauses that looks at values, and libiio keeps its context for as long as it likes where there is room |
//! | `IIO_READINGS` | 4096 | readings | that wait for a slow buffer: some seconds of the fastest cycle |
//! | `IIO_COMMAND_BYTES` | 1024 | bytes | of a command; the longest has some 100 |
//! | `IIO_SILENCE` | 4 | s | without a row after which a client is told so: libiio waits 5 s by itself |
//! | `ACCEPT_PAUSE` | 0.1 | s | when the process is out of descriptors or threads |

use std::time::Duration;

pub const LOOK_AROUND: Duration = Duration::from_millis(100);
pub const ANSWER: Duration = Duration::from_secs(2);
pub const RETRY_AFTER: Duration = Duration::from_millis(500);
pub const STATS_EVERY: Duration = Duration::from_secs(1);
pub const MAX_HZ: f64 = 20.0;
pub const PAGE_WAITING: usize = 64;
pub const PAGE_PATIENCE: Duration = Duration::from_secs(5);
pub const REQUEST_BYTES: usize = 8192;
pub const STACK_BYTES: usize = 128 * 1024;
pub const ACCEPT_PAUSE: Duration = Duration::from_millis(100);
pub const SILENCES: u32 = 3;
pub const KEEP_ALIVE_S: u16 = 5;
pub const BROKER_PATIENCE_S: u64 = 5;
pub const BROKER_RETRY_AFTER: Duration = Duration::from_secs(2);
pub const BROKER_QUEUE: usize = 64;
pub const SEND_BYTES: u32 = 16 * 1024;
pub const PACKET_BYTES: usize = 256 * 1024;
pub const MOST_ANNOUNCED: usize = 256;
pub const BROKER_GOODBYE: Duration = Duration::from_secs(1);
pub const TAKEOVER: Duration = Duration::from_secs(3);
pub const PAGES: usize = 32;
pub const PAGE_EVENTS: usize = 256;
pub const STILL_THERE: Duration = Duration::from_secs(10);
pub const IIO_CLIENTS: usize = 32;
pub const IIO_IDLE: Duration = Duration::from_secs(10);
pub const IIO_READINGS: usize = 4096;
pub const IIO_COMMAND_BYTES: u64 = 1024;
pub const IIO_SILENCE: Duration = Duration::from_secs(4);
