//! The doors that hostile bytes come in by, one per fuzz target. Shared by the fuzz targets in `fuzz/`, the replay of the
//! corpus and the reliability run. Each entry panics when a reader does, and when what a reader lets in breaks a promise.

use std::{
    cell::RefCell,
    ffi::OsStr,
    fs::{self, File},
    io::{Seek, SeekFrom, Write},
    os::{fd::AsRawFd, unix::ffi::OsStrExt},
    path::{Path, PathBuf},
};

use build_file::{Contents, Limits, ReadError, Unit, has_end, read, read_build};
use nestd::{
    intake::{OrderList, Ticket, copies_in_name, display_name, raw_name},
    ledger::Tilts,
    settings,
};
use nester::Orientation;

/// A fuzz target: its name, which is also its corpus' folder, and its entry.
pub type Target = (&'static str, fn(&[u8]));

/// All of them.
pub const TARGETS: [Target; 9] = [
    ("stl_binary", stl_binary),
    ("stl_ascii", stl_ascii),
    ("threemf_zip", threemf_zip),
    ("threemf_xml", threemf_xml),
    ("ticket_toml", ticket_toml),
    ("ticket_json", ticket_json),
    ("order_csv", order_csv),
    ("configuration", configuration),
    ("names", names),
];

/// Between farm file and machine file in one input of [`configuration`].
const CUT: &[u8] = b"\n# machine\n";
/// The farm file where the input is a machine file only.
const FARM: &[u8] = b"scan_secs = 1\n";

thread_local! {
    /// A file that is in memory only.
    static SCRATCH: RefCell<File> =
        RefCell::new(rustix::fs::memfd_create("nestd-fuzz", rustix::fs::MemfdFlags::CLOEXEC).unwrap().into());
    static FOLDER: tempfile::TempDir = folder();
}

fn folder() -> tempfile::TempDir {
    let memory = Path::new("/dev/shm");
    let dir = if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() }.unwrap();
    fs::create_dir(dir.path().join("profiles")).unwrap();
    dir
}

/// The bytes as a file.
fn with_file<T>(bytes: &[u8], use_it: impl FnOnce(&Path) -> T) -> T {
    SCRATCH.with_borrow_mut(|file| {
        file.set_len(0).unwrap();
        file.seek(SeekFrom::Start(0)).unwrap();
        file.write_all(bytes).unwrap();
        use_it(&PathBuf::from(format!("/proc/self/fd/{}", file.as_raw_fd())))
    })
}

/// Reads as the farm does; what it lets in keeps the limits and is made of finite numbers.
fn read_part(file: &Path, name: &str) -> Result<Contents, ReadError> {
    let limits = Limits::for_testing();
    let _ = has_end(&mut File::open(file).unwrap(), name).unwrap();
    let result = read(file, name, None, Unit::Millimeter, &limits);
    match &result {
        Ok(contents) => {
            assert!(!contents.solids.is_empty());
            let triangles: usize = contents.solids.iter().map(|s| s.mesh.triangles().len()).sum();
            assert!(triangles as u64 <= limits.max_triangles, "{triangles} triangles");
            for solid in &contents.solids {
                assert!(solid.copies > 0 && u64::from(solid.copies) <= limits.max_instances);
                assert!(solid.mesh.volume_mm3() > 0.0 && solid.mesh.volume_mm3().is_finite());
                assert!(solid.mesh.vertices().iter().all(|v| v.is_finite()));
            }
        }
        Err(error) => assert!(!error.is_io(), "{error:?} blames the disk"),
    }
    result
}

/// The bytes as they are, and as facets under a header that tells their number.
pub fn stl_binary(bytes: &[u8]) {
    let _ = with_file(bytes, |file| read_part(file, "a.stl"));
    let mut framed = b"solid or not".to_vec();
    framed.resize(80, b' ');
    framed.extend((bytes.len() as u32 / 50).to_le_bytes());
    framed.extend(bytes);
    let _ = with_file(&framed, |file| read_part(file, "a.stl"));
}

