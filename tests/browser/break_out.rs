//! Two people break out one build, each with a device of their own: what is shown to whom, and what is said, by touch, mouse and keyboard.

use std::process::Command;

use glam::DVec3;
use ledger::PartState;

use crate::{
    pages::{BrowserDashboard, MACHINE, Nodes, browser, tools},
    support::stl,
};

/// A machine with room for all copies in few layers; the search need not be good.
const PROFILE: &str = "volume_mm = [380, 284, 380]\nclearance_mm = 3.0\nlayer_mm = 0.08\nsettle_secs = 0.3\nunfinished_secs = 2\n\
                       final_secs = 1\narrival_secs = 0\n";
/// Kinds of parts, each of an order of its own, and copies of each.
const PARTS: (usize, usize) = (12, 20);
/// Presses of both together.
const PRESSES: usize = 200;

pub fn two_devices_break_out_a_build_and_no_copy_is_shown_to_both() {
    break_out(Nodes::One);
}

pub fn two_devices_break_out_a_build_whichever_of_three_nodes_answers() {
    break_out(Nodes::Three);
}

fn break_out(nodes: Nodes) {
    let chromium = browser();
    let dashboard = BrowserDashboard::start_on(nodes);
    dashboard.farm.write_profile(MACHINE, PROFILE);
    dashboard.farm.reload();
    let (kinds, each) = PARTS;
    for kind in 0..kinds {
        let size = DVec3::new(9.0 + (kind % 5) as f64, 8.0 + (kind % 7) as f64, 7.0 + (kind % 3) as f64);
        let name = format!("a hinge of the kind with a name of nearly sixty letters {kind:02}.stl");
        dashboard.drop(&format!("K-{kind}"), &format!("{name}.toml"), format!("copies = {each}").as_bytes());
        dashboard.drop(&format!("K-{kind}"), &name, &stl(&sample_parts::cuboid(size)));
    }
    dashboard.wait_for(PartState::Waiting, kinds);
    dashboard.flush();
    dashboard.printer_takes("1");
    let asked = serde_json::json!({
        "chromium": chromium, "base": dashboard.base, "build": 1, "copies": kinds * each, "presses": PRESSES,
        "shots": std::env::var_os("NESTD_SHOTS").map(std::path::PathBuf::from),
    });
    let output = Command::new("node").arg("breakout.mjs").arg(asked.to_string()).current_dir(tools()).output().unwrap();
    let output_text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    println!("{output_text}");
    assert!(output.status.success(), "{output_text}\n{}", dashboard.farm.log());
}
