//! Orders by hand to the daemon, which answers in the row; so they work from another server too.

use serde::{Deserialize, Serialize};
use sqlx::FromRow;

use super::{CommandId, Ledger, LedgerError, PartId, Utc, error::Result, word::own_word};

/// What is ordered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CommandKind {
    /// Publish what waits in a profile now.
    Flush,
    /// Fire no batch in a profile until it is resumed.
    Pause,
    /// Let a profile fire again.
    Resume,
    /// Take a rejected part back.
    Retry,
    /// Reject a waiting part.
    Cancel,
    /// Look into the hot folders now.
    Scan,
}

own_word!(CommandKind);

/// Where an order stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CommandState {
    /// Not answered yet.
    Asked,
    /// Done.
    Done,
    /// Refused; the answer says why.
    Refused,
}

own_word!(CommandState);

/// An order to give.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewCommand {
    /// What.
    pub kind: CommandKind,
    /// Machine profile of flush, pause and resume, "" otherwise.
    pub profile: String,
    /// Part of retry and cancel.
    pub part: Option<PartId>,
    /// user@host.
    pub asked_by: String,
}

/// An order as it stands.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, FromRow)]
pub struct CommandRow {
    /// Its number.
    pub id: CommandId,
    /// What.
    pub kind: CommandKind,
    /// Machine profile, "" = none.
    pub profile: String,
    /// Part of retry and cancel.
    pub part_id: Option<PartId>,
    /// user@host.
    pub asked_by: String,
    /// When.
    pub asked_at: Utc,
    /// Where it stands.
    pub state: CommandState,
    /// What the daemon answered.
    pub answer: String,
    /// When it answered.
    pub answered_at: Option<Utc>,
}

impl Ledger {
    /// Gives an order to the daemon.
    pub async fn ask(&self, command: &NewCommand) -> Result<CommandId> {
        let mut change = self.change().await?;
        if let Some(part) = command.part {
            change.part(part).await?;
        }
        let now = change.now;
        let id = sqlx::query_scalar(
            "INSERT INTO command (kind, profile, part_id, asked_by, asked_at, state) \
             VALUES (?, ?, ?, ?, ?, 'asked') RETURNING id",
        )
        .bind(command.kind)
        .bind(&command.profile)
        .bind(command.part)
        .bind(&command.asked_by)
        .bind(now)
        .fetch_one(change.db())
        .await?;
        change.commit().await?;
        Ok(id)
    }

    /// The orders that are not answered, oldest first.
    pub async fn asked(&self) -> Result<Vec<CommandRow>> {
        let query = sqlx::query_as("SELECT * FROM command WHERE state = 'asked' ORDER BY id");
        Ok(query.fetch_all(self.reader()?).await?)
    }

    /// Answers an order, once.
    pub async fn answer(&self, id: CommandId, done: bool, answer: &str) -> Result<()> {
        let mut change = self.change().await?;
        let state = if done { CommandState::Done } else { CommandState::Refused };
        let now = change.now;
        let answered =
            sqlx::query("UPDATE command SET state = ?, answer = ?, answered_at = ? WHERE id = ? AND state = 'asked'")
                .bind(state)
                .bind(answer)
                .bind(now)
                .bind(id)
                .execute(change.db())
                .await?;
        if answered.rows_affected() == 0 {
            return Err(LedgerError::UnknownCommand(id));
        }
        change.commit().await
    }

    /// An order.
    pub async fn command(&self, id: CommandId) -> Result<Option<CommandRow>> {
        let query = sqlx::query_as("SELECT * FROM command WHERE id = ?").bind(id);
        Ok(query.fetch_optional(self.reader()?).await?)
    }

    /// Pauses a profile; `true` = it was not paused.
    pub async fn pause(&self, profile: &str, by: &str) -> Result<bool> {
        let mut change = self.change().await?;
        let now = change.now;
        let insert = "INSERT INTO pause (profile, paused_by, paused_at) VALUES (?, ?, ?) ON CONFLICT DO NOTHING";
        let paused = sqlx::query(insert).bind(profile).bind(by).bind(now).execute(change.db()).await?;
        if paused.rows_affected() == 0 {
            return Ok(false);
        }
        change.event("paused", profile, None, None, by).await?;
        change.commit().await?;
        Ok(true)
    }

    /// Resumes a profile; `true` = it was paused.
    pub async fn resume(&self, profile: &str, by: &str) -> Result<bool> {
        let mut change = self.change().await?;
        let lift = sqlx::query("DELETE FROM pause WHERE profile = ?").bind(profile);
        if lift.execute(change.db()).await?.rows_affected() == 0 {
            return Ok(false);
        }
        change.event("resumed", profile, None, None, by).await?;
        change.commit().await?;
        Ok(true)
    }

    /// The paused profiles, by name.
    pub async fn paused(&self) -> Result<Vec<String>> {
        let query = sqlx::query_scalar("SELECT profile FROM pause ORDER BY profile");
        Ok(query.fetch_all(self.reader()?).await?)
    }
}
