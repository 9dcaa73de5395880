//! The step "read": a claimed part's file becomes checked meshes, or a reason why not. Runs on a job's thread.

use std::sync::Arc;

use super::{nest::Meshes, receive::chain, shelf::MeshKey};
use crate::{
    format::ReadError,
    format::{self, Solid, Unit},
    geometry::Defects,
    ledger::{PartRow, Refusal, SolidFacts},
    nest::{self, OrientationRule},
    settings::{MeshErrors, Profile},
};

/// What came out of reading a part's file.
#[derive(Debug)]
pub enum ReadOutcome {
    /// Printable solids.
    Solids(Vec<SolidFacts>),
    /// It cannot be printed; whole sentences for the technician.
    Refused(Refusal, String),
    /// The disk failed, not the file: it is tried again.
    Later(String),
}

/// Reads and checks; the meshes go onto the shelf.
pub fn read_part(part: &PartRow, profile: &Arc<Profile>, meshes: &Meshes) -> ReadOutcome {
    let file = match meshes.store.path(&part.content_hash) {
        Ok(file) => file,
        Err(error) => return ReadOutcome::Later(chain(&error)),
    };
    match file.try_exists() {
        Ok(true) => {}
        Ok(false) => {
            return ReadOutcome::Refused(Refusal::Other, "Its file is no longer kept. Drop it again.".to_owned());
        }
        Err(error) => return ReadOutcome::Later(format!("{}: {error}", file.display())),
    }
    let contents = match format::read(&file, &part.name, part.unit, profile.unit, &meshes.limits) {
        Ok(contents) => contents,
        Err(error) if error.is_io() => return ReadOutcome::Later(chain(&error)),
        // What it quotes of the file is for people.
        Err(error) => {
            let reason = format!("{}: {}.", part.name, format::visible(&chain(&error)));
            return ReadOutcome::Refused(kind_of(&error), reason);
        }
    };
    let copies: u64 = contents.solids.iter().map(|s| u64::from(s.copies) * u64::from(part.copies)).sum();
    if copies > meshes.limits.max_copies {
        let reason = format!(
            "It asks for {copies} copies; one file may ask for {} at most (limits.max_copies).",
            meshes.limits.max_copies
        );
        return ReadOutcome::Refused(Refusal::Limit, reason);
    }
    let faults: Vec<(Refusal, String)> =
        contents.solids.iter().filter_map(|solid| fault_of(solid, part, profile)).collect();
    if let Some((first, _)) = faults.first() {
        let reasons: Vec<&str> = faults.iter().map(|(_, reason)| reason.as_str()).collect();
        return ReadOutcome::Refused(*first, reasons.join("\n"));
    }
    let mut facts = Vec::new();
    for (index, solid) in contents.solids.into_iter().enumerate() {
        let mut warnings = if index == 0 { contents.warnings.clone() } else { Vec::new() };
        warnings.extend(solid.warnings.iter().cloned());
        warnings.iter_mut().for_each(|warning| *warning = format::visible(warning));
        facts.push(facts_of(&solid, index as u32, part, warnings));
        let key = MeshKey {
            content_hash: part.content_hash.clone(),
            object_index: index as u32,
            default_unit: profile.unit,
            unit: part.unit,
        };
        meshes.shelf.put(key, solid.mesh);
    }
    ReadOutcome::Solids(facts)
}

/// What kind of reason it is that a file cannot be read.
fn kind_of(error: &ReadError) -> Refusal {
    match error {
        ReadError::TooLarge { .. } => Refusal::Limit,
        ReadError::NoSolid { .. } => Refusal::NotClosed,
        ReadError::Io(_) => Refusal::Unreadable,
        ReadError::Unknown(_) | ReadError::Truncated(_) | ReadError::Invalid { .. } | ReadError::Unsupported(_) => {
            Refusal::Format
        }
    }
}

