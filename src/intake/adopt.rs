//! Whose a claim is, and how it becomes another farm's. A claim's folder is `.claimed/<id>@<farm>`; one without a farm is of an
//! earlier release and counts as own. A claim has one name at a time, so that of two farms, one that lets it go and one that
//! takes it over, exactly one comes first.

use std::{collections::HashSet, fs, io, path::Path};

use super::{
    claim_folder::{
        ADOPTED, CLAIMED_DIR, DONE, NEW, claiming, folder_name, id_and_farm, is_foreign, names, taken_over_name,
    },
    disk,
};

/// The claims of other farms that lie in `.claimed/` and may be taken over: the names of their folders.
pub fn foreign(inbox: &Path, farm: &str) -> io::Result<Vec<String>> {
    // What is being removed was taken into the store of its farm.
    Ok(names(inbox)?.into_iter().filter(|name| !name.starts_with(DONE) && is_foreign(name, farm)).collect())
}

/// Claims of this farm that another one has taken over: their ids.
pub fn taken_over(inbox: &Path, farm: &str) -> io::Result<Vec<String>> {
    let names: HashSet<String> = names(inbox)?.into_iter().collect();
    let mut taken = Vec::new();
    for trace in names.iter().filter(|name| name.starts_with(ADOPTED)) {
        let (id, former) = id_and_farm(trace);
        let stands = |farm: &str| names.contains(&folder_name(id, farm));
        // A trace whose claim is still there is of a taking over that did not come to its end.
        if former.unwrap_or_default() == farm && !stands(farm) {
            taken.push(id.to_owned());
        }
    }
    Ok(taken)
}

/// Those of these claims that have not been let go by this farm: they lie in `.claimed/`, or another farm took them over.
pub fn not_let_go(inbox: &Path, farm: &str, ids: &HashSet<String>) -> io::Result<Vec<String>> {
    let mut left = names(inbox)?;
    left.retain(|name| {
        let (id, of) = id_and_farm(name);
        let is_past = name.starts_with(DONE) || (name.starts_with(ADOPTED) && of != Some(farm));
        !is_past && ids.contains(id)
    });
    Ok(left)
}

/// Takes over the claims of other farms; returns how many there were. The trace is on disk before the claim changes its name.
pub fn adopt(inbox: &Path, farm: &str) -> io::Result<usize> {
    let _only_one = claiming(inbox);
    let claimed = inbox.join(CLAIMED_DIR);
    let (names, mut count) = (foreign(inbox, farm)?, 0);
    if names.is_empty() {
        return Ok(0);
    }
    for name in names {
        let (id, _) = id_and_farm(&name);
        if !name.starts_with(NEW) {
            let trace = taken_over_name(&claimed.join(&name));
            let text =
                serde_json::json!({ "claim": id, "taken_over_by": farm, "at": jiff::Timestamp::now().to_string() });
            disk::write_by_rename(&trace, format!("{text}\n").as_bytes())?;
        }
        let begins = if name.starts_with(NEW) { NEW } else { "" };
        let own = claimed.join(format!("{begins}{}", folder_name(id, farm)));
        match disk::rename_noreplace(&claimed.join(&name), &own) {
            // Its farm has let it go meanwhile, so that nothing was taken over.
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let _ = fs::remove_file(taken_over_name(&claimed.join(&name)));
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
    use crate::intake::{Released, claim_as, claims, release, test_inbox::TestInbox};

    #[test]
    fn of_two_farms_one_that_lets_a_claim_go_and_one_that_takes_it_over_one_comes_first() {
        let farm = TestInbox::new();
        farm.drop_file("a.stl", "a");
        let claim = claim_as(&farm.inbox, &farm.ready_part(), "aa").unwrap();
        let ids = HashSet::from([claim.id.clone()]);
        assert_eq!(claims(&farm.inbox, "aa").unwrap().0, std::slice::from_ref(&claim));
        assert!(claims(&farm.inbox, "bb").unwrap().0.is_empty() && claim.part.exists());
        assert_eq!(foreign(&farm.inbox, "bb").unwrap().len(), 1);
        assert!(foreign(&farm.inbox, "aa").unwrap().is_empty() && taken_over(&farm.inbox, "aa").unwrap().is_empty());
        assert_eq!(adopt(&farm.inbox, "bb").unwrap(), 1);
        assert_eq!(taken_over(&farm.inbox, "aa").unwrap(), std::slice::from_ref(&claim.id));
        assert_eq!(release(&claim, "").unwrap(), Released::TakenOver);
        let own = claims(&farm.inbox, "bb").unwrap().0;
        assert_eq!(own[0].id, claim.id);
        assert_eq!(not_let_go(&farm.inbox, "aa", &ids).unwrap().len(), 2);
        assert_eq!(release(&own[0], "").unwrap(), Released::Removed);
        assert!(not_let_go(&farm.inbox, "bb", &ids).unwrap().is_empty());
        // The trace stays, for the former farm may come back at any time.
        assert_eq!(release(&claim, "").unwrap(), Released::TakenOver);
        assert_eq!((adopt(&farm.inbox, "bb").unwrap(), taken_over(&farm.inbox, "bb").unwrap().len()), (0, 0));
    }

    #[test]
    fn where_nothing_was_ever_claimed_there_is_nothing_to_take_over() {
        let farm = TestInbox::new();
        assert_eq!(adopt(&farm.inbox, "bb").unwrap(), 0);
    }

    #[test]
    fn what_was_let_go_cannot_be_taken_over() {
        let farm = TestInbox::new();
        farm.drop_file("a.stl", "a");
        let claim = claim_as(&farm.inbox, &farm.ready_part(), "aa").unwrap();
        assert_eq!(release(&claim, "").unwrap(), Released::Removed);
        assert_eq!(release(&claim, "").unwrap(), Released::Removed);
        assert_eq!(adopt(&farm.inbox, "bb").unwrap(), 0);
        assert!(not_let_go(&farm.inbox, "aa", &HashSet::from([claim.id])).unwrap().is_empty());
    }
}
