//! The cake of a build, for pages and commands to show: the mesh of each part and the poses of its copies. It is read
//! from the ledger and the stored originals, or from a build file.

use std::{
    cell::OnceCell,
    collections::{BTreeMap, HashMap},
    path::{Path, PathBuf},
    sync::Arc,
};

use build_file::{BuildMetadata, PictureBody, PictureScheme, PlacedMesh, Viewpoint};
use glam::DVec3;
use intake::ContentStore;
use ledger::{BuildRow, BuildState, Ledger, LedgerError, PartId, PartRow, RemovalStep};
use settings::{MachineProfile, Settings};
use solids::{Bounds, Mesh, Pose};

use super::{build_record::archive_folder, kept_build};
use crate::{
    decisions::layout::{due_words, placed_from_json},
    files::{mesh_cache::MeshCache, mesh_source::MeshSource},
};

/// The contents of a build.
#[derive(Debug, Clone)]
pub struct CakeContents {
    /// Edge lengths of the build volume, mm.
    pub volume_mm: DVec3,
    /// The parts.
    pub parts: Vec<CakePart>,
}

/// A part with its copies in a build.
#[derive(Debug, Clone)]
pub struct CakePart {
    /// Number of the part in the ledger, or in the file.
    pub part: i64,
    /// Names of the part and of its solid.
    pub name: String,
    /// Order or kit, "" = none.
    pub order: String,
    /// When it is due, as people read it, "" = no date.
    pub due: String,
    /// The customer's note, "" = none.
    pub note: String,
    /// What the customer's own system calls the line, "" = not said.
    pub reference: String,
    /// Finishing steps after the print, "" = none, or known only to the ledger.
    pub finish: String,
    /// The mesh; `None` = its original is past its retention.
    pub mesh: Option<Arc<Mesh>>,
    /// The placed copies.
    pub copies: Vec<CakeCopy>,
}

/// A placed copy in a build.
#[derive(Debug, Clone)]
pub struct CakeCopy {
    /// Number of the copy, from 1.
    pub copy: u32,
    /// Mesh frame -> machine frame, mm.
    pub pose: Pose,
    /// How it is removed from the cake; `None` = not proved.
    pub drawn: Option<RemovalStep>,
}

/// The parts of a build with their copies: from the proved placements if the build has been nested, otherwise from its
/// current layout.
pub async fn load_placed_parts(
    ledger: &Ledger,
    build: &BuildRow,
    profile: &MachineProfile,
) -> Result<Vec<(PartRow, Vec<CakeCopy>)>, LedgerError> {
    let mut by_part: BTreeMap<PartId, Vec<CakeCopy>> = BTreeMap::new();
    if matches!(build.state, BuildState::Open | BuildState::Nesting) {
        for placed in placed_from_json(build.kept.layout.as_deref().unwrap_or_default()) {
            let pose = Pose { translation: placed.pose.translation + profile.origin_mm(), ..placed.pose };
            by_part.entry(placed.copy.0).or_default().push(CakeCopy { copy: placed.copy.1 + 1, pose, drawn: None });
        }
    } else {
        for row in ledger.placements_of_build(build.id).await? {
            if let Some(pose) = row.pose() {
                let standing = CakeCopy { copy: row.copy + 1, pose, drawn: row.removal_step() };
                by_part.entry(row.part_id).or_default().push(standing);
            }
        }
    }
    let mut parts = Vec::with_capacity(by_part.len());
    for (id, copies) in by_part {
        if let Some(part) = ledger.find_part(id).await? {
            parts.push((part, copies));
        }
    }
    Ok(parts)
}

/// Number of copies of a part in the current layout of an open build.
pub fn count_copies_in_layout(build: &BuildRow, part: PartId) -> u32 {
    let layout = placed_from_json(build.kept.layout.as_deref().unwrap_or_default());
    layout.iter().filter(|placed| placed.copy.0 == part).count() as u32
}

