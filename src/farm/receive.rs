//! The steps "dropped" and "claimed": what has settled in a hot folder is claimed and copied into the store. The scan is the
//! truth; an event only says "look". The row in the ledger follows in the event loop.

use std::{
    collections::HashMap,
    io,
    path::Path,
    time::{Duration, Instant},
};

use super::{
    failure::chain,
    holds::Holds,
    owner::Hold,
    refused::RefusedFiles,
    taken::{Taken, new_part},
    time_source::TimeSource,
};
use crate::{
    intake::{
        self, Claim, Given, Inbox, Judged, Kind, LeftFolders, ListEnd, ListRules, Lists, Ready, ScanLimits, Seen,
        SettleRules, Settler, Store, StoreError, Stored, TicketError,
    },
    ledger::{NewPart, Refusal},
    settings::Profile,
};

/// Parts claimed in one look, so that the first of very many are being read while the rest is claimed: so many, or this share
/// of what stands there, so that the looks at very many files do not cost more than the files.
const CLAIMS_PER_LOOK: usize = 100;
const SHARE_PER_LOOK: usize = 20;
/// Rows without a file are told after the list stood still for so many settle times.
const TOLD_AFTER_SETTLES: f64 = 2.0;
/// A file that nestd may not read is refused when that lasts so long.
const DENIED_FOR: Duration = Duration::from_secs(5);

/// Refused files are counted again after so long.
const COUNT_AGAIN: Duration = Duration::from_secs(2);

/// The gate of a hot folder: what it remembers between two looks.
#[derive(Debug)]
pub struct Gate {
    inbox: Inbox,
    settler: Settler,
    lists: Lists,
    time: TimeSource,
    began: Instant,
    /// Order folders whose files were claimed; they go when they stay empty.
    left: LeftFolders,
    /// Claims that are not in the store yet; `None` = what lies in `.claimed/` is to be listed: at the start, after the hot
    /// folder was away, after something went wrong there.
    pending: Option<Vec<Claim>>,
    /// The refused files that somebody must see to.
    refused: RefusedFiles,
    /// When they were counted last.
    counted: Option<Instant>,
    /// Device and inode of the hot folder at the last look.
    at: Option<(u64, u64)>,
    /// Claims with a file that may not be read, and since when.
    unreadable: HashMap<String, Instant>,
    /// Number of the farm that takes.
    farm: String,
}

/// A claimed part that is in the store.
#[derive(Debug)]
pub struct Drop {
    /// The claim.
    pub claim: Claim,
    /// Its copy.
    pub stored: Stored,
    /// What is said about it.
    pub given: Result<Given, TicketError>,
    /// Its row as it is to be recorded, which is noted beside its copy already.
    pub row: NewPart,
}

/// What one look found.
#[derive(Debug, Default)]
pub struct Received {
    /// Claimed parts that are in the store.
    pub drops: Vec<Drop>,
    /// Why the hot folder cannot be looked at.
    pub unavailable: Option<String>,
    /// Seconds until another look is worth it, where something is settling.
    pub next_secs: Option<f64>,
    /// Things that were refused without becoming a part: display name, kind and reason.
    pub refused: Vec<(String, Refusal, String)>,
    /// What waits because it and an order list do not fit together: parts of sentences.
    pub held: Vec<String>,
    /// Whether more is ready than one look takes: `held` is not all.
    pub is_cut: bool,
    /// What went wrong and will be tried again.
    pub troubles: Vec<String>,
    /// Refused files that somebody must see to; `None` = not counted this time.
    pub refused_kept: Option<usize>,
    /// Whether things may be put into the error folder and the archive.
    may_refuse: bool,
    /// A part may stand in a claim that nobody knows: claims are listed anew, and no order list is ended for its seeming to
    /// be served.
    in_doubt: bool,
}

impl Gate {
    /// A gate that remembers nothing yet.
    pub fn new(profile: &Profile, orphan_secs: f64, time: TimeSource) -> Self {
        Self {
            inbox: Inbox::new(&profile.folders.inbox, ScanLimits::default()),
            settler: Settler::new(rules(profile, orphan_secs)),
            lists: Lists::default(),
            began: time.instant(),
            time,
            left: LeftFolders::default(),
            pending: None,
            refused: RefusedFiles::default(),
            counted: None,
            at: None,
            unreadable: HashMap::new(),
            farm: String::new(),
        }
    }

    /// Whether it is the gate of this profile's hot folder still.
    pub fn is_of(&self, profile: &Profile) -> bool {
        self.inbox.path() == profile.folders.inbox
    }

    /// What lies in `.claimed/` is listed anew at the next look.
    pub fn relist(&mut self) {
        self.pending = None;
    }

    /// A claim that could not be recorded: the next look brings it again.
    pub fn take_back(&mut self, claim: Claim) {
        self.wait(claim);
    }

