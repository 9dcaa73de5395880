//! Renders a build's cake for a page and caches the result. Only one render runs at a time, so that the dashboard takes
//! at most one core from the farm.

use std::sync::Arc;

use anyhow::Context;
use farm::{CakeContents, load_placed_parts};
use language::say;
use ledger::{BuildId, BuildRow, PartId};
use settings::MachineProfile;

use super::state::DashboardState;
use crate::web::base::{
    cache::RecentCache,
    error::{HandlerError, HandlerResult},
};

/// The cache and the key of a rendered result.
pub(crate) struct CacheLocation<T: 'static> {
    /// The cache for this kind of result.
    pub(crate) cache: fn(&DashboardState) -> &RecentCache<T>,
    /// Must change whenever the result changes.
    pub(crate) key: String,
    /// The only part that is needed; `None` = all.
    pub(crate) only: Option<PartId>,
}

/// Finds a build, and its profile as it was when the build was made.
pub(crate) async fn find_build(web: &DashboardState, number: i64) -> HandlerResult<(BuildRow, MachineProfile)> {
    let missing = || HandlerError::NotFound(say!("build-named", build = number.to_string()));
    let build = web.ledger.find_build(BuildId(number)).await?.ok_or_else(missing)?;
    let settings = web.current_settings();
    let now = settings.profiles.get(&build.machine);
    let profile = MachineProfile::from_snapshot(&build.machine, build.kept.profile_snapshot.as_deref(), now);
    Ok((build, profile))
}

/// Returns the cached result of `make`, or runs it on the build's cake. `make` runs on a blocking thread, one call at a
/// time, and its result is cached even when the client has gone.
pub(crate) async fn render_cached<T: Clone + Send + 'static>(
    web: &Arc<DashboardState>,
    build: &BuildRow,
    profile: &MachineProfile,
    kept: CacheLocation<T>,
    make: impl FnOnce(&CakeContents) -> anyhow::Result<T> + Send + 'static,
) -> HandlerResult<T> {
    let language = language::current();

    let known = || (kept.cache)(web).get(&kept.key);
    if let Some(thing) = known() {
        return Ok(thing);
    }
    let turn = web.render_slot.clone().acquire_owned().await.context("waiting for a turn")?;
    if let Some(thing) = known() {
        return Ok(thing);
    }
    let mut parts = load_placed_parts(&web.ledger, build, profile).await?;
    parts.retain(|(part, _)| kept.only.is_none_or(|only| part.id == only));
    let (web, build, profile) = (web.clone(), build.clone(), profile.clone());
    let making = tokio::task::spawn_blocking(move || {
        let _turn = turn;
        let cake = CakeContents::from_ledger(&web.current_settings(), &profile, &build, parts);
        let thing = language.within(|| make(&cake))?;
        (kept.cache)(&web).insert(kept.key, thing.clone());
        Ok(thing)
    });
    let made: anyhow::Result<T> = making.await.context("looking at the build")?;
    Ok(made?)
}

/// A text that changes whenever the copies in the build or their poses change.
pub(crate) fn layout_version(build: &BuildRow) -> String {
    let layout = blake3::hash(build.kept.layout.as_deref().unwrap_or_default().as_bytes()).to_hex();
    format!("{}-{}-{}", build.id, build.state, &layout[..16])
}
