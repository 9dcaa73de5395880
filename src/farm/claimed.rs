//! The event loop's side of "claimed" and "read": rows for what was claimed, and what becomes of it once it is read.

use std::{
    sync::Arc,
    time::{Duration, Instant},
};

use anyhow::{Context, Result};
use jiff::{Timestamp, tz::TimeZone};
use tracing::{info, warn};

use super::{
    attention::Attention,
    event::Event,
    farm::Farm,
    jobs::JobKey,
    read::{ReadOutcome, read_part},
    receive::{Drop, Gate, Received},
};
use crate::{
    intake::{self, Claim, Given, Released, Source, Stored},
    ledger::{NewPart, NewTicket, PartId, PartRow, PartState, Refusal, TicketSource, Tilts, Utc},
    nest::Orientation,
    settings::{Duplicates, Profile},
};

/// Files that are read at once.
const READERS: usize = 2;
/// A look that follows a file-system event waits this long, so that a burst of events is one look.
const LOOK_AFTER_EVENT: Duration = Duration::from_millis(200);

/// Said of a part whose ticket could not be read; it cannot be taken back, for its copies would be guessed.
pub(super) const COPIES_UNKNOWN: &str = "Its copies are not known, so it is not printed";

impl Farm {
    /// Something changed: look soon.
    pub(super) fn look_soon(&mut self) {
        let soon = Instant::now() + LOOK_AFTER_EVENT;
        self.stations.values_mut().for_each(|s| s.look_at = s.look_at.min(soon));
    }

    /// Starts a look through every hot folder whose time has come.
    pub(super) fn receive(&mut self) {
        let orphan_secs = self.settings.orphan_ticket_secs;
        for (name, station) in &mut self.stations {
            if Instant::now() < station.look_at || self.jobs.runs(&JobKey::Receive(name.clone())) {
                continue;
            }
            let Some(mut gate) = station.gate.take() else { continue };
            let (profile, store) = (station.profile.clone(), self.meshes.store.clone());
            let mut hold = station.holds.inbox.clone();
            let (name, status) = (name.clone(), station.told(&self.notices));
            self.jobs.start(JobKey::Receive(name.clone()), move || {
                let mut received = gate.look(&profile, &mut hold, &store, orphan_secs);
                if status.1.is_empty() || received.unavailable.is_some() {
                    return Event::Received { profile: name, gate, received };
                }
                if let Err(failure) = intake::write_status(&profile.folders.inbox, &status.0, &status.1) {
                    received.troubles.push(format!("writing STATUS.txt: {failure}"));
                }
                Event::Received { profile: name, gate, received }
            });
        }
    }

    /// Takes in a look: each claimed part gets its row, and is read. What cannot be recorded now is tried at the next look.
    pub(super) async fn on_received(&mut self, name: &str, mut gate: Box<Gate>, received: Received) -> Result<()> {
        self.jobs.ended(&JobKey::Receive(name.to_owned()));
        for drop in received.drops {
            if let Err(failure) = self.record(name, &drop).await {
                self.trouble(Attention::TakingFails, name, "recording a drop", &failure);
                gate.take_back(drop.claim);
            }
        }
        let scan_secs = self.settings.scan_secs;
        if let Some(station) = self.stations.get_mut(name) {
            if gate.is_of(&station.profile) {
                station.gate = Some(gate);
            }
            let next_secs = received.next_secs.unwrap_or(scan_secs).clamp(0.05, scan_secs);
            station.look_at = Instant::now() + Duration::from_secs_f64(next_secs);
            station.refused_kept = received.refused_kept.unwrap_or(station.refused_kept);
            let error_dir = station.profile.folders.error.display();
            match station.refused_kept {
                0 => self.notices.clear(Attention::Refused, name, ""),
                1 => self.notices.raise(Attention::Refused, name, "", &format!("1 file in {error_dir}")),
                files => self.notices.raise(Attention::Refused, name, "", &format!("{files} files in {error_dir}")),
            }
        }
        match &received.unavailable {
            Some(why) => self.notices.raise(Attention::HotFolderAway, name, "", why),
            None => self.looked_through(name),
        }
        if let Some(trouble) = received.troubles.first() {
            let more = received.troubles.len() - 1;
            let more = if more > 0 { format!(", and {more} more") } else { String::new() };
            self.notices.trouble(Attention::TakingFails, name, "", &format!("{trouble}{more}"));
        }
        for (file, cause, reason) in &received.refused {
            warn!(profile = %name, "Refused {file} in {name}: {reason}");
            self.ledger.file_refused(name, *cause, &format!("{file}: {reason}")).await?;
        }
        Ok(())
    }

