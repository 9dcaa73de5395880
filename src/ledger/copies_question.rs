//! Waiting parts whose number of copies is asked for.

use sqlx::FromRow;

use super::{Ledger, PartId, error::Result};

/// A waiting part that was taken as one copy, because what was said about its copies is not clear.
#[derive(Debug, Clone, PartialEq, Eq, FromRow)]
pub struct CopiesQuestion {
    /// Machine profile.
    pub profile: String,
    /// The part.
    pub id: PartId,
    /// Its file name, escaped for display.
    pub name: String,
    /// Number of such parts of the profile.
    pub total: u32,
}

impl Ledger {
    /// The first `most` parts of each profile that wait as one copy with a warning that contains `question`, oldest first.
    pub async fn copies_questions(&self, question: &str, most: u32) -> Result<Vec<CopiesQuestion>> {
        let query = sqlx::query_as(
            "SELECT profile, id, name, total FROM (SELECT profile, id, name, \
             COUNT(*) OVER (PARTITION BY profile) AS total, \
             ROW_NUMBER() OVER (PARTITION BY profile ORDER BY id) AS at FROM part \
             WHERE state = 'waiting' AND warnings <> '' AND copies - cancelled_copies = 1 AND instr(warnings, ?) > 0) \
             WHERE at <= ? ORDER BY profile, id",
        );
        Ok(query.bind(question).bind(most).fetch_all(self.reader()?).await?)
    }
}
