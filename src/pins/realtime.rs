//! The rights that make waiting precise: scheduling, memory, processor, wake-up.
//!
//! Each is optional and each says what became of it; measuring works without any, only with more jitter. Everything
//! here is for the calling thread, but memory and the wake-up latency, which are for the process and the machine.
#![allow(unsafe_code)] // sched_setscheduler, which nix does not wrap; the only unsafe code of the project.

use nix::errno::Errno;
use nix::sched::{CpuSet, sched_setaffinity};
use nix::sys::mman::{MlockAllFlags, mlockall};
use nix::sys::prctl::set_timerslack;
use nix::sys::resource::{RLIM_INFINITY, Resource, getrlimit, rlim_t};
use nix::unistd::Pid;
use serde::Deserialize;
use std::fmt;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};

/// Where the kernel takes bounds of the wake-up latency (Documentation/power/pm_qos_interface.rst).
const CPU_DMA_LATENCY: &str = "/dev/cpu_dma_latency";
/// The calling thread, in scheduler calls.
const THIS_THREAD: Pid = Pid::from_raw(0);

/// What to ask the kernel for: `[realtime]` of the configuration. Default: nothing.
#[derive(Debug, Clone, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct Wishes {
    /// SCHED_FIFO with this priority, 1 to 99.
    #[serde(rename = "priority")]
    pub fifo_priority: Option<u8>,
    /// All memory, present and future, locked into RAM (mlockall).
    pub lock_memory: bool,
    /// The one processor to run on, counted from 0.
    pub cpu: Option<usize>,
    /// No idle state that takes time to leave: 0 us in /dev/cpu_dma_latency for as long as [`Realtime`] lives. Costs
    /// power while held.
    #[serde(rename = "dma-latency")]
    pub no_deep_idle: bool,
}

/// What became of one wish.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Right {
    /// It was not wished for.
    NotAsked,
    /// It holds.
    Granted,
    /// It does not, and why.
    Denied(String),
}

impl Right {
    fn of(asked: Option<Result<(), String>>) -> Right {
        match asked {
            None => Right::NotAsked,
            Some(Ok(())) => Right::Granted,
            Some(Err(why)) => Right::Denied(why),
        }
    }
}

impl fmt::Display for Right {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Right::NotAsked => f.write_str("not asked for"),
            Right::Granted => f.write_str("granted"),
            Right::Denied(why) => write!(f, "denied: {why}"),
        }
    }
}