    /// A hot folder is there and was looked through.
    fn looked_through(&mut self, name: &str) {
        self.notices.clear(Attention::HotFolderAway, name, "");
        if let Some(station) = self.stations.get_mut(name) {
            station.scanned_at = Some(Utc(Timestamp::now()));
        }
    }

    /// The row of a claimed part; an earlier run may have written it already.
    async fn record(&mut self, name: &str, drop: &Drop) -> Result<()> {
        let Some(profile) = self.stations.get(name).map(|s| s.profile.clone()) else { return Ok(()) };
        let Drop { claim, stored, given } = drop;
        let row = new_part(&profile, claim, stored, given.as_ref().ok());
        let recorded = self.ledger.record_claim(&row).await?;
        // Between the copy and the row, the end of an earlier part of the same content may have taken the copy away.
        if !self.meshes.store.path(&stored.hash)?.exists() {
            self.meshes.store.put_claimed(claim)?;
        }
        let part = self.ledger.part(recorded.id).await?.context("a recorded part has no row")?;
        if part.content_hash != stored.hash {
            // It was written to after its row was committed, and then nestd crashed: a new revision.
            intake::give_back(claim)?;
            return Ok(());
        }
        self.claims.insert(claim.id.clone(), claim.clone());
        match (part.state, given) {
            (PartState::Claimed, Err(error)) => {
                let reason = format!("{error}. {COPIES_UNKNOWN}: mend the ticket and drop both again.");
                self.refuse(&part, Refusal::Ticket, &reason).await
            }
            _ => self.settle_claim(&part),
        }
    }

    /// Ends the claims of parts that were read or refused; what failed earlier (an error folder that could not be
    /// written to) is tried again.
    pub(super) async fn settle_claims(&mut self) -> Result<()> {
        for claim in self.claims.keys().cloned().collect::<Vec<_>>() {
            let parts = self.ledger.parts_of_claim(&claim).await?;
            let Some(part) = parts.first() else { continue };
            if let Err(failure) = self.settle_claim(part) {
                let (part, profile) = (part.name.clone(), part.profile.clone());
                self.trouble(Attention::EndingFails, &profile, &part, &failure);
            }
        }
        Ok(())
    }

    fn settle_claim(&mut self, part: &PartRow) -> Result<()> {
        match part.state {
            PartState::Claimed => Ok(()),
            PartState::Rejected => self.put_into_error(part, &part.reason),
            // It was read: only its original is left to let go.
            _ => self.let_go(part),
        }
    }

    /// Starts reading claimed parts.
    pub(super) async fn read(&mut self) -> Result<()> {
        let profiles: Vec<Arc<Profile>> = self.stations.values().map(|s| s.profile.clone()).collect();
        // Each time another machine comes first, so that none waits for the end of another one's line.
        self.reads_begun = self.reads_begun.wrapping_add(1);
        for at in 0..profiles.len() {
            let profile = &profiles[(self.reads_begun + at) % profiles.len()];
            let reading = self.jobs.count(|key| matches!(key, JobKey::Read(_)));
            if reading >= READERS {
                break;
            }
            let parts = self.ledger.claimed_parts(&profile.name, READERS + reading + self.read_again.len()).await?;
            parts.into_iter().for_each(|part| self.begin_read(part, profile));
        }
        Ok(())
    }

    fn begin_read(&mut self, part: PartRow, profile: &Arc<Profile>) {
        let waits = self.read_again.rests(&part.id);
        let is_full = self.jobs.count(|key| matches!(key, JobKey::Read(_))) >= READERS;
        if waits || is_full || self.jobs.runs(&JobKey::Read(part.id)) {
            return;
        }
        let (profile, meshes) = (profile.clone(), self.meshes.clone());
        self.jobs.start(JobKey::Read(part.id), move || Event::Read {
            part: part.id,
            outcome: read_part(&part, &profile, &meshes),
        });
    }

    /// Takes in what a reader found.
    pub(super) async fn on_read(&mut self, id: PartId, outcome: ReadOutcome) -> Result<()> {
        self.jobs.ended(&JobKey::Read(id));
        let part = self.ledger.part(id).await?.context("a part that was read has no row")?;
        if part.state != PartState::Claimed {
            return Ok(());
        }
        match outcome {
            ReadOutcome::Solids(mut solids) => {
                if let Some(warning) = match self.duplicate_of(&part).await? {
                    Some((earlier, Duplicates::Reject)) => {
                        let reason =
                            format!("It is the same file as part {earlier}, and this profile takes no file twice.");
                        return self.refuse(&part, Refusal::Duplicate, &reason).await;
                    }
                    Some((earlier, Duplicates::Warn)) => {
                        Some(format!("The same file as part {earlier}: taken as more copies."))
                    }
                    _ => None,
                } {
                    solids[0].warnings.push(warning);
                }
                // Before it waits: a crash after must not leave its file in two places.
                if let Err(failure) = self.tidy_error_folder(&part).await {
                    self.read_again.failed(id);
                    return Err(
                        failure.context(format!("removing what was refused of part {id} from the error folder"))
                    );
                }
                let ids = self.ledger.accept(id, &solids).await?;
                let copies: u32 = solids.iter().map(|s| s.copies).sum();
                let parts = ids.len();
                info!(part.id = %id, profile = %part.profile, "{} waits in {}: {parts} parts, {copies} copies.", part.name, part.profile);
                self.let_go(&part)
            }
            ReadOutcome::Refused(cause, reason) => self.refuse(&part, cause, &reason).await,
            ReadOutcome::Later(why) => {
                self.read_again.failed(id);
                let about = format!("part {id} ({})", part.name);
                self.notices.trouble(Attention::ReadingFails, &part.profile, &about, &format!("{about}: {why}"));
                Ok(())
            }
        }
    }

