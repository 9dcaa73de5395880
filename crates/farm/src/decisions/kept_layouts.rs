//! The layouts of open builds that the ledger keeps while they wait, and what they are valid for.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::Result;
use build_file::DeliveryKind;
use delivery::build::MachineSpec;
use ledger::{BuildId, Ledger, NightSearchRow, PartId, PartRow};
use nester::LayerAreaCap;
use settings::MachineProfile;

use super::layout::{LayoutPlacement, layouts_from_json};

/// The lowest layout that is kept of exactly these copies with these rules.
pub(crate) async fn find_kept_layout(
    ledger: &Ledger,
    build: BuildId,
    profile: &MachineProfile,
    wanted: &[(PartRow, Vec<u32>)],
) -> Result<Option<Vec<LayoutPlacement>>> {
    let row = find_row(ledger, build, &hash_problem(profile, wanted)).await?;
    Ok(row.and_then(|row| layouts_from_json(&row.pool).ok()?.into_iter().next()))
}

/// How far the search for these copies and rules has come.
pub(crate) async fn find_row(ledger: &Ledger, build: BuildId, problem: &str) -> Result<Option<NightSearchRow>> {
    Ok(ledger.find_night_search(build).await?.filter(|row| row.problem == problem))
}

/// Whether the layouts of a machine stay valid when its profile changes.
pub(crate) fn keeps_layouts(before: &MachineProfile, after: &MachineProfile) -> bool {
    describe_machine(before) == describe_machine(after)
}

/// What layouts depend on in a profile: not how the build file is written.
fn describe_machine(profile: &MachineProfile) -> String {
    let machine = profile.to_machine();
    let layer_cap = machine.layer_cap.cap_mm2().map(|_| machine.layer_cap);
    let delivery = if machine.delivery.is_rounded() { DeliveryKind::Stl } else { DeliveryKind::default() };
    let arrangement = Default::default();
    let machine = MachineSpec { layer_cap: LayerAreaCap::default(), delivery, arrangement, ..machine };
    format!("{machine:?} {layer_cap:?}")
}

/// BLAKE3 of everything that a layout depends on: the machine, the meshes, the copies and the rules for them. The order of
/// `wanted` makes no difference.
pub(crate) fn hash_problem(profile: &MachineProfile, wanted: &[(PartRow, Vec<u32>)]) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(describe_machine(profile).as_bytes());
    let mut by_part: BTreeMap<PartId, (&PartRow, BTreeSet<u32>)> = BTreeMap::new();
    for (part, copies) in wanted {
        by_part.entry(part.id).or_insert_with(|| (part, BTreeSet::new())).1.extend(copies);
    }
    for (part, copies) in by_part.values() {
        let (file, limits) = ((&part.file.content_hash, part.solid.object_index), part.orientation_limits());
        let rules = (part.terms.unit, part.size_mm(), part.terms.clearance_mm, limits, copies);
        hasher.update(format!("{} {file:?} {rules:?}", part.id).as_bytes());
    }
    hasher.finalize().to_string()
}
