//! Where programs that run on their own say what happens.

use nix::sys::stat::fstat;
use std::io::Write;
use std::os::fd::{AsFd, BorrowedFd};

/// To standard error; into the journal, each line begins with its syslog priority (sd-daemon(3)) and has no time, which
/// the journal adds. RUST_LOG chooses what is said.
pub fn start() {
    let mut logger = env_logger::Builder::from_env(env_logger::Env::default().default_filter_or("info"));
    if is_journal(std::io::stderr().as_fd()) {
        logger.format(|out, record| {
            let priority = match record.level() {
                log::Level::Error => 3,
                log::Level::Warn => 4,
                log::Level::Info => 6,
                log::Level::Debug | log::Level::Trace => 7,
            };
            // Every line of its own, or the journal takes the rest for another priority.
            record.args().to_string().lines().try_for_each(|line| writeln!(out, "<{priority}>{line}"))
        });
    }
    logger.init();
}

/// Whether a descriptor is the stream to the journal: the variable is inherited by programs whose output was
/// redirected, so it names the stream by device and inode (systemd.exec(5), JOURNAL_STREAM).
fn is_journal(output: BorrowedFd<'_>) -> bool {
    let Ok(stream) = std::env::var("JOURNAL_STREAM") else { return false };
    fstat(output).is_ok_and(|found| stream == format!("{}:{}", found.st_dev, found.st_ino))
}
