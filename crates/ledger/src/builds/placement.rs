//! Placements: which copy of which part is in which build, and its pose there.

use glam::{DQuat, DVec3};
use serde::Serialize;
use solids::Pose;

use crate::{
    BuildId, BuildState, Ledger, PartId, UtcTimestamp,
    base::{
        error::Result,
        sql::{self, sql_row},
    },
};

/// A copy with its proved pose in a build.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProvedPlacement {
    /// The part.
    pub part: PartId,
    /// Its copy, from 0.
    pub copy: u32,
    /// Rotation, unit quaternion x y z w.
    pub rotation: [f64; 4],
    /// Translation after the rotation, machine frame, mm.
    pub translation_mm: [f64; 3],
    /// How it is removed from the cake; `None` = not proved.
    pub removal: Option<RemovalStep>,
}

/// How a copy is removed from the cake, after all copies with a lower position in the removal order. Proved on the
/// triangles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RemovalStep {
    /// Position in the removal order, from 1.
    pub position: u32,
    /// The straight line that it takes: a unit vector in the machine's frame.
    pub direction: [f64; 3],
}

/// A copy that is in a build.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlacementRow {
    /// The part.
    pub part_id: PartId,
    /// Its copy, from 0.
    pub copy: u32,
    /// The build.
    pub build_id: BuildId,
    /// State of the build.
    pub build_state: BuildState,
    /// When the build was put into the queue.
    pub published_at: Option<UtcTimestamp>,
    /// Whether it was told to be printed badly, so that it does not count.
    pub is_bad: bool,
    /// Whether its build was taken back out of the queue before it was printed, so that it does not count.
    pub is_withdrawn: bool,
    /// Whether the printer took the file of its build, as far as is known.
    pub is_taken: bool,
    /// How it stands there.
    #[serde(flatten)]
    pub pose_columns: PoseColumns,
    /// How it is removed from the cake.
    #[serde(flatten)]
    pub removal: RemovalColumns,
}

sql_row!(PlacementRow { part_id, copy, build_id, build_state, published_at, is_bad, is_withdrawn, is_taken; pose_columns, removal });

/// How a copy stands in a build; `None` until the build is verified.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PoseColumns {
    /// Rotation, unit quaternion.
    pub qx: Option<f64>,
    /// Second component of the quaternion.
    pub qy: Option<f64>,
    /// Third component of the quaternion.
    pub qz: Option<f64>,
    /// Real part of the quaternion.
    pub qw: Option<f64>,
    /// Translation after the rotation, machine frame, mm.
    pub tx_mm: Option<f64>,
    /// Translation along y, mm.
    pub ty_mm: Option<f64>,
    /// Translation along z, mm.
    pub tz_mm: Option<f64>,
}

sql_row!(PoseColumns { qx, qy, qz, qw, tx_mm, ty_mm, tz_mm });

/// How a copy is removed from the cake; `None` = not proved.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RemovalColumns {
    /// Its position in the removal order, from 1.
    #[serde(rename = "drawn")]
    pub position: Option<u32>,
    /// Direction of its removal: a unit vector in the machine's frame, first component.
    #[serde(rename = "way_x")]
    pub direction_x: Option<f64>,
    /// Second component of that direction.
    #[serde(rename = "way_y")]
    pub direction_y: Option<f64>,
    /// Third component of that direction.
    #[serde(rename = "way_z")]
    pub direction_z: Option<f64>,
}

sql_row!(RemovalColumns { position = "drawn", direction_x = "way_x", direction_y = "way_y", direction_z = "way_z" });

impl PlacementRow {
    /// Pose of the copy, mesh frame -> machine frame; `None` until the build is verified, or if the row is damaged.
    pub fn pose(&self) -> Option<Pose> {
        let PoseColumns { qx, qy, qz, qw, tx_mm, ty_mm, tz_mm } = self.pose_columns;
        Pose::from_stored(DQuat::from_xyzw(qx?, qy?, qz?, qw?), DVec3::new(tx_mm?, ty_mm?, tz_mm?)).ok()
    }

    /// How the copy is removed from the cake; `None` = not proved.
    pub fn removal_step(&self) -> Option<RemovalStep> {
        let RemovalColumns { position, direction_x, direction_y, direction_z } = self.removal;
        Some(RemovalStep { position: position?, direction: [direction_x?, direction_y?, direction_z?] })
    }
}

impl Ledger {
    /// The placements of a part, by copy.
    pub async fn placements_of_part(&self, part: PartId) -> Result<Vec<PlacementRow>> {
        let query = sql::select_as(
            "FROM (SELECT l.*, b.state AS build_state, b.published_at, \
             b.withdrawn_at IS NOT NULL AS is_withdrawn, b.taken_at IS NOT NULL AS is_taken FROM build_copy l JOIN build b ON b.id = l.build_id) \
             AS placed WHERE part_id = $1 ORDER BY copy, build_id",
        );
        Ok(query.bind(part).fetch_all(self.reader()?).await?)
    }

    /// The copies in a build with their poses, by part and copy.
    pub async fn placements_of_build(&self, build: BuildId) -> Result<Vec<PlacementRow>> {
        let query = sql::select_as(
            "FROM (SELECT l.*, b.state AS build_state, b.published_at, \
             b.withdrawn_at IS NOT NULL AS is_withdrawn, b.taken_at IS NOT NULL AS is_taken FROM build_copy l JOIN build b ON b.id = l.build_id) \
             AS placed WHERE build_id = $1 ORDER BY part_id, copy",
        );
        Ok(query.bind(build).fetch_all(self.reader()?).await?)
    }

    /// The copies of a build that count, by part and copy.
    pub async fn counted_copies(&self, build: BuildId) -> Result<Vec<(PartId, u32)>> {
        let query = sql::query_as("SELECT part_id, copy FROM placement WHERE build_id = $1 ORDER BY part_id, copy");
        Ok(query.bind(build).fetch_all(self.reader()?).await?)
    }

    /// Volume of the parts of a build, mm3.
    pub async fn volume_of_build(&self, build: BuildId) -> Result<f64> {
        let query = sql::query_scalar(
            "SELECT CAST(coalesce(sum(p.volume_mm3), 0.0) AS DOUBLE PRECISION) FROM placement l JOIN part p ON p.id = l.part_id \
             WHERE l.build_id = $1",
        );
        Ok(query.bind(build).fetch_one(self.reader()?).await?)
    }

    /// The copies taken into a build, by part and copy.
    pub async fn copies_of_build(&self, build: BuildId) -> Result<Vec<(PartId, u32)>> {
        let query = sql::query_as("SELECT part_id, copy FROM build_copy WHERE build_id = $1 ORDER BY part_id, copy");
        Ok(query.bind(build).fetch_all(self.reader()?).await?)
    }
}
