//! External programs: compilers, simulators of hardware, yosys, Python, others.
//!
//! None of them is trusted to end or to limit its output. **Invariant.** A run
//! ends: after its time, or beyond the limit of its output, it is killed with
//! all processes that it started. On Unix it also ends when robovec does, which
//! a small watcher ([`ProcessWatch`]) waits for.

use std::ffi::{OsStr, OsString};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::OnceLock;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

/// Limits of time and output.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ProcessLimits {
    /// Time of a run by the clock on the wall.
    pub time: Duration,
    /// Bytes of the standard output, and of the standard error.
    pub bytes: usize,
}

impl ProcessLimits {
    /// Half an hour and 64 MiB: more than any tool needs that does its work.
    pub const USUAL: ProcessLimits = ProcessLimits {
        time: Duration::from_secs(1800),
        bytes: 64 << 20,
    };
}

static LIMITS: OnceLock<ProcessLimits> = OnceLock::new();

/// Sets the limits of all runs, at the program's start: the first value stays.
pub fn set_limits(limits: ProcessLimits) {
    let _ = LIMITS.set(limits);
}

/// Time between two looks at a program.
const PAUSE: Duration = Duration::from_millis(50);

/// Time for the end of the output after a program: children keep it open.
const GRACE: Duration = Duration::from_secs(2);

/// Reason why a program did not do its work, beside [`FinishedProcess`].
#[derive(Debug, thiserror::Error)]
pub enum ToolError {
    /// It cannot be started.
    #[error("'{program}' cannot be run: {error}")]
    Start {
        /// The program.
        program: String,
        /// The reason.
        error: io::Error,
    },
    /// It took too long.
    #[error("'{program}' was stopped: it ran longer than {seconds} s")]
    Time {
        /// The program.
        program: String,
        /// Its limit.
        seconds: u64,
    },
    /// Its output exceeded the limit.
    #[error("'{program}' was stopped: it printed more than {bytes} bytes")]
    Output {
        /// The program.
        program: String,
        /// Its limit.
        bytes: usize,
    },
}

/// A run that ended without being stopped.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct FinishedProcess {
    /// Exit status.
    pub status: ExitStatus,
    /// Text it printed to the standard output.
    pub output: Vec<u8>,
    /// And to the standard error.
    pub errors: Vec<u8>,
}

impl FinishedProcess {
    /// The standard output as text.
    pub fn text(&self) -> String {
        String::from_utf8_lossy(&self.output).into_owned()
    }

    /// The standard error as text.
    pub fn messages(&self) -> String {
        String::from_utf8_lossy(&self.errors).into_owned()
    }
}

/// A program with its arguments.
#[derive(Clone, Debug)]
pub struct ProgramCall {
    program: PathBuf,
    name: String,
    arguments: Vec<OsString>,
    variables: Vec<(OsString, OsString)>,
    folder: Option<PathBuf>,
    limits: ProcessLimits,
}

impl ProgramCall {
    /// A program by its name or path, without arguments.
    pub fn new(program: impl AsRef<Path>) -> ProgramCall {
        let program = program.as_ref().to_owned();
        ProgramCall {
            name: program.display().to_string(),
            program,
            arguments: Vec::new(),
            variables: Vec::new(),
            folder: None,
            limits: LIMITS.get().copied().unwrap_or(ProcessLimits::USUAL),
        }
    }

    /// A program requested its version.
    pub fn version(program: impl AsRef<Path>, argument: &str) -> ProgramCall {
        ProgramCall::new(program).arguments([argument])
    }

    /// The same under another name in messages: that of a shell's program.
    #[must_use]
    pub fn called(mut self, name: &str) -> ProgramCall {
        name.clone_into(&mut self.name);
        self
    }

    /// Adds arguments.
    #[must_use]
    pub fn arguments<T: AsRef<OsStr>>(
        mut self,
        arguments: impl IntoIterator<Item = T>,
    ) -> ProgramCall {
        let arguments = arguments.into_iter();
        self.arguments
            .extend(arguments.map(|argument| argument.as_ref().to_owned()));
        self
    }

    /// Sets a variable of its environment.
    #[must_use]
    pub fn variable(mut self, name: &str, value: impl AsRef<OsStr>) -> ProgramCall {
        self.variables
            .push((name.into(), value.as_ref().to_owned()));
        self
    }

