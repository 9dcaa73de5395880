//! Tests that every sample is a clean solid of the stated size.

use std::{collections::HashSet, f64::consts::PI};

use glam::DVec3;
use sha2::{Digest, Sha256};

use super::*;

/// Whether the surface is connected: every triangle is reachable from the first one over shared vertices.
fn is_one_shell(mesh: &Mesh) -> bool {
    let mut group: Vec<usize> = (0..mesh.vertices().len()).collect();
    fn root(group: &mut [usize], mut v: usize) -> usize {
        while group[v] != v {
            group[v] = group[group[v]];
            v = group[v];
        }
        v
    }
    for &[a, b, c] in mesh.triangles() {
        for (x, y) in [(a, b), (b, c)] {
            let (x, y) = (root(&mut group, x as usize), root(&mut group, y as usize));
            group[x] = y;
        }
    }
    let roots: HashSet<usize> = (0..group.len()).map(|v| root(&mut group, v)).collect();
    roots.len() == 1
}

fn least_area_mm2(mesh: &Mesh) -> f64 {
    let area = |t| {
        let [a, b, c] = mesh.corners(t);
        (b - a).cross(c - a).length() / 2.0
    };
    (0..mesh.triangles().len()).map(area).fold(f64::INFINITY, f64::min)
}

/// The winding number of the surface about a point: 1 inside, 0 outside, more where it overlaps itself.
fn winding(mesh: &Mesh, point: DVec3) -> f64 {
    let solid_angle = |t: usize| {
        let [a, b, c] = mesh.corners(t).map(|corner| (corner - point).normalize());
        2.0 * a.dot(b.cross(c)).atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
    };
    (0..mesh.triangles().len()).map(solid_angle).sum::<f64>() / (4.0 * PI)
}

/// Tests both sides of `n` triangles spread over the surface.
fn assert_does_not_overlap_itself(name: &str, mesh: &Mesh, n: usize) {
    let count = mesh.triangles().len();
    for t in (0..n).map(|i| i * count / n) {
        let [a, b, c] = mesh.corners(t);
        let (middle, normal) = ((a + b + c) / 3.0, (b - a).cross(c - a).normalize());
        for (side, expected) in [(1.0, 0.0), (-1.0, 1.0)] {
            let found = winding(mesh, middle + side * 1e-4 * normal);
            assert!((found - expected).abs() < 1e-3, "{name} winds {found} times around a point at {middle}");
        }
    }
}

fn assert_clean(name: &str, mesh: &Mesh) {
    let defects = mesh.defects();
    assert!(defects.is_closed() && !defects.inverted && defects.degenerate_triangles == 0, "{name}: {defects:?}");
    assert!(is_one_shell(mesh), "{name} is not one shell");
    assert!(least_area_mm2(mesh) > 1e-6, "{name} has a triangle of {} mm2", least_area_mm2(mesh));
}

fn assert_near(name: &str, mesh: &Mesh, exact_mm3: f64, tolerance: f64) {
    let share = mesh.volume_mm3() / exact_mm3;
    assert!((share - 1.0).abs() < tolerance, "{name}: {} mm3, expected {exact_mm3}", mesh.volume_mm3());
}

#[test]
fn every_sample_is_one_closed_shell_without_collapsed_triangles() {
    for sample in all_samples() {
        assert_clean(sample.name, &sample.mesh);
        let triangles = sample.mesh.triangles().len();
        assert!((500..=20_000).contains(&triangles), "{} has {triangles} triangles", sample.name);
    }
}

#[test]
fn every_random_part_is_one_closed_shell_and_no_two_are_alike() {
    let mut volumes = HashSet::new();
    for seed in 0..400 {
        let mesh = random_part(seed);
        assert_clean(&format!("random part {seed}"), &mesh);
        let size = mesh.bounds().size();
        assert!(size.max_element() < 120.0 && size.min_element() > 0.5, "random part {seed} measures {size} mm");
        assert!(volumes.insert(mesh.volume_mm3().to_bits()), "random part {seed} was there before");
    }
}

#[test]
fn no_sample_overlaps_itself() {
    for sample in all_samples() {
        assert_does_not_overlap_itself(sample.name, &sample.mesh, 60);
    }
    for (i, (mesh, _)) in workload_parts(SampleWorkload::EngineLike).iter().enumerate() {
        assert_does_not_overlap_itself(&format!("engine-like part {i}"), mesh, 30);
    }
    for seed in 0..200 {
        assert_does_not_overlap_itself(&format!("random part {seed}"), &random_part(seed), 30);
    }
}

#[test]
fn there_are_at_least_fourteen_kinds_with_names_of_their_own() {
    let names: HashSet<&str> = all_samples().iter().map(|s| s.name).collect();
    assert!(names.len() >= 14 && names.len() == all_samples().len());
    assert!(names.iter().all(|n| n.chars().all(|c| c.is_ascii_lowercase() || c == '_')));
}

