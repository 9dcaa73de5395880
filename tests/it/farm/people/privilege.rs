//! Least privilege: the daemon does not run as root without the option, and its files have the configured mode and
//! group.

use std::{
    fs,
    os::unix::{
        fs::{MetadataExt, PermissionsExt},
        process::CommandExt,
    },
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

use ledger::PartState;

use crate::support::{MACHINE, QUICK, TestFarm, stl, wait_until};

const NOBODY: u32 = 65534;

fn is_root() -> bool {
    rustix::process::geteuid().is_root()
}

#[test]
fn the_daemon_does_not_run_as_root_unless_allowed() {
    if !is_root() {
        return; // nothing to refuse
    }
    let farm = TestFarm::new(QUICK);
    let output = farm.command(&["run"]).env_remove("NESTD_ALLOW_ROOT").output().unwrap();
    let output_text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{output_text}");
    assert!(output_text.contains("does not run as root") && output_text.contains("--allow-root"), "{output_text}");
    assert!(!farm.root().join("state").exists(), "it has made something");
    let no = farm.command(&["run"]).env("NESTD_ALLOW_ROOT", "0").output().unwrap();
    assert_eq!(no.status.code(), Some(2));
    for allowed in [&["check"][..], &["status"], &["--help"]] {
        let output_text = farm.command(allowed).env_remove("NESTD_ALLOW_ROOT").output().unwrap();
        assert!(!String::from_utf8_lossy(&output_text.stderr).contains("root:"), "{allowed:?} is fine as root");
    }
}

/// Ports on which a process listens.
fn ports_of(pid: i32) -> usize {
    let descriptors = fs::read_dir(format!("/proc/{pid}/fd")).unwrap();
    let sockets: Vec<String> = descriptors
        .filter_map(|entry| {
            fs::read_link(entry.unwrap().path()).ok()?.to_str()?.strip_prefix("socket:[").map(str::to_owned)
        })
        .collect();
    let listening = |table: &str| -> usize {
        let text = fs::read_to_string(format!("/proc/{pid}/net/{table}")).unwrap_or_default();
        let rows = text.lines().skip(1).map(|line| line.split_whitespace().collect::<Vec<_>>());
        rows.filter(|row| row[3] == "0A" && sockets.iter().any(|socket| socket.trim_end_matches(']') == row[9])).count()
    };
    ["tcp", "tcp6"].map(listening).iter().sum()
}

#[test]
fn a_daemon_opens_a_port_only_for_a_dashboard_that_is_asked_for() {
    let mut farm = TestFarm::running(QUICK);
    farm.drop_part("block.stl", &sample_parts::cuboid(glam::DVec3::splat(20.0)));
    farm.wait_for_parts(PartState::Waiting, 1);
    assert_eq!(ports_of(farm.pid()), 0);
    farm.stop();
    let config = fs::read_to_string(farm.config()).unwrap();
    fs::write(farm.config(), format!("{config}[web]\nlisten = \"127.0.0.1:0\"\n")).unwrap();
    farm.start();
    wait_until("the dashboard listens", 20.0, || ports_of(farm.pid()) == 1);
}

#[test]
fn a_group_that_the_daemons_user_is_not_in_is_refused_at_the_start() {
    let farm = TestFarm::new(QUICK);
    let config = fs::read_to_string(farm.config()).unwrap();
    fs::write(farm.config(), format!("{config}[files]\ngroup = \"4711\"\n")).unwrap();
    let mut command = farm.command(&["run"]);
    if is_root() {
        command.uid(NOBODY).gid(NOBODY);
        let reachable = farm.command(&["--version"]).uid(NOBODY).gid(NOBODY).output();
        if !reachable.is_ok_and(|output| output.status.success())
            || fs::set_permissions(farm.root(), PermissionsExt::from_mode(0o755)).is_err()
        {
            return; // the user `nobody` may not run the binary that cargo has built here
        }
    }
    let output = command.output().unwrap();
    let output_text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{output_text}");
    assert!(output_text.contains("is not in the group 4711"), "{output_text}");
}

/// Starts the daemon with a given umask, as a careless script might.
fn start_with_umask(farm: &TestFarm, umask: &str) -> std::process::Child {
    let daemon = farm.command(&["run"]);
    let mut shell = Command::new("sh");
    shell.args(["-c", &format!("umask {umask}; exec \"$@\""), "sh"]).arg(daemon.get_program()).args(daemon.get_args());
    shell.env("NESTD_ALLOW_ROOT", "1").current_dir(farm.root()).stdout(Stdio::null());
    let log = fs::File::options().create(true).append(true).open(farm.root().join("log")).unwrap();
    shell.stderr(log).spawn().unwrap()
}

/// Everything below a folder: path, mode, group, whether it is a folder.
fn all_below(folder: &Path, found: &mut Vec<(PathBuf, u32, u32, bool)>) {
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let meta = entry.metadata().unwrap();
        found.push((entry.path(), meta.mode() & 0o777, meta.gid(), meta.is_dir()));
        if meta.is_dir() {
            all_below(&entry.path(), found);
        }
    }
}

#[test]
fn what_the_daemon_makes_has_the_mode_and_group_of_the_configuration_under_any_umask() {
    let group = if is_root() { 4711 } else { rustix::process::getegid().as_raw() };
    for (umask, mode, folders) in [("077", 0o660, 0o770), ("000", 0o640, 0o750)] {
        let farm = TestFarm::new(QUICK);
        let config = fs::read_to_string(farm.config()).unwrap();
        fs::write(farm.config(), format!("{config}[files]\nmode = \"{mode:04o}\"\ngroup = \"{group}\"\n")).unwrap();
        let mut daemon = start_with_umask(&farm, umask);
        crate::support::wait_until("the hot folder is there", 20.0, || farm.folder("inbox").is_dir());
        farm.drop_bytes("good.stl", &stl(&sample_parts::all_samples()[0].mesh));
        farm.drop_bytes("torn.stl", b"solid torn");
        farm.wait_for_parts(PartState::Waiting, 1);
        farm.flush();
        farm.wait_for_parts(PartState::Built, 1);
        crate::support::wait_until("the torn file is refused", 20.0, || {
            farm.folder("error").join("torn.stl.reason.txt").exists()
        });
        let mut found = Vec::new();
        for kind in ["inbox", "queue", "error", "archive"] {
            let folder = fs::metadata(farm.folder(kind)).unwrap();
            found.push((farm.folder(kind), folder.mode() & 0o777, folder.gid(), true));
            all_below(&farm.folder(kind), &mut found);
        }
        daemon.kill().unwrap();
        daemon.wait().unwrap();
        // A file that was dropped and moved keeps the owner who dropped it.
        found.retain(|(path, ..)| !path.ends_with("torn.stl"));
        assert!(found.iter().any(|(path, ..)| path.to_string_lossy().ends_with(".build.3mf")), "{found:#?}");
        assert!(found.iter().any(|(path, ..)| path.ends_with("STATUS.txt")), "{found:#?}");
        let wrong: Vec<_> = (found.iter())
            .filter(|(_, has, gid, is_folder)| *has != if *is_folder { folders } else { mode } || *gid != group)
            .collect();
        assert!(wrong.is_empty(), "umask {umask}: {wrong:#?}");
        let state = fs::metadata(farm.root().join("state")).unwrap().mode() & 0o777;
        assert_eq!(state & 0o027, 0, "others may look into the state folder: {state:o}");
        assert!(farm.root().join("inbox").join(MACHINE).is_dir());
    }
}
