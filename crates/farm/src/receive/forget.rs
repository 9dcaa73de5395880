//! Removes data from the store: files that no part needs any more, and claim notes of printed claims. A job removes
//! them, because a stored file may be large and a disk slow. Right before the job starts, the farm checks whether each
//! file is needed. Until the job has ended, no part with the same bytes is recorded or taken back.

use anyhow::Result;
use intake::StoreError;
use jiff::{SignedDuration, Timestamp};
use jobs::{BackgroundJob, Carried};
use ledger::Ledger;

use crate::{
    alerts::alert::AlertKind,
    core::{desks::Storing, farm::Farm},
    records::forgettable::{Forgettable, KEEP_REFUSED_SECS},
};

/// Removes the files and claim notes that the store does not need.
#[derive(Clone)]
pub(crate) struct ForgetJob;

impl BackgroundJob<Farm> for ForgetJob {
    const KIND: &'static str = "Forget";
    type Outcome = Result<()>;
    type Desk<'f> = Storing<'f>;

    fn subject(&self) -> String {
        String::new()
    }

    async fn on_done(self, mut desk: Self::Desk<'_>, removed: Self::Outcome) -> Result<()> {
        on_forgotten(&mut desk, removed).await
    }

    async fn on_panic(self, mut desk: Self::Desk<'_>, message: &str) -> Result<()> {
        on_forgotten(&mut desk, Err(anyhow::anyhow!("panicked: {message}"))).await
    }
}

/// The mark that files are being removed. What was not removed, the next cleanup finds again.
struct RemovalMark;

impl Carried<Farm> for RemovalMark {
    type Desk<'f> = Storing<'f>;

    fn give_back(self, desk: Self::Desk<'_>) {
        desk.forgetting.end();
    }
}

/// Removes these from the store if no part needs them, together with earlier requests. A later cleanup finds those
/// again that cannot be removed now.
pub(crate) async fn forget_data(desk: &mut Storing<'_>, unneeded: impl IntoIterator<Item = Forgettable>) -> Result<()> {
    desk.forgetting.want(unneeded);
    if desk.jobs.is_running::<ForgetJob>("") {
        return Ok(());
    }
    let mut work = Vec::new();
    for wanted in desk.forgetting.wanted().clone() {
        if let Forgettable::StoredFile(hash) = &wanted
            && is_content_needed(desk.shared.ledger, desk.shared.date(), hash).await?
        {
            continue;
        }
        work.push(wanted);
    }
    desk.forgetting.begin(&work);
    if work.is_empty() {
        return Ok(());
    }
    let forgetting = &*desk.forgetting;
    desk.meshes.mesh_cache.retain(|key| !forgetting.is_under_way(&key.content_hash));
    let store = desk.meshes.store.clone();
    desk.jobs.start_with(ForgetJob, RemovalMark, move |_| {
        // If one cannot be removed, the others are still removed.
        let removed = work.iter().map(|one| one.remove_from(&store)).collect::<Vec<_>>();
        Ok(removed.into_iter().collect::<Result<(), StoreError>>()?)
    });
    Ok(())
}

async fn on_forgotten(desk: &mut Storing<'_>, removed: Result<()>) -> Result<()> {
    match &removed {
        Ok(()) => desk.shared.alerts.clear(AlertKind::StepFails, "", "forgetting"),
        Err(failure) => desk.shared.report_failure(AlertKind::StepFails, "", "forgetting", failure),
    }
    forget_data(desk, []).await
}

/// Whether a stored file is needed by a live part, or by a refused part that may still be taken back.
async fn is_content_needed(ledger: &Ledger, now: Timestamp, content_hash: &str) -> Result<bool> {
    let since = now.checked_sub(SignedDuration::from_secs_f64(KEEP_REFUSED_SECS));
    Ok(ledger.is_hash_in_use(content_hash, since.unwrap_or(Timestamp::UNIX_EPOCH)).await?)
}