fn facts_of(solid: &Solid, object_index: u32, part: &PartRow, mut warnings: Vec<String>) -> SolidFacts {
    let defects = solid.mesh.defects();
    if !defects.is_closed() {
        warnings.push(format!("The mesh is not closed: {}.", defects_text(&defects)));
    }
    SolidFacts {
        object_index,
        object_name: solid.name.clone(),
        copies: solid.copies.saturating_mul(part.copies),
        triangles: solid.mesh.triangles().len() as u64,
        volume_mm3: solid.mesh.volume_mm3(),
        size_mm: solid.mesh.bounds().size().to_array(),
        warnings,
    }
}

/// Why a solid cannot be printed on this machine.
fn fault_of(solid: &Solid, part: &PartRow, profile: &Profile) -> Option<(Refusal, String)> {
    let defects = solid.mesh.defects();
    if !defects.is_closed() && profile.mesh_errors == MeshErrors::Reject {
        let reason = format!(
            "{}: the mesh is not closed ({}), so it is not known what is inside. Repair it, or set mesh_errors = \"warn\" in \
             the profile {}.",
            solid.name,
            defects_text(&defects),
            profile.name
        );
        return Some((Refusal::NotClosed, reason));
    }
    misfit_of(solid, part, profile).map(|reason| (Refusal::TooLarge, reason))
}

fn defects_text(defects: &Defects) -> String {
    [
        (defects.open_edges, "open edges"),
        (defects.non_manifold_edges, "edges of more than two triangles"),
        (defects.inconsistent_edges, "edges whose triangles face opposite ways"),
    ]
    .iter()
    .filter(|(count, _)| *count > 0)
    .map(|(count, what)| format!("{count} {what}"))
    .collect::<Vec<_>>()
    .join(", ")
}

/// Why a solid does not fit into the machine in any allowed orientation. Nothing is rescaled; units in which it would
/// fit are named.
fn misfit_of(solid: &Solid, part: &PartRow, profile: &Profile) -> Option<String> {
    let rule = part.orientation;
    let volume = profile.build_volume();
    let misfit = nest::fits(&solid.mesh, &part.turning(), &volume).err()?;
    if misfit.is_forbidden {
        return Some(format!(
            "{}: no rotation obeys all of its orientation rules ({}{}).",
            solid.name,
            rule_name(rule),
            tilts_text(part)
        ));
    }
    let (needs, has) = (misfit.extents_mm, volume.size_mm);
    let mut reason = format!(
        "{}: needs {:.1} x {:.1} x {:.1} mm in its best allowed orientation ({}{}); the build volume of {} is {} x {} x {} mm.",
        solid.name,
        needs.x,
        needs.y,
        needs.z,
        rule_name(rule),
        tilts_text(part),
        profile.name,
        has.x,
        has.y,
        has.z
    );
    // Wrong units are the commonest reason: say what the numbers would be in a smaller unit, and let people decide.
    if part.unit.is_none() {
        let read_in = profile.unit.mm();
        let smaller = [Unit::Millimeter, Unit::Micron]
            .into_iter()
            .find(|unit| unit.mm() < read_in && (needs * (unit.mm() / read_in)).cmple(has).all());
        if let Some(unit) = smaller {
            let size = needs * (unit.mm() / read_in);
            let word = format!("{unit:?}").to_lowercase();
            reason.push_str(&format!(
                " Read in {word}s it would be {:.1} x {:.1} x {:.1} mm and fit: if that is meant, drop it with a ticket that says \
                 unit = \"{word}\".",
                size.x, size.y, size.z
            ));
        }
    }
    Some(reason)
}

/// What must stand near to straight up, as it follows the rule's name.
fn tilts_text(part: &PartRow) -> String {
    part.tilts.0.iter().map(|tilt| format!(", {}", tilt.in_words())).collect()
}

fn rule_name(rule: OrientationRule) -> &'static str {
    match rule {
        OrientationRule::Free => "free",
        OrientationRule::Upright => "upright",
        OrientationRule::Axis => "axis",
        OrientationRule::Fixed => "fixed",
    }
}
