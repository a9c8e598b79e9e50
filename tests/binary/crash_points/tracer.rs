//! Runs a program under `ptrace`, and stops it at every system call that changes the file system or says something.
//!
//! A stop is before the call: whoever kills the program there leaves what all calls before it have done.

use std::collections::HashSet;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};

use nix::sys::ptrace::{self, Options};
use nix::sys::signal::{Signal, kill};
use nix::sys::wait::{WaitPidFlag, WaitStatus, waitpid};
use nix::unistd::Pid;

use super::call::{Call, Registers};

/// What becomes of a program at a stop.
pub enum Then {
    /// It makes the call.
    Goes,
    /// It ends there, as by `kill -9` or a power cut.
    Dies,
    /// The call fails: no space is left on the disk.
    FindsTheDiskFull,
}

/// A stop before a system call.
pub struct Stop {
    /// The number of this stop, from 0.
    pub index: usize,
    /// What is about to be called.
    pub call: Call,
}

/// How a traced program ended, and its output.
pub struct Traced {
    /// Its exit code; none if it was killed.
    pub code: Option<i32>,
    /// What it said to standard output and standard error.
    pub said: [String; 2],
    /// How many system calls it made, of whatever kind.
    pub calls: usize,
}

/// Runs a program in this folder, and asks at each stop what becomes of it.
pub fn trace(mut command: Command, folder: &Path, at: impl FnMut(&Stop, u32) -> Then) -> Traced {
    // SAFETY: `ptrace(PTRACE_TRACEME)` is a bare system call, and as such safe between fork and exec.
    unsafe {
        command.pre_exec(|| ptrace::traceme().map_err(std::io::Error::from));
    }
    // Output must not hold it up: it goes into files beside the folder.
    let outputs =
        [tempfile::NamedTempFile::new().unwrap(), tempfile::NamedTempFile::new().unwrap()];
    command.stdout(outputs[0].reopen().unwrap()).stderr(outputs[1].reopen().unwrap());
    let mut child = command.spawn().expect("the executable starts");
    drop(child.stdin.take());
    let folder = folder.canonicalize().unwrap();
    let (code, calls) = Supervisor::new(&child, folder, at).run();
    // It is gone already; this only tells the standard library so.
    let _ = child.try_wait();
    let said = outputs.map(|file| std::fs::read_to_string(file.path()).unwrap());
    Traced { code, said, calls }
}

struct Supervisor<F> {
    leader: Pid,
    folder: PathBuf,
    at: F,
    /// Threads inside a system call; those of which the call is to fail have a second entry.
    inside: HashSet<Pid>,
    failing: HashSet<Pid>,
    calls: usize,
    stops: usize,
}

impl<F: FnMut(&Stop, u32) -> Then> Supervisor<F> {
    fn new(child: &Child, folder: PathBuf, at: F) -> Self {
        let leader = Pid::from_raw(child.id().cast_signed());
        let (inside, failing) = (HashSet::new(), HashSet::new());
        Self { leader, folder, at, inside, failing, calls: 0, stops: 0 }
    }

    /// Follows all threads until the program has ended.
    fn run(mut self) -> (Option<i32>, usize) {
        // Only children of this thread: other tests wait for their own.
        let flags = WaitPidFlag::__WALL | WaitPidFlag::__WNOTHREAD;
        let first = waitpid(self.leader, Some(flags)).expect("it stops at its first instruction");
        assert!(matches!(first, WaitStatus::Stopped(_, Signal::SIGTRAP)), "{first:?}");
        let follow = Options::PTRACE_O_TRACESYSGOOD
            | Options::PTRACE_O_TRACECLONE
            | Options::PTRACE_O_EXITKILL;
        ptrace::setoptions(self.leader, follow).expect("it is traced");
        self.go_on(self.leader, None);
        loop {
            match waitpid(None, Some(flags)).expect("it lives, or has just ended") {
                WaitStatus::PtraceSyscall(thread) => self.system_call(thread),
                WaitStatus::PtraceEvent(thread, ..)
                | WaitStatus::Stopped(thread, Signal::SIGSTOP | Signal::SIGTRAP) => {
                    self.go_on(thread, None);
                }
                WaitStatus::Stopped(thread, signal) => self.go_on(thread, Some(signal)),
                WaitStatus::Exited(thread, code) if thread == self.leader => {
                    return (Some(code), self.calls);
                }
                WaitStatus::Signaled(thread, ..) if thread == self.leader => {
                    return (None, self.calls);
                }
                _ => {}
            }
        }
    }

    /// A thread that was killed meanwhile needs no going on.
    fn go_on(&self, thread: Pid, signal: Option<Signal>) {
        let _ = ptrace::syscall(thread, signal);
    }

    fn system_call(&mut self, thread: Pid) {
        if self.inside.remove(&thread) {
            if self.failing.remove(&thread) {
                Registers::of(thread).answer_with_a_full_disk(thread);
            }
        } else {
            self.inside.insert(thread);
            self.calls += 1;
            // A thread that was killed meanwhile has no registers.
            if let Ok(registers) = ptrace::getregs(thread) {
                self.entered(thread, Registers(registers));
            }
        }
        self.go_on(thread, None);
    }

    fn entered(&mut self, thread: Pid, registers: Registers) {
        let Some(call) = registers.call(thread, &self.folder) else { return };
        let stop = Stop { index: self.stops, call };
        self.stops += 1;
        match (self.at)(&stop, self.leader.as_raw().cast_unsigned()) {
            Then::Goes => {}
            Then::Dies => kill(self.leader, Signal::SIGKILL).expect("it is there"),
            Then::FindsTheDiskFull => {
                registers.skip(thread);
                self.failing.insert(thread);
            }
        }
    }
}
