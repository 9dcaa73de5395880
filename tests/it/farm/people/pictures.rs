//! Pictures of builds: of an open build, of a published one, and of one that the printer has taken.

use std::{
    fs,
    io::{Read, Write},
    os::unix::{fs::PermissionsExt, net::UnixStream},
    path::Path,
    time::{Duration, Instant},
};

use ledger::PartState;

use crate::support::{QUICK, TestFarm, block, wait_until};

/// Width and height of a PNG, and its bytes.
fn png(file: &Path) -> (u32, u32, Vec<u8>) {
    let bytes = fs::read(file).unwrap();
    assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
    let number = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
    (number(16), number(20), bytes)
}

/// (exit code, standard error).
fn failed(farm: &TestFarm, args: &[&str]) -> (Option<i32>, String) {
    let output = farm.nestd(args);
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

/// The head and the body of a response of the dashboard.
fn get(farm: &TestFarm, path: &str) -> (String, Vec<u8>) {
    let mut stream = UnixStream::connect(farm.root().join("web.sock")).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n").unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    let end = answer.windows(4).position(|four| four == b"\r\n\r\n").unwrap();
    (String::from_utf8(answer[..end].to_vec()).unwrap(), answer[end + 4..].to_vec())
}

#[test]
fn a_build_is_drawn_while_it_is_open_in_the_queue_and_when_the_printer_has_taken_it() {
    let farm = TestFarm::running(QUICK);
    let folder = farm.root().to_owned();
    assert_eq!(failed(&farm, &["render", "77"]).0, Some(1));
    farm.drop_part("order-9/a_x3.stl", &block(40.0, 30.0, 20.0));
    farm.drop_part("b.stl", &block(30.0, 30.0, 60.0));
    farm.wait_for_parts(PartState::Waiting, 2);
    let open = || farm.nestd(&["render", "1", "--size", "320x240", "-o", "open.png"]).status.success();
    wait_until("the open build can be drawn", 30.0, open);
    assert_eq!((png(&folder.join("open.png")).0, png(&folder.join("open.png")).1), (320, 240));
    farm.flush();
    let file = farm.wait_for_queued(1).remove(0);
    let stem = file.file_name().unwrap().to_string_lossy().replace(".build.3mf", "");
    for (words, name) in [
        (vec!["1"], "number"),
        (vec!["build", "b1"], "words"),
        (vec![stem.as_str()], "stem"),
        (vec!["order-9"], "order"),
        (vec!["b.stl"], "part"),
        (vec![file.to_str().unwrap()], "file"),
    ] {
        let target = format!("{name}.png");
        let args = [vec!["render"], words, vec!["-o", &target]].concat();
        assert_eq!(farm.nestd_ok(&args), format!("{target}\n"));
        assert_eq!(png(&folder.join(&target)).2, png(&folder.join("number.png")).2, "{name}");
    }
    farm.nestd_ok(&["report", "1", "-o", "queue.html"]);
    fs::remove_file(&file).unwrap();
    farm.wait_for_parts(PartState::Built, 2);
    farm.nestd_ok(&["render", "1", "-o", "archive.png"]);
    let (width, height, bytes) = png(&folder.join("archive.png"));
    assert_eq!((width, height), (1024, 768));
    assert!(bytes.len() > 5000, "{} bytes: nothing is drawn", bytes.len());
    let report = fs::read_to_string(folder.join("queue.html")).unwrap();
    assert!(report.contains("a_x3.stl") && report.contains("mm proved on the triangles") && report.contains("order-9"));
    fs::remove_dir_all(farm.folder("archive").join(&stem)).unwrap();
    let (code, stderr) = failed(&farm, &["render", "1"]);
    assert!(code == Some(1) && stderr.contains("no longer kept") && stderr.contains("build file"), "{code:?} {stderr}");
}

#[test]
fn the_row_of_a_machine_shows_its_build_and_a_look_leaves_the_store_alone() {
    let mut farm = TestFarm::new(QUICK);
    let socket = farm.root().join("web.sock");
    let mut config = fs::read_to_string(farm.config()).unwrap();
    config += &format!("[web]\nlisten = \"unix:{}\"\n", socket.display());
    fs::write(farm.config(), config).unwrap();
    farm.start();
    wait_until("the dashboard listens", 20.0, || UnixStream::connect(&socket).is_ok());
    let page = || String::from_utf8(get(&farm, "/").1).unwrap();
    assert!(!page().contains("<img"), "there is nothing to show yet");
    farm.drop_part("a_x2.stl", &block(40.0, 30.0, 20.0));
    wait_until("the row shows the open build", 30.0, || page().contains("src=\"/builds/1/picture?width="));
    // A request must not remove a file that the daemon is just putting into the store.
    let putting = farm.root().join("state/store/tmp-test");
    fs::write(&putting, "half").unwrap();
    let text = page();
    let source = text.split("<img").nth(1).unwrap().split("src=\"").nth(1).unwrap().split('"').next().unwrap();
    let asked = source.replace("&amp;", "&");
    let began = Instant::now();
    let (head, picture) = get(&farm, &asked);
    let first = began.elapsed();
    assert!(head.starts_with("HTTP/1.1 200") && head.contains("image/png") && head.contains("immutable"), "{head}");
    assert!(picture.starts_with(b"\x89PNG") && picture.len() > 500);
    assert_eq!(get(&farm, &asked).1, picture);
    assert!(first < Duration::from_secs(20), "{first:?}");
    assert!(get(&farm, "/builds/1/picture?width=480&of=other").0.contains("no-cache"));
    assert!(get(&farm, "/builds/99/picture").0.starts_with("HTTP/1.1 404"));
    assert_eq!(get(&farm, "/builds/1/scene").0.get(..12), Some("HTTP/1.1 200"));
    assert!(putting.exists());
    farm.flush();
    farm.wait_for_queued(1);
    wait_until("the row shows the queued build", 60.0, || {
        page().contains("src=\"/builds/1/picture?width=") && page().contains("Build 1 on")
    });
    assert_eq!(fs::metadata(&putting).unwrap().permissions().mode() & 0o400, 0o400);
}
