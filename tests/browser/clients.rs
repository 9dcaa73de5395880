//! Clients that others' generators make of the description of the interface: they run the examples of docs/integrator.md against the real
//! daemon. Needs `NESTD_API_TOOLS=<folder>`, which `clients/fetch.sh <folder>` fills.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
    thread::JoinHandle,
    time::{Duration, Instant},
};

use crate::{
    pages::BrowserDashboard,
    support::{QUICK, TestFarm, block, farm_files::list_build_files, stl},
};

fn tools() -> PathBuf {
    std::env::var_os("NESTD_API_TOOLS").unwrap().into()
}

fn sources() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/browser/clients")
}

/// A farm, and a folder with its description and the files that the examples send.
fn prepared() -> (BrowserDashboard, tempfile::TempDir) {
    let dashboard = BrowserDashboard::serve(TestFarm::new(QUICK));
    // Below the tools, whose packages node then finds.
    let folder = tempfile::tempdir_in(tools()).unwrap();
    let mut answer = ureq::get(&format!("{}/api/v1/openapi.json", dashboard.base)).call().unwrap();
    fs::write(folder.path().join("openapi.json"), answer.body_mut().read_to_vec().unwrap()).unwrap();
    for (name, mesh) in [("hinge.stl", block(30.0, 20.0, 10.0)), ("cover.stl", block(25.0, 20.0, 5.0))] {
        fs::write(folder.path().join(name), stl(&mesh)).unwrap();
    }
    (dashboard, folder)
}

/// A printer that takes the first build out of the queue of a farm.
pub fn printer_of(farm: &TestFarm) -> JoinHandle<()> {
    let queue = farm.folder("queue");
    std::thread::spawn(move || {
        let began = Instant::now();
        while began.elapsed() < Duration::from_secs(120) {
            if let Some(file) = list_build_files(&queue).first() {
                return fs::remove_file(file).unwrap();
            }
            std::thread::sleep(Duration::from_millis(100));
        }
    })
}

/// Runs a tool in a folder. Returns what it says.
fn run(folder: &Path, tool: &str, arguments: &[&str]) -> String {
    let path = format!("{}:{}", tools().join("venv/bin").display(), std::env::var("PATH").unwrap());
    let mut command = Command::new(if tool == "node" { tool.into() } else { tools().join(tool) });
    let ran = command.args(arguments).current_dir(folder).env("PATH", path).output().unwrap();
    let text = format!("{}{}", String::from_utf8_lossy(&ran.stdout), String::from_utf8_lossy(&ran.stderr));
    assert!(ran.status.success(), "{tool} {arguments:?}: {text}");
    text
}

pub fn a_python_client_made_of_the_description_runs_the_examples_of_the_document() {
    let (dashboard, folder) = prepared();
    let (folder, generator) = (folder.path(), sources().join("generator.yaml"));
    run(folder, "venv/bin/openapi-spec-validator", &["openapi.json"]);
    let made = ["generate", "--path", "openapi.json", "--meta", "none", "--output-path", "nestd_client", "--config"];
    let arguments = [&made[..], &[generator.to_str().unwrap(), "--fail-on-warning"]].concat();
    run(folder, "venv/bin/openapi-python-client", &arguments);
    fs::copy(sources().join("client.py"), folder.join("client.py")).unwrap();
    let _printer = printer_of(&dashboard.farm);
    let told = run(folder, "venv/bin/python", &["client.py", &dashboard.base, "."]);
    assert!(told.contains("all examples ran"), "{told}\n{}", dashboard.farm.log());
    dashboard.farm.assert_ledger_agrees();
}

pub fn a_typescript_client_made_of_the_description_runs_the_examples_of_the_document() {
    let (dashboard, folder) = prepared();
    let folder = folder.path();
    run(folder, "node_modules/.bin/openapi-typescript", &["openapi.json", "--output", "nestd.d.ts"]);
    for name in ["client.ts", "package.json"] {
        fs::copy(sources().join(name), folder.join(name)).unwrap();
    }
    let strict =
        ["--strict", "--noUncheckedIndexedAccess", "--target", "es2022", "--module", "nodenext", "--skipLibCheck"];
    run(folder, "node_modules/.bin/tsc", &[&strict[..], &["client.ts"]].concat());
    let _printer = printer_of(&dashboard.farm);
    let told = run(folder, "node", &["client.js", &dashboard.base, "."]);
    assert!(told.contains("all examples ran"), "{told}\n{}", dashboard.farm.log());
    dashboard.farm.assert_ledger_agrees();
}
