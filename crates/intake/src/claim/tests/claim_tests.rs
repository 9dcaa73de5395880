//! Tests of claims on real folders, interrupted after every step.

use std::{
    ffi::OsStr,
    io::Write,
    os::unix::{ffi::OsStrExt, fs::symlink},
};

use super::*;
use crate::{
    SpecSource, list_claims, recover_claims, remove_emptied_claims,
    test_inbox::{TestInbox, stops_at},
};

const LIST: &str = "file,copies\npart_x2.stl,7\n";

fn dropped() -> TestInbox {
    let farm = TestInbox::new();
    farm.drop_file("kit 1/part_x2.stl", "solid");
    farm.drop_file("kit 1/part_x2.stl.toml", "priority = 90");
    farm.drop_file("kit 1/order.csv", LIST);
    farm
}

#[test]
fn a_claim_takes_the_part_with_its_ticket_and_a_copy_of_the_list() {
    let farm = dropped();
    let claim = farm.claim();
    assert_eq!(farm.dropped(), ["kit 1/order.csv"]);
    assert_eq!((claim.name.as_os_str(), claim.order.as_str()), (OsStr::new("part_x2.stl"), "kit 1"));
    assert_eq!(claim.part, claim.dir.join("kit 1/part_x2.stl"));
    assert_eq!(claim.tickets, [claim.dir.join("kit 1/part_x2.stl.toml")]);
    let said = ListLookup::load_from(claim.list.as_ref().unwrap()).unwrap().unwrap();
    assert_eq!(said.row.as_deref(), Some(LIST.trim_end()));
    assert_eq!(recover_claims(&farm.inbox, "").unwrap().0, std::slice::from_ref(&claim));
    let given = claim.read_part_spec().unwrap();
    assert_eq!((given.ticket.copies, given.ticket.priority), (Some(7), Some(90)));
    let sources: Vec<SpecSource> = given.sources.iter().map(|s| s.source).collect();
    assert_eq!(sources, [SpecSource::Sidecar, SpecSource::OrderList, SpecSource::Name]);
    assert_eq!(release_claim(&claim, "").unwrap(), ReleaseOutcome::Removed);
    assert_eq!(release_claim(&claim, "").unwrap(), ReleaseOutcome::Removed);
    assert!(farm.claimed().is_empty() && recover_claims(&farm.inbox, "").unwrap().0.is_empty());
}

#[test]
fn many_claims_use_the_folders_of_removed_ones_again_and_none_stays() {
    let farm = TestInbox::new();
    let inode = |dir: &Path| std::os::unix::fs::MetadataExt::ino(&fs::metadata(dir).unwrap());
    let folders = || fs::read_dir(farm.inbox.join(".claimed")).unwrap().map(|entry| entry.unwrap().path());
    let mut inodes = std::collections::BTreeSet::new();
    for n in 0..60 {
        farm.drop_file(&format!("part-{n}.stl"), "solid");
        let claim = farm.claim();
        inodes.insert(inode(&claim.dir));
        assert_eq!(list_claims(&farm.inbox).unwrap().claims, std::slice::from_ref(&claim));
        release_claim(&claim, "").unwrap();
        if n == 40 {
            let kept = folders().find(|path| path.to_string_lossy().contains(".done-")).unwrap();
            fs::write(kept.join("theirs.stl"), "put there by somebody").unwrap();
        }
    }
    assert!(inodes.len() <= 20, "{} folders for 60 claims", inodes.len());
    assert!(recover_claims(&farm.inbox, "").unwrap().0.is_empty(), "a kept folder is no claim");
    farm.drop_file("last.stl", "solid");
    let last = farm.claim();
    assert_eq!(fs::read_dir(&last.dir).unwrap().count(), 1, "a folder that recovery removed is not used");
    release_claim(&last, "").unwrap();
    remove_emptied_claims(&farm.inbox);
    assert_eq!(
        folders().filter(|path| path.to_string_lossy().contains("Z-0")).collect::<Vec<_>>(),
        Vec::<PathBuf>::new()
    );
}

