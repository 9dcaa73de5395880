//! The filled area of each layer of a build. Heat grows with the filled area, so a machine may limit it. The area of a
//! layer is its mean: the volume between its two planes divided by its thickness. This is exact and does not jump where
//! a face lies in a plane.

use glam::DVec3;
use serde::{Deserialize, Serialize};
use solids::{Mesh, Pose};

use crate::LayerAreaCap;

/// Share by which a cap may be exceeded, because of rounding.
const CAP_TOLERANCE: f64 = 1e-6;

/// The filled areas of the layers of a build.
///
/// ```
/// use glam::DVec3;
/// use nester::{LayerAreas, LayerAreaCap};
/// use solids::{Mesh, Pose};
///
/// let cube = Mesh::cuboid(DVec3::splat(10.0))?;
/// let cap = LayerAreaCap { layer_mm: 0.5, area_mm2: 90.0 };
/// let areas = LayerAreas::from_meshes([(&cube, Pose::IDENTITY)], cap);
/// assert!((areas.largest_area_mm2 - 100.0).abs() < 1e-9 && !areas.keeps_cap());
/// # Ok::<(), solids::MeshError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct LayerAreas {
    /// Thickness of a layer, mm.
    pub layer_mm: f64,
    /// Greatest filled area of any layer, mm2.
    pub largest_area_mm2: f64,
    /// Height of that layer's middle above the floor of the build volume, mm.
    pub largest_at_mm: f64,
    /// Mean filled area of the layers up to the build height, mm2.
    pub mean_area_mm2: f64,
    /// Mean over greatest filled area: 1 when every layer has the same filled area.
    pub evenness: f64,
    /// Greatest filled area that was allowed, mm2; `None` = no limit.
    pub cap_mm2: Option<f64>,
}

impl LayerAreas {
    /// Measures placed meshes; the floor of the build volume is at z = 0.
    pub fn from_meshes<'a>(placed: impl IntoIterator<Item = (&'a Mesh, Pose)>, cap: LayerAreaCap) -> Self {
        let mut filled = FilledLayers::new(cap);
        placed
            .into_iter()
            .for_each(|(mesh, pose)| filled.add_part(&PartLayerAreas::from_mesh(mesh, &pose, cap.layer_mm)));
        filled.layer_areas()
    }

    /// A readable sentence: `the layer at 12.05 mm is filled with 210.0 mm2, 200.0 mm2 are allowed`.
    pub fn in_words(&self) -> String {
        let filled =
            format!("the layer at {:.2} mm is filled with {:.1} mm2", self.largest_at_mm, self.largest_area_mm2);
        match self.cap_mm2 {
            Some(cap_mm2) => format!("{filled}, {cap_mm2:.1} mm2 are allowed"),
            None => filled,
        }
    }

    /// Whether no layer exceeds the allowed area, up to rounding.
    pub fn keeps_cap(&self) -> bool {
        self.cap_mm2.is_none_or(|cap| self.largest_area_mm2 <= cap * (1.0 + 2.0 * CAP_TOLERANCE))
    }
}

/// Filled areas of one part, layer by layer.
#[derive(Debug, Clone)]
pub(crate) struct PartLayerAreas {
    /// First layer.
    pub(crate) first: usize,
    areas: Vec<f64>,
}

impl PartLayerAreas {
    /// Measures a mesh at a pose.
    pub(crate) fn from_mesh(mesh: &Mesh, pose: &Pose, layer_mm: f64) -> Self {
        let points: Vec<DVec3> = mesh.vertices().iter().map(|&v| pose.transform_point(v)).collect();
        let (low, high) =
            points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p.z), high.max(p.z)));
        let layer = |z: f64| (z / layer_mm).floor().max(0.0) as usize;
        let (first, last) = (layer(low), layer(high));
        // The area enclosed by the contours of a closed surface does not depend on the origin; a near origin keeps
        // precision.
        let middle = pose.transform_point(mesh.bounds().center()).with_z(0.0);
        let mut areas = vec![0.0; last - first + 1];
        for &[a, b, c] in mesh.triangles() {
            let corners = [a, b, c].map(|v| points[v as usize] - middle);
            SlicedTriangle::new(corners).add_volumes(first, layer_mm, &mut areas);
        }
        areas.iter_mut().for_each(|area| *area = (*area / layer_mm).max(0.0));
        Self { first, areas }
    }
}

/// A triangle cut by horizontal planes.
struct SlicedTriangle {
    /// Corners from low to high.
    corners: [DVec3; 3],
    /// 1 if the solid is to the left of the direction from the long edge to the other edges, -1 if it is to the right.
    side: f64,
}

