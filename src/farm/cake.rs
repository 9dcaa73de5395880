//! The cake of a build, for faces to show: of each part its mesh, and where its copies stand. It comes from the ledger and the
//! kept originals, or from a build file.

use std::{
    cell::OnceCell,
    collections::{BTreeMap, HashMap},
    path::{Path, PathBuf},
    sync::Arc,
};

use build_file::{BuildInfo, Drawn, PlacedMesh, Viewpoint};
use glam::DVec3;
use solids::{Bounds, Mesh, Pose};

use super::{layout::placed_from_json, meshes::Meshes, shelf::Shelf};
use crate::{
    intake::Store,
    ledger::{BuildRow, BuildState, DrawnOut, Ledger, LedgerError, PartId, PartRow},
    settings::{Profile, Settings},
};

/// What stands in a build.
#[derive(Debug, Clone)]
pub struct Cake {
    /// Edge lengths of the build volume, mm.
    pub volume_mm: DVec3,
    /// By part.
    pub parts: Vec<CakePart>,
}

/// A part with its copies in a build.
#[derive(Debug, Clone)]
pub struct CakePart {
    /// The ledger's number of the part, or its number in the file.
    pub part: i64,
    /// Name of the part with that of its solid.
    pub name: String,
    /// Order or kit, "" = none.
    pub order: String,
    /// `None` when its original is past its keeping.
    pub mesh: Option<Arc<Mesh>>,
    /// Where its copies stand.
    pub copies: Vec<Standing>,
}

/// A copy that stands in a build.
#[derive(Debug, Clone)]
pub struct Standing {
    /// From 1.
    pub copy: u32,
    /// Mesh frame -> machine frame, mm.
    pub pose: Pose,
    /// How it comes out of the cake; `None` = not proved.
    pub drawn: Option<DrawnOut>,
}

/// The parts of a build with their copies: of one that is past nesting as proved, else as in its layout so far.
pub async fn standing(
    ledger: &Ledger,
    build: &BuildRow,
    profile: &Profile,
) -> Result<Vec<(PartRow, Vec<Standing>)>, LedgerError> {
    let mut by_part: BTreeMap<PartId, Vec<Standing>> = BTreeMap::new();
    if matches!(build.state, BuildState::Open | BuildState::Nesting) {
        for placed in placed_from_json(build.kept.layout.as_deref().unwrap_or_default()) {
            let pose = Pose { translation: placed.pose.translation + profile.origin_mm(), ..placed.pose };
            by_part.entry(placed.copy.0).or_default().push(Standing { copy: placed.copy.1 + 1, pose, drawn: None });
        }
    } else {
        for row in ledger.placements_of_build(build.id).await? {
            if let Some(pose) = row.pose() {
                let standing = Standing { copy: row.copy + 1, pose, drawn: row.drawn() };
                by_part.entry(row.part_id).or_default().push(standing);
            }
        }
    }
    let mut parts = Vec::with_capacity(by_part.len());
    for (id, copies) in by_part {
        if let Some(part) = ledger.part(id).await? {
            parts.push((part, copies));
        }
    }
    Ok(parts)
}

/// How many copies of a part stand in the layout that an open build has so far.
pub fn copies_so_far(build: &BuildRow, part: PartId) -> u32 {
    let layout = placed_from_json(build.kept.layout.as_deref().unwrap_or_default());
    layout.iter().filter(|placed| placed.copy.0 == part).count() as u32
}

impl Cake {
    /// From what the ledger knows and the originals that are kept: in the store as long as they wait there, then in the
    /// archive. Reads files.
    pub fn of_ledger(
        settings: &Settings,
        profile: &Profile,
        build: &BuildRow,
        parts: Vec<(PartRow, Vec<Standing>)>,
    ) -> Self {
        let originals = Originals::new(settings, profile, build);
        let part = |(row, copies): (PartRow, Vec<Standing>)| CakePart {
            part: row.id.0,
            name: row.full_name(),
            order: row.terms.order_name.clone(),
            mesh: originals.mesh(&row),
            copies,
        };
        Self { volume_mm: profile.space.volume_mm, parts: parts.into_iter().map(part).collect() }
    }

    /// From a build file. Parts are told apart by their numbers, without these by their meshes.
    pub fn of_file(placed: &[PlacedMesh], volume_mm: DVec3) -> Self {
        let mut parts: Vec<CakePart> = Vec::new();
        let mut known: HashMap<(Option<&str>, &str, *const Mesh), usize> = HashMap::new();
        for item in placed {
            let key = (item.part_number.as_deref(), item.order.as_deref().unwrap_or_default(), Arc::as_ptr(&item.mesh));
            let at = *known.entry(key).or_insert_with(|| {
                let number = item.part_number.as_deref().and_then(|n| n.parse().ok());
                parts.push(CakePart {
                    part: number.unwrap_or(parts.len() as i64 + 1),
                    name: name_in_file(item),
                    order: build_file::visible(item.order.as_deref().unwrap_or_default()),
                    mesh: Some(item.mesh.clone()),
                    copies: Vec::new(),
                });
                parts.len() - 1
            });
            let copies = &mut parts[at].copies;
            let copy = item.copy.unwrap_or(copies.len() as u32 + 1);
            copies.push(Standing { copy, pose: item.pose, drawn: None });
        }
        Self { volume_mm, parts }
    }

