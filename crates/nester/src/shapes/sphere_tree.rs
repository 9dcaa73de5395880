//! Points spread over a part's surface, in a tree of bounding spheres. They are looked up in another part's distance
//! grid.

use std::collections::HashMap;

use glam::{DVec3, Vec3};
use rand::RngExt;
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};
use solids::Mesh;

use super::{
    bounding_sphere::BoundingSphere,
    byte_codec::{ByteReader, ByteWriter},
    sphere_walk::SphereWalk,
};

/// Greatest number of points in a leaf.
const MAX_LEAF_POINTS: usize = 6;

/// Surface points of a part in its frame, relative to its center, and the spheres around them.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SphereTree {
    points: Vec<Vec3>,
    spheres: Vec<BoundingSphere>,
    /// The same points and spheres.
    pub(crate) walk: SphereWalk,
    /// Surface area that each point represents, mm2.
    pub(crate) point_area: f32,
}

impl SphereTree {
    /// Samples about `wanted` points: first along sharp edges, where parts meet, then over the faces.
    pub(crate) fn new(
        &MeasuredSurface { mesh, area, ref sharp }: &MeasuredSurface<'_>,
        center: DVec3,
        wanted: usize,
    ) -> Self {
        let mut spacing = (area / (0.7 * wanted as f64)).sqrt().max(1e-3);
        let mut points = sample_surface(mesh, sharp, spacing);
        for _ in 0..8 {
            if points.len() <= wanted + wanted / 2 {
                break;
            }
            spacing *= 1.3;
            points = sample_surface(mesh, sharp, spacing);
        }
        let mut points: Vec<Vec3> = points.into_iter().map(|p| (p - center).as_vec3()).collect();
        let mut spheres = Vec::with_capacity(points.len());
        let count = points.len();
        build_spheres(&mut points, 0, count, &mut spheres);
        let walk = SphereWalk::new(&spheres, &points).expect("every sphere was divided into two");
        Self { point_area: (area / points.len() as f64) as f32, points, spheres, walk }
    }

    /// Writes the tree as bytes.
    pub(super) fn write_to(&self, to: &mut ByteWriter) {
        to.write_f32s(&[self.point_area]);
        to.write_u32(self.points.len() as u32);
        self.points.iter().for_each(|p| to.write_f32s(&p.to_array()));
        to.write_u32(self.spheres.len() as u32);
        for sphere in &self.spheres {
            to.write_f32s(&sphere.center.to_array());
            to.write_f32s(&[sphere.radius]);
            [sphere.next_sibling, sphere.first, sphere.count].into_iter().for_each(|n| to.write_u32(n));
        }
    }

    /// Reads the tree from bytes; `None` if a traversal would not end or would leave the points.
    pub(super) fn read_from(from: &mut ByteReader<'_>) -> Option<Self> {
        let [point_area] = from.read_f32s()?;
        let count = from.read_u32()?;
        let points: Vec<Vec3> = (0..count).map(|_| from.read_f32s().map(Vec3::from_array)).collect::<Option<_>>()?;
        let count = from.read_u32()?;
        let sphere = |at: u32, from: &mut ByteReader<'_>| {
            let (center, [radius]) = (Vec3::from_array(from.read_f32s()?), from.read_f32s()?);
            let [skip, first, own] = [from.read_u32()?, from.read_u32()?, from.read_u32()?];
            let is_sound = skip > at && skip <= count && first.checked_add(own)? as usize <= points.len();
            is_sound.then_some(BoundingSphere { center, radius, next_sibling: skip, first, count: own })
        };
        let spheres = (0..count).map(|at| sphere(at, from)).collect::<Option<Vec<BoundingSphere>>>()?;
        let walk = SphereWalk::new(&spheres, &points)?;
        Some(Self { points, spheres, walk, point_area })
    }

    /// All spheres.
    #[cfg(test)]
    pub(crate) fn spheres(&self) -> &[BoundingSphere] {
        &self.spheres
    }

    /// All points.
    pub(crate) fn points(&self) -> &[Vec3] {
        &self.points
    }
}

fn surface_area(mesh: &Mesh) -> f64 {
    (0..mesh.triangles().len()).map(|t| triangle_area(mesh.corners(t))).sum()
}