impl CakeContents {
    /// Built from the ledger and the stored originals, which lie in the store while the parts wait and in the archive
    /// later. Reads files.
    pub fn from_ledger(
        settings: &Settings,
        profile: &MachineProfile,
        build: &BuildRow,
        parts: Vec<(PartRow, Vec<CakeCopy>)>,
    ) -> Self {
        let originals = OriginalMeshes::new(settings, profile, build);
        let part = |(row, copies): (PartRow, Vec<CakeCopy>)| CakePart {
            part: row.id.0,
            name: row.full_name(),
            order: row.terms.order_name.clone(),
            due: due_words(&row.terms, &profile.time_zone),
            note: row.terms.note.clone(),
            reference: row.terms.reference.clone(),
            finish: row.terms.finish.clone(),
            mesh: originals.load_mesh(&row),
            copies,
        };
        Self { volume_mm: profile.space.volume_mm, parts: parts.into_iter().map(part).collect() }
    }

    /// Built from a build file. Parts are distinguished by their numbers, or by their meshes if they have none.
    pub fn from_placed_meshes(placed: &[PlacedMesh], volume_mm: DVec3) -> Self {
        let mut parts: Vec<CakePart> = Vec::new();
        let shown = |word: &Option<String>| build_file::escape_invisible(word.as_deref().unwrap_or_default());
        let mut known: HashMap<(Option<&str>, &str, *const Mesh), usize> = HashMap::new();
        for item in placed {
            let key =
                (item.part_number.as_deref(), item.words.order.as_deref().unwrap_or_default(), Arc::as_ptr(&item.mesh));
            let at = *known.entry(key).or_insert_with(|| {
                let number = item.part_number.as_deref().and_then(|n| n.parse().ok());
                parts.push(CakePart {
                    part: number.unwrap_or(parts.len() as i64 + 1),
                    name: placed_mesh_name(item),
                    order: shown(&item.words.order),
                    due: shown(&item.words.due),
                    note: shown(&item.words.note),
                    reference: shown(&item.words.reference),
                    finish: String::new(),
                    mesh: Some(item.mesh.clone()),
                    copies: Vec::new(),
                });
                parts.len() - 1
            });
            let copies = &mut parts[at].copies;
            let copy = item.copy.unwrap_or(copies.len() as u32 + 1);
            copies.push(CakeCopy { copy, pose: item.pose, drawn: None });
        }
        // As those of the ledger, so that each has the same colour.
        parts.sort_by_key(|part| part.part);
        Self { volume_mm, parts }
    }

    /// Number of placed copies.
    pub fn copy_count(&self) -> usize {
        self.parts.iter().map(|part| part.copies.len()).sum()
    }

    /// Number of parts whose originals are past their retention.
    pub fn missing_mesh_count(&self) -> usize {
        self.parts.iter().filter(|part| part.mesh.is_none()).count()
    }

    /// Top of the highest copy that has a mesh, mm.
    pub fn top_mm(&self) -> Option<f64> {
        let bounds = self.parts.iter().flat_map(|p| p.copies.iter().filter_map(|copy| p.copy_bounds(copy)));
        bounds.map(|bounds| bounds.max.z).reduce(f64::max)
    }

    /// A picture of it, as PNG.
    pub fn render_picture(&self, viewpoint: Viewpoint, size: (u32, u32)) -> Vec<u8> {
        self.render_picture_on(PictureScheme::Light, viewpoint, size)
    }

    /// A picture of it on a given ground, as PNG.
    pub fn render_picture_on(&self, scheme: PictureScheme, viewpoint: Viewpoint, size: (u32, u32)) -> Vec<u8> {
        self.render_in(self.volume_mm, scheme, viewpoint, size)
    }

    /// Draws it up to a height, as if its volume ended there.
    pub fn render_up_to(&self, height_mm: f64, scheme: PictureScheme, size: (u32, u32)) -> Vec<u8> {
        self.render_in(self.volume_mm.with_z(height_mm), scheme, Viewpoint::Iso, size)
    }

    fn render_in(&self, volume_mm: DVec3, scheme: PictureScheme, viewpoint: Viewpoint, size: (u32, u32)) -> Vec<u8> {
        let mut bodies = Vec::with_capacity(self.copy_count());
        for (kind, part) in self.parts.iter().enumerate() {
            if let Some(mesh) = &part.mesh {
                bodies.extend(part.copies.iter().map(|copy| PictureBody { mesh, pose: copy.pose, kind }));
            }
        }
        build_file::draw_picture_on(scheme, &bodies, volume_mm, viewpoint, size)
    }
}