impl SlicedTriangle {
    fn new([a, b, c]: [DVec3; 3]) -> Self {
        let normal = (b - a).cross(c - a);
        let mut corners = [a, b, c];
        corners.sort_by(|p, q| p.z.total_cmp(&q.z));
        let [low, middle, high] = corners;
        let share = if high.z > low.z { (middle.z - low.z) / (high.z - low.z) } else { 0.0 };
        let across = middle - low.lerp(high, share);
        // Seen from above, a contour runs along z x normal with the solid on its left.
        let side = if across.y * normal.x - across.x * normal.y >= 0.0 { 1.0 } else { -1.0 };
        Self { corners, side }
    }

    /// Adds the triangle's contribution to the volume of each layer.
    fn add_volumes(&self, first: usize, layer_mm: f64, volumes: &mut [f64]) {
        let [low, middle, high] = self.corners.map(|c| c.z);
        let layer = |z: f64| ((z / layer_mm).floor().max(0.0) as usize).clamp(first, first + volumes.len() - 1);
        for at in layer(low)..=layer(high) {
            // A part slightly below the floor counts for the first layer.
            let bottom = if at == 0 { f64::NEG_INFINITY } else { at as f64 * layer_mm };
            let (from, to) = (low.max(bottom), high.min((at + 1) as f64 * layer_mm));
            let cut = middle.clamp(from, to.max(from));
            volumes[at - first] += self.volume_between(from, cut, true) + self.volume_between(cut, to, false);
        }
    }

    /// The volume between two heights on one side of the middle corner. The area is a quadratic function of the height,
    /// which Simpson's rule integrates exactly.
    fn volume_between(&self, from: f64, to: f64, lower: bool) -> f64 {
        if to <= from {
            return 0.0;
        }
        let [low, middle, high] = self.corners;
        let on = |p: DVec3, q: DVec3, z: f64| p.lerp(q, ((z - p.z) / (q.z - p.z).max(1e-300)).clamp(0.0, 1.0));
        let area = |z: f64| {
            let long = on(low, high, z);
            let short = if lower { on(low, middle, z) } else { on(middle, high, z) };
            0.5 * (long.x * short.y - long.y * short.x)
        };
        self.side * (to - from) / 6.0 * (area(from) + 4.0 * area(0.5 * (from + to)) + area(to))
    }
}

/// Filled areas of all parts together, and their cap.
#[derive(Debug, Clone)]
pub(crate) struct FilledLayers {
    cap: LayerAreaCap,
    areas: Vec<f64>,
}

impl FilledLayers {
    /// No part is added yet.
    pub(crate) fn new(cap: LayerAreaCap) -> Self {
        Self { cap, areas: Vec::new() }
    }

    /// Whether there is a cap.
    pub(crate) fn is_capped(&self) -> bool {
        self.cap.area_mm2.is_finite()
    }

    /// Whether a part may be added.
    pub(crate) fn can_add(&self, slice: &PartLayerAreas) -> bool {
        self.can_add_raised(slice, 0)
    }

    fn can_add_raised(&self, slice: &PartLayerAreas, layers: usize) -> bool {
        let most = self.cap.area_mm2 * (1.0 + CAP_TOLERANCE);
        let here = |at: usize| self.areas.get(slice.first + layers + at).copied().unwrap_or(0.0);
        slice.areas.iter().enumerate().all(|(at, area)| here(at) + area <= most)
    }

    /// The least number of layers by which a part must be raised so that it may be added; `None` when it alone exceeds
    /// the cap.
    pub(crate) fn layers_to_raise(&self, slice: &PartLayerAreas) -> Option<usize> {
        let above_all = self.areas.len().saturating_sub(slice.first);
        (0..=above_all).find(|&layers| self.can_add_raised(slice, layers))
    }

    /// Adds a part.
    pub(crate) fn add_part(&mut self, slice: &PartLayerAreas) {
        let end = slice.first + slice.areas.len();
        if self.areas.len() < end {
            self.areas.resize(end, 0.0);
        }
        self.areas[slice.first..end].iter_mut().zip(&slice.areas).for_each(|(sum, area)| *sum += area);
    }

    /// The height by which a part must be raised so that it may be added, mm; `None` when it alone exceeds the cap.
    pub(crate) fn raise_mm(&self, mesh: &Mesh, pose: &Pose) -> Option<f64> {
        let layers = self.layers_to_raise(&PartLayerAreas::from_mesh(mesh, pose, self.cap.layer_mm))?;
        Some(layers as f64 * self.cap.layer_mm)
    }

