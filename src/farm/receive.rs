//! The steps "dropped" and "claimed": what has settled in a hot folder is claimed and copied into the store. The scan is the
//! truth; an event only says "look". The row in the ledger follows in the event loop.

use std::time::{Duration, Instant};

use crate::{
    format,
    intake::{
        self, Claim, Inbox, LeftFolders, ListEnd, Ready, ScanLimits, SettleRules, Settler, Store, StoreError, Stored,
    },
    settings::Profile,
};

/// Parts claimed in one look, so that the first of very many are being read while the rest is claimed.
const MAX_CLAIMS_PER_LOOK: usize = 100;

/// Refused files are counted again after so long.
const COUNT_AGAIN: Duration = Duration::from_secs(2);

/// The gate of a hot folder: what it remembers between two looks.
#[derive(Debug)]
pub struct Gate {
    inbox: Inbox,
    settler: Settler,
    began: Instant,
    /// Order folders whose files were claimed; they go when they stay empty.
    left: LeftFolders,
    /// Claims that are not in the store yet; `None` = those of an earlier run have not been looked for.
    pending: Option<Vec<Claim>>,
    /// When the refused files were counted last.
    counted: Option<Instant>,
}

/// What one look found.
#[derive(Debug, Default)]
pub struct Received {
    /// Claimed parts that are in the store.
    pub drops: Vec<(Claim, Stored)>,
    /// Why the hot folder cannot be looked at.
    pub unavailable: Option<String>,
    /// Seconds until another look is worth it, where something is settling.
    pub next_secs: Option<f64>,
    /// Things that were refused without becoming a part: display name and reason.
    pub refused: Vec<(String, String)>,
    /// What went wrong and will be tried again.
    pub troubles: Vec<String>,
    /// Refused files that lie in the error folder; `None` = not counted this time.
    pub refused_kept: Option<usize>,
}

impl Gate {
    /// A gate that remembers nothing yet.
    pub fn new(profile: &Profile, orphan_secs: f64) -> Self {
        Self {
            inbox: Inbox::new(&profile.folders.inbox, ScanLimits::default()),
            settler: Settler::new(rules(profile, orphan_secs)),
            began: Instant::now(),
            left: LeftFolders::default(),
            pending: None,
            counted: None,
        }
    }

    /// Whether it is the gate of this profile's hot folder still.
    pub fn is_of(&self, profile: &Profile) -> bool {
        self.inbox.path() == profile.folders.inbox
    }

    /// A claim that could not be recorded: the next look brings it again.
    pub fn take_back(&mut self, claim: Claim) {
        self.pending.get_or_insert_default().push(claim);
    }

    /// One look: claims what has settled and copies it into the store.
    pub fn look(&mut self, profile: &Profile, store: &Store, orphan_secs: f64) -> Received {
        let mut received = Received::default();
        self.settler.set_rules(rules(profile, orphan_secs));
        let mut claims = self.claims_so_far(&mut received);
        match self.inbox.scan() {
            Ok(listing) => {
                received
                    .troubles
                    .extend(listing.troubles.iter().map(|(path, why)| format!("{}: {why}", path.display())));
                let now_secs = self.began.elapsed().as_secs_f64();
                let ready = self.settler.observe(&listing.seen, now_secs, format::has_end);
                received.next_secs = self.settler.next_secs(now_secs);
                for ready in ready {
                    if claims.len() >= MAX_CLAIMS_PER_LOOK {
                        received.next_secs = Some(0.0);
                        break;
                    }
                    claims.extend(self.take(profile, &ready, orphan_secs, &mut received));
                }
            }
            Err(error) => received.unavailable = Some(error.to_string()),
        }
        self.pending = Some(Vec::new());
        for claim in claims {
            // A claim that was listed while the loop ended it is no claim any more.
            if !claim.dir.exists() {
                continue;
            }
            self.left.note(&claim);
            match store.put(&claim.part) {
                Ok(stored) => received.drops.push((claim, stored)),
                // Somebody still writes into it: it goes back and settles anew.
                Err(StoreError::Changed(_)) => match intake::give_back(&claim) {
                    Ok(_) => received.next_secs = Some(0.0),
                    Err(error) => {
                        received.troubles.push(chain(&error));
                        self.pending.get_or_insert_default().push(claim);
                    }
                },
                Err(StoreError::Unreadable { source, .. }) => {
                    if !refuse_unreadable(profile, &claim, &source, &mut received) {
                        self.pending.get_or_insert_default().push(claim);
                    }
                }
                Err(error) => {
                    received.troubles.push(chain(&error));
                    self.pending.get_or_insert_default().push(claim);
                }
            }
        }
        self.left.sweep(self.inbox.path(), LeftFolders::MIN_AGE);
        if self.counted.is_none_or(|at| at.elapsed() >= COUNT_AGAIN) || !received.refused.is_empty() {
            self.counted = Some(Instant::now());
            received.refused_kept = Some(refused_kept(&profile.folders.error));
        }
        received
    }

