//! The socket that clients connect to: handed over by systemd, or bound by ourselves. Never two daemons on one path, never
//! somebody else's file deleted.

use super::lock::{Lock, LockError};
use nix::errno::Errno;
use nix::fcntl::{FcntlArg, FdFlag, fcntl};
use nix::sys::socket::{self, AddressFamily, Backlog, SockFlag, SockType, UnixAddr, sockopt};
use nix::sys::stat::{Mode, fchmod, umask};
use std::fmt::Display;
use std::fs::{self, Metadata};
use std::io;
use std::os::fd::{AsFd, AsRawFd, BorrowedFd, OwnedFd};
use std::os::unix::fs::{FileTypeExt, MetadataExt};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Why there is no socket, and what to do.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct ListenError(String);

/// A listening unix stream socket. Dropping it removes the file that it has made, if it is still that file.
#[derive(Debug)]
pub struct Listener {
    socket: UnixListener,
    own_file: Option<OwnFile>,
}

#[derive(Debug)]
struct OwnFile {
    path: PathBuf,
    inode: (u64, u64),
}

/// What a file is known by, whatever its name: its device and its number there.
fn inode(metadata: &Metadata) -> (u64, u64) {
    (metadata.dev(), metadata.ino())
}

impl Listener {
    /// The socket that systemd passes to a socket-activated service, if there is one.
    ///
    /// To be called once, at the start of the process: it takes the descriptors into its possession.
    ///
    /// # Errors
    /// Several descriptors, or one that is not a listening unix stream socket.
    pub fn from_systemd() -> Result<Option<Listener>, ListenError> {
        let mut passed =
            sd_listen_fds::get().map_err(|error| not_ours(format!("something else ({error})")))?;
        if passed.len() > 1 {
            return Err(not_ours(format!("{} sockets", passed.len())));
        }
        let Some((_, fd)) = passed.pop() else { return Ok(None) };
        let fd = OwnedFd::from(UnixListener::from(fd));
        Self::adopt(fd).map(Some)
    }

    fn adopt(fd: OwnedFd) -> Result<Listener, ListenError> {
        let is_stream = socket::getsockopt(&fd, sockopt::SockType) == Ok(SockType::Stream);
        let is_listening = socket::getsockopt(&fd, sockopt::AcceptConn) == Ok(true);
        let is_unix = socket::getsockname::<UnixAddr>(fd.as_raw_fd()).is_ok();
        if !(is_stream && is_listening && is_unix) {
            return Err(not_ours("a descriptor that is not a listening unix stream socket"));
        }
        let unusable = |error| not_ours(format!("a descriptor that cannot be used ({error})"));
        fcntl(&fd, FcntlArg::F_SETFD(FdFlag::FD_CLOEXEC)).map_err(|errno| unusable(errno.into()))?;
        let socket = UnixListener::from(fd);
        socket.set_nonblocking(true).map_err(unusable)?;
        Ok(Listener { socket, own_file: None })
    }

    /// Binds a socket at `path` with the permission bits `mode`.
    ///
    /// A socket file that nobody serves any more (its daemon was killed) is replaced.
    ///
    /// # Errors
    /// What is in the way. No file is removed then that was there before.
    pub fn bind(path: &Path, mode: u32) -> Result<Listener, ListenError> {
        // The kernel tells the shorter name of the lock file too late.
        UnixAddr::new(path).map_err(|errno| failed("bind", path, errno))?;
        // From here to listen() only one daemon at a time: else two could find the same stale file, and the
        // second would remove the fresh socket of the first.
        let mut lock_path = path.as_os_str().to_owned();
        lock_path.push(".lock");
        let lock_path = PathBuf::from(lock_path);
        let _lock = Lock::take(&lock_path).map_err(|error| no_lock(&lock_path, error))?;
        remove_stale(path)?;
        bind_and_listen(path, mode)
    }

    pub(super) fn accept(&self) -> io::Result<UnixStream> {
        self.socket.accept().map(|(stream, _)| stream)
    }
}

impl AsFd for Listener {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.socket.as_fd()
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        let Some(own) = &self.own_file else { return };
        if fs::symlink_metadata(&own.path).is_ok_and(|now| inode(&now) == own.inode) {
            if let Err(error) = fs::remove_file(&own.path) {
                log::warn!("remove {}: {error}", own.path.display());
            }
        }
    }
}

/// What systemd passed is not one listening unix stream socket.
fn not_ours(passed: impl Display) -> ListenError {
    ListenError(format!("systemd passed {passed}: cermd takes one ListenStream= with a path"))
}

fn failed(call: &str, path: &Path, source: impl Into<io::Error>) -> ListenError {
    let source = source.into();
    let hint = match source.raw_os_error().map(Errno::from_raw) {
        Some(Errno::EACCES | Errno::EPERM) => {
            ": run cermd as a user that may write there, or give it another [server] socket"
        }
        Some(Errno::EROFS) => ": the unit needs ReadWritePaths= or RuntimeDirectory= for it",
        Some(Errno::ENAMETOOLONG) => ": a socket path has at most 107 bytes",
        Some(Errno::ENOENT) => {
            ": create its directory (RuntimeDirectory= in a systemd unit does), or give it another [server] socket"
        }
        _ => "",
    };
    ListenError(format!("{call} {}: {source}{hint}", path.display()))
}

