//! Names of files: the endings of those that hold parts, and the name of a build file, `<utc>_<machine>_<build-id>.build.3mf`.

use crate::DeliveryKind;

/// Endings of files that hold one part, or a plate of one customer, in lower case.
pub const MESH_ENDINGS: [&str; 4] = ["stl", "3mf", "obj", "ply"];
/// The ending of a package of models with what is asked of each.
pub(crate) const CAMSPEC_ENDING: &str = "camspec";

/// What people are told to export from a CAD program.
macro_rules! cad_formats {
    () => {
        "STL or 3MF"
    };
}
pub(crate) use cad_formats;
/// What people are told to drop: the formats of [`MESH_ENDINGS`] in words.
pub const MESH_FORMATS: &str = "STL, 3MF, OBJ or PLY";

/// The endings of all files that hold parts, in lower case.
pub fn part_endings() -> impl Iterator<Item = &'static str> {
    MESH_ENDINGS.into_iter().chain([CAMSPEC_ENDING])
}

/// Whether a file with this name holds parts, by its ending in any case.
pub(crate) fn is_part_name(name: &str) -> bool {
    name.rsplit_once('.').is_some_and(|(_, end)| part_endings().any(|ending| end.eq_ignore_ascii_case(ending)))
}

/// `20261120T044900Z_mjf-5200_000042.build.3mf`: ASCII, sortable, no spaces, at most 100 characters. Core 1.4 reserves the
/// double suffix for a complete plate; the other kinds of files have it, too. Sidecars share the stem.
pub fn build_file_name(created_utc: jiff::Timestamp, machine: &str, build_id: u64, kind: DeliveryKind) -> String {
    let machine: String = (machine.chars().take(50))
        .map(|c| if c.is_ascii_alphanumeric() || c == '-' || c == '.' { c } else { '-' })
        .collect();
    format!("{}_{machine}_{build_id:06}{}", created_utc.strftime("%Y%m%dT%H%M%SZ"), kind.ending())
}

/// What the name of a build file, of any kind, begins with: the name without its ending. `None` = it is none.
pub fn build_file_stem(name: &str) -> Option<&str> {
    DeliveryKind::ALL.iter().find_map(|kind| name.strip_suffix(kind.ending()))
}

/// The name of the table of places beside a whole build as STL, by the stem of its name.
pub fn placement_table_name(stem: &str) -> String {
    format!("{stem}{PLACEMENT_TABLE_ENDING}")
}

/// The ending of the name of that table.
pub const PLACEMENT_TABLE_ENDING: &str = ".placements.csv";
