//! What only tests above the ledger need.

use jiff::Timestamp;
use ledger::{
    BuildId, BuildState, ClaimedFile, Ledger, LedgerError, OperatorWord, OwedCopies, PartId, PartMeasures, PartMending,
    PartRefusal, PartRow, PartState, PartTerms, PartTimes, ReprintTarget, RequiredTilts, SeenFile, SeenFiles,
    SolidOfFile, ToldOutcome, WordAnswer,
};
use nester::OrientationRule;

type Result<T> = std::result::Result<T, LedgerError>;

/// Words of a person about builds that lie in no queue folder.
#[expect(async_fn_in_trait, reason = "tests await them in place")]
pub trait ToldWords {
    async fn record_outcome(&self, build: BuildId, told: &ToldOutcome) -> Result<WordAnswer>;
    async fn reprint_copies(&self, target: &ReprintTarget, told_by: &str) -> Result<WordAnswer>;
    /// Returns the new build.
    async fn requeue_build(&self, build: BuildId, asked_by: &str) -> Result<BuildId>;
}

impl ToldWords for Ledger {
    async fn record_outcome(&self, build: BuildId, told: &ToldOutcome) -> Result<WordAnswer> {
        say(self, OperatorWord::Outcome(build, told.clone()), &told.told_by).await
    }

    async fn reprint_copies(&self, target: &ReprintTarget, told_by: &str) -> Result<WordAnswer> {
        say(self, OperatorWord::Reprint(target.clone()), told_by).await
    }

    async fn requeue_build(&self, build: BuildId, asked_by: &str) -> Result<BuildId> {
        say(self, OperatorWord::Requeue(build), asked_by).await?;
        Ok(self.builds_in_state(BuildState::Nesting).await?.last().unwrap().id)
    }
}

async fn say(ledger: &Ledger, word: OperatorWord, by: &str) -> Result<WordAnswer> {
    let meant = ledger.builds_meant(&word).await?;
    let seen: SeenFiles = meant.into_iter().map(|build| (build.id, SeenFile::OutOfQueue)).collect();
    ledger.carry_out(&word, by, &seen, false).await
}

/// The row of a waiting part without measures or terms, which arrived at this time.
pub fn part_row(id: PartId, copies: u32, arrived: Timestamp) -> PartRow {
    PartRow {
        id,
        machine: "paper-200".to_owned(),
        name: format!("part-{}.stl", id.0),
        solid: SolidOfFile { object_index: 0, object_name: String::new() },
        file: ClaimedFile { claim: String::new(), content_hash: String::new(), bytes: 0, reads: 0 },
        state: PartState::Waiting,
        refused: PartRefusal { reason: String::new(), refusal: None },
        warnings: String::new(),
        owed: OwedCopies {
            copies,
            cancelled_copies: 0,
            put_back_at: None,
            fetch_at: None,
            question: String::new(),
            size_differs: false,
            replaced_by: None,
            awaits_material: false,
        },
        terms: PartTerms {
            order_name: String::new(),
            customer: String::new(),
            email: String::new(),
            material: String::new(),
            finish: String::new(),
            priority: 50,
            due_at: None,
            due_text: String::new(),
            orientation: OrientationRule::Free,
            tilts: RequiredTilts::default(),
            clearance_mm: None,
            unit: None,
            reference: String::new(),
            note: String::new(),
        },
        measures: PartMeasures {
            triangles: None,
            volume_mm3: None,
            size_x_mm: None,
            size_y_mm: None,
            size_z_mm: None,
            read_unit: None,
        },
        mending: PartMending::default(),
        times: PartTimes { claimed_at: arrived.into(), waits_since: None, state_at: arrived.into(), damaged_at: None },
    }
}
