//! Meshes that are not closed are mended where somebody said yes: a person, a ticket, or the setting of a machine. What was done is told in
//! measures and kept with the hash of the mended mesh; each time the file is read, the mesh is mended again and must be that one.

use std::sync::Arc;

use build_file::{PartFileContents, format_count};
use intake::Ticket;
use ledger::{MEND_BY_SETTING, MEND_BY_TICKET, MendedFacts, PartRow};
use settings::{MachineProfile, MeshErrorPolicy};
use solids::{MendMeasures, MendedMesh, Mesh};

use crate::alerts::failure::MendDiffersError;

/// Below this volume more digits are told, cm3.
const SMALL_CM3: f64 = 10.0;

/// Who allows that the meshes of a part's file are mended; `None` = nobody. A mesh that was mended stays mended.
pub(super) fn allowed_by(part: &PartRow, profile: &MachineProfile) -> Option<String> {
    let said = Some(&part.mending.mend_allowed_by).filter(|by| !by.is_empty());
    said.cloned().or_else(|| by_setting(profile))
}

/// The same for a file with this ticket.
pub(crate) fn allowed_by_ticket(ticket: &Ticket, profile: &MachineProfile) -> Option<String> {
    ticket.mend.filter(|&mend| mend).map(|_| MEND_BY_TICKET.to_owned()).or_else(|| by_setting(profile))
}

fn by_setting(profile: &MachineProfile) -> Option<String> {
    (profile.intake.mesh_errors == MeshErrorPolicy::Repair).then(|| MEND_BY_SETTING.to_owned())
}

/// Mends the solids of a file that can be mended, where somebody allows it; tells for each what was done, and warns of it.
pub(crate) fn mend_solids(contents: &mut PartFileContents, by: Option<&str>) -> Vec<Option<MendedFacts>> {
    let Some(by) = by else { return vec![None; contents.solids.len()] };
    let who = match by {
        MEND_BY_TICKET => "its ticket",
        MEND_BY_SETTING => "mesh_errors of its machine",
        person => person,
    };
    let mend = |solid: &mut build_file::PartFileSolid| {
        let done = solid.mesh.mended().ok()?;
        let text = mend_text(&done.measures);
        solid.warnings.push(format!("The mesh was mended, as {who} allows: {text}."));
        let hash = mesh_hash(&done.mesh);
        solid.mesh = Arc::new(done.mesh);
        Some(MendedFacts { text, hash })
    };
    contents.solids.iter_mut().map(mend).collect()
}

/// The mesh of a part as it is printed: where its row has a mended one, that one and no other.
///
/// # Errors
/// It is mended otherwise now.
pub fn mend_as_recorded(part: &PartRow, mesh: Arc<Mesh>) -> Result<Arc<Mesh>, MendDiffersError> {
    if part.mending.mended_hash.is_empty() {
        return Ok(mesh);
    }
    let same = |done: &MendedMesh| mesh_hash(&done.mesh) == part.mending.mended_hash;
    let differs = || MendDiffersError { part: part.id, name: part.name.clone() };
    mesh.mended().ok().filter(same).map(|done| Arc::new(done.mesh)).ok_or_else(differs)
}

/// BLAKE3 of the numbers of a mesh, 64 hex digits.
fn mesh_hash(mesh: &Mesh) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&(mesh.vertices().len() as u64).to_le_bytes());
    for number in mesh.vertices().iter().flat_map(|vertex| vertex.to_array()) {
        hasher.update(&number.to_le_bytes());
    }
    for corner in mesh.triangles().iter().flatten() {
        hasher.update(&corner.to_le_bytes());
    }
    hasher.finalize().to_hex().to_string()
}

/// What was done, in words with measures.
pub(super) fn mend_text(measures: &MendMeasures) -> String {
    let mut said = Vec::new();
    if measures.holes > 0 {
        let holes = format_count(measures.holes, "hole of at most", "holes of at most");
        said.push(format!("{holes} {:.2} mm closed", measures.widest_hole_mm));
    }
    let counts = [
        (measures.added, "triangle added", "triangles added"),
        (measures.turned, "triangle turned", "triangles turned"),
        (measures.left_out, "triangle left out", "triangles left out"),
        (measures.joined, "corner joined", "corners joined"),
    ];
    said.extend(
        counts.iter().filter(|count| count.0 > 0).map(|&(count, one, several)| format_count(count, one, several)),
    );
    let [before, after] = [measures.volume_before_mm3, measures.volume_after_mm3].map(|volume| volume / 1000.0);
    let digits = if after < SMALL_CM3 { 4 } else { 2 };
    said.push(format!("volume {before:.digits$} -> {after:.digits$} cm³"));
    said.push(format!("at most {:.2} mm off the surface before", measures.deviation_mm));
    said.join(", ")
}
