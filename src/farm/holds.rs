//! The holds on the folders of a machine, taken and kept together.

use super::{
    lease::Stamp,
    owner::{Hold, Owner, OwnerError},
};
use crate::{
    intake,
    settings::{Folders, Profile},
};

/// The hold on the folders of a profile.
#[derive(Debug, Clone)]
pub struct Holds {
    /// Of the hot folder.
    pub inbox: Hold,
    /// Of the queue folder.
    pub queue: Hold,
    /// Of the archive.
    pub archive: Hold,
    /// Of the error folder.
    pub error: Hold,
    /// What is wrong, of each; in plain words.
    pub wrong: [Option<String>; 4],
    /// When they were looked at last; `None` = never.
    looked: Option<Stamp>,
    /// Claims of this farm that another one has taken over.
    pub taken_over: Vec<String>,
    /// How many claims of other farms lie in the hot folder.
    pub foreign: usize,
}

impl Holds {
    /// Holds that are not taken yet.
    pub fn new(owner: &Owner, profile: &Profile) -> Self {
        let hold = |folder| Hold::new(owner.clone(), folder);
        let Folders { inbox, queue, error, archive } = &profile.folders;
        Self {
            inbox: hold(inbox),
            queue: hold(queue),
            archive: hold(archive),
            error: hold(error),
            wrong: Default::default(),
            looked: None,
            taken_over: Vec::new(),
            foreign: 0,
        }
    }

    /// All of them.
    pub fn all(&mut self) -> [&mut Hold; 4] {
        [&mut self.inbox, &mut self.queue, &mut self.archive, &mut self.error]
    }

    /// Whether they were looked at a moment ago, so that nobody else can have taken them since.
    pub fn are_fresh(&self) -> bool {
        self.looked.is_some_and(Stamp::holds)
    }

    /// Shows that the folders are served, and looks what another farm has done in them.
    pub fn keep(&mut self) {
        self.looked = Some(Stamp::now());
        self.wrong = self.all().map(|hold| hold.keep().err().map(|error| error.to_string()));
        if let Ok(taken_over) = intake::taken_over(self.inbox.folder(), self.inbox.farm()) {
            self.taken_over = taken_over;
        }
        if let Ok(foreign) = intake::foreign(self.inbox.folder(), self.inbox.farm()) {
            self.foreign = foreign.len();
        }
    }

    /// Takes hold of the folders that are not held yet; whether it is clear of each.
    pub fn keep_at_start(&mut self) -> Result<bool, OwnerError> {
        let (mut wrong, mut is_clear) = (self.wrong.clone(), true);
        for (hold, wrong) in self.all().into_iter().zip(&mut wrong).filter(|(hold, _)| hold.seen().is_none()) {
            *wrong = match hold.keep() {
                Ok(()) => None,
                Err(refused @ OwnerError::Other { .. }) => return Err(refused),
                Err(error) => {
                    is_clear &= !matches!(error, OwnerError::Unclear { .. });
                    Some(error.to_string())
                }
            };
        }
        self.wrong = wrong;
        Ok(is_clear)
    }

    /// Whether nothing was wrong with queue and archive when they were last looked at.
    pub fn can_publish(&self) -> bool {
        let [_, queue, archive, _] = &self.wrong;
        queue.is_none() && archive.is_none()
    }

    /// Whether queue and archive are those of before: a build is published into both.
    pub fn demand_published(&self) -> Result<(), OwnerError> {
        self.archive.demand_mine()?;
        self.queue.demand_mine()
    }

    /// Whether files may be taken out of the hot folder at this moment.
    pub fn may_take(&self) -> bool {
        self.are_fresh() || self.inbox.demand_mine().is_ok()
    }

    /// Whether what is in the error folder can be relied on, and things can be put there.
    pub fn demand_error(&self) -> Result<(), OwnerError> {
        self.error.clone().check()
    }
}
