//! Tests with scans made by hand, because the settler is a pure function.

use super::*;

const RULES: SettleRules = SettleRules { settle_secs: 5.0, unfinished_secs: 600.0, orphan_secs: 3600.0 };

fn seen(path: &str, size: u64, ctime_secs: i128) -> InboxEntry {
    InboxEntry {
        is_private_link: false,
        found_list: crate::FoundList::None,
        path: path.into(),
        order: String::new(),
        kind: EntryKind::File,
        size,
        allocated: size,
        ctime_ns: ctime_secs * 1_000_000_000,
        mtime_ns: 0,
        inode: 1,
        dev: 1,
    }
}

fn whole(_: &Path, _: &str) -> io::Result<bool> {
    Ok(true)
}

fn cut(_: &Path, _: &str) -> io::Result<bool> {
    Ok(false)
}

fn parts(ready: &[SettledEntry]) -> Vec<&str> {
    ready
        .iter()
        .filter_map(|r| match r {
            SettledEntry::Part { part, .. } => part.path.to_str(),
            _ => None,
        })
        .collect()
}

#[test]
fn a_file_that_stands_still_is_taken_after_two_scans_and_the_settle_time() {
    let mut settler = SettleTracker::new(RULES);
    let scan = [seen("in/a.stl", 84, 1)];
    assert_eq!(settler.observe_scan(&scan, 100.0, whole), []);
    assert_eq!(settler.observe_scan(&scan, 104.9, whole), []);
    assert_eq!(parts(&settler.observe_scan(&scan, 105.0, whole)), ["in/a.stl"]);
    // It is reported again at every scan while it is in the hot folder.
    assert_eq!(parts(&settler.observe_scan(&scan, 106.0, whole)), ["in/a.stl"]);
}

#[test]
fn one_scan_is_never_enough() {
    let mut settler = SettleTracker::new(SettleRules { settle_secs: 0.0, ..RULES });
    let scan = [seen("in/a.stl", 84, 1)];
    assert_eq!(settler.observe_scan(&scan, 0.0, whole), []);
    assert_eq!(settler.next_scan_secs(0.0), Some(0.0));
    assert_eq!(parts(&settler.observe_scan(&scan, 0.0, whole)), ["in/a.stl"]);
    assert_eq!(settler.next_scan_secs(0.0), None);
}

#[test]
fn a_file_still_growing_is_not_taken_however_long_it_takes() {
    let mut settler = SettleTracker::new(RULES);
    for step in 0..5000 {
        let now = f64::from(step) * 4.0;
        assert_eq!(settler.observe_scan(&[seen("in/a.stl", step as u64, i128::from(step))], now, cut), []);
    }
    let last = [seen("in/a.stl", 4999, 4999)];
    assert_eq!(parts(&settler.observe_scan(&last, 4999.0 * 4.0 + 5.0, whole)), ["in/a.stl"]);
}

#[test]
fn a_write_into_an_allocated_file_is_seen_by_its_ctime() {
    let mut settler = SettleTracker::new(RULES);
    settler.observe_scan(&[seen("in/a.stl", 84, 1)], 0.0, whole);
    settler.observe_scan(&[seen("in/a.stl", 84, 2)], 6.0, whole);
    assert_eq!(settler.observe_scan(&[seen("in/a.stl", 84, 2)], 10.0, whole), []);
    assert_eq!(settler.observe_scan(&[seen("in/a.stl", 84, 2)], 11.0, whole).len(), 1);
}

#[test]
fn a_replaced_file_and_one_that_went_and_came_settle_anew() {
    let mut settler = SettleTracker::new(RULES);
    settler.observe_scan(&[seen("in/a.stl", 84, 1)], 0.0, whole);
    let other = InboxEntry { inode: 2, ..seen("in/a.stl", 84, 1) };
    assert_eq!(settler.observe_scan(std::slice::from_ref(&other), 6.0, whole), []);
    settler.observe_scan(&[], 7.0, whole);
    assert_eq!(settler.observe_scan(&[other], 12.0, whole), []);
}

