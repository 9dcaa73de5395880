//! What the 3D view draws: every mesh once, made light, and where its copies stand.
//!
//! The answer is binary, little-endian: the length of a JSON text (u32), the text, padded to four bytes, then for each mesh
//! its vertices (f32 x 3) and its triangles (u32 x 3).

use std::sync::Arc;

use anyhow::Context;
use axum::{
    body::Bytes,
    extract::{Path, State},
    http::header,
    response::{IntoResponse, Response},
};
use serde::Serialize;

use super::{
    cache::Kept,
    problem::{Answer, Problem},
    reduce::reduce,
    server::Web,
};
use crate::{
    farm::{Cake, CakePart, Standing, standing},
    geometry::Mesh,
    ledger::{BuildId, BuildRow},
    settings::Profile,
};

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

/// A build and its profile, as it was when the build was made.
pub(super) async fn build_of(web: &Web, number: i64) -> Answer<(BuildRow, Profile)> {
    let missing = || Problem::NotFound(format!("build {number}"));
    let build = web.ledger.build(BuildId(number)).await?.ok_or_else(missing)?;
    let settings = web.settings();
    let now = settings.profiles.get(&build.profile);
    let profile = Profile::then(&build.profile, build.profile_snapshot.as_deref(), now);
    Ok((build, profile))
}

/// What is made of a build's cake, or was: away from the threads that answer, one after the other, and kept also when nobody
/// waits for it any more.
pub(super) async fn of_cake<T: Clone + Send + 'static>(
    web: &Arc<Web>,
    build: &BuildRow,
    profile: &Profile,
    kept: Kept<T>,
    make: impl FnOnce(&Cake) -> anyhow::Result<T> + Send + 'static,
) -> Answer<T> {
    let known = || (kept.cache)(web).get(&kept.key);
    if let Some(thing) = known() {
        return Ok(thing);
    }
    let turn = web.looking.clone().acquire_owned().await.context("waiting for a turn")?;
    if let Some(thing) = known() {
        return Ok(thing);
    }
    let parts = standing(&web.ledger, build, profile).await?;
    let (web, build, profile) = (web.clone(), build.clone(), profile.clone());
    let making = tokio::task::spawn_blocking(move || {
        let _turn = turn;
        let thing = make(&Cake::of_ledger(&web.settings(), &profile, &build, parts))?;
        (kept.cache)(&web).put(kept.key, thing.clone());
        Ok(thing)
    });
    let made: anyhow::Result<T> = making.await.context("looking at the build")?;
    Ok(made?)
}

/// The scene of a build.
pub(super) async fn scene(State(web): State<Arc<Web>>, Path(number): Path<i64>) -> Answer<Response> {
    let (build, profile) = build_of(&web, number).await?;
    let kept = Kept { cache: |web| &web.scenes, key: version(&build) };
    let facts = (build.id.0, build.height_mm, profile.layer_mm);
    let pack = move |cake: &Cake| Ok(Bytes::from(packed(cake, facts, MOST_DRAWN)?));
    let bytes = of_cake(&web, &build, &profile, kept, pack).await?;
    Ok(([(header::CONTENT_TYPE, "application/octet-stream")], bytes).into_response())
}

/// A text that is another one when something else stands in the build, or stands otherwise.
pub(super) fn version(build: &BuildRow) -> String {
    let layout = blake3::hash(build.layout.as_deref().unwrap_or_default().as_bytes()).to_hex();
    format!("{}-{}-{}", build.id, build.state, &layout[..16])
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
