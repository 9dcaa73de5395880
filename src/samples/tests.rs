//! Every sample is a clean solid of the size that it says.

use glam::DVec3;

use super::*;

#[test]
fn every_sample_is_a_closed_solid_without_collapsed_triangles() {
    for sample in all() {
        let (name, defects) = (sample.name, sample.mesh.defects());
        assert!(defects.is_closed() && !defects.inverted && defects.degenerate_triangles == 0, "{name}: {defects:?}");
        let triangles = sample.mesh.triangles().len();
        assert!((500..=20_000).contains(&triangles), "{name} has {triangles} triangles");
    }
}

#[test]
fn a_box_and_a_ring_have_their_volumes() {
    let size = DVec3::new(10.0, 20.0, 30.0);
    let mesh = cuboid(size);
    assert!((mesh.volume_mm3() - 6000.0).abs() < 1e-9 && mesh.bounds().size() == size && mesh.triangles().len() == 12);
    let exact = std::f64::consts::PI * (20.0f64.powi(2) - 14.0f64.powi(2)) * 8.0;
    assert!((ring(40.0, 28.0, 8.0).volume_mm3() / exact - 1.0).abs() < 2e-3);
}
