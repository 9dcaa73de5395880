//! Work that depends on a mesh only, kept from one run to the next. What is kept guides the search and never decides:
//! the trees that prove clearance are always built from the triangles, so no kept byte can make a build wrong.

use solids::{Mesh, Obb, Pose};

use super::{
    body::Body,
    field::DistanceField,
    outline::Outline,
    pack::{Packer, Unpacker},
};

/// A place to keep bytes by key. What it gives back may be missing or stale, but not altered: implementations check
/// it. Asked from several threads at once.
///
/// ```
/// use std::{collections::HashMap, sync::{Arc, Mutex}};
/// use nester::{Cache, PreparedMeshes};
///
/// #[derive(Default)]
/// struct MemoryCache(Mutex<HashMap<String, Vec<u8>>>);
///
/// impl Cache for MemoryCache {
///     fn fetch(&self, key: &str) -> Option<Vec<u8>> {
///         self.0.lock().ok()?.get(key).cloned()
///     }
///     fn keep(&self, key: &str, bytes: &[u8]) {
///         if let Ok(mut kept) = self.0.lock() {
///             kept.insert(key.to_owned(), bytes.to_vec());
///         }
///     }
/// }
///
/// let prepared = PreparedMeshes::default().with_cache(Some(Arc::new(MemoryCache::default())));
/// # assert!(prepared.is_empty());
/// ```
pub trait Cache: Sync {
    /// What was kept under a key, if it is still there and whole.
    fn fetch(&self, key: &str) -> Option<Vec<u8>>;
    /// Keeps bytes under a key. Failing to is no error: the work is done again.
    fn keep(&self, key: &str, bytes: &[u8]);
}

/// Part of every key; another number for another meaning of the bytes or another way to work them out.
const VERSION: u32 = 1;

/// The name of a mesh by its content: equal meshes have equal names, wherever they come from.
pub(crate) fn name_of(mesh: &Mesh) -> String {
    let mut hasher = blake3::Hasher::new();
    let mut bytes = Vec::with_capacity(1 << 16);
    let mut flush = |bytes: &mut Vec<u8>, most: usize| {
        if bytes.len() > most {
            hasher.update(bytes);
            bytes.clear();
        }
    };
    bytes.extend((mesh.vertices().len() as u64).to_le_bytes());
    for vertex in mesh.vertices() {
        vertex.to_array().iter().for_each(|v| bytes.extend(v.to_le_bytes()));
        flush(&mut bytes, 65_000);
    }
    for corners in mesh.triangles() {
        corners.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
        flush(&mut bytes, 65_000);
    }
    flush(&mut bytes, 0);
    hasher.finalize().to_hex().to_string()
}

/// The key of a kind of work on a mesh.
pub(crate) fn key_of(kind: &str, mesh_name: &str) -> String {
    format!("{kind}-{VERSION}-{mesh_name}")
}

/// An outline as bytes.
pub(crate) fn pack_outline(outline: &Outline) -> Vec<u8> {
    let mut packer = Packer::default();
    packer.f64s(&outline.obb.pose.rotation.to_array());
    packer.f64s(&outline.obb.pose.translation.to_array());
    packer.f64s(&outline.obb.half_mm.to_array());
    packer.f64s(&[outline.radius_mm]);
    packer.u32(outline.extremes.len() as u32);
    outline.extremes.iter().for_each(|p| packer.f64s(&p.to_array()));
    packer.0
}

/// An outline from bytes.
pub(crate) fn unpack_outline(bytes: &[u8]) -> Option<Outline> {
    let mut from = Unpacker(bytes);
    let rotation = glam::DQuat::from_array(from.f64s()?);
    let pose = Pose { rotation, translation: from.f64s()?.into() };
    let obb = Obb { pose, half_mm: from.f64s()?.into() };
    let [radius_mm] = from.f64s()?;
    let count = from.u32()?;
    let extremes: Vec<glam::DVec3> = (0..count).map(|_| from.f64s().map(Into::into)).collect::<Option<_>>()?;
    (from.0.is_empty() && rotation.is_normalized() && !extremes.is_empty()).then_some(Outline {
        obb,
        extremes,
        radius_mm,
    })
}

/// Guides as bytes: signed distances, many points and few.
pub(crate) fn pack_guides(field: &DistanceField, fine: &Body, coarse: &Body) -> Vec<u8> {
    let mut packer = Packer::default();
    field.pack(&mut packer);
    fine.pack(&mut packer);
    coarse.pack(&mut packer);
    packer.0
}

/// Guides from bytes.
pub(crate) fn unpack_guides(bytes: &[u8]) -> Option<(DistanceField, Body, Body)> {
    let mut from = Unpacker(bytes);
    let guides = (DistanceField::unpack(&mut from)?, Body::unpack(&mut from)?, Body::unpack(&mut from)?);
    from.0.is_empty().then_some(guides)
}
