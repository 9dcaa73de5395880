//! The entry points for hostile input, one per fuzz target. The fuzz targets in `fuzz/`, the replay of the corpus and
//! the reliability run share them. An entry panics when a reader panics, and when a reader accepts input that it must
//! not accept.

use std::{
    cell::RefCell,
    ffi::OsStr,
    fs::{self, File},
    io::{Seek, SeekFrom, Write},
    os::{fd::AsRawFd, unix::ffi::OsStrExt},
    path::{Path, PathBuf},
};

use build_file::{FileReadError, LengthUnit, PartFileContents, ReadLimits, has_end, read_build, read_part_file};
use intake::{OrderList, Ticket, copies_in_name, display_name, raw_name};
use ledger::RequiredTilts;
use nester::OrientationLimits;

/// A fuzz target: its name, which is also its corpus' folder, and its entry.
pub type FuzzTarget = (&'static str, fn(&[u8]));

/// All fuzz targets.
pub const TARGETS: [FuzzTarget; 11] = [
    ("stl_binary", stl_binary),
    ("stl_ascii", stl_ascii),
    ("obj", obj),
    ("ply", ply),
    ("threemf_zip", threemf_zip),
    ("threemf_xml", threemf_xml),
    ("ticket_toml", ticket_toml),
    ("ticket_json", ticket_json),
    ("order_csv", order_csv),
    ("configuration", configuration),
    ("names", names),
];

/// Separates farm file and machine file in an input of [`configuration`].
const SEPARATOR: &[u8] = b"\n# machine\n";
/// The farm file for an input that is only a machine file.
const DEFAULT_FARM_FILE: &[u8] = b"scan_secs = 1\n";

thread_local! {
    /// A file in memory.
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

/// Writes the bytes to a file and passes its path on.
fn with_file<T>(bytes: &[u8], use_it: impl FnOnce(&Path) -> T) -> T {
    SCRATCH.with_borrow_mut(|file| {
        file.set_len(0).unwrap();
        file.seek(SeekFrom::Start(0)).unwrap();
        file.write_all(bytes).unwrap();
        use_it(&PathBuf::from(format!("/proc/self/fd/{}", file.as_raw_fd())))
    })
}

/// Reads as the farm does, and asserts that accepted contents keep the limits and have finite numbers only.
fn read_part(file: &Path, name: &str) -> Result<PartFileContents, FileReadError> {
    let limits = ReadLimits::for_testing();
    let _ = has_end(&mut File::open(file).unwrap(), name).unwrap();
    let result = read_part_file(file, name, None, LengthUnit::Millimeter, &limits);
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

/// Reads the bytes as they are, and as facets under a header with the right count.
pub fn stl_binary(bytes: &[u8]) {
    let _ = with_file(bytes, |file| read_part(file, "a.stl"));
    let mut framed = b"solid or not".to_vec();
    framed.resize(80, b' ');
    framed.extend((bytes.len() as u32 / 50).to_le_bytes());
    framed.extend(bytes);
    let _ = with_file(&framed, |file| read_part(file, "a.stl"));
}

/// Reads the bytes as text of an OBJ file.
pub fn obj(bytes: &[u8]) {
    let _ = with_file(bytes, |file| read_part(file, "a.obj"));
}

/// Reads the bytes as they follow the first line of a PLY file.
pub fn ply(bytes: &[u8]) {
    let _ = with_file(&[b"ply\n".as_slice(), bytes].concat(), |file| read_part(file, "a.ply"));
}

/// Reads the bytes as text that begins with `solid`.
pub fn stl_ascii(bytes: &[u8]) {
    let text = [b"solid ".as_slice(), bytes].concat();
    let _ = with_file(&text, |file| read_part(file, "a.stl"));
}

/// Reads the bytes as a ZIP package.
pub fn threemf_zip(bytes: &[u8]) {
    with_file(bytes, |file| {
        let _ = read_part(file, "a.3mf");
        let _ = read_build(file, &ReadLimits::for_testing());
    });
}

/// Reads the bytes as the model of a valid package.
pub fn threemf_xml(bytes: &[u8]) {
    let entries = [("_rels/.rels", super::samples::RELATIONSHIPS.as_bytes()), ("3D/3dmodel.model", bytes)];
    threemf_zip(&super::samples::package(&entries, zip::CompressionMethod::Stored));
}

/// Asserts that the values of a ticket can be stored in the ledger and read back unchanged.
fn ticket_is_kept(ticket: Ticket) {
    if let Some(due) = ticket.due
        && let Ok(at) = due.to_timestamp(&jiff::tz::TimeZone::UTC)
    {
        let text = ledger::UtcTimestamp(at).to_string();
        assert!(text.parse::<jiff::Timestamp>().is_ok(), "{text}");
    }
    assert!(ticket.copies.is_none_or(|n| (1..=10_000).contains(&n)));
    assert!(ticket.clearance_mm.is_none_or(|mm| (0.0..=100.0).contains(&mm)));
    let turning = OrientationLimits::new(
        ticket.orientation.unwrap_or_default(),
        ticket.keep_up.as_deref().unwrap_or_default(),
        ticket.not_down.as_deref().unwrap_or_default(),
    );
    let kept = RequiredTilts(turning.tilts).to_string();
    let back = RequiredTilts::try_from(kept.clone()).unwrap_or_else(|error| panic!("{kept:?}: {error}"));
    assert_eq!(back.0.len(), kept.split(';').filter(|one| !one.is_empty()).count());
}

/// Reads the bytes as a ticket in TOML.
pub fn ticket_toml(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if let Ok(ticket) = Ticket::from_toml(text, "a.stl.toml") {
        ticket_is_kept(ticket);
    }
}

/// Reads the bytes as a ticket in JSON.
pub fn ticket_json(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if let Ok(ticket) = Ticket::from_json(text, "a.stl.json") {
        ticket_is_kept(ticket);
    }
}

/// Reads the bytes as an order list, and looks up each file that it names and one that it may not name.
pub fn order_csv(bytes: &[u8]) {
    let list = OrderList::parse_list(bytes);
    let _ = list.row_for_file(OsStr::new("a.stl"));
    for row in list.rows().unwrap_or_default().iter().take(50) {
        let found = list.row_for_file(OsStr::new(&row.file));
        if let Ok(Some(row)) = found {
            ticket_is_kept(row.ticket.clone().expect("a row that is found makes sense"));
        }
    }
}

/// Reads the bytes as a farm file and a machine file.
pub fn configuration(bytes: &[u8]) {
    let cut = bytes.windows(SEPARATOR.len()).position(|window| window == SEPARATOR);
    let (farm, machine) = cut.map_or((DEFAULT_FARM_FILE, bytes), |at| (&bytes[..at], &bytes[at + SEPARATOR.len()..]));
    FOLDER.with(|folder| {
        let file = folder.path().join("nestd.toml");
        fs::write(&file, farm).unwrap();
        fs::write(folder.path().join("profiles/m.toml"), machine).unwrap();
        match settings::load_settings(Some(&file), Some(Path::new("/farm"))) {
            Ok(settings) => assert_eq!(settings.profiles.len(), 1),
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    });
}

/// Uses the bytes as the name of a file.
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
