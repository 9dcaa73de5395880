//! The note of a claim beside its stored file: what was asked for. A restored ledger learns from it what it has
//! forgotten.

use std::{
    collections::{BTreeMap, HashMap},
    fs,
    path::Path,
};

use anyhow::{Context, Result};
use intake::{
    ClaimedPart, ContentStore, PartSpec, ReceivedTicket, SpecSource, StoredContent, StoredFile, Ticket, TicketError,
};
use ledger::{
    DroppedFile, Ledger, MEND_BY_TICKET, NewPartRow, NewTerms, NewTicketRow, PartRow, RequiredTilts, TicketSource,
};
use serde::{Deserialize, Serialize};
use settings::{MachineProfile, Settings};

use super::file_fault::FileTerms;
use crate::leases::{lease_holder::FarmIdentity, own_machines::without_other_nodes};

/// A note in the store.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ClaimNote {
    /// Id of the farm that claimed the file.
    pub farm: String,
    /// The row to record.
    pub part: NewPartRow,
    /// Why the number of copies is not known; `None` = it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unclear: Option<String>,
    /// Copies wanted of each solid of the file when something was last decided about it; none of a refused one.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub wanted: BTreeMap<u32, u32>,
    /// What else was asked for then, of a file of one solid; `None` = what the row says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub asked: Option<NewTerms>,
}

impl ClaimNote {
    /// The note of a claim; `unclear` = why the number of copies is not known.
    pub fn new(farm: &str, part: NewPartRow, unclear: Option<&TicketError>) -> Self {
        Self {
            farm: farm.to_owned(),
            part,
            unclear: unclear.map(ToString::to_string),
            wanted: BTreeMap::new(),
            asked: None,
        }
    }

    /// The row with what was asked last, where nothing else was decided about it.
    pub fn row_as_asked(&self, decisions: u32) -> NewPartRow {
        let mut row = self.part.clone();
        if let Some(asked) = &self.asked {
            row.terms = asked.clone();
            row.copies = self.wanted.get(&0).copied().filter(|_| decisions == 0).unwrap_or(row.copies);
        }
        row
    }

    /// The note of a part whose original was fetched from the archive.
    pub fn of_part(farm: &str, part: &PartRow) -> Self {
        let wanted = BTreeMap::from([(part.solid.object_index, part.wanted_copies())]);
        let part = NewPartRow {
            claim: part.file.claim.clone(),
            machine: part.machine.clone(),
            name: part.name.clone(),
            content_hash: part.file.content_hash.clone(),
            bytes: part.file.bytes,
            copies: part.wanted_copies(),
            terms: terms_of(part),
            warnings: part.warnings.lines().map(str::to_owned).collect(),
            ticket: None,
            dropped: DroppedFile::default(),
        };
        Self { farm: farm.to_owned(), part, unclear: None, wanted, asked: None }
    }

    /// The note of a claim beside its stored file; `None` = there is none, or it cannot be read.
    pub fn read(store: &ContentStore, hash: &str, claim: &str) -> Option<Self> {
        serde_json::from_str(&fs::read_to_string(store.note_path(hash, claim).ok()?).ok()?).ok()
    }

    /// The text of the file in the store.
    pub fn to_text(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }
}

/// A stored file, or a claim of one, that the ledger does not know.
#[derive(Debug, Clone, PartialEq)]
pub struct ForgottenFile {
    /// BLAKE3 of the file.
    pub hash: String,
    /// The claim; `None` = there is no note of it.
    pub claim: Option<String>,
    /// Its note; `None` = there is none, or it cannot be read.
    pub note: Option<ClaimNote>,
    /// Whether the stored file is there.
    pub is_stored: bool,
    /// Whether its original is still claimed in the hot folder: the daemon takes it from there.
    pub is_in_work: bool,
    /// How often it was refused, cancelled or taken back, as counted in its note.
    pub decisions: u32,
}

impl ForgottenFile {
    /// The name that people know.
    pub fn display_name(&self) -> String {
        match &self.note {
            Some(ClaimNote { part, .. }) if part.terms.order_name.is_empty() => part.name.clone(),
            Some(ClaimNote { part, .. }) => format!("{}/{}", part.terms.order_name, part.name),
            None => format!("the file with the BLAKE3 {}", self.hash),
        }
    }
}

/// Everything in the store, by hash. Call this before querying the ledger, which may then know more, but never less.
///
/// # Errors
/// The store cannot be read.
pub fn list_stored_files(settings: &Settings) -> Result<BTreeMap<String, StoredContent>> {
    let dir = settings.state_dir.join("store");
    ContentStore::from_dir(dir.clone()).list_contents().with_context(|| format!("listing {}", dir.display()))
}

