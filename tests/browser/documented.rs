//! What documents show runs as it stands there: the examples of docs/integrator.md with curl, the receiver of docs/integrator.md with Python.

use std::{
    fs,
    net::{TcpListener, TcpStream},
    os::unix::fs::PermissionsExt,
    path::Path,
    process::{Child, Command, Stdio},
};

use crate::{
    clients,
    pages::{BrowserDashboard, Nodes},
    support::{QUICK, TestFarm, block, stl, wait_until_or},
};

/// Why what needs this program cannot run here.
pub fn missing(program: &str) -> Option<String> {
    let version = Command::new(program).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    (!version.is_ok_and(|status| status.success())).then(|| format!("needs {program}"))
}

pub fn the_examples_of_the_interface_for_programs_work_as_they_stand_there() {
    run_examples(Nodes::One);
}

pub fn the_examples_work_whichever_of_three_nodes_answers() {
    run_examples(Nodes::Three);
}

fn run_examples(nodes: Nodes) {
    let dashboard = BrowserDashboard::serve_on(nodes, TestFarm::new(QUICK));
    let document = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/integrator.md")).unwrap();
    let examples: Vec<&str> = document.split("```sh\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
    assert!(examples.len() >= 6, "{}", examples.len());
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("hinge.stl"), stl(&block(30.0, 20.0, 10.0))).unwrap();
    let cover = stl(&block(25.0, 20.0, 5.0));
    fs::write(folder.path().join("cover.stl"), &cover).unwrap();
    let script = format!("set -eu\n{}", examples.join("echo\n")).replace("http://localhost:7878", &dashboard.base);
    assert!(script.contains(&dashboard.base), "the examples ask another farm");
    let _printer = clients::printer_of(&dashboard.farm);
    let ran = Command::new("sh").args(["-c", &script]).current_dir(folder.path()).output().unwrap();
    let (told, errors) = (String::from_utf8_lossy(&ran.stdout), String::from_utf8_lossy(&ran.stderr));
    assert!(ran.status.success(), "{told}\n{errors}\n{}", dashboard.farm.log());
    for words in [
        "\"order\":\"K-4711\"",
        "\"name\":\"hinge-left.stl\"",
        "\"done\":true",
        "Build 1 is complete.",
        "upload-offset: 40",
        blake3::hash(&cover).to_hex().as_str(),
    ] {
        assert!(told.contains(words), "{words}: {told}");
    }
    assert!(!told.contains("[\".\"]"), "what was done is told in words: {told}");
    dashboard.farm.assert_ledger_agrees();
}

/// The receiver of docs/integrator.md, word for word except for its port and its key.
fn documented_receiver(folder: &Path, port: u16) -> Child {
    let text = include_str!("../../docs/integrator.md");
    let (_, code) = text.split_once("standard library only:\n\n").unwrap();
    let lines = code.lines().take_while(|line| line.is_empty() || line.starts_with("    "));
    let code: String = lines.map(|line| format!("{}\n", line.strip_prefix("    ").unwrap_or(""))).collect();
    assert!(code.contains("8099") && code.contains("compare_digest"), "{code}");
    let code = code.replace("8099", &port.to_string()).replace("webhook.key", "secret");
    let output_file = fs::File::create(folder.join("heard")).unwrap();
    let mut python = Command::new("python3");
    python.args(["-c", &code]).current_dir(folder).stdout(output_file).stderr(Stdio::null());
    python.spawn().unwrap()
}

pub fn the_documented_receiver_takes_our_messages_and_refuses_others() {
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let farm = TestFarm::new(QUICK);
    let secret = farm.root().join("secret");
    fs::write(&secret, "a-key-of-some-length-for-tests\n").unwrap();
    fs::set_permissions(&secret, fs::Permissions::from_mode(0o600)).unwrap();
    let config = fs::read_to_string(farm.config()).unwrap();
    let hook = format!("webhook = \"http://127.0.0.1:{port}/hook\"\nsecret_file = \"{}\"\n", secret.display());
    fs::write(farm.config(), format!("{config}[notify]\n{hook}")).unwrap();
    let mut python = documented_receiver(farm.root(), port);
    let listens = || TcpStream::connect(("127.0.0.1", port)).is_ok();
    wait_until_or("the receiver listens", 20.0, String::new, listens);
    farm.nestd_ok(&["notify", "--test"]);
    let read_output = || fs::read_to_string(farm.root().join("heard")).unwrap();
    wait_until_or("the receiver tells of it", 20.0, String::new, || read_output().ends_with('\n'));
    fs::write(&secret, "another-key-of-some-length\n").unwrap();
    let forged = farm.nestd(&["notify", "--test"]);
    python.kill().unwrap();
    python.wait().unwrap();
    assert!(read_output().starts_with("A test message from nestd on "), "{}", read_output());
    assert_eq!(forged.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&forged.stderr).contains("answers 403"), "{forged:?}");
}
