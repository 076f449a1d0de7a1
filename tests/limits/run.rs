//! Running a program within bounds of time and memory.

use nix::sys::resource::{UsageWho, getrusage};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Kilobytes of address space that a program gets.
const MEMORY: u32 = 2_000_000;

/// Seconds on the clock after which a program is stopped that does not use
/// its processor.
const PATIENCE: Duration = Duration::from_secs(400);

/// A program with its arguments.
#[derive(Clone, Debug)]
pub(crate) struct Invocation {
    pub(crate) program: &'static str,
    pub(crate) arguments: Vec<String>,
}

/// End of a run.
#[derive(Debug)]
pub(crate) struct Ending {
    /// The exit code, if the process was not killed.
    pub(crate) code: Option<i32>,
    /// Output, its beginning and end.
    pub(crate) told: String,
    /// Seconds of processors, programs it started included.
    pub(crate) seconds: f64,
    /// True when it was stopped after the time.
    pub(crate) late: bool,
}

impl Invocation {
    /// For people.
    pub(crate) fn line(&self) -> String {
        format!("{} {}", self.program, self.arguments.join(" "))
    }

    /// Runs it in a folder with 2 GB, and stops it after this number of seconds
    /// of processor time: other work on the computer does not count.
    pub(crate) fn run(&self, folder: &Path, seconds: u64) -> Ending {
        let program = match self.program {
            "robovec" => env!("CARGO_BIN_EXE_robovec"),
            _ => env!("CARGO_BIN_EXE_robovec-opt"),
        };
        let errors = folder.join("stderr");
        let open = || std::fs::File::create(&errors).expect("a writable folder");
        let start = processor_seconds();
        let mut child = Command::new("sh")
            .args([
                "-c",
                &format!("ulimit -v {MEMORY}; ulimit -t {seconds}; exec \"$@\""),
                "sh",
                program,
            ])
            .args(&self.arguments)
            .current_dir(folder)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(open())
            .spawn()
            .expect("the shell starts");
        let late = !ended(&mut child, PATIENCE);
        if late {
            child.kill().expect("it runs");
        }
        let status = child.wait().expect("it was started");
        let told = std::fs::read(&errors).unwrap_or_default();
        Ending {
            code: status.code(),
            told: String::from_utf8_lossy(&told).into_owned(),
            seconds: processor_seconds() - start,
            late,
        }
    }
}

/// Seconds of processors that all children took so far, and theirs.
fn processor_seconds() -> f64 {
    let usage = getrusage(UsageWho::RUSAGE_CHILDREN).expect("it can be asked");
    let seconds =
        |time: nix::sys::time::TimeVal| time.tv_sec() as f64 + time.tv_usec() as f64 * 1e-6;
    seconds(usage.user_time()) + seconds(usage.system_time())
}

/// Waits; false when the time is over.
fn ended(child: &mut Child, time: Duration) -> bool {
    let start = Instant::now();
    while start.elapsed() < time {
        match child.try_wait() {
            Ok(None) => std::thread::sleep(Duration::from_millis(4)),
            Ok(Some(_)) | Err(_) => return true,
        }
    }
    false
}

impl Ending {
    /// Fault that must never happen, if it happened.
    pub(crate) fn fault(&self) -> Option<&'static str> {
        if self.late {
            return Some("it did not end in time");
        }
        if self.told.contains("panicked") {
            return Some("it panicked");
        }
        if self.told.contains("memory allocation") {
            return Some("it had not enough memory");
        }
        match self.code {
            None => Some("it was killed by a signal, perhaps after its time"),
            Some(0..=2) => None,
            Some(_) => Some("its exit code is strange"),
        }
    }
}