/// The stored files and claims that have no row and are not just being claimed. A claim in a hot folder whose note counts decisions had
/// its row when they were made: it would be recorded once more, and what was refused or cancelled would be printed.
///
/// # Errors
/// A note, a hot folder or the ledger cannot be read.
pub async fn find_forgotten_files(
    settings: &Settings,
    ledger: &Ledger,
    kept: &BTreeMap<String, StoredContent>,
) -> Result<Vec<ForgottenFile>> {
    let store = ContentStore::from_dir(settings.state_dir.join("store"));
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
    let own = without_other_nodes(settings, ledger).await?;
    let in_work = ClaimsInWork::list(settings, &own, !nameless.is_empty())?;
    // A claim that was released between the two queries has its row by now.
    unknown = ledger.unknown_claims(&unknown).await?;
    nameless = ledger.unknown_contents(&nameless).await?;
    unknown.retain(|claim| !in_work.taken_over.contains(claim));
    nameless.retain(|hash| !in_work.hashes.contains(hash));
    unknown.sort();
    let mut found = Vec::new();
    for claim in unknown {
        let Some((hash, is_stored, decisions)) = by_claim.remove(&claim) else { continue };
        let is_in_work = in_work.whole.contains(&claim);
        if decisions == 0 && (is_in_work || in_work.unfinished.contains(&claim)) {
            continue;
        }
        let text = match fs::read_to_string(store.note_path(&hash, &claim)?) {
            // Its content was built or forgotten meanwhile.
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => continue,
            other => other.with_context(|| format!("reading the note of the claim {claim}"))?,
        };
        // A note that a power cut left empty says nothing, and is reported.
        let note = serde_json::from_str::<ClaimNote>(&text).ok();
        let note = note.filter(|note| note.part.claim == claim && note.part.content_hash == hash);
        found.push(ForgottenFile { hash, claim: Some(claim), note, is_stored, is_in_work, decisions });
    }
    let without_note =
        |hash| ForgottenFile { hash, claim: None, note: None, is_stored: true, is_in_work: false, decisions: 0 };
    found.extend(nameless.into_iter().map(without_note));
    Ok(found)
}

/// The claims in the hot folders.
#[derive(Default)]
struct ClaimsInWork {
    whole: Vec<String>,
    /// Those that are being created or removed.
    unfinished: Vec<String>,
    /// Those that another farm has in its ledger.
    taken_over: Vec<String>,
    /// BLAKE3 of their files, if asked for.
    hashes: Vec<String>,
}

impl ClaimsInWork {
    /// Lists them, also in the hot folders of other nodes' machines, as far as they can be read here: such a machine was perhaps this
    /// node's when the file was claimed. `own` = the machines of this node.
    fn list(settings: &Settings, own: &Settings, with_hashes: bool) -> Result<Self> {
        let mut found = Self { taken_over: claims_taken_over(own)?, ..Self::default() };
        for (name, profile) in &settings.profiles {
            let inbox = &profile.folders.inbox;
            let work = match intake::list_claims(inbox) {
                Err(_) if !own.profiles.contains_key(name) => continue,
                other => other.with_context(|| format!("listing {}", inbox.join(".claimed").display()))?,
            };
            for claim in work.claims {
                if with_hashes {
                    found.hashes.extend(intake::hash_file(&claim.part).ok());
                }
                found.whole.push(claim.id);
            }
            found.unfinished.extend(work.unfinished.iter().filter_map(|dir| claim_id(dir)));
        }
        Ok(found)
    }
}

/// The claims of this farm that another farm has taken over.
fn claims_taken_over(settings: &Settings) -> Result<Vec<String>> {
    let Ok(Some(farm)) = FarmIdentity::read(&settings.state_dir) else { return Ok(Vec::new()) };
    let mut claims = Vec::new();
    for profile in settings.profiles.values() {
        let inbox = &profile.folders.inbox;
        let found = intake::taken_over_claims(inbox, &farm.id);
        claims.extend(found.with_context(|| format!("listing {}", inbox.join(".claimed").display()))?);
    }
    Ok(claims)
}

/// Removes the stored files and notes of claims that another farm has taken over before they had a row here.
///
/// # Errors
/// The store, a hot folder or the ledger cannot be read, or the store cannot be changed.
pub async fn drop_taken_over_claims(settings: &Settings, ledger: &Ledger, store: &ContentStore) -> Result<()> {
    let unknown = ledger.unknown_claims(&claims_taken_over(settings)?).await?;
    if unknown.is_empty() {
        return Ok(());
    }
    for (hash, kept) in store.list_contents()? {
        let gone: Vec<&String> = kept.claims.keys().filter(|claim| unknown.contains(claim)).collect();
        if gone.is_empty() {
            continue;
        }
        for claim in &gone {
            store.delete_note(&hash, claim)?;
        }
        if gone.len() == kept.claims.len() && !ledger.unknown_contents(std::slice::from_ref(&hash)).await?.is_empty() {
            store.remove_content(&hash)?;
        }
    }
    Ok(())
}