    /// The working folder; a program whose path begins with `./` is in it.
    #[must_use]
    pub fn folder(mut self, folder: &Path) -> ProgramCall {
        if let Ok(own) = self.program.strip_prefix("./") {
            self.program = folder.join(own);
        }
        self.folder = Some(folder.to_owned());
        self
    }

    /// Other limits than the usual ones.
    #[must_use]
    pub fn limits(mut self, limits: ProcessLimits) -> ProgramCall {
        self.limits = limits;
        self
    }

    /// Runs it to its end, without input.
    ///
    /// # Errors
    ///
    /// Fails when it cannot be started or reaches a limit and is killed.
    pub fn run(&self) -> Result<FinishedProcess, ToolError> {
        let mut command = Command::new(&self.program);
        command
            .args(&self.arguments)
            .envs(self.variables.iter().map(|(name, value)| (name, value)))
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        if let Some(folder) = &self.folder {
            command.current_dir(folder);
        }
        own_group(&mut command);
        let start = |error| ToolError::Start {
            program: self.name.clone(),
            error,
        };
        let mut running = Running::new(command.spawn().map_err(start)?);
        self.follow(&mut running).map_err(start)?
    }

    /// Reads the output of a program until it ends.
    fn follow(&self, running: &mut Running) -> io::Result<Result<FinishedProcess, ToolError>> {
        let deadline = Instant::now() + self.limits.time;
        let (sender, receiver) = mpsc::channel();
        let child = &mut running.child;
        let streams: [Option<Box<dyn Read + Send>>; 2] = [
            child.stdout.take().map(|stream| Box::new(stream) as _),
            child.stderr.take().map(|stream| Box::new(stream) as _),
        ];
        for (index, stream) in streams.into_iter().enumerate() {
            let stream = stream.expect("the output was asked for as a pipe");
            let sender = sender.clone();
            let most = self.limits.bytes as u64 + 1;
            thread::spawn(move || {
                let mut bytes = Vec::new();
                // What cannot be read any more has ended.
                let _ = stream.take(most).read_to_end(&mut bytes);
                let _ = sender.send((index, bytes));
            });
        }
        let mut read: [Option<Vec<u8>>; 2] = [None, None];
        let mut ended: Option<(ExitStatus, Instant)> = None;
        loop {
            match receiver.recv_timeout(PAUSE) {
                Ok((_, bytes)) if bytes.len() > self.limits.bytes => {
                    running.kill();
                    return Ok(Err(ToolError::Output {
                        program: self.name.clone(),
                        bytes: self.limits.bytes,
                    }));
                }
                Ok((index, bytes)) => read[index] = Some(bytes),
                Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => {}
            }
            if ended.is_none() {
                let status = if read.iter().all(Option::is_some) {
                    running.wait_until(deadline)?
                } else {
                    running.child.try_wait()?
                };
                ended = status.map(|status| (status, Instant::now()));
            }
            if let (Some((status, _)), [Some(output), Some(errors)]) = (ended, &mut read) {
                running.is_done = true;
                return Ok(Ok(FinishedProcess {
                    status,
                    output: std::mem::take(output),
                    errors: std::mem::take(errors),
                }));
            }
            if ended.is_some_and(|(_, when)| when.elapsed() > GRACE) {
                running.kill();
            }
            if Instant::now() > deadline {
                running.kill();
                return Ok(Err(ToolError::Time {
                    program: self.name.clone(),
                    seconds: self.limits.time.as_secs(),
                }));
            }
        }
    }
}

/// Makes the program the first of a group of all processes that it starts.
#[cfg(unix)]
fn own_group(command: &mut Command) {
    use std::os::unix::process::CommandExt;
    command.process_group(0);
}

#[cfg(not(unix))]
fn own_group(_command: &mut Command) {}

/// A program that runs, and is killed when this value goes.
struct Running {
    child: Child,
    is_done: bool,
    _watch: Option<ProcessWatch>,
}

impl Running {
    fn new(child: Child) -> Running {
        Running {
            _watch: ProcessWatch::over(child.id()),
            child,
            is_done: false,
        }
    }

    /// Waits for the end of a program that has closed its output.
    fn wait_until(&mut self, deadline: Instant) -> io::Result<Option<ExitStatus>> {
        let mut pause = Duration::from_micros(100);
        loop {
            let status = self.child.try_wait()?;
            if status.is_some() || Instant::now() > deadline {
                return Ok(status);
            }
            thread::sleep(pause);
            pause = (pause * 2).min(PAUSE);
        }
    }