#[test]
fn a_file_without_its_end_is_waited_for_and_taken_as_unfinished_in_the_end() {
    let mut settler = SettleTracker::new(RULES);
    let scan = [seen("in/a.stl", 100, 1)];
    for step in 0..60 {
        assert_eq!(settler.observe_scan(&scan, f64::from(step) * 10.0, cut), [], "step {step}");
    }
    let ready = settler.observe_scan(&scan, 600.0, cut);
    assert!(matches!(&ready[..], [SettledEntry::Part { unfinished: true, .. }]), "{ready:?}");
    // Its end arrived after all: it is an ordinary part.
    let ready = settler.observe_scan(&scan, 610.0, whole);
    assert!(matches!(&ready[..], [SettledEntry::Part { unfinished: false, .. }]), "{ready:?}");
}

#[test]
fn an_end_that_cannot_be_read_is_not_there_yet() {
    let mut settler = SettleTracker::new(RULES);
    let scan = [seen("in/a.stl", 100, 1)];
    settler.observe_scan(&scan, 0.0, whole);
    assert_eq!(settler.observe_scan(&scan, 9.0, |_, _| Err(io::ErrorKind::PermissionDenied.into())), []);
}

#[test]
fn the_end_is_asked_for_only_when_the_file_stands_still() {
    let mut settler = SettleTracker::new(RULES);
    let never = |_: &Path, _: &str| -> io::Result<bool> { panic!("asked too early") };
    settler.observe_scan(&[seen("in/a.stl", 1, 1)], 0.0, never);
    settler.observe_scan(&[seen("in/a.stl", 2, 2)], 9.0, never);
    settler.observe_scan(&[seen("in/a.stl", 2, 2)], 10.0, never);
}

#[test]
fn a_hole_only_delays() {
    let mut settler = SettleTracker::new(RULES);
    let scan = [InboxEntry { allocated: 4096, ..seen("in/a.stl", 1 << 20, 1) }];
    settler.observe_scan(&scan, 0.0, whole);
    assert_eq!(settler.observe_scan(&scan, 29.0, whole), []);
    assert_eq!(settler.observe_scan(&scan, 30.0, whole).len(), 1);
}

#[test]
fn a_part_waits_for_the_ticket_beside_it_to_settle() {
    let mut settler = SettleTracker::new(RULES);
    settler.observe_scan(&[seen("in/a.stl", 84, 1)], 0.0, whole);
    let both = [seen("in/a.stl", 84, 1), seen("in/a.stl.toml", 10, 4)];
    assert_eq!(settler.observe_scan(&both, 4.0, whole), []);
    assert_eq!(settler.observe_scan(&both, 8.0, whole), []);
    let ready = settler.observe_scan(&both, 9.0, whole);
    let [SettledEntry::Part { tickets, .. }] = &ready[..] else { panic!("{ready:?}") };
    assert_eq!(tickets[0].path, Path::new("in/a.stl.toml"));
}

#[test]
fn a_ticket_may_come_long_before_its_part() {
    let mut settler = SettleTracker::new(RULES);
    let ticket = seen("in/a.stl.JSON", 10, 1);
    for now in [0.0, 1000.0, 3599.0] {
        let ready = settler.observe_scan(std::slice::from_ref(&ticket), now, whole);
        assert!(ready.iter().all(|one| matches!(one, SettledEntry::Orphan { expiry_reason: None, .. })), "{ready:?}");
    }
    // Its part is being copied now, so it is not an orphan any more.
    for step in 0..10 {
        let both = [ticket.clone(), seen("in/a.stl", step, i128::from(step))];
        assert_eq!(settler.observe_scan(&both, 3599.0 + step as f64 * 4.0, cut), []);
    }
    let both = [ticket, seen("in/a.stl", 9, 9)];
    let ready = settler.observe_scan(&both, 3700.0, whole);
    assert!(matches!(&ready[..], [SettledEntry::Part { tickets, .. }] if tickets.len() == 1), "{ready:?}");
}