#[test]
fn ids_are_unique_and_sort_by_time() {
    let ids: Vec<String> = (0..200).map(|_| new_claim_id()).collect();
    assert!(ids.is_sorted(), "{ids:?}");
    let mut unique = ids.clone();
    unique.dedup();
    assert_eq!(unique, ids);
}

#[test]
fn a_claim_stopped_anywhere_leaves_the_part_with_its_ticket_at_exactly_one_place() {
    let mut both = [0, 0];
    for stop in 1.. {
        let farm = dropped();
        let ready = farm.ready_part();
        if !stops_at(stop, |step| claim_stepwise(&farm.inbox, &ready, "", step)) {
            assert!(stop > 8 && both[0] > 5 && both[1] > 0, "{stop} {both:?}");
            return;
        }
        let claims = recover_claims(&farm.inbox, "").unwrap().0;
        let all = ["kit 1/order.csv", "kit 1/part_x2.stl", "kit 1/part_x2.stl.toml"];
        match &claims[..] {
            [] => {
                assert_eq!(farm.dropped(), all, "stop {stop}");
                assert!(farm.claimed().is_empty());
                both[0] += 1;
            }
            [claim] => {
                assert_eq!(farm.dropped(), all[..1], "stop {stop}");
                assert_eq!(claim.read_part_spec().unwrap().ticket.copies, Some(7));
                assert_eq!(claim.read_part_spec().unwrap().ticket.priority, Some(90));
                both[1] += 1;
            }
            more => panic!("stop {stop}: {more:?}"),
        }
    }
}

#[test]
fn a_release_stopped_anywhere_leaves_a_whole_claim_or_none() {
    for stop in 1.. {
        let farm = dropped();
        let claim = farm.claim();
        if !stops_at(stop, |step| release_stepwise(&claim, "", step)) {
            assert!(stop > 3);
            return;
        }
        let left = recover_claims(&farm.inbox, "").unwrap().0;
        assert!(left.is_empty() || left == [claim.clone()], "stop {stop}: {left:?}");
        assert_eq!(release_claim(&claim, "").unwrap(), ReleaseOutcome::Removed);
        assert!(farm.claimed().is_empty());
        assert_eq!(farm.dropped(), ["kit 1/order.csv"]);
    }
}

#[test]
fn a_part_that_changed_after_it_settled_stays_in_the_hot_folder() {
    let farm = dropped();
    let ready = farm.ready_part();
    farm.drop_file("kit 1/part_x2.stl", "solid and more");
    assert!(matches!(claim_part(&farm.inbox, &ready), Err(ClaimError::Changed(_))));
    assert_eq!(farm.dropped().len(), 3);
    assert!(farm.claimed().is_empty());
    // The list changed: the result is the same.
    let ready = farm.ready_part();
    farm.drop_file("kit 1/order.csv", "file,copies\npart_x2.stl,8\n");
    assert!(matches!(claim_part(&farm.inbox, &ready), Err(ClaimError::Changed(_))));
    fs::remove_file(farm.inbox.join("kit 1/part_x2.stl")).unwrap();
    let ready = SettledEntry::Part {
        part: seen_part(&ready),
        tickets: Vec::new(),
        list: None,
        lookup: None,
        still_secs: 9.0,
        unfinished: false,
    };
    assert!(matches!(claim_part(&farm.inbox, &ready), Err(ClaimError::Gone(_))));
    assert_eq!(farm.dropped().len(), 2);
    assert!(farm.claimed().is_empty());
}

fn seen_part(ready: &SettledEntry) -> InboxEntry {
    let SettledEntry::Part { part, .. } = ready else { panic!("{ready:?}") };
    part.clone()
}