/// Each right by its key in the configuration.
pub type Rights = [(&'static str, Right); 4];

/// What was granted; lasts for the life of the thread, the wake-up latency for the life of this value.
#[derive(Debug)]
pub struct Realtime {
    /// For the log and for reports.
    pub rights: Rights,
    _latency_bound: Option<File>,
}

impl Realtime {
    /// Asks for all that is wished, for the calling thread. Never fails: see the rights. The timer slack (50 us for
    /// threads without real-time scheduling, prctl(2)) is always taken to 1 ns, for which no right is needed.
    pub fn request(wishes: &Wishes) -> Realtime {
        let _ = set_timerslack(1);
        let bound = wishes.no_deep_idle.then(hold_latency_at_zero);
        let idle = bound.as_ref().map(|bound| bound.as_ref().map(drop).map_err(latency_refused));
        Realtime {
            rights: [
                ("priority", Right::of(wishes.fifo_priority.map(set_fifo))),
                ("lock-memory", Right::of(wishes.lock_memory.then(lock_memory))),
                ("cpu", Right::of(wishes.cpu.map(pin))),
                ("dma-latency", Right::of(idle)),
            ],
            _latency_bound: bound.and_then(Result::ok),
        }
    }
}

fn set_fifo(priority: u8) -> Result<(), String> {
    let parameters = libc::sched_param { sched_priority: priority.into() };
    // SAFETY: the kernel reads `parameters`, which outlives the call, and keeps no reference to it.
    let answer = unsafe { libc::sched_setscheduler(THIS_THREAD.as_raw(), libc::SCHED_FIFO, &parameters) };
    Errno::result(answer).map(drop).map_err(|errno| fifo_refused(errno, priority))
}

fn fifo_refused(errno: Errno, priority: u8) -> String {
    match errno {
        Errno::EPERM => format!("{errno}; needs LimitRTPRIO={priority} in the unit, or CAP_SYS_NICE"),
        Errno::EINVAL => format!("{errno}; priority {priority} is not between 1 and 99"),
        other => other.to_string(),
    }
}

/// With MCL_FUTURE and a limit, a later allocation would fail and end the process: locked only without a limit.
fn lock_memory() -> Result<(), String> {
    let (limit, _) = getrlimit(Resource::RLIMIT_MEMLOCK).map_err(|errno| errno.to_string())?;
    may_lock(limit, nix::unistd::geteuid().is_root())?;
    mlockall(MlockAllFlags::MCL_CURRENT | MlockAllFlags::MCL_FUTURE)
        .map_err(|errno| format!("{errno}; needs LimitMEMLOCK=infinity in the unit, or CAP_IPC_LOCK"))
}

fn may_lock(limit_bytes: rlim_t, root: bool) -> Result<(), String> {
    if root || limit_bytes == RLIM_INFINITY {
        return Ok(());
    }
    Err(format!("only {} KiB may be locked; needs LimitMEMLOCK=infinity in the unit", limit_bytes / 1024))
}

fn pin(cpu: usize) -> Result<(), String> {
    let mut only = CpuSet::new();
    only.set(cpu).and_then(|()| sched_setaffinity(THIS_THREAD, &only)).map_err(|errno| {
        format!("{errno}; processor {cpu} does not exist here or is not allowed to this service")
    })
}

fn hold_latency_at_zero() -> io::Result<File> {
    let mut file = OpenOptions::new().write(true).open(CPU_DMA_LATENCY)?;
    file.write_all(&0_i32.to_ne_bytes())?;
    Ok(file)
}

fn latency_refused(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => {
            format!("the kernel has no {CPU_DMA_LATENCY} (CONFIG_PM or CONFIG_CPU_IDLE)")
        }
        io::ErrorKind::PermissionDenied => {
            let how = "DeviceAllow= of cermd.service and the udev rule let the user cermd in";
            format!("{error}; {CPU_DMA_LATENCY} is root's: {how}")
        }
        _ => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_asked_nothing_changed() {
        let realtime = Realtime::request(&Wishes::default());
        assert!(realtime.rights.iter().all(|(_, right)| *right == Right::NotAsked));
    }

    #[test]
    fn a_refusal_says_what_is_needed() {
        assert!(fifo_refused(Errno::EPERM, 50).contains("LimitRTPRIO=50"));
        assert!(fifo_refused(Errno::EINVAL, 0).contains("between 1 and 99"));
        assert!(latency_refused(&io::ErrorKind::PermissionDenied.into()).contains("DeviceAllow"));
        assert!(latency_refused(&io::ErrorKind::NotFound.into()).contains("no /dev/cpu_dma_latency"));
    }

    #[test]
    fn memory_is_locked_only_without_a_limit() {
        assert_eq!(
            may_lock(8 << 20, false).unwrap_err().split(';').next(),
            Some("only 8192 KiB may be locked")
        );
        assert!(may_lock(8 << 20, true).is_ok());
        assert!(may_lock(RLIM_INFINITY, false).is_ok());
    }

    #[test]
    fn impossible_wishes_are_denied_by_the_kernel() {
        // In a thread of its own: what is granted stays with the thread.
        let realtime = std::thread::spawn(|| {
            Realtime::request(&Wishes { fifo_priority: Some(100), cpu: Some(1023), ..Wishes::default() })
        });
        let realtime = realtime.join().unwrap();
        let [(_, scheduling), (_, memory), (_, affinity), _] = realtime.rights;
        assert!(matches!(scheduling, Right::Denied(why) if why.contains("between 1 and 99")));
        assert!(matches!(affinity, Right::Denied(why) if why.contains("processor 1023")));
        assert_eq!(memory, Right::NotAsked);
    }

    #[test]
    fn a_thread_can_be_pinned_to_a_processor_it_has() {
        let pinned = std::thread::spawn(|| {
            let allowed = nix::sched::sched_getaffinity(THIS_THREAD).unwrap();
            let cpu = (0..CpuSet::count()).find(|cpu| allowed.is_set(*cpu).unwrap()).unwrap();
            let realtime = Realtime::request(&Wishes { cpu: Some(cpu), ..Wishes::default() });
            (realtime.rights[2].clone(), cpu, nix::sched::sched_getaffinity(THIS_THREAD).unwrap())
        });
        let (right, cpu, now) = pinned.join().unwrap();
        assert_eq!(right, ("cpu", Right::Granted));
        assert!((0..CpuSet::count()).all(|other| now.is_set(other).unwrap() == (other == cpu)));
    }
}
