//! Caches prepared data that depends on a mesh only, between runs. Cached data guides the search and never decides
//! validity: the trees that prove clearance are always built from the triangles, so a cached byte cannot make a build
//! wrong.

use solids::{Mesh, Obb, Pose};

use super::{
    byte_codec::{ByteReader, ByteWriter},
    distance_field::DistanceField,
    outline::MeshOutline,
    sphere_tree::SphereTree,
};

/// A key-value store for bytes. A value may be missing or stale but must not be altered: implementations check that.
/// Called from several threads at once.
///
/// ```
/// use std::{collections::HashMap, sync::{Arc, Mutex}};
/// use nester::{PreparedMeshCache, PreparedMeshes};
///
/// #[derive(Default)]
/// struct MemoryCache(Mutex<HashMap<String, Vec<u8>>>);
///
/// impl PreparedMeshCache for MemoryCache {
///     fn fetch_bytes(&self, key: &str) -> Option<Vec<u8>> {
///         self.0.lock().ok()?.get(key).cloned()
///     }
///     fn store_bytes(&self, key: &str, bytes: &[u8]) {
///         if let Ok(mut kept) = self.0.lock() {
///             kept.insert(key.to_owned(), bytes.to_vec());
///         }
///     }
/// }
///
/// let prepared = PreparedMeshes::default().with_cache(Some(Arc::new(MemoryCache::default())));
/// # assert!(prepared.is_empty());
/// ```
pub trait PreparedMeshCache: Sync {
    /// Returns the value stored under a key, if it still exists and is intact.
    fn fetch_bytes(&self, key: &str) -> Option<Vec<u8>>;
    /// Stores bytes under a key. A failure is not an error: the data is computed again.
    fn store_bytes(&self, key: &str, bytes: &[u8]);
}

/// Version in every key. It changes with the format of the bytes or the method that computes them.
const VERSION: u32 = 2;

/// The content hash of a mesh: equal meshes have equal hashes, wherever they come from.
pub(crate) fn mesh_content_hash(mesh: &Mesh) -> String {
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

/// The key of a kind of prepared data of a mesh.
pub(crate) fn cache_key(kind: &str, mesh_name: &str) -> String {
    format!("{kind}-{VERSION}-{mesh_name}")
}

/// Encodes an outline as bytes.
pub(crate) fn pack_outline(outline: &MeshOutline) -> Vec<u8> {
    let mut packer = ByteWriter::default();
    packer.write_f64s(&outline.obb.pose.rotation.to_array());
    packer.write_f64s(&outline.obb.pose.translation.to_array());
    packer.write_f64s(&outline.obb.half_mm.to_array());
    packer.write_f64s(&[outline.radius_mm]);
    packer.write_u32(outline.extremes.len() as u32);
    outline.extremes.iter().for_each(|p| packer.write_f64s(&p.to_array()));
    packer.0
}

/// Decodes an outline from bytes.
pub(crate) fn unpack_outline(bytes: &[u8]) -> Option<MeshOutline> {
    let mut from = ByteReader(bytes);
    let rotation = glam::DQuat::from_array(from.read_f64s()?);
    let pose = Pose { rotation, translation: from.read_f64s()?.into() };
    let obb = Obb { pose, half_mm: from.read_f64s()?.into() };
    let [radius_mm] = from.read_f64s()?;
    let count = from.read_u32()?;
    let extremes: Vec<glam::DVec3> = (0..count).map(|_| from.read_f64s().map(Into::into)).collect::<Option<_>>()?;
    (from.0.is_empty() && rotation.is_normalized() && !extremes.is_empty()).then_some(MeshOutline {
        obb,
        extremes,
        radius_mm,
    })
}

/// Encodes a collision proxy as bytes: distance grid, fine points, coarse points.
pub(crate) fn pack_proxies(field: &DistanceField, fine: &SphereTree, coarse: &SphereTree) -> Vec<u8> {
    let mut packer = ByteWriter::default();
    field.write_to(&mut packer);
    fine.write_to(&mut packer);
    coarse.write_to(&mut packer);
    packer.0
}

/// Decodes a collision proxy from bytes.
pub(crate) fn unpack_proxies(bytes: &[u8]) -> Option<(DistanceField, SphereTree, SphereTree)> {
    let mut from = ByteReader(bytes);
    let proxies =
        (DistanceField::read_from(&mut from)?, SphereTree::read_from(&mut from)?, SphereTree::read_from(&mut from)?);
    from.0.is_empty().then_some(proxies)
}
