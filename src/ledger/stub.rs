//! The doors of the room, before they are hung.

use super::*;

type Result<T> = std::result::Result<T, LedgerError>;

fn unwritten<T>() -> Result<T> {
    Err(LedgerError::Sql(sqlx::Error::WorkerCrashed))
}

impl Ledger {
    /// Records a claim and its ticket; the same claim again gives the same part.
    pub async fn record_claim(&self, _part: &NewPart) -> Result<Recorded> {
        unwritten()
    }
    /// A part.
    pub async fn part(&self, _id: PartId) -> Result<Option<PartRow>> {
        unwritten()
    }
    /// All parts in a state, oldest first.
    pub async fn parts_in_state(&self, _state: PartState) -> Result<Vec<PartRow>> {
        unwritten()
    }
    /// All solids of a claim, by object index.
    pub async fn parts_of_claim(&self, _claim: &str) -> Result<Vec<PartRow>> {
        unwritten()
    }
    /// All parts of an order, oldest first.
    pub async fn order(&self, _name: &str) -> Result<Vec<PartRow>> {
        unwritten()
    }
    /// All parts with a copy in a build, in order of precedence.
    pub async fn parts_of_build(&self, _build: BuildId) -> Result<Vec<PartRow>> {
        unwritten()
    }
    /// claimed -> waiting: the solids that were read; further solids than 0 become parts of their own. Returns the
    /// parts that wait now. A sibling that is not claimed stays as it is.
    pub async fn accept(&self, _id: PartId, _solids: &[SolidFacts]) -> Result<Vec<PartId>> {
        unwritten()
    }
    /// claimed -> rejected, with all claimed solids of the same claim.
    pub async fn reject(&self, _id: PartId, _reason: &str) -> Result<()> {
        unwritten()
    }
    /// waiting -> rejected: by an operator, or because the profile changed. Published copies stay published; refused
    /// while a copy is being nested.
    pub async fn cancel(&self, _id: PartId, _reason: &str) -> Result<()> {
        unwritten()
    }
    /// rejected -> claimed: it is read again.
    pub async fn retry(&self, _id: PartId) -> Result<()> {
        unwritten()
    }
    /// The waiting copies of a profile in order of precedence: priority, due date, age.
    pub async fn waiting_copies(&self, _profile: &str) -> Result<Vec<WaitingPart>> {
        unwritten()
    }
    /// The latest part of another claim, not rejected, with the same content in the same profile.
    pub async fn earlier_with_hash(&self, _profile: &str, _hash: &str, _before: PartId) -> Result<Option<PartId>> {
        unwritten()
    }
    /// Whether a live part (claimed, waiting, batched) needs the stored file.
    pub async fn hash_in_use(&self, _hash: &str) -> Result<bool> {
        unwritten()
    }
    /// Where the copies of a part are, by copy.
    pub async fn placements_of_part(&self, _part: PartId) -> Result<Vec<PlacementRow>> {
        unwritten()
    }
    /// The copies in a build with their poses, by part and copy.
    pub async fn placements_of_build(&self, _build: BuildId) -> Result<Vec<PlacementRow>> {
        unwritten()
    }

