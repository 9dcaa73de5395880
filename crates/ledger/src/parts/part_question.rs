//! Parts with an open question: a person must say or do something.

use build_file::{COPIES_QUESTION, is_copies_question};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    Ledger, PartRow, PartState,
    base::{
        error::Result,
        sql::{self, sql_row},
        text_column::own_word,
    },
    store::change::LedgerChange,
};

/// What a question is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum QuestionKind {
    /// Whether the part is printed as it is.
    Confirmation,
    /// Its original must be dropped again.
    Original,
    /// How many copies are wanted.
    Copies,
    /// Its material must be loaded on its machine, or be another one.
    Material,
}

own_word!(QuestionKind);

impl QuestionKind {
    /// The open questions of a part, the most important first; `parts_with_questions` finds the first of them in SQL. A
    /// part whose number of copies is asked for is wanted once, and a line of its warnings asks for it.
    pub fn of_part(part: &PartRow) -> Vec<Self> {
        let is_waiting = part.state == PartState::Waiting;
        // More copies can be ordered while the one that was taken is being built.
        let is_taken = is_waiting || part.state == PartState::Batched;
        let is_unclear = part.wanted_copies() == 1 && part.warnings.lines().any(is_copies_question);
        let asked = [
            (Self::Confirmation, is_waiting && !part.owed.question.is_empty()),
            (Self::Original, part.state.is_live() && part.times.damaged_at.is_some()),
            (Self::Copies, is_taken && is_unclear),
            (Self::Material, is_waiting && part.owed.awaits_material),
        ];
        asked.into_iter().filter_map(|(kind, is_open)| is_open.then_some(kind)).collect()
    }
}

/// A part with an open question.
#[derive(Debug, Clone, PartialEq)]
pub struct QuestionedPart {
    /// The part.
    pub part: PartRow,
    /// What is asked first.
    pub kind: QuestionKind,
    /// Number of such parts of the machine.
    pub total: u32,
}

sql_row!(QuestionedPart { kind, total; part });

impl Ledger {
    /// The first `most` parts of each machine and kind with an open question, oldest first. A part whose number of
    /// copies is asked for is one copy with a warning that contains [`COPIES_QUESTION`].
    pub async fn parts_with_questions(&self, most: u32) -> Result<Vec<QuestionedPart>> {
        // The kinds are those of `QuestionKind::of_part`, the first of them for each part.
        let query = sql::select_as(
            "FROM (SELECT *, COUNT(*) OVER (PARTITION BY machine, kind) AS total, \
             ROW_NUMBER() OVER (PARTITION BY machine, kind ORDER BY id) AS at FROM (\
             SELECT *, CASE WHEN state = 'waiting' AND question <> '' THEN 'confirmation' WHEN damaged_at IS NOT NULL THEN 'original' \
             WHEN warnings <> '' AND copies - cancelled_copies = 1 AND instr(warnings, $1) > 0 THEN 'copies' \
             WHEN state = 'waiting' AND awaits_material THEN 'material' END AS kind \
             FROM part WHERE state IN ('waiting', 'batched')) AS asked WHERE kind IS NOT NULL) AS numbered WHERE at <= $2 ORDER BY machine, id",
        );
        Ok(query.bind(COPIES_QUESTION).bind(most).fetch_all(self.reader()?).await?)
    }
}

impl PartRow {
    /// Whether it is known how many copies are wanted. Otherwise they are taken as 1 until a person says, or it is dropped again.
    pub fn is_number_known(&self) -> bool {
        !self.has_unknown_copies() && !QuestionKind::of_part(self).contains(&QuestionKind::Copies)
    }

    /// Its warnings as people are shown them: what nobody can answer any more is not asked.
    pub fn told_warnings(&self) -> impl Iterator<Item = &str> {
        let is_asked = QuestionKind::of_part(self).contains(&QuestionKind::Copies);
        self.warnings.lines().map(move |warning| match warning.strip_prefix(COPIES_QUESTION) {
            Some(told) if !is_asked => told.trim_start(),
            _ => warning,
        })
    }
}

impl LedgerChange {
    /// Somebody told how many copies of a part are wanted, also where that is what was taken. Returns whether it was asked for.
    pub(crate) async fn end_copies_question(&mut self, part: &PartRow) -> Result<bool> {
        let others: Vec<&str> = part.warnings.lines().filter(|warning| !is_copies_question(warning)).collect();
        let left = others.join("\n");
        if left == part.warnings {
            return Ok(false);
        }
        let set = sql::query("UPDATE part SET warnings = $1 WHERE id = $2").bind(&left).bind(part.id);
        set.execute(self.db()).await?;
        Ok(true)
    }
}
