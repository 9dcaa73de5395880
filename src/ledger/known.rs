//! What of a long list the ledger does not know: asked at each start, so a few thousand at once.

use super::{Ledger, error::Result};

/// Asked at once.
const AT_ONCE: usize = 5_000;

impl Ledger {
    /// Build files that no build has the name of.
    pub async fn unknown_build_files(&self, names: &[String]) -> Result<Vec<String>> {
        self.not_in("build WHERE file_name = value", names).await
    }

    /// Claims that no part has, and that were not taken in place of a damaged file.
    pub async fn unknown_claims(&self, claims: &[String]) -> Result<Vec<String>> {
        self.not_in("(SELECT claim FROM part UNION ALL SELECT claim FROM replacement) WHERE claim = value", claims)
            .await
    }

    /// Contents, by BLAKE3, that no part has.
    pub async fn unknown_contents(&self, hashes: &[String]) -> Result<Vec<String>> {
        self.not_in("part WHERE content_hash = value", hashes).await
    }

    async fn not_in(&self, rows: &str, asked: &[String]) -> Result<Vec<String>> {
        let query = format!("SELECT value FROM json_each(?) WHERE NOT EXISTS (SELECT 1 FROM {rows})");
        let mut unknown = Vec::new();
        for some in asked.chunks(AT_ONCE) {
            let list = serde_json::Value::from(some).to_string();
            let found = sqlx::query_scalar::<_, String>(sqlx::AssertSqlSafe(query.clone())).bind(list);
            unknown.extend(found.fetch_all(self.reader()?).await?);
        }
        Ok(unknown)
    }
}
