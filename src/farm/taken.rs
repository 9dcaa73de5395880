//! What was asked of a claim, as it is noted beside its stored file: a ledger that went back in time learns from it what it
//! forgot.

use std::{
    collections::{BTreeMap, HashMap},
    fs,
    path::Path,
};

use anyhow::{Context, Result};
use jiff::tz::TimeZone;
use nester::Orientation;
use serde::{Deserialize, Serialize};

use crate::{
    intake::{self, Claim, Given, Kept, Source, Store, Stored, TicketError},
    ledger::{Ledger, NewPart, NewTerms, NewTicket, TicketSource, Tilts},
    settings::{Profile, Settings},
};

/// A note as it lies in the store.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Taken {
    /// Number of the farm that took it.
    pub farm: String,
    /// Its row as it was to be recorded.
    pub part: NewPart,
    /// Why its copies are not known; `None` = they are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unclear: Option<String>,
}

impl Taken {
    /// The note of a claim; `unclear` = why nobody knows how many copies were meant.
    pub fn of(farm: &str, part: NewPart, unclear: Option<&TicketError>) -> Self {
        Self { farm: farm.to_owned(), part, unclear: unclear.map(ToString::to_string) }
    }

    /// As it lies in the store.
    pub fn to_text(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }
}

/// A stored file, or a claim of one, that the ledger does not know.
#[derive(Debug, Clone, PartialEq)]
pub struct Forgotten {
    /// BLAKE3 of the file.
    pub hash: String,
    /// The claim; `None` = nothing is noted of it.
    pub claim: Option<String>,
    /// What its note says; `None` = there is none, or it cannot be read.
    pub taken: Option<Taken>,
    /// Whether its bytes are there.
    pub is_stored: bool,
    /// How often it was refused, cancelled or taken back, by its note.
    pub decisions: u32,
}

impl Forgotten {
    /// How people know it.
    pub fn name(&self) -> String {
        match &self.taken {
            Some(Taken { part, .. }) if part.terms.order_name.is_empty() => part.name.clone(),
            Some(Taken { part, .. }) => format!("{}/{}", part.terms.order_name, part.name),
            None => format!("the file with the BLAKE3 {}", self.hash),
        }
    }
}

/// All that lies in the store, by hash. It is asked for before the ledger, which may then know more, and never less.
///
/// # Errors
/// The store cannot be read.
pub fn kept(settings: &Settings) -> Result<BTreeMap<String, Kept>> {
    let dir = settings.state_dir.join("store");
    Store::at(dir.clone()).kept().with_context(|| format!("listing {}", dir.display()))
}

/// What of this has no row, and is not just being taken.
///
/// # Errors
/// A note, a hot folder or the ledger cannot be read.
pub async fn forgotten(settings: &Settings, ledger: &Ledger, kept: &BTreeMap<String, Kept>) -> Result<Vec<Forgotten>> {
    let store = Store::at(settings.state_dir.join("store"));
    let (mut by_claim, mut contents) = (HashMap::new(), Vec::new());
    for (hash, kept) in kept {
        for (claim, decisions) in &kept.claims {
            by_claim.insert(claim.clone(), (hash.clone(), kept.is_stored, *decisions));
        }
        if kept.claims.is_empty() {
            contents.push(hash.clone());
        }
    }
    let claims: Vec<String> = by_claim.keys().cloned().collect();
    let mut unknown = ledger.unknown_claims(&claims).await?;
    let mut nameless = ledger.unknown_contents(&contents).await?;
    if unknown.is_empty() && nameless.is_empty() {
        return Ok(Vec::new());
    }
    let (in_work, hashes) = in_work(settings, !nameless.is_empty())?;
    // A claim that is let go between the two looks has its row by now.
    unknown = ledger.unknown_claims(&unknown).await?;
    nameless = ledger.unknown_contents(&nameless).await?;
    unknown.retain(|claim| !in_work.contains(claim));
    nameless.retain(|hash| !hashes.contains(hash));
    unknown.sort();
    let mut found = Vec::new();
    for claim in unknown {
        let Some((hash, is_stored, decisions)) = by_claim.remove(&claim) else { continue };
        let text = match fs::read_to_string(store.note_path(&hash, &claim)?) {
            // Its content was built or forgotten meanwhile.
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => continue,
            other => other.with_context(|| format!("reading the note of the claim {claim}"))?,
        };
        // A note that a power cut left empty tells nothing, and is told.
        let taken = serde_json::from_str::<Taken>(&text).ok();
        let taken = taken.filter(|taken| taken.part.claim == claim && taken.part.content_hash == hash);
        found.push(Forgotten { hash, claim: Some(claim), taken, is_stored, decisions });
    }
    let without_note = |hash| Forgotten { hash, claim: None, taken: None, is_stored: true, decisions: 0 };
    found.extend(nameless.into_iter().map(without_note));
    Ok(found)
}