#[test]
fn the_same_call_gives_the_same_mesh() {
    for (first, second) in all_samples().iter().zip(all_samples()) {
        assert_eq!(first.mesh.vertices(), second.mesh.vertices(), "{}", first.name);
        assert_eq!(first.mesh.triangles(), second.mesh.triangles(), "{}", first.name);
    }
    assert_eq!(random_part(7).vertices(), random_part(7).vertices());
}

#[test]
fn crisp_parts_have_their_volumes() {
    let size = DVec3::new(10.0, 20.0, 30.0);
    let mesh = cuboid(size);
    assert_near("cuboid", &mesh, 6000.0, 1e-12);
    assert!(mesh.bounds().size() == size && mesh.triangles().len() == 12);
    assert_near("ring", &ring(40.0, 28.0, 8.0), PI * (400.0 - 196.0) * 8.0, 2e-3);
    // A pipe's volume is its cross section times the length of its center line.
    let path_mm = 32.0 * PI / 2.0 + 2.0 * 18.0;
    assert_near("duct", &duct(30.0, 2.5, 32.0, 90.0, 18.0), PI * (225.0 - 156.25) * path_mm, 1e-2);
    // The wire has 16 sides.
    let (path_mm, section) = (5.0 * (24.0 * PI).hypot(9.0), 8.0 * 4.0 * (PI / 8.0).sin());
    assert_near("spring", &spring(24.0, 4.0, 9.0, 5.0), section * path_mm, 2e-2);
    // Two angles of 36 x 3.5 and 40 x 3.5 over the width, and four concave ribs.
    let rib = 28.5f64.powi(2) * (1.0 - PI / 4.0);
    let exact = (76.5 * 3.5) * 36.0 + 4.0 * rib * 3.5;
    assert_near("ribbed_bracket", &ribbed_bracket(40.0, 36.0, 3.5, 4), exact, 1e-2);
    // Struts along each axis, crossings counted once: 4 x 4 of 32.5 mm three times, less 2 x 64 cubes.
    let exact = 3.0 * 16.0 * 32.5 * 6.25 - 2.0 * 64.0 * 2.5f64.powi(3);
    assert_near("lattice_block", &lattice_block([3, 3, 3], 10.0, 2.5), exact, 1e-9);
    // A plate less 56 hexagons.
    let hexagon = 3.0f64.sqrt() / 2.0 * 6.4f64.powi(2);
    let plate = honeycomb(8, 7, 8.0, 1.6, 6.0);
    let area = plate.bounds().size().truncate().element_product() - 56.0 * hexagon;
    assert_near("honeycomb", &plate, area * 6.0, 1e-9);
}

#[test]
fn modelled_parts_come_near_their_volumes() {
    let ball_mm3 = 4.0 / 3.0 * PI * 18.0f64.powi(3);
    // A gyroid sheet of thickness t has about 3.09 t / period of its space.
    assert_near("gyroid_ball", &gyroid_ball(36.0, 18.0, 3.2), ball_mm3 * 3.09 * 3.2 / 18.0, 0.1);
    let tee = pipe_tee(56.0, 32.0, 24.0, 3.5);
    let section = PI * (144.0 - 8.5f64.powi(2));
    // The branch begins at the run's wall, somewhere between its flank and its crest.
    assert!(tee.volume_mm3() > section * (56.0 + 18.0) && tee.volume_mm3() < section * (56.0 + 26.0));
}

#[test]
fn wheels_and_windows_have_their_sizes_and_do_not_overlap_themselves() {
    for (name, mesh, size) in [
        ("wheel", wheel(212.0, 25.0, 14.0, 5), DVec3::new(212.0, 212.0, 25.0)),
        ("window", frame(200.0, 180.0, 14.0, 22.0, 2), DVec3::new(200.0, 180.0, 22.0)),
    ] {
        assert_clean(name, &mesh);
        assert_does_not_overlap_itself(name, &mesh, 60);
        assert!((mesh.bounds().size() - size).abs().max_element() < 1e-9, "{name} measures {}", mesh.bounds().size());
    }
    // Two panes of 79 x 152 mm.
    assert_near("window", &frame(200.0, 180.0, 14.0, 22.0, 2), (200.0 * 180.0 - 2.0 * 79.0 * 152.0) * 22.0, 1e-9);
}

#[test]
fn the_fan_fills_its_frame_exactly() {
    let fan = axial_fan(65.0, 22.0, 7);
    let size = fan.bounds().size();
    assert!((size - DVec3::new(65.0, 65.0, 22.0)).abs().max_element() < 1e-9, "{size}");
}