#[test]
fn a_ticket_without_its_part_is_an_orphan_and_expires() {
    let mut settler = SettleTracker::new(RULES);
    let ticket = [seen("in/a.stl.toml", 10, 1)];
    settler.observe_scan(&ticket, 0.0, whole);
    assert_eq!(settler.observe_scan(&ticket, 14.0, whole), [], "its part may only be slower");
    let ready = settler.observe_scan(&ticket, 15.0, whole);
    let [SettledEntry::Orphan { part_name, expiry_reason: None, .. }] = &ready[..] else { panic!("{ready:?}") };
    assert_eq!(part_name, "a.stl");
    let ready = settler.observe_scan(&ticket, 3600.0, whole);
    let [SettledEntry::Orphan { expiry_reason: Some(reason), .. }] = &ready[..] else { panic!("{ready:?}") };
    assert!(reason.contains("\"a.stl\"") && reason.contains("3600 s"), "{reason}");
}

#[test]
fn a_part_takes_the_list_of_its_own_folder_along() {
    let mut settler = SettleTracker::new(RULES);
    let scan = [seen("in/k/a.stl", 84, 1), seen("in/k/order.csv", 30, 1), seen("in/b.stl", 84, 1)];
    settler.observe_scan(&scan, 0.0, whole);
    let ready = settler.observe_scan(&scan, 5.0, whole);
    let [SettledEntry::Part { list: Some(list), .. }, SettledEntry::List { .. }, SettledEntry::Part { list: None, .. }] =
        &ready[..]
    else {
        panic!("{ready:?}")
    };
    assert_eq!(list.path, Path::new("in/k/order.csv"));
}

#[test]
fn a_folder_is_an_order_that_is_taken_when_nothing_in_it_changes_any_more() {
    let mut settler = SettleTracker::new(RULES);
    let in_order = |path: &str, size, ctime| InboxEntry { order: "k".into(), ..seen(path, size, ctime) };
    let first = [in_order("in/k/a.stl", 84, 1), seen("in/loose.stl", 84, 1)];
    settler.observe_scan(&first, 0.0, whole);
    // While another file, and then the list, is copied, the rest of the order waits. Files outside the order do not.
    let [a, loose] = first;
    let second = [a.clone(), in_order("in/k/b.stl", 50, 4), loose.clone()];
    assert_eq!(parts(&settler.observe_scan(&second, 5.0, whole)), ["in/loose.stl"]);
    let third = [a.clone(), in_order("in/k/b.stl", 84, 8), in_order("in/k/order.csv", 30, 9), loose.clone()];
    assert_eq!(parts(&settler.observe_scan(&third, 9.0, whole)), ["in/loose.stl"]);
    assert_eq!(parts(&settler.observe_scan(&third, 13.9, whole)), ["in/loose.stl"]);
    let ready = settler.observe_scan(&third, 14.0, whole);
    assert_eq!(parts(&ready), ["in/k/a.stl", "in/k/b.stl", "in/loose.stl"]);
    let is_without_list =
        |one: &SettledEntry| matches!(one, SettledEntry::Part { part, list: None, .. } if part.order == "k");
    assert!(!ready.iter().any(is_without_list), "{ready:?}");
}

#[test]
fn a_folder_waits_for_a_list_that_is_copied_last_and_for_its_sub_folders() {
    let mut settler = SettleTracker::new(RULES);
    let in_order = |order: &str, name: &str, ctime| InboxEntry {
        order: order.into(),
        ..seen(&format!("in/{order}/{name}"), 84, ctime)
    };
    let first = [in_order("k", "a.stl", 1), in_order("k/left", "b.stl", 1), in_order("k/right", "c.stl", 1)];
    settler.observe_scan(&first, 0.0, whole);
    // The list of the sub-folder is copied last, then another file of its neighbour.
    let [a, b, c] = first;
    let second = [a.clone(), b.clone(), in_order("k/left", "order.csv", 6), c.clone()];
    assert_eq!(parts(&settler.observe_scan(&second, 6.0, whole)), ["in/k/right/c.stl"]);
    let third = [second.to_vec(), vec![in_order("k/right", "d.stl", 10)]].concat();
    assert_eq!(parts(&settler.observe_scan(&third, 10.0, whole)), Vec::<String>::new());
    assert_eq!(parts(&settler.observe_scan(&third, 11.0, whole)), ["in/k/left/b.stl"]);
    let ready = settler.observe_scan(&third, 15.0, whole);
    assert_eq!(parts(&ready).len(), 4, "{ready:?}");
    let of_list =
        |one: &SettledEntry| matches!(one, SettledEntry::Part { part, list: Some(_), .. } if part.order == "k/left");
    assert!(ready.iter().any(of_list));
}

