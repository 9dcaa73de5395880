//! Tests of order lists on real folders.

use super::*;
use crate::{
    ClaimedPart, OrderListRules, ScanLimits, TakeDecision, UnlistedPolicy, claim_part, release_claim, scan_inbox,
    test_inbox::{TestInbox, files},
};

const LIST: &str = "file,copies\na.stl,2\nb.stl,3\n";

fn end(farm: &TestInbox, incomplete_secs: f64) -> Vec<ListOutcome> {
    let mut lists = OrderListTracker::default();
    lists.observe_scan(&scan_inbox(&farm.inbox, ScanLimits::default()).unwrap().entries);
    let ready = farm.ready().into_iter().filter(|r| matches!(r, SettledEntry::List { .. }));
    ready
        .map(|r| finish_order_list(&farm.inbox, &mut lists, &r, incomplete_secs, &farm.archive, &farm.error).unwrap())
        .collect()
}

/// The entries that wait, with their reasons.
fn waits(farm: &TestInbox, incomplete_secs: f64) -> Vec<String> {
    let rules = OrderListRules { incomplete_secs, unlisted: UnlistedPolicy::Refuse };
    let why = |judged| if let TakeDecision::Wait(why) = judged { Some(why) } else { None };
    farm.judged(rules).into_iter().filter_map(why).collect()
}

/// Names and copies (or the error) of all parts that may be taken after `incomplete_secs`.
fn taken(
    farm: &TestInbox,
    incomplete_secs: f64,
    unlisted: UnlistedPolicy,
) -> Vec<(String, Result<Option<u32>, String>)> {
    let judged = farm.judged(OrderListRules { incomplete_secs, unlisted });
    let take = |judged| if let TakeDecision::Take(ready) = judged { Some(ready) } else { None };
    let parts = judged.into_iter().filter_map(take).filter(|ready| matches!(ready, SettledEntry::Part { .. }));
    let claims = parts.map(|ready| claim_part(&farm.inbox, &ready).unwrap());
    let said = |claim: ClaimedPart| {
        let given = claim.read_part_spec().map(|given| given.ticket.copies).map_err(|why| why.to_string());
        release_claim(&claim, "").unwrap();
        (claim.display_name(), given)
    };
    claims.map(said).collect()
}

fn claim_all(farm: &TestInbox) {
    for ready in farm.ready() {
        if matches!(ready, SettledEntry::Part { .. }) {
            release_claim(&claim_part(&farm.inbox, &ready).unwrap(), "").unwrap();
        }
    }
}

#[test]
fn a_list_is_archived_when_all_its_files_were_claimed() {
    let farm = TestInbox::new();
    farm.drop_file("k/order.csv", LIST);
    assert_eq!(end(&farm, 1000.0), [ListOutcome::Awaited]);
    farm.drop_file("k/a.stl", "solid");
    assert_eq!(end(&farm, 1000.0), [ListOutcome::Awaited]);
    claim_all(&farm);
    assert_eq!(end(&farm, 1000.0), [ListOutcome::Awaited]);
    farm.drop_file("k/b.stl", "solid");
    claim_all(&farm);
    let archived = farm.archive.join("order-lists/k/order.csv");
    assert_eq!(end(&farm, 1000.0), [ListOutcome::Archived(archived.clone())]);
    assert_eq!(fs::read_to_string(archived).unwrap(), LIST);
    assert!(farm.dropped().is_empty());
    assert!(files(&farm.inbox.join(".claimed/.lists")).is_empty());
}

#[test]
fn a_list_whose_files_do_not_come_is_refused_with_their_names() {
    let farm = TestInbox::new();
    farm.drop_file("order.csv", LIST);
    farm.drop_file("a.stl", "solid");
    claim_all(&farm);
    // The list was unchanged for 100 s, but one of its files just arrived.
    assert_eq!(end(&farm, 50.0), [ListOutcome::Awaited]);
    let ends = end(&farm, 0.0);
    let [ListOutcome::Refused(reason)] = &ends[..] else { panic!("{ends:?}") };
    assert!(reason.contains("1 of 2 rows") && reason.contains("b.stl") && !reason.contains("a.stl"), "{reason}");
    assert_eq!(files(&farm.error), ["order.csv", "order.csv.reason.txt"]);
}

