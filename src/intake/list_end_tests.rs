//! Order lists on real folders.

use super::*;
use crate::intake::{
    claim, release,
    test_inbox::{TestInbox, files},
};

const LIST: &str = "file,copies\na.stl,2\nb.stl,3\n";

fn end(farm: &TestInbox, orphan_secs: f64) -> Vec<ListEnd> {
    let lists = farm.ready().into_iter().filter(|r| matches!(r, Ready::List { .. }));
    lists.map(|r| end_list(&farm.inbox, &r, orphan_secs, &farm.archive, &farm.error).unwrap()).collect()
}

fn claim_all(farm: &TestInbox) {
    for ready in farm.ready() {
        if matches!(ready, Ready::Part { .. }) {
            release(&claim(&farm.inbox, &ready).unwrap()).unwrap();
        }
    }
}

#[test]
fn a_list_is_archived_when_all_its_files_were_claimed() {
    let farm = TestInbox::new();
    farm.drop_file("k/order.csv", LIST);
    assert_eq!(end(&farm, 1000.0), [ListEnd::Awaited]);
    farm.drop_file("k/a.stl", "solid");
    assert_eq!(end(&farm, 1000.0), [ListEnd::Awaited]);
    claim_all(&farm);
    assert_eq!(end(&farm, 1000.0), [ListEnd::Awaited]);
    farm.drop_file("k/b.stl", "solid");
    claim_all(&farm);
    let archived = farm.archive.join("order-lists/k/order.csv");
    assert_eq!(end(&farm, 1000.0), [ListEnd::Archived(archived.clone())]);
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
    // The list stood for 100 s, but a file of it came just now.
    assert_eq!(end(&farm, 50.0), [ListEnd::Awaited]);
    let ends = end(&farm, 0.0);
    let [ListEnd::Refused(reason)] = &ends[..] else { panic!("{ends:?}") };
    assert!(reason.contains("1 of 2 rows") && reason.contains("b.stl") && !reason.contains("a.stl"), "{reason}");
    assert_eq!(files(&farm.error), ["order.csv", "order.csv.reason.txt"]);
}

#[test]
fn a_list_waits_for_a_file_that_is_beside_it_however_long_it_takes() {
    let farm = TestInbox::new();
    farm.drop_file("order.csv", LIST);
    farm.drop_file("b.stl", "still being copied");
    assert_eq!(end(&farm, 0.0), [ListEnd::Awaited]);
}

#[test]
fn a_broken_list_stays_for_the_files_that_it_names_and_is_refused_in_the_end() {
    let farm = TestInbox::new();
    farm.drop_file("order.csv", "file;amount\na.stl;2\n");
    assert_eq!(end(&farm, 1000.0), [ListEnd::Awaited]);
    farm.drop_file("a.stl", "solid");
    farm.drop_file("other.stl", "solid");
    let mut refused = 0;
    for ready in farm.ready() {
        if matches!(ready, Ready::Part { .. }) {
            let claim = claim(&farm.inbox, &ready).unwrap();
            assert_eq!(claim.given().is_err(), claim.name == "a.stl");
            refused += usize::from(claim.given().is_err());
        }
    }
    assert_eq!(refused, 1);
    let ends = end(&farm, 0.0);
    let [ListEnd::Refused(reason)] = &ends[..] else { panic!("{ends:?}") };
    assert!(reason.contains("amount"), "{reason}");
}

#[test]
fn an_empty_list_and_rows_without_a_file_are_refused_in_the_end() {
    for text in ["file,copies\n", "file,copies\n,3\n"] {
        let farm = TestInbox::new();
        farm.drop_file("order.csv", text);
        assert_eq!(end(&farm, 1000.0), [ListEnd::Awaited], "{text}");
        assert!(matches!(&end(&farm, 0.0)[..], [ListEnd::Refused(_)]), "{text}");
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
    assert_eq!(end(&farm, 1000.0), [ListEnd::Awaited]);
    drop(old);
}
