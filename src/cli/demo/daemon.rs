//! The real daemon as a child process of the demo.

use std::{
    fs::{self, File},
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use anyhow::{Context, Result, bail};
use rustix::process::{Pid, Signal, kill_process};

/// An orderly stop takes 10 s at most; a little more for a busy machine.
const STOP_SECS: u64 = 15;
/// So much of the log is shown when something failed.
const TAIL_LINES: usize = 30;

/// A running `nestd run`. Dropped without [`Daemon::stop`], it is killed: the ledger stands a crash.
#[derive(Debug)]
pub(super) struct Daemon {
    child: Child,
    log: PathBuf,
}

impl Daemon {
    /// Starts this very program as the daemon; its log is appended to `log`.
    pub(super) fn start(config: &Path, root: &Path, log: &Path) -> Result<Self> {
        let out = File::options().create(true).append(true).open(log);
        let out = out.with_context(|| format!("cannot write {}", log.display()))?;
        let child = nestd(config, root)?
            .args(["run", "--allow-root"])
            .stdin(Stdio::null())
            .stdout(out.try_clone()?)
            .stderr(out)
            .spawn()
            .context("cannot start the daemon")?;
        Ok(Self { child, log: log.to_owned() })
    }

    /// Its process number.
    pub(super) fn pid(&self) -> u32 {
        self.child.id()
    }

    /// # Errors
    /// When the daemon has ended by itself.
    pub(super) fn expect_running(&mut self) -> Result<()> {
        if let Some(status) = self.child.try_wait()? {
            bail!("the daemon ended by itself ({status})");
        }
        Ok(())
    }

    /// Asks the daemon to stop and waits for it.
    ///
    /// # Errors
    /// When it does not stop in time or reports a failure.
    pub(super) fn stop(mut self) -> Result<()> {
        let pid = i32::try_from(self.child.id()).ok().and_then(Pid::from_raw).context("the daemon has no process")?;
        kill_process(pid, Signal::TERM).context("cannot stop the daemon")?;
        let deadline = Instant::now() + Duration::from_secs(STOP_SECS);
        while Instant::now() < deadline {
            match self.child.try_wait()? {
                Some(status) if status.success() => return Ok(()),
                Some(status) => bail!("the daemon stopped with a failure ({status})"),
                None => thread::sleep(Duration::from_millis(50)),
            }
        }
        bail!("the daemon did not stop within {STOP_SECS} s")
    }

    /// The end of its log.
    pub(super) fn log_tail(log: &Path) -> String {
        let text = fs::read(log).map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).unwrap_or_default();
        let lines: Vec<&str> = text.lines().collect();
        lines[lines.len().saturating_sub(TAIL_LINES)..].join("\n")
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        // Fails when it has ended, as it should have.
        if matches!(self.child.try_wait(), Ok(None)) {
            let _ = self.child.kill();
            let _ = self.child.wait();
            eprintln!("nestd: killed the demo's daemon; its log is {}", self.log.display());
        }
    }
}

/// This very program, told to use the demo's farm.
pub(super) fn nestd(config: &Path, root: &Path) -> Result<Command> {
    let mut command = Command::new(std::env::current_exe().context("cannot find this program")?);
    command.arg("-c").arg(config).arg("--root").arg(root);
    Ok(command)
}