#[test]
fn other_rows_are_spoken_of_only_where_there_are_any() {
    let farm = TestInbox::new();
    farm.drop_file("order.csv", LIST);
    let ends = end(&farm, 0.0);
    let [ListOutcome::Refused(reason)] = &ends[..] else { panic!("{ends:?}") };
    assert!(reason.contains("2 of 2 rows") && !reason.contains("other rows"), "{reason}");
}

#[test]
fn a_list_waits_for_a_file_that_is_beside_it_however_long_it_takes() {
    let farm = TestInbox::new();
    farm.drop_file("order.csv", LIST);
    farm.drop_file("b.stl", "still being copied");
    assert_eq!(end(&farm, 0.0), [ListOutcome::Awaited]);
}

#[test]
fn a_list_that_is_not_understood_holds_all_files_of_its_folder_and_is_refused_after_them() {
    let farm = TestInbox::new();
    farm.drop_file("order.csv", "price;amount\na.stl;2\n");
    assert_eq!(end(&farm, 1000.0), [ListOutcome::Awaited]);
    farm.drop_file("a.stl", "solid");
    farm.drop_file("other.stl", "solid");
    let why = waits(&farm, 1000.0);
    assert!(why.len() == 2 && why[0].starts_with("a.stl stands beside order.csv, which is not understood"), "{why:?}");
    assert_eq!(end(&farm, 0.5), [ListOutcome::Awaited]);
    let taken = taken(&farm, 50.0, UnlistedPolicy::Refuse);
    assert!(taken.len() == 2 && taken.iter().all(|(_, copies)| copies.is_err()), "{taken:?}");
    let ends = end(&farm, 0.0);
    let [ListOutcome::Refused(reason)] = &ends[..] else { panic!("{ends:?}") };
    assert!(reason.contains("names its columns"), "{reason}");
}

#[test]
fn a_part_that_the_list_does_not_name_waits_and_is_then_refused_or_taken_as_is_set() {
    for (unlisted, is_taken) in [(UnlistedPolicy::Refuse, false), (UnlistedPolicy::Warn, true)] {
        let farm = TestInbox::new();
        farm.drop_file("k/a.stl", "solid");
        farm.drop_file("k/b.stl", "solid");
        farm.drop_file("k/new.stl", "solid");
        farm.drop_file("k/said.stl", "solid");
        farm.drop_file("k/said.stl.toml", "copies = 4");
        farm.drop_file("k/order.csv", LIST);
        assert_eq!(waits(&farm, 1000.0), ["k/new.stl stands in none of the 2 rows of order.csv"]);
        let copies = |name: &str, copies| (name.to_owned(), Ok(Some(copies)));
        assert_eq!(taken(&farm, 1000.0, unlisted), [copies("a.stl", 2), copies("b.stl", 3), copies("said.stl", 4)]);
        // All rows are served, but the list stays for the part that it may have left out.
        assert_eq!(end(&farm, 1000.0), [ListOutcome::Awaited]);
        let late = taken(&farm, 50.0, unlisted);
        assert_eq!((late.len(), late[0].1.is_ok()), (1, is_taken), "{late:?}");
        assert!(matches!(&end(&farm, 1000.0)[..], [ListOutcome::Archived(_)]));
    }
}

#[test]
fn what_comes_after_a_list_was_served_is_nothing_to_it() {
    let farm = TestInbox::new();
    farm.drop_file("order.csv", LIST);
    farm.drop_file("a.stl", "solid");
    farm.drop_file("b.stl", "solid");
    claim_all(&farm);
    std::thread::sleep(std::time::Duration::from_millis(30));
    farm.drop_file("c.stl", "solid");
    assert_eq!(waits(&farm, 1000.0), [""; 0]);
    assert!(matches!(&end(&farm, 1000.0)[..], [ListOutcome::Archived(_)]));
}

