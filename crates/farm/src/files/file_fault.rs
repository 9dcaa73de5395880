//! Why a file that can be read cannot be printed: too many copies, a mesh that is not closed, too large for the machine. What a file asks for
//! its solids itself, as CAMSPEC packages do, is put into the words of the ledger and of the search.

use build_file::{LengthUnit, PartFileContents, PartFileSolid, ReadLimits, SolidRequest};
use intake::Ticket;
use ledger::{PartId, RefusalCause, RequestedTerms, RequiredTilts};
use nester::{FaceNotDown, OrientationLimits, OrientationRule, TiltLimit, TiltLimitError};
use settings::{MachineProfile, MeshErrorPolicy};
use solids::MeshDefects;

use super::mending::mend_text;

/// A part that would be smaller than this in another unit was not meant in it.
const SMALLEST_MEANT_MM: f64 = 1.0;

/// What was asked with a file, as far as it decides whether the file can be printed.
#[derive(Debug, Clone)]
pub(crate) struct FileTerms {
    /// How its solids may be turned.
    pub limits: OrientationLimits,
    /// Unit from the ticket.
    pub unit: Option<LengthUnit>,
    /// Unit in which a file that states none was read.
    pub read_unit: LengthUnit,
    /// Copies ordered.
    pub copies: u32,
    /// The part; `None` = it is none yet.
    pub part: Option<PartId>,
}

impl FileTerms {
    /// The terms of a file with this ticket.
    pub fn of_ticket(ticket: &Ticket, profile: &MachineProfile) -> Self {
        let turning = &profile.turning;
        let limits = OrientationLimits::new(
            ticket.orientation.unwrap_or(turning.orientation),
            ticket.keep_up.as_deref().unwrap_or(&turning.keep_up),
            ticket.not_down.as_deref().unwrap_or(&turning.not_down),
        );
        Self {
            limits,
            unit: ticket.unit,
            read_unit: profile.intake.unit,
            copies: ticket.copies.unwrap_or(1),
            part: None,
        }
    }

    /// These terms with what the file asks for one of its solids itself.
    fn with_request(&self, request: Option<&RequestedTerms>) -> Self {
        let mut terms = self.clone();
        if let Some(request) = request {
            terms.limits.rule = request.orientation.unwrap_or(terms.limits.rule);
            terms.limits.tilts.extend(&request.tilts.0);
        }
        terms
    }
}

/// What a file asks for a solid of this machine.
///
/// # Errors
/// A direction or an angle is none.
pub(crate) fn requested_terms(
    request: &SolidRequest,
    profile: &MachineProfile,
) -> Result<RequestedTerms, TiltLimitError> {
    let up = request.up.iter().map(|&(direction, within_deg)| TiltLimit::new(direction, within_deg));
    let up: Vec<TiltLimit> = up.collect::<Result<_, _>>()?;
    let not_down = request.not_down.iter().map(|&(normal, spare_deg)| FaceNotDown::new(normal, spare_deg));
    let not_down: Vec<FaceNotDown> = not_down.collect::<Result<_, _>>()?;
    Ok(RequestedTerms {
        reference: request.reference.clone(),
        material: request.material.as_deref().map(|word| profile.materials.name_of(word)),
        priority: request.priority,
        clearance_mm: request.clearance_mm,
        orientation: request.is_fixed.then_some(OrientationRule::Fixed),
        tilts: RequiredTilts(OrientationLimits::new(OrientationRule::Free, &up, &not_down).tilts),
    })
}

/// Why the solids of a file cannot be printed on a machine, in whole sentences.
pub(crate) fn find_file_fault(
    contents: &PartFileContents,
    terms: &FileTerms,
    profile: &MachineProfile,
    limits: &ReadLimits,
) -> Option<(RefusalCause, String)> {
    let copies: u64 = contents.solids.iter().map(|s| u64::from(s.copies) * u64::from(terms.copies)).sum();
    if copies > limits.max_copies {
        let reason = format!(
            "It asks for {copies} copies; one file may ask for {} at most (limits.max_copies). Drop it again with fewer, or \
             raise that limit in the configuration and reload nestd.",
            limits.max_copies
        );
        return Some((RefusalCause::Limit, reason));
    }
    let faults: Vec<(RefusalCause, String)> =
        contents.solids.iter().filter_map(|solid| find_solid_fault(solid, terms, profile)).collect();
    // Where all that is wrong can be mended, a yes is enough.
    let (first, _) = faults.iter().find(|(cause, _)| *cause != RefusalCause::Mendable).or(faults.first())?;
    let reasons: Vec<&str> = faults.iter().map(|(_, reason)| reason.as_str()).collect();
    Some((*first, reasons.join("\n")))
}

