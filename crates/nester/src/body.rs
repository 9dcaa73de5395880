//! Points spread over a part's surface, in a tree of spheres: where another part's distance grid is asked.

use std::collections::HashMap;

use glam::{DVec3, Vec3};
use rand::RngExt;
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};
use solids::Mesh;

use super::pack::{Packer, Unpacker};

/// Points of a leaf at most.
const LEAF: usize = 6;

/// A sphere around some of the points; nodes stand in depth-first order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sphere {
    pub(crate) center: Vec3,
    pub(crate) radius: f32,
    /// The node to go on with when this one is of no interest.
    pub(crate) skip: u32,
    first: u32,
    count: u32,
}

/// Surface points of a part in its frame less its center, and the spheres around them.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Body {
    points: Vec<Vec3>,
    spheres: Vec<Sphere>,
    /// Surface that each point stands for, mm2.
    pub(crate) point_area: f32,
}

impl Body {
    /// About `wanted` points: first along sharp edges, where parts meet, then spread over the faces.
    pub(crate) fn new(mesh: &Mesh, center: DVec3, wanted: usize) -> Self {
        let area = surface(mesh);
        let sharp = sharp_edges(mesh);
        let mut spacing = (area / (0.7 * wanted as f64)).sqrt().max(1e-3);
        let mut points = spread(mesh, &sharp, spacing);
        for _ in 0..8 {
            if points.len() <= wanted + wanted / 2 {
                break;
            }
            spacing *= 1.3;
            points = spread(mesh, &sharp, spacing);
        }
        let mut points: Vec<Vec3> = points.into_iter().map(|p| (p - center).as_vec3()).collect();
        let mut spheres = Vec::with_capacity(points.len());
        let count = points.len();
        build(&mut points, 0, count, &mut spheres);
        Self { point_area: (area / points.len() as f64) as f32, points, spheres }
    }

    /// As bytes.
    pub(super) fn pack(&self, to: &mut Packer) {
        to.f32s(&[self.point_area]);
        to.u32(self.points.len() as u32);
        self.points.iter().for_each(|p| to.f32s(&p.to_array()));
        to.u32(self.spheres.len() as u32);
        for sphere in &self.spheres {
            to.f32s(&sphere.center.to_array());
            to.f32s(&[sphere.radius]);
            [sphere.skip, sphere.first, sphere.count].into_iter().for_each(|n| to.u32(n));
        }
    }

    /// From bytes; `None` where a walk would not end or would leave the points.
    pub(super) fn unpack(from: &mut Unpacker<'_>) -> Option<Self> {
        let [point_area] = from.f32s()?;
        let count = from.u32()?;
        let points: Vec<Vec3> = (0..count).map(|_| from.f32s().map(Vec3::from_array)).collect::<Option<_>>()?;
        let count = from.u32()?;
        let sphere = |at: u32, from: &mut Unpacker<'_>| {
            let (center, [radius]) = (Vec3::from_array(from.f32s()?), from.f32s()?);
            let [skip, first, own] = [from.u32()?, from.u32()?, from.u32()?];
            let is_sound = skip > at && skip <= count && first.checked_add(own)? as usize <= points.len();
            is_sound.then_some(Sphere { center, radius, skip, first, count: own })
        };
        let spheres = (0..count).map(|at| sphere(at, from)).collect::<Option<Vec<Sphere>>>()?;
        (!points.is_empty()).then_some(Self { points, spheres, point_area })
    }

    /// All points.
    pub(crate) fn points(&self) -> &[Vec3] {
        &self.points
    }

    /// Calls `visit` with every point that lies in spheres which `wanted` lets pass.
    #[inline]
    pub(crate) fn walk(&self, mut wanted: impl FnMut(Vec3, f32) -> bool, mut visit: impl FnMut(Vec3)) {
        let mut at = 0;
        while let Some(sphere) = self.spheres.get(at) {
            if !wanted(sphere.center, sphere.radius) {
                at = sphere.skip as usize;
                continue;
            }
            let first = sphere.first as usize;
            self.points[first..first + sphere.count as usize].iter().for_each(|&p| visit(p));
            at += 1;
        }
    }
}

fn surface(mesh: &Mesh) -> f64 {
    (0..mesh.triangles().len()).map(|t| triangle_area(mesh.corners(t))).sum()
}

fn triangle_area([a, b, c]: [DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

/// Edges whose two faces meet at more than about 30 degrees.
fn sharp_edges(mesh: &Mesh) -> Vec<[DVec3; 2]> {
    let mut edges: Vec<(u32, u32, usize)> = (mesh.triangles().iter().enumerate())
        .flat_map(|(t, &[a, b, c])| [(a, b), (b, c), (c, a)].map(|(a, b)| (a.min(b), a.max(b), t)))
        .collect();
    edges.sort_unstable();
    let normal = |t: usize| {
        let [a, b, c] = mesh.corners(t);
        (b - a).cross(c - a).normalize_or(DVec3::ZERO)
    };
    let place = |v: u32| mesh.vertices()[v as usize];
    (edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)))
        .filter(|edge| edge.len() != 2 || normal(edge[0].2).dot(normal(edge[1].2)) < 0.86)
        .map(|edge| [place(edge[0].0), place(edge[0].1)])
        .collect()
}

/// Points no closer to each other than `spacing`, by throwing darts: edges first, faces after.
fn spread(mesh: &Mesh, sharp: &[[DVec3; 2]], spacing: f64) -> Vec<DVec3> {
    let mut darts = Darts { spacing, cells: HashMap::new(), points: Vec::new() };
    for &[a, b] in sharp {
        darts.throw(a);
        darts.throw(b);
    }
    for &[a, b] in sharp {
        let steps = (a.distance(b) / spacing).floor() as usize;
        (1..steps).for_each(|k| darts.throw(a.lerp(b, k as f64 / steps as f64)));
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
            darts.throw(corners[0] + (corners[1] - corners[0]) * u + (corners[2] - corners[0]) * v);
        }
    }
    darts.points
}

struct Darts {
    spacing: f64,
    cells: HashMap<[i32; 3], Vec<u32>>,
    points: Vec<DVec3>,
}

impl Darts {
    fn throw(&mut self, point: DVec3) {
        let [x, y, z] = (point / self.spacing).floor().to_array().map(|v| v as i32);
        for dx in -1..=1 {
            for dy in -1..=1 {
                for dz in -1..=1 {
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

/// Sorts a range of points into spheres, depth first; returns nothing but fills `spheres`.
fn build(points: &mut [Vec3], first: usize, count: usize, spheres: &mut Vec<Sphere>) {
    let range = &mut points[first..first + count];
    let (min, max) = range.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), &p| (l.min(p), h.max(p)));
    let center = (min + max) * 0.5;
    let radius = range.iter().map(|p| p.distance(center)).fold(0.0, f32::max);
    let at = spheres.len();
    let leaf = count <= LEAF;
    let own = if leaf { count as u32 } else { 0 };
    spheres.push(Sphere { center, radius, skip: 0, first: first as u32, count: own });
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
        build(points, first, half, spheres);
        build(points, first + half, count - half, spheres);
    }
    spheres[at].skip = spheres.len() as u32;
}