#[test]
fn a_part_that_is_written_after_it_was_claimed_comes_back_as_a_new_revision() {
    let farm = TestInbox::new();
    let path = farm.drop_file("a.stl", "solid");
    let mut late = fs::OpenOptions::new().append(true).open(&path).unwrap();
    let claim = farm.claim();
    farm.drop_file("a.stl", "another");
    late.write_all(b" more").unwrap();
    let back = farm.inbox.join("a (2).stl");
    assert_eq!(release_claim(&claim, "").unwrap(), ReleaseOutcome::GivenBack(back.clone()));
    assert_eq!(fs::read_to_string(back).unwrap(), "solid more");
    assert_eq!(farm.dropped(), ["a (2).stl", "a.stl"]);
    assert!(farm.claimed().is_empty());
}

#[test]
fn a_revision_whose_time_was_set_back_is_not_lost_and_a_file_whose_mode_changed_is_not_doubled() {
    use std::os::unix::fs::PermissionsExt;
    let farm = TestInbox::new();
    let path = farm.drop_file("a.stl", "solid one");
    let mut held = fs::OpenOptions::new().write(true).open(&path).unwrap();
    let claim = farm.claim();
    let hash = blake3::hash(b"solid one").to_hex().to_string();
    let before = held.metadata().unwrap().modified().unwrap();
    held.write_all(b"solid two").unwrap();
    held.set_modified(before).unwrap();
    let back = farm.inbox.join("a.stl");
    assert_eq!(release_claim(&claim, &hash).unwrap(), ReleaseOutcome::GivenBack(back.clone()));
    assert_eq!(fs::read_to_string(&back).unwrap(), "solid two");
    fs::remove_file(&back).unwrap();
    farm.drop_file("a.stl", "solid one");
    let claim = farm.claim();
    fs::set_permissions(&claim.part, fs::Permissions::from_mode(0o600)).unwrap();
    assert_eq!(release_claim(&claim, &hash).unwrap(), ReleaseOutcome::Removed);
    assert!(farm.dropped().is_empty() && farm.claimed().is_empty());
}

#[test]
fn what_is_given_back_keeps_its_ticket_under_a_free_name() {
    let farm = dropped();
    let claim = farm.claim();
    farm.drop_file("kit 1/part_x2.stl", "newer");
    let back = give_back_claim(&claim).unwrap();
    assert_eq!(back, farm.inbox.join("kit 1/part_x2 (2).stl"));
    let names = ["kit 1/order.csv", "kit 1/part_x2 (2).stl", "kit 1/part_x2 (2).stl.toml", "kit 1/part_x2.stl"];
    assert_eq!(farm.dropped(), names);
}

#[test]
fn a_folder_swapped_for_a_link_does_not_make_nestd_take_files_from_elsewhere() {
    let farm = TestInbox::new();
    farm.drop_file("kit/a.stl", "solid");
    let ready = farm.ready_part();
    let outside = farm.dir.path().join("outside");
    fs::rename(farm.inbox.join("kit"), &outside).unwrap();
    symlink(&outside, farm.inbox.join("kit")).unwrap();
    assert!(matches!(claim_part(&farm.inbox, &ready), Err(ClaimError::Gone(_))));
    assert!(outside.join("a.stl").exists());
}

#[test]
fn names_of_all_kinds_are_claimed() {
    let farm = TestInbox::new();
    let long = "n".repeat(251) + ".stl";
    for name in [b"a b.stl".as_slice(), b"two\nlines.stl", b"latin\xfc.stl", "部品 🔩.stl".as_bytes(), long.as_bytes()]
    {
        let path = farm.inbox.join("k\n\u{fc}").join(OsStr::from_bytes(name));
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, name).unwrap();
        let claim = farm.claim();
        assert_eq!(claim.name.as_bytes(), name);
        assert_eq!(claim.order, "k\\n\u{fc}");
        assert_eq!(fs::read(&claim.part).unwrap(), name);
        assert_eq!(recover_claims(&farm.inbox, "").unwrap().0, std::slice::from_ref(&claim));
        release_claim(&claim, "").unwrap();
    }
}