    /// One look: claims what has settled and copies it into the store.
    pub fn look(&mut self, profile: &Profile, holds: &mut Holds, store: &Store, orphan_secs: f64) -> Received {
        let mut received = Received::default();
        let hold = &mut holds.inbox;
        if let Err(error) = hold.check() {
            received.unavailable = Some(error.to_string());
            self.pending = None;
            return received;
        }
        if self.at.is_some() && self.at != hold.seen() {
            // It was away and is back, or was replaced on purpose.
            self.inbox = Inbox::new(self.inbox.path(), ScanLimits::default());
            self.pending = None;
        }
        self.at = hold.seen();
        received.may_refuse = holds.error.check().is_ok() && holds.archive.check().is_ok();
        hold.farm().clone_into(&mut self.farm);
        self.settler.set_rules(rules(profile, orphan_secs));
        let mut claims = self.claims_so_far(holds.inbox.farm(), &mut received);
        match self.inbox.scan() {
            Ok(listing) => {
                received
                    .troubles
                    .extend(listing.troubles.iter().map(|(path, why)| format!("{}: {why}", path.display())));
                self.take_what_is_ready(profile, holds, &listing.seen, &mut claims, &mut received);
            }
            Err(error) => received.unavailable = Some(error.to_string()),
        }
        // A claim that went wrong may be there and nobody knows it: the next look lists them all.
        self.pending = (!received.in_doubt).then(Vec::new);
        for claim in claims {
            // A claim that was listed while the loop ended it is no claim any more.
            if matches!(claim.dir.try_exists(), Ok(false)) {
                continue;
            }
            self.left.note(&claim);
            self.store(profile, claim, store, &mut received);
        }
        self.left.sweep(self.inbox.path(), LeftFolders::MIN_AGE);
        if self.counted.is_none_or(|at| self.time.passed_since(at) >= COUNT_AGAIN) || !received.refused.is_empty() {
            self.counted = Some(self.time.instant());
            received.refused_kept = received.may_refuse.then(|| self.refused.count(&profile.folders.error));
        }
        received
    }

    /// Claims what has settled and fits what its order list says.
    fn take_what_is_ready(
        &mut self,
        profile: &Profile,
        holds: &Holds,
        seen: &[Seen],
        claims: &mut Vec<Claim>,
        received: &mut Received,
    ) {
        let now_secs = self.time.passed_since(self.began).as_secs_f64();
        let most = CLAIMS_PER_LOOK.max(seen.len() / SHARE_PER_LOOK);
        let inbox = self.inbox.path();
        let list_rules =
            ListRules { incomplete_secs: profile.intake.incomplete_secs, unlisted: profile.intake.unlisted };
        let has_end = |file: &Path, name: &str| build_file::has_end(&mut intake::open_dropped(inbox, file)?, name);
        self.lists.observe(seen);
        for ready in self.settler.ready(seen, now_secs, has_end) {
            if claims.len() >= most || !holds.may_take() {
                received.is_cut = true;
                break;
            }
            let may_be_part =
                |file: &Path| build_file::may_be_part(&mut intake::open_dropped(inbox, file)?, &name_of(file));
            match self.lists.judge(inbox, ready, list_rules, may_be_part) {
                Judged::Take(ready) => claims.extend(take(&holds.inbox, profile, &ready, &mut self.lists, received)),
                Judged::Wait(why) => received.held.push(why),
            }
        }
        received.next_secs = if received.is_cut { Some(0.0) } else { self.settler.next_secs(now_secs) };
    }

    /// Copies a claimed part into the store. What fails stays claimed, and is tried at the next look.
    fn store(&mut self, profile: &Profile, claim: Claim, store: &Store, received: &mut Received) {
        match store.put_claimed(&claim) {
            Ok(stored) => match claim.given() {
                Err(error @ TicketError::Unreadable { errno, .. })
                    if !self.is_lasting(&claim, &io::Error::from_raw_os_error(errno)) =>
                {
                    received.troubles.push(error.to_string());
                    self.wait(claim);
                }
                given => {
                    self.unreadable.remove(&claim.id);
                    let row = new_part(profile, &claim, &stored, given.as_ref().ok());
                    let note = Taken::of(&self.farm, row, given.as_ref().err());
                    match store.note(&stored.hash, &claim.id, &note.to_text()) {
                        Ok(()) => received.drops.push(Drop { claim, stored, given, row: note.part }),
                        Err(error) => {
                            received.troubles.push(chain(&error));
                            self.wait(claim);
                        }
                    }
                }
            },
            // Somebody still writes into it: it goes back and settles anew.
            Err(StoreError::Changed(_)) => match intake::give_back(&claim) {
                Ok(_) => received.next_secs = Some(0.0),
                Err(error) => {
                    received.troubles.push(chain(&error));
                    self.wait(claim);
                }
            },
            Err(StoreError::Unreadable { source, .. }) if self.is_lasting(&claim, &source) => {
                if !refuse_unreadable(profile, &claim, &source, received) {
                    self.wait(claim);
                }
            }
            Err(error) => {
                received.troubles.push(chain(&error));
                self.wait(claim);
            }
        }
    }

