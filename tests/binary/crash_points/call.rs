//! Which system calls change the file system, on Linux for x86-64.

use std::ffi::OsStr;
use std::fs::File;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use nix::libc::{self, c_long, user_regs_struct};
use nix::sys::ptrace;
use nix::unistd::Pid;

/// A system call that matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Call {
    /// It takes room on the disk: makes, writes, lengthens or syncs a file or a folder.
    Takes(&'static str),
    /// It gives a file of the user's cache its name: whoever loses that loses only time.
    Caches,
    /// It changes names, locks or modes.
    Changes(&'static str),
    /// It says something: standard output or standard error.
    Says,
}

/// The registers of a thread that is about to make a call, or has made it.
pub struct Registers(pub user_regs_struct);

impl Registers {
    pub fn of(thread: Pid) -> Self {
        Self(ptrace::getregs(thread).expect("it has stopped"))
    }

    /// What is about to be called, if it matters; files outside the folder do not.
    pub fn call(&self, thread: Pid, folder: &Path) -> Option<Call> {
        let Self(registers) = self;
        let opened_to_write = |flags: u64| {
            let writes = libc::O_WRONLY | libc::O_RDWR | libc::O_CREAT | libc::O_TRUNC;
            flags & u64::from(writes.cast_unsigned()) != 0
        };
        let file = |fd: u64| std::fs::read_link(format!("/proc/{thread}/fd/{fd}")).ok();
        let ours = |fd: u64| file(fd).is_some_and(|file| file.starts_with(folder));
        let written = |fd: u64, call: Call| match fd {
            1 | 2 => Some(Call::Says),
            _ => ours(fd).then_some(call),
        };
        let (first, second, third) = (registers.rdi, registers.rsi, registers.rdx);
        let renamed = |name: u64| {
            let place = text_at(thread, name);
            let elsewhere = place.is_absolute() && !place.starts_with(folder);
            if elsewhere { Call::Caches } else { Call::Takes("rename") }
        };
        Some(match registers.orig_rax.cast_signed() as c_long {
            libc::SYS_write | libc::SYS_writev | libc::SYS_pwrite64 | libc::SYS_pwritev => {
                return written(first, Call::Takes("write"));
            }
            libc::SYS_fsync | libc::SYS_fdatasync => {
                return written(first, Call::Takes("sync"));
            }
            libc::SYS_ftruncate | libc::SYS_fallocate => {
                return written(first, Call::Takes("truncate"));
            }
            libc::SYS_copy_file_range => return written(third, Call::Takes("copy")),
            libc::SYS_sendfile => return written(first, Call::Takes("copy")),
            libc::SYS_openat if opened_to_write(third) => Call::Takes("open"),
            libc::SYS_open if opened_to_write(second) => Call::Takes("open"),
            libc::SYS_creat => Call::Takes("open"),
            libc::SYS_mkdir | libc::SYS_mkdirat => Call::Takes("mkdir"),
            libc::SYS_rename => renamed(second),
            libc::SYS_renameat | libc::SYS_renameat2 => renamed(registers.r10),
            libc::SYS_link | libc::SYS_linkat | libc::SYS_symlink | libc::SYS_symlinkat => {
                Call::Takes("link")
            }
            libc::SYS_unlink | libc::SYS_unlinkat | libc::SYS_rmdir => Call::Changes("unlink"),
            libc::SYS_flock => Call::Changes("lock"),
            libc::SYS_chmod | libc::SYS_fchmod | libc::SYS_fchmodat => Call::Changes("chmod"),
            libc::SYS_utimensat | libc::SYS_truncate => Call::Changes("change"),
            _ => return None,
        })
    }

    /// Makes no call at all in place of the one that the thread is about to make.
    pub fn skip(mut self, thread: Pid) {
        self.0.orig_rax = u64::MAX;
        ptrace::setregs(thread, self.0).expect("it has stopped");
    }

    /// The answer to the call that was skipped.
    pub fn answer_with_a_full_disk(mut self, thread: Pid) {
        self.0.rax = i64::from(-libc::ENOSPC).cast_unsigned();
        ptrace::setregs(thread, self.0).expect("it has stopped");
    }
}

/// A path in a thread's memory.
fn text_at(thread: Pid, address: u64) -> PathBuf {
    let memory = File::open(format!("/proc/{thread}/mem")).expect("it is traced");
    // Behind the path there may be less.
    let mut bytes = vec![0; libc::PATH_MAX as usize];
    let read = memory.read_at(&mut bytes, address).expect("a path is there");
    let end = bytes[..read].iter().position(|byte| *byte == 0).expect("a path has an end");
    OsStr::from_bytes(&bytes[..end]).into()
}
