//! Drops that may not be orders of their own: rows of lists that say no, folders of the past, conflict copies of sync programs,
//! backups, the same part in several formats. Such a part waits for a yes.

use anyhow::Result;
use build_file::MESH_ENDINGS;
use intake::{CopyKind, CopyName};
use jiff::{SignedDuration, Timestamp};
use ledger::{Ledger, Namesake, PartRow, SolidFacts};

/// A part that was built longer ago is not doubled by a file that comes now.
const DOUBLED_WITHIN: SignedDuration = SignedDuration::from_hours(7 * 24);

/// Adds what is in doubt about a file to what is asked about its solids. What a ticket or a row of a list names is wanted.
pub(super) async fn ask_about_doubts(
    ledger: &Ledger,
    part: &PartRow,
    solids: &mut [SolidFacts],
    now: Timestamp,
) -> Result<()> {
    part.warnings.lines().filter_map(intake::read_print_question).for_each(|doubt| add_question(solids, doubt));
    // Only in an order a part takes the place of others.
    if !part.terms.order_name.is_empty() {
        ask_about_places(ledger, part, solids).await?;
    }
    let copy = intake::read_copy_name(&part.name);
    if let (Some(copy), Some(first)) = (&copy, solids.first_mut()) {
        first.copy_of.clone_from(&copy.original);
    }
    let names = names_in_formats(copy.as_ref().map_or(&part.name, |copy| &copy.original));
    if names.is_empty() || ledger.has_ticket(part.id).await? {
        return Ok(());
    }
    let since = now.checked_sub(DOUBLED_WITHIN).unwrap_or(Timestamp::UNIX_EPOCH);
    let namesakes = ledger.namesakes_of_part(part, &names, since).await?;
    let doubt = match copy {
        Some(copy) => copy_doubt(&copy, &namesakes),
        None => match format_doubt(part, &namesakes) {
            Some(doubt) => Some(doubt),
            None => original_doubt(&ledger.copies_of_files(part, &names, since).await?),
        },
    };
    doubt.iter().for_each(|doubt| add_question(solids, doubt));
    Ok(())
}

/// Adds a doubt to what is asked about the solids of a file.
pub(super) fn add_question(solids: &mut [SolidFacts], doubt: &str) {
    solids.iter_mut().for_each(|solid| solid.ask(doubt));
}

/// Asks about a file that took the place of parts, or may be meant to.
async fn ask_about_places(ledger: &Ledger, part: &PartRow, solids: &mut [SolidFacts]) -> Result<()> {
    let replaced = ledger.replaced_without_copies(part.id).await?;
    if !replaced.is_empty() {
        add_question(solids, &place_doubt(&replaced));
    }
    if let Some(moved) = ledger.moved_namesake(part).await? {
        let (id, machine) = (moved.id, moved.machine);
        let doubt = format!("part {id} of this name in its order was moved to {machine}, and it may be a newer one");
        add_question(solids, &doubt);
    }
    Ok(())
}

/// A file that took the place of parts, of which nobody knows how many copies are wanted of it.
fn place_doubt(replaced: &[PartRow]) -> String {
    let parts = replaced.iter().map(|part| format!("{} ({} wanted)", part.id, part.wanted_copies()));
    let parts: Vec<String> = parts.collect();
    format!("it took the place of the parts {}, and nothing says how many are wanted of it", parts.join(", "))
}

/// A name in all formats; none if it is not that of a single part.
fn names_in_formats(name: &str) -> Vec<String> {
    match name.rsplit_once('.') {
        Some((stem, extension)) if MESH_ENDINGS.iter().any(|ending| ending.eq_ignore_ascii_case(extension)) => {
            let as_written = |ending: &str| [format!("{stem}.{ending}"), format!("{stem}.{}", ending.to_uppercase())];
            MESH_ENDINGS.into_iter().flat_map(as_written).collect()
        }
        _ => Vec::new(),
    }
}

/// A copy of a file. One of a file manager is in doubt if its original is ordered too.
fn copy_doubt(copy: &CopyName, namesakes: &[Namesake]) -> Option<String> {
    let known = namesakes.first().map(|known| format!("{} (part {})", known.name, known.id));
    let what = match copy.kind {
        CopyKind::Conflict => "its name says that a sync program found two versions of",
        CopyKind::Backup => "its name is that of a backup of",
        CopyKind::BesideOriginal => return known.map(|known| format!("its name is that of a copy of {known}")),
    };
    Some(format!("{what} {}", known.as_ref().unwrap_or(&copy.original)))
}

/// A file of which a copy came first. What a ticket or a row orders is wanted.
fn original_doubt(copies: &[Namesake]) -> Option<String> {
    let copy = copies.iter().find(|copy| !copy.has_ticket)?;
    Some(format!("{} (part {}) has the name of a copy of it", copy.name, copy.id))
}

/// A part that was dropped before, or is ordered by a ticket, in another format.
fn format_doubt(part: &PartRow, namesakes: &[Namesake]) -> Option<String> {
    let format = |name: &str| name.rsplit_once('.').map(|(_, extension)| extension.to_lowercase());
    let is_first = |known: &&Namesake| known.id < part.id || known.has_ticket;
    let known = namesakes.iter().filter(is_first).find(|known| format(&known.name) != format(&part.name))?;
    Some(format!("it may be {} (part {}) in another format", known.name, known.id))
}

#[cfg(test)]
mod tests {
    use ledger::PartId;

    use super::*;

    #[test]
    fn a_copy_of_a_file_manager_is_in_doubt_only_where_its_original_is_ordered() {
        let known = [Namesake { id: PartId(3), name: "x.stl".to_owned(), has_ticket: false }];
        let copy = |kind| CopyName { original: "x.stl".to_owned(), kind };
        let doubt = copy_doubt(&copy(CopyKind::BesideOriginal), &known);
        assert_eq!(doubt.as_deref(), Some("its name is that of a copy of x.stl (part 3)"));
        assert_eq!(copy_doubt(&copy(CopyKind::BesideOriginal), &[]), None);
        assert!(copy_doubt(&copy(CopyKind::Conflict), &[]).unwrap().contains("two versions of x.stl"));
        assert!(copy_doubt(&copy(CopyKind::Backup), &known).unwrap().contains("backup of x.stl (part 3)"));
    }

    #[test]
    fn only_names_of_single_parts_have_other_formats() {
        assert_eq!(
            names_in_formats("x.v2.Stl"),
            ["x.v2.stl", "x.v2.STL", "x.v2.3mf", "x.v2.3MF", "x.v2.obj", "x.v2.OBJ", "x.v2.ply", "x.v2.PLY"]
        );
        assert!(names_in_formats("kit.camspec").is_empty() && names_in_formats("x").is_empty());
    }
}