    /// How many copies stand in it.
    pub fn copies(&self) -> usize {
        self.parts.iter().map(|part| part.copies.len()).sum()
    }

    /// Parts whose originals are past their keeping.
    pub fn missing(&self) -> usize {
        self.parts.iter().filter(|part| part.mesh.is_none()).count()
    }

    /// Top of the highest copy whose mesh is there, mm.
    pub fn top_mm(&self) -> Option<f64> {
        let bounds = self.parts.iter().flat_map(|p| p.copies.iter().filter_map(|copy| p.bounds(copy)));
        bounds.map(|bounds| bounds.max.z).reduce(f64::max)
    }

    /// Its picture, a PNG.
    pub fn picture(&self, viewpoint: Viewpoint, size: (u32, u32)) -> Vec<u8> {
        let mut bodies = Vec::with_capacity(self.copies());
        for (kind, part) in self.parts.iter().enumerate() {
            if let Some(mesh) = &part.mesh {
                bodies.extend(part.copies.iter().map(|copy| Drawn { mesh, pose: copy.pose, kind }));
            }
        }
        build_file::picture(&bodies, self.volume_mm, viewpoint, size)
    }
}

impl CakePart {
    /// Where a copy is.
    pub fn bounds(&self, copy: &Standing) -> Option<Bounds> {
        self.mesh.as_ref().map(|mesh| mesh.bounds_at(&copy.pose))
    }
}

/// Name of a placed copy: as it was dropped, with that of its solid.
fn name_in_file(item: &PlacedMesh) -> String {
    let name = match item.source_name.as_deref() {
        Some(source) if source != item.name => format!("{source} ({})", item.name),
        _ => item.name.clone(),
    };
    build_file::visible(&name)
}

/// A published build whose file lies in the queue as it was proved.
pub fn file_in_queue(profile: &Profile, build: &BuildRow) -> Option<PathBuf> {
    let file = profile.folders.queue.join(build.staged.file_name.as_deref()?);
    let is_proved = |file: &Path| Some(hash_of(file).ok()?.to_hex().as_str() == build.staged.file_hash.as_deref()?);
    is_proved(&file)?.then_some(file)
}

/// What a file says of its volume, else what is given.
pub fn volume_of(info: &BuildInfo, given_mm: Option<DVec3>) -> Option<DVec3> {
    given_mm.or(info.volume_mm).filter(|mm| mm.is_finite() && mm.min_element() > 0.0)
}

/// The originals of a build's parts.
struct Originals {
    meshes: Meshes,
    profile: Profile,
    /// Where the archived ones are.
    archive: Option<PathBuf>,
    /// Archived ones by their content, once one is needed.
    archived: OnceCell<HashMap<String, PathBuf>>,
}

impl Originals {
    fn new(settings: &Settings, profile: &Profile, build: &BuildRow) -> Self {
        // Only to look: opening it would clear away what the daemon is just putting there.
        let store = Store::at(settings.state_dir.join("store"));
        let (shelf, limits, unreadable) = (Shelf::default(), settings.limits.clone(), Default::default());
        let meshes = Meshes { shelf, store, limits, prepared: Default::default(), cache: None, unreadable };
        let stem = build.staged.file_name.as_deref().and_then(|name| name.strip_suffix(".build.3mf"));
        let archive = stem.map(|stem| profile.folders.archive.join(stem));
        Self { meshes, profile: profile.clone(), archive, archived: OnceCell::new() }
    }

    fn archived(&self) -> &HashMap<String, PathBuf> {
        self.archived.get_or_init(|| {
            let files = self.archive.as_ref().and_then(|folder| std::fs::read_dir(folder).ok()).into_iter().flatten();
            let known = |path: PathBuf| Some((hash_of(&path).ok()?.to_hex().to_string(), path));
            files.flatten().filter_map(|file| known(file.path())).collect()
        })
    }

    /// The mesh of a part; `None` when its original is past its keeping.
    fn mesh(&self, part: &PartRow) -> Option<Arc<Mesh>> {
        if let Ok(mesh) = self.meshes.mesh(&self.profile, part) {
            return Some(mesh);
        }
        let file = self.archived().get(&part.file.content_hash)?;
        let contents =
            build_file::read(file, &part.name, part.terms.unit, self.profile.intake.unit, &self.meshes.limits).ok()?;
        Some(Arc::new(contents.solids.into_iter().nth(part.solid.object_index as usize)?.mesh))
    }
}

fn hash_of(file: &Path) -> std::io::Result<blake3::Hash> {
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(std::fs::File::open(file)?)?;
    Ok(hasher.finalize())
}