    /// Kills it and all that it started; it may be dead already.
    fn kill(&mut self) {
        #[cfg(unix)]
        {
            use nix::sys::signal::{Signal, killpg};
            use nix::unistd::Pid;
            if let Ok(group) = i32::try_from(self.child.id()) {
                let _ = killpg(Pid::from_raw(group), Signal::SIGKILL);
            }
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
        self.is_done = true;
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if !self.is_done {
            self.kill();
        }
    }
}

/// Kills the group that its argument names, if its input ends without a line.
const SCRIPT: &str = "read -r line || kill -s KILL -- \"-$1\" 2>/dev/null";

/// A shell beside a tool, which kills the tool when robovec dies.
///
/// A tool runs in its own process group, so that all of it can be killed;
/// therefore the terminal's interrupt, which is sent to robovec's group, does
/// not reach it. The shell waits for the end of a pipe that only robovec holds
/// open. The system closes the pipe when robovec ends without a word, and the
/// shell kills the group; a line through the pipe sends it home.
struct ProcessWatch(Child);

impl ProcessWatch {
    /// A watcher of a group of processes; `None` without shells or groups.
    fn over(group: u32) -> Option<ProcessWatch> {
        if cfg!(not(unix)) {
            return None;
        }
        let mut command = Command::new("sh");
        command
            .args(["-c", SCRIPT, "sh", &group.to_string()])
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::null());
        own_group(&mut command);
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

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    fn shell(script: &str) -> ProgramCall {
        ProgramCall::new("sh").arguments(["-c", script])
    }

    /// A limit that only a program reaches which never ends.
    fn short() -> ProcessLimits {
        ProcessLimits {
            time: Duration::from_millis(300),
            bytes: 1000,
        }
    }

    #[test]
    fn output_errors_and_status_are_told_apart() {
        let run = shell("echo out; echo err >&2; exit 3").run();
        let run = run.expect("it ends");
        assert_eq!(
            (run.text(), run.messages()),
            ("out\n".into(), "err\n".into())
        );
        assert_eq!(run.status.code(), Some(3));
        let run = ProgramCall::new("sh")
            .arguments(["-c", "echo $WORD; pwd"])
            .variable("WORD", "given")
            .folder(Path::new("/"))
            .run();
        assert_eq!(run.expect("it ends").text(), "given\n/\n");
    }

    #[test]
    fn a_program_that_is_not_there_is_named() {
        let error = ProgramCall::new("no-such-program-at-all").run();
        let message = error.expect_err("it is not there").to_string();
        assert!(message.starts_with("'no-such-program-at-all' cannot be run"));
    }

    #[test]
    fn what_never_ends_is_stopped() {
        for script in [
            "sleep 1000",
            "sleep 1000 & sleep 1000",
            "exec >&- 2>&-; sleep 1000",
        ] {
            let error = shell(script).limits(short()).run();
            assert!(matches!(error, Err(ToolError::Time { .. })), "{script}");
        }
    }

    #[test]
    fn what_prints_without_end_is_stopped() {
        let limits = ProcessLimits {
            time: Duration::from_secs(600),
            bytes: 1000,
        };
        for script in ["yes", "yes >&2", "head -c 1001 /dev/zero"] {
            let error = shell(script).limits(limits).run();
            assert!(matches!(error, Err(ToolError::Output { .. })), "{script}");
        }
        let run = shell("head -c 1000 /dev/zero").limits(limits).run();
        assert_eq!(run.expect("it is allowed").output.len(), 1000);
    }

    #[test]
    fn what_a_program_leaves_running_is_killed() {
        let limits = ProcessLimits {
            time: Duration::from_secs(600),
            bytes: 1000,
        };
        let run = shell("sleep 1000 & echo $!").limits(limits).run();
        let text = run.expect("the program itself ends").text();
        let process: i32 = text.trim().parse().expect("a number");
        let is_dead = || {
            let there = nix::sys::signal::kill(nix::unistd::Pid::from_raw(process), None);
            // It may wait for somebody to take note of its end.
            let state = std::fs::read_to_string(format!("/proc/{process}/stat"));
            there.is_err() || state.is_ok_and(|state| state.contains(") Z "))
        };
        // Its end takes the system a moment.
        let ended = (0..1000).any(|_| {
            std::thread::sleep(Duration::from_millis(10));
            is_dead()
        });
        assert!(ended);
    }
}