/// The bytes as text that calls itself a solid.
pub fn stl_ascii(bytes: &[u8]) {
    let text = [b"solid ".as_slice(), bytes].concat();
    let _ = with_file(&text, |file| read_part(file, "a.stl"));
}

/// The bytes as a package.
pub fn threemf_zip(bytes: &[u8]) {
    with_file(bytes, |file| {
        let _ = read_part(file, "a.3mf");
        let _ = read_build(file, &Limits::for_testing());
    });
}

/// The bytes as the model of a sound package.
pub fn threemf_xml(bytes: &[u8]) {
    let entries = [("_rels/.rels", super::samples::RELATIONSHIPS.as_bytes()), ("3D/3dmodel.model", bytes)];
    threemf_zip(&super::samples::package(&entries, zip::CompressionMethod::Stored));
}

/// Whatever a ticket may say can be kept in the ledger and is the same when it comes back.
fn ticket_is_kept(ticket: Ticket) {
    if let Some(due) = ticket.due
        && let Ok(at) = due.at(&jiff::tz::TimeZone::UTC)
    {
        let text = nestd::ledger::Utc(at).to_string();
        assert!(text.parse::<jiff::Timestamp>().is_ok(), "{text}");
    }
    assert!(ticket.copies.is_none_or(|n| (1..=10_000).contains(&n)));
    assert!(ticket.clearance_mm.is_none_or(|mm| (0.0..=100.0).contains(&mm)));
    let turning = Orientation::new(
        ticket.orientation.unwrap_or_default(),
        ticket.keep_up.as_deref().unwrap_or_default(),
        ticket.not_down.as_deref().unwrap_or_default(),
    );
    let kept = Tilts(turning.tilts).to_string();
    let back = Tilts::try_from(kept.clone()).unwrap_or_else(|error| panic!("{kept:?}: {error}"));
    assert_eq!(back.0.len(), kept.split(';').filter(|one| !one.is_empty()).count());
}

/// The bytes as a sidecar in TOML.
pub fn ticket_toml(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if let Ok(ticket) = Ticket::from_toml(text, "a.stl.toml") {
        ticket_is_kept(ticket);
    }
}

/// The bytes as a sidecar in JSON.
pub fn ticket_json(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if let Ok(ticket) = Ticket::from_json(text, "a.stl.json") {
        ticket_is_kept(ticket);
    }
}

/// The bytes as an order list, asked for each file that it names and for one that it may not.
pub fn order_csv(bytes: &[u8]) {
    let list = OrderList::parse(bytes);
    let _ = list.row_for(OsStr::new("a.stl"));
    for row in list.rows().unwrap_or_default().iter().take(50) {
        let found = list.row_for(OsStr::new(&row.file));
        if let Ok(Some(row)) = found {
            ticket_is_kept(row.ticket.clone().expect("a row that is found makes sense"));
        }
    }
}

/// The bytes as a farm file and a machine file.
pub fn configuration(bytes: &[u8]) {
    let cut = bytes.windows(CUT.len()).position(|window| window == CUT);
    let (farm, machine) = cut.map_or((FARM, bytes), |at| (&bytes[..at], &bytes[at + CUT.len()..]));
    FOLDER.with(|folder| {
        let file = folder.path().join("nestd.toml");
        fs::write(&file, farm).unwrap();
        fs::write(folder.path().join("profiles/m.toml"), machine).unwrap();
        match settings::load(Some(&file), Some(Path::new("/farm"))) {
            Ok(settings) => assert_eq!(settings.profiles.len(), 1),
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    });
}

/// The bytes as the name of a file.
pub fn names(bytes: &[u8]) {
    let name = OsStr::from_bytes(bytes);
    let shown = display_name(name);
    assert_eq!(raw_name(&shown).as_deref(), Some(name), "{shown:?}");
    assert!(!shown.chars().any(char::is_control), "{shown:?}");
    let _ = copies_in_name(&shown);
    if let Ok(text) = std::str::from_utf8(bytes) {
        let _ = (raw_name(text), copies_in_name(text));
    }
}
