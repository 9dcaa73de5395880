//! Solids given by a few lengths: bodies of a machine, stand-ins for parts, examples.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use crate::{Mesh, MeshError};

/// Corners of each circle of a tube.
const CIRCLE_CORNERS: u32 = 64;

impl Mesh {
    /// A box with one corner at the origin and the opposite one at `size_mm`.
    ///
    /// # Errors
    /// [`MeshError::NoVolume`] or [`MeshError::Empty`] where an edge is 0, [`MeshError::NotFinite`] where it is no finite number.
    ///
    /// ```
    /// use glam::DVec3;
    /// use solids::Mesh;
    ///
    /// let bar = Mesh::cuboid(DVec3::new(80.0, 10.0, 5.0))?;
    /// assert!(bar.defects().is_closed() && (bar.volume_mm3() - 4000.0).abs() < 1e-9);
    /// # Ok::<(), solids::MeshError>(())
    /// ```
    pub fn cuboid(size_mm: DVec3) -> Result<Self, MeshError> {
        let corner = |n: u32| size_mm * DVec3::new((n & 1) as f64, (n >> 1 & 1) as f64, (n >> 2 & 1) as f64);
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Self::new((0..8).map(corner).collect(), triangles)
    }

    /// A tube around the z axis, from z = 0 to `height_mm`; its circles of `outer_mm` and `inner_mm` diameter are polygons of 64
    /// corners. An inner diameter of 0 makes a cylinder.
    ///
    /// # Errors
    /// As [`Mesh::cuboid`]; [`MeshError::NoVolume`] where both diameters are equal, too.
    ///
    /// ```
    /// use solids::Mesh;
    ///
    /// let ring = Mesh::tube(30.0, 20.0, 6.0)?;
    /// assert!(ring.defects().is_closed() && ring.bounds().size().z == 6.0);
    /// # Ok::<(), solids::MeshError>(())
    /// ```
    pub fn tube(outer_mm: f64, inner_mm: f64, height_mm: f64) -> Result<Self, MeshError> {
        // The corners of one cross section: outer bottom, outer top, inner top, inner bottom.
        let section = |n: u32| {
            let way = DVec2::from_angle(TAU * f64::from(n) / f64::from(CIRCLE_CORNERS)) / 2.0;
            [(outer_mm, 0.0), (outer_mm, height_mm), (inner_mm, height_mm), (inner_mm, 0.0)]
                .map(|(diameter_mm, z)| (way * diameter_mm).extend(z))
        };
        let triangles = (0..CIRCLE_CORNERS).flat_map(|n| {
            let next = (n + 1) % CIRCLE_CORNERS;
            (0..4).flat_map(move |side| {
                let after = (side + 1) % 4;
                let [a, b, c, d] = [4 * n + side, 4 * next + side, 4 * next + after, 4 * n + after];
                [[a, b, c], [a, c, d]]
            })
        });
        Self::new((0..CIRCLE_CORNERS).flat_map(section).collect(), triangles.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn simple_solids_are_closed_and_have_their_volumes() {
        let area_mm2 = |diameter_mm: f64| {
            let angle = TAU / f64::from(CIRCLE_CORNERS);
            f64::from(CIRCLE_CORNERS) / 8.0 * diameter_mm * diameter_mm * angle.sin()
        };
        let solids = [
            (Mesh::cuboid(DVec3::new(2.0, 3.0, 4.0)), 24.0),
            (Mesh::tube(30.0, 20.0, 6.0), 6.0 * (area_mm2(30.0) - area_mm2(20.0))),
            (Mesh::tube(30.0, 0.0, 6.0), 6.0 * area_mm2(30.0)),
        ];
        for (solid, volume_mm3) in solids {
            let solid = solid.expect("is a solid");
            assert!(solid.defects().is_closed() && !solid.defects().inverted);
            assert!((solid.volume_mm3() - volume_mm3).abs() < 1e-9 * volume_mm3, "{}", solid.volume_mm3());
        }
    }

    #[test]
    fn lengths_without_a_volume_are_refused() {
        assert!(Mesh::cuboid(DVec3::new(2.0, 0.0, 4.0)).is_err());
        assert!(Mesh::tube(20.0, 20.0, 4.0).is_err());
        assert!(Mesh::tube(0.0, 0.0, 4.0).is_err());
        assert!(matches!(Mesh::tube(f64::NAN, 0.0, 4.0), Err(MeshError::NotFinite { .. })));
    }
}
