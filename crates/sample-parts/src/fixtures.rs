//! Solids and pairs of solids for tests and benches.

use std::{collections::HashMap, sync::Arc};

use glam::{DQuat, DVec3};
use rand_chacha::{ChaCha8Rng, rand_core::Rng};

use solids::{ClearanceTree, Mesh, Pose};

/// Adds the corners and faces of a box, counter-clockwise seen from outside.
fn add_box(min: DVec3, max: DVec3, vertices: &mut Vec<DVec3>, triangles: &mut Vec<[u32; 3]>, inwards: bool) {
    let base = vertices.len() as u32;
    vertices.extend((0..8).map(|i| {
        let pick = |bit: u32, low: f64, high: f64| if i >> bit & 1 == 1 { high } else { low };
        DVec3::new(pick(0, min.x, max.x), pick(1, min.y, max.y), pick(2, min.z, max.z))
    }));
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    for [a, b, c, d] in faces {
        for [a, b, c] in [[a, b, c], [a, c, d]] {
            triangles.push(if inwards { [base + a, base + c, base + b] } else { [base + a, base + b, base + c] });
        }
    }
}

/// A box between two corners.
pub fn cuboid(min: DVec3, max: DVec3) -> Arc<Mesh> {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    add_box(min, max, &mut vertices, &mut triangles, false);
    Arc::new(Mesh::new(vertices, triangles).expect("a box is a solid"))
}

/// A box of the given edges with its least corner at the origin.
pub fn block(x: f64, y: f64, z: f64) -> Arc<Mesh> {
    cuboid(DVec3::ZERO, DVec3::new(x, y, z))
}

/// A box with a sealed box-shaped cavity, walls of `wall` mm.
pub fn hollow_box(size: f64, wall: f64) -> Arc<Mesh> {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    add_box(DVec3::ZERO, DVec3::splat(size), &mut vertices, &mut triangles, false);
    add_box(DVec3::splat(wall), DVec3::splat(size - wall), &mut vertices, &mut triangles, true);
    Arc::new(Mesh::new(vertices, triangles).expect("a hollow box is a solid"))
}

/// A box open at the top: a bucket with walls of `wall` mm.
pub fn bucket(size: f64, wall: f64) -> Arc<Mesh> {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    add_box(DVec3::ZERO, DVec3::splat(size), &mut vertices, &mut triangles, false);
    let (low, high) = (DVec3::splat(wall), DVec3::new(size - wall, size - wall, size));
    add_box(low, high, &mut vertices, &mut triangles, true);
    // The two tops (face 4, 5, 7, 6 of each box) are replaced by a rim between them.
    let on_top = |t: &[u32; 3]| t.iter().all(|&v| vertices[v as usize].z == size);
    triangles.retain(|t| !on_top(t));
    for (a, b) in [(4, 5), (5, 7), (7, 6), (6, 4)] {
        triangles.push([a, b, b + 8]);
        triangles.push([a, b + 8, a + 8]);
    }
    Arc::new(Mesh::new(vertices, triangles).expect("a bucket is a solid"))
}

/// A sphere-like solid of 20 x 4^level triangles; `radius_mm` gives the radius in each direction.
pub fn star(level: u32, radius_mm: impl Fn(DVec3) -> f64) -> Arc<Mesh> {
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    let mut vertices: Vec<DVec3> = Vec::new();
    for (a, b) in [(1.0, golden), (-1.0, golden), (1.0, -golden), (-1.0, -golden)] {
        vertices.extend([DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)]);
    }
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    let near = |i: usize, j: usize| (vertices[i].distance(vertices[j]) - 2.0).abs() < 1e-9;
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if near(i, j) && near(j, k) && near(i, k) {
                    let out = (vertices[j] - vertices[i]).cross(vertices[k] - vertices[i]).dot(vertices[i]) > 0.0;
                    let corners = if out { [i, j, k] } else { [i, k, j] };
                    triangles.push(corners.map(|v| v as u32));
                }
            }
        }
    }
    for _ in 0..level {
        let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                vertices.push((vertices[a as usize] + vertices[b as usize]) * 0.5);
                vertices.len() as u32 - 1
            })
        };
        let split = |[a, b, c]: [u32; 3]| {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(split).collect();
    }
    let placed = vertices.into_iter().map(|v| v.normalize() * radius_mm(v.normalize())).collect();
    Arc::new(Mesh::new(placed, triangles).expect("a star is a solid"))
}

/// A solid from the shared data, or `None` with a message on stderr when `NESTD_DATA` is not set.
#[allow(clippy::print_stderr)]
pub fn mesh_from_data(file: &str) -> Option<Arc<Mesh>> {
    let Ok(folder) = std::env::var("NESTD_DATA") else {
        eprintln!("skipped: NESTD_DATA is not set");
        return None;
    };
    let mut source = std::fs::File::open(std::path::Path::new(&folder).join(file)).expect("the file is there");
    let soup = stl_io::read_stl(&mut source).expect("is an STL file");
    let vertices = soup.vertices.iter().map(|v| DVec3::new(v[0].into(), v[1].into(), v[2].into())).collect();
    let triangles = soup.faces.iter().map(|f| f.vertices.map(|v| v as u32)).collect();
    Some(Arc::new(Mesh::new(vertices, triangles).expect("is a solid")))
}

/// A uniform number in [-1, 1].
pub fn unit(rng: &mut ChaCha8Rng) -> f64 {
    f64::from(rng.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0
}

fn direction(rng: &mut ChaCha8Rng) -> DVec3 {
    DVec3::new(unit(rng), unit(rng), unit(rng)).normalize_or(DVec3::X)
}

/// A random rotation, moved along a random direction until the distance is at most 0.05 mm more than `gap_mm`.
pub fn tight_pose(one: &ClearanceTree, two: &ClearanceTree, gap_mm: f64, rng: &mut ChaCha8Rng) -> Pose {
    let (axis, angle, way) = (direction(rng), unit(rng) * 3.0, direction(rng));
    let rotation = DQuat::from_axis_angle(axis, angle);
    let (center1, center2) = (one.mesh().bounds().center(), rotation * two.mesh().bounds().center());
    let at = |far: f64| Pose::new(rotation, center1 - center2 + way * far);
    let (mut near, mut far) = (0.0, 1000.0);
    while far - near > 0.05 {
        let middle = 0.5 * (near + far);
        if one.is_closer_than(two, &at(middle), gap_mm) {
            near = middle;
        } else {
            far = middle;
        }
    }
    at(far)
}
