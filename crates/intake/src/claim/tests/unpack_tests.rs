use std::{fs, io::Write};

use zip::{CompressionMethod, DateTime, ZipWriter, write::SimpleFileOptions};

use super::*;
use crate::{
    EntryKind, ScanLimits, recover_claims, scan_inbox,
    test_inbox::{TestInbox, files, stops_at},
};

fn options() -> SimpleFileOptions {
    let time = DateTime::from_date_and_time(2026, 3, 9, 10, 20, 30).unwrap();
    SimpleFileOptions::default().compression_method(CompressionMethod::Deflated).last_modified_time(time)
}

/// An archive with these files.
fn packed(entries: &[(&str, &str)]) -> Vec<u8> {
    let mut archive = ZipWriter::new(io::Cursor::new(Vec::new()));
    for (name, content) in entries {
        archive.start_file(*name, options()).unwrap();
        archive.write_all(content.as_bytes()).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// A hot folder with an archive of this content.
struct Dropped {
    farm: TestInbox,
    path: PathBuf,
}

impl Dropped {
    fn new(name: &str, bytes: &[u8]) -> Self {
        let farm = TestInbox::new();
        let path = farm.drop_file(name, "");
        fs::write(&path, bytes).unwrap();
        Self { farm, path }
    }

    fn seen(&self) -> InboxEntry {
        let found = scan_inbox(&self.farm.inbox, ScanLimits::default()).unwrap().entries;
        found.into_iter().find(|one| one.path == self.path && one.kind == EntryKind::File).unwrap()
    }

    fn unpack(&self, limits: &ReadLimits) -> UnpackOutcome {
        unpack_archive(&self.farm.inbox, &self.seen(), limits).unwrap()
    }

    fn refusal(&self, limits: &ReadLimits) -> String {
        let UnpackOutcome::Refused(reason) = self.unpack(limits) else { panic!("it is unpacked") };
        assert!(self.path.exists() && self.farm.claimed().is_empty(), "it stays as it is");
        reason
    }
}

#[test]
fn an_archive_becomes_the_order_folder_that_was_packed() {
    let bytes = packed(&[
        ("Kunde 7/order.csv", "file;copies\na.stl;4\n"),
        ("Kunde 7/a.stl", "solid a"),
        ("Kunde 7/sub/b.stl", "solid b"),
        ("__MACOSX/Kunde 7/._a.stl", "x"),
        ("Kunde 7/.DS_Store", "x"),
    ]);
    let dropped = Dropped::new("A-17.zip", &bytes);
    assert!(is_order_archive(&dropped.farm.inbox, &dropped.path));
    let folder = dropped.farm.inbox.join("A-17");
    assert_eq!(dropped.unpack(&ReadLimits::default()), UnpackOutcome::Unpacked(folder.clone()));
    assert_eq!(dropped.farm.dropped(), ["A-17/a.stl", "A-17/order.csv", "A-17/sub/b.stl"]);
    assert_eq!(fs::read_to_string(folder.join("a.stl")).unwrap(), "solid a");
    let changed: jiff::Timestamp = fs::metadata(folder.join("a.stl")).unwrap().modified().unwrap().try_into().unwrap();
    assert_eq!(changed.to_string(), "2026-03-09T10:20:30Z");
    assert!(dropped.farm.claimed().is_empty());
}

#[test]
fn an_order_of_a_name_that_is_taken_gets_a_number_and_files_keep_their_bytes() {
    let dropped = Dropped::new("kit/A.zip", &packed(&[("a.stl", "solid a"), ("b\\c.stl", "solid c")]));
    dropped.farm.drop_file("kit/A/old.stl", "solid old");
    let folder = dropped.farm.inbox.join("kit/A (2)");
    assert_eq!(dropped.unpack(&ReadLimits::default()), UnpackOutcome::Unpacked(folder));
    // Two files: the second name has a separator of Windows.
    assert_eq!(dropped.farm.dropped(), ["kit/A/old.stl", "kit/A (2)/a.stl", "kit/A (2)/b/c.stl"]);
}

#[test]
fn the_order_folder_has_no_name_of_a_file_or_of_what_is_ignored() {
    for (archive, folder) in [
        ("bracket.stl.zip", "bracket"),
        ("order.csv.zip", "order"),
        ("v1.2.zip", "v1.2"),
        ("kit.tmp.zip", "kit"),
        ("kit~.zip", "kit~ order"),
        ("Thumbs.db.ZIP", "Thumbs"),
    ] {
        let dropped = Dropped::new(archive, &packed(&[("a.stl", "solid a")]));
        assert_eq!(
            dropped.unpack(&ReadLimits::default()),
            UnpackOutcome::Unpacked(dropped.farm.inbox.join(folder)),
            "{archive}"
        );
        assert_eq!(dropped.farm.dropped(), [format!("{folder}/a.stl")]);
    }
}

#[test]
fn packages_under_the_name_of_an_archive_are_parts_and_no_archives() {
    for entries in [vec![("_rels/.rels", "<a/>"), ("3D/3dmodel.model", "<a/>")], vec![(".camspec.json", "{}")], vec![]]
    {
        let dropped = Dropped::new("a.zip", &packed(&entries));
        assert!(!is_order_archive(&dropped.farm.inbox, &dropped.path), "{entries:?}");
    }
    let whole = packed(&[("a.stl", "solid a")]);
    for bytes in [&whole[..whole.len() - 9], b"solid a".as_slice()] {
        let dropped = Dropped::new("a.zip", bytes);
        assert!(!is_order_archive(&dropped.farm.inbox, &dropped.path));
    }
    let dropped = Dropped::new("a.stl", &whole);
    assert!(!is_order_archive(&dropped.farm.inbox, &dropped.path));
}

#[test]
fn what_cannot_be_unpacked_safely_is_refused_with_a_remedy() {
    let bomb = "0".repeat(20 << 20);
    let twice = {
        let mut bytes = packed(&[("a.stl", "solid a"), ("b.stl", "solid b")]);
        let at: Vec<usize> = (0..bytes.len() - 5).filter(|&at| bytes[at..].starts_with(b"b.stl")).collect();
        at.iter().for_each(|&at| bytes[at] = b'a');
        bytes
    };
    let locked = {
        let mut bytes = packed(&[("a.stl", "solid a")]);
        let head = bytes.windows(4).position(|four| four == b"PK\x01\x02").unwrap();
        (bytes[6], bytes[head + 8]) = (bytes[6] | 1, bytes[head + 8] | 1);
        bytes
    };
    let damaged = {
        let mut bytes = packed(&[("a.stl", &"solid a of some length".repeat(9))]);
        bytes[45] ^= 0xff;
        bytes
    };
    let link = {
        let mut archive = ZipWriter::new(io::Cursor::new(Vec::new()));
        archive.add_symlink("a.stl", "/etc/passwd", options()).unwrap();
        archive.finish().unwrap().into_inner()
    };
    let limits = ReadLimits { max_entries: 3, max_unpacked_bytes: 64 << 20, ..ReadLimits::default() };
    for (bytes, why) in [
        (packed(&[("../a.stl", "x")]), "outside of it, \"../a.stl\""),
        (packed(&[("a/../../b.stl", "x")]), "outside of it"),
        (packed(&[("/etc/a.stl", "x")]), "outside of it"),
        (link, "a link, \"a.stl\""),
        (packed(&[("a.stl", "x"), ("more.zip", "PK")]), "another archive in it"),
        (packed(&[("__MACOSX/._a", "x")]), "no file in it"),
        (packed(&[("a", "x"), ("b", "x"), ("c", "x"), ("d", "x")]), "4 entries; the limit is 3"),
        (packed(&[("a.stl", &bomb)]), "unpacks to more than the limit"),
        (twice, "twice"),
        (locked, "cannot be unpacked"),
        (damaged, "cannot be unpacked"),
    ] {
        let reason = Dropped::new("a.zip", &bytes).refusal(&limits);
        assert!(reason.contains(why) && (reason.contains("npack") || reason.contains("Pack")), "{why}: {reason}");
    }
    let one = Dropped::new("a.zip", &packed(&[("a.stl", "solid a"), ("b.stl", "solid b")]));
    let little = ReadLimits { max_unpacked_bytes: 13, ..limits };
    assert!(one.refusal(&little).contains("max_unpacked_bytes"));
    assert!(matches!(one.unpack(&ReadLimits { max_unpacked_bytes: 14, ..little }), UnpackOutcome::Unpacked(_)));
}

#[test]
fn an_archive_that_changes_meanwhile_is_left_alone() {
    let dropped = Dropped::new("a.zip", &packed(&[("a.stl", "solid a")]));
    let seen = dropped.seen();
    let newer = packed(&[("a.stl", "solid newer")]);
    let mut steps = 0;
    let unpacked = unpack_stepwise(&dropped.farm.inbox, &seen, &ReadLimits::default(), &mut || {
        steps += 1;
        if steps == 2 {
            fs::write(&dropped.path, &newer).unwrap();
        }
    });
    assert!(matches!(unpacked, Err(ClaimError::Changed(_))), "{unpacked:?}");
    assert_eq!((fs::read(&dropped.path).unwrap(), dropped.farm.dropped()), (newer, vec!["a.zip".to_owned()]));
    assert!(dropped.farm.claimed().is_empty());
}

#[test]
fn after_a_crash_at_any_step_the_order_is_there_once() {
    let bytes = packed(&[("order.csv", "file;copies\na.stl;4\n"), ("a.stl", "solid a"), ("b.stl", "solid b")]);
    let whole = ["a/a.stl", "a/b.stl", "a/order.csv"];
    let mut seen_states = [0, 0];
    for stop in 1.. {
        let dropped = Dropped::new("a.zip", &bytes);
        let (inbox, seen) = (&dropped.farm.inbox, dropped.seen());
        if !stops_at(stop, |step| unpack_stepwise(inbox, &seen, &ReadLimits::default(), step)) {
            assert_eq!(dropped.farm.dropped(), whole);
            assert!(stop > 6, "{stop}");
            break;
        }
        let is_packed = dropped.farm.dropped() == ["a.zip"];
        seen_states[usize::from(is_packed)] += 1;
        for _ in 0..2 {
            let (claims, troubles) = recover_claims(inbox, "").unwrap();
            assert!(claims.is_empty() && troubles.is_empty(), "{troubles:?}");
            assert!(dropped.farm.claimed().is_empty(), "{:?}", files(&inbox.join(".claimed")));
            assert_eq!(dropped.farm.dropped(), if is_packed { vec!["a.zip"] } else { whole.to_vec() }, "step {stop}");
        }
    }
    assert!(seen_states.iter().all(|&count| count > 1), "{seen_states:?}");
}

#[test]
fn names_of_dos_in_an_archive_are_read_and_those_of_other_code_pages_keep_their_bytes() {
    for (letter, expected) in [(0x84_u8, "Geh\u{e4}use.stl".as_bytes()), (0xe4, &b"Geh\xe4use.stl"[..])] {
        let mut bytes = packed(&[("GehQuse.stl", "solid")]);
        while let Some(at) = bytes.windows(4).position(|four| four == b"GehQ") {
            bytes[at + 3] = letter;
        }
        let order = Dropped::new("o.zip", &bytes);
        let UnpackOutcome::Unpacked(folder) = order.unpack(&ReadLimits::default()) else { panic!("it is refused") };
        let name = fs::read_dir(folder).unwrap().next().unwrap().unwrap().file_name();
        assert_eq!(name.as_bytes(), expected);
    }
}