fn no_lock(path: &Path, error: LockError) -> ListenError {
    match error {
        LockError::Failed(error) => failed("open", path, error),
        LockError::Held => {
            let why = "another cermd is just now binding a socket there";
            ListenError(format!("{}: {why}; stop one of the two", path.display()))
        }
        LockError::NotOurs => {
            let why = "not a file of this user alone";
            ListenError(format!("{}: {why}: remove it, or choose another [server] socket", path.display()))
        }
    }
}

/// A stream socket that never waits, and the address of the path.
fn unix_socket(path: &Path) -> Result<(OwnedFd, UnixAddr), ListenError> {
    let flags = SockFlag::SOCK_CLOEXEC | SockFlag::SOCK_NONBLOCK;
    let socket = socket::socket(AddressFamily::Unix, SockType::Stream, flags, None)
        .map_err(|errno| failed("make a socket for", path, errno))?;
    let address = UnixAddr::new(path).map_err(|errno| failed("bind", path, errno))?;
    Ok((socket, address))
}

/// The umask is the process's, and only one thread at a time may change it and put it back.
static UMASK: Mutex<()> = Mutex::new(());

/// Makes the file, which has its mode from the first: a later chmod would follow a link that somebody has put in its place.
fn bind(socket: &OwnedFd, address: &UnixAddr, mode: u32) -> nix::Result<()> {
    // The new file gets the mode of the socket, less the umask, whose bits for the owner stay out of it: folders that other
    // threads make meanwhile are still their own.
    fchmod(socket, Mode::from_bits_truncate(mode))?;
    let _alone = UMASK.lock().unwrap_or_else(PoisonError::into_inner);
    let own = umask(Mode::from_bits_truncate(!mode & 0o077));
    let bound = socket::bind(socket.as_raw_fd(), address);
    umask(own);
    bound
}

fn bind_and_listen(path: &Path, mode: u32) -> Result<Listener, ListenError> {
    let (socket, address) = unix_socket(path)?;
    bind(&socket, &address, mode).map_err(|errno| failed("bind", path, errno))?;
    let metadata = fs::symlink_metadata(path).map_err(|source| failed("stat", path, source))?;
    let own_file = OwnFile { path: path.to_owned(), inode: inode(&metadata) };
    let listener = Listener { socket: UnixListener::from(socket), own_file: Some(own_file) };
    socket::listen(&listener.socket, Backlog::MAXCONN).map_err(|errno| failed("listen on", path, errno))?;
    Ok(listener)
}

/// Removes a socket file that nobody listens on.
fn remove_stale(path: &Path) -> Result<(), ListenError> {
    match fs::symlink_metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(failed("stat", path, error)),
        Ok(metadata) if !metadata.file_type().is_socket() => {
            return Err(ListenError(format!(
                "{} exists and is not a socket: remove it, or choose another path in [server] socket",
                path.display()
            )));
        }
        Ok(_) => {}
    }
    // Without blocking: the queue of a daemon that hangs may be full.
    let (probe, address) = unix_socket(path)?;
    let served = |owner: &str| {
        let stop = "stop that one first, or choose another path in [server] socket";
        Err(ListenError(format!("{} is already served by {owner}: {stop}", path.display())))
    };
    match socket::connect(probe.as_raw_fd(), &address) {
        Ok(()) => served(&owner_of(&probe)),
        Err(Errno::EAGAIN) => served("a process that does not answer (its queue is full)"),
        Err(Errno::ECONNREFUSED) => {
            log::info!("replacing {}, which nobody serves any more", path.display());
            fs::remove_file(path).map_err(|source| failed("remove the stale", path, source))
        }
        Err(Errno::ENOENT) => Ok(()),
        Err(errno) => Err(failed("connect to", path, errno)),
    }
}

