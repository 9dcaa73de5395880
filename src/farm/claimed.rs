//! The event loop's side of "claimed" and "read": rows for what was claimed, and what becomes of it once it is read.

use std::{sync::Arc, time::Duration};

use anyhow::{Context, Result};
use build_file::counted;
use tracing::{debug, info, warn};

use super::{
    attention::Attention,
    error_folder::{self, COPIES_UNKNOWN},
    farm::Farm,
    holds::Holds,
    jobs::Job,
    meshes::READS_IN_THE_DAEMON,
    read::{ReadOutcome, read_part},
    read_turn::{READERS, ReadTurn},
    receive::{Drop, Gate, Received},
    standing_claim::StandingClaim,
    taken::Taken,
    twins::TwinVerdict,
};
use crate::{
    intake::{self, TicketError},
    ledger::{NewPart, PartId, PartRow, PartState, Recorded, Refusal, Utc},
    settings::Profile,
};

/// A look that follows a file-system event waits this long, so that a burst of events is one look.
const LOOK_AFTER_EVENT: Duration = Duration::from_millis(200);

/// Looking through a profile's hot folder; gives the memory of the folder back, and what was found.
#[derive(Clone)]
pub(super) struct ReceiveJob {
    profile: String,
}

impl Job<Farm> for ReceiveJob {
    const KIND: &'static str = "Receive";
    type Outcome = (Box<Gate>, Received);

    fn about(&self) -> String {
        self.profile.clone()
    }

    async fn done(self, farm: &mut Farm, (gate, received): Self::Outcome) -> Result<()> {
        farm.on_received(&self.profile, gate, received).await
    }

    async fn panicked(self, farm: &mut Farm, _message: &str) -> Result<()> {
        farm.new_gate(&self.profile);
        Ok(())
    }

    fn not_started(self, farm: &mut Farm, _why: &str) {
        farm.new_gate(&self.profile);
    }
}

/// Reading a part's file.
#[derive(Clone)]
pub(super) struct ReadJob {
    part: PartId,
}

impl Job<Farm> for ReadJob {
    const KIND: &'static str = "Read";
    type Outcome = ReadOutcome;

    fn about(&self) -> String {
        self.part.to_string()
    }

    async fn done(self, farm: &mut Farm, outcome: Self::Outcome) -> Result<()> {
        farm.on_read(self.part, outcome).await
    }

    async fn panicked(self, farm: &mut Farm, message: &str) -> Result<()> {
        let reason = format!(
            "The reader failed on it: {message}. Export it again, as STL or 3MF; where that fails too, send it to nestd's makers."
        );
        farm.on_read(self.part, ReadOutcome::Refused(Refusal::Failure, reason)).await
    }

    fn not_started(self, farm: &mut Farm, _why: &str) {
        farm.reading.again.failed(self.part);
    }
}

impl Farm {
    /// Something changed: look soon.
    pub(super) fn look_soon(&mut self) {
        let soon = self.now() + LOOK_AFTER_EVENT;
        self.stations.values_mut().for_each(|s| s.inbox.look_at = s.inbox.look_at.min(soon));
    }

    /// Starts a look through every hot folder whose time has come.
    pub(super) fn receive(&mut self) {
        let (now, orphan_secs) = (self.now(), self.settings.orphan_ticket_secs);
        for (name, station) in &mut self.stations {
            if !station.may_take
                || !station.holds.are_fresh()
                || now < station.inbox.look_at
                || self.jobs.runs::<ReceiveJob>(name)
            {
                continue;
            }
            let Some(mut gate) = station.inbox.gate.take() else { continue };
            if std::mem::take(&mut station.inbox.relist) {
                gate.relist();
            }
            let (profile, store) = (station.profile.clone(), self.meshes.store.clone());
            let mut holds = station.holds.clone();
            let (name, status) = (name.clone(), station.told(&self.notices, self.settings.scan_secs));
            self.jobs.start(ReceiveJob { profile: name }, move || {
                let mut received = gate.look(&profile, &mut holds, &store, orphan_secs);
                // What is told is not written into an empty mount point that took the folder's place meanwhile.
                if status.1.is_empty() || received.unavailable.is_some() || holds.inbox.check().is_err() {
                    return (gate, received);
                }
                if let Err(failure) = intake::write_status(&profile.folders.inbox, &status.0, &status.1) {
                    received.troubles.push(format!("writing STATUS.txt: {failure}"));
                }
                (gate, received)
            });
        }
    }

