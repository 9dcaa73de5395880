//! Meshes of the samples are broken by code and mended: the closed original is known, so what comes out can be judged.

use std::collections::{BTreeMap, HashMap};

use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use solids::{MendError, Mesh, closest_point};

use crate::{all_samples, fixtures};

type Soup = (Vec<DVec3>, Vec<[u32; 3]>);

/// A mended mesh is wrong if its volume is off by more than this share, or a mended place by more than this share of the diagonal.
const VOLUME_SHARE: f64 = 0.005;
const DEVIATION_SHARE: f64 = 0.01;

/// A way to break a mesh.
type Breaker = fn(&mut Soup, &mut ChaCha8Rng);

const BREAKERS: [(&str, Breaker); 14] = [
    ("one triangle lost", |soup, rng| lose_patches(soup, rng, 1, 0)),
    ("five triangles lost", |soup, rng| lose_patches(soup, rng, 5, 0)),
    ("what is around a corner lost", |soup, rng| lose_patches(soup, rng, 1, 1)),
    ("three larger holes", |soup, rng| lose_patches(soup, rng, 3, 2)),
    ("some triangles turned", |(_, triangles), rng| turn(triangles, rng, 0.05)),
    ("a third of them turned", |(_, triangles), rng| turn(triangles, rng, 0.33)),
    ("triangles doubled", |(_, triangles), rng| double(triangles, rng, false)),
    ("triangles doubled and turned", |(_, triangles), rng| double(triangles, rng, true)),
    ("corners torn off", tear_corners),
    ("each triangle by itself, rounded", |soup, rng| round_apart(soup, rng, 0.004)),
    ("corners on one side of an edge only", split_edges),
    ("triangles hanging on", hang_on),
    ("lost, turned and doubled", |soup, rng| {
        lose_patches(soup, rng, 2, 0);
        turn(&mut soup.1, rng, 0.03);
        double(&mut soup.1, rng, false);
    }),
    ("a third cut off", cut_off),
];

/// Takes patches away: triangles, and those around them `rings` times.
fn lose_patches((_, triangles): &mut Soup, rng: &mut ChaCha8Rng, count: usize, rings: usize) {
    for _ in 0..count {
        let mut corners = triangles[rng.random_range(0..triangles.len())].to_vec();
        if rings == 0 {
            let gone = [corners[0], corners[1], corners[2]];
            triangles.retain(|t| *t != gone);
            continue;
        }
        corners.truncate(1);
        for _ in 1..rings {
            let around = triangles.iter().filter(|t| t.iter().any(|corner| corners.contains(corner)));
            corners = around.flatten().copied().collect();
            corners.sort_unstable();
            corners.dedup();
        }
        triangles.retain(|t| !t.iter().any(|corner| corners.contains(corner)));
    }
}

fn turn(triangles: &mut [[u32; 3]], rng: &mut ChaCha8Rng, share: f64) {
    let at = rng.random_range(0..triangles.len());
    triangles[at].swap(0, 1);
    triangles.iter_mut().filter(|_| rng.random_bool(share)).for_each(|t| t.swap(0, 1));
}

fn double(triangles: &mut Vec<[u32; 3]>, rng: &mut ChaCha8Rng, is_turned: bool) {
    for _ in 0..6 {
        let [a, b, c] = triangles[rng.random_range(0..triangles.len())];
        triangles.push(if is_turned { [b, a, c] } else { [b, c, a] });
    }
}

fn tear_corners((vertices, triangles): &mut Soup, rng: &mut ChaCha8Rng) {
    for _ in 0..6 {
        let at = rng.random_range(0..triangles.len());
        let place = vertices[triangles[at][1] as usize];
        vertices.push(place + DVec3::new(0.004, -0.003, 0.005));
        triangles[at][1] = vertices.len() as u32 - 1;
    }
}

fn round_apart((vertices, triangles): &mut Soup, rng: &mut ChaCha8Rng, by: f64) {
    let mut apart = Vec::new();
    for corner in triangles.iter_mut().flatten() {
        let mut noise = || rng.random_range(-by..by);
        apart.push(vertices[*corner as usize] + DVec3::new(noise(), noise(), noise()));
        *corner = apart.len() as u32 - 1;
    }
    *vertices = apart;
}

fn split_edges((vertices, triangles): &mut Soup, rng: &mut ChaCha8Rng) {
    for _ in 0..5 {
        let at = rng.random_range(0..triangles.len());
        let [a, b, c] = triangles[at];
        vertices.push(vertices[a as usize].lerp(vertices[b as usize], 0.4));
        let middle = vertices.len() as u32 - 1;
        triangles[at] = [a, middle, c];
        triangles.push([middle, b, c]);
    }
}

fn hang_on((vertices, triangles): &mut Soup, rng: &mut ChaCha8Rng) {
    for _ in 0..3 {
        let [a, b, c] = triangles[rng.random_range(0..triangles.len())];
        let [pa, pb, pc] = [a, b, c].map(|corner| vertices[corner as usize]);
        vertices.push(pa + (pb - pa).cross(pc - pa).normalize_or_zero() * 0.5);
        triangles.push([a, b, vertices.len() as u32 - 1]);
    }
}

fn cut_off((vertices, triangles): &mut Soup, _: &mut ChaCha8Rng) {
    let (low, high) = vertices.iter().fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v.x), high.max(v.x)));
    let plane = low + 0.67 * (high - low);
    triangles.retain(|t| t.iter().any(|&corner| vertices[corner as usize].x < plane));
}

