//! Tests of lists in order folders with folders in them.

use super::{test_inbox::TestInbox, *};

pub(super) const HELD: OrderListRules = OrderListRules { incomplete_secs: 1000.0, unlisted: UnlistedPolicy::Refuse };
pub(super) const OVER: OrderListRules = OrderListRules { incomplete_secs: 50.0, unlisted: UnlistedPolicy::Refuse };

/// Paths, copies (or the error) and whether these are asked for, of all parts that may be taken.
pub(super) fn taken(farm: &TestInbox, rules: OrderListRules) -> Vec<(String, Result<Option<u32>, String>, bool)> {
    let mut said = Vec::new();
    for judged in farm.judged(rules) {
        if let TakeDecision::Take(ready @ SettledEntry::Part { .. }) = judged {
            let claim = claim_part(&farm.inbox, &ready).unwrap();
            let spec = claim.read_part_spec();
            let is_asked = spec.iter().any(|spec| spec.warnings.iter().any(|one| build_file::is_copies_question(one)));
            let copies = spec.map(|spec| spec.ticket.copies).map_err(|why| why.to_string());
            said.push((format!("{}/{}", claim.order, claim.display_name()), copies, is_asked));
            release_claim(&claim, "").unwrap();
        }
    }
    said.sort();
    said
}

pub(super) fn waits(farm: &TestInbox) -> Vec<String> {
    let why = |judged| if let TakeDecision::Wait(why) = judged { Some(why) } else { None };
    farm.judged(HELD).into_iter().filter_map(why).collect()
}

/// How all lists end.
fn ends(farm: &TestInbox, incomplete_secs: f64) -> Vec<ListOutcome> {
    let mut lists = OrderListTracker::default();
    lists.observe_scan(&scan_inbox(&farm.inbox, ScanLimits::default()).unwrap().entries);
    let ready = farm.ready().into_iter().filter(|ready| matches!(ready, SettledEntry::List { .. }));
    ready
        .map(|list| {
            finish_order_list(&farm.inbox, &mut lists, &list, incomplete_secs, &farm.archive, &farm.error).unwrap()
        })
        .collect()
}

#[test]
fn the_path_in_a_row_decides_among_files_of_one_name_in_folders_below_the_list() {
    for (one, two) in [("R/a.stl", "L/a.stl"), ("R\\A.stl", "./L/a"), ("C:\\o\\R\\a.stl", "D:\\x\\L\\a.stl")] {
        let farm = TestInbox::new();
        farm.drop_file("k/l.csv", &format!("file,qty\n{one},2\n{two},4\n"));
        farm.drop_file("k/L/a.stl", "solid l");
        farm.drop_file("k/R/a.stl", "solid r");
        let expected = [("k/L/a.stl".to_owned(), Ok(Some(4)), false), ("k/R/a.stl".to_owned(), Ok(Some(2)), false)];
        assert_eq!(taken(&farm, HELD), expected, "{one}");
        assert!(matches!(ends(&farm, 1000.0)[..], [ListOutcome::Archived(_)]), "{one}");
    }
}

#[test]
fn a_row_that_fits_two_files_in_folders_below_is_for_neither() {
    let farm = TestInbox::new();
    farm.drop_file("k/l.csv", "file,qty\nbracket.stl,4\nlid.stl,3\n");
    for name in ["k/left/bracket.stl", "k/right/bracket.stl", "k/left/lid.stl"] {
        farm.drop_file(name, "solid");
    }
    let why = waits(&farm);
    let is_told = |part: &str| why.iter().any(|why| why.contains(part) && why.contains("write its folder too"));
    assert!(is_told("left/bracket.stl") && is_told("right/bracket.stl"), "{why:?}");
    assert_eq!(taken(&farm, HELD), [("k/left/lid.stl".to_owned(), Ok(Some(3)), false)]);
    let told = taken(&farm, OVER);
    assert!(told.len() == 2 && told.iter().all(|(_, copies, _)| copies.is_err()), "{told:?}");
    // The remedy, followed word by word.
    let farm = TestInbox::new();
    farm.drop_file("k/l.csv", "file,qty\nleft/bracket.stl,4\nright/bracket.stl,1\n");
    for name in ["k/left/bracket.stl", "k/right/bracket.stl"] {
        farm.drop_file(name, "solid");
    }
    assert_eq!(
        taken(&farm, HELD).iter().map(|(_, copies, _)| copies.clone()).collect::<Vec<_>>(),
        [Ok(Some(4)), Ok(Some(1))]
    );
}

#[test]
fn what_lies_below_a_list_and_stands_in_no_row_is_asked_about() {
    let farm = TestInbox::new();
    farm.drop_file("k/l.csv", "file,qty\nsub/a.stl,3\n");
    for name in ["k/sub/a.stl", "k/sub/b.stl", "k/sub/c_x2.stl", "other/b.stl"] {
        farm.drop_file(name, "solid");
    }
    let expected = [
        ("k/sub/a.stl".to_owned(), Ok(Some(3)), false),
        ("k/sub/b.stl".to_owned(), Ok(None), true),
        ("k/sub/c_x2.stl".to_owned(), Ok(Some(2)), false),
        ("other/b.stl".to_owned(), Ok(None), false),
    ];
    assert_eq!(taken(&farm, HELD), expected);
    assert!(matches!(ends(&farm, 1000.0)[..], [ListOutcome::Archived(_)]));
}

#[test]
fn a_list_in_a_folder_of_its_own_is_asked_about() {
    let farm = TestInbox::new();
    farm.drop_file("k/Liste/l.csv", "Datei;Menge\na.stl;4\nb.stl;6\n");
    for name in ["k/STL/a.stl", "k/STL/b.stl", "k/STL/c.stl", "z/a.stl"] {
        farm.drop_file(name, "solid");
    }
    let asked: Vec<bool> = taken(&farm, HELD).into_iter().map(|(_, _, is_asked)| is_asked).collect();
    assert_eq!(asked, [true, true, false, false]);
}