    async fn duplicate_of(&self, part: &PartRow) -> Result<Option<(PartId, Duplicates)>> {
        let Some(station) = self.stations.get(&part.profile) else { return Ok(None) };
        let earlier = self.ledger.earlier_with_hash(&part.profile, &part.content_hash, part.id).await?;
        Ok(earlier.map(|earlier| (earlier, station.profile.duplicates)))
    }

    /// claimed -> rejected, then the file goes into the error folder; a crash between is caught up by `record`.
    async fn refuse(&mut self, part: &PartRow, cause: Refusal, reason: &str) -> Result<()> {
        warn!(part.id = %part.id, profile = %part.profile, "Refused {} in {}: {reason}", part.name, part.profile);
        self.ledger.reject(part.id, cause, reason).await?;
        self.put_into_error(part, reason)
    }

    fn put_into_error(&mut self, part: &PartRow, reason: &str) -> Result<()> {
        self.read_again.done(&part.id);
        let Some(station) = self.stations.get(&part.profile) else { return Ok(()) };
        let folders = &station.profile.folders;
        let Some(claim) = self.claims.get(&part.claim) else {
            // One that was taken back and is refused again; a claim that is still to be found brings its original itself.
            let is_in_work = intake::claim_dir(&folders.inbox, &part.claim).exists();
            return if is_in_work { Ok(()) } else { self.copy_into_error(part, reason) };
        };
        intake::refuse(claim, &folders.error, &reason_text(part, reason))?;
        self.claims.remove(&part.claim);
        Ok(())
    }

    /// Lets the claimed original go: the store has it, and its row is committed.
    fn let_go(&mut self, part: &PartRow) -> Result<()> {
        self.read_again.done(&part.id);
        let Some(claim) = self.claims.get(&part.claim) else { return Ok(()) };
        if let Released::GivenBack(path) = intake::release(claim)? {
            let file = path.display();
            warn!("{file} was written to after it was claimed; it is taken again as a new revision.");
        }
        self.claims.remove(&part.claim);
        Ok(())
    }

    /// After a successful retry the refused file and its reason have no business in the error folder any more.
    async fn tidy_error_folder(&self, part: &PartRow) -> Result<()> {
        match self.stations.get(&part.profile) {
            Some(station) if self.ledger.was_rejected(part.id).await? => {
                super::tidy::remove_refused(&station.profile.folders.error, part)
            }
            _ => Ok(()),
        }
    }
}

/// What a refused part's reason says below the reason itself.
pub(super) fn reason_text(part: &PartRow, reason: &str) -> String {
    let again = match reason.contains(COPIES_UNKNOWN) {
        true => String::new(),
        false => format!(" To take it back: nestd retry {}", part.id),
    };
    format!("{}\n\n{}{again}\n", reason.trim_end(), super::tidy::part_line(part))
}

fn new_part(profile: &Profile, claim: &Claim, stored: &Stored, given: Option<&Given>) -> NewPart {
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
        ticket.orientation.unwrap_or(profile.orientation),
        ticket.keep_up.as_deref().unwrap_or(&profile.keep_up),
        ticket.not_down.as_deref().unwrap_or(&profile.not_down),
    );
    NewPart {
        claim: claim.id.clone(),
        profile: profile.name.clone(),
        name: claim.display_name(),
        order_name: ticket.order.unwrap_or_else(|| claim.order.clone()),
        content_hash: stored.hash.clone(),
        bytes: stored.bytes,
        copies: ticket.copies.unwrap_or(1),
        priority: ticket.priority.unwrap_or(50),
        due_at,
        orientation: orientation.rule,
        tilts: Tilts(orientation.tilts),
        clearance_mm: ticket.clearance_mm,
        unit: ticket.unit,
        note: ticket.note.unwrap_or_default(),
        warnings,
        ticket: source,
    }
}
