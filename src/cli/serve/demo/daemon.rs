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
use tokio::signal::unix::{SignalKind, signal};

/// An orderly stop takes 10 s at most; this is a little more, for a busy machine.
const STOP_SECS: u64 = 15;
/// Time between two looks at the daemon.
const LOOK_INTERVAL: Duration = Duration::from_secs(1);
/// Lines of the log that are shown after a failure.
const TAIL_LINES: usize = 30;

/// A running `nestd run`. When it is dropped without [`DemoDaemon::stop`] it is killed, which the ledger survives.
#[derive(Debug)]
pub(super) struct DemoDaemon {
    child: Child,
    log: PathBuf,
}

impl DemoDaemon {
    /// Starts this program as the daemon; its log is appended to `log`. Ctrl-C reaches it, too.
    pub(super) fn start(config: &Path, root: &Path, log: &Path) -> Result<Self> {
        let out = File::options().create(true).append(true).open(log);
        let out = out.with_context(|| format!("cannot write {}", log.display()))?;
        let child = nestd_command(config, root)?
            .args(["run", "--allow-root"])
            .stdin(Stdio::null())
            .stdout(out.try_clone()?)
            .stderr(out)
            .spawn()
            .context("cannot start the daemon")?;
        Ok(Self { child, log: log.to_owned() })
    }

    /// The process id.
    pub(super) fn process_id(&self) -> u32 {
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

    /// Waits until somebody ends the demo.
    ///
    /// # Errors
    /// When the daemon has ended by itself.
    pub(super) async fn run_until_stopped(&mut self) -> Result<()> {
        let (mut interrupt, mut terminate) = (signal(SignalKind::interrupt())?, signal(SignalKind::terminate())?);
        loop {
            tokio::select! {
                _ = interrupt.recv() => return Ok(()),
                _ = terminate.recv() => return Ok(()),
                () = tokio::time::sleep(LOOK_INTERVAL) => self.expect_running()?,
            }
        }
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

impl Drop for DemoDaemon {
    fn drop(&mut self) {
        // After `stop` the process has ended, and there is nothing to kill.
        if matches!(self.child.try_wait(), Ok(None)) {
            let _ = self.child.kill();
            let _ = self.child.wait();
            eprintln!("nestd: killed the demo's daemon; its log is {}", self.log.display());
        }
    }
}

/// A command that runs this program on the demo's farm.
pub(super) fn nestd_command(config: &Path, root: &Path) -> Result<Command> {
    let mut command = Command::new(std::env::current_exe().context("cannot find this program")?);
    command.arg("-c").arg(config).arg("--root").arg(root);
    Ok(command)
}
