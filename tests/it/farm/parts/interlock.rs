//! Parts that fit together only as links of a chain.

use glam::DVec3;
use ledger::PartState;
use solids::Mesh;

use crate::support::TestFarm;

/// A machine in which a flat ring and a ring on edge fit together only when they are linked.
const NARROW: &str = "volume_mm = [32, 22, 22]\nclearance_mm = 1.0\norientation = \"fixed\"\nsettle_secs = 0.3\n\
                      unfinished_secs = 2\nfinal_secs = 2\narrival_secs = 2\n";

fn drop_rings(farm: &TestFarm) {
    let flat = sample_parts::ring(21.0, 15.0, 3.0);
    let turned = |v: &DVec3| DVec3::new(v.x, -v.z, v.y);
    let on_edge = Mesh::new(flat.vertices().iter().map(turned).collect(), flat.triangles().to_vec()).unwrap();
    // The ring on edge is placed first; the flat one then fits only as a link around it.
    farm.drop_part("a_on_edge.stl", &on_edge);
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.drop_part("b_flat.stl", &flat);
}

#[test]
fn links_of_a_chain_are_built_apart() {
    let farm = TestFarm::running(NARROW);
    drop_rings(&farm);
    // The second ring does not fit into the build of the first, which fires; the second is flushed.
    farm.wait_for_queued(1);
    farm.flush();
    let files = farm.wait_for_queued(2);
    farm.wait_for_parts(PartState::Built, 2);
    for file in files {
        assert_eq!(build_file::read_build(&file, &build_file::ReadLimits::default()).unwrap().len(), 1);
        let output_text = farm.nestd_ok(&["verify", file.to_str().unwrap()]);
        assert!(output_text.contains("part by part"), "{output_text}");
    }
    farm.assert_nothing_lost_or_doubled();
}
