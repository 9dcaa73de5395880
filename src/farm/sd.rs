//! What the service manager hears: ready, status, watchdog, reloading, stopping. Silent where there is none.

use sd_notify::NotifyState;

/// Longer than the longest wait between two tries to open the farm.
const EXTEND_USEC: u32 = 120_000_000;

/// The farm serves.
pub fn ready(status: &str) {
    tell(&[NotifyState::Ready, NotifyState::Status(status)]);
}

/// One line for `systemctl status`.
pub fn status(status: &str) {
    tell(&[NotifyState::Status(status)]);
}

/// The start takes longer, for this reason.
pub fn waiting(why: &str) {
    tell(&[NotifyState::Status(why), NotifyState::ExtendTimeoutUsec(EXTEND_USEC)]);
}

/// The event loop is alive.
pub fn alive() {
    tell(&[NotifyState::Watchdog]);
}

/// The configuration is being read again; `ready` ends it.
pub fn reloading() {
    if let Ok(now) = NotifyState::monotonic_usec_now() {
        tell(&[NotifyState::Reloading, now]);
    }
}

/// The farm stops.
pub fn stopping() {
    tell(&[NotifyState::Stopping]);
}

fn tell(states: &[NotifyState<'_>]) {
    if let Err(error) = sd_notify::notify(states) {
        tracing::debug!(%error, "The service manager does not listen.");
    }
}
