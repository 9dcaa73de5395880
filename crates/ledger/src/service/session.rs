//! Sessions: the browsers in which people have signed in. The ledger knows only the BLAKE3 of the token that a browser has, so a session
//! holds over a restart and on every node, and nobody gets one by reading the ledger.
//!
//! A session begins when a person gives the password. On a device that several share, others go on with their PIN: the session stays that of
//! the device and changes its person and its token.

use access::Role;
use jiff::SignedDuration;

use crate::{
    Ledger, UtcTimestamp,
    base::{
        error::Result,
        sql::{self, sql_row},
    },
    store::change::LedgerChange,
};

/// A session ends this long after the password was given, hours.
pub const SESSION_HOURS: i64 = 30 * 24;
/// A session in which nothing is done for this time ends, hours.
const IDLE_HOURS: i64 = 7 * 24;
/// On a shared device a person has left who does nothing for this time, minutes.
const LEFT_MINUTES: i64 = 15;
/// Wrong PINs in a row on a device, after which it needs a password.
pub const MAX_WRONG_PINS: i64 = 5;

/// A session that goes on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SessionRow {
    /// Who uses the device; `None` = nobody just now: it is shared.
    pub person: Option<String>,
    /// What that person may do.
    pub role: Option<Role>,
    /// Whether others may go on there with their PIN.
    pub is_shared: bool,
    /// Whether the person gave a PIN.
    pub with_pin: bool,
    /// When the password was given.
    pub opened_at: UtcTimestamp,
    /// When the person did something there, to a minute.
    pub seen_at: UtcTimestamp,
}

sql_row!(SessionRow { person, role, is_shared, with_pin, opened_at, seen_at });

impl Ledger {
    /// The session with a token of this hash; `None` = there is none, or it has ended. From a shared device a person may have left.
    pub async fn find_session(&self, token_hash: &str) -> Result<Option<SessionRow>> {
        let query = sql::query_as::<SessionRow>(
            "SELECT session.person, person.role, session.is_shared, session.with_pin, session.opened_at, session.seen_at \
             FROM session LEFT JOIN person ON person.name = session.person WHERE session.token_hash = $1",
        );
        let found = query.bind(token_hash).fetch_optional(self.reader()?).await?;
        let age = |since: UtcTimestamp| self.now().duration_since(*since);
        let goes_on = |row: &SessionRow| {
            age(row.opened_at) < SignedDuration::from_hours(SESSION_HOURS)
                && age(row.seen_at) < SignedDuration::from_hours(IDLE_HOURS)
        };
        Ok(found.filter(goes_on).map(|row| match row.is_shared {
            true if age(row.seen_at) >= SignedDuration::from_mins(LEFT_MINUTES) => {
                SessionRow { person: None, role: None, ..row }
            }
            _ => row,
        }))
    }

    /// A person has given the password: a session with a new token, in place of the one that the browser had.
    pub async fn open_session(&self, token_hash: &str, person: &str, is_shared: bool, former: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        change.tell_nobody();
        let now = change.now;
        let before = |hours| UtcTimestamp(now.0.saturating_sub(SignedDuration::from_hours(hours)).unwrap_or_default());
        let end = sql::query("DELETE FROM session WHERE token_hash = $1 OR opened_at < $2 OR seen_at < $3");
        end.bind(former).bind(before(SESSION_HOURS)).bind(before(IDLE_HOURS)).execute(change.db()).await?;
        sql::query(
            "INSERT INTO session (token_hash, person, opened_by, is_shared, with_pin, opened_at, seen_at) \
             VALUES ($1, $2, $2, $3, $4, $5, $5)",
        )
        .bind(token_hash)
        .bind(person)
        .bind(is_shared)
        .bind(false)
        .bind(now)
        .execute(change.db())
        .await?;
        let signed_in = sql::query("UPDATE person SET signed_in_at = $1 WHERE name = $2").bind(now).bind(person);
        signed_in.execute(change.db()).await?;
        change.commit().await
    }

    /// Another person uses a shared device from now on, with a new token; `None` = nobody. Returns whether there is such a session.
    pub async fn hand_session_on(&self, token_hash: &str, new_hash: &str, person: Option<&str>) -> Result<bool> {
        let mut change = self.begin_change().await?;
        change.tell_nobody();
        let now = change.now;
        let hand_on = sql::query_scalar::<String>(
            "UPDATE session SET token_hash = $1, person = $2, with_pin = $3, wrong_pins = 0, seen_at = $4 \
             WHERE token_hash = $5 AND is_shared RETURNING token_hash",
        );
        let hand_on = hand_on.bind(new_hash).bind(person).bind(true).bind(now).bind(token_hash);
        let found = hand_on.fetch_optional(change.db()).await?;
        change.commit().await?;
        Ok(found.is_some())
    }

    /// Counts a wrong PIN on a device. Returns whether it was one too many: then the session has ended.
    pub async fn count_wrong_pin(&self, token_hash: &str) -> Result<bool> {
        let mut change = self.begin_change().await?;
        change.tell_nobody();
        let count = sql::query_scalar::<i64>(
            "UPDATE session SET wrong_pins = wrong_pins + 1 WHERE token_hash = $1 RETURNING wrong_pins",
        );
        let wrong = count.bind(token_hash).fetch_optional(change.db()).await?;
        let is_over = wrong.is_none_or(|wrong| wrong >= MAX_WRONG_PINS);
        if is_over {
            sql::query("DELETE FROM session WHERE token_hash = $1").bind(token_hash).execute(change.db()).await?;
        }
        change.commit().await?;
        Ok(is_over)
    }

    /// The person did something in a session.
    pub async fn note_session_seen(&self, token_hash: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        change.tell_nobody();
        let now = change.now;
        let seen = sql::query("UPDATE session SET seen_at = $1 WHERE token_hash = $2").bind(now).bind(token_hash);
        seen.execute(change.db()).await?;
        change.commit().await
    }

    /// Ends a session.
    pub async fn end_session(&self, token_hash: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        change.tell_nobody();
        sql::query("DELETE FROM session WHERE token_hash = $1").bind(token_hash).execute(change.db()).await?;
        change.commit().await
    }

    /// Ends all sessions: a ledger that was put back must not bring those back that people have ended.
    pub async fn end_all_sessions(&self) -> Result<()> {
        let mut change = self.begin_change().await?;
        change.tell_nobody();
        sql::query("DELETE FROM session").execute(change.db()).await?;
        change.commit().await
    }
}

impl LedgerChange {
    /// Ends the sessions of a person, and those of the shared devices for which only this person gave a password.
    pub(super) async fn end_sessions_of(&mut self, person: &str) -> Result<()> {
        let end = sql::query("DELETE FROM session WHERE person = $1 OR opened_by = $1").bind(person);
        end.execute(self.db()).await?;
        Ok(())
    }
}
