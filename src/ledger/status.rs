//! Status: what waits, what is being nested and what was published last, per machine profile.

use serde::Serialize;
use sqlx::FromRow;

use super::{BuildId, BuildState, Utc};

/// A machine profile as it stands. Profiles about which the ledger knows nothing have none.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ProfileStatus {
    /// Its name.
    pub profile: String,
    /// Claimed parts that are not read yet.
    pub claimed_parts: u32,
    /// Parts with a copy that waits.
    pub waiting_parts: u32,
    /// Copies that wait.
    pub waiting_copies: u32,
    /// Rejected parts.
    pub rejected_parts: u32,
    /// When the oldest waiting part was claimed.
    pub oldest_at: Option<Utc>,
    /// The nearest due date of the waiting parts.
    pub due_at: Option<Utc>,
    /// The open build.
    pub open: Option<OpenBuild>,
    /// Builds that are being nested or published.
    pub nesting: Vec<NestingBuild>,
    /// Who has paused it.
    pub paused: Option<Paused>,
    /// The build that was published last.
    pub last_published: Option<PublishedBuild>,
}

/// The forecast of the next build.
#[derive(Debug, Clone, PartialEq, Serialize, FromRow)]
pub struct OpenBuild {
    /// Its number.
    pub build: BuildId,
    /// Height of its layout so far, mm.
    pub height_mm: Option<f64>,
    /// Density of its layout so far, 0..1.
    pub density: Option<f64>,
    /// Copies in its layout so far.
    pub copies: Option<u32>,
}

/// A build that has fired and is not published.
#[derive(Debug, Clone, PartialEq, Serialize, FromRow)]
pub struct NestingBuild {
    /// Its number.
    pub build: BuildId,
    /// Nesting or verified.
    pub state: BuildState,
    /// Copies taken into it.
    pub copies: u32,
    /// Trigger.
    pub fired_by: String,
    /// How often nesting was begun.
    pub attempts: u32,
    /// When it fired.
    pub nesting_at: Option<Utc>,
}

/// A pause.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, FromRow)]
pub struct Paused {
    /// user@host.
    pub paused_by: String,
    /// When.
    pub paused_at: Utc,
}

/// A build in the queue.
#[derive(Debug, Clone, PartialEq, Serialize, FromRow)]
pub struct PublishedBuild {
    /// Its number.
    pub build: BuildId,
    /// When it came into the queue.
    pub published_at: Utc,
    /// Build height, mm.
    pub height_mm: Option<f64>,
    /// Density, 0..1.
    pub density: Option<f64>,
    /// Placements.
    pub copies: Option<u32>,
    /// Name of the build file.
    pub file_name: Option<String>,
}
