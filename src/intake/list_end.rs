//! How an order list ends. It stays where it is while its files come, each claim takes a copy along; marks in
//! `.claimed/.lists/` say which rows were served, so that a restart does not forget.

use std::{
    ffi::OsStr,
    fs,
    path::{Path, PathBuf},
};

use super::{
    Lists, Ready, RefuseError, Seen, disk, display_name,
    marks::{Marks, age_secs},
    order_list::{OrderList, Row},
    refuse::{io_error, refuse_path},
};

/// Lists that were served lie here in the archive folder.
const ARCHIVE_DIR: &str = "order-lists";
/// What became of an order list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ListEnd {
    /// It stays: files that it names are still to come, or parts of its folder still settle.
    Awaited,
    /// Every row's file was claimed; the list is in the archive, here.
    Archived(PathBuf),
    /// It is in the error folder, with this reason.
    Refused(String),
}

/// Ends the order list of a [`Ready::List`] when its time has come: archives it when all its files were claimed, refuses
/// it when the others did not come for `incomplete_secs` after the last one that did. It stays as long as parts stand beside
/// it that it is for, or that wait because it does not name them. To be called for each [`Ready::List`], after the claims of
/// the same scan.
pub fn end_list(
    inbox: &Path,
    lists: &mut Lists,
    ready: &Ready,
    incomplete_secs: f64,
    archive_dir: &Path,
    error_dir: &Path,
) -> Result<ListEnd, RefuseError> {
    let Ready::List { list, quiet_secs } = ready else { return Ok(ListEnd::Awaited) };
    let standing = lists.standing(inbox, list, incomplete_secs).map_err(|e| io_error("read", &list.path, e))?;
    let (content, marks, is_needed) = standing;
    let idle_secs = quiet_secs.min(age_secs(&marks.dir).unwrap_or(f64::MAX));
    let verdict = match is_needed {
        true => Verdict::Wait,
        false => verdict(content, marks, idle_secs >= incomplete_secs, incomplete_secs),
    };
    let dir = marks.dir.clone();
    let end = match verdict {
        Verdict::Wait => return Ok(ListEnd::Awaited),
        Verdict::Served => ListEnd::Archived(archive(inbox, list, archive_dir)?),
        Verdict::Refuse(reason) => {
            refuse_path(inbox, list, error_dir, &reason)?;
            ListEnd::Refused(reason)
        }
    };
    let _ = fs::remove_dir_all(dir);
    Ok(end)
}

enum Verdict {
    Wait,
    Served,
    Refuse(String),
}

fn verdict(content: &OrderList, marks: &Marks, is_over: bool, incomplete_secs: f64) -> Verdict {
    let rows = match content.rows() {
        Err(why) if is_over => {
            return Verdict::Refuse(format!(
                "This order list cannot be read: {why}. Mend it and drop it again together with its files."
            ));
        }
        Err(_) => return Verdict::Wait,
        Ok(rows) => rows,
    };
    let missing: Vec<&Row> = rows.iter().filter(|r| !r.file.is_empty() && !marks.is_served(&r.file)).collect();
    let nameless = rows.iter().filter(|r| r.file.is_empty()).count();
    match missing[..] {
        [] if !rows.is_empty() && nameless == 0 => Verdict::Served,
        _ if !is_over => Verdict::Wait,
        [] if rows.is_empty() => Verdict::Refuse("This order list names no files.".to_owned()),
        [] => Verdict::Refuse(format!("{nameless} rows of this order list name no file; the others were served.")),
        _ => {
            let names: Vec<String> = missing.iter().map(|r| display_name(OsStr::new(&r.file))).collect();
            Verdict::Refuse(format!(
                "No file came within {incomplete_secs:.0} s for {} of {} rows of this order list: {}. The other rows were \
                 served. Drop these files together with a list for them.",
                names.len(),
                rows.len(),
                names.join(", ")
            ))
        }
    }
}

fn archive(inbox: &Path, list: &Seen, archive_dir: &Path) -> Result<PathBuf, RefuseError> {
    let folder = list.path.parent().and_then(|p| p.strip_prefix(inbox).ok()).unwrap_or(Path::new(""));
    let folder = archive_dir.join(ARCHIVE_DIR).join(folder);
    disk::create_dirs(&folder).map_err(|e| io_error("create", &folder, e))?;
    let name = list.path.file_name().unwrap_or_default();
    disk::move_to_free_name(&list.path, &folder, name).map_err(|e| io_error("move to the archive", &list.path, e))
}

#[cfg(test)]
#[path = "list_end_tests.rs"]
mod tests;
