//! `[realtime]`: numbers that no kernel knows.

use super::Findings;
use crate::pins::realtime::Wishes;

/// The priorities of SCHED_FIFO, sched(7).
const PRIORITIES: std::ops::RangeInclusive<u8> = 1..=99;
/// As many as the kernel's set of processors holds here, CPU_SET(3).
const PROCESSORS: usize = nix::sched::CpuSet::count();

pub fn check(wishes: &Wishes, findings: &mut Findings) {
    if let Some(priority) = wishes.fifo_priority.filter(|priority| !PRIORITIES.contains(priority)) {
        findings.error(
            "realtime.priority",
            format!("{priority} is not between 1 and 99"),
            "50, or without it: the usual scheduling",
        );
    }
    if let Some(cpu) = wishes.cpu.filter(|cpu| *cpu >= PROCESSORS) {
        findings.error(
            "realtime.cpu",
            format!("there is no processor {cpu}"),
            "3, the last of four, or without it: any processor",
        );
    }
}