impl CakePart {
    /// Bounds of a copy.
    pub fn copy_bounds(&self, copy: &CakeCopy) -> Option<Bounds> {
        self.mesh.as_ref().map(|mesh| mesh.bounds_at(&copy.pose))
    }
}

/// Name of a placed copy: the name of its source file with that of its solid.
fn placed_mesh_name(item: &PlacedMesh) -> String {
    let name = match item.source_name.as_deref() {
        Some(source) if source != item.name => format!("{source} ({})", item.name),
        _ => item.name.clone(),
    };
    build_file::escape_invisible(&name)
}

/// The file of a published build, if it lies in the queue or is kept in the archive, and is the one that was proved.
pub fn find_proved_file(profile: &MachineProfile, build: &BuildRow) -> Option<PathBuf> {
    let is_proved = |file: &Path| Some(intake::hash_file(file).ok()? == build.staged.file_hash.as_deref()?);
    build_file_paths(profile, build)?.into_iter().find(|file| is_proved(file).unwrap_or(false))
}

/// Where a build's file is now, as far as its name tells: in the queue folder, else kept in the archive.
pub fn locate_build_file(profile: &MachineProfile, build: &BuildRow) -> Option<PathBuf> {
    let [queued, kept] = build_file_paths(profile, build)?;
    Some(if kept.is_file() && !queued.exists() { kept } else { queued })
}

fn build_file_paths(profile: &MachineProfile, build: &BuildRow) -> Option<[PathBuf; 2]> {
    let name = build.staged.file_name.as_deref()?;
    Some([
        profile.visible_file(name, build.place.printer.as_deref()),
        kept_build::kept_path(&profile.folders.archive, name),
    ])
}

/// The build volume given in the file, or else `given_mm`.
pub fn resolve_volume_mm(info: &BuildMetadata, given_mm: Option<DVec3>) -> Option<DVec3> {
    given_mm.or(info.rules.volume_mm).filter(|mm| mm.is_finite() && mm.min_element() > 0.0)
}

/// The originals of a build's parts.
struct OriginalMeshes {
    meshes: MeshSource,
    /// The build's archive folder.
    archive: Option<PathBuf>,
    /// Archived originals by content; filled when first needed.
    archived: OnceCell<HashMap<String, PathBuf>>,
}

impl OriginalMeshes {
    fn new(settings: &Settings, profile: &MachineProfile, build: &BuildRow) -> Self {
        // Read only: `ContentStore::open` would remove files that the daemon is just writing.
        let store = ContentStore::from_dir(settings.state_dir.join("store"));
        let (shelf, limits, unreadable) = (MeshCache::default(), settings.limits.clone(), Default::default());
        let meshes = MeshSource {
            mesh_cache: shelf,
            store,
            limits,
            prepared: Default::default(),
            preparation_cache: None,
            judged: Default::default(),
            unreadable_since: unreadable,
        };
        let name = build.staged.file_name.as_deref();
        let archive = name.map(|name| archive_folder(&profile.folders.archive, name));
        Self { meshes, archive, archived: OnceCell::new() }
    }

    fn archived_by_hash(&self) -> &HashMap<String, PathBuf> {
        self.archived.get_or_init(|| {
            let files = self.archive.as_ref().and_then(|folder| std::fs::read_dir(folder).ok()).into_iter().flatten();
            let known = |path: PathBuf| Some((intake::hash_file(&path).ok()?, path));
            files.flatten().filter_map(|file| known(file.path())).collect()
        })
    }

    /// The mesh of a part; `None` = its original is past its retention.
    fn load_mesh(&self, part: &PartRow) -> Option<Arc<Mesh>> {
        if let Ok(mesh) = self.meshes.load_mesh(part) {
            return Some(mesh);
        }
        let file = self.archived_by_hash().get(&part.file.content_hash)?;
        self.meshes.mesh_cache.read_mesh(file, part, &self.meshes.limits).ok()
    }
}
