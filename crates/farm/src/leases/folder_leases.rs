//! The leases on the folders of a machine, acquired and renewed together.

use delivery::queue::QueueAddress;
use settings::{MachineFolders, MachineProfile};

use super::{
    folder_lease::{FolderLease, LeaseError},
    lease_clock::LeaseTimestamp,
    lease_holder::LeaseHolder,
};

/// Why a folder cannot be used, for alerts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LeaseProblem {
    /// It is not there, is not the expected one, or cannot be read or written.
    Unavailable(String),
    /// Another daemon serves it.
    HeldByOther(String),
    /// It names another daemon, and it is not clear yet whether that one is alive.
    HolderUnclear(String),
}

impl LeaseProblem {
    fn new(error: &LeaseError) -> Self {
        match error {
            LeaseError::HeldByOther { .. } => Self::HeldByOther(error.to_string()),
            LeaseError::HolderUnclear { .. } => Self::HolderUnclear(error.to_string()),
            _ => Self::Unavailable(error.to_string()),
        }
    }

    /// The error in plain words.
    pub fn text(&self) -> &str {
        let (Self::Unavailable(text) | Self::HeldByOther(text) | Self::HolderUnclear(text)) = self;
        text
    }
}

/// The leases on the folders of a machine.
#[derive(Debug, Clone)]
pub struct FolderLeases {
    /// Lease on the hot folder.
    pub inbox: FolderLease,
    /// Leases on the queue folders, one per printer.
    pub queues: Vec<FolderLease>,
    /// Lease on the archive.
    pub archive: FolderLease,
    /// Lease on the error folder.
    pub error: FolderLease,
    /// The problem of each lease, in the order of [`FolderLeases::all_leases`].
    pub errors: Vec<Option<LeaseProblem>>,
    /// When the leases were last renewed and what that told was acted on; `None` = never.
    renewed_at: Option<LeaseTimestamp>,
    /// When the last renewal began.
    renewing_at: Option<LeaseTimestamp>,
    /// Claims of this farm that another farm has taken over.
    pub taken_over: Vec<String>,
    /// Number of claims of other farms in the hot folder.
    pub foreign_claims: usize,
}

impl FolderLeases {
    /// Leases that are not acquired yet.
    pub fn new(holder: &LeaseHolder, profile: &MachineProfile) -> Self {
        let lease = |folder| FolderLease::new(holder.clone(), folder);
        let MachineFolders { inbox, queue: _, error, archive } = &profile.folders;
        Self {
            inbox: lease(inbox),
            archive: lease(archive),
            error: lease(error),
            errors: vec![None; 3 + profile.queue_folders().count()],
            queues: profile.queue_folders().map(lease).collect(),
            renewed_at: None,
            renewing_at: None,
            taken_over: Vec::new(),
            foreign_claims: 0,
        }
    }

    /// All leases: hot folder, archive, error folder, and the queue folders.
    pub fn all_leases(&mut self) -> Vec<&mut FolderLease> {
        [&mut self.inbox, &mut self.archive, &mut self.error].into_iter().chain(&mut self.queues).collect()
    }

    /// The lease on a queue; `None` = it needs none, or is not one of these.
    pub fn queue_lease(&self, queue: &QueueAddress) -> Option<&FolderLease> {
        self.queues.iter().find(|lease| Some(lease.folder_path()) == queue.folder())
    }

    /// Whether these are leases on the same folders.
    pub fn are_of_same_folders(&self, other: &Self) -> bool {
        let is_same = |(own, other): (&FolderLease, &FolderLease)| own.is_same_folder(other);
        self.inbox.is_same_folder(&other.inbox)
            && self.queues.len() == other.queues.len()
            && self.queues.iter().zip(&other.queues).all(is_same)
    }

    /// Whether the leases were renewed recently, so that no other daemon can have taken them since.
    pub fn are_fresh(&self) -> bool {
        self.renewed_at.is_some_and(LeaseTimestamp::is_valid)
    }

    /// How often somebody else served one of the folders, or may have, since this process first held them.
    pub fn interruption_count(&self) -> u32 {
        let others = [&self.inbox, &self.archive, &self.error];
        others.into_iter().chain(&self.queues).map(FolderLease::interruption_count).sum()
    }

    /// What the last renewal told was acted on: from here on the folders count as checked at that time.
    pub fn confirm_renewal(&mut self) {
        self.renewed_at = self.renewing_at;
    }

    /// Renews all leases, and checks what other farms have done in the hot folder.
    pub fn renew_all(&mut self) {
        self.renewing_at = Some(LeaseTimestamp::now());
        self.errors =
            (self.all_leases().into_iter()).map(|lease| lease.renew().err().as_ref().map(LeaseProblem::new)).collect();
        if let Ok(taken_over) = intake::taken_over_claims(self.inbox.folder_path(), self.inbox.farm_id()) {
            self.taken_over = taken_over;
        }
        if let Ok(foreign) = intake::foreign_claims(self.inbox.folder_path(), self.inbox.farm_id()) {
            self.foreign_claims = foreign.len();
        }
    }

    /// Acquires the leases that are still missing. Returns `false` if it is not clear yet whether another daemon holds
    /// one.
    pub fn acquire_missing(&mut self) -> Result<bool, LeaseError> {
        let (mut wrong, mut is_clear) = (self.errors.clone(), true);
        for (lease, wrong) in
            self.all_leases().into_iter().zip(&mut wrong).filter(|(lease, _)| lease.held_identity().is_none())
        {
            *wrong = match lease.renew() {
                Ok(()) => None,
                Err(refused @ LeaseError::HeldByOther { .. }) => return Err(refused),
                Err(error) => {
                    is_clear &= !matches!(error, LeaseError::HolderUnclear { .. });
                    Some(LeaseProblem::new(&error))
                }
            };
        }
        self.errors = wrong;
        Ok(is_clear)
    }

    /// The problem of the lease on a queue; the outer `None` = it has no lease.
    pub fn queue_problem(&self, queue: &QueueAddress) -> Option<Option<&LeaseProblem>> {
        let at = self.queues.iter().position(|lease| Some(lease.folder_path()) == queue.folder())?;
        Some(self.errors.get(3 + at)?.as_ref())
    }

    /// Whether nothing was wrong with a queue and the archive when they were last looked at.
    pub fn can_publish(&self, queue: &QueueAddress) -> bool {
        let is_queue_well = match self.queue_problem(queue) {
            Some(problem) => problem.is_none(),
            None => queue.folder().is_none(),
        };
        matches!(self.errors.get(1), Some(None)) && is_queue_well
    }

    /// Checks that this farm still holds a queue and the archive: a build is published into both.
    pub fn check_publishing(&self, queue: &QueueAddress) -> Result<(), LeaseError> {
        self.archive.check_held()?;
        let Some(folder) = queue.folder() else { return Ok(()) };
        self.queue_lease(queue).ok_or_else(|| LeaseError::Replaced(folder.to_owned()))?.check_held()
    }

    /// Whether files may be claimed from the hot folder at this moment.
    pub fn may_take_files(&self) -> bool {
        self.are_fresh() || self.inbox.check_held().is_ok()
    }

    /// Checks that the error folder may be read and written.
    pub fn check_error_folder(&self) -> Result<(), LeaseError> {
        self.error.clone().check_usable()
    }
}