/// The farthest that a mended place lies from the original, mm.
fn deviation(original: &Mesh, mended: &[[DVec3; 3]]) -> f64 {
    let count = original.triangles().len();
    let distance = |point: DVec3| {
        let to = (0..count).map(|t| closest_point(point, &original.corners(t)).distance_squared(point));
        to.fold(f64::INFINITY, f64::min).sqrt()
    };
    let step = (mended.len() / 60).max(1);
    mended.iter().step_by(step).map(|[a, b, c]| distance((*a + *b + *c) / 3.0)).fold(0.0, f64::max)
}

#[test]
#[allow(clippy::print_stdout)] // its figures stand in the book
fn of_hundreds_of_broken_meshes_none_is_mended_wrongly() {
    let mut table: BTreeMap<usize, (u32, u32, f64, f64)> = BTreeMap::new();
    let mut reasons: HashMap<String, u32> = HashMap::new();
    let (mut made, mut mended, mut wrong, mut made_of) = (0, 0, Vec::new(), [0_u64; BREAKERS.len()]);
    for sample in all_samples() {
        if sample.mesh.triangles().len() > 40_000 {
            continue;
        }
        for (at, (name, break_it)) in BREAKERS.iter().enumerate().chain(BREAKERS.iter().enumerate()) {
            made_of[at] += 1;
            let mut rng = ChaCha8Rng::seed_from_u64(at as u64 + 1000 * (made_of[at] % 2));
            let original = &sample.mesh;
            let mut soup: Soup = (original.vertices().to_vec(), original.triangles().to_vec());
            break_it(&mut soup, &mut rng);
            let broken = Mesh::new(soup.0, soup.1).expect("has a volume");
            if broken.defects().is_closed() {
                continue;
            }
            made += 1;
            let row = table.entry(at).or_default();
            match broken.mended() {
                Err(why) => {
                    row.1 += 1;
                    *reasons.entry(format!("{name}: {}", kind(&why))).or_default() += 1;
                }
                Ok(done) => {
                    mended += 1;
                    assert!(done.mesh.defects().is_closed());
                    let off = (done.mesh.volume_mm3() / original.volume_mm3() - 1.0).abs();
                    let far = deviation(original, &done.mended);
                    (row.0, row.2, row.3) = (row.0 + 1, row.2.max(off), row.3.max(far));
                    let diagonal = original.bounds().size().length();
                    if off > VOLUME_SHARE || far > DEVIATION_SHARE * diagonal {
                        wrong.push(format!(
                            "{} {name}: volume off by {off:.4}, {far:.3} of {diagonal:.0} mm, {:?}",
                            sample.name, done.measures
                        ));
                    }
                }
            }
        }
    }
    println!("{made} made, {mended} mended, {} refused, {} wrong", made - mended, wrong.len());
    for (at, (mended, refused, off, far)) in &table {
        println!(
            "{:40} {mended:3} mended {refused:3} refused, volume {:.4} %, {far:.3} mm",
            BREAKERS[*at].0,
            off * 100.0
        );
    }
    println!("{reasons:#?}");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(made >= 200 && mended * 10 >= made * 7, "{mended} of {made} are mended");
}

fn kind(why: &MendError) -> String {
    format!("{why:?}").split('(').next().unwrap_or_default().to_owned()
}

#[test]
fn each_triangle_of_a_block_that_is_lost_comes_back() {
    let block = crate::cuboid(DVec3::new(10.0, 8.0, 6.0));
    for lost in 0..12 {
        let mut triangles = block.triangles().to_vec();
        triangles.remove(lost);
        let done =
            Mesh::new(block.vertices().to_vec(), triangles).unwrap().mended().expect("it is known what was there");
        assert!((done.mesh.volume_mm3() - 480.0).abs() < 1e-9);
    }
}

#[test]
fn what_is_ambiguous_is_refused() {
    let broken =
        |vertices: &[DVec3], triangles: Vec<[u32; 3]>| Mesh::new(vertices.to_vec(), triangles).unwrap().mended();
    let block = fixtures::block(10.0, 20.0, 30.0);
    let is_top = |t: &&[u32; 3]| t.iter().all(|&corner| block.vertices()[corner as usize].z == 30.0);
    let open: Vec<[u32; 3]> = block.triangles().iter().filter(|t| !is_top(t)).copied().collect();
    assert!(
        matches!(broken(block.vertices(), open), Err(MendError::LargeHole(_) | MendError::Opening(_))),
        "an open box"
    );
    let tube = crate::ring(40.0, 28.0, 8.0);
    let in_wall: Vec<[u32; 3]> = (tube.triangles().iter())
        .filter(|t| t.iter().any(|&corner| tube.vertices()[corner as usize].z > 0.01))
        .copied()
        .collect();
    assert!(broken(tube.vertices(), in_wall).is_err(), "the wall of a ring without its bottom");
    assert!(matches!(block.mended(), Err(MendError::Closed)));
}

#[test]
fn a_cavity_of_which_a_triangle_is_lost_stays_a_cavity_and_the_mesh_is_mended_the_same_each_time() {
    let hollow = fixtures::hollow_box(20.0, 4.0);
    // The last triangles are those of the cavity.
    let mut triangles = hollow.triangles().to_vec();
    triangles.pop();
    let broken = Mesh::new(hollow.vertices().to_vec(), triangles).unwrap();
    let done = broken.mended().expect("one triangle of a flat face");
    assert!((done.mesh.volume_mm3() - hollow.volume_mm3()).abs() < 1e-6);
    assert_eq!((done.measures.holes, done.measures.added, done.measures.turned), (1, 1, 0));
    let again = broken.mended().unwrap();
    assert_eq!((done.mesh.vertices(), done.mesh.triangles()), (again.mesh.vertices(), again.mesh.triangles()));
}