/// Who called listen() at the other end, as "pid N (name)".
fn owner_of(connected: &OwnedFd) -> String {
    let Ok(credentials) = socket::getsockopt(connected, sockopt::PeerCredentials) else {
        return "an unknown process".to_owned();
    };
    let pid = credentials.pid();
    match fs::read_to_string(format!("/proc/{pid}/comm")) {
        Ok(name) => format!("pid {pid} ({})", name.trim_end()),
        Err(_) => format!("pid {pid}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn socket_path() -> (tempfile::TempDir, PathBuf) {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("s");
        (directory, path)
    }

    #[test]
    fn the_mode_is_as_asked_and_the_file_goes_with_the_listener() {
        let (_directory, path) = socket_path();
        for mode in [0o660, 0o600, 0o666] {
            let listener = Listener::bind(&path, mode).unwrap();
            assert_eq!(fs::metadata(&path).unwrap().mode() & 0o7777, mode);
            UnixStream::connect(&path).unwrap();
            drop(listener);
            assert!(!path.exists());
        }
    }

    #[test]
    fn a_live_socket_is_refused_with_its_owner() {
        let (_directory, path) = socket_path();
        let first = Listener::bind(&path, 0o600).unwrap();
        let refusal = Listener::bind(&path, 0o600).unwrap_err().to_string();
        assert!(refusal.contains(&format!("pid {} (", std::process::id())), "{refusal}");
        assert!(UnixStream::connect(&path).is_ok(), "the first goes on");
        drop(first);
        Listener::bind(&path, 0o600).unwrap();
    }

    #[test]
    fn a_stale_socket_is_replaced() {
        let (_directory, path) = socket_path();
        drop(UnixListener::bind(&path).unwrap()); // std leaves the file behind
        assert!(path.exists());
        let _listener = Listener::bind(&path, 0o600).unwrap();
        UnixStream::connect(&path).unwrap();
    }

    #[test]
    fn what_is_no_socket_is_left_alone() {
        let (directory, path) = socket_path();
        fs::write(&path, "precious").unwrap();
        let refused = |path: &Path| Listener::bind(path, 0o600).unwrap_err().to_string();
        assert!(refused(&path).contains("is not a socket: remove it"), "{}", refused(&path));
        assert_eq!(fs::read_to_string(&path).unwrap(), "precious");
        let link = directory.path().join("link");
        std::os::unix::fs::symlink(&path, &link).unwrap();
        assert!(refused(&link).contains("is not a socket: remove it"), "{}", refused(&link));
    }

    #[test]
    fn a_file_that_is_no_longer_ours_stays() {
        let (_directory, path) = socket_path();
        let listener = Listener::bind(&path, 0o600).unwrap();
        fs::rename(&path, path.with_extension("old")).unwrap();
        fs::write(&path, "of somebody else").unwrap();
        drop(listener);
        assert!(path.exists());
    }

    #[test]
    fn errors_say_what_to_do() {
        let (directory, path) = socket_path();
        let missing = Listener::bind(&directory.path().join("no/s"), 0o600).unwrap_err().to_string();
        assert!(missing.contains("no/s") && missing.contains("create its directory"), "{missing}");
        let long = Listener::bind(&directory.path().join("x".repeat(200)), 0o600).unwrap_err().to_string();
        assert!(long.contains("107 bytes"), "{long}");
        let lock_path = path.with_file_name("s.lock");
        let lock = Lock::take(&lock_path).unwrap();
        let contended = Listener::bind(&path, 0o600).unwrap_err().to_string();
        assert!(contended.contains("another cermd is just now"), "{contended}");
        drop(lock);
        fs::create_dir(&lock_path).unwrap();
        let blocked = Listener::bind(&path, 0o600).unwrap_err().to_string();
        assert!(blocked.contains("s.lock: not a file of this user alone: remove it"), "{blocked}");
    }

    /// Others can read the directory of the socket, and lock it.
    #[test]
    fn a_lock_of_somebody_else_on_the_directory_keeps_nobody_out() {
        use nix::fcntl::{Flock, FlockArg};
        let (directory, path) = socket_path();
        let opened = fs::File::open(directory.path()).unwrap();
        let _held = Flock::lock(opened, FlockArg::LockExclusive).unwrap();
        drop(Listener::bind(&path, 0o600).unwrap());
        let left = fs::read_dir(directory.path()).unwrap().count();
        assert_eq!(left, 0, "neither socket nor lock is left");
    }

    #[test]
    fn no_chmod_follows_the_bind() {
        use nix::sys::inotify::{AddWatchFlags, InitFlags, Inotify};
        let (directory, path) = socket_path();
        let watch = Inotify::init(InitFlags::IN_NONBLOCK).unwrap();
        let wanted = AddWatchFlags::IN_CREATE | AddWatchFlags::IN_ATTRIB;
        watch.add_watch(directory.path(), wanted).unwrap();
        let _listener = Listener::bind(&path, 0o620).unwrap();
        let seen = watch.read_events().unwrap();
        let of_socket: Vec<_> =
            seen.iter().filter(|event| event.name.as_deref() == path.file_name()).collect();
        assert!(of_socket.len() == 1 && of_socket[0].mask == AddWatchFlags::IN_CREATE, "{seen:?}");
        assert_eq!(fs::metadata(&path).unwrap().mode() & 0o7777, 0o620);
    }

    #[test]
    fn only_a_listening_unix_stream_is_adopted() {
        let (_directory, path) = socket_path();
        let adopted = Listener::adopt(OwnedFd::from(UnixListener::bind(&path).unwrap())).unwrap();
        assert_eq!(adopted.accept().unwrap_err().kind(), io::ErrorKind::WouldBlock);
        drop(adopted);
        assert!(path.exists(), "systemd's file is systemd's");
        let (stream, _other) = UnixStream::pair().unwrap();
        assert!(Listener::adopt(OwnedFd::from(stream)).is_err());
        let tcp = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        assert!(Listener::adopt(OwnedFd::from(tcp)).is_err());
        assert!(Listener::adopt(OwnedFd::from(fs::File::open("/dev/null").unwrap())).is_err());
    }
}
