//! What bounds the server, and who gets in.

use crate::stream::limits::serving::{
    CLIENTS, CLIENTS_KEPT, CLIENTS_OF_A_USER, OTHER_DESCRIPTORS, QUEUE_LINES, SEND_BUFFER_BYTES,
};
use nix::sys::resource::{Resource, getrlimit, rlim_t, setrlimit};
use nix::sys::socket::{self, sockopt};
use nix::unistd::Uid;
use std::os::unix::net::UnixStream;

/// What bounds the server.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Clients at a time; the next one is told "busy" and closed.
    pub clients: usize,
    /// Of these, only for root and the daemon's own user: nobody else shuts them out.
    pub kept: usize,
    /// Clients of one other user at a time.
    pub of_a_user: usize,
    /// Lines that wait for a client that reads slowly.
    pub queue_lines: usize,
    /// `SO_SNDBUF` of each client, bytes; the kernel takes twice that for a client that does not read (and no
    /// line that is longer than that in one piece).
    pub send_buffer_bytes: usize,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits {
            clients: CLIENTS,
            kept: CLIENTS_KEPT,
            of_a_user: CLIENTS_OF_A_USER,
            queue_lines: QUEUE_LINES,
            send_buffer_bytes: SEND_BUFFER_BYTES,
        }
    }
}

impl Limits {
    /// The default, with no more clients than this process has descriptors for, of which it takes as many as it may: a
    /// client that cannot even be accepted waits without a word, root as well.
    pub fn of_this_process() -> Limits {
        // What the limit is a number of is another type on 32 bits.
        let wanted = (CLIENTS + OTHER_DESCRIPTORS) as rlim_t;
        let allowed = getrlimit(Resource::RLIMIT_NOFILE).map_or(wanted, |(soft, hard)| {
            let raised = wanted.min(hard);
            let is_raised = soft < raised && setrlimit(Resource::RLIMIT_NOFILE, raised, hard).is_ok();
            if is_raised { raised } else { soft }
        });
        Limits::with_descriptors(usize::try_from(allowed).unwrap_or(usize::MAX))
    }

    fn with_descriptors(allowed: usize) -> Limits {
        let clients = CLIENTS.min(allowed.saturating_sub(OTHER_DESCRIPTORS)).max(1);
        let kept = CLIENTS_KEPT.min(clients / 2);
        Limits { clients, kept, of_a_user: (clients - kept).div_ceil(2), ..Limits::default() }
    }

    /// Whether one more client of this user is admitted, beside `clients` of which `of_user` are its own; or what it is
    /// told.
    pub(super) fn admit(&self, user: User, clients: usize, of_user: usize) -> Result<(), String> {
        if clients >= self.clients || (!user.is_privileged && clients + self.kept >= self.clients) {
            return Err(format!("all {} connections are in use: try again later", self.clients));
        }
        if !user.is_privileged && of_user >= self.of_a_user {
            return Err(format!("{of_user} connections are yours, and no user has more: close some"));
        }
        Ok(())
    }
}

/// Who is at the other end of a connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct User {
    /// `None`: the kernel does not say.
    id: Option<Uid>,
    /// Root, or the user that we run as.
    is_privileged: bool,
}

impl User {
    pub fn of(socket: &UnixStream) -> User {
        let credentials = socket::getsockopt(socket, sockopt::PeerCredentials);
        let id = credentials.ok().map(|credentials| Uid::from_raw(credentials.uid()));
        User { id, is_privileged: id.is_some_and(|id| id.is_root() || id == Uid::effective()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lets users, by number, in by turns until nobody gets in any more, root last.
    fn filled(limits: Limits, users: u32) -> (Vec<usize>, usize) {
        let mut clients = vec![0; users as usize];
        let user = |id: usize| User { id: Some(Uid::from_raw(1000 + id as u32)), is_privileged: false };
        let mut comes = true;
        while std::mem::take(&mut comes) {
            for id in 0..clients.len() {
                if limits.admit(user(id), clients.iter().sum(), clients[id]).is_ok() {
                    clients[id] += 1;
                    comes = true;
                }
            }
        }
        let root = User { id: Some(Uid::from_raw(0)), is_privileged: true };
        let others: usize = clients.iter().sum();
        let of_root = (0..).take_while(|&of_root| limits.admit(root, others + of_root, of_root).is_ok());
        (clients.clone(), of_root.count())
    }

    #[test]
    fn no_user_shuts_out_another_and_nobody_root() {
        assert_eq!(filled(Limits::default(), 1), (vec![504], 520));
        assert_eq!(filled(Limits::default(), 2), (vec![504, 504], 16));
        assert_eq!(filled(Limits::default(), 3), (vec![336; 3], 16));
    }

    #[test]
    fn few_descriptors_are_few_clients_not_silence() {
        for allowed in [0, 1, 64, 65, 66, 100, 1024, 1088, 1_000_000] {
            let limits = Limits::with_descriptors(allowed);
            assert!((1..=CLIENTS).contains(&limits.clients) && limits.of_a_user > 0, "{allowed}: {limits:?}");
            assert!(allowed <= 65 || limits.clients + OTHER_DESCRIPTORS <= allowed, "{allowed}: {limits:?}");
            assert!(allowed < 66 || filled(limits, 2).1 > 0, "{allowed}: {limits:?}");
        }
        assert_eq!(Limits::with_descriptors(2048), Limits::default());
    }
}
