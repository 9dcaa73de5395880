//! People who sign in to the real daemon: over HTTP, across restarts, and with nothing secret in what is written down.

use std::{fs, io::Write, process::Stdio};

use crate::{farm::parts::door::OpenFarm, support::http::HttpAnswer};

const PASSWORD: &str = "correct horse battery";

/// Runs a command that asks for something secret.
fn tell(open: &OpenFarm, args: &[&str], secret: &str) -> String {
    let mut command = open.farm.command(args);
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    writeln!(child.stdin.take().unwrap(), "{secret}").unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn sign_in(open: &OpenFarm, password: &str) -> HttpAnswer {
    let body = format!("name=anna&password={}", password.replace(' ', "+"));
    open.send("POST /sign-in\ncontent-type: application/x-www-form-urlencoded", body.as_bytes())
}

fn get(open: &OpenFarm, path: &str, token: &str) -> HttpAnswer {
    open.send(&format!("GET {path}\ncookie: nestd_session={token}"), b"")
}

#[test]
fn a_person_signs_in_stays_so_over_a_restart_and_leaves_no_secret_behind() {
    let mut open = OpenFarm::start("");
    assert_eq!(get(&open, "/", "").status, 200, "without people nobody is asked");
    let said = tell(&open, &["people", "add", "anna", "--role", "operate"], PASSWORD);
    assert!(said.contains("anna may sign in, with the role operate."), "{said}");
    std::thread::sleep(std::time::Duration::from_millis(1100));
    assert_eq!(get(&open, "/", "").status, 401);
    assert_eq!(open.send("GET /api/v1/farm", b"").status, 401);
    assert_eq!(sign_in(&open, "wrong horse battery").status, 403);
    let answer = sign_in(&open, PASSWORD);
    assert_eq!(answer.status, 303, "{}", answer.body);
    let token = answer.head.split("nestd_session=").nth(1).unwrap().split(';').next().unwrap().to_owned();
    assert_eq!(get(&open, "/", &token).status, 200);
    open.restart();
    assert_eq!(get(&open, "/", &token).status, 200, "it is in the ledger");
    assert!(open.farm.nestd_ok(&["people", "list"]).contains("anna"));
    let backup = open.farm.root().join("backup");
    assert!(open.farm.nestd_ok(&["backup", backup.to_str().unwrap()]).contains("keep it as a secret"));
    let state =
        fs::read_dir(open.farm.root().join("state")).unwrap().filter_map(|entry| fs::read(entry.unwrap().path()).ok());
    let written: Vec<Vec<u8>> = state.chain([open.farm.log().into_bytes(), fs::read(&backup).unwrap()]).collect();
    for secret in [PASSWORD, token.as_str()] {
        let has = |bytes: &Vec<u8>| bytes.windows(secret.len()).any(|window| window == secret.as_bytes());
        assert!(!written.iter().any(has), "{secret} is written down");
    }
    assert!(open.farm.nestd_ok(&["people", "sign-out", "ANNA"]).contains("anna is signed out everywhere"));
    assert_eq!(get(&open, "/", &token).status, 401);
    let last = open.farm.nestd(&["people", "remove", "anna"]);
    assert!(!last.status.success() && String::from_utf8_lossy(&last.stderr).contains("--anyway"));
}
