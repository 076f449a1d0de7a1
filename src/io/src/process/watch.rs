//! Death of a tool when robovec dies.
//!
//! A tool runs in its own process group, so that all of it can be killed;
//! therefore the terminal's interrupt, which is sent to robovec's group, does
//! not reach it. A shell beside it waits for the end of a pipe that only
//! robovec holds open. The system closes the pipe when robovec ends without a
//! word, and the shell kills the group; a line through the pipe sends it home.

use std::io::Write;
use std::process::{Child, Command, Stdio};

/// Kills the group that its argument names, when its input ends without a
/// line.
const SCRIPT: &str = "read -r line || kill -s KILL -- \"-$1\" 2>/dev/null";

/// A watcher, which is sent home when this value goes.
pub(super) struct ProcessWatch(Child);

impl ProcessWatch {
    /// A watcher of a group of processes; `None` where there is no shell or
    /// no group.
    pub(super) fn over(group: u32) -> Option<ProcessWatch> {
        if cfg!(not(unix)) {
            return None;
        }
        let mut command = Command::new("sh");
        command
            .args(["-c", SCRIPT, "sh", &group.to_string()])
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::null());
        super::own_group(&mut command);
        command.spawn().ok().map(ProcessWatch)
    }
}

impl Drop for ProcessWatch {
    fn drop(&mut self) {
        if let Some(mut pipe) = self.0.stdin.take() {
            // A watcher that is gone needs no word.
            let _ = pipe.write_all(b"done\n");
        }
        let _ = self.0.wait();
    }
}