/// The claims that stand in the hot folders, and, where asked, the BLAKE3 of their files.
fn in_work(settings: &Settings, with_hashes: bool) -> Result<(Vec<String>, Vec<String>)> {
    let (mut claims, mut hashes) = (Vec::new(), Vec::new());
    for profile in settings.profiles.values() {
        let inbox = &profile.folders.inbox;
        let work = intake::work(inbox).with_context(|| format!("listing {}", inbox.join(".claimed").display()))?;
        for claim in work.claims {
            if with_hashes {
                hashes.extend(intake::hash_file(&claim.part).ok());
            }
            claims.push(claim.id);
        }
        claims.extend(work.unfinished.iter().filter_map(|dir| id_of(dir)));
    }
    // The other farm knows them.
    claims.extend(taken_over(settings)?);
    Ok((claims, hashes))
}

/// The claims of this farm that another one has taken over.
fn taken_over(settings: &Settings) -> Result<Vec<String>> {
    let farm = fs::read_to_string(settings.state_dir.join(super::owner::FARM)).unwrap_or_default();
    let mut claims = Vec::new();
    for profile in settings.profiles.values().filter(|_| !farm.trim().is_empty()) {
        let inbox = &profile.folders.inbox;
        let found = intake::taken_over(inbox, farm.trim());
        claims.extend(found.with_context(|| format!("listing {}", inbox.join(".claimed").display()))?);
    }
    Ok(claims)
}

/// Drops what is stored of claims that another farm has taken over before they had a row here.
///
/// # Errors
/// The store, a hot folder or the ledger cannot be read, or the store not be changed.
pub async fn drop_taken_over(settings: &Settings, ledger: &Ledger, store: &Store) -> Result<()> {
    let unknown = ledger.unknown_claims(&taken_over(settings)?).await?;
    if unknown.is_empty() {
        return Ok(());
    }
    for (hash, kept) in store.kept()? {
        let gone: Vec<&String> = kept.claims.keys().filter(|claim| unknown.contains(claim)).collect();
        if gone.is_empty() {
            continue;
        }
        for claim in &gone {
            store.forget_note(&hash, claim)?;
        }
        if gone.len() == kept.claims.len() && !ledger.unknown_contents(std::slice::from_ref(&hash)).await?.is_empty() {
            store.remove(&hash)?;
        }
    }
    Ok(())
}

/// The id of a claim that is being put together or taken apart.
fn id_of(dir: &Path) -> Option<String> {
    Some(intake::claim_id(dir.file_name()?.to_str()?).to_owned())
}

/// The row of a claimed part.
pub(super) fn new_part(profile: &Profile, claim: &Claim, stored: &Stored, given: Option<&Given>) -> NewPart {
    let ticket = given.map(|g| g.ticket.clone()).unwrap_or_default();
    let mut warnings = given.map(|g| g.warnings.clone()).unwrap_or_default();
    let due_at = ticket.due.and_then(|due| match due.at(&TimeZone::system()) {
        Ok(at) => Some(at),
        Err(error) => {
            warnings.push(format!("Its due date is no date here: {error}."));
            None
        }
    });
    let source = given.and_then(|g| g.sources.first()).map(|s| NewTicket {
        source: match s.source {
            Source::Name => TicketSource::Name,
            Source::Sidecar => TicketSource::Sidecar,
            Source::OrderList => TicketSource::OrderList,
        },
        file_name: s.file_name.clone(),
        text: s.text.clone(),
    });
    let orientation = Orientation::new(
        ticket.orientation.unwrap_or(profile.turning.orientation),
        ticket.keep_up.as_deref().unwrap_or(&profile.turning.keep_up),
        ticket.not_down.as_deref().unwrap_or(&profile.turning.not_down),
    );
    NewPart {
        claim: claim.id.clone(),
        profile: profile.name.clone(),
        name: claim.display_name(),
        content_hash: stored.hash.clone(),
        bytes: stored.bytes,
        copies: ticket.copies.unwrap_or(1),
        terms: NewTerms {
            order_name: ticket.order.unwrap_or_else(|| claim.order.clone()),
            priority: ticket.priority.unwrap_or(50),
            due_at,
            orientation: orientation.rule,
            tilts: Tilts(orientation.tilts),
            clearance_mm: ticket.clearance_mm,
            unit: ticket.unit,
            note: ticket.note.unwrap_or_default(),
        },
        warnings,
        ticket: source,
    }
}
