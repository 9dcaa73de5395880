//! What became of the copies that a layout lacks: whether one of them would fit alone, and beside how much of what is
//! placed.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{
    NestingConfig, NestingInstance, NestingSolution, PreparedMeshes, SearchBudget, find_fitting_rotation,
    prepare::prepared_instance::{PlacedItem, PreparedInstance},
    start::{
        layout_builder::LayoutBuilder, nesting_run::NestingRun, recipe::PlacementRecipe, retained::retained_items,
    },
};

/// Number of items, from the front of the order of precedence, for which it is examined beside how much they fit.
const MAX_EXAMINED_ITEMS: usize = 8;
/// At least this number of rotations is tried.
const MIN_ROTATIONS: usize = 12;

/// Where one more copy of an item would fit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct LeftOutFit {
    /// Whether it finds a place in the volume without the placed copies; pinned copies stay.
    pub alone: bool,
    /// Number of placed copies, from the front of the order of precedence, beside which it finds a place while they
    /// stand where they are; `None` when this was not examined, because many items were left out.
    pub beside: Option<usize>,
    /// The same for people.
    pub reason: String,
}

/// Examines each item of which a solution lacks copies; the keys are indices of items. `prepared` are the meshes of the
/// search. Costs about as much as placing the parts of the solution some times.
///
/// ```
/// use std::sync::Arc;
/// use glam::DVec3;
/// use nester::{BuildVolume, NestingConfig, NestingInstance, NestingItem, PreparedMeshes, SearchBudget, examine_left_out, nest_with_cache};
/// use solids::Mesh;
///
/// let cube = Arc::new(Mesh::cuboid(DVec3::splat(20.0))?);
/// let volume = BuildVolume { size_mm: DVec3::new(45.0, 45.0, 22.0) };
/// let instance = NestingInstance::new(volume, 2.0, vec![NestingItem::new("cube", cube, 5)])?;
/// let (config, prepared) = (NestingConfig::default(), PreparedMeshes::default());
///
/// let solution = nest_with_cache(&instance, &config, &[], &prepared, &SearchBudget::of_evaluations(500), &mut ());
/// let fit = &examine_left_out(&instance, &config, &solution, &prepared)[&0];
/// assert!(fit.alone);
/// assert_eq!((fit.beside, solution.placements.len()), (Some(3), 4));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn examine_left_out(
    instance: &NestingInstance,
    config: &NestingConfig,
    solution: &NestingSolution,
    prepared: &PreparedMeshes,
) -> BTreeMap<usize, LeftOutFit> {
    if solution.unplaced.is_empty() {
        return BTreeMap::new();
    }
    let stop = SearchBudget::until_cancelled();
    NestingRun::new(instance, config, prepared, &stop, &mut ()).examine_items(solution)
}

impl NestingRun<'_> {
    fn examine_items(&self, solution: &NestingSolution) -> BTreeMap<usize, LeftOutFit> {
        let Some(task) = self.prepare_instance(self.outline_instance().into()) else { return BTreeMap::new() };
        let mut pieces = retained_items(&task, self.instance, &solution.placements);
        // Pinned copies come first: they are always there.
        pieces.sort_by_key(|piece| (!task.is_fixed((piece.item, piece.copy)), piece.item, piece.copy));
        let mut builder = LayoutBuilder::new(&task).with_rotations(MIN_ROTATIONS);
        let mut fits = BTreeMap::new();
        for &copy in &solution.unplaced {
            if fits.contains_key(&copy.0) {
                continue;
            }
            let fit = match self.misfit_reason(copy.0) {
                Some(reason) => LeftOutFit { alone: false, beside: None, reason },
                None => examine_copy(&task, &mut builder, &pieces, copy, fits.len() < MAX_EXAMINED_ITEMS),
            };
            fits.insert(copy.0, fit);
        }
        fits
    }

    /// Why an item fits in no allowed orientation, if that is so.
    fn misfit_reason(&self, item: usize) -> Option<String> {
        let (item, volume) = (&self.instance.items()[item], self.instance.volume());
        find_fitting_rotation(&item.mesh, &item.orientation, &volume).err().map(|misfit| misfit.reason(&volume))
    }
}

