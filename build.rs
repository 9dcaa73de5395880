//! Notes from which commit a release is built, for `nestd --version`. `NESTD_COMMIT` says it where there is no repository. A program
//! of the development profile does not know it: it would be compiled again after each commit.

use std::{path::Path, process::Command};

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned()).filter(|text| !text.is_empty())
}

fn main() {
    println!("cargo:rerun-if-env-changed=NESTD_COMMIT");
    let given = std::env::var("NESTD_COMMIT").ok().filter(|commit| !commit.is_empty());
    // Not the repository of somebody who has these sources as a folder in his own.
    let is_ours = Path::new(".git").exists() && std::env::var("PROFILE").is_ok_and(|profile| profile == "release");
    if is_ours && given.is_none() {
        for file in ["HEAD", "logs/HEAD"].iter().filter_map(|name| git(&["rev-parse", "--git-path", name])) {
            if Path::new(&file).exists() {
                println!("cargo:rerun-if-changed={file}");
            }
        }
    }
    let of_repository = || git(&["log", "-1", "--format=%h, %cs", "--abbrev=10"]).filter(|_| is_ours);
    let commit = given.or_else(of_repository).map(|commit| format!(" ({commit})")).unwrap_or_default();
    println!("cargo:rustc-env=NESTD_VERSION={}{commit}", env!("CARGO_PKG_VERSION"));
}