#[test]
fn broken_and_doubled_tickets_are_errors() {
    let farm = TestInbox::new();
    farm.drop_file("a.stl", "solid");
    farm.drop_file("a.stl.toml", "copys = 3");
    let error = farm.claim().read_part_spec().unwrap_err().to_string();
    assert!(error.contains("a.stl.toml") && error.contains("copys"), "{error}");
    farm.drop_file("b.stl", "solid");
    farm.drop_file("b.stl.toml", "copies = 3");
    farm.drop_file("b.stl.json", "{\"copies\":4}");
    let error = farm.claim().read_part_spec().unwrap_err().to_string();
    assert!(error.contains("b.stl.json") && error.contains("b.stl.toml"), "{error}");
    farm.drop_file("c.stl", "solid");
    fs::write(farm.inbox.join("c.stl.toml"), b"note = \"\xff\"").unwrap();
    assert!(farm.claim().read_part_spec().unwrap_err().to_string().contains("UTF-8"));
    farm.drop_file("d.stl", "solid");
    farm.drop_file("d.stl.toml", &"#".repeat(70_000));
    assert!(farm.claim().read_part_spec().unwrap_err().to_string().contains("longer than"));
}

#[test]
fn a_ticket_wins_over_the_list_and_the_list_over_the_name() {
    let farm = TestInbox::new();
    farm.drop_file("a_x10.stl", "solid");
    assert_eq!(farm.claim().read_part_spec().unwrap().ticket.copies, Some(10));
    farm.drop_file("a_x10.stl", "solid");
    farm.drop_file("order.csv", "file,copies,priority\na_x10.stl,3,60\n");
    assert_eq!(farm.claim().read_part_spec().unwrap().ticket.copies, Some(3));
    farm.drop_file("a_x10.stl", "solid");
    farm.drop_file("a_x10.stl.json", "{\"copies\":2}");
    let ticket = farm.claim().read_part_spec().unwrap().ticket;
    assert_eq!((ticket.copies, ticket.priority), (Some(2), Some(60)));
}

#[test]
fn strangers_in_the_folder_of_claims_do_no_harm() {
    let farm = dropped();
    let claim = farm.claim();
    fs::create_dir_all(farm.inbox.join(".claimed/empty")).unwrap();
    fs::write(farm.inbox.join(".claimed/a file"), "x").unwrap();
    assert_eq!(recover_claims(&farm.inbox, "").unwrap().0, [claim]);
    assert!(recover_claims(farm.dir.path(), "").unwrap().0.is_empty());
}

#[test]
fn a_name_whose_copies_are_not_understood_is_warned_of_unless_a_ticket_says_them() {
    let farm = TestInbox::new();
    farm.drop_file("part_x0.stl", "solid");
    let given = farm.claim().read_part_spec().unwrap();
    assert_eq!(given.ticket.copies, None);
    assert!(given.warnings.len() == 1 && given.warnings[0].contains("\"x0\""), "{:?}", given.warnings);
    farm.drop_file("part_x99999.stl", "solid");
    farm.drop_file("part_x99999.stl.toml", "copies = 3");
    let given = farm.claim().read_part_spec().unwrap();
    assert_eq!((given.ticket.copies, given.warnings), (Some(3), vec![]));
    farm.drop_file("part_x2.stl", "solid");
    assert!(farm.claim().read_part_spec().unwrap().warnings.is_empty());
}

#[test]
fn a_ticket_without_the_parts_extension_goes_with_its_part_wherever_that_goes() {
    let farm = TestInbox::new();
    farm.drop_file("plain.stl", "solid");
    farm.drop_file("plain.toml", "copies = 4");
    let claim = farm.claim();
    assert_eq!(claim.read_part_spec().unwrap().ticket.copies, Some(4));
    assert_eq!(claim.read_part_spec().unwrap().sources[0].file_name, "plain.toml");
    assert_eq!(recover_claims(&farm.inbox, "").unwrap().0, std::slice::from_ref(&claim));
    // By now, its short name would be ambiguous.
    farm.drop_file("plain.3mf", "PK");
    give_back_claim(&claim).unwrap();
    assert_eq!(farm.dropped(), ["plain.3mf", "plain.stl", "plain.stl.toml"]);
    fs::remove_file(farm.inbox.join("plain.3mf")).unwrap();
    assert_eq!(farm.claim().read_part_spec().unwrap().ticket.copies, Some(4));
}