    /// Claims that wait for the store; at the first look those that an earlier run left.
    fn claims_so_far(&mut self, received: &mut Received) -> Vec<Claim> {
        if let Some(pending) = self.pending.take() {
            return pending;
        }
        match intake::claims(self.inbox.path()) {
            Ok(claims) => claims,
            Err(error) => {
                received.troubles.push(chain(&error));
                Vec::new()
            }
        }
    }

    fn take(&self, profile: &Profile, ready: &Ready, orphan_secs: f64, received: &mut Received) -> Option<Claim> {
        let inbox = self.inbox.path();
        match ready {
            Ready::Part { .. } => match intake::claim(inbox, ready) {
                Ok(claim) => return Some(claim),
                // It is still being written to or was taken away: the next look tells.
                Err(intake::ClaimError::Changed(_) | intake::ClaimError::Gone(_)) => {}
                Err(error) => received.troubles.push(chain(&error)),
            },
            Ready::List { list, .. } => {
                let folders = &profile.folders;
                match intake::end_list(inbox, ready, orphan_secs, &folders.archive, &folders.error) {
                    Ok(ListEnd::Refused(reason)) => received.refused.push((name_of(&list.path), reason)),
                    Ok(ListEnd::Awaited | ListEnd::Archived(_)) => {}
                    Err(error) => received.troubles.push(chain(&error)),
                }
            }
            Ready::Refuse { seen, reason } => match intake::refuse_path(inbox, seen, &profile.folders.error, reason) {
                Ok(_) => received.refused.push((name_of(&seen.path), reason.clone())),
                Err(error) => received.troubles.push(chain(&error)),
            },
        }
        None
    }
}

/// The reasons that lie in an error folder: one for each file that somebody must see to.
fn refused_kept(error_dir: &std::path::Path) -> usize {
    let is_reason = |file: &&std::path::PathBuf| file.as_os_str().as_encoded_bytes().ends_with(b".reason.txt");
    intake::files_below(error_dir).map_or(0, |files| files.iter().filter(is_reason).count())
}

/// A file that nestd may not read has no hash and so no row: it goes straight to the error folder. Returns whether it did.
fn refuse_unreadable(profile: &Profile, claim: &Claim, why: &std::io::Error, received: &mut Received) -> bool {
    let reason = format!("nestd cannot read this file: {why}. Drop it again with permissions that let nestd read it.");
    let refused = intake::refuse(claim, &profile.folders.error, &reason);
    match &refused {
        Ok(_) => received.refused.push((claim.display_name(), reason)),
        Err(error) => received.troubles.push(chain(error)),
    }
    refused.is_ok()
}

fn rules(profile: &Profile, orphan_secs: f64) -> SettleRules {
    SettleRules { settle_secs: profile.settle_secs, unfinished_secs: profile.unfinished_secs, orphan_secs }
}

fn name_of(path: &std::path::Path) -> String {
    path.file_name().map(intake::display_name).unwrap_or_default()
}

/// An error with its sources in one line.
pub fn chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut source = error.source();
    while let Some(error) = source {
        text.push_str(&format!(": {error}"));
        source = error.source();
    }
    text
}
