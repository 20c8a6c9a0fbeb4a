//! What is wrong with a configuration that parses, and what to expect of one that is right. Everything here follows from
//! the configuration alone.

mod channels;
mod circuit;
mod gpio;
mod measure;
pub(crate) mod predict;
mod trigger;

use super::{Backend, Config, Findings, Server, limits};
use crate::pins::realtime::Wishes;
use std::os::unix::ffi::OsStrExt;

impl Config {
    /// Everything that is wrong or worth knowing; what is compared with predicted times comes last, and only
    /// when circuit and settings are right in themselves.
    pub fn check(&self) -> Findings {
        let mut findings = Findings::default();
        // The pins of a simulated circuit are those of its scene.
        let chip = self.gpio.chip.as_deref().filter(|_| self.gpio.backend != Backend::Mock);
        circuit::check(&self.circuit, chip.unwrap_or_default(), &mut findings);
        measure::check(self, &mut findings);
        let predictable = !findings.has_errors();
        if channels::number(&self.channels, &mut findings) {
            gpio::check(self, &mut findings);
            channels::check(&self.channels, &mut findings);
            trigger::check(self, &mut findings);
        }
        server(&self.server, &mut findings);
        realtime(&self.realtime, &mut findings);
        if predictable {
            predict::check(self, &mut findings);
        }
        findings
    }
}

/// Can the socket exist, and who may write to it?
fn server(server: &Server, findings: &mut Findings) {
    let length = server.socket.as_os_str().as_bytes().len();
    if length == 0 || length > limits::LONGEST_SOCKET {
        let reason = format!("the path has {length} bytes, and 1 to {} are possible", limits::LONGEST_SOCKET);
        findings.error("server.socket", reason, "\"/run/cermd/cermd.sock\"");
    }
    let mode = server.mode;
    for (is_odd, what) in [
        (mode & 0o002 != 0, "lets everybody write to the socket"),
        (mode & 0o200 == 0, "keeps even the owner out"),
    ] {
        if is_odd {
            findings.warning("server.mode", format!("\"{mode:04o}\" {what}"), "\"0660\"");
        }
    }
}

/// Numbers that no kernel knows.
fn realtime(wishes: &Wishes, findings: &mut Findings) {
    if let Some(priority) = wishes.fifo_priority.filter(|priority| !limits::PRIORITIES.contains(priority)) {
        let remedy = "40, or without it: the usual scheduling";
        findings.error("realtime.priority", format!("{priority} is not between 1 and 99"), remedy);
    } else if let Some(priority) = wishes.fifo_priority.filter(|priority| *priority >= limits::INTERRUPTS) {
        let reason =
            format!("{priority} is not below {}, that of the threads that bring edges", limits::INTERRUPTS);
        findings.warning("realtime.priority", format!("{reason}: waiting for one keeps it away"), "40");
    }
    if let Some(cpu) = wishes.cpu.filter(|cpu| *cpu >= limits::PROCESSORS) {
        let remedy = "3, the last of four, or without it: any processor";
        findings.error("realtime.cpu", format!("there is no processor {cpu}"), remedy);
    }
}

#[cfg(test)]
mod tests;