    fn wait(&mut self, claim: Claim) {
        if let Some(pending) = &mut self.pending {
            pending.push(claim);
        }
    }

    /// Whether a file is no file of ours to read, and not only for a moment: shares say "permission denied" in passing.
    fn is_lasting(&mut self, claim: &Claim, why: &io::Error) -> bool {
        if why.kind() != io::ErrorKind::PermissionDenied {
            return why.raw_os_error().is_none_or(|code| code == rustix::io::Errno::LOOP.raw_os_error());
        }
        let since = *self.unreadable.entry(claim.id.clone()).or_insert_with(|| self.time.instant());
        self.time.passed_since(since) >= DENIED_FOR
    }

    /// Claims that wait for the store; at the first look those that an earlier run left.
    fn claims_so_far(&mut self, farm: &str, received: &mut Received) -> Vec<Claim> {
        if let Some(pending) = self.pending.take() {
            return pending;
        }
        match intake::claims(self.inbox.path(), farm) {
            Ok((claims, troubles)) => {
                received.in_doubt = !troubles.is_empty();
                received.troubles.extend(troubles);
                claims
            }
            Err(error) => {
                received.in_doubt = true;
                received.troubles.push(chain(&error));
                Vec::new()
            }
        }
    }
}

/// Does with one thing what is to be done; a part becomes a claim.
fn take(hold: &Hold, profile: &Profile, ready: &Ready, lists: &mut Lists, received: &mut Received) -> Option<Claim> {
    let inbox = hold.folder();
    match ready {
        Ready::Part { .. } => match intake::claim_as(inbox, ready, hold.farm()) {
            Ok(claim) => {
                lists.served(ready);
                return Some(claim);
            }
            // It is still being written to or was taken away: the next look tells.
            Err(intake::ClaimError::Changed(_) | intake::ClaimError::Gone(_)) => {}
            Err(error) => {
                received.in_doubt = true;
                received.troubles.push(chain(&error));
            }
        },
        // It stays where it is until they are there again; a notice tells.
        Ready::List { .. } | Ready::Refuse { .. } if !received.may_refuse => {}
        Ready::List { .. } if received.in_doubt => {}
        Ready::List { list, quiet_secs } => {
            let (folders, incomplete_secs) = (&profile.folders, profile.intake.incomplete_secs);
            match intake::end_list(inbox, lists, ready, incomplete_secs, &folders.archive, &folders.error) {
                Ok(ListEnd::Refused(reason)) => {
                    received.refused.push((name_of(&list.path), Refusal::Ticket, reason));
                }
                // It may only be the first of its order to be copied.
                Ok(ListEnd::Awaited) if *quiet_secs < TOLD_AFTER_SETTLES * profile.intake.settle_secs => {}
                Ok(ListEnd::Awaited) => received.held.extend(lists.missing(list)),
                Ok(ListEnd::Archived(_)) => {}
                Err(error) => received.troubles.push(chain(&error)),
            }
        }
        Ready::Refuse { seen, reason } => match intake::refuse_path(inbox, seen, &profile.folders.error, reason) {
            Ok(_) => received.refused.push((name_of(&seen.path), kind_of(ready), reason.clone())),
            Err(error) => received.troubles.push(chain(&error)),
        },
    }
    None
}

/// What kind of thing is refused without being read: what is said about parts, or what is no file of ours to read.
fn kind_of(ready: &Ready) -> Refusal {
    match ready {
        Ready::Refuse { seen, .. } if seen.kind == Kind::File && !seen.is_secret => Refusal::Ticket,
        _ => Refusal::Unreadable,
    }
}

/// A file that nestd may not read has no hash and so no row: it goes straight to the error folder. Returns whether it did.
fn refuse_unreadable(profile: &Profile, claim: &Claim, why: &std::io::Error, received: &mut Received) -> bool {
    if !received.may_refuse {
        return false;
    }
    let reason = format!("nestd cannot read this file: {why}. Drop it again with permissions that let nestd read it.");
    let refused = intake::refuse(claim, &profile.folders.error, &reason);
    match &refused {
        Ok(_) => received.refused.push((claim.display_name(), Refusal::Unreadable, reason)),
        Err(error) => received.troubles.push(chain(error)),
    }
    refused.is_ok()
}

fn rules(profile: &Profile, orphan_secs: f64) -> SettleRules {
    SettleRules {
        settle_secs: profile.intake.settle_secs,
        unfinished_secs: profile.intake.unfinished_secs,
        orphan_secs,
    }
}

fn name_of(path: &std::path::Path) -> String {
    path.file_name().map(intake::display_name).unwrap_or_default()
}
