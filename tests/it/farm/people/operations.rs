//! The commands of docs/administrator.md, word for word.

use std::{fs, path::Path, process::Command};

use ledger::PartState;

use crate::support::{QUICK, TestFarm, block};

/// The commands of a section of the document.
fn commands(section: &str) -> Vec<String> {
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/administrator.md")).unwrap();
    let section = text.split(&format!("## {section}\n")).nth(1).unwrap_or_else(|| panic!("no section {section}"));
    let lines = section.split("\n## ").next().unwrap().lines();
    let commands: Vec<String> = lines.filter_map(|line| line.strip_prefix("    ")).map(str::to_owned).collect();
    assert!(commands.len() >= 2, "{commands:?}");
    commands
}

impl TestFarm {
    /// Runs a line of the document on this farm's folders.
    fn do_as_documented(&mut self, line: &str) {
        match line {
            "systemctl stop nestd" => return self.stop(),
            "systemctl start nestd" => return self.start(),
            _ => {}
        }
        let here = self.root().display().to_string();
        let line = line
            .replace("/var/backups/nestd", &format!("{here}/backups"))
            .replace("/var/lib/nestd", &format!("{here}/state"))
            .replace("2026-11-20", "$(date +%F)");
        let script = format!("set -eu\nnestd() {{ \"$NESTD\" \"$@\" -c config/nestd.toml --root . ; }}\n{line}\n");
        let output = Command::new("bash")
            .args(["-c", &script])
            .env("NESTD", env!("CARGO_BIN_EXE_nestd"))
            .current_dir(self.root())
            .output()
            .unwrap();
        let output_text =
            String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{line}: {output_text}\n{}", self.log());
    }
}

#[test]
fn backing_up_and_restoring_work_as_they_are_documented() {
    let mut farm = TestFarm::running(QUICK);
    fs::create_dir_all(farm.root().join("backups/store")).unwrap();
    farm.drop_part("a.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    for line in commands("Backing up") {
        farm.do_as_documented(&line);
    }
    assert_eq!(fs::read_dir(farm.root().join("backups/store")).unwrap().count(), 1, "the original is kept");
    farm.flush();
    farm.wait_for_parts(PartState::Built, 1);
    for line in commands("Restoring") {
        farm.do_as_documented(&line);
    }
    assert_eq!(farm.parts(PartState::Built).len(), 1);
    farm.flush();
    std::thread::sleep(std::time::Duration::from_millis(1500));
    assert_eq!(farm.queued().len(), 1, "printed twice");
}
