//! The step "read": turns a claimed part's file into checked meshes, or a reason for refusal. Runs on a job's thread.

use std::sync::Arc;

use build_file::{LengthUnit, PartFileSolid};
use nester::OrientationRule;
use solids::MeshDefects;

use super::{
    failure::{LostFileError, PartReadError, error_chain},
    mesh_cache::MeshCacheKey,
    mesh_source::MeshSource,
    standing_claim::StandingClaim,
};
use crate::{
    ledger::{PartRow, RefusalCause, SolidFacts},
    settings::{MachineProfile, MeshErrorPolicy},
};

/// A part that would be smaller than this in another unit was not meant in it.
const SMALLEST_MEANT_MM: f64 = 1.0;

/// Result of reading a part's file.
#[derive(Debug)]
pub enum PartReadOutcome {
    /// Printable solids.
    Solids(Vec<SolidFacts>),
    /// The part cannot be printed; whole sentences for the technician.
    Refused(RefusalCause, String),
    /// The stored file is damaged: the part waits until it is dropped again.
    LostFile(LostFileError),
    /// The disk failed, not the file: the part is retried.
    TryLater(String),
}

/// Reads and checks a file; the meshes go into the mesh cache.
///
/// A damaged stored file is replaced from the claimed original, if that is still in the hot folder.
pub fn read_part(
    part: &PartRow,
    claim: Option<&StandingClaim>,
    profile: &Arc<MachineProfile>,
    meshes: &MeshSource,
) -> PartReadOutcome {
    if let Some(Err(failure)) = claim.map(|claim| claim.ensure_stored(&meshes.store, &part.file.content_hash)) {
        return PartReadOutcome::TryLater(error_chain(&failure));
    }
    let heal = |failure: anyhow::Error| match (LostFileError::find_in_chain(&failure), claim) {
        (Some(_), Some(claim)) if meshes.store.store_claimed(&claim.claim).is_ok() => meshes.verified_file(part),
        _ => Err(failure),
    };
    let file = match meshes.verified_file(part).or_else(heal) {
        Ok(file) => file,
        Err(failure) => {
            return match failure.downcast::<LostFileError>() {
                Ok(LostFileError { aside: None, .. }) if claim.is_none() => PartReadOutcome::Refused(
                    RefusalCause::Other,
                    "Its file is no longer kept. Drop it again.".to_owned(),
                ),
                Ok(lost) => PartReadOutcome::LostFile(lost),
                Err(failure) => PartReadOutcome::TryLater(format!("{failure:#}")),
            };
        }
    };
    let contents = match meshes.read_contents(file, part, profile.intake.unit) {
        Ok(contents) => contents,
        Err(PartReadError::TryLater(why)) => return PartReadOutcome::TryLater(why),
        Err(PartReadError::Refused(cause, reason)) => return PartReadOutcome::Refused(cause, reason),
    };
    let copies: u64 = contents.solids.iter().map(|s| u64::from(s.copies) * u64::from(part.owed.copies)).sum();
    if copies > meshes.limits.max_copies {
        let reason = format!(
            "It asks for {copies} copies; one file may ask for {} at most (limits.max_copies). Drop it again with fewer, or \
             raise that limit in the configuration and reload nestd.",
            meshes.limits.max_copies
        );
        return PartReadOutcome::Refused(RefusalCause::Limit, reason);
    }
    let faults: Vec<(RefusalCause, String)> =
        contents.solids.iter().filter_map(|solid| find_solid_fault(solid, part, profile)).collect();
    if let Some((first, _)) = faults.first() {
        let reasons: Vec<&str> = faults.iter().map(|(_, reason)| reason.as_str()).collect();
        return PartReadOutcome::Refused(*first, reasons.join("\n"));
    }
    let mut facts = Vec::new();
    for (index, solid) in contents.solids.into_iter().enumerate() {
        let mut warnings = if index == 0 { contents.warnings.clone() } else { Vec::new() };
        warnings.extend(solid.warnings.iter().cloned());
        warnings.iter_mut().for_each(|warning| *warning = build_file::escape_invisible(warning));
        let question = size_question(&solid, part, profile);
        facts.push(SolidFacts { question, ..solid_facts(&solid, index as u32, part, warnings) });
        let key = MeshCacheKey {
            content_hash: part.file.content_hash.clone(),
            object_index: index as u32,
            default_unit: profile.intake.unit,
            unit: part.terms.unit,
        };
        meshes.mesh_cache.insert(key, solid.mesh);
    }
    PartReadOutcome::Solids(facts)
}

fn solid_facts(solid: &PartFileSolid, object_index: u32, part: &PartRow, mut warnings: Vec<String>) -> SolidFacts {
    let defects = solid.mesh.defects();
    if !defects.is_closed() {
        warnings.push(format!("The mesh is not closed: {}.", defects_text(&defects)));
    }
    SolidFacts {
        object_index,
        object_name: solid.name.clone(),
        copies: solid.copies.saturating_mul(part.owed.copies),
        triangles: solid.mesh.triangles().len() as u64,
        volume_mm3: solid.mesh.volume_mm3(),
        size_mm: solid.mesh.bounds().size().to_array(),
        question: String::new(),
        warnings,
    }
}