#[test]
fn a_name_that_may_be_of_two_files_waits_until_it_is_clear() {
    let farm = TestInbox::new();
    farm.drop_file("order.csv", "file,copies\nlid,2\n");
    farm.drop_file("lid.stl", "solid");
    farm.drop_file("lid.3mf", "solid");
    assert_eq!(waits(&farm, 1000.0).len(), 2);
    fs::remove_file(farm.inbox.join("lid.3mf")).unwrap();
    assert_eq!(taken(&farm, 1000.0, UnlistedPolicy::Refuse), [("lid.stl".to_owned(), Ok(Some(2)))]);
    // The row is served; another file that it could also mean does not count.
    farm.drop_file("lid.3mf", "solid");
    assert_eq!(waits(&farm, 1000.0).len(), 1);
}

#[test]
fn lists_in_other_code_pages_speak_for_the_files_beside_them() {
    for list in [&b"datei;menge\r\nGr\x94\xe1e.stl;7\r\n"[..], b"datei;menge\r\n.\\Gr\xf6\xdfe;7\r\n"] {
        let farm = TestInbox::new();
        farm.drop_file("k/Gro\u{308}ße.stl", "solid");
        fs::write(farm.inbox.join("k/order.csv"), list).unwrap();
        assert_eq!(
            taken(&farm, 1000.0, UnlistedPolicy::Refuse),
            [("Gro\u{308}ße.stl".to_owned(), Ok(Some(7)))],
            "{list:?}"
        );
        assert!(matches!(&end(&farm, 1000.0)[..], [ListOutcome::Archived(_)]));
    }
}

#[test]
fn a_part_that_was_given_back_keeps_its_row_under_another_name_and_without_its_list() {
    let farm = TestInbox::new();
    farm.drop_file("k/a.stl", "solid");
    farm.drop_file("k/order.csv", "file,copies\na.stl,7\n");
    let claim = farm.claim();
    assert!(matches!(&end(&farm, 1000.0)[..], [ListOutcome::Archived(_)]));
    farm.drop_file("k/a.stl", "another one");
    let back = crate::give_back_claim(&claim).unwrap();
    assert_eq!(back, farm.inbox.join("k/a (2).stl"));
    let one = |name: &str, copies| (name.to_owned(), Ok(copies));
    assert_eq!(taken(&farm, 1000.0, UnlistedPolicy::Refuse), [one("a (2).stl", Some(7)), one("a.stl", None)]);
    // The same while its list is still there.
    farm.drop_file("k/order.csv", "file,copies\na.stl,7\n");
    farm.drop_file("k/a.stl", "solid");
    let claim = farm.claim();
    farm.drop_file("k/a.stl", "another one");
    crate::give_back_claim(&claim).unwrap();
    assert_eq!(taken(&farm, 1000.0, UnlistedPolicy::Refuse), [one("a (2).stl", Some(7)), one("a.stl", Some(7))]);
}

#[test]
fn an_empty_list_and_rows_without_a_file_are_refused_in_the_end() {
    for text in ["file,copies\n", "file,copies\n,3\n"] {
        let farm = TestInbox::new();
        farm.drop_file("order.csv", text);
        assert_eq!(end(&farm, 1000.0), [ListOutcome::Awaited], "{text}");
        assert!(matches!(&end(&farm, 0.0)[..], [ListOutcome::Refused(_)]), "{text}");
    }
}

#[test]
fn a_new_list_of_the_same_text_is_not_served_by_the_old_ones_files() {
    let farm = TestInbox::new();
    farm.drop_file("order.csv", "file,copies\na.stl,2\n");
    farm.drop_file("a.stl", "solid");
    claim_all(&farm);
    let old = fs::File::open(farm.inbox.join("order.csv")).unwrap();
    fs::remove_file(farm.inbox.join("order.csv")).unwrap();
    farm.drop_file("order.csv", "file,copies\na.stl,2\n");
    assert_eq!(end(&farm, 1000.0), [ListOutcome::Awaited]);
    drop(old);
}
