//! What is made of a build's cake for a page, and is kept: one at a time, so that looking takes one core from the farm at most.

use std::sync::Arc;

use anyhow::Context;

use super::{
    cache::Cache,
    problem::{Answer, Problem},
    state::Web,
};
use crate::{
    farm::{Cake, standing},
    ledger::{BuildId, BuildRow},
    settings::Profile,
};

/// Where a thing is kept, and under what.
pub(super) struct Kept<T: 'static> {
    /// The cache of its kind.
    pub(super) cache: fn(&Web) -> &Cache<T>,
    /// Another one when the thing is.
    pub(super) key: String,
}

/// A build and its profile, as it was when the build was made.
pub(super) async fn build_of(web: &Web, number: i64) -> Answer<(BuildRow, Profile)> {
    let missing = || Problem::NotFound(format!("build {number}"));
    let build = web.ledger.build(BuildId(number)).await?.ok_or_else(missing)?;
    let settings = web.settings();
    let now = settings.profiles.get(&build.profile);
    let profile = Profile::then(&build.profile, build.kept.profile_snapshot.as_deref(), now);
    Ok((build, profile))
}

/// What is made of a build's cake, or was: away from the threads that answer, one after the other, and kept also when nobody
/// waits for it any more.
pub(super) async fn of_cake<T: Clone + Send + 'static>(
    web: &Arc<Web>,
    build: &BuildRow,
    profile: &Profile,
    kept: Kept<T>,
    make: impl FnOnce(&Cake) -> anyhow::Result<T> + Send + 'static,
) -> Answer<T> {
    let known = || (kept.cache)(web).get(&kept.key);
    if let Some(thing) = known() {
        return Ok(thing);
    }
    let turn = web.looking.clone().acquire_owned().await.context("waiting for a turn")?;
    if let Some(thing) = known() {
        return Ok(thing);
    }
    let parts = standing(&web.ledger, build, profile).await?;
    let (web, build, profile) = (web.clone(), build.clone(), profile.clone());
    let making = tokio::task::spawn_blocking(move || {
        let _turn = turn;
        let thing = make(&Cake::of_ledger(&web.settings(), &profile, &build, parts))?;
        (kept.cache)(&web).put(kept.key, thing.clone());
        Ok(thing)
    });
    let made: anyhow::Result<T> = making.await.context("looking at the build")?;
    Ok(made?)
}

/// A text that is another one when something else stands in the build, or stands otherwise.
pub(super) fn version(build: &BuildRow) -> String {
    let layout = blake3::hash(build.kept.layout.as_deref().unwrap_or_default().as_bytes()).to_hex();
    format!("{}-{}-{}", build.id, build.state, &layout[..16])
}
