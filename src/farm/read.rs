//! The step "read": a claimed part's file becomes checked meshes, or a reason why not. Runs on a job's thread.

use std::sync::Arc;

use build_file::{Solid, Unit};
use nester::OrientationRule;
use solids::Defects;

use super::{
    failure::{Lost, Unread, chain},
    meshes::Meshes,
    shelf::MeshKey,
    standing_claim::StandingClaim,
};
use crate::{
    ledger::{PartRow, Refusal, SolidFacts},
    settings::{MeshErrors, Profile},
};

/// What came out of reading a part's file.
#[derive(Debug)]
pub enum ReadOutcome {
    /// Printable solids.
    Solids(Vec<SolidFacts>),
    /// It cannot be printed; whole sentences for the technician.
    Refused(Refusal, String),
    /// The stored file is damaged: the part waits for it to be dropped again.
    Lost(Lost),
    /// The disk failed, not the file: it is tried again.
    Later(String),
}

/// Reads and checks; the meshes go onto the shelf.
///
/// A stored file that is damaged is put there again from the claimed original, as long as that lies in the hot folder.
pub fn read_part(
    part: &PartRow,
    claim: Option<&StandingClaim>,
    profile: &Arc<Profile>,
    meshes: &Meshes,
) -> ReadOutcome {
    if let Some(Err(failure)) = claim.map(|claim| claim.ensure_stored(&meshes.store, &part.file.content_hash)) {
        return ReadOutcome::Later(chain(&failure));
    }
    let heal = |failure: anyhow::Error| match (Lost::of(&failure), claim) {
        (Some(_), Some(claim)) if meshes.store.put_claimed(&claim.claim).is_ok() => meshes.stored(part),
        _ => Err(failure),
    };
    let file = match meshes.stored(part).or_else(heal) {
        Ok(file) => file,
        Err(failure) => {
            return match failure.downcast::<Lost>() {
                Ok(Lost { aside: None, .. }) if claim.is_none() => {
                    ReadOutcome::Refused(Refusal::Other, "Its file is no longer kept. Drop it again.".to_owned())
                }
                Ok(lost) => ReadOutcome::Lost(lost),
                Err(failure) => ReadOutcome::Later(format!("{failure:#}")),
            };
        }
    };
    let contents = match meshes.contents(file, part, profile.intake.unit) {
        Ok(contents) => contents,
        Err(Unread::Later(why)) => return ReadOutcome::Later(why),
        Err(Unread::Refused(cause, reason)) => return ReadOutcome::Refused(cause, reason),
    };
    let copies: u64 = contents.solids.iter().map(|s| u64::from(s.copies) * u64::from(part.copies)).sum();
    if copies > meshes.limits.max_copies {
        let reason = format!(
            "It asks for {copies} copies; one file may ask for {} at most (limits.max_copies). Drop it again with fewer, or \
             raise that limit in the configuration and reload nestd.",
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
        warnings.iter_mut().for_each(|warning| *warning = build_file::visible(warning));
        facts.push(facts_of(&solid, index as u32, part, warnings));
        let key = MeshKey {
            content_hash: part.file.content_hash.clone(),
            object_index: index as u32,
            default_unit: profile.intake.unit,
            unit: part.terms.unit,
        };
        meshes.shelf.put(key, solid.mesh);
    }
    ReadOutcome::Solids(facts)
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
    if !defects.is_closed() && profile.intake.mesh_errors == MeshErrors::Reject {
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
    .map(|&(count, one, several)| build_file::counted(count, one, several))
    .collect::<Vec<_>>()
    .join(", ")
}

/// Why a solid does not fit into the machine in any allowed orientation. Nothing is rescaled; units in which it would
/// fit are named.
fn misfit_of(solid: &Solid, part: &PartRow, profile: &Profile) -> Option<String> {
    let rule = part.terms.orientation;
    let volume = profile.build_volume();
    let misfit = nester::fits(&solid.mesh, &part.turning(), &volume).err()?;
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
    // Wrong units are the commonest reason: say what the numbers would be in a smaller unit, and let people decide.
    if part.terms.unit.is_none() {
        let read_in = profile.intake.unit.mm();
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
    if !reason.contains("unit = ") {
        reason.push_str(
            " Drop it for a larger machine, or split it; where its ticket holds it upright or fixed, a freer orientation may fit.",
        );
    }
    Some(reason)
}

/// What must stand near to straight up, as it follows the rule's name.
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
