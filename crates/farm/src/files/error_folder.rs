//! A refused part in the error folder: its file, and a reason file beside it.

use std::{
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result};
use language::{Language, say};
use ledger::{PartId, PartRow, RefusalCause};

/// Said to people of a part whose ticket could not be read; it cannot be taken back, for its copies would be guessed.
pub(crate) const ASKED_UNCLEARLY: &str = "It is not certain what is asked with it, so it is not printed";

/// What a reason that names a part tells of it.
struct RefusedEntry {
    reason: PathBuf,
    /// Its file, unchanged; `None` = it is not there, or somebody changed it.
    file: Option<PathBuf>,
    /// Whether nothing else is in the reason's folder.
    is_alone: bool,
}

/// The paths of a refused part's file and its reason in the error folder. Several files may have the same content: the
/// reason that names the part identifies the right one.
pub fn find_refused_files(error_dir: &Path, part: &PartRow) -> Result<Vec<(PathBuf, PathBuf)>> {
    let entries = find_entries(error_dir, part)?.into_iter();
    Ok(entries.filter_map(|entry| Some((entry.file?, entry.reason))).collect())
}

fn find_entries(error_dir: &Path, part: &PartRow) -> Result<Vec<RefusedEntry>> {
    // It may have been written in another language.
    let lines = Language::ALL.map(|language| language.within(|| part_line(part)));
    let names_part = |line_of_reason: &str| lines.iter().any(|line| line_of_reason.starts_with(line.as_str()));
    let files = match intake::files_below(error_dir) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        other => other.with_context(|| format!("listing {}", error_dir.display()))?,
    };
    let mut found = Vec::new();
    for reason in files.iter().filter(|file| intake::is_reason_file(file)) {
        let text = intake::read_reason(reason).with_context(|| format!("reading {}", reason.display()))?;
        if !text.is_some_and(|text| text.lines().any(names_part)) {
            continue;
        }
        // The name without the suffix, unless the name was shortened. A copy that a crash cut short has all its bytes, perhaps,
        // and not its name yet: it must be made again.
        let named = reason.with_extension("").with_extension("");
        let is_beside = |file: &&PathBuf| {
            file.parent() == reason.parent()
                && *file != reason
                && !file.file_name().is_some_and(intake::is_temporary_name)
        };
        let mut entry =
            RefusedEntry { reason: reason.clone(), file: None, is_alone: !files.iter().any(|file| is_beside(&file)) };
        let others = files.iter().filter(is_beside).filter(|file| **file != named);
        for file in [&named].into_iter().chain(others) {
            if has_content(file, part)? {
                entry.file = Some(file.clone());
                break;
            }
        }
        found.push(entry);
    }
    Ok(found)
}

fn has_content(file: &Path, part: &PartRow) -> Result<bool> {
    match fs::symlink_metadata(file) {
        Ok(meta) if !meta.is_file() || meta.len() != part.file.bytes => Ok(false),
        Ok(_) => {
            let hash = intake::hash_file(file).with_context(|| format!("reading {}", file.display()))?;
            Ok(hash == part.file.content_hash)
        }
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error).with_context(|| format!("looking at {}", file.display())),
    }
}

/// Removes a refused file and its reason from the error folder, if the file is unchanged; also a reason that lies alone in
/// the folder that was made for it.
pub fn remove_refused_files(error_dir: &Path, part: &PartRow) -> Result<()> {
    for RefusedEntry { reason, file, is_alone } in find_entries(error_dir, part)? {
        let own_folder = reason.parent().filter(|folder| *folder != error_dir);
        if file.is_none() && !(is_alone && own_folder.is_some()) {
            continue;
        }
        for gone in file.iter().chain([&reason]) {
            fs::remove_file(gone).with_context(|| format!("removing {}", gone.display()))?;
        }
        if let Some(folder) = own_folder {
            // Fails if the folder is not empty.
            let _ = fs::remove_dir(folder);
        }
    }
    Ok(())
}

/// Start of the line in the reason that names the part.
pub fn part_line(part: &PartRow) -> String {
    say!("reason-part", part = part.id.to_string(), machine = &part.machine)
}

/// The part of a machine that the text of a reason names; `None` = the file was refused before it became a part.
pub(super) fn find_part_number(text: &str, machine: &str) -> Option<PartId> {
    const NUMBER: &str = "\u{0}";
    let lines = Language::ALL.map(|language| language.within(|| say!("reason-part", part = NUMBER, machine = machine)));
    // An earlier version called a machine by its profile.
    let earlier = format!("Part {NUMBER} of the profile {machine}.");
    let ends: Vec<(&str, &str)> = lines.iter().chain([&earlier]).filter_map(|line| line.split_once(NUMBER)).collect();
    let number =
        |line: &str| ends.iter().find_map(|(start, end)| line.strip_prefix(start)?.split_once(end)?.0.parse().ok());
    text.lines().find_map(number).map(PartId)
}

/// The complete text of a reason file, in the language that is current.
pub(crate) fn reason_text(part: &PartRow, cause: Option<RefusalCause>, reason: &str) -> String {
    let again = match cause {
        // Its copies would be guessed; and the same bytes are no other format the next time.
        Some(RefusalCause::Ticket | RefusalCause::Format | RefusalCause::Document) => String::new(),
        _ => format!(" {}", say!("reason-retry", part = part.id.to_string())),
    };
    format!("{}\n\n{}{again}\n", RefusalCause::introduce(cause, reason.trim_end()), part_line(part))
}