#[test]
fn a_file_in_the_folder_takes_the_ticket_even_while_it_is_being_copied() {
    let mut settler = SettleTracker::new(RULES);
    let ticket = seen("in/a.stl.toml", 10, 1);
    settler.observe_scan(std::slice::from_ref(&ticket), 0.0, whole);
    assert_eq!(settler.observe_scan(std::slice::from_ref(&ticket), 20.0, whole).len(), 1);
    for step in 0..20 {
        let both = [seen("in/a.stl", step, i128::from(step)), ticket.clone()];
        assert_eq!(settler.observe_scan(&both, 21.0 + step as f64 * 4.0, cut), []);
    }
}

#[test]
fn a_ticket_finds_its_part_in_other_letters_where_only_one_can_be_meant() {
    let mut settler = SettleTracker::new(RULES);
    let names = [
        "in/Bracket.STL",
        "in/bracket.stl.toml",
        "in/Gro\u{308}ße.stl",
        "in/größe.toml",
        "in/a.stl",
        "in/A.stl",
        "in/A.STL.toml",
    ];
    let mut scan = names.map(|name| seen(name, 84, 1));
    scan.sort_by(|a, b| a.path.cmp(&b.path));
    settler.observe_scan(&scan, 0.0, whole);
    let expected = [("in/Bracket.STL", vec!["in/bracket.stl.toml"]), ("in/Gro\u{308}ße.stl", vec!["in/größe.toml"])];
    let ready = settler.observe_scan(&scan, 5.0, whole);
    assert_eq!(with_tickets(&ready), expected);
    assert_eq!(blocked(&ready), ["in/A.stl", "in/a.stl"]);
}

#[test]
fn a_part_waits_for_a_list_that_is_being_written() {
    let mut settler = SettleTracker::new(RULES);
    let part = seen("in/a.stl", 84, 1);
    settler.observe_scan(&[part.clone(), seen("in/order.csv", 30, 1)], 0.0, whole);
    let scan = [part, seen("in/order.csv", 31, 2)];
    assert_eq!(settler.observe_scan(&scan, 5.0, whole), []);
    assert_eq!(settler.observe_scan(&scan, 10.0, whole).len(), 2);
}

#[test]
fn a_second_list_in_other_letters_is_refused() {
    let mut settler = SettleTracker::new(RULES);
    let scan = [seen("in/Order.csv", 30, 1), seen("in/order.csv", 30, 1)];
    settler.observe_scan(&scan, 0.0, whole);
    let ready = settler.observe_scan(&scan, 5.0, whole);
    assert!(matches!(&ready[..], [SettledEntry::List { .. }, SettledEntry::Refuse { .. }]), "{ready:?}");
}

#[test]
fn what_is_no_file_is_refused_after_settling() {
    let mut settler = SettleTracker::new(RULES);
    let kinds = [EntryKind::Symlink, EntryKind::Directory, EntryKind::Socket, EntryKind::Fifo, EntryKind::Device];
    let scan: Vec<InboxEntry> = (kinds.iter().enumerate())
        .map(|(i, &kind)| InboxEntry { kind, ..seen(&format!("in/{i}.stl"), 0, 1) })
        .collect();
    assert_eq!(settler.observe_scan(&scan, 0.0, cut), []);
    assert_eq!(
        settler.observe_scan(&scan, 5.0, cut).iter().filter(|r| matches!(r, SettledEntry::Refuse { .. })).count(),
        5
    );
}

#[test]
fn an_empty_file_and_one_of_an_unknown_kind_are_taken_too() {
    let mut settler = SettleTracker::new(RULES);
    let scan = [seen("in/empty.stl", 0, 1), seen("in/notes.txt", 9, 1), seen("in/no_extension", 9, 1)];
    settler.observe_scan(&scan, 0.0, whole);
    assert_eq!(
        parts(&settler.observe_scan(&scan, 5.0, whole)).len(),
        2,
        "the text may be a ticket of a part that is slower"
    );
    assert_eq!(parts(&settler.observe_scan(&scan, 15.0, whole)).len(), 3);
}

