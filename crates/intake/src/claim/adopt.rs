//! Who owns a claim, and how another farm takes it over. The folder of a claim is `.claimed/<id>@<farm>`. A folder
//! without a farm was made by an earlier release and counts as our own. A claim has exactly one name at a time. So if
//! one farm releases it while another takes it over, exactly one of the two renames succeeds.

use std::{collections::HashSet, fs, io, path::Path};

use crate::folder::{
    claim_folder::{
        ADOPTED_PREFIX, CLAIMED_DIR, REMOVED_PREFIX, UNFINISHED_PREFIX, claim_folder_name, is_foreign_claim,
        list_claim_folders, lock_claims, parse_folder_name, takeover_trace_path,
    },
    disk,
};

/// Folder names of the claims in `.claimed/` that belong to other farms and may be taken over.
pub fn foreign_claims(inbox: &Path, farm: &str) -> io::Result<Vec<String>> {
    // A claim that is being removed is already in the store of its farm.
    Ok(list_claim_folders(inbox)?
        .into_iter()
        .filter(|name| !name.starts_with(REMOVED_PREFIX) && is_foreign_claim(name, farm))
        .collect())
}

/// Ids of the claims of this farm that another farm has taken over.
pub fn taken_over_claims(inbox: &Path, farm: &str) -> io::Result<Vec<String>> {
    let names: HashSet<String> = list_claim_folders(inbox)?.into_iter().collect();
    let mut taken = Vec::new();
    for trace in names.iter().filter(|name| name.starts_with(ADOPTED_PREFIX)) {
        let (id, former) = parse_folder_name(trace);
        let stands = |farm: &str| names.contains(&claim_folder_name(id, farm));
        // A trace whose claim is still there belongs to a takeover that did not complete.
        if former.unwrap_or_default() == farm && !stands(farm) {
            taken.push(id.to_owned());
        }
    }
    Ok(taken)
}

/// Returns those of the given claims that this farm has not released: they are in `.claimed/`, or another farm took
/// them over.
pub fn unreleased_claims(inbox: &Path, farm: &str, ids: &HashSet<String>) -> io::Result<Vec<String>> {
    let mut left = list_claim_folders(inbox)?;
    left.retain(|name| {
        let (id, of) = parse_folder_name(name);
        let is_past = name.starts_with(REMOVED_PREFIX) || (name.starts_with(ADOPTED_PREFIX) && of != Some(farm));
        !is_past && ids.contains(id)
    });
    Ok(left)
}

/// Gives the claims of a farm, complete or not, the number that the farm has now. Nobody takes them over: no trace is left.
pub fn rename_claims(inbox: &Path, before: &str, now: &str) -> io::Result<()> {
    let _only_one = lock_claims(inbox);
    let claimed = inbox.join(CLAIMED_DIR);
    for name in list_claim_folders(inbox)?.iter().filter(|name| !name.starts_with(ADOPTED_PREFIX)) {
        if let (id, Some(of)) = parse_folder_name(name)
            && of == before
        {
            let begins = name.split_once(id).map_or("", |(begins, _)| begins);
            disk::rename_noreplace(
                &claimed.join(name),
                &claimed.join(format!("{begins}{}", claim_folder_name(id, now))),
            )?;
        }
    }
    if claimed.exists() { disk::fsync_dir(&claimed) } else { Ok(()) }
}

