//! People who use the pages: their names, roles and the hashes of their passwords and PINs. Whatever changes for one is an event, and ends
//! the sessions that rest on what was before. The hashes leave this file in [`PersonSecrets`] only, which nothing prints.

use access::{PasswordHash, Role};
use serde::Serialize;

use crate::{
    EventKind, Ledger, LedgerError, UtcTimestamp,
    base::{
        error::Result,
        sql::{self, FromSqlRow, SqlRow},
        text_column::word_column,
    },
    store::change::LedgerChange,
};

word_column!(Role);

/// A person.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct PersonRow {
    /// The name, as events have it.
    pub name: String,
    /// What the person may do.
    pub role: Role,
    /// Whether there is a password; without one, a proxy says who it is.
    pub has_password: bool,
    /// Whether there is a PIN.
    pub has_pin: bool,
    /// Who added the person.
    pub added_by: String,
    /// When.
    pub added_at: UtcTimestamp,
    /// When the person last gave the password.
    pub signed_in_at: Option<UtcTimestamp>,
}

/// What a person must know to sign in.
#[derive(Debug, Clone)]
pub struct PersonSecrets {
    /// The name, as events have it.
    pub name: String,
    /// Of the password.
    pub password: PasswordHash,
    /// Of the PIN.
    pub pin: PasswordHash,
}

/// What changes for a person.
#[derive(Debug, Clone)]
pub enum PersonChange {
    /// The role.
    Role(Role),
    /// The password; all sessions end.
    Password(PasswordHash),
    /// The PIN, or that there is none; sessions that were opened with it end.
    Pin(PasswordHash),
    /// All sessions end.
    SignedOut,
    /// The person may not sign in any more.
    Removed,
}

impl FromSqlRow for PersonRow {
    fn from_sql_row(row: &SqlRow) -> sqlx::Result<Self> {
        let has = |name| row.column::<String>(name).map(|hash| !hash.is_empty());
        Ok(Self {
            name: row.column("name")?,
            role: row.column("role")?,
            has_password: has("password_hash")?,
            has_pin: has("pin_hash")?,
            added_by: row.column("added_by")?,
            added_at: row.column("added_at")?,
            signed_in_at: row.column("signed_in_at")?,
        })
    }
}

impl FromSqlRow for PersonSecrets {
    fn from_sql_row(row: &SqlRow) -> sqlx::Result<Self> {
        let hash = |name| row.column(name).map(PasswordHash::from_stored);
        Ok(Self { name: row.column("name")?, password: hash("password_hash")?, pin: hash("pin_hash")? })
    }
}

/// By what names are compared.
fn folded(name: &str) -> String {
    name.trim().to_lowercase()
}

impl Ledger {
    /// Whether there are people at all.
    pub async fn has_people(&self) -> Result<bool> {
        let any = sql::query_scalar::<i64>("SELECT count(*) FROM (SELECT 1 FROM person LIMIT 1) AS any_person");
        Ok(any.fetch_one(self.reader()?).await? > 0)
    }

    /// All people, by name.
    pub async fn list_people(&self) -> Result<Vec<PersonRow>> {
        let query = sql::query_as(
            "SELECT name, role, password_hash, pin_hash, added_by, added_at, signed_in_at FROM person ORDER BY folded",
        );
        Ok(query.fetch_all(self.reader()?).await?)
    }

    /// The person of this name, in whatever case it is written.
    pub async fn find_person(&self, name: &str) -> Result<Option<PersonRow>> {
        let query = sql::query_as(
            "SELECT name, role, password_hash, pin_hash, added_by, added_at, signed_in_at FROM person WHERE folded = $1",
        );
        Ok(query.bind(folded(name)).fetch_optional(self.reader()?).await?)
    }

    /// What the person of this name must know to sign in.
    pub async fn find_secrets(&self, name: &str) -> Result<Option<PersonSecrets>> {
        let query = sql::query_as("SELECT name, password_hash, pin_hash FROM person WHERE folded = $1");
        Ok(query.bind(folded(name)).fetch_optional(self.reader()?).await?)
    }

    /// Adds a person; `by` says so.
    ///
    /// # Errors
    /// `PersonKnown` if there is one of this name.
    pub async fn add_person(&self, name: &str, role: Role, password: &PasswordHash, by: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        let now = change.now;
        let known = sql::query_scalar::<String>("SELECT name FROM person WHERE folded = $1").bind(folded(name));
        if let Some(known) = known.fetch_optional(change.db()).await? {
            return Err(LedgerError::PersonKnown(known));
        }
        sql::query(
            "INSERT INTO person (name, folded, role, password_hash, added_by, added_at) VALUES ($1, $2, $3, $4, $5, $6)",
        )
        .bind(name)
        .bind(folded(name))
        .bind(role)
        .bind(password.to_stored())
        .bind(by)
        .bind(now)
        .execute(change.db())
        .await?;
        let detail = format!("{name} was added with the role {}, by {by}", role.as_str());
        change.write_event(EventKind::Person, "", None, None, &detail).await?;
        change.commit().await
    }

    /// Changes something for a person; `by` says so. Returns the name, as events have it.
    ///
    /// # Errors
    /// `UnknownPerson` if there is none of this name.
    pub async fn change_person(&self, name: &str, what: &PersonChange, by: &str) -> Result<String> {
        let mut change = self.begin_change().await?;
        let known = sql::query_scalar::<String>("SELECT name FROM person WHERE folded = $1").bind(folded(name));
        let known = known.fetch_optional(change.db()).await?;
        let name = known.ok_or_else(|| LedgerError::UnknownPerson(name.to_owned()))?;
        let detail = change.apply_to_person(&name, what).await?;
        let detail = format!("{name} {detail}, by {by}");
        change.write_event(EventKind::Person, "", None, None, &detail).await?;
        change.commit().await?;
        Ok(name)
    }
}

impl LedgerChange {
    /// Returns what happened to the person, in words.
    async fn apply_to_person(&mut self, name: &str, what: &PersonChange) -> Result<String> {
        match what {
            PersonChange::Role(role) => {
                let set = sql::query("UPDATE person SET role = $1 WHERE name = $2").bind(*role).bind(name);
                set.execute(self.db()).await?;
                Ok(format!("was given the role {}", role.as_str()))
            }
            PersonChange::Password(hash) => {
                let set = sql::query("UPDATE person SET password_hash = $1 WHERE name = $2").bind(hash.to_stored());
                set.bind(name).execute(self.db()).await?;
                self.end_sessions_of(name).await?;
                Ok(if hash.is_none() { "has no password any more" } else { "was given a new password" }.to_owned())
            }
            PersonChange::Pin(hash) => {
                let set = sql::query("UPDATE person SET pin_hash = $1 WHERE name = $2").bind(hash.to_stored());
                set.bind(name).execute(self.db()).await?;
                let leave = sql::query("UPDATE session SET person = NULL WHERE person = $1 AND with_pin");
                leave.bind(name).execute(self.db()).await?;
                Ok(if hash.is_none() { "has no PIN any more" } else { "was given a new PIN" }.to_owned())
            }
            PersonChange::SignedOut => {
                self.end_sessions_of(name).await?;
                Ok("was signed out everywhere".to_owned())
            }
            PersonChange::Removed => {
                self.end_sessions_of(name).await?;
                sql::query("DELETE FROM person WHERE name = $1").bind(name).execute(self.db()).await?;
                Ok("was removed".to_owned())
            }
        }
    }
}
