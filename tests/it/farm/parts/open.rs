//! The open build: it adds and removes parts, keeps zones free, can be published at any moment, and is idle without
//! work.

use std::time::{Duration, Instant};

use glam::DVec3;
use ledger::PartState;
use nester::{PlacedSolid, prove_with_keep_out};
use solids::Bounds;

use crate::support::{QUICK, TestFarm, block, cpu_secs};

#[test]
fn a_reserved_zone_stays_free_in_the_published_file() {
    let zone = "keep_out = [{ min = [0, 0, 0], max = [60, 120, 40] }]";
    let farm = TestFarm::running(&format!("{zone}\nfloor_margin_mm = 3\n{QUICK}"));
    farm.drop_part("a_x3.stl", &block(50.0, 50.0, 20.0));
    farm.drop_part("b_x4.stl", &block(30.0, 20.0, 12.0));
    farm.wait_for_parts(PartState::Waiting, 2);
    farm.flush();
    farm.wait_for_parts(PartState::Built, 2);
    let file = farm.queued().remove(0);
    let (info, placed) = build_file::read_build_and_metadata(&file, &Default::default()).unwrap();
    let zone = Bounds { min: DVec3::ZERO, max: DVec3::new(60.0, 120.0, 40.0) };
    assert_eq!(info.rules.keep_out, [zone]);
    let body = |p: build_file::PlacedMesh| PlacedSolid { name: p.name, mesh: p.mesh, pose: p.pose, clearance_mm: 2.0 };
    let bodies: Vec<PlacedSolid> = placed.into_iter().map(body).collect();
    assert_eq!(bodies.len(), 7);
    assert!(prove_with_keep_out(&bodies, DVec3::splat(120.0), 0.0, &[zone]).is_proved());
    let output_text = farm.nestd_ok(&["verify", file.to_str().unwrap()]);
    assert!(output_text.contains("proved") && output_text.contains("keep-out boxes  1"), "{output_text}");
}

#[test]
fn a_flush_while_parts_arrive_publishes_all_of_them_within_the_final_budget() {
    let farm = TestFarm::running(&QUICK.replace("arrival_secs = 0.5", "arrival_secs = 60"));
    farm.drop_part("a_x20.stl", &block(20.0, 15.0, 8.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    std::thread::sleep(Duration::from_millis(1500));
    farm.drop_part("b_x2.stl", &block(31.0, 12.0, 9.0));
    farm.wait_for_parts(PartState::Waiting, 2);
    let began = Instant::now();
    farm.flush();
    farm.wait_for_parts(PartState::Built, 2);
    assert!(began.elapsed().as_secs() < 30, "the search for arrivals does not hold it up");
    assert_eq!(farm.queued().len(), 1);
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn an_idle_farm_uses_next_to_no_cpu() {
    let farm = TestFarm::running(QUICK);
    // Waiting parts that are already nested cost no more CPU time than an empty farm.
    farm.drop_part("a.stl", &block(20.0, 15.0, 8.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    std::thread::sleep(Duration::from_secs(4));
    let before = cpu_secs(farm.pid());
    std::thread::sleep(Duration::from_secs(4));
    let used = cpu_secs(farm.pid()) - before;
    assert!(used < 0.2, "{used} s in 4 s");
}
