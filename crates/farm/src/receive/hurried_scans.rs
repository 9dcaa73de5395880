//! A line that was ordered by request is taken at once: the hot folder of its machine is scanned when the ledger has another one.

use anyhow::Result;

use super::scan_jobs::HotFolderScanJob;
use crate::core::desks::Serving;

/// Has the hot folder of a machine scanned soon for which a line was ordered.
pub(crate) async fn hurry_scans(desk: &mut Serving<'_>) -> Result<()> {
    let now = desk.shared.now();
    for (name, machine) in desk.machines.iter_mut() {
        let newest = desk.shared.ledger.newest_arriving_line(name).await?;
        if newest != machine.inbox.arriving {
            machine.inbox.next_scan_at = now;
            machine.inbox.is_hurried = desk.jobs.is_running::<HotFolderScanJob>(name);
            machine.inbox.arriving = newest;
        }
    }
    Ok(())
}
