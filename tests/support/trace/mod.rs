//! Runs the daemon under ptrace: every system call that touches the farm's folders is counted, can be made to fail, and the
//! process can be killed between any two of them. All threads are followed. The binary under test is the ordinary one.

mod call;

use std::{
    collections::HashMap,
    os::unix::process::CommandExt,
    path::{Path, PathBuf},
    process::Command,
    sync::mpsc::{Receiver, channel},
    thread::JoinHandle,
    time::{Duration, Instant},
};

use nix::{
    libc,
    sys::{
        ptrace::{self, Options},
        signal::{Signal, kill},
        wait::{WaitPidFlag, WaitStatus, waitpid},
    },
    unistd::Pid,
};

#[allow(unused_imports)] // no program needs all of it
pub use call::{CallEffect, SystemCall};

/// What to do with a call that is about to be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CallVerdict {
    /// The kernel does it.
    Let,
    /// It is not done and returns this error.
    Fail(i32),
    /// It writes at most this number of bytes.
    Shorten(u64),
    /// The kernel does it after a while; only the thread that makes it waits.
    Delay(Duration),
}

/// Looks at the calls of a traced daemon; lives on the tracer's thread.
pub trait CallWatcher: Send {
    /// A call is about to be made.
    fn before(&mut self, call: &SystemCall) -> CallVerdict;
    /// A call was made, with this result. `false` = kill the daemon now.
    fn after(&mut self, call: &SystemCall, result: i64) -> bool;
}

/// A daemon under the tracer; killed when dropped.
pub struct TracedDaemon<W> {
    pid: Pid,
    ended: Receiver<()>,
    has_ended: bool,
    thread: Option<JoinHandle<W>>,
}

/// Whether processes may be traced here; some containers forbid it.
pub fn is_allowed() -> bool {
    struct Nothing;
    impl CallWatcher for Nothing {
        fn before(&mut self, _: &SystemCall) -> CallVerdict {
            CallVerdict::Let
        }
        fn after(&mut self, _: &SystemCall, _: i64) -> bool {
            true
        }
    }
    TracedDaemon::start(Command::new("true"), Path::new("/nowhere"), Nothing).is_ok()
}

impl<W: CallWatcher + 'static> TracedDaemon<W> {
    /// Starts `command`; calls on paths below `root` are shown to `watch`.
    pub fn start(command: Command, root: &Path, watch: W) -> Result<Self, String> {
        let (tell_pid, pid) = channel();
        let (tell_end, ended) = channel();
        let root = root.to_owned();
        let thread = std::thread::spawn(move || {
            let pid = match seize(command) {
                Ok(pid) => pid,
                Err(error) => {
                    let _ = tell_pid.send(Err(error));
                    return watch;
                }
            };
            let _ = tell_pid.send(Ok(pid));
            let watch = DaemonTracer { pid, root, watch, inside: HashMap::new(), held: Vec::new() }.run();
            let _ = tell_end.send(());
            watch
        });
        let pid = pid.recv().map_err(|e| e.to_string())??;
        Ok(Self { pid, ended, has_ended: false, thread: Some(thread) })
    }

    /// Its process id.
    pub fn pid(&self) -> i32 {
        self.pid.as_raw()
    }

    /// Whether the daemon has ended.
    pub fn has_ended(&mut self) -> bool {
        self.has_ended = self.has_ended || self.ended.try_recv().is_ok();
        self.has_ended
    }

    /// SIGTERM, and kill -9 after some time. Returns what was watched, and whether it went in time.
    pub fn stop(mut self) -> (W, bool) {
        let _ = kill(self.pid, Signal::SIGTERM);
        let began = Instant::now();
        while !self.has_ended() && began.elapsed() < Duration::from_secs(15) {
            std::thread::sleep(Duration::from_millis(5));
        }
        let in_time = self.has_ended;
        (self.kill(), in_time)
    }

    /// kill -9.
    pub fn kill(mut self) -> W {
        let _ = kill(self.pid, Signal::SIGKILL);
        self.thread.take().unwrap().join().unwrap()
    }
}

impl<W> Drop for TracedDaemon<W> {
    fn drop(&mut self) {
        if let Some(thread) = self.thread.take() {
            let _ = kill(self.pid, Signal::SIGKILL);
            let _ = thread.join();
        }
    }
}

/// Starts a shell that stops itself, takes hold of it, and lets it become the command.
fn seize(command: Command) -> Result<Pid, String> {
    let mut shell = Command::new("/bin/sh");
    shell.args(["-c", "kill -STOP $$; exec \"$0\" \"$@\""]).arg(command.get_program()).args(command.get_args());
    if let Some(dir) = command.get_current_dir() {
        shell.current_dir(dir);
    }
    for (key, value) in command.get_envs() {
        match value {
            Some(value) => shell.env(key, value),
            None => shell.env_remove(key),
        };
    }
    let log = command.get_current_dir().map(|dir| dir.join("log"));
    shell.stdin(std::process::Stdio::null()).stdout(std::process::Stdio::null()).process_group(0);
    match log.and_then(|log| std::fs::File::options().create(true).append(true).open(log).ok()) {
        Some(log) => shell.stderr(log),
        None => shell.stderr(std::process::Stdio::null()),
    };
    let child = shell.spawn().map_err(|e| e.to_string())?;
    let pid = Pid::from_raw(child.id() as i32);
    waitpid(pid, Some(WaitPidFlag::WUNTRACED)).map_err(|e| e.to_string())?;
    let options = Options::PTRACE_O_TRACESYSGOOD
        | Options::PTRACE_O_TRACECLONE
        | Options::PTRACE_O_TRACEFORK
        | Options::PTRACE_O_TRACEVFORK
        | Options::PTRACE_O_TRACEEXEC
        | Options::PTRACE_O_EXITKILL;
    if let Err(error) = ptrace::seize(pid, options) {
        let _ = kill(pid, Signal::SIGKILL);
        let _ = waitpid(pid, None);
        return Err(error.to_string());
    }
    kill(pid, Signal::SIGCONT).map_err(|e| e.to_string())?;
    Ok(pid)
}

