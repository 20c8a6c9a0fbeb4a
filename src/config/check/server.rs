//! `[server]`: can the socket exist, and who may write to it.

use super::Findings;
use crate::config::Config;
use std::os::unix::ffi::OsStrExt;

/// `sun_path` holds 108 bytes with the final zero (include/uapi/linux/un.h).
const LONGEST_SOCKET: usize = 107;

pub fn check(config: &Config, findings: &mut Findings) {
    let length = config.server.socket.as_os_str().as_bytes().len();
    if length == 0 || length > LONGEST_SOCKET {
        findings.error(
            "server.socket",
            format!("the path has {length} bytes, and 1 to {LONGEST_SOCKET} are possible"),
            "\"/run/cermd/cermd.sock\"",
        );
    }
    let mode = config.server.mode.0;
    if mode & 0o002 != 0 {
        findings.warning(
            "server.mode",
            format!("\"{mode:04o}\" lets everybody write to the socket"),
            "\"0660\"",
        );
    }
    if mode & 0o200 == 0 {
        findings.warning("server.mode", format!("\"{mode:04o}\" keeps even the owner out"), "\"0660\"");
    }
}
