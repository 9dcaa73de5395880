//! What the 3D view draws: every mesh once, made light, and where its copies stand.
//!
//! The answer is binary, little-endian: the length of a JSON text (u32), the text, padded to four bytes, then for each mesh
//! its vertices (f32 x 3) and its triangles (u32 x 3).

use std::{
    collections::{BTreeMap, HashMap},
    path::PathBuf,
    sync::{Arc, Mutex, PoisonError},
};

use anyhow::Context;
use axum::{
    body::Bytes,
    extract::{Path, State},
    http::header,
    response::{IntoResponse, Response},
};
use glam::DVec3;
use serde::Serialize;

use super::{
    problem::{Answer, Problem},
    reduce::reduce,
    server::Web,
    words::full_name,
};
use crate::{
    farm::{Meshes, Shelf, placed_from_json},
    format,
    geometry::{Mesh, Pose},
    intake::Store,
    ledger::{BuildId, BuildRow, BuildState, Ledger, PartId, PartRow},
    settings::{Profile, Settings},
};

/// Triangles that a view draws in all, about.
const MOST_DRAWN: usize = 700_000;
/// Triangles of one mesh: at least, at most.
const OF_MESH: (usize, usize) = (150, 20_000);
/// Scenes that are kept.
const KEPT: usize = 8;

/// A copy that stands in a build.
#[derive(Debug, Clone)]
pub(super) struct Standing {
    pub(super) part: PartId,
    /// From 0.
    pub(super) copy: u32,
    /// Mesh frame -> machine frame, mm.
    pub(super) pose: Pose,
}

/// Scenes that were made, by build and what makes it another one.
#[derive(Debug, Default)]
pub(super) struct Scenes(Mutex<Vec<(String, Bytes)>>);

#[derive(Serialize)]
struct Scene {
    build: BuildId,
    volume_mm: [f64; 3],
    height_mm: Option<f64>,
    layer_mm: f64,
    meshes: Vec<Shown>,
}

#[derive(Serialize)]
struct Shown {
    part: PartId,
    name: String,
    order: String,
    vertices: usize,
    triangles: usize,
    copies: Vec<Copy>,
}

#[derive(Serialize)]
struct Copy {
    copy: u32,
    rotation: [f64; 4],
    translation_mm: [f64; 3],
    low_mm: f64,
    top_mm: f64,
}

/// Where the copies of a build stand: of one that is past nesting as proved, else as in its layout so far.
pub(super) async fn standing(ledger: &Ledger, build: &BuildRow, profile: &Profile) -> Answer<Vec<Standing>> {
    if matches!(build.state, BuildState::Open | BuildState::Nesting) {
        let placed = placed_from_json(build.layout.as_deref().unwrap_or_default());
        let moved = |pose: Pose| Pose { translation: pose.translation + profile.origin_mm(), ..pose };
        return Ok(placed
            .into_iter()
            .map(|p| Standing { part: p.copy.0, copy: p.copy.1, pose: moved(p.pose) })
            .collect());
    }
    let rows = ledger.placements_of_build(build.id).await?;
    let standing = rows.iter().filter_map(|row| {
        let turn = glam::DQuat::from_xyzw(row.qx?, row.qy?, row.qz?, row.qw?);
        let pose = Pose::new(turn, DVec3::new(row.tx_mm?, row.ty_mm?, row.tz_mm?));
        Some(Standing { part: row.part_id, copy: row.copy, pose })
    });
    Ok(standing.collect())
}

/// The parts of copies, with their copies, by part.
pub(super) async fn by_part(ledger: &Ledger, standing: Vec<Standing>) -> Answer<Vec<(PartRow, Vec<Standing>)>> {
    let mut by_part: BTreeMap<PartId, Vec<Standing>> = BTreeMap::new();
    for copy in standing {
        by_part.entry(copy.part).or_default().push(copy);
    }
    let mut parts = Vec::with_capacity(by_part.len());
    for (id, copies) in by_part {
        if let Some(part) = ledger.part(id).await? {
            parts.push((part, copies));
        }
    }
    Ok(parts)
}

/// The meshes of a build's parts: out of the store as long as they wait there, then out of the archive.
pub(super) struct Bodies {
    meshes: Meshes,
    profile: Profile,
    /// Archived originals by their content.
    archived: HashMap<String, PathBuf>,
}

impl Bodies {
    /// Those of a build.
    pub(super) fn new(settings: &Settings, profile: &Profile, build: &BuildRow) -> anyhow::Result<Self> {
        let store = Store::open(settings.state_dir.join("store"))?;
        let meshes = Meshes { shelf: Shelf::default(), store, limits: settings.limits.clone(), cache: None };
        let stem = build.file_name.as_deref().and_then(|name| name.strip_suffix(".build.3mf"));
        let folder = stem.map(|stem| profile.folders.archive.join(stem));
        let files = folder.and_then(|folder| std::fs::read_dir(folder).ok()).into_iter().flatten().flatten();
        let known = |path: PathBuf| Some((hash_of(&path).ok()?.to_hex().to_string(), path));
        let archived = files.filter_map(|file| known(file.path())).collect();
        Ok(Self { meshes, profile: profile.clone(), archived })
    }

