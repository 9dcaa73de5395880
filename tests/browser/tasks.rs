//! What people do on the pages, by clicks and seconds, and how a build opens on a slow line. `NESTD_SHOTS=<folder>` also saves pictures
//! of the pages of that farm (`docs/screens.sh`).

use std::{fs, process::Command};

use glam::DVec3;
use ledger::PartState;

use crate::{
    pages::{BrowserDashboard, MACHINE, Nodes, browser, tools},
    quiet,
    support::{stl, wait_until_or},
};

/// Tasks of people take few clicks by mouse, touch and keyboard, and a line of 400 kbit/s shows a picture within 3 s and the view within 20 s.
pub fn tasks_take_few_clicks_by_mouse_touch_and_keyboard_and_a_slow_line_shows_a_picture_soon() {
    do_tasks(Nodes::One);
}

/// The same, whichever of three nodes answers.
pub fn tasks_are_done_whichever_of_three_nodes_answers() {
    do_tasks(Nodes::Three);
}

fn do_tasks(nodes: Nodes) {
    let (chromium, _quiet) = (browser(), quiet::run_alone());
    let dashboard = BrowserDashboard::start_on(nodes);
    let box_of = |x: f64, y: f64, z: f64| stl(&sample_parts::cuboid(DVec3::new(x, y, z)));
    // A build that is good, one that failed, one that waits with what is late, and a refused file.
    let read = dashboard.drop_samples(0, &["Acme", "1182", "Müller & Söhne"]);
    dashboard.wait_for(PartState::Waiting, read);
    dashboard.flush();
    dashboard.farm.nestd_ok(&["outcome", "1", "complete"]);
    dashboard.drop("Beta AG", "cover_x2.stl", &box_of(50.0, 40.0, 8.0));
    dashboard.wait_for(PartState::Waiting, 1);
    dashboard.flush();
    let history: serde_json::Value = serde_json::from_str(&dashboard.farm.nestd_ok(&["history", "--json"])).unwrap();
    let failed = history[0]["build"].to_string();
    dashboard.printer_takes(&failed);
    dashboard.farm.nestd_ok(&["outcome", &failed, "failed", "--note", "bed moved"]);
    dashboard.drop("Gamma", "late_part.stl.toml", b"copies = 1\ndue = \"2026-01-15\"\n");
    dashboard.drop("Gamma", "late_part.stl", &box_of(33.0, 22.0, 11.0));
    dashboard.drop("Delta", "hinge DO NOT PRINT.stl", &box_of(21.0, 12.0, 8.0));
    // The copies of the failed print wait, too.
    dashboard.wait_for(PartState::Waiting, 3);
    dashboard.drop("Delta", "torn.stl", &box_of(9.0, 9.0, 9.0)[..500]);
    dashboard.wait_for(PartState::Refused, 1);
    let shown = || {
        let page = Command::new("curl").args(["-s", &dashboard.base]).output().unwrap();
        let page = String::from_utf8_lossy(&page.stdout).into_owned();
        page.contains("Late, or at risk") && page.contains("torn.stl") && page.contains("bed moved")
    };
    wait_until_or("the farm page says what is late, failed and refused", 60.0, || dashboard.farm.log(), shown);
    let sample = dashboard.farm.root().join("sample.stl");
    fs::write(&sample, box_of(17.0, 12.0, 9.0)).unwrap();
    let asked = serde_json::json!({
        "chromium": chromium, "base": dashboard.base, "machine": MACHINE, "build": 1, "sample": sample, "friday": "2031-11-28",
        "shots": std::env::var_os("NESTD_SHOTS").map(std::path::PathBuf::from),
    });
    let output = Command::new("node").arg("tasks.mjs").arg(asked.to_string()).current_dir(tools()).output().unwrap();
    let output_text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    println!("{output_text}");
    assert!(output.status.success(), "{output_text}\n{}", dashboard.farm.log());
}