    /// A hot folder is looked at by a gate that remembers nothing.
    fn new_gate(&mut self, name: &str) {
        let (now, scan_secs) = (self.now(), self.settings.scan_secs);
        if let Some(station) = self.stations.get_mut(name) {
            station.inbox.gate = Some(Box::new(Gate::new(
                &station.profile,
                self.settings.orphan_ticket_secs,
                self.schedule.time.clone(),
            )));
            station.inbox.look_at = now + Duration::from_secs_f64(scan_secs);
        }
    }

    /// Takes in a look: each claimed part gets its row, and is read. What cannot be recorded now is tried at the next look.
    async fn on_received(&mut self, name: &str, mut gate: Box<Gate>, mut received: Received) -> Result<()> {
        let (early, drops): (Vec<Drop>, Vec<Drop>) = std::mem::take(&mut received.drops)
            .into_iter()
            .partition(|drop| self.ending.forgetting.is_under_way(&drop.stored.hash));
        for drop in early {
            // Its stored copy is being removed, for it was an earlier part's: the next look copies it in again.
            gate.take_back(drop.claim);
            received.next_secs = Some(0.0);
        }
        let rows: Vec<&NewPart> = drops.iter().map(|drop| &drop.row).collect();
        // One change for all costs as much as one row. Where it fails, each is written by itself below, and told.
        let mut recorded = Vec::new();
        if rows.len() > 1 && self.stations.contains_key(name) {
            match self.ledger.record_claims(&rows).await {
                Ok(all) => recorded = all,
                Err(failure) => debug!("The rows of a look are written one by one: {failure}."),
            }
        }
        for (at, drop) in drops.into_iter().enumerate() {
            if let Err(failure) = self.record(name, &drop, recorded.get(at).copied()).await {
                self.trouble(Attention::TakingFails, name, "recording a drop", &failure);
                gate.take_back(drop.claim);
            }
        }
        let (now, scan_secs) = (self.now(), self.settings.scan_secs);
        if let Some(station) = self.stations.get_mut(name) {
            if gate.is_of(&station.profile) {
                station.inbox.gate = Some(gate);
            }
            let next_secs = received.next_secs.unwrap_or(scan_secs).clamp(0.05, scan_secs);
            station.inbox.look_at = now + Duration::from_secs_f64(next_secs);
            station.inbox.refused_kept = received.refused_kept.unwrap_or(station.inbox.refused_kept);
            let error_dir = station.profile.folders.error.display();
            match received.is_cut || received.unavailable.is_some() {
                true => {}
                false if received.held.is_empty() => self.notices.clear(Attention::Incomplete, name, ""),
                false => self.notices.raise(Attention::Incomplete, name, "", &few(&received.held)),
            }
            match station.inbox.refused_kept {
                0 => self.notices.clear(Attention::Refused, name, ""),
                files => {
                    let detail = format!("{} in {error_dir}", counted(files, "file", "files"));
                    self.notices.raise(Attention::Refused, name, "", &detail);
                }
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
        let date = self.date();
        if let Some(station) = self.stations.get_mut(name) {
            station.inbox.scanned_at = Some(Utc(date));
        }
    }

    /// The row of a claimed part; an earlier run or the change for the whole look may have written it already.
    async fn record(&mut self, name: &str, drop: &Drop, recorded: Option<Recorded>) -> Result<()> {
        if !self.stations.contains_key(name) {
            return Ok(());
        }
        let Drop { claim, stored, given, row } = drop;
        if given.is_ok() && self.is_replacement(name, claim, stored).await? {
            return Ok(());
        }
        let recorded = match recorded {
            Some(recorded) => recorded,
            None => self.ledger.record_claim(row).await?,
        };
        if recorded.fresh {
            self.reading.counted.insert(recorded.id);
        }
        let part = self.ledger.part(recorded.id).await?.context("a recorded part has no row")?;
        if part.file.content_hash != stored.hash {
            self.give_back(name, claim, stored);
            return Ok(());
        }
        let note = Taken::of(self.life.owner.farm(), row.clone(), given.as_ref().err()).to_text();
        self.ending.claims.insert(claim.id.clone(), StandingClaim { claim: claim.clone(), note });
        match (part.state, given) {
            (PartState::Claimed, Err(error)) => {
                let remedy = match error {
                    TicketError::Unlisted(_) => {
                        "drop it again together with a list that has a row for it, or with a ticket of its own"
                    }
                    _ => "mend the ticket and drop both again",
                };
                let reason = format!("{error}. {COPIES_UNKNOWN}: {remedy}.");
                self.refuse(&part, Refusal::Ticket, &reason).await
            }
            _ => {
                self.settle_claim(&part);
                Ok(())
            }
        }
    }

    /// Starts reading claimed parts.
    pub(super) async fn read(&mut self) -> Result<()> {
        let profiles: Vec<Arc<Profile>> =
            (self.stations.values()).filter(|s| s.may_take && s.holds.are_fresh()).map(|s| s.profile.clone()).collect();
        // Each time another machine comes first, so that none waits for the end of another one's line.
        self.reading.begun = self.reading.begun.wrapping_add(1);
        for at in 0..profiles.len() {
            let profile = &profiles[(self.reading.begun + at) % profiles.len()];
            let reading = self.jobs.running::<ReadJob>().count();
            if reading >= READERS {
                break;
            }
            let parts = self.ledger.claimed_parts(&profile.name, READERS + reading + self.reading.again.len()).await?;
            for part in parts {
                self.begin_read(part, profile).await?;
            }
        }
        Ok(())
    }

    async fn begin_read(&mut self, mut part: PartRow, profile: &Arc<Profile>) -> Result<()> {
        let turn = ReadTurn {
            reads: part.file.reads,
            is_resting: self.reading.again.rests(&part.id),
            is_ending: self.is_ending(&part),
            is_being_read: self.jobs.runs::<ReadJob>(part.id),
            readers: self.jobs.running::<ReadJob>().count(),
            is_reader_alone: self.reading.is_alone,
        };
        if !turn.has_come() {
            return Ok(());
        }
        let was_rejected = self.ledger.was_rejected(part.id).await?;
        if !self.reading.counted.remove(&part.id) {
            part.file.reads = self.ledger.begin_read(part.id).await?;
        }
        self.reading.is_alone = part.file.reads > READS_IN_THE_DAEMON;
        let (profile, meshes) = (profile.clone(), self.meshes.clone());
        let claim = self.ending.claims.get(&part.file.claim).cloned();
        let holds = self.stations.get(&profile.name).map(|station| station.holds.clone());
        // After a retry the refused file and its reason have no business in the error folder any more.
        let refused_before = holds.filter(|_| was_rejected);
        self.jobs.start(ReadJob { part: part.id }, move || {
            let mut outcome = read_part(&part, claim.as_ref(), &profile, &meshes);
            // Before it waits: a crash after must not leave its file in two places.
            if let (Some(holds), ReadOutcome::Solids(_)) = (refused_before, &outcome)
                && let Err(failure) = remove_refused(&holds, &profile, &part)
            {
                outcome = ReadOutcome::Later(format!("removing what was refused of it: {failure:#}"));
            }
            outcome
        });
        Ok(())
    }

    /// Takes in what a reader found.
    async fn on_read(&mut self, id: PartId, outcome: ReadOutcome) -> Result<()> {
        let part = self.ledger.part(id).await?.context("a part that was read has no row")?;
        if part.state != PartState::Claimed {
            return Ok(());
        }
        match outcome {
            ReadOutcome::Solids(mut solids) => {
                match self.verdict_on_twins(&part, &solids).await? {
                    TwinVerdict::None => {}
                    TwinVerdict::Warn(warning) => solids[0].warnings.push(warning),
                    TwinVerdict::Refuse(reason) => return self.refuse(&part, Refusal::Duplicate, &reason).await,
                }
                let ids = self.ledger.accept(id, &solids).await?;
                let copies = counted(solids.iter().map(|s| s.copies).sum::<u32>(), "copy", "copies");
                let parts = counted(ids.len(), "part", "parts");
                info!(part.id = %id, profile = %part.profile, "{} waits in {}: {parts}, {copies}.", part.name, part.profile);
                self.let_go(&part);
                Ok(())
            }
            ReadOutcome::Refused(cause, reason) => self.refuse(&part, cause, &reason).await,
            ReadOutcome::Lost(lost) => self.ask_again(&lost).await,
            ReadOutcome::Later(why) => {
                self.reading.again.failed(id);
                self.ledger.forget_read(id).await?;
                let about = format!("part {id} ({})", part.name);
                self.notices.trouble(Attention::ReadingFails, &part.profile, &about, &format!("{about}: {why}"));
                Ok(())
            }
        }
    }
}

/// The first of many things that wait.
fn few(held: &[String]) -> String {
    const MOST: usize = 5;
    match held.len() {
        0..=MOST => held.join("; "),
        all => format!("{}; and {} more", held[..MOST].join("; "), all - MOST),
    }
}

fn remove_refused(holds: &Holds, profile: &Profile, part: &PartRow) -> Result<()> {
    holds.demand_error()?;
    error_folder::remove_refused(&profile.folders.error, part)
}