    /// The open build of a profile; opened when there is none.
    pub async fn open_build(&self, _profile: &str) -> Result<BuildRow> {
        unwritten()
    }
    /// Deletes the open build of a profile that is no more; it holds no copy.
    pub async fn drop_open_build(&self, _profile: &str) -> Result<()> {
        unwritten()
    }
    /// Keeps the layout of an open or nesting build.
    pub async fn save_layout(&self, _build: BuildId, _layout: &OpenLayout) -> Result<()> {
        unwritten()
    }
    /// open -> nesting: takes exactly these copies; parts whose last copy is taken become batched.
    pub async fn begin_nesting(&self, _build: BuildId, _fired_by: &str, _copies: &[(PartId, u32)]) -> Result<()> {
        unwritten()
    }
    /// Counts another attempt of a nesting build; returns how many there are now.
    pub async fn begin_attempt(&self, _build: BuildId) -> Result<u32> {
        unwritten()
    }
    /// Adds CPU seconds of nesting for a build.
    pub async fn add_cpu_secs(&self, _build: BuildId, _cpu_secs: f64) -> Result<()> {
        unwritten()
    }
    /// Lets copies of a nesting build go: their parts wait again.
    pub async fn release_copies(&self, _build: BuildId, _copies: &[(PartId, u32)]) -> Result<()> {
        unwritten()
    }
    /// nesting -> verified: the file is written and proved. `placed` must be exactly the copies of the build.
    pub async fn verify_build(&self, _build: BuildId, _verified: &Verified, _placed: &[PlacedCopy]) -> Result<()> {
        unwritten()
    }
    /// verified -> published; parts whose last copy is published become built.
    pub async fn publish_build(&self, _build: BuildId) -> Result<()> {
        unwritten()
    }
    /// nesting -> failed: all its copies wait again.
    pub async fn fail_build(&self, _build: BuildId, _reason: &str) -> Result<()> {
        unwritten()
    }
    /// All builds in a state, oldest first.
    pub async fn builds_in_state(&self, _state: BuildState) -> Result<Vec<BuildRow>> {
        unwritten()
    }
    /// A build.
    pub async fn build(&self, _id: BuildId) -> Result<Option<BuildRow>> {
        unwritten()
    }
    /// The copies taken into a build, by part and copy.
    pub async fn copies_of_build(&self, _id: BuildId) -> Result<Vec<(PartId, u32)>> {
        unwritten()
    }
    /// Writes what somebody told of a published build and moves it, through printing where needed.
    pub async fn record_outcome(&self, _build: BuildId, _outcome: Outcome, _note: &str, _told_by: &str) -> Result<()> {
        unwritten()
    }
    /// What was told of a build, oldest first.
    pub async fn outcomes(&self, _build: BuildId) -> Result<Vec<OutcomeRow>> {
        unwritten()
    }

    /// Gives an order to the daemon.
    pub async fn ask(&self, _command: &NewCommand) -> Result<CommandId> {
        unwritten()
    }
    /// The orders that are not answered, oldest first.
    pub async fn asked(&self) -> Result<Vec<CommandRow>> {
        unwritten()
    }
    /// Answers an order.
    pub async fn answer(&self, _id: CommandId, _done: bool, _answer: &str) -> Result<()> {
        unwritten()
    }
    /// An order.
    pub async fn command(&self, _id: CommandId) -> Result<Option<CommandRow>> {
        unwritten()
    }
    /// Pauses a profile; `true` = it was not paused.
    pub async fn pause(&self, _profile: &str, _by: &str) -> Result<bool> {
        unwritten()
    }
    /// Resumes a profile; `true` = it was paused.
    pub async fn resume(&self, _profile: &str, _by: &str) -> Result<bool> {
        unwritten()
    }
    /// The paused profiles.
    pub async fn paused(&self) -> Result<Vec<String>> {
        unwritten()
    }

    /// Writes a sign of life.
    pub async fn beat(&self, _beat: &Beat) -> Result<()> {
        unwritten()
    }
    /// The daemon has stopped in order: nobody serves this ledger.
    pub async fn farewell(&self) -> Result<()> {
        unwritten()
    }
    /// The daemon that serves or served this ledger.
    pub async fn daemon(&self) -> Result<Option<DaemonRow>> {
        unwritten()
    }
    /// Writes an event.
    pub async fn event(
        &self,
        _kind: &str,
        _profile: &str,
        _part: Option<PartId>,
        _build: Option<BuildId>,
        _detail: &str,
    ) -> Result<()> {
        unwritten()
    }
    /// The events of a part, oldest first.
    pub async fn events_of_part(&self, _part: PartId) -> Result<Vec<EventRow>> {
        unwritten()
    }
    /// The events of a build, oldest first.
    pub async fn events_of_build(&self, _build: BuildId) -> Result<Vec<EventRow>> {
        unwritten()
    }

    /// Builds with their heights, newest first.
    pub async fn history(&self, _query: &HistoryQuery) -> Result<Vec<HistoryRow>> {
        unwritten()
    }
    /// Every profile of which the ledger knows something, by name.
    pub async fn status(&self) -> Result<Vec<ProfileStatus>> {
        unwritten()
    }
    /// Looks at every row and says in sentences what does not agree; empty = all is well.
    pub async fn faults(&self) -> Result<Vec<String>> {
        unwritten()
    }
}