/// What a person must confirm of a solid that is hardly printable: a speck, which may be one of a wrong unit too.
fn size_question(solid: &PartFileSolid, part: &PartRow, profile: &MachineProfile) -> String {
    let size = solid.mesh.bounds().size();
    let (longest, thickness) = (size.max_element(), size.min_element());
    let is_speck = longest < profile.intake.min_size_mm;
    if profile.intake.min_size_mm <= 0.0 || !is_speck && thickness >= profile.space.layer_mm {
        return String::new();
    }
    let shown = format!("it is {:.2} x {:.2} x {:.2} mm", size.x, size.y, size.z);
    let why = match is_speck {
        true => format!("smaller than {} mm", profile.intake.min_size_mm),
        false => format!("thinner than a layer of {} mm", profile.space.layer_mm),
    };
    let unit = match part.terms.unit {
        None if is_speck && profile.intake.unit == LengthUnit::Millimeter => {
            let inches = LengthUnit::Inch.mm_per_unit();
            format!(
                "; read in inches instead of millimetres it would be {:.1} x {:.1} x {:.1} mm",
                size.x * inches,
                size.y * inches,
                size.z * inches
            )
        }
        _ => String::new(),
    };
    format!("{shown}, {why}{unit}")
}

/// Why a solid cannot be printed on this machine.
fn find_solid_fault(solid: &PartFileSolid, part: &PartRow, profile: &MachineProfile) -> Option<(RefusalCause, String)> {
    let defects = solid.mesh.defects();
    if !defects.is_closed() && profile.intake.mesh_errors == MeshErrorPolicy::Reject {
        let reason = format!(
            "{}: the mesh is not closed ({}), so it is not known what is inside. Repair it, or set mesh_errors = \"warn\" in \
             the profile {}.",
            solid.name,
            defects_text(&defects),
            profile.name
        );
        return Some((RefusalCause::NotClosed, reason));
    }
    find_misfit(solid, part, profile).map(|reason| (RefusalCause::TooLarge, reason))
}

fn defects_text(defects: &MeshDefects) -> String {
    [
        (defects.open_edges, "open edge", "open edges"),
        (defects.non_manifold_edges, "edge of more than two triangles", "edges of more than two triangles"),
        (
            defects.inconsistent_edges,
            "edge whose triangles face opposite ways",
            "edges whose triangles face opposite ways",
        ),
    ]
    .iter()
    .filter(|(count, ..)| *count > 0)
    .map(|&(count, one, several)| build_file::format_count(count, one, several))
    .collect::<Vec<_>>()
    .join(", ")
}

/// Why a solid does not fit into the machine in any allowed orientation. Nothing is rescaled; if it would fit in
/// another unit, the reason says so.
fn find_misfit(solid: &PartFileSolid, part: &PartRow, profile: &MachineProfile) -> Option<String> {
    let rule = part.terms.orientation;
    let volume = profile.build_volume();
    let misfit = nester::find_fitting_rotation(&solid.mesh, &part.orientation_limits(), &volume).err()?;
    if misfit.is_forbidden {
        return Some(format!(
            "{}: no rotation obeys all of its orientation rules ({}{}). Take one of them out of its ticket and drop both again.",
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
    // A wrong unit is the most common reason: give the size in a smaller unit, and let people decide.
    let read_in = profile.intake.unit.mm_per_unit();
    let fits_in = |unit: &LengthUnit| {
        let size = needs * (unit.mm_per_unit() / read_in);
        unit.mm_per_unit() < read_in && size.cmple(has).all() && size.max_element() >= SMALLEST_MEANT_MM
    };
    let smaller = [LengthUnit::Millimeter, LengthUnit::Micron].into_iter().find(fits_in);
    reason.push_str(&match smaller.filter(|_| part.terms.unit.is_none()) {
        Some(unit) => {
            let size = needs * (unit.mm_per_unit() / read_in);
            let word = format!("{unit:?}").to_lowercase();
            format!(
                " Read in {word}s it would be {:.1} x {:.1} x {:.1} mm and fit: if that is meant, drop it with a ticket that says \
                 unit = \"{word}\".",
                size.x, size.y, size.z
            )
        }
        None => " Drop it for a larger machine, or split it; where its ticket holds it upright or fixed, a freer \
                 orientation may fit."
            .to_owned(),
    });
    Some(reason)
}

/// The directions that must point nearly upwards, to be appended to the name of the rule.
fn tilts_text(part: &PartRow) -> String {
    part.terms.tilts.0.iter().map(|tilt| format!(", {}", tilt.in_words())).collect()
}

fn rule_name(rule: OrientationRule) -> &'static str {
    match rule {
        OrientationRule::Free => "free",
        OrientationRule::Upright => "upright",
        OrientationRule::Axis => "axis",
        OrientationRule::Fixed => "fixed",
    }
}