#[test]
fn workloads_hold_the_copies_and_the_meshes_that_they_promise() {
    let copies = |w| workload_parts(w).iter().map(|(_, copies)| copies).sum::<u32>();
    assert_eq!((copies(SampleWorkload::Fans), copies(SampleWorkload::EngineLike)), (20, 30));
    let engine = workload_parts(SampleWorkload::EngineLike);
    assert!(engine.iter().all(|(mesh, _)| mesh.defects().is_closed() && mesh.bounds().size().max_element() < 120.0));
    let different: HashSet<u64> = engine.iter().map(|(mesh, _)| mesh.volume_mm3().to_bits()).collect();
    assert_eq!(different.len(), 30);
    let small = SampleWorkload::Small { copies: 100, meshes: 30, seed: 5 };
    assert_eq!((workload_parts(small).len(), copies(small)), (30, 100));
    let organic = SampleWorkload::Organic { copies: 9, meshes: 4, seed: 5 };
    assert_eq!((workload_parts(organic).len(), copies(organic)), (4, 9));
    assert_eq!((copies(SampleWorkload::Cages), copies(SampleWorkload::Tall)), (42, 48));
    assert_eq!((copies(SampleWorkload::Wheels { wheels: 6 }), copies(SampleWorkload::Windows)), (21, 30));
    assert_eq!(copies(SampleWorkload::Twins { each: 7 }), 14);
}

#[test]
fn figures_and_cages_are_closed_and_as_large_as_promised() {
    for seed in 0..4 {
        let mesh = random_figure(seed);
        let longest = mesh.bounds().size().max_element();
        assert!(mesh.defects().is_closed() && mesh.volume_mm3() > 1000.0, "figure {seed}");
        assert!((25.0..140.0).contains(&longest), "figure {seed} measures {longest} mm");
        assert_does_not_overlap_itself(&format!("figure {seed}"), &mesh, 30);
    }
    assert_eq!(random_figure(3).vertices(), random_figure(3).vertices());
    for workload in [SampleWorkload::Cages, SampleWorkload::Tall, SampleWorkload::Windows] {
        for (at, (mesh, _)) in workload_parts(workload).iter().enumerate() {
            let size = mesh.bounds().size();
            assert!(mesh.defects().is_closed() && size.max_element() <= 205.0, "{workload:?} {at} measures {size} mm");
        }
    }
}

#[test]
fn a_written_workload_holds_the_copies_and_triangles_that_the_bench_packs() {
    let hex = |bytes: &[u8]| Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect::<String>();
    let mut sums = String::new();
    for workload in &COMPARED_WORKLOADS {
        assert_eq!(ComparedWorkload::named(workload.name), Some(workload));
        let files = workload.files();
        sums.extend(files.iter().map(|file| format!("{}  {}\n", hex(&file.bytes), file.path)));
        let bytes = |path: &str| files.iter().find(|file| file.path == path).map(|file| file.bytes.clone()).unwrap();
        let text = |path: &str| String::from_utf8(bytes(path)).unwrap();
        let list = text(&format!("workloads/{}.csv", workload.name));
        let rows: Vec<(&str, u32)> =
            list.lines().skip(1).filter_map(|row| row.split_once(',')).map(|(f, n)| (f, n.parse().unwrap())).collect();
        let parts = workload_parts(workload.parts);
        assert!(list.starts_with("file,quantity\n") && rows.len() == parts.len() && files.len() == parts.len() + 2);
        for ((file, quantity), (mesh, copies)) in rows.iter().zip(&parts) {
            let mut source = std::io::Cursor::new(bytes(file));
            let facets = stl_io::create_stl_reader(&mut source).unwrap();
            let written: Vec<[[f32; 3]; 3]> = facets.map(|facet| facet.unwrap().vertices.map(|v| v.0)).collect();
            let corners = |t| mesh.corners(t).map(|corner| corner.as_vec3().to_array());
            let packed: Vec<[[f32; 3]; 3]> = (0..mesh.triangles().len()).map(corners).collect();
            assert!(quantity == copies && written == packed, "{file}");
            assert!(packed.iter().all(|[a, b, c]| a != b && b != c && c != a), "{file}: a triangle lost its area");
        }
        let [length_mm, width_mm] = workload.base_mm;
        let beside = text(&format!("workloads/{}.json", workload.name));
        assert!(beside.contains(&format!("\"volume_mm\": [{length_mm}, {width_mm}, 600]")), "{beside}");
        assert!(beside.contains(&format!("\"clearance_mm\": {}}}", workload.clearance_mm)), "{beside}");
    }
    // Results of others refer to these parts.
    let page = include_str!("../../../benches/packing/README.md");
    assert!(page.contains(&format!("SHA-256 of SHA256SUMS: {}\n", hex(sums.as_bytes()))), "{}", hex(sums.as_bytes()));
}
