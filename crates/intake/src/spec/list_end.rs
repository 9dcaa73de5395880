//! What finally becomes of an order list. The list stays in place while its files arrive, and each claim takes its row
//! along. Marks in `.claimed/.lists/` record which rows were served, so the state survives a restart.

use std::{
    ffi::OsStr,
    fs,
    path::{Path, PathBuf},
};

use super::list_tracker::ListProgress;
use crate::{
    OrderListTracker, RefuseError, SettledEntry,
    claim::{
        archive::archive_entry,
        refuse::{io_error, refuse_entry},
    },
    display_name,
    lists::{
        order_list::{OrderList, OrderListRow},
        served_rows::ServedRows,
    },
};

/// Sub-folder of the archive for lists whose rows were all served.
const ARCHIVE_DIR: &str = "order-lists";
/// What became of an order list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ListOutcome {
    /// The list stays: files that it names are still missing, or parts of its folder have not settled.
    Awaited,
    /// The file of every row was claimed. The list was moved to this path in the archive.
    Archived(PathBuf),
    /// The list was moved to the error folder with this reason.
    Refused(String),
}

/// Finishes the order list of a [`SettledEntry::List`]. If all its files were claimed, the list is archived. If the missing
/// files did not arrive within `incomplete_secs` after the last one that did, it is refused. The list stays while its
/// folder holds parts that it names, or parts that wait because it does not name them. Call this for each
/// [`SettledEntry::List`], after the claims of the same scan.
pub fn finish_order_list(
    inbox: &Path,
    lists: &mut OrderListTracker,
    ready: &SettledEntry,
    incomplete_secs: f64,
    archive_dir: &Path,
    error_dir: &Path,
) -> Result<ListOutcome, RefuseError> {
    let SettledEntry::List { list, quiet_secs } = ready else { return Ok(ListOutcome::Awaited) };
    let standing = lists.list_progress(inbox, list, incomplete_secs).map_err(|e| io_error("read", &list.path, e))?;
    let ListProgress { content, marks, is_needed, idle_secs } = standing;
    let idle_secs = quiet_secs.min(idle_secs);
    let verdict = match is_needed {
        true => ListDecision::Wait,
        false => decide_list_outcome(content, marks, idle_secs >= incomplete_secs, incomplete_secs, &list.order),
    };
    let dir = marks.dir.clone();
    let end = match verdict {
        ListDecision::Wait => return Ok(ListOutcome::Awaited),
        ListDecision::Served => ListOutcome::Archived(archive_entry(inbox, list, archive_dir, ARCHIVE_DIR)?),
        ListDecision::Refuse(reason) => {
            refuse_entry(inbox, list, error_dir, &reason)?;
            ListOutcome::Refused(reason)
        }
    };
    let _ = fs::remove_dir_all(dir);
    Ok(end)
}

enum ListDecision {
    Wait,
    Served,
    Refuse(String),
}

fn decide_list_outcome(
    content: &OrderList,
    marks: &ServedRows,
    is_over: bool,
    incomplete_secs: f64,
    order: &str,
) -> ListDecision {
    let rows = match content.rows() {
        Err(why) if is_over => {
            return ListDecision::Refuse(format!(
                "This order list cannot be read: {why}. Correct it and drop it again together with its files."
            ));
        }
        Err(_) => return ListDecision::Wait,
        Ok(rows) => rows,
    };
    let missing: Vec<&OrderListRow> = rows.iter().filter(|r| !r.file.is_empty() && !marks.is_served(&r.file)).collect();
    let unused: Vec<String> =
        rows.iter().filter(|r| marks.is_unused(&r.file)).map(|r| display_name(OsStr::new(&r.file))).collect();
    let unused = match unused.is_empty() {
        true => String::new(),
        false => format!(
            " {} could not be used for the parts that they name, which were refused or are asked about: {}. Where a part was \
             refused, mend its row and drop this list and that part again.",
            build_file::format_count(unused.len(), "row", "rows"),
            unused.join(", ")
        ),
    };
    let nameless = rows.iter().filter(|r| r.file.is_empty()).count();
    let is_good = |row: &&OrderListRow| marks.is_served(&row.file) && !marks.is_unused(&row.file);
    let has_served = rows.iter().any(|row| is_good(&row));
    let others = if has_served { " The other rows were served." } else { "" };
    match missing[..] {
        [] if !rows.is_empty() && nameless == 0 && unused.is_empty() => ListDecision::Served,
        [] if nameless == 0 && !unused.is_empty() => {
            ListDecision::Refuse(format!("Of this order list{unused}{others}"))
        }
        _ if !is_over => ListDecision::Wait,
        [] if rows.is_empty() => ListDecision::Refuse("This order list names no files.".to_owned()),
        [] => ListDecision::Refuse(format!("{nameless} rows of this order list name no file.{others}{unused}")),
        _ => {
            let names: Vec<String> = missing.iter().map(|r| display_name(OsStr::new(&r.file))).collect();
            // A file that never came is a refused part of its order, which the file replaces.
            let has_other_orders =
                missing.iter().any(|row| row.ticket.as_ref().is_ok_and(|ticket| ticket.order.is_some()));
            let remedy = match order {
                _ if has_other_orders => "Drop these files together with a list for them.".to_owned(),
                "" => "Drop these files together with a list for them.".to_owned(),
                order => format!("Drop these files into {order}: each is taken as its row says."),
            };
            ListDecision::Refuse(format!(
                "No file came within {incomplete_secs:.0} s for {} of {} rows of this order list: {}.{others} {remedy}{unused}",
                names.len(),
                rows.len(),
                names.join(", ")
            ))
        }
    }
}

#[cfg(test)]
#[path = "tests/list_end_tests.rs"]
mod tests;