/// Takes over the claims of other farms and returns their number. The trace is on disk before the claim is renamed.
pub fn adopt_claims(inbox: &Path, farm: &str) -> io::Result<usize> {
    let _only_one = lock_claims(inbox);
    let claimed = inbox.join(CLAIMED_DIR);
    let (names, mut count) = (foreign_claims(inbox, farm)?, 0);
    if names.is_empty() {
        return Ok(0);
    }
    for name in names {
        let (id, _) = parse_folder_name(&name);
        if !name.starts_with(UNFINISHED_PREFIX) {
            let trace = takeover_trace_path(&claimed.join(&name));
            let text =
                serde_json::json!({ "claim": id, "taken_over_by": farm, "at": jiff::Timestamp::now().to_string() });
            disk::write_file_atomically(&trace, format!("{text}\n").as_bytes())?;
        }
        let begins = if name.starts_with(UNFINISHED_PREFIX) { UNFINISHED_PREFIX } else { "" };
        let own = claimed.join(format!("{begins}{}", claim_folder_name(id, farm)));
        match disk::rename_noreplace(&claimed.join(&name), &own) {
            // Its farm released the claim in the meantime, so nothing was taken over.
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let _ = fs::remove_file(takeover_trace_path(&claimed.join(&name)));
            }
            Err(error) => return Err(error),
            Ok(()) => count += 1,
        }
    }
    disk::fsync_dir(&claimed)?;
    Ok(count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ReleaseOutcome, claim_for_farm, recover_claims, release_claim, test_inbox::TestInbox};

    #[test]
    fn of_two_farms_one_that_lets_a_claim_go_and_one_that_takes_it_over_one_comes_first() {
        let farm = TestInbox::new();
        farm.drop_file("a.stl", "a");
        let claim = claim_for_farm(&farm.inbox, &farm.ready_part(), "aa").unwrap();
        let ids = HashSet::from([claim.id.clone()]);
        assert_eq!(recover_claims(&farm.inbox, "aa").unwrap().0, std::slice::from_ref(&claim));
        assert!(recover_claims(&farm.inbox, "bb").unwrap().0.is_empty() && claim.part.exists());
        assert_eq!(foreign_claims(&farm.inbox, "bb").unwrap().len(), 1);
        assert!(
            foreign_claims(&farm.inbox, "aa").unwrap().is_empty()
                && taken_over_claims(&farm.inbox, "aa").unwrap().is_empty()
        );
        assert_eq!(adopt_claims(&farm.inbox, "bb").unwrap(), 1);
        assert_eq!(taken_over_claims(&farm.inbox, "aa").unwrap(), std::slice::from_ref(&claim.id));
        assert_eq!(release_claim(&claim, "").unwrap(), ReleaseOutcome::TakenOver);
        let own = recover_claims(&farm.inbox, "bb").unwrap().0;
        assert_eq!(own[0].id, claim.id);
        assert_eq!(unreleased_claims(&farm.inbox, "aa", &ids).unwrap().len(), 2);
        assert_eq!(release_claim(&own[0], "").unwrap(), ReleaseOutcome::Removed);
        assert!(unreleased_claims(&farm.inbox, "bb", &ids).unwrap().is_empty());
        // The trace stays, because the former farm may come back at any time.
        assert_eq!(release_claim(&claim, "").unwrap(), ReleaseOutcome::TakenOver);
        assert_eq!(
            (adopt_claims(&farm.inbox, "bb").unwrap(), taken_over_claims(&farm.inbox, "bb").unwrap().len()),
            (0, 0)
        );
    }

    #[test]
    fn a_farm_that_gets_another_number_keeps_its_claims_and_no_other() {
        let farm = TestInbox::new();
        rename_claims(&farm.inbox, "aa", "cc").unwrap();
        let claimed = |name: &str, of: &str| {
            farm.drop_file(name, name);
            claim_for_farm(&farm.inbox, &farm.ready_part(), of).unwrap()
        };
        let (own, other) = (claimed("a.stl", "aa"), claimed("b.stl", "bb"));
        let unfinished = farm.inbox.join(".claimed/.new-x@aa");
        fs::create_dir(&unfinished).unwrap();
        rename_claims(&farm.inbox, "aa", "cc").unwrap();
        assert!(!unfinished.exists() && farm.inbox.join(".claimed/.new-x@cc").exists());
        let ids = |farm_id: &str| {
            let claims = recover_claims(&farm.inbox, farm_id).unwrap().0;
            claims.into_iter().map(|claim| claim.id).collect::<Vec<_>>()
        };
        assert_eq!((ids("cc"), ids("bb"), ids("aa")), (vec![own.id], vec![other.id], vec![]));
        assert!(taken_over_claims(&farm.inbox, "aa").unwrap().is_empty());
    }

    #[test]
    fn where_nothing_was_ever_claimed_there_is_nothing_to_take_over() {
        let farm = TestInbox::new();
        assert_eq!(adopt_claims(&farm.inbox, "bb").unwrap(), 0);
    }

    #[test]
    fn what_was_let_go_cannot_be_taken_over() {
        let farm = TestInbox::new();
        farm.drop_file("a.stl", "a");
        let claim = claim_for_farm(&farm.inbox, &farm.ready_part(), "aa").unwrap();
        assert_eq!(release_claim(&claim, "").unwrap(), ReleaseOutcome::Removed);
        assert_eq!(release_claim(&claim, "").unwrap(), ReleaseOutcome::Removed);
        assert_eq!(adopt_claims(&farm.inbox, "bb").unwrap(), 0);
        assert!(unreleased_claims(&farm.inbox, "aa", &HashSet::from([claim.id])).unwrap().is_empty());
    }
}