#[test]
fn the_settler_says_when_to_look_again() {
    let mut settler = SettleTracker::new(RULES);
    assert_eq!(settler.next_scan_secs(0.0), None);
    settler.observe_scan(&[seen("in/a.stl", 84, 1)], 10.0, whole);
    assert_eq!(settler.next_scan_secs(12.0), Some(3.0));
}

/// The parts that wait because of what stands beside them.
fn blocked(ready: &[SettledEntry]) -> Vec<&str> {
    ready
        .iter()
        .filter_map(|one| if let SettledEntry::Blocked { part, .. } = one { part.path.to_str() } else { None })
        .collect()
}

/// Names of the tickets of each settled part.
fn with_tickets(ready: &[SettledEntry]) -> Vec<(&str, Vec<&str>)> {
    ready
        .iter()
        .filter_map(|r| match r {
            SettledEntry::Part { part, tickets, .. } => {
                Some((part.path.to_str()?, tickets.iter().filter_map(|t| t.path.to_str()).collect()))
            }
            _ => None,
        })
        .collect()
}

#[test]
fn a_ticket_without_the_parts_extension_is_of_the_one_part_of_that_name() {
    let mut settler = SettleTracker::new(RULES);
    let names = ["in/a.json", "in/a.STL", "in/b.3mf", "in/b.toml", "in/b.txt", "in/k/b.stl"];
    let scan = names.map(|name| seen(name, 84, 1));
    settler.observe_scan(&scan, 0.0, whole);
    let ready = settler.observe_scan(&scan, 5.0, whole);
    let expected = [("in/a.STL", vec!["in/a.json"]), ("in/b.3mf", vec!["in/b.toml"]), ("in/k/b.stl", vec![])];
    assert_eq!(with_tickets(&ready), expected);
    // The part waits for it like for any other ticket.
    let growing = names.map(|name| seen(name, 84, if name == "in/b.toml" { 2 } else { 1 }));
    assert!(!parts(&settler.observe_scan(&growing, 6.0, whole)).contains(&"in/b.3mf"));
}

#[test]
fn parts_wait_for_a_ticket_that_could_be_of_several_and_so_does_the_last_one_left() {
    let mut settler = SettleTracker::new(RULES);
    let scan = [seen("in/a.3mf", 84, 1), seen("in/a.stl", 84, 1), seen("in/a.toml", 9, 1)];
    settler.observe_scan(&scan, 0.0, whole);
    assert_eq!(blocked(&settler.observe_scan(&scan, 5.0, whole)), ["in/a.3mf", "in/a.stl"]);
    assert_eq!(blocked(&settler.observe_scan(&scan[1..], 10.0, whole)), ["in/a.stl"]);
    let ready = settler.observe_scan(&scan[2..], 3600.0, whole);
    let [SettledEntry::Refuse { reason, .. }] = &ready[..] else { panic!("{ready:?}") };
    assert!(reason.contains("several parts were called \"a\""), "{reason}");
    // A ticket that is rewritten for the only remaining part is unambiguous.
    let anew = [seen("in/a.stl", 84, 1), seen("in/a.toml", 9, 2)];
    settler.observe_scan(&anew, 3601.0, whole);
    assert_eq!(with_tickets(&settler.observe_scan(&anew, 3606.0, whole)), [("in/a.stl", vec!["in/a.toml"])]);
}

#[test]
fn a_ticket_that_names_a_part_in_full_is_of_no_other() {
    let mut settler = SettleTracker::new(RULES);
    let names =
        ["in/a", "in/a.stl", "in/a.toml", "in/b.stl.3mf", "in/b.stl.toml", "in/c.stl", "in/c.stl.toml", "in/c.toml"];
    let scan = names.map(|name| seen(name, 84, 1));
    settler.observe_scan(&scan, 0.0, whole);
    let expected = [
        ("in/a", vec!["in/a.toml"]),
        ("in/a.stl", vec![]),
        ("in/b.stl.3mf", vec![]),
        ("in/c.stl", vec!["in/c.stl.toml", "in/c.toml"]), // two are refused when they are read
    ];
    assert_eq!(with_tickets(&settler.observe_scan(&scan, 5.0, whole)), expected);
}