/// Examines a copy that fits the volume; `pieces` are the pinned copies, then the others in order of precedence.
fn examine_copy<'t>(
    task: &'t PreparedInstance,
    builder: &mut LayoutBuilder<'t>,
    pieces: &[PlacedItem],
    copy: (usize, u32),
    is_first: bool,
) -> LeftOutFit {
    let pinned = pieces.iter().filter(|piece| task.is_fixed((piece.item, piece.copy))).count();
    let mut fits_beside = |count: usize| {
        let mut stack = builder.start_layout(&pieces[..count]);
        builder.place_copy(&PlacementRecipe::FIRST[0], copy, &mut stack)
    };
    if !fits_beside(pinned) {
        let reason = "finds no place even in the empty volume".to_owned();
        return LeftOutFit { alone: false, beside: None, reason };
    }
    if !is_first {
        return LeftOutFit { alone: true, beside: None, reason: "one of them would fit alone".to_owned() };
    }
    let (mut beside, mut too_many) = (pinned, pieces.len() + 1);
    while too_many > beside + 1 {
        let middle = beside.midpoint(too_many);
        if fits_beside(middle) {
            beside = middle;
        } else {
            too_many = middle;
        }
    }
    let reason = match beside {
        0 => "one of them would fit alone, but not beside the first placed copy".to_owned(),
        _ => {
            let volume_mm3 = |pieces: &[PlacedItem]| -> f64 {
                pieces.iter().map(|piece| task.outlined.outlined_item(piece.item).mesh.volume_mm3()).sum()
            };
            let percent = 100.0 * volume_mm3(&pieces[..beside]) / volume_mm3(pieces);
            format!(
                "one of them would fit alone, and beside the first {beside} of the {} placed copies ({percent:.0} % of \
                 their volume)",
                pieces.len()
            )
        }
    };
    LeftOutFit { alone: true, beside: Some(beside), reason }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::{
        OrientationRule,
        tests::{
            nester_tests::{asked, item},
            testing::block,
        },
    };

    fn examined(instance: &NestingInstance) -> (NestingSolution, BTreeMap<usize, LeftOutFit>) {
        let (config, prepared) = (NestingConfig::default(), PreparedMeshes::default());
        let budget = SearchBudget::of_evaluations(2000);
        let solution = crate::nest_with_cache(instance, &config, &[], &prepared, &budget, &mut ());
        let fits = examine_left_out(instance, &config, &solution, &prepared);
        (solution, fits)
    }

    #[test]
    fn a_copy_that_is_left_out_fits_alone_and_beside_what_leaves_its_room_free() {
        // Four cubes fill the floor. The plate needs the room of two of them: it fits beside the first two.
        let items = vec![
            item(block(DVec3::splat(20.0)), 4, OrientationRule::Fixed),
            item(block(DVec3::new(42.0, 20.0, 20.0)), 2, OrientationRule::Fixed),
            item(block(DVec3::splat(60.0)), 1, OrientationRule::Free),
        ];
        let (solution, fits) = examined(&asked(DVec3::new(45.0, 45.0, 22.0), 2.0, items));
        assert_eq!(solution.unplaced, [(1, 0), (1, 1), (2, 0)]);
        assert_eq!((fits[&1].alone, fits[&2].alone, fits[&2].beside), (true, false, None));
        let beside = fits[&1].beside.expect("examined");
        assert!((1..=2).contains(&beside), "{fits:?}");
        let told = format!("beside the first {beside} of the 4 placed copies ({} % of their volume)", 25 * beside);
        assert!(fits[&1].reason.contains(&told), "{fits:?}");
        assert!(fits[&2].reason.contains("needs 60.0 x 60.0 x 60.0 mm"), "{fits:?}");
    }

    #[test]
    fn where_much_is_left_out_only_the_first_items_are_examined_beside_the_others() {
        let items =
            (0..12).map(|n| item(block(DVec3::new(20.0, 20.0, 18.0 + 0.1 * f64::from(n))), 1, OrientationRule::Fixed));
        let (solution, fits) = examined(&asked(DVec3::new(22.0, 45.0, 20.0), 2.0, items.collect()));
        assert_eq!((solution.placements.len(), fits.len()), (2, 10));
        let examined: Vec<bool> = fits.values().map(|fit| fit.beside == Some(1)).collect();
        assert_eq!(examined, [[true; 8].as_slice(), &[false; 2]].concat());
        assert!(
            fits.values().all(|fit| fit.alone && fit.reason.starts_with("one of them would fit alone")),
            "{fits:?}"
        );
    }
}
