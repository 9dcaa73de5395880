//! What the 3D view draws: every mesh once, made light, and where its copies stand.
//!
//! The answer is binary, little-endian: the length of a JSON text (u32), the text, padded to four bytes, then for each mesh
//! its vertices (f32 x 3) and its triangles (u32 x 3).

use std::sync::Arc;

use axum::{
    body::Bytes,
    extract::{Path, State},
    http::header,
    response::{IntoResponse, Response},
};
use serde::Serialize;
use solids::Mesh;

use super::{
    problem::Answer,
    reduce::reduce,
    render::{Kept, build_of, of_cake, version},
    state::Web,
};
use crate::farm::{Cake, CakePart, Standing};

/// Triangles that a view draws in all, about.
const MOST_DRAWN: usize = 700_000;
/// Triangles of one mesh: at least, at most.
const OF_MESH: (usize, usize) = (150, 20_000);
/// Scenes that are kept.
pub(super) const KEPT: usize = 8;

#[derive(Serialize)]
struct Scene {
    build: i64,
    volume_mm: [f64; 3],
    height_mm: Option<f64>,
    layer_mm: f64,
    /// Copies whose originals are past their keeping.
    missing_copies: usize,
    meshes: Vec<Shown>,
}

#[derive(Serialize)]
struct Shown {
    part: i64,
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

/// The scene of a build.
pub(super) async fn scene(State(web): State<Arc<Web>>, Path(number): Path<i64>) -> Answer<Response> {
    let (build, profile) = build_of(&web, number).await?;
    let kept = Kept { cache: |web| &web.caches.scenes, key: version(&build) };
    let facts = (build.id.0, build.measures.height_mm, profile.space.layer_mm);
    let pack = move |cake: &Cake| Ok(Bytes::from(packed(cake, facts, MOST_DRAWN)?));
    let bytes = of_cake(&web, &build, &profile, kept, pack).await?;
    Ok(([(header::CONTENT_TYPE, "application/octet-stream")], bytes).into_response())
}

/// A cake as the view takes it, of about `most_drawn` triangles; `facts` are the build's number, height and layer, mm.
pub(super) fn packed(
    cake: &Cake,
    (build, height_mm, layer_mm): (i64, Option<f64>, f64),
    most_drawn: usize,
) -> anyhow::Result<Vec<u8>> {
    let most = (most_drawn / cake.copies().max(1)).clamp(OF_MESH.0, OF_MESH.1);
    let (mut meshes, mut bytes) = (Vec::new(), Vec::new());
    for part in &cake.parts {
        // An original that is past its keeping is not there any more: the others are shown.
        let Some(mesh) = &part.mesh else { continue };
        let light = reduce(mesh, most);
        meshes.push(Shown {
            part: part.part,
            name: part.name.clone(),
            order: part.order.clone(),
            vertices: light.vertices.len(),
            triangles: light.triangles.len(),
            copies: shown_copies(part, mesh),
        });
        bytes.extend(light.vertices.iter().flatten().flat_map(|v| v.to_le_bytes()));
        bytes.extend(light.triangles.iter().flatten().flat_map(|v| v.to_le_bytes()));
    }
    let gone = cake.parts.iter().filter(|part| part.mesh.is_none());
    let missing_copies = gone.map(|part| part.copies.len()).sum();
    let scene = Scene { build, volume_mm: cake.volume_mm.to_array(), height_mm, layer_mm, missing_copies, meshes };
    let mut text = serde_json::to_vec(&scene)?;
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut whole = (text.len() as u32).to_le_bytes().to_vec();
    whole.extend(text);
    whole.extend(bytes);
    Ok(whole)
}

fn shown_copies(part: &CakePart, mesh: &Mesh) -> Vec<Copy> {
    let copy = |standing: &Standing| {
        let bounds = mesh.bounds_at(&standing.pose);
        Copy {
            copy: standing.copy,
            rotation: standing.pose.rotation.to_array(),
            translation_mm: standing.pose.translation.to_array(),
            low_mm: bounds.min.z,
            top_mm: bounds.max.z,
        }
    };
    part.copies.iter().map(copy).collect()
}
