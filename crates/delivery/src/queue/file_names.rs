//! File names in the queue: a build and its sidecars share a stem. Files with dot-names are not published yet.

use build_file::{DeliveryKind, PLACEMENT_TABLE_ENDING, build_file_stem};

use super::QueueError;

/// Suffixes of the sidecars.
pub(super) const SIDECARS: [&str; 5] = [".report.json", ".parts.csv", ".png", ".stl", PLACEMENT_TABLE_ENDING];
/// End of the dot-name of a file that is complete and fsynced.
pub(super) const STAGED: &str = ".part";
/// End of the dot-name of a file that is still being written.
pub(super) const HALF: &str = ".half";
/// End of the dot-name of a file that was taken back.
pub(super) const MOVING: &str = ".moving";
/// Printers and their file systems need short names.
const MAX_NAME_BYTES: usize = 100;

/// The stem of the name of a build or sidecar: `<utc>_<machine>_<build-id>`, ASCII, no spaces. `None` = not such a
/// name.
pub(super) fn queue_file_stem(name: &str) -> Option<&str> {
    let stem = build_file_stem(name).or_else(|| SIDECARS.iter().find_map(|s| name.strip_suffix(s)))?;
    let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.');
    let is_name = !stem.is_empty() && !stem.starts_with('.') && stem.chars().all(is_plain);
    (is_name && name.len() <= MAX_NAME_BYTES).then_some(stem)
}

/// The stem of a build's name.
pub(super) fn build_stem(name: &str) -> Result<&str, QueueError> {
    queue_file_stem(name)
        .filter(|_| build_file_stem(name).is_some())
        .ok_or_else(|| QueueError::InvalidName(name.to_owned()))
}

/// The names that a build with this stem may have, by the kind that it is delivered as.
pub(super) fn builds_of_stem(stem: &str) -> impl Iterator<Item = String> {
    DeliveryKind::ALL.into_iter().map(move |kind| format!("{stem}{}", kind.ending()))
}

/// The name of the build of which a dot-name holds the build or a sidecar. `None` = a file of another program, which nestd must not remove.
pub(super) fn staged_build_name(dot_name: &str) -> Option<String> {
    let stem = staged_file_stem(dot_name)?;
    let inner = dot_name.strip_prefix('.')?;
    let build = builds_of_stem(stem).find(|build| inner.starts_with(build.as_str()));
    Some(build.unwrap_or_else(|| format!("{stem}{}", DeliveryKind::default().ending())))
}

/// The names of the sidecars of a build, and its own last: the order in which they become visible.
pub(super) fn files_of_build(build_name: &str) -> Result<impl Iterator<Item = String>, QueueError> {
    let stem = build_stem(build_name)?;
    let sidecars = SIDECARS.iter().map(move |suffix| format!("{stem}{suffix}"));
    Ok(sidecars.chain([build_name.to_owned()]))
}

/// The stem of a dot-name that nestd gave. `None` = a file of another program, which nestd must not remove.
pub(super) fn staged_file_stem(name: &str) -> Option<&str> {
    let inner = name.strip_prefix('.')?;
    let inner = inner.strip_suffix(STAGED).or_else(|| inner.strip_suffix(HALF))?;
    let stem = queue_file_stem(inner)?;
    let (time, rest) = stem.split_once('_')?;
    let (machine, id) = rest.rsplit_once('_')?;
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    let (day, clock) = time.strip_suffix('Z')?.split_once('T')?;
    let is_ours = is_number(day) && is_number(clock) && is_number(id) && !machine.is_empty();
    is_ours.then_some(stem)
}

#[cfg(test)]
mod tests {
    use super::*;

    const BUILD_NAME: &str = "20261120T044900Z_mjf-5200_000042.build.3mf";

    #[test]
    fn a_build_and_its_sidecars_share_a_stem() {
        let expected = Some("20261120T044900Z_mjf-5200_000042");
        assert_eq!(queue_file_stem(BUILD_NAME), expected);
        for suffix in SIDECARS {
            assert_eq!(queue_file_stem(&BUILD_NAME.replace(".build.3mf", suffix)), expected);
        }
    }

    #[test]
    fn paths_dot_names_and_long_names_are_no_names() {
        let long = format!("{}.build.3mf", "x".repeat(91));
        for name in ["", ".build.3mf", "a.3mf", "../a.build.3mf", ".a.build.3mf", "a b.build.3mf", "ä.build.3mf", &long]
        {
            assert_eq!(queue_file_stem(name), None, "{name}");
        }
        assert!(build_stem("a.png").is_err());
    }

    #[test]
    fn only_our_own_dot_names_are_known() {
        assert!(staged_file_stem(&format!(".{BUILD_NAME}.part")).is_some());
        assert!(staged_file_stem(".20261120T044900Z_fuse_1_000042.png.half").is_some());
        for name in
            [BUILD_NAME, ".nestd-queue", ".DS_Store", ".x.build.3mf.part", ".20261120T044900Z_p_x.build.3mf.part"]
        {
            assert_eq!(staged_file_stem(name), None, "{name}");
        }
    }
}