#[test]
fn a_part_with_a_full_and_a_short_ticket_is_given_back_with_both() {
    let farm = TestInbox::new();
    for name in ["plain.stl", "plain.stl.toml", "plain.toml"] {
        farm.drop_file(name, "copies = 4");
    }
    let claim = farm.claim();
    assert!(claim.read_part_spec().unwrap_err().to_string().contains("two tickets"));
    give_back_claim(&claim).unwrap();
    assert_eq!(farm.dropped(), ["plain.stl", "plain.stl.toml", "plain.toml"]);
    assert!(farm.claimed().is_empty());
}

#[test]
fn a_claim_with_a_short_ticket_stopped_anywhere_keeps_the_two_together() {
    for stop in 1.. {
        let farm = TestInbox::new();
        farm.drop_file("plain.stl", "solid");
        farm.drop_file("plain.toml", "copies = 4");
        let ready = farm.ready_part();
        if !stops_at(stop, |step| claim_stepwise(&farm.inbox, &ready, "", step)) {
            assert!(stop > 5, "{stop}");
            return;
        }
        let claims = recover_claims(&farm.inbox, "").unwrap().0;
        let claim = claims.first().cloned().unwrap_or_else(|| farm.claim());
        assert_eq!(claim.read_part_spec().unwrap().ticket.copies, Some(4), "stop {stop}");
    }
}

/// Names as an old file server stores them, in Windows-1252.
const NAMES_IN_1252: [&[u8]; 4] =
    [b"Halter \x84neu\x93.stl", b"Teil \x96.stl", b"10\xd7 Deckel.stl", b"Tr\xe4ger_x4.stl"];

#[test]
fn copies_are_read_from_characters_and_asked_for_where_a_name_has_none() {
    for name in NAMES_IN_1252 {
        let farm = TestInbox::new();
        fs::write(farm.inbox.join(OsStr::from_bytes(name)), "solid").unwrap();
        let given = farm.claim().read_part_spec().unwrap();
        assert_eq!(given.ticket.copies, None, "{name:?}");
        assert!(
            given.warnings.len() == 1 && build_file::is_copies_question(&given.warnings[0]),
            "{:?}",
            given.warnings
        );
    }
    // An invisible character is shown as an escape; its digits count nothing.
    let farm = TestInbox::new();
    farm.drop_file("part_x\u{202e}.stl", "solid");
    let given = farm.claim().read_part_spec().unwrap();
    assert_eq!((given.ticket.copies, given.warnings), (None, vec![]));
}

#[test]
fn a_ticket_beside_a_name_that_is_no_text_says_its_copies() {
    let farm = TestInbox::new();
    for (ending, content) in [("", "solid"), (".toml", "copies = 3")] {
        let name = [NAMES_IN_1252[0], ending.as_bytes()].concat();
        fs::write(farm.inbox.join(OsStr::from_bytes(&name)), content).unwrap();
    }
    let given = farm.claim().read_part_spec().unwrap();
    assert_eq!((given.ticket.copies, given.warnings), (Some(3), vec![]));
}

#[test]
fn a_list_finds_a_file_whose_name_has_the_same_bytes() {
    for name in NAMES_IN_1252 {
        let farm = TestInbox::new();
        fs::write(farm.inbox.join(OsStr::from_bytes(name)), "solid").unwrap();
        let list = [b"Datei;St\xfcck\r\n", name, b";1200\r\nGr\xf6\xdfe.stl;2\r\n"].concat();
        fs::write(farm.inbox.join("order.csv"), list).unwrap();
        let given = farm.claim().read_part_spec().unwrap();
        assert_eq!((given.ticket.copies, given.warnings), (Some(1200), vec![]), "{name:?}");
    }
}