    /// Removes a part.
    pub(crate) fn remove_part(&mut self, slice: &PartLayerAreas) {
        let end = slice.first + slice.areas.len();
        self.areas[slice.first..end].iter_mut().zip(&slice.areas).for_each(|(sum, area)| *sum -= area);
    }

    /// The filled areas.
    pub(crate) fn layer_areas(&self) -> LayerAreas {
        let layer_mm = self.cap.layer_mm;
        let greatest = self.areas.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(&a.0)));
        let (at, largest) = greatest.map_or((0, 0.0), |(at, &area)| (at, area));
        let mean = self.areas.iter().sum::<f64>() / self.areas.len().max(1) as f64;
        LayerAreas {
            layer_mm,
            largest_area_mm2: largest,
            largest_at_mm: (at as f64 + 0.5) * layer_mm,
            mean_area_mm2: mean,
            evenness: if largest > 0.0 { mean / largest } else { 1.0 },
            cap_mm2: self.cap.cap_mm2(),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DQuat;
    use proptest::prelude::*;
    use sample_parts::fixtures::star;

    use super::*;
    use crate::tests::testing::{block, hollow};

    fn areas(mesh: &Mesh, pose: &Pose, layer_mm: f64) -> Vec<f64> {
        let slice = PartLayerAreas::from_mesh(mesh, pose, layer_mm);
        [vec![0.0; slice.first], slice.areas].concat()
    }

    #[test]
    fn a_box_fills_its_layers_and_what_it_fills_of_the_last() {
        let at = |z: f64| Pose::new(DQuat::IDENTITY, DVec3::new(100.0, -50.0, z));
        let found = areas(&block(DVec3::new(4.0, 5.0, 2.5)), &at(1.0), 1.0);
        assert!(found.iter().zip([0.0, 20.0, 20.0, 10.0]).all(|(f, w)| (f - w).abs() < 1e-9), "{found:?}");
        let shell = areas(&hollow(10.0, 1.0), &at(-4e-7), 1.0);
        assert!((shell[0] - 100.0).abs() < 1e-4 && (shell[5] - 36.0).abs() < 1e-4, "{shell:?}");
    }

    #[test]
    fn a_part_is_raised_until_the_cap_holds() {
        let mut filled = FilledLayers::new(LayerAreaCap { layer_mm: 1.0, area_mm2: 30.0 });
        let cube = block(DVec3::new(4.0, 5.0, 3.0));
        let slice = PartLayerAreas::from_mesh(&cube, &Pose::IDENTITY, 1.0);
        assert_eq!(filled.layers_to_raise(&slice), Some(0));
        filled.add_part(&slice);
        assert!(!filled.can_add(&slice));
        assert_eq!(filled.layers_to_raise(&slice), Some(3));
        filled.remove_part(&slice);
        assert!(filled.can_add(&slice));
        let plate = PartLayerAreas::from_mesh(&block(DVec3::new(10.0, 10.0, 1.0)), &Pose::IDENTITY, 1.0);
        assert_eq!(filled.layers_to_raise(&plate), None, "too much alone");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        #[test]
        fn layers_add_up_to_the_volume_and_agree_with_cuts(
            genes in [0.0..1.0f64, 0.0..1.0f64, 0.0..1.0f64], z in 20.0..40.0f64, layer_mm in 0.05..3.0f64, seed in 0.0..6.0f64,
        ) {
            let mesh = star(2, |d| (DVec3::new(9.0, 5.0, 3.0) * d).length() * (1.0 + 0.3 * (4.0 * d.y + seed).sin()));
            let pose = Pose::new(crate::orientation::rotations::rotation_from_genes(genes), DVec3::new(30.0, 20.0, z));
            let slice = PartLayerAreas::from_mesh(&mesh, &pose, layer_mm);
            let volume: f64 = slice.areas.iter().sum::<f64>() * layer_mm;
            prop_assert!((volume - mesh.volume_mm3()).abs() < 1e-6 * mesh.volume_mm3(), "{volume}");
            // Layers of half the thickness have the same mean, two by two.
            let half = PartLayerAreas::from_mesh(&mesh, &pose, 0.5 * layer_mm);
            for (at, area) in slice.areas.iter().enumerate() {
                let part = |n: usize| half.areas.get((2 * (slice.first + at) + n).wrapping_sub(half.first)).unwrap_or(&0.0);
                prop_assert!((0.5 * (part(0) + part(1)) - area).abs() < 1e-6 * (1.0 + area));
            }
        }
    }
}
