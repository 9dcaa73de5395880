//! Signals from the system to the daemon.

use anyhow::{Context, Result};
use tokio::signal::unix::{SignalKind, signal};

/// The meaning of a signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DaemonSignal {
    /// SIGTERM or SIGINT: stop in order.
    Stop,
    /// SIGHUP: read the configuration again.
    Reload,
}

/// The signals that the daemon listens to.
#[derive(Debug)]
pub struct SignalListener {
    terminate: tokio::signal::unix::Signal,
    interrupt: tokio::signal::unix::Signal,
    hang_up: tokio::signal::unix::Signal,
    /// A reload that was asked for while the loop was busy.
    is_reload_due: bool,
}

impl SignalListener {
    /// Starts to listen.
    pub fn listen() -> Result<Self> {
        let listen = |kind| signal(kind).context("listening to signals");
        Ok(Self {
            terminate: listen(SignalKind::terminate())?,
            interrupt: listen(SignalKind::interrupt())?,
            hang_up: listen(SignalKind::hangup())?,
            is_reload_due: false,
        })
    }

    /// The next signal.
    pub async fn next_signal(&mut self) -> DaemonSignal {
        if std::mem::take(&mut self.is_reload_due) {
            return DaemonSignal::Reload;
        }
        self.receive().await
    }

    /// Waits until the daemon is to stop. A reload that is asked for meanwhile is the next signal.
    pub async fn wait_for_stop(&mut self) {
        while self.receive().await == DaemonSignal::Reload {
            self.is_reload_due = true;
        }
    }

    async fn receive(&mut self) -> DaemonSignal {
        tokio::select! {
            _ = self.terminate.recv() => DaemonSignal::Stop,
            _ = self.interrupt.recv() => DaemonSignal::Stop,
            _ = self.hang_up.recv() => DaemonSignal::Reload,
        }
    }
}