struct DaemonTracer<W> {
    pid: Pid,
    root: PathBuf,
    watch: W,
    /// Threads inside a call, with the call when it is one of ours, what is to be returned instead and the registers to
    /// be put back.
    inside: HashMap<Pid, Option<PendingCall>>,
    /// Threads whose call is delayed, and until when.
    held: Vec<(Pid, Instant)>,
}

struct PendingCall {
    call: SystemCall,
    verdict: CallVerdict,
    regs: libc::user_regs_struct,
}

impl<W: CallWatcher> DaemonTracer<W> {
    /// Follows all threads until the process is gone.
    fn run(mut self) -> W {
        let group = Pid::from_raw(-self.pid.as_raw());
        loop {
            self.let_go_of_held();
            // While a thread is held there is nothing to be told that it has been held long enough.
            let wait =
                if self.held.is_empty() { WaitPidFlag::__WALL } else { WaitPidFlag::__WALL | WaitPidFlag::WNOHANG };
            match waitpid(group, Some(wait)) {
                Ok(WaitStatus::StillAlive) => std::thread::sleep(Duration::from_millis(1)),
                Ok(WaitStatus::PtraceSyscall(thread)) => self.handle_call(thread),
                Ok(WaitStatus::PtraceEvent(thread, ..)) => resume(thread, None),
                Ok(WaitStatus::Stopped(thread, signal)) => {
                    let held = matches!(signal, Signal::SIGSTOP | Signal::SIGTRAP | Signal::SIGCONT);
                    resume(thread, (!held).then_some(signal));
                }
                Ok(WaitStatus::Exited(thread, _) | WaitStatus::Signaled(thread, ..)) => {
                    self.inside.remove(&thread);
                    if thread == self.pid {
                        return self.watch;
                    }
                }
                Err(nix::errno::Errno::EINTR) | Ok(_) => {}
                Err(_) => return self.watch,
            }
        }
    }

    fn let_go_of_held(&mut self) {
        let now = Instant::now();
        self.held.extract_if(.., |(_, until)| *until <= now).for_each(|(thread, _)| resume(thread, None));
    }

    fn handle_call(&mut self, thread: Pid) {
        match self.inside.remove(&thread) {
            None => {
                let pending = self.enter(thread);
                let delay = pending.as_ref().and_then(|pending| match pending.verdict {
                    CallVerdict::Delay(delay) => Some(delay),
                    _ => None,
                });
                self.inside.insert(thread, pending);
                if let Some(delay) = delay {
                    return self.held.push((thread, Instant::now() + delay));
                }
            }
            Some(Some(pending)) => self.leave(thread, pending),
            Some(None) => {}
        }
        resume(thread, None);
    }

    fn enter(&mut self, thread: Pid) -> Option<PendingCall> {
        let regs = ptrace::getregs(thread).ok()?;
        let call = SystemCall::decode(self.pid, thread, &regs, &self.root)?;
        let verdict = self.watch.before(&call);
        let mut changed = regs;
        match verdict {
            CallVerdict::Let | CallVerdict::Delay(_) => {}
            CallVerdict::Fail(_) => changed.orig_rax = u64::MAX,
            CallVerdict::Shorten(bytes) => changed.rdx = bytes,
        }
        if !matches!(verdict, CallVerdict::Let | CallVerdict::Delay(_)) {
            let _ = ptrace::setregs(thread, changed);
        }
        Some(PendingCall { call, verdict, regs })
    }

    fn leave(&mut self, thread: Pid, pending: PendingCall) {
        let Ok(mut regs) = ptrace::getregs(thread) else { return };
        match pending.verdict {
            CallVerdict::Let | CallVerdict::Delay(_) => {}
            CallVerdict::Fail(errno) => regs.rax = i64::from(-errno) as u64,
            CallVerdict::Shorten(_) => regs.rdx = pending.regs.rdx,
        }
        if !matches!(pending.verdict, CallVerdict::Let | CallVerdict::Delay(_)) {
            let _ = ptrace::setregs(thread, regs);
        }
        if !self.watch.after(&pending.call, regs.rax as i64) {
            let _ = kill(self.pid, Signal::SIGKILL);
        }
    }
}

fn resume(thread: Pid, signal: Option<Signal>) {
    // waitpid reports a thread that was killed meanwhile.
    let _ = ptrace::syscall(thread, signal);
}
