//! The scene of the 3D view: every mesh once, with fewer triangles, and the poses of its copies.
//!
//! The response is binary, little-endian: the length of a JSON text (u32), the text padded to four bytes, then for each mesh the x of
//! its vertices, their y, their z and the corners of its triangles, each number as the difference to the one before (u16, modulo
//! 65,536), which compresses well. A coordinate is `low_mm` + `step_mm` x number.

use std::sync::Arc;

use anyhow::Context;
use axum::{
    extract::{Path, State},
    http::HeaderMap,
    response::Response,
};
use farm::{CakeContents, CakeCopy, CakePart};
use flate2::Compression;
use serde::Serialize;
use solids::Mesh;

use super::{
    cached_render::{CacheLocation, find_build, layout_version, render_cached},
    state::DashboardState,
};
use crate::web::{
    base::{compressed::CompressedBody, error::HandlerResult},
    figures::mesh_reduction::{ReducedMesh, reduce_mesh},
};

/// Approximate limit of the triangles in a view.
const MAX_TRIANGLES: usize = 700_000;
/// Lower and upper limit of the triangles of one mesh; it may keep twice as many, which have fewer than 65,536 vertices.
const TRIANGLES_PER_MESH: (usize, usize) = (150, 10_000);
/// Scenes in the cache.
pub(crate) const CACHED_SCENES: usize = 8;

#[derive(Serialize)]
struct SceneHeader {
    build: i64,
    volume_mm: [f64; 3],
    height_mm: Option<f64>,
    layer_mm: f64,
    /// Copies whose original files are no longer kept.
    missing_copies: usize,
    meshes: Vec<SceneMesh>,
}

#[derive(Serialize)]
struct SceneMesh {
    part: i64,
    name: String,
    order: String,
    /// When it is due, as people read it, "" = no date.
    due: String,
    vertices: usize,
    triangles: usize,
    /// Whether it may be seen that its file has more triangles.
    is_simplified: bool,
    /// The lowest coordinates, and the length of a step, mm.
    low_mm: [f32; 3],
    step_mm: f32,
    copies: Vec<SceneCopy>,
}

#[derive(Serialize)]
struct SceneCopy {
    copy: u32,
    rotation: [f64; 4],
    translation_mm: [f64; 3],
    low_mm: f64,
    top_mm: f64,
    /// Its step in the proved order of removal, from 1; `None` = not proved.
    step: Option<u32>,
}

/// The scene of a build.
pub(crate) async fn get_scene(
    State(web): State<Arc<DashboardState>>,
    Path(number): Path<i64>,
    headers: HeaderMap,
) -> HandlerResult<Response> {
    let (build, profile) = find_build(&web, number).await?;
    let kept = CacheLocation { cache: |web| &web.caches.scenes, key: layout_version(&build), only: None };
    let facts = (build.id.0, build.measures.height_mm, profile.space.layer_mm);
    let pack = move |cake: &CakeContents| {
        Ok(CompressedBody::new(&pack_scene(cake, facts, MAX_TRIANGLES)?, Compression::default())?)
    };
    let body = render_cached(&web, &build, &profile, kept, pack).await?;
    Ok(body.answer(&headers, "application/octet-stream", "private, no-cache").context("sending a scene")?)
}

/// Packs a cake for the view, with about `triangle_target` triangles. The tuple is the build's number, its height in mm and
/// the layer height in mm.
pub(crate) fn pack_scene(
    cake: &CakeContents,
    (build, height_mm, layer_mm): (i64, Option<f64>, f64),
    triangle_target: usize,
) -> anyhow::Result<Vec<u8>> {
    let per_copy = (triangle_target / cake.copy_count().max(1)).clamp(TRIANGLES_PER_MESH.0, TRIANGLES_PER_MESH.1);
    let (mut meshes, mut bytes) = (Vec::new(), Vec::new());
    for part in &cake.parts {
        // The original of this part is no longer kept: only the other parts are shown.
        let Some(mesh) = &part.mesh else { continue };
        let reduced = reduce_mesh(mesh, per_copy);
        let (low_mm, step_mm) = quantisation(&reduced);
        meshes.push(SceneMesh {
            part: part.part,
            name: part.name.clone(),
            order: part.order.clone(),
            due: part.due.clone(),
            vertices: reduced.vertices.len(),
            triangles: reduced.triangles.len(),
            is_simplified: reduced.is_simplified,
            low_mm,
            step_mm,
            copies: scene_copies(part, mesh),
        });
        for axis in 0..3 {
            let steps = |v: &[f32; 3]| ((v[axis] - low_mm[axis]) / step_mm).round() as u16;
            push_differences(&mut bytes, reduced.vertices.iter().map(steps));
        }
        push_differences(&mut bytes, reduced.triangles.iter().flatten().map(|&corner| corner as u16));
    }
    let gone = cake.parts.iter().filter(|part| part.mesh.is_none());
    let missing_copies = gone.map(|part| part.copies.len()).sum();
    let scene =
        SceneHeader { build, volume_mm: cake.volume_mm.to_array(), height_mm, layer_mm, missing_copies, meshes };
    let mut text = serde_json::to_vec(&scene)?;
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut whole = (text.len() as u32).to_le_bytes().to_vec();
    whole.extend(text);
    whole.extend(bytes);
    Ok(whole)
}

/// The lowest coordinates of a mesh, and the step in which 16 bits reach over its longest side, mm.
fn quantisation(mesh: &ReducedMesh) -> ([f32; 3], f32) {
    let fold = |of: fn(f32, f32) -> f32, start: f32| {
        mesh.vertices.iter().fold([start; 3], |all, v| std::array::from_fn(|axis| of(all[axis], v[axis])))
    };
    let (low, high): ([f32; 3], [f32; 3]) = (fold(f32::min, f32::MAX), fold(f32::max, f32::MIN));
    let longest = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f32::max);
    (low, (longest / f32::from(u16::MAX)).max(f32::MIN_POSITIVE))
}

/// Appends numbers as differences, each to the one before.
fn push_differences(bytes: &mut Vec<u8>, numbers: impl Iterator<Item = u16>) {
    let mut last = 0u16;
    for number in numbers {
        bytes.extend(number.wrapping_sub(last).to_le_bytes());
        last = number;
    }
}

fn scene_copies(part: &CakePart, mesh: &Mesh) -> Vec<SceneCopy> {
    let copy = |standing: &CakeCopy| {
        let bounds = mesh.bounds_at(&standing.pose);
        SceneCopy {
            copy: standing.copy,
            rotation: standing.pose.rotation.to_array(),
            translation_mm: standing.pose.translation.to_array(),
            low_mm: bounds.min.z,
            top_mm: bounds.max.z,
            step: standing.drawn.map(|drawn| drawn.position),
        }
    };
    part.copies.iter().map(copy).collect()
}
