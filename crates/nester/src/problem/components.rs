//! Components of our own search that can be disabled one by one, so that a bench can measure the contribution of each
//! (ablation).

/// Enabled components; all of them unless a bench disables some.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SearchComponents {
    /// Flower pollination proposes new places for parts. Disabled: uniform random sampling with as many queries.
    pub flowers_in_relocation: bool,
    /// Flower pollination proposes recipes for first layouts. Disabled: uniform random sampling with as many runs.
    pub flowers_in_start: bool,
    /// Overlapping parts are relocated within the whole volume.
    pub relocation: bool,
    /// Failed height limits leave near-feasible layouts to continue from.
    pub pool: bool,
    /// The weight of a pair grows while the pair overlaps, and that of a part while it stands out of the room.
    pub weights: bool,
    /// All parts make room together. Disabled: one part after the other is pushed.
    pub joint_steps: bool,
    /// Parts rotate while they are pushed apart.
    pub turning: bool,
    /// The height limit is lowered on the first layouts. Disabled: the first layouts are the result.
    pub separation: bool,
    /// Distance grids are refined as far as the budget allows. Disabled: those of the first layouts are used.
    pub fine_proxies: bool,
    /// Parts finally move down and towards the origin.
    pub tie_breaks: bool,
}

impl Default for SearchComponents {
    fn default() -> Self {
        Self {
            flowers_in_relocation: true,
            flowers_in_start: true,
            relocation: true,
            pool: true,
            weights: true,
            joint_steps: true,
            turning: true,
            separation: true,
            fine_proxies: true,
            tie_breaks: true,
        }
    }
}

impl SearchComponents {
    /// Each component's name, and the search with that component disabled.
    pub fn each_disabled() -> [(&'static str, Self); 10] {
        let all = Self::default();
        [
            ("flowers in relocation (uniform sampling instead)", Self { flowers_in_relocation: false, ..all }),
            ("flowers in the start (uniform sampling instead)", Self { flowers_in_start: false, ..all }),
            ("relocation", Self { relocation: false, ..all }),
            ("pool of failed height limits", Self { pool: false, ..all }),
            ("pair weights", Self { weights: false, ..all }),
            ("joint steps (one part after the other instead)", Self { joint_steps: false, ..all }),
            ("rotation while separating", Self { turning: false, ..all }),
            ("separation (first layouts only)", Self { separation: false, ..all }),
            ("fine proxies", Self { fine_proxies: false, ..all }),
            ("tie-breaks at the end", Self { tie_breaks: false, ..all }),
        ]
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::{
        BuildVolume, NestingConfig, NestingInstance, NestingItem, NestingSolution, OrientationRule, PlacedSolid,
        StopCondition, nest, prove_placed_solids,
        tests::testing::{block, tetrahedron},
    };

    struct AblationTestBudget;

    impl StopCondition for AblationTestBudget {
        fn spent_share_at(&self, evaluations: u64) -> f64 {
            evaluations as f64 / 24_000.0
        }
    }

    fn nested(instance: &NestingInstance, components: SearchComponents) -> NestingSolution {
        let config = NestingConfig { components, ..NestingConfig::default() };
        nest(instance, &config, &[], &AblationTestBudget, &mut |_: &NestingSolution, _: u64| {})
    }

    #[test]
    fn every_component_takes_part_and_none_is_needed_for_a_proved_layout() {
        let item = |name: &str, mesh, copies| NestingItem {
            name: name.to_owned(),
            mesh,
            copies,
            orientation: OrientationRule::Free.into(),
            clearance_mm: None,
        };
        let corner = tetrahedron([DVec3::ZERO, DVec3::X * 7.5, DVec3::Y * 6.5, DVec3::Z * 5.5]);
        let items = vec![item("corner", corner, 4), item("bar", block(DVec3::new(1.5, 7.0, 2.25)), 3)];
        let volume = BuildVolume { size_mm: DVec3::new(9.5, 9.5, 60.0) };
        let instance = NestingInstance::new(volume, 1.0, items).expect("makes sense");
        let whole = nested(&instance, SearchComponents::default());
        for (component, components) in SearchComponents::each_disabled() {
            let solution = nested(&instance, components);
            let body = |p: &crate::ItemPlacement| PlacedSolid {
                name: instance.items()[p.item].name.clone(),
                mesh: instance.items()[p.item].mesh.clone(),
                pose: p.pose,
                clearance_mm: 1.0,
            };
            let bodies: Vec<PlacedSolid> = solution.placements.iter().map(body).collect();
            assert!(
                solution.unplaced.is_empty() && prove_placed_solids(&bodies, volume.size_mm).is_proved(),
                "without {component}"
            );
            // The evaluations are compared too: a first layout that is not the best changes nothing else.
            assert!(solution != whole, "nothing changes without {component}");
        }
    }
}