    /// The mesh of a part; `None` when its original is past its keeping.
    pub(super) fn mesh(&self, part: &PartRow) -> Option<Arc<Mesh>> {
        if let Ok(mesh) = self.meshes.mesh(&self.profile, part) {
            return Some(mesh);
        }
        let file = self.archived.get(&part.content_hash)?;
        let contents = format::read(file, &part.name, part.unit, self.profile.unit, &self.meshes.limits).ok()?;
        Some(Arc::new(contents.solids.into_iter().nth(part.object_index as usize)?.mesh))
    }
}

fn hash_of(file: &std::path::Path) -> std::io::Result<blake3::Hash> {
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(std::fs::File::open(file)?)?;
    Ok(hasher.finalize())
}

/// A build and its profile.
pub(super) async fn build_of(web: &Web, number: i64) -> Answer<(BuildRow, Profile)> {
    let missing = || Problem::NotFound(format!("build {number}"));
    let build = web.ledger.build(BuildId(number)).await?.ok_or_else(missing)?;
    let settings = web.settings();
    let profile = settings.profiles.get(&build.profile).cloned();
    let profile = profile.ok_or_else(|| Problem::NotFound(format!("profile {} any more", build.profile)))?;
    Ok((build, profile))
}

/// The scene of a build.
pub(super) async fn scene(State(web): State<Arc<Web>>, Path(number): Path<i64>) -> Answer<Response> {
    let (build, profile) = build_of(&web, number).await?;
    let key = format!("{} {} {:x}", build.id, build.state, crc(build.layout.as_deref().unwrap_or_default()));
    let known = web.scenes.0.lock().unwrap_or_else(PoisonError::into_inner).iter().find(|(k, _)| *k == key).cloned();
    let bytes = match known {
        Some((_, bytes)) => bytes,
        None => {
            let standing = standing(&web.ledger, &build, &profile).await?;
            let parts = by_part(&web.ledger, standing).await?;
            let settings = web.settings();
            let made = tokio::task::spawn_blocking(move || make(&settings, &build, &profile, parts)).await;
            let bytes = Bytes::from(made.context("making the scene")??);
            let mut scenes = web.scenes.0.lock().unwrap_or_else(PoisonError::into_inner);
            scenes.insert(0, (key, bytes.clone()));
            scenes.truncate(KEPT);
            bytes
        }
    };
    Ok(([(header::CONTENT_TYPE, "application/octet-stream")], bytes).into_response())
}

/// A number for a text that is another one when the text is.
fn crc(text: &str) -> u64 {
    u64::from_le_bytes(std::array::from_fn(|at| blake3::hash(text.as_bytes()).as_bytes()[at]))
}

fn make(
    settings: &Settings,
    build: &BuildRow,
    profile: &Profile,
    parts: Vec<(PartRow, Vec<Standing>)>,
) -> anyhow::Result<Vec<u8>> {
    let bodies = Bodies::new(settings, profile, build)?;
    let drawn: usize = parts.iter().map(|(_, copies)| copies.len()).sum();
    let most = (MOST_DRAWN / drawn.max(1)).clamp(OF_MESH.0, OF_MESH.1);
    let (mut shown, mut bytes) = (Vec::new(), Vec::new());
    for (part, copies) in parts {
        // An original that is past its keeping is not there any more: the others are shown.
        let Some(mesh) = bodies.mesh(&part) else { continue };
        let light = reduce(&mesh, most);
        let copy = |standing: &Standing| {
            let bounds = mesh.bounds_at(&standing.pose);
            Copy {
                copy: standing.copy + 1,
                rotation: standing.pose.rotation.to_array(),
                translation_mm: standing.pose.translation.to_array(),
                low_mm: bounds.min.z,
                top_mm: bounds.max.z,
            }
        };
        shown.push(Shown {
            part: part.id,
            name: full_name(&part),
            order: part.order_name.clone(),
            vertices: light.vertices.len(),
            triangles: light.triangles.len(),
            copies: copies.iter().map(copy).collect(),
        });
        bytes.extend(light.vertices.iter().flatten().flat_map(|v| v.to_le_bytes()));
        bytes.extend(light.triangles.iter().flatten().flat_map(|v| v.to_le_bytes()));
    }
    let (build, volume_mm, height_mm) = (build.id, profile.volume_mm.to_array(), build.height_mm);
    let mut text =
        serde_json::to_vec(&Scene { build, volume_mm, height_mm, layer_mm: profile.layer_mm, meshes: shown })?;
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut whole = (text.len() as u32).to_le_bytes().to_vec();
    whole.extend(text);
    whole.extend(bytes);
    Ok(whole)
}
