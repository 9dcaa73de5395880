//! Notifications to systemd: ready, status, watchdog, reloading, stopping. Does nothing without systemd.

use sd_notify::NotifyState;

/// Longer than the maximum wait between two attempts to open the farm.
const EXTEND_USEC: u32 = 120_000_000;

/// The farm has started.
pub fn notify_ready(status: &str) {
    send_states(&[NotifyState::Ready, NotifyState::Status(status)]);
}

/// One line for `systemctl status`.
pub fn notify_status(status: &str) {
    send_states(&[NotifyState::Status(status)]);
}

/// The start takes longer, and why.
pub fn notify_start_delayed(why: &str) {
    send_states(&[NotifyState::Status(why), NotifyState::ExtendTimeoutUsec(EXTEND_USEC)]);
}

/// The event loop is alive.
pub fn notify_watchdog() {
    send_states(&[NotifyState::Watchdog]);
}

/// The configuration is being read again; `ready` ends this state.
pub fn notify_reloading() {
    if let Ok(now) = NotifyState::monotonic_usec_now() {
        send_states(&[NotifyState::Reloading, now]);
    }
}

/// The farm is stopping.
pub fn notify_stopping() {
    send_states(&[NotifyState::Stopping]);
}

fn send_states(states: &[NotifyState<'_>]) {
    if let Err(error) = sd_notify::notify(states) {
        tracing::debug!(%error, "The service manager could not be notified.");
    }
}
