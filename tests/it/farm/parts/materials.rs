//! Materials, with the real daemon: parts of two materials in one hot folder never share a build, whoever loads what and whatever is killed.

use std::fs;

use farm::InvariantExpectations;
use ledger::PartState;

use crate::support::{QUICK, TestFarm, block, wait_until_or};

const MATERIALS: &str = "[materials]\nPA12 = [\"PA 12\", \"Nylon 12\", \"PA2200\"]\nPA11 = [\"Rilsan\"]\n";

fn drop_of(farm: &TestFarm, name: &str, material: &str) {
    if !material.is_empty() {
        farm.drop_bytes(&format!("{name}.toml"), format!("material = \"{material}\"\n").as_bytes());
    }
    farm.drop_part(name, &block(20.0, 20.0, 10.0));
}

/// The names of the parts of each published build, by build, with its material.
fn builds(farm: &TestFarm) -> Vec<(String, Vec<String>)> {
    let history: serde_json::Value =
        serde_json::from_str(&farm.nestd_ok(&["history", "--format", "json"])).expect("the history is JSON");
    let mut builds: Vec<(String, Vec<String>)> = Vec::new();
    for row in history.as_array().unwrap() {
        let id = ledger::BuildId(row["build"].as_i64().unwrap());
        let (build, parts) = farm.query_ledger(async |ledger| {
            (ledger.find_build(id).await.unwrap().unwrap(), ledger.parts_of_build(id).await.unwrap())
        });
        let mut names: Vec<String> = parts.into_iter().map(|part| part.name).collect();
        names.sort();
        builds.push((build.material, names));
    }
    builds.sort();
    builds
}

#[test]
fn parts_of_two_materials_in_one_folder_never_share_a_build() {
    let mut farm = TestFarm::new(&format!("{QUICK}material = \"pa 12\"\n"));
    let config = fs::read_to_string(farm.config()).unwrap();
    fs::write(farm.config(), format!("{config}{MATERIALS}")).unwrap();
    farm.start();
    for (name, material) in
        [("a.stl", "PA2200"), ("b.stl", "nylon-12"), ("c.stl", "PA11"), ("d.stl", ""), ("e.stl", "PA13")]
    {
        drop_of(&farm, name, material);
    }
    let parts = farm.wait_for_parts(PartState::Waiting, 5);
    let waiting = |name: &str| parts.iter().find(|part| part.name == name).unwrap();
    assert_eq!(waiting("a.stl").terms.material, "PA12");
    let shown = |name: &str| {
        let text = farm.nestd_ok(&["show", &format!("p{}", waiting(name).id)]);
        text.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let asked = shown("c.stl");
    for said in
        ["waits for PA11", "test has PA12 loaded", "PA11 is loaded on no machine", "nestd machine load test PA11"]
    {
        assert!(asked.contains(said), "{said}: {asked}");
    }
    let unknown = shown("e.stl");
    assert!(unknown.contains("does not name PA13, only PA11, PA12"), "{unknown}");
    farm.flush();
    farm.wait_for_parts(PartState::Built, 3);
    assert_eq!(builds(&farm), [("PA12".to_owned(), ["a.stl", "b.stl", "d.stl"].map(str::to_owned).to_vec())]);
    let status = || fs::read_to_string(farm.folder("inbox").join("STATUS.txt")).unwrap_or_default();
    wait_until_or("the hot folder says what waits", 20.0, status, || {
        status().contains("Loaded: PA12.") && status().contains("1 copy waits for PA11. PA11 is loaded on no machine.")
    });
    let flushed = farm.nestd_ok(&["flush", "test"]);
    assert!(flushed.contains("nothing is built in test") && flushed.contains("1 copy for PA11"), "{flushed}");
    let refused = farm.nestd(&["machine", "load", "test", "PA13"]);
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(!refused.status.success() && said.contains("only PA11, PA12"), "{said}");
    drop_of(&farm, "f.stl", "PA 12");
    farm.wait_for_parts(PartState::Waiting, 3);
    // Said, and the daemon is killed before it has seen it.
    farm.kill();
    let told = farm.nestd_ok(&["machine", "load", "test", "rilsan"]);
    assert!(told.contains("PA11 is loaded on test now") && told.contains("2 parts there wait"), "{told}");
    farm.start();
    farm.flush();
    farm.wait_for_parts(PartState::Built, 4);
    let made = builds(&farm);
    assert_eq!(made[0], ("PA11".to_owned(), vec!["c.stl".to_owned()]), "{made:?}");
    farm.nestd_ok(&["edit", &format!("p{}", waiting("e.stl").id), "--material", "Rilsan"]);
    farm.flush();
    farm.wait_for_parts(PartState::Built, 5);
    farm.nestd_ok(&["machine", "load", "test", "PA12"]);
    farm.flush();
    farm.wait_for_parts(PartState::Built, 6);
    let made: Vec<String> = builds(&farm).into_iter().map(|(of, parts)| format!("{of}: {}", parts.join(" "))).collect();
    assert_eq!(made, ["PA11: c.stl", "PA11: e.stl", "PA12: a.stl b.stl d.stl", "PA12: f.stl"]);
    farm.stop();
    assert_eq!(farm.broken_invariants(&InvariantExpectations { at_rest: true, ..Default::default() }), [""; 0]);
}
