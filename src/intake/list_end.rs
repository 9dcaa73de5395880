//! How an order list ends. It stays where it is while its files come, each claim takes a copy along; marks in
//! `.claimed/.lists/` say which rows were served, so that a restart does not forget.

use std::{
    collections::HashMap,
    ffi::{OsStr, OsString},
    fs,
    io::{self, Write},
    os::unix::ffi::{OsStrExt, OsStringExt},
    path::{Path, PathBuf},
    time::Duration,
};

use super::{
    Lists, Ready, RefuseError, Seen,
    claim::CLAIMED_DIR,
    disk, display_name,
    order_list::{OrderList, Row},
    refuse::{io_error, refuse_path},
};

/// Lists that were served lie here in the archive folder.
const ARCHIVE_DIR: &str = "order-lists";
/// Marks of lists that somebody deleted go after so long.
const STALE_MARKS: Duration = Duration::from_secs(7 * 24 * 3600);

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

/// Notes on disk that a row of a list was served, and by which file. Before the claim is whole: a part that is still there
/// counts anyway.
pub(super) fn mark_served(inbox: &Path, list: &Seen, row_file: &str, name: &OsStr) -> io::Result<()> {
    let marks = marks_dir(inbox, list);
    let below = marks.strip_prefix(inbox).unwrap_or(&marks);
    disk::create_dirs_beneath(inbox, below)?;
    let mut file = disk::create_anew(&marks.join(mark(row_file)))?;
    file.write_all(name.as_bytes())?;
    file.sync_all()?;
    disk::fsync_dir(&marks)
}

/// Which rows of a list were served, as the marks say.
#[derive(Debug)]
pub(super) struct Marks {
    dir: PathBuf,
    /// The file that served a row, by the row's mark.
    served: HashMap<String, OsString>,
}

impl Marks {
    /// Those on the disk; none that can be read are none.
    pub fn load(inbox: &Path, list: &Seen) -> Self {
        let dir = marks_dir(inbox, list);
        let entries = fs::read_dir(&dir).into_iter().flatten().flatten();
        let mark = |entry: fs::DirEntry| {
            let bytes = disk::read_start(&entry.path(), disk::MAX_NAME_BYTES as u64).ok()??;
            Some((entry.file_name().into_string().ok()?, OsString::from_vec(bytes)))
        };
        let served = entries.filter_map(mark).collect();
        Self { dir, served }
    }

    /// Whether those on the disk are as many.
    pub fn are_all(&self) -> bool {
        fs::read_dir(&self.dir).map_or(0, Iterator::count) == self.served.len()
    }

    /// One more, that is on the disk already.
    pub fn add(&mut self, row_file: &str, name: &OsStr) {
        self.served.insert(mark(row_file), name.to_owned());
    }

    /// Whether a row was served.
    pub fn is_served(&self, row_file: &str) -> bool {
        self.served.contains_key(&mark(row_file))
    }

    /// The files that served a row.
    pub fn files(&self) -> impl Iterator<Item = &OsString> {
        self.served.values().filter(|name| !name.is_empty())
    }

    /// When a row was last served.
    pub fn last_ns(&self) -> Option<i128> {
        fs::metadata(&self.dir).ok().map(|meta| disk::mtime_ns(&meta))
    }
}

/// Removes marks of lists, and notes of parts that were given back, that are long gone.
pub(super) fn sweep_marks(inbox: &Path) {
    for folder in [".lists", ".given"].map(|name| inbox.join(CLAIMED_DIR).join(name)) {
        if fs::symlink_metadata(&folder).is_ok_and(|meta| !meta.is_dir()) {
            continue;
        }
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            if age_secs(&entry.path()).is_some_and(|age| age > STALE_MARKS.as_secs_f64()) {
                let _ = fs::remove_dir_all(entry.path()).or_else(|_| fs::remove_file(entry.path()));
            }
        }
    }
}

/// Inode and ctime tell this list from a later one of the same text, whose rows nobody served yet.
fn marks_dir(inbox: &Path, list: &Seen) -> PathBuf {
    inbox.join(CLAIMED_DIR).join(".lists").join(format!("{}-{}", list.inode, list.ctime_ns))
}

fn mark(file: &str) -> String {
    blake3::hash(file.as_bytes()).to_hex()[..32].to_owned()
}

fn age_secs(path: &Path) -> Option<f64> {
    let meta = fs::metadata(path).ok()?;
    Some(meta.modified().ok()?.elapsed().unwrap_or_default().as_secs_f64())
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
