//! Solids that are constant between levels: adjacent plane regions, each filled in some of the slabs.

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use super::{outline::PlanarOutline, surface::SurfaceBuilder, triangulate::triangulate_outline};

/// A directed edge, by the bits of its end points.
type DirectedEdgeKey = [u64; 4];

fn edge_key(a: DVec2, b: DVec2) -> DirectedEdgeKey {
    let [a, b] = [a + DVec2::ZERO, b + DVec2::ZERO];
    [a.x.to_bits(), a.y.to_bits(), b.x.to_bits(), b.y.to_bits()]
}

/// One outline, filled from the first to the last level.
pub(crate) fn extrude_prism(outline: PlanarOutline, levels: &[f64]) -> SurfaceBuilder {
    extrude_layers(&[outline], levels, |_, _| true, |_, _| true)
}

/// Builds a solid from regions that share whole edges or do not touch, filled where `solid(region, slab)` is true. Slab
/// k lies between levels k and k + 1, in rising order, mm. Walls are omitted on edges for which `walled` is false; the
/// caller adds other surfaces there.
pub(crate) fn extrude_layers(
    regions: &[PlanarOutline],
    levels: &[f64],
    solid: impl Fn(usize, usize) -> bool,
    walled: impl Fn(DVec2, DVec2) -> bool,
) -> SurfaceBuilder {
    debug_assert!(levels.is_sorted_by(|a, b| a < b), "levels rise");
    let slabs = levels.len() - 1;
    let region_of_edge: HashMap<DirectedEdgeKey, usize> = (regions.iter().enumerate())
        .flat_map(|(r, region)| region.edges().map(move |(a, b)| (edge_key(a, b), r)))
        .collect();
    let mut surface = SurfaceBuilder::default();
    for (r, region) in regions.iter().enumerate() {
        for (a, b) in region.edges().filter(|&(a, b)| walled(a, b)) {
            let neighbour = region_of_edge.get(&edge_key(b, a));
            for slab in 0..slabs {
                if solid(r, slab) && !neighbour.is_some_and(|&n| solid(n, slab)) {
                    let [low, high] = [levels[slab], levels[slab + 1]];
                    surface.add_quad(a.extend(low), b.extend(low), b.extend(high), a.extend(high));
                }
            }
        }
        add_faces(&mut surface, region, levels, |slab| solid(r, slab));
    }
    surface
}

/// Adds the faces of a region at the levels where it starts or stops being solid.
fn add_faces(surface: &mut SurfaceBuilder, region: &PlanarOutline, levels: &[f64], solid: impl Fn(usize) -> bool) {
    let triangles = triangulate_outline(region);
    for (at, &z) in levels.iter().enumerate() {
        let (below, above) = (at > 0 && solid(at - 1), at + 1 < levels.len() && solid(at));
        for &[a, b, c] in triangles.iter().filter(|_| below != above) {
            let [a, b, c]: [DVec3; 3] = [a, b, c].map(|p| p.extend(z));
            if below { surface.add_triangle(a, b, c) } else { surface.add_triangle(a, c, b) }
        }
    }
}