/// The id of a claim that is being created or removed.
fn claim_id(dir: &Path) -> Option<String> {
    Some(intake::claim_id(dir.file_name()?.to_str()?).to_owned())
}

/// What is asked for with a part.
pub(crate) fn terms_of(part: &PartRow) -> NewTerms {
    NewTerms {
        order_name: part.terms.order_name.clone(),
        customer: part.terms.customer.clone(),
        email: part.terms.email.clone(),
        material: part.terms.material.clone(),
        finish: part.terms.finish.clone(),
        priority: part.terms.priority,
        due_at: part.terms.due_at.map(|at| at.0),
        due_text: part.terms.due_text.clone(),
        orientation: part.terms.orientation,
        tilts: part.terms.tilts.clone(),
        clearance_mm: part.terms.clearance_mm,
        unit: part.terms.unit,
        read_unit: part.measures.read_unit,
        note: part.terms.note.clone(),
        mend_allowed_by: part.mending.mend_allowed_by.clone(),
    }
}

/// The row of a claimed part.
pub(crate) fn new_part_row(
    profile: &MachineProfile,
    claim: &ClaimedPart,
    stored: &StoredFile,
    part_spec: Option<&PartSpec>,
) -> NewPartRow {
    let ticket = part_spec.map(|g| g.ticket.clone()).unwrap_or_default();
    let mut warnings = part_spec.map(|g| g.warnings.clone()).unwrap_or_default();
    let source = part_spec.and_then(|g| g.sources.first()).map(ticket_row);
    let order_name = ticket.order.clone().unwrap_or_else(|| order_of_claim(claim));
    let dropped = DroppedFile {
        folder: claim.order.clone(),
        mtime_ns: claim.dropped_mtime_ns(),
        rewrites: part_spec.and_then(|given| given.rewrites.clone()),
    };
    let (copies, terms, undated) = new_terms(profile, ticket, order_name);
    warnings.extend(undated);
    NewPartRow {
        claim: claim.id.clone(),
        machine: profile.name.clone(),
        name: claim.display_name(),
        content_hash: stored.hash.clone(),
        bytes: stored.bytes,
        copies,
        terms,
        warnings,
        ticket: source,
        dropped,
    }
}

/// The copies and terms that a ticket asks for, and a warning if its due date is none.
pub(crate) fn new_terms(
    profile: &MachineProfile,
    ticket: Ticket,
    order_name: String,
) -> (u32, NewTerms, Option<String>) {
    let (due_at, undated) = match ticket.due.map(|due| due.to_timestamp(profile.time_zone.time_zone())) {
        Some(Ok(at)) => (Some(at), None),
        Some(Err(error)) => (None, Some(format!("Its due date is no date here: {error}."))),
        None => (None, None),
    };
    let FileTerms { limits, unit, read_unit, copies, part: _ } = FileTerms::of_ticket(&ticket, profile);
    let terms = NewTerms {
        order_name,
        customer: ticket.customer.unwrap_or_default(),
        email: ticket.email.unwrap_or_default(),
        material: profile.materials.name_of(&ticket.material.unwrap_or_default()),
        finish: ticket.finish.unwrap_or_default(),
        priority: ticket.priority.unwrap_or(50),
        due_at,
        due_text: ticket.due.map(|due| due.to_string()).unwrap_or_default(),
        orientation: limits.rule,
        tilts: RequiredTilts(limits.tilts),
        clearance_mm: ticket.clearance_mm,
        unit,
        read_unit: Some(read_unit),
        note: ticket.note.unwrap_or_default(),
        mend_allowed_by: if ticket.mend == Some(true) { MEND_BY_TICKET.to_owned() } else { String::new() },
    };
    (copies, terms, undated)
}

/// A ticket as the ledger keeps it.
pub(crate) fn ticket_row(received: &ReceivedTicket) -> NewTicketRow {
    NewTicketRow {
        source: match received.source {
            SpecSource::Name => TicketSource::Name,
            SpecSource::Sidecar => TicketSource::Sidecar,
            SpecSource::OrderList => TicketSource::OrderList,
        },
        file_name: received.file_name.clone(),
        text: received.text.clone(),
    }
}

/// The order of a claim: its folder, or else its package.
fn order_of_claim(claim: &ClaimedPart) -> String {
    let is_package = build_file::is_camspec_name(&claim.name.to_string_lossy());
    match Path::new(&claim.name).file_stem().filter(|_| claim.order.is_empty() && is_package) {
        Some(stem) => intake::display_name(stem),
        None => claim.order.clone(),
    }
}
