//! Keys of requests and forms that were carried out, each with what was answered, so that what is sent again is done once.

use serde::{Deserialize, Serialize};

use crate::{
    Ledger,
    base::{
        error::Result,
        sql::{self, sql_row},
    },
    store::change::LedgerChange,
};

/// A request that was carried out.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct AnsweredRequest {
    /// BLAKE3 of what was asked, 64 hex digits.
    pub fingerprint: String,
    /// JSON that was answered.
    pub answer: String,
}

sql_row!(AnsweredRequest { fingerprint, answer });

impl Ledger {
    /// The request that was carried out with this key.
    pub async fn find_answered_request(&self, client: &str, key: &str) -> Result<Option<AnsweredRequest>> {
        let query = sql::select_as("FROM request_key WHERE client = $1 AND key = $2").bind(client).bind(key);
        Ok(query.fetch_optional(self.reader()?).await?)
    }

    /// Records the key of a request that changes the farm by itself, and what is answered, in place of the earlier answer that is known.
    /// `false` = another node has recorded something else under it meanwhile, and carries it out.
    pub async fn record_answered_request(
        &self,
        client: &str,
        key: &str,
        answered: &AnsweredRequest,
        known: Option<&AnsweredRequest>,
    ) -> Result<bool> {
        let mut change = self.begin_change().await?;
        if change.find_request_key(client, key).await?.as_ref() != known {
            return Ok(false);
        }
        change.write_request_key(client, key, answered).await?;
        change.commit().await?;
        Ok(true)
    }

    /// Forgets the key of a request that was refused.
    pub async fn forget_answered_request(&self, client: &str, key: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        let forget = sql::query("DELETE FROM request_key WHERE client = $1 AND key = $2").bind(client).bind(key);
        forget.execute(change.db()).await?;
        change.commit().await
    }
}

impl LedgerChange {
    /// The request that was carried out with this key.
    pub(super) async fn find_request_key(&mut self, client: &str, key: &str) -> Result<Option<AnsweredRequest>> {
        let query = sql::select_as("FROM request_key WHERE client = $1 AND key = $2").bind(client).bind(key);
        Ok(query.fetch_optional(self.db()).await?)
    }

    /// Records the key of a request, and what is answered.
    pub(super) async fn write_request_key(
        &mut self,
        client: &str,
        key: &str,
        answered: &AnsweredRequest,
    ) -> Result<()> {
        let now = self.now;
        sql::query(
            "INSERT INTO request_key (client, key, fingerprint, answer, answered_at) VALUES ($1, $2, $3, $4, $5) \
             ON CONFLICT (client, key) DO UPDATE SET fingerprint = excluded.fingerprint, answer = excluded.answer, \
             answered_at = excluded.answered_at",
        )
        .bind(client)
        .bind(key)
        .bind(&answered.fingerprint)
        .bind(&answered.answer)
        .bind(now)
        .execute(self.db())
        .await?;
        Ok(())
    }
}