/// Why a solid cannot be printed on this machine.
fn find_solid_fault(
    solid: &PartFileSolid,
    terms: &FileTerms,
    profile: &MachineProfile,
) -> Option<(RefusalCause, String)> {
    let defects = solid.mesh.defects();
    if !defects.is_closed() && profile.intake.mesh_errors != MeshErrorPolicy::Warn {
        return Some(open_mesh_fault(solid, &defects, terms, profile));
    }
    let terms = match solid.request.as_deref().map(|request| requested_terms(request, profile)).transpose() {
        Ok(request) => terms.with_request(request.as_ref()),
        Err(error) => return Some((RefusalCause::Other, format!("{}: {error}.", solid.name))),
    };
    find_misfit(solid, &terms, profile).map(|reason| (RefusalCause::TooLarge, reason))
}

/// Why a mesh that is not closed is refused: what could be mended if somebody says so, or why it cannot.
fn open_mesh_fault(
    solid: &PartFileSolid,
    defects: &MeshDefects,
    terms: &FileTerms,
    profile: &MachineProfile,
) -> (RefusalCause, String) {
    let found = format!(
        "{}: the mesh is not closed ({}), so it is not known what is inside.",
        solid.name,
        defects_text(defects)
    );
    match solid.mesh.mended() {
        Ok(done) => {
            let remedy = match terms.part {
                Some(part) => format!("`nestd mend {part}` or the button on its page has it mended and printed."),
                None => "A ticket with mend = true has it mended and printed.".to_owned(),
            };
            let reason = format!("{found} It can be mended: {}. {remedy}", mend_text(&done.measures));
            (RefusalCause::Mendable, reason)
        }
        Err(why) => {
            let remedy = format!("Repair it, or set mesh_errors = \"warn\" in the machine {}.", profile.name);
            (RefusalCause::NotClosed, format!("{found} It is not mended, because {why}. {remedy}"))
        }
    }
}

pub(super) fn defects_text(defects: &MeshDefects) -> String {
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
fn find_misfit(solid: &PartFileSolid, terms: &FileTerms, profile: &MachineProfile) -> Option<String> {
    let rule = terms.limits.rule;
    let volume = profile.build_volume();
    let misfit = nester::find_fitting_rotation(&solid.mesh, &terms.limits, &volume).err()?;
    if misfit.is_forbidden {
        return Some(format!(
            "{}: no rotation obeys all of its orientation rules ({}{}). Take one of them out of its ticket and drop both again.",
            solid.name,
            rule_name(rule),
            tilts_text(&terms.limits)
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
        tilts_text(&terms.limits),
        profile.name,
        has.x,
        has.y,
        has.z
    );
    // A wrong unit is the most common reason: give the size in a smaller unit, and let people decide.
    let read_in = terms.read_unit.mm_per_unit();
    let fits_in = |unit: &LengthUnit| {
        let size = needs * (unit.mm_per_unit() / read_in);
        unit.mm_per_unit() < read_in && size.cmple(has).all() && size.max_element() >= SMALLEST_MEANT_MM
    };
    let smaller = [LengthUnit::Millimeter, LengthUnit::Micron].into_iter().find(fits_in);
    reason.push_str(&match smaller.filter(|_| terms.unit.is_none()) {
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
fn tilts_text(limits: &OrientationLimits) -> String {
    limits.tilts.iter().map(|tilt| format!(", {}", tilt.in_words())).collect()
}

fn rule_name(rule: OrientationRule) -> &'static str {
    match rule {
        OrientationRule::Free => "free",
        OrientationRule::Upright => "upright",
        OrientationRule::Axis => "axis",
        OrientationRule::Fixed => "fixed",
    }
}
