//! The step "read": turns a claimed part's file into checked meshes, or a reason for refusal. Runs on a job's thread.

use std::sync::Arc;

use build_file::{LengthUnit, PartFileSolid};
use ledger::{PartRow, RefusalCause, SolidFacts};
use settings::MachineProfile;

use super::{
    file_fault::{FileTerms, defects_text, find_file_fault, requested_terms},
    mending::{allowed_by, mend_solids},
    mesh_cache::MeshCacheKey,
    mesh_source::MeshSource,
    read_again::read_in_fixed_unit,
    standing_claim::StandingClaim,
};
use crate::alerts::failure::{LostFileError, PartReadError, error_chain};

/// Coarser coordinates than this share of a layer are told.
const MAX_STEP_PER_LAYER: f64 = 0.1;

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
        Err(failure) => return outcome_without_file(failure, claim.is_some()),
    };
    let fixed_unit = part.measures.read_unit.unwrap_or(profile.intake.unit);
    let judged = meshes.judged.take(part, fixed_unit, &meshes.limits);
    let read = judged.map_or_else(
        || read_in_fixed_unit(&file, part, profile.intake.unit, &meshes.limits),
        |contents| Ok((fixed_unit, contents)),
    );
    let (read_unit, mut contents) = match read {
        Ok(read) => read,
        Err(PartReadError::TryLater(why)) => return PartReadOutcome::TryLater(why),
        Err(PartReadError::Refused(cause, reason)) => return PartReadOutcome::Refused(cause, reason),
    };
    let mended = mend_solids(&mut contents, allowed_by(part, profile).as_deref());
    let (limits, unit) = (part.orientation_limits(), part.terms.unit);
    let terms = FileTerms { limits, unit, read_unit, copies: part.owed.copies, part: Some(part.id) };
    if let Some((cause, reason)) = find_file_fault(&contents, &terms, profile, &meshes.limits) {
        return PartReadOutcome::Refused(cause, reason);
    }
    let mut facts = Vec::new();
    for ((index, solid), mended) in contents.solids.into_iter().enumerate().zip(mended) {
        let request = solid.request.as_deref().and_then(|request| requested_terms(request, profile).ok());
        let mut warnings = if index == 0 { contents.warnings.clone() } else { Vec::new() };
        warnings.extend(solid.warnings.iter().cloned());
        warnings.extend(far_warning(&solid, profile));
        warnings.iter_mut().for_each(|warning| *warning = build_file::escape_invisible(warning));
        let question = size_question(&solid, (part, read_unit), profile);
        let found = solid_facts(&solid, index as u32, part, warnings);
        let mended_hash = mended.as_ref().map_or_else(String::new, |mended| mended.hash.clone());
        let mut found = SolidFacts { question, request, read_unit, mended, ..found };
        found.ask(solid.question.as_deref().unwrap_or_default());
        facts.push(found);
        let key = MeshCacheKey {
            content_hash: part.file.content_hash.clone(),
            object_index: index as u32,
            read_unit: Some(read_unit),
            unit: part.terms.unit,
            mended_hash,
        };
        meshes.mesh_cache.insert(key, solid.mesh);
    }
    PartReadOutcome::Solids(facts)
}

/// A part whose stored file is not there, or cannot be read now.
fn outcome_without_file(failure: anyhow::Error, is_claimed: bool) -> PartReadOutcome {
    match failure.downcast::<LostFileError>() {
        Ok(LostFileError { aside: None, .. }) if !is_claimed => {
            PartReadOutcome::Refused(RefusalCause::Other, "Its file is no longer kept. Drop it again.".to_owned())
        }
        Ok(lost) => PartReadOutcome::LostFile(lost),
        Err(failure) => PartReadOutcome::TryLater(format!("{failure:#}")),
    }
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
        file_copies: solid.copies,
        triangles: solid.mesh.triangles().len() as u64,
        volume_mm3: solid.mesh.volume_mm3(),
        size_mm: solid.mesh.bounds().size().to_array(),
        read_unit: LengthUnit::default(),
        question: String::new(),
        copy_of: String::new(),
        warnings,
        mended: None,
        request: None,
    }
}

/// Tells of a solid so far from the origin of its file that the numbers of its coordinates are coarse beside a layer.
fn far_warning(solid: &PartFileSolid, profile: &MachineProfile) -> Option<String> {
    let step = solid.coordinate_step_mm;
    (step > profile.space.layer_mm * MAX_STEP_PER_LAYER).then(|| {
        format!(
            "Its coordinates are so far from the origin of the file that 32-bit numbers are {step:.4} mm apart there: its \
             details may be off by as much. Move it to the origin in the CAD program and export it again."
        )
    })
}

/// What a person must confirm of a solid that is hardly printable: a speck, which may be one of a wrong unit too.
fn size_question(solid: &PartFileSolid, (part, read_unit): (&PartRow, LengthUnit), profile: &MachineProfile) -> String {
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
        None if is_speck && read_unit == LengthUnit::Millimeter => {
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
