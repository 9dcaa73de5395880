//! `nestd render`, `report`, `status --watch` and the progress bar of `nest`, as a user at a terminal sees them.

use std::{
    fs::{self, File},
    io::Read,
    os::fd::OwnedFd,
    path::{Path, PathBuf},
    process::{Command, Output, Stdio},
    sync::mpsc,
    time::{Duration, Instant},
};

use build_file::write_stl;
use glam::DVec3;
use ledger::Ledger;
use nix::pty::{Winsize, openpty};
use solids::Pose;

/// A script tag that is a possible file name: without a slash.
const EVIL: &str = "<script>alert(1)<!--.stl";

pub fn nestd(dir: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_nestd"));
    command.current_dir(dir).env_remove("NESTD_ROOT").args(args);
    command
}

fn run(dir: &Path, args: &[&str]) -> Output {
    nestd(dir, args).output().unwrap()
}

/// The shipped configuration for trying nestd out.
fn config() -> String {
    format!("{}/config/nestd.toml", env!("CARGO_MANIFEST_DIR"))
}

/// (exit code, standard error).
fn failed(dir: &Path, args: &[&str]) -> (Option<i32>, String) {
    let output = run(dir, args);
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

/// A folder with two parts, one with a hostile name, and the arguments to nest them.
fn parts() -> (tempfile::TempDir, Vec<String>) {
    let dir = tempfile::tempdir().unwrap();
    let blocks = [(EVIL, DVec3::new(30.0, 20.0, 10.0)), ("b.stl", DVec3::new(15.0, 15.0, 40.0))];
    for (name, size) in blocks {
        let mesh = sample_parts::cuboid(size);
        write_stl([(&mesh, &Pose::IDENTITY)].into_iter(), File::create(dir.path().join(name)).unwrap()).unwrap();
    }
    let words = [&format!("{EVIL}=3"), "b.stl=2", "--volume", "80x80x120", "--clearance", "1", "-o", "x.build.3mf"];
    let args = ["nest"].into_iter().chain(words).map(str::to_owned).collect();
    (dir, args)
}

fn nested(more: &[&str]) -> (tempfile::TempDir, Output) {
    let (dir, args) = parts();
    let args: Vec<&str> = args.iter().map(String::as_str).chain(more.iter().copied()).collect();
    let output = run(dir.path(), &args);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    (dir, output)
}

fn png_size(bytes: &[u8]) -> (u32, u32) {
    assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
    let number = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
    (number(16), number(20))
}

#[test]
fn a_build_file_is_drawn_from_three_sides_at_the_size_asked_without_a_farm() {
    let (dir, _) = nested(&["--evaluations", "200"]);
    let mut pictures = Vec::new();
    for view in ["iso", "top", "front"] {
        let args = ["render", "x.build.3mf", "--view", view, "--size", "300x200", "-o", "x.png"];
        assert!(run(dir.path(), &args).status.success());
        pictures.push(fs::read(dir.path().join("x.png")).unwrap());
    }
    assert!(pictures.iter().all(|bytes| png_size(bytes) == (300, 200)));
    assert!(pictures[0] != pictures[1] && pictures[1] != pictures[2] && pictures[0] != pictures[2]);
    fs::remove_file(dir.path().join("x.png")).unwrap();
    let output = run(dir.path(), &["render", "x.build.3mf"]);
    assert_eq!((String::from_utf8(output.stdout).unwrap().as_str(), output.status.code()), ("x.png\n", Some(0)));
    let standing = fs::read(dir.path().join("x.png")).unwrap();
    assert_eq!(png_size(&standing), (1024, 768));
    assert_eq!(run(dir.path(), &["render", "x.build.3mf", "-o", "-"]).stdout, standing);
    let left: Vec<PathBuf> = fs::read_dir(dir.path()).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert!(left.iter().all(|path| !path.to_string_lossy().ends_with(".part")), "{left:?}");
}

#[test]
fn what_cannot_be_drawn_is_reported_with_the_reason() {
    let (dir, _) = nested(&["--evaluations", "50"]);
    fs::write(dir.path().join("torn.3mf"), "no package").unwrap();
    let config = config();
    for (args, code, expected) in [
        (vec!["render", "x.build.3mf", "--size", "0x9"], 2, "1 to 4096 pixels"),
        (vec!["render", "x.build.3mf", "--size", "9000x9"], 2, "1 to 4096 pixels"),
        (vec!["render", "x.build.3mf", "--view", "left"], 2, "iso, top, front"),
        (vec!["render", "./gone.build.3mf"], 2, "there is no file"),
        (vec!["render", "torn.3mf"], 2, "torn.3mf"),
        (vec!["render", "x.build.3mf", "-o", "."], 2, "is a folder"),
        (vec!["render", "x.build.3mf", "-o", "nowhere/x.png"], 1, "creating"),
        (vec!["render", "gone.build.3mf"], 2, "there is no file"),
        (vec!["report", "12", "-c", &config, "--root", "farm"], 1, "there is no ledger"),
        (vec!["render"], 2, "BUILD"),
    ] {
        let (found, output_text) = failed(dir.path(), &args);
        assert!(found == Some(code) && output_text.contains(expected), "{args:?}: {found:?} {output_text}");
    }
}

#[test]
fn a_report_of_a_file_is_whole_and_shows_names_as_text() {
    let (dir, _) = nested(&["--evaluations", "50"]);
    assert!(run(dir.path(), &["report", "x.build.3mf"]).status.success());
    let html = fs::read_to_string(dir.path().join("x.html")).unwrap();
    assert!(html.contains("alert(1)") && !html.contains("<script>alert") && !html.contains("<!--.stl"));
    assert!(html.contains("data:image/png;base64,") && html.contains("default-src 'none'"));
    assert!(html.contains("Pick map") && html.contains("data-copies=\"5\"") && html.ends_with("</html>"));
}

/// A process on a terminal of 30 rows, with its output so far.
pub struct PseudoTerminal {
    pub child: std::process::Child,
    written: mpsc::Receiver<Vec<u8>>,
    pub seen: String,
}

impl PseudoTerminal {
    /// Runs a command whose standard output (or standard error) is a terminal.
    pub fn of(command: Command, errors: bool) -> Self {
        Self::wide(command, errors, 100)
    }

    /// The same with a given number of columns.
    fn wide(mut command: Command, errors: bool, columns: u16) -> Self {
        let size = Winsize { ws_row: 30, ws_col: columns, ws_xpixel: 0, ws_ypixel: 0 };
        let pty = openpty(&size, None).unwrap();
        let (mine, theirs): (OwnedFd, OwnedFd) = (pty.master, pty.slave);
        match errors {
            true => command.stderr(Stdio::from(theirs)).stdout(Stdio::null()),
            false => command.stdout(Stdio::from(theirs)).stderr(Stdio::null()),
        };
        let child = command.spawn().unwrap();
        drop(command);
        let (send, written) = mpsc::channel();
        std::thread::spawn(move || {
            let (mut terminal, mut buffer) = (File::from(mine), [0; 4096]);
            // Reading fails when the other side is closed.
            while let Ok(length @ 1..) = terminal.read(&mut buffer) {
                if send.send(buffer[..length].to_vec()).is_err() {
                    break;
                }
            }
        });
        Self { child, written, seen: String::new() }
    }

    /// Reads until the condition holds for the text so far.
    pub fn until(&mut self, what: &str, holds: impl Fn(&str) -> bool) {
        let began = Instant::now();
        while !holds(&self.seen) {
            assert!(began.elapsed() < Duration::from_secs(60), "{what}: {:?}", self.seen);
            if let Ok(bytes) = self.written.recv_timeout(Duration::from_millis(200)) {
                self.seen += &String::from_utf8_lossy(&bytes);
            }
        }
    }
}

impl Drop for PseudoTerminal {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The signal of Ctrl-C. If this test runs in the background of a script, which ignores that signal, another signal
/// that ends the process.
fn interrupt() -> nix::sys::signal::Signal {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:")).unwrap().trim();
    match u64::from_str_radix(ignored, 16).unwrap() & 1 << 1 {
        0 => nix::sys::signal::Signal::SIGINT,
        _ => nix::sys::signal::Signal::SIGTERM,
    }
}

#[test]
fn status_is_redrawn_in_place_until_ctrl_c() {
    let dir = tempfile::tempdir().unwrap();
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let config = config();
    let status = ["-c", &config, "--root", ".", "status", "--watch"];
    let (code, output_text) = failed(dir.path(), &status);
    assert!(code == Some(2) && output_text.contains("redraws a terminal"), "{code:?} {output_text}");
    runtime.block_on(async { Ledger::open(&dir.path().join("state/nestd.db")).await.unwrap().close().await });
    let mut terminal = PseudoTerminal::of(nestd(dir.path(), &status), false);
    terminal.until("the farm is shown", |seen| seen.contains("MACHINE") && seen.contains("Ctrl-C"));
    assert!(terminal.seen.starts_with("\x1b[2J\x1b[H"), "{:?}", terminal.seen);
    runtime.block_on(async {
        let ledger = Ledger::open_existing(&dir.path().join("state/nestd.db")).await.unwrap();
        ledger.open_build("a-machine-that-came").await.unwrap();
        ledger.pause_machine("a-machine-that-came", "somebody@desk", ledger::PauseCause::Person).await.unwrap();
        ledger.close().await;
    });
    terminal.until("what changed is seen", |seen| seen.contains("a-machine-that-came"));
    assert_eq!(terminal.seen.matches("\x1b[2J").count(), 1, "later it is drawn over");
    let pid = nix::unistd::Pid::from_raw(terminal.child.id() as i32);
    nix::sys::signal::kill(pid, interrupt()).unwrap();
    assert_eq!(terminal.child.wait().unwrap().code(), None, "it ends by the signal");
}

#[test]
fn a_narrow_terminal_shows_all_of_the_status() {
    let dir = tempfile::tempdir().unwrap();
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let ledger = Ledger::open(&dir.path().join("state/nestd.db")).await.unwrap();
        ledger
            .pause_machine("fuse-1", "a-person-with-a-long-name@a-desk-in-the-office", ledger::PauseCause::Person)
            .await
            .unwrap();
        ledger.close().await;
    });
    let args = ["-c", &config(), "--root", ".", "status", "--watch"];
    let mut terminal = PseudoTerminal::wide(nestd(dir.path(), &args), false, 60);
    terminal.until("the farm is shown", |seen| seen.contains("Ctrl-C"));
    let mut shown = terminal.seen.split("Every 2 s").next().unwrap().to_owned();
    for control in ["\x1b[2J", "\x1b[H", "\x1b[K", "\r"] {
        shown = shown.replace(control, "");
    }
    let lines: Vec<&str> = shown.lines().collect();
    assert!(lines.iter().all(|line| line.chars().count() <= 60), "{lines:#?}");
    for output_text in ["NOW: paused by", "@a-desk-in-the-office", "WAITING: 0", "LAST PUBLISHED: -"] {
        assert!(shown.contains(output_text), "{output_text}: {lines:#?}");
    }
}

#[test]
fn a_bar_grows_on_a_terminal_only() {
    let (_, output) = nested(&["--evaluations", "200"]);
    assert_eq!(String::from_utf8(output.stderr).unwrap(), "");
    let (dir, mut args) = parts();
    args.iter_mut().filter(|word| *word == "80x80x120").for_each(|word| *word = "41x41x120".to_owned());
    let args: Vec<&str> = args.iter().map(String::as_str).chain(["--budget", "2s"]).collect();
    let mut terminal = PseudoTerminal::of(nestd(dir.path(), &args), true);
    terminal.until("the bar has grown", |seen| {
        seen.contains("mm high") && seen.contains("[##") && seen.contains(" s left")
    });
    assert!(terminal.child.wait().unwrap().success());
    terminal.until("the line is taken away", |seen| seen.ends_with("\r\x1b[K"));
    assert!(dir.path().join("x.build.3mf").exists());
}
