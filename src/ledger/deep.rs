//! What a deep check asks: where each file that was taken must lie, and whose build a file in the queue is.

use jiff::Timestamp;
use sqlx::FromRow;

use super::{BuildId, BuildRow, Ledger, PartId, PartState, Utc, error::Result};

/// A part as far as its file matters.
#[derive(Debug, Clone, PartialEq, Eq, FromRow)]
pub struct PartPlace {
    /// Its number.
    pub id: PartId,
    /// Name of its claim.
    pub claim: String,
    /// Machine profile.
    pub profile: String,
    /// File name as dropped, escaped for display.
    pub name: String,
    /// BLAKE3 of the file.
    pub content_hash: String,
    /// Size of the file.
    pub bytes: u64,
    /// Where it stands.
    pub state: PartState,
    /// When its state was entered.
    pub state_at: Utc,
}

/// A part with a copy in a published build.
#[derive(Debug, Clone, PartialEq, Eq, FromRow)]
pub struct BuiltPlace {
    /// The build.
    pub build: BuildId,
    /// Machine profile.
    pub profile: String,
    /// Name of the build file.
    pub file_name: String,
    /// The part.
    pub part: PartId,
    /// File name as dropped, escaped for display.
    pub name: String,
    /// BLAKE3 of the file.
    pub content_hash: String,
}

impl Ledger {
    /// Every part that is not built, oldest first.
    pub async fn part_places(&self) -> Result<Vec<PartPlace>> {
        let query = sqlx::query_as(
            "SELECT id, claim, profile, name, content_hash, bytes, state, state_at FROM part \
             WHERE state <> 'built' ORDER BY id",
        );
        Ok(query.fetch_all(self.reader()?).await?)
    }

    /// The parts of every build that was published since then, by build and part.
    pub async fn built_places(&self, since: Timestamp) -> Result<Vec<BuiltPlace>> {
        let query = sqlx::query_as(
            "SELECT DISTINCT b.id AS build, b.profile, b.file_name, p.id AS part, p.name, p.content_hash FROM build b \
             JOIN placement l ON l.build_id = b.id JOIN part p ON p.id = l.part_id \
             WHERE b.published_at >= ? AND b.file_name IS NOT NULL ORDER BY b.id, p.id",
        );
        Ok(query.bind(Utc(since)).fetch_all(self.reader()?).await?)
    }

    /// Whether a part was ever refused or cancelled.
    pub async fn was_rejected(&self, part: PartId) -> Result<bool> {
        let query = sqlx::query_scalar("SELECT EXISTS (SELECT 1 FROM event WHERE part_id = ? AND kind = 'rejected')")
            .bind(part);
        Ok(query.fetch_one(self.reader()?).await?)
    }

    /// How many files of each content were ever recorded, by hash.
    pub async fn drops_by_hash(&self) -> Result<Vec<(String, u32)>> {
        let query = sqlx::query_as(
            "SELECT content_hash, count(*) FROM (SELECT claim, content_hash FROM part \
             UNION SELECT claim, content_hash FROM replacement) GROUP BY content_hash ORDER BY content_hash",
        );
        Ok(query.fetch_all(self.reader()?).await?)
    }

    /// A part of a profile that has this content.
    pub async fn part_of_content(&self, profile: &str, hash: &str) -> Result<Option<PartPlace>> {
        let query = sqlx::query_as(
            "SELECT id, claim, profile, name, content_hash, bytes, state, state_at FROM part \
             WHERE profile = ? AND content_hash = ? ORDER BY id DESC LIMIT 1",
        );
        Ok(query.bind(profile).bind(hash).fetch_optional(self.reader()?).await?)
    }

    /// The build of a profile that has this file name.
    pub async fn build_named(&self, profile: &str, file_name: &str) -> Result<Option<BuildRow>> {
        let query = sqlx::query_as("SELECT * FROM build WHERE profile = ? AND file_name = ?");
        Ok(query.bind(profile).bind(file_name).fetch_optional(self.reader()?).await?)
    }
}