fn triangle_area([a, b, c]: [DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

/// What every sampling of a surface needs of it.
pub(crate) struct MeasuredSurface<'a> {
    mesh: &'a Mesh,
    /// mm2.
    area: f64,
    sharp: Vec<[DVec3; 2]>,
}

impl<'a> MeasuredSurface<'a> {
    /// Measures the surface of a mesh.
    pub(crate) fn new(mesh: &'a Mesh) -> Self {
        Self { mesh, area: surface_area(mesh), sharp: sharp_edges(mesh) }
    }
}

/// Edges whose two faces meet at more than about 30 degrees.
fn sharp_edges(mesh: &Mesh) -> Vec<[DVec3; 2]> {
    let edges = || {
        let of_triangle = |(t, &[a, b, c]): (usize, &[u32; 3])| [(a, b, t), (b, c, t), (c, a, t)];
        mesh.triangles().iter().enumerate().flat_map(of_triangle)
    };
    // A counting sort by the lower vertex leaves a handful of edges in each bucket.
    let mut ends = vec![0_u32; mesh.vertices().len() + 1];
    edges().for_each(|(a, b, _)| ends[a.min(b) as usize + 1] += 1);
    (1..ends.len()).for_each(|vertex| ends[vertex] += ends[vertex - 1]);
    let mut sorted = vec![(0_u32, 0_u32); 3 * mesh.triangles().len()];
    for (a, b, t) in edges() {
        let next = &mut ends[a.min(b) as usize];
        sorted[*next as usize] = (a.max(b), t as u32);
        *next += 1;
    }
    let normal = |t: u32| {
        let [a, b, c] = mesh.corners(t as usize);
        (b - a).cross(c - a).normalize_or(DVec3::ZERO)
    };
    let place = |v: u32| mesh.vertices()[v as usize];
    let mut sharp = Vec::new();
    let mut start = 0;
    for (vertex, &end) in ends[..mesh.vertices().len()].iter().enumerate() {
        let bucket = &mut sorted[start..end as usize];
        bucket.sort_unstable();
        let of_vertex = bucket
            .chunk_by(|x, y| x.0 == y.0)
            .filter(|edge| edge.len() != 2 || normal(edge[0].1).dot(normal(edge[1].1)) < 0.86)
            .map(|edge| [place(vertex as u32), place(edge[0].0)]);
        sharp.extend(of_vertex);
        start = end as usize;
    }
    sharp
}

/// Samples points that are no closer to each other than `spacing` (Poisson disk sampling by dart throwing): edges
/// first, faces after.
fn sample_surface(mesh: &Mesh, sharp: &[[DVec3; 2]], spacing: f64) -> Vec<DVec3> {
    let mut darts = PoissonDiskSampler { spacing, cells: HashMap::new(), points: Vec::new() };
    for &[a, b] in sharp {
        darts.add_if_spaced(a);
        darts.add_if_spaced(b);
    }
    for &[a, b] in sharp {
        let steps = (a.distance(b) / spacing).floor() as usize;
        (1..steps).for_each(|k| darts.add_if_spaced(a.lerp(b, k as f64 / steps as f64)));
    }
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut owed = 0.0;
    for t in 0..mesh.triangles().len() {
        let corners = mesh.corners(t);
        owed += 5.0 * triangle_area(corners) / (spacing * spacing);
        while owed > 0.0 {
            owed -= 1.0;
            let (mut u, mut v): (f64, f64) = (rng.random(), rng.random());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            darts.add_if_spaced(corners[0] + (corners[1] - corners[0]) * u + (corners[2] - corners[0]) * v);
        }
    }
    darts.points
}

struct PoissonDiskSampler {
    spacing: f64,
    cells: HashMap<[i32; 3], Vec<u32>>,
    points: Vec<DVec3>,
}

impl PoissonDiskSampler {
    fn add_if_spaced(&mut self, point: DVec3) {
        let [x, y, z] = (point / self.spacing).floor().to_array().map(|v| v as i32);
        // The point's own cell comes first: no other one holds as much of what is too near.
        for dx in [0, -1, 1] {
            for dy in [0, -1, 1] {
                for dz in [0, -1, 1] {
                    let near = self.cells.get(&[x + dx, y + dy, z + dz]).map_or(&[][..], Vec::as_slice);
                    if near.iter().any(|&p| self.points[p as usize].distance(point) < self.spacing) {
                        return;
                    }
                }
            }
        }
        self.cells.entry([x, y, z]).or_default().push(self.points.len() as u32);
        self.points.push(point);
    }
}

/// Sorts a range of points into spheres, depth first, and appends them to `spheres`.
fn build_spheres(points: &mut [Vec3], first: usize, count: usize, spheres: &mut Vec<BoundingSphere>) {
    let range = &mut points[first..first + count];
    let (min, max) = range.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), &p| (l.min(p), h.max(p)));
    let center = (min + max) * 0.5;
    let radius = range.iter().map(|p| p.distance(center)).fold(0.0, f32::max);
    let at = spheres.len();
    let leaf = count <= MAX_LEAF_POINTS;
    let own = if leaf { count as u32 } else { 0 };
    spheres.push(BoundingSphere { center, radius, next_sibling: 0, first: first as u32, count: own });
    if !leaf {
        let size = max - min;
        let axis = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let half = count / 2;
        range.select_nth_unstable_by(half, |a, b| a[axis].total_cmp(&b[axis]));
        build_spheres(points, first, half, spheres);
        build_spheres(points, first + half, count - half, spheres);
    }
    spheres[at].next_sibling = spheres.len() as u32;
}
