//! Finds the entries of a long list that the ledger does not know. Each start runs these queries, so they check a few
//! thousand entries at a time.

use sqlx::AssertSqlSafe;

use crate::{
    Ledger,
    base::{error::Result, sql},
};

/// Entries per query.
const CHUNK_LEN: usize = 5_000;

impl Ledger {
    /// File names that no build has.
    pub async fn unknown_build_files(&self, names: &[String]) -> Result<Vec<String>> {
        self.find_unknown("build WHERE file_name = value", names).await
    }

    /// Claims that belong to no part and did not replace a damaged file.
    pub async fn unknown_claims(&self, claims: &[String]) -> Result<Vec<String>> {
        self.find_unknown(
            "(SELECT claim FROM part UNION ALL SELECT claim FROM replacement) AS known WHERE claim = value",
            claims,
        )
        .await
    }

    /// Content hashes (BLAKE3) that no part has.
    pub async fn unknown_contents(&self, hashes: &[String]) -> Result<Vec<String>> {
        self.find_unknown("part WHERE content_hash = value", hashes).await
    }

    pub(crate) async fn find_unknown(&self, rows: &str, asked: &[String]) -> Result<Vec<String>> {
        let query = format!("SELECT value FROM json_each($1) WHERE NOT EXISTS (SELECT 1 FROM {rows})");
        let mut unknown = Vec::new();
        for some in asked.chunks(CHUNK_LEN) {
            let list = serde_json::Value::from(some).to_string();
            let found = sql::query_scalar::<String>(AssertSqlSafe(query.clone())).bind(list);
            unknown.extend(found.fetch_all(self.reader()?).await?);
        }
        Ok(unknown)
    }
}
