//! Whether the ledger knows all that the folders tell: demanded at the start, at every reload and when a folder comes back. A
//! ledger that went back in time would print parts twice, or never.

use std::{
    collections::{HashMap, HashSet},
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
    time::Duration,
};

use anyhow::{Context, Result};

use super::{
    attention::Attention,
    decided,
    reconcile::unknown_builds,
    taken,
    told::{Away, Known},
};
use crate::{
    intake,
    ledger::Ledger,
    settings::{Profile, Settings},
};

/// The ledger is older than the folders.
#[derive(Debug, thiserror::Error)]
#[error("the ledger is older than the folders: {detail}. {}", Attention::LedgerBehind.remedy())]
pub struct Behind {
    /// What it does not know.
    pub detail: String,
}

/// What the folders tell and the ledger does not know, in words; folders that cannot be asked are left out and returned.
///
/// # Errors
/// The ledger or the store cannot be read.
pub async fn unknown(settings: &Settings, ledger: &Ledger) -> Result<(Vec<String>, Vec<Away>)> {
    let (mut told, mut away) = (Vec::new(), Vec::new());
    for profile in settings.profiles.values() {
        match unknown_to(settings, ledger, profile).await {
            Ok(names) => told.extend(names),
            Err(error) => away.push(error.downcast::<Away>()?),
        }
    }
    let kept = taken::kept(settings)?;
    let mut files = taken::forgotten(settings, ledger, &kept).await?;
    // What is just being taken stands in a hot folder; one that is away hides it.
    files.retain(|file| {
        let profile = file.taken.as_ref().and_then(|taken| settings.profiles.get(&taken.part.profile));
        profile.is_none_or(|profile| profile.folders.inbox.join(".claimed").is_dir())
    });
    told.extend(files.iter().map(|file| match &file.taken {
        Some(taken) => format!("{} ({} copies for {})", file.name(), taken.part.copies, taken.part.profile),
        None => file.name(),
    }));
    told.extend(decided::since(settings, ledger, &kept).await?.iter().map(decided::name));
    Ok((told, away))
}

/// The builds of a machine that the ledger does not know.
///
/// # Errors
/// [`Away`] where a folder cannot be asked; the ledger cannot be read.
pub async fn unknown_to(settings: &Settings, ledger: &Ledger, profile: &Profile) -> Result<Vec<String>> {
    // What was never made tells nothing: the folders of a new machine.
    let folders = &profile.folders;
    let mut new_folders = vec![folders.archive.clone(), folders.queue.clone()];
    new_folders.retain(|folder| !super::served::is_known(&settings.state_dir, folder));
    let known = Known { state_dir: settings.state_dir.clone(), new_folders };
    let builds = unknown_builds(settings, ledger, profile, &known, &mut HashSet::new()).await?;
    Ok(builds.into_iter().map(|build| build.name).collect())
}

/// A claim is taken, recorded and let go within seconds; what stands longer was left.
const LEFT_AFTER: Duration = Duration::from_secs(300);

/// Claims of which the ledger knows nothing, and half made ones, that no daemon will end before its next start.
///
/// # Errors
/// A hot folder or the ledger cannot be read.
pub async fn left_claims(settings: &Settings, ledger: &Ledger) -> Result<Vec<PathBuf>> {
    let (mut claims, mut left) = (HashMap::new(), Vec::new());
    for profile in settings.profiles.values() {
        let inbox = &profile.folders.inbox;
        let work = intake::work(inbox).with_context(|| format!("listing the claims in {}", inbox.display()))?;
        claims.extend(work.claims.into_iter().map(|claim| (claim.id.clone(), intake::claim_dir(inbox, &claim.id))));
        left.extend(work.unfinished);
    }
    let ids: Vec<String> = claims.keys().cloned().collect();
    left.extend(ledger.unknown_claims(&ids).await?.iter().filter_map(|id| claims.remove(id)));
    let is_old = |dir: &PathBuf| {
        let age = std::fs::metadata(dir).and_then(|meta| meta.modified()).map(|at| at.elapsed());
        // A time that is to come tells nothing of the age.
        age.is_ok_and(|age| age.map_or(true, |age| age >= LEFT_AFTER))
    };
    left.retain(is_old);
    left.sort();
    Ok(left)
}

/// Refuses to serve a farm whose ledger is older than its folders.
///
/// # Errors
/// [`Behind`], or the ledger cannot be read.
pub async fn demand_current(settings: &Settings, ledger: &Ledger) -> Result<()> {
    match detail(&unknown(settings, ledger).await?.0) {
        Some(detail) => Err(Behind { detail }.into()),
        None => Ok(()),
    }
}

/// The first of what the ledger does not know, and how much more; `None` = it knows all.
pub fn detail(unknown: &[String]) -> Option<String> {
    let first = unknown.first()?;
    let more = if unknown.len() > 1 { format!(" and {} more", unknown.len() - 1) } else { String::new() };
    Some(format!("it does not know {first}{more}"))
}

/// Device and inode of a machine's archive and queue when they were last held against the ledger.
pub type Seen = [(u64, u64); 2];

/// What came of holding a machine's folders against the ledger.
#[derive(Debug)]
pub enum Compared {
    /// They are the folders that agreed.
    AsBefore,
    /// The ledger knows all that they tell.
    Agrees(Seen),
    /// The ledger does not.
    Behind(String),
    /// They cannot be asked.
    Away(String),
}

/// Holds a machine's folders against the ledger, unless they are those that agreed.
pub(super) async fn compare(settings: &Settings, ledger: &Ledger, profile: &Profile, before: Option<Seen>) -> Compared {
    let identity = |folder: &Path| {
        let meta = std::fs::metadata(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        Ok::<_, String>((meta.dev(), meta.ino()))
    };
    let seen = identity(&profile.folders.archive).and_then(|a| Ok([a, identity(&profile.folders.queue)?]));
    let seen = match seen {
        Ok(seen) if before == Some(seen) => return Compared::AsBefore,
        Ok(seen) => seen,
        Err(why) => return Compared::Away(why),
    };
    let told = async {
        let mut told = unknown_to(settings, ledger, profile).await?;
        let kept = taken::kept(settings)?;
        let files = taken::forgotten(settings, ledger, &kept).await?;
        let is_of = |file: &taken::Forgotten| file.taken.as_ref().is_some_and(|t| t.part.profile == profile.name);
        told.extend(files.iter().filter(|file| is_of(file)).map(taken::Forgotten::name));
        let decided = decided::since(settings, ledger, &kept).await?;
        told.extend(decided.iter().filter(|claim| claim.profile == profile.name).map(decided::name));
        anyhow::Ok(told)
    };
    match told.await {
        Ok(told) => detail(&told).map_or(Compared::Agrees(seen), Compared::Behind),
        Err(error) => Compared::Away(format!("{error:#}")),
    }
}
