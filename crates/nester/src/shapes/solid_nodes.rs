//! Finds the nodes of a lattice that lie inside a solid: rays along the three axes vote, and nodes that cannot be
//! reached from outside count as solid.

use glam::DVec3;

/// For every node, whether it is inside the solid or in a sealed cavity. Nodes are in x, then y, then z order.
pub(crate) fn solid_nodes(
    dims: [usize; 3],
    origin: DVec3,
    step: f64,
    triangles: impl Iterator<Item = [DVec3; 3]>,
) -> Vec<bool> {
    let mut rays = [0, 1, 2].map(|axis| AxisCrossings::new(axis, dims));
    for triangle in triangles {
        let corners = triangle.map(|c| ((c - origin) / step).to_array());
        rays.iter_mut().for_each(|rays| rays.add_triangle(&corners));
    }
    rays.iter_mut().for_each(AxisCrossings::accumulate_windings);
    let count: usize = dims.iter().product();
    let votes = |node: usize| rays.iter().filter(|r| r.winding[node] > 0).count();
    let mut solid: Vec<bool> = (0..count).map(|node| votes(node) >= 2).collect();
    let reached = reachable_from_border(dims, &rays, &solid);
    solid.iter_mut().zip(reached).for_each(|(solid, reached)| *solid |= !reached);
    solid
}

/// Crossings of all lattice lines along one axis with the surface.
struct AxisCrossings {
    axis: usize,
    dims: [usize; 3],
    strides: [usize; 3],
    /// At each node, the number of times that the surface was entered minus the number of times that it was left.
    winding: Vec<i16>,
    /// Whether the surface crosses the line between the previous node and this one.
    crossed: Vec<bool>,
}

impl AxisCrossings {
    fn new(axis: usize, dims: [usize; 3]) -> Self {
        let count: usize = dims.iter().product();
        let strides = [1, dims[0], dims[0] * dims[1]];
        Self { axis, dims, strides, winding: vec![0; count], crossed: vec![false; count] }
    }

    /// Adds the crossings with a triangle, whose corners are in steps of the lattice.
    fn add_triangle(&mut self, corners: &[[f64; 3]; 3]) {
        let (axis, dims) = (self.axis, self.dims);
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let flat = corners.map(|c| [c[u], c[v]]);
        let span = |k: usize| {
            let all = flat.map(|c| c[k]);
            (all.iter().copied().fold(f64::INFINITY, f64::min), all.iter().copied().fold(f64::NEG_INFINITY, f64::max))
        };
        let ((u0, u1), (v0, v1)) = (span(0), span(1));
        let first = |low: f64| low.ceil().max(0.0) as usize;
        let end = |high: f64, n: usize| (high.floor().min(n as f64 - 1.0) + 1.0).max(0.0) as usize;
        let (range_u, range_v) = (first(u0)..end(u1, dims[u]), first(v0)..end(v1, dims[v]));
        // Most triangles of a fine mesh cross no line.
        if range_u.is_empty() || range_v.is_empty() {
            return;
        }
        let area = cross_2d(flat[0], flat[1], flat[2]);
        if area.abs() < 1e-12 {
            return;
        }
        for at_v in range_v {
            for at_u in range_u.clone() {
                let place = [at_u as f64, at_v as f64];
                let Some(shares) = barycentric_shares(place, &flat, area) else { continue };
                let depth: f64 = (0..3).map(|k| shares[k] * corners[k][axis]).sum();
                let node = depth.ceil().max(0.0) as usize;
                if node < dims[axis] {
                    let at = node * self.strides[axis] + at_u * self.strides[u] + at_v * self.strides[v];
                    // Seen along +axis, a counter-clockwise projection means that the ray leaves the solid.
                    self.winding[at] += if area > 0.0 { -1 } else { 1 };
                    self.crossed[at] = true;
                }
            }
        }
    }

    /// Sums crossings to winding numbers, from each line's start to its end.
    fn accumulate_windings(&mut self) {
        let (length, stride) = (self.dims[self.axis], self.strides[self.axis]);
        for lines in self.winding.chunks_exact_mut(length * stride) {
            (stride..lines.len()).for_each(|at| lines[at] += lines[at - stride]);
        }
    }
}

fn cross_2d(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Barycentric coordinates of a point in a projected triangle; `None` outside.
fn barycentric_shares(p: [f64; 2], t: &[[f64; 2]; 3], area: f64) -> Option<[f64; 3]> {
    let shares = [cross_2d(p, t[1], t[2]) / area, cross_2d(t[0], p, t[2]) / area, cross_2d(t[0], t[1], p) / area];
    shares.iter().all(|&s| s >= 0.0).then_some(shares)
}

/// Nodes that can be reached from the lattice's border without passing the surface or a solid node.
fn reachable_from_border(dims: [usize; 3], rays: &[AxisCrossings; 3], solid: &[bool]) -> Vec<bool> {
    let strides = [1, dims[0], dims[0] * dims[1]];
    let mut reached = vec![false; solid.len()];
    let mut open = vec![0];
    reached[0] = true;
    while let Some(node) = open.pop() {
        let row = node / dims[0];
        let place = [node - row * dims[0], row % dims[1], row / dims[1]];
        for axis in 0..3 {
            let at = place[axis];
            let mut visit = |next: usize, border: usize| {
                if !reached[next] && !solid[next] && !rays[axis].crossed[border] {
                    reached[next] = true;
                    open.push(next);
                }
            };
            if at + 1 < dims[axis] {
                visit(node + strides[axis], node + strides[axis]);
            }
            if at > 0 {
                visit(node - strides[axis], node);
            }
        }
    }
    reached
}
