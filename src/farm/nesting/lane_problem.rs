//! What all lanes of a final search have in common, in a form that other nodes can read: instance and settings of the search in the
//! ledger, meshes as files that the nodes fetch from each other by their BLAKE3.

use std::{
    fs,
    path::Path,
    sync::{Arc, Mutex},
};

use anyhow::{Context, Result, bail};
use glam::DVec3;
use nester::{NamedMeshInstance, NestingConfig, NestingInstance};
use serde::{Deserialize, Serialize};
use solids::Mesh;

use crate::intake::ContentStore;

/// Folder of the meshes in the state directory.
pub(crate) const MESHES_DIR: &str = "meshes";

/// The meshes of searches in lanes, as files named by BLAKE3.
pub(crate) fn mesh_files(state_dir: &Path) -> ContentStore {
    ContentStore::from_dir(state_dir.join(MESHES_DIR))
}

/// The search that this node has read last, with its text: the lanes of a search have it in common.
pub(crate) type SharedLaneProblem = Arc<Mutex<Option<(String, Arc<(NestingInstance, NestingConfig)>)>>>;

/// What is searched.
#[derive(Serialize, Deserialize)]
pub(crate) struct LaneProblem {
    instance: NamedMeshInstance,
    config: NestingConfig,
}

impl LaneProblem {
    /// Describes a search for other nodes, and stores its meshes in `files`. Seed and threads are those of each lane.
    pub(super) fn describe(instance: &NestingInstance, config: &NestingConfig, files: &ContentStore) -> Result<Self> {
        let mut stored = Ok(());
        let named = NamedMeshInstance::new(instance, |mesh| {
            let bytes = mesh_bytes(mesh);
            let hash = blake3::hash(&bytes).to_hex().to_string();
            if stored.is_ok() {
                stored = files.store_received(&mut &bytes[..], &hash);
            }
            hash
        });
        stored?;
        Ok(Self { instance: named, config: NestingConfig { seed: 0, threads: 1, ..config.clone() } })
    }

    /// The search with its meshes, for those of which that are not in `files` `fetch` is asked.
    pub(crate) fn load(
        self,
        files: &ContentStore,
        fetch: impl Fn(&str) -> Result<()>,
    ) -> Result<(NestingInstance, NestingConfig)> {
        let instance = self.instance.load_meshes(|hash| -> Result<Arc<Mesh>> {
            if files.verify_hash(hash).is_err() {
                fetch(hash)?;
            }
            let path = files.file_path(hash)?;
            let bytes = fs::read(&path).with_context(|| format!("reading {}", path.display()))?;
            Ok(Arc::new(mesh_from_bytes(&bytes).with_context(|| format!("reading {}", path.display()))?))
        })?;
        Ok((instance, self.config))
    }
}

/// A mesh as bytes, little endian: number of vertices (u64), their coordinates in mm (f64), and the vertex numbers of the triangles (u32).
fn mesh_bytes(mesh: &Mesh) -> Vec<u8> {
    let mut bytes = (mesh.vertices().len() as u64).to_le_bytes().to_vec();
    bytes.extend(mesh.vertices().iter().flat_map(|vertex| vertex.to_array()).flat_map(f64::to_le_bytes));
    bytes.extend(mesh.triangles().iter().flatten().flat_map(|vertex| vertex.to_le_bytes()));
    bytes
}

fn mesh_from_bytes(bytes: &[u8]) -> Result<Mesh> {
    let (count, rest) = bytes.split_first_chunk().context("it is too short")?;
    let vertex_bytes = usize::try_from(u64::from_le_bytes(*count))?.checked_mul(24);
    let Some((vertices, triangles)) = vertex_bytes.and_then(|at| rest.split_at_checked(at)) else {
        bail!("it is too short")
    };
    let (numbers, _) = vertices.as_chunks::<8>();
    let (vertices, _) = numbers.as_chunks::<3>();
    let (numbers, _) = triangles.as_chunks::<4>();
    let (triangles, _) = numbers.as_chunks::<3>();
    let vertices = vertices.iter().map(|vertex| DVec3::from_array(vertex.map(f64::from_le_bytes))).collect();
    Ok(Mesh::new(vertices, triangles.iter().map(|corners| corners.map(u32::from_le_bytes)).collect())?)
}

#[cfg(test)]
mod tests {
    use nester::{BuildVolume, LanePlan, NestingItem, PreparedMeshes, SearchBudget, run_lane};

    use super::*;

    fn instance() -> NestingInstance {
        let clip = Arc::new(sample_parts::clip(22.0, 2.4, 14.0));
        let ring = Arc::new(sample_parts::ring(20.0, 12.0, 1.0 / 0.3));
        let items = vec![
            NestingItem::new("clip", clip.clone(), 3),
            NestingItem::new("ring", ring, 2),
            NestingItem::new("clip again", clip, 1),
        ];
        NestingInstance::new(BuildVolume { size_mm: DVec3::new(60.0, 60.0, 120.0) }, 1.5, items).unwrap()
    }

    #[test]
    fn another_node_finds_the_same_with_the_meshes_that_it_fetches() {
        let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
        let [here, there] = folders.each_ref().map(|folder| ContentStore::open(folder.path()).unwrap());
        let (instance, config) = (instance(), NestingConfig { seed: 7, threads: 2, ..NestingConfig::default() });
        let problem = LaneProblem::describe(&instance, &config, &here).unwrap();
        let text = serde_json::to_string(&problem).unwrap();
        let again = LaneProblem::describe(&instance, &NestingConfig::default(), &here).unwrap();
        assert_eq!(serde_json::to_string(&again).unwrap(), text, "the same search has the same text");
        let fetch = |hash: &str| {
            let mut source = std::fs::File::open(here.file_path(hash)?)?;
            Ok(there.store_received(&mut source, hash)?)
        };
        let told: LaneProblem = serde_json::from_str(&text).unwrap();
        let (read, config) = told.load(&there, fetch).unwrap();
        let task = &LanePlan { lanes: 1, rounds: 1, evaluations: 1500, seed: 3 }.first_tasks(&[])[0];
        let run = |instance: &NestingInstance| {
            run_lane(instance, &config, &PreparedMeshes::default(), task, &SearchBudget::until_cancelled())
        };
        assert_eq!(run(&read), run(&instance));
    }

    #[test]
    fn a_mesh_that_cannot_be_fetched_or_read_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let files = ContentStore::open(folder.path()).unwrap();
        let problem = LaneProblem::describe(&instance(), &NestingConfig::default(), &files).unwrap();
        let elsewhere = tempfile::tempdir().unwrap();
        let none = problem.load(&ContentStore::open(elsewhere.path()).unwrap(), |_| bail!("nobody has it"));
        assert_eq!(none.err().unwrap().to_string(), "nobody has it");
        for bytes in [&b"short"[..], &u64::MAX.to_le_bytes(), &[9, 0, 0, 0, 0, 0, 0, 0, 1, 2]] {
            assert!(mesh_from_bytes(bytes).is_err());
        }
    }
}
