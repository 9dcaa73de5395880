//! Organs of our own search that can be taken out one by one, so that a bench can tell what each of them is worth.

/// Which organs take part; all of them unless a bench says otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Organs {
    /// Flower pollination proposes where a part could move to; without it, even sampling with as many questions.
    pub flowers_in_relocation: bool,
    /// Flower pollination proposes recipes for first layouts; without it, even sampling with as many runs.
    pub flowers_in_start: bool,
    /// Overlapping parts look for another place in the whole volume.
    pub relocation: bool,
    /// Failed lids leave near-feasible layouts to go on from.
    pub pool: bool,
    /// The weight of a pair grows as long as it overlaps.
    pub weights: bool,
    /// Parts turn while they are pushed out of each other.
    pub turning: bool,
    /// The lid falls over the first layout; without it, the first layouts are all there is.
    pub separation: bool,
    /// Distance grids as fine as the budget allows; without it, those of the first layouts.
    pub fine_guides: bool,
    /// Parts move down and towards the origin in the end.
    pub settling: bool,
}

impl Default for Organs {
    fn default() -> Self {
        Self {
            flowers_in_relocation: true,
            flowers_in_start: true,
            relocation: true,
            pool: true,
            weights: true,
            turning: true,
            separation: true,
            fine_guides: true,
            settling: true,
        }
    }
}

impl Organs {
    /// Each organ's name and the search without it.
    pub fn each_taken_out() -> [(&'static str, Self); 9] {
        let all = Self::default();
        [
            ("flowers in relocation (even sampling instead)", Self { flowers_in_relocation: false, ..all }),
            ("flowers in the start (even sampling instead)", Self { flowers_in_start: false, ..all }),
            ("relocation", Self { relocation: false, ..all }),
            ("pool of failed lids", Self { pool: false, ..all }),
            ("pair weights", Self { weights: false, ..all }),
            ("turning while pushed", Self { turning: false, ..all }),
            ("separation (first layouts only)", Self { separation: false, ..all }),
            ("fine guides", Self { fine_guides: false, ..all }),
            ("settling in the end", Self { settling: false, ..all }),
        ]
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::{
        Body, BuildVolume, Config, Instance, Item, OrientationRule, Solution, Stop, nest, prove,
        testing::{block, tetrahedron},
    };

    struct Evaluations;

    impl Stop for Evaluations {
        fn spent(&self, evaluations: u64) -> f64 {
            evaluations as f64 / 24_000.0
        }
    }

    fn nested(instance: &Instance, organs: Organs) -> Solution {
        let config = Config { organs, ..Config::default() };
        nest(instance, &config, &[], &Evaluations, &mut |_: &Solution, _: u64| {})
    }

    #[test]
    fn every_organ_takes_part_and_none_is_needed_for_a_proved_layout() {
        let item = |name: &str, mesh, copies| Item {
            name: name.to_owned(),
            mesh,
            copies,
            orientation: OrientationRule::Free.into(),
            clearance_mm: None,
        };
        let corner = tetrahedron([DVec3::ZERO, DVec3::X * 7.5, DVec3::Y * 6.5, DVec3::Z * 5.5]);
        let items = vec![item("corner", corner, 4), item("bar", block(DVec3::new(1.5, 7.0, 2.25)), 3)];
        let volume = BuildVolume { size_mm: DVec3::new(9.5, 9.5, 60.0) };
        let instance = Instance::new(volume, 1.0, items).expect("makes sense");
        let whole = nested(&instance, Organs::default());
        for (organ, organs) in Organs::each_taken_out() {
            let solution = nested(&instance, organs);
            let body = |p: &crate::Placement| Body {
                name: instance.items()[p.item].name.clone(),
                mesh: instance.items()[p.item].mesh.clone(),
                pose: p.pose,
                clearance_mm: 1.0,
            };
            let bodies: Vec<Body> = solution.placements.iter().map(body).collect();
            assert!(solution.unplaced.is_empty() && prove(&bodies, volume.size_mm).is_proved(), "without {organ}");
            // Also the evaluations: a first layout that is not the best changes nothing else.
            assert!(solution != whole, "nothing changes without {organ}");
        }
    }
}
