//! Files that nobody has ordered: recycle bins, folders of the past, backups, unfinished downloads, conflict copies, what a sync program puts back.

use std::{
    fs,
    io::Write,
    time::{Duration, SystemTime, UNIX_EPOCH},
};

use ledger::{CommandKind, CommandState, PartState};
use zip::{ZipWriter, write::SimpleFileOptions};

use crate::{
    AlertKind,
    driven_tests::{HandDrivenFarm, QUICK, block, stl},
};

fn farm() -> HandDrivenFarm {
    HandDrivenFarm::open(&format!("{QUICK}incomplete_secs = 8\n[trigger]\nmax_wait_secs = \"24h\"\n"))
}

/// A tetrahedron of 10 mm as a 3MF file.
fn threemf() -> Vec<u8> {
    let model = "<?xml version=\"1.0\"?><model unit=\"millimeter\" xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">\
                 <resources><object id=\"1\" type=\"model\"><mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"10\" y=\"0\" z=\"0\"/>\
                 <vertex x=\"0\" y=\"10\" z=\"0\"/><vertex x=\"0\" y=\"0\" z=\"10\"/></vertices><triangles><triangle v1=\"0\" v2=\"2\" v3=\"1\"/>\
                 <triangle v1=\"0\" v2=\"1\" v3=\"3\"/><triangle v1=\"0\" v2=\"3\" v3=\"2\"/><triangle v1=\"1\" v2=\"2\" v3=\"3\"/></triangles></mesh>\
                 </object></resources><build><item objectid=\"1\"/></build></model>";
    let types = "<?xml version=\"1.0\"?><Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\"><Default \
                 Extension=\"rels\" ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/><Default \
                 Extension=\"model\" ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/></Types>";
    let rels = "<?xml version=\"1.0\"?><Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"><Relationship \
                Target=\"/3D/3dmodel.model\" Id=\"r\" Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>";
    let mut zip = ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, text) in [("[Content_Types].xml", types), ("_rels/.rels", rels), ("3D/3dmodel.model", model)] {
        zip.start_file(name, SimpleFileOptions::default()).unwrap();
        zip.write_all(text.as_bytes()).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// Names of the waiting parts that are asked about, and of those that are not, sorted.
fn asked(farm: &HandDrivenFarm) -> (Vec<String>, Vec<String>) {
    let mut parts = farm.parts(PartState::Waiting);
    parts.sort_by(|a, b| a.name.cmp(&b.name));
    let (asked, clear): (Vec<_>, Vec<_>) = parts.into_iter().partition(|part| !part.owed.question.is_empty());
    let names = |parts: Vec<ledger::PartRow>| parts.into_iter().map(|part| part.name).collect();
    (names(asked), names(clear))
}

#[test]
fn recycle_bins_snapshots_backups_and_unfinished_downloads_are_left_alone() {
    let mut farm = farm();
    let folders = [
        "#recycle",
        "@Recycle",
        "$RECYCLE.BIN",
        "RECYCLER",
        "#snapshot",
        "~snapshot",
        ".snapshot",
        "@Recently-Snapshot",
        "@tmp",
        "System Volume Information",
        "lost+found",
        "Network Trash Folder",
        "y.stl.download",
    ];
    let mut left: Vec<String> =
        folders.iter().flat_map(|folder| [format!("{folder}/a.stl"), format!("kit/{folder}/deep/a.stl")]).collect();
    let endings =
        ["~", ".bak", ".BAK", ".old", ".orig", ".temp", ".opdownload", ".!sync", ".uploading", ".download", ".swp"];
    left.extend(endings.map(|ending| format!("x.stl{ending}")));
    left.extend(["#x.stl#".to_owned(), "kit/x.stl.1.bak".to_owned()]);
    for (at, name) in left.iter().enumerate() {
        farm.drop_bytes(name, &stl(&block(10.0, 12.0, 14.0 + at as f64)));
    }
    farm.drop_part("kit/good.stl", &block(10.0, 12.0, 9.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.pass_secs(30.0);
    let states = [PartState::Claimed, PartState::Waiting, PartState::Refused];
    assert_eq!(states.map(|state| farm.parts(state).len()), [0, 1, 0]);
    assert!(left.iter().all(|name| farm.folder("inbox").join(name).exists()));
    assert!(!farm.has_alert(AlertKind::Refused));
}

#[test]
fn conflict_copies_are_asked_about_and_the_file_itself_is_printed() {
    let mut farm = farm();
    let copies = [
        "x (1).stl",
        "x (Anna's conflicted copy 2026-01-01).stl",
        "x (conflicted copy 2026-01-01 120000).stl",
        "x - Copy.stl",
        "x - Kopie (2).stl",
        "Copy of x.stl",
        "x-DESKTOP-ABC123.stl",
        "x.sync-conflict-20260101-120000-ABCDEFG.stl",
    ];
    for (at, name) in copies.iter().chain(&["x.stl", "y (Copy).stl", "z-LAPTOP.stl"]).enumerate() {
        farm.drop_part(&format!("kit/{name}"), &block(10.0, 12.0, 14.0 + at as f64));
    }
    farm.wait_for_parts(PartState::Waiting, copies.len() + 3);
    let (questions, clear) = asked(&farm);
    let mut sorted = copies.map(str::to_owned).to_vec();
    sorted.sort();
    assert_eq!(questions, sorted);
    assert_eq!(clear, ["x.stl", "y (Copy).stl", "z-LAPTOP.stl"]);
    let part = farm.parts(PartState::Waiting).into_iter().find(|part| part.name.starts_with("x (conf")).unwrap();
    assert!(part.owed.question.contains("x.stl"), "{}", part.owed.question);
    assert_eq!(farm.order_and_wait(CommandKind::Cancel, Some(part.id)).state, CommandState::Done);
}

#[test]
fn a_file_is_asked_about_if_a_copy_of_it_came_before_it() {
    let mut farm = farm();
    for (at, name) in ["kit/x - Copy.stl", "other/x.stl", "y - Copy.3mf.stl"].iter().enumerate() {
        farm.drop_part(name, &block(10.0, 12.0, 14.0 + at as f64));
    }
    farm.wait_for_parts(PartState::Waiting, 3);
    assert_eq!(asked(&farm).0, [""; 0], "nobody ordered an original");
    farm.drop_part("kit/x.stl", &block(10.0, 12.0, 18.0));
    farm.drop_part("kit/xx.stl", &block(10.0, 12.0, 19.0));
    farm.wait_for_parts(PartState::Waiting, 5);
    assert_eq!(asked(&farm).0, ["x.stl"]);
    let part = farm.parts(PartState::Waiting).into_iter().find(|part| !part.owed.question.is_empty()).unwrap();
    assert_eq!(part.terms.order_name, "kit");
    assert!(
        part.owed.question.contains("x - Copy.stl (part 1) has the name of a copy of it"),
        "{}",
        part.owed.question
    );
}

#[test]
fn a_conflict_copy_with_a_ticket_of_its_own_and_a_copy_without_its_original_are_printed() {
    let mut farm = farm();
    farm.drop_bytes("x (1).stl.toml", b"copies = 2\n");
    farm.drop_part("x (1).stl", &block(10.0, 12.0, 14.0));
    farm.drop_part("x.stl", &block(10.0, 12.0, 15.0));
    farm.drop_part("y - Kopie.stl", &block(10.0, 12.0, 16.0));
    farm.wait_for_parts(PartState::Waiting, 3);
    assert_eq!(asked(&farm).0, [""; 0]);
}

#[test]
fn the_same_part_in_several_formats_is_printed_once_and_asked_about() {
    let mut farm = farm();
    farm.drop_bytes("kit/x.3mf", &threemf());
    farm.drop_part("kit/x.stl", &block(10.0, 12.0, 14.0));
    farm.drop_part("kit/y.stl", &block(10.0, 12.0, 15.0));
    farm.drop_part("other/x.stl", &block(10.0, 12.0, 16.0));
    farm.wait_for_parts(PartState::Waiting, 4);
    let (questions, clear) = asked(&farm);
    assert_eq!((questions.len(), clear.len()), (1, 3), "{questions:?}");
    let part = farm.parts(PartState::Waiting).into_iter().find(|part| !part.owed.question.is_empty()).unwrap();
    assert_eq!((part.name.as_str(), part.terms.order_name.as_str()), ("x.stl", "kit"));
    assert!(part.owed.question.contains("x.3mf"), "{}", part.owed.question);
}

#[test]
fn a_list_of_another_program_holds_the_parts_beside_it() {
    let mut farm = farm();
    let lists = [
        ("order.json", "{\"lines\": [{\"file\": \"a.stl\", \"quantity\": 4}]}"),
        ("export.json", "[{\"part\": \"a\", \"qty\": 4}]"),
        ("order.xml", "<order><line file='a.stl' qty='4'/></order>"),
        ("mengen.yaml", "a.stl: 4\n"),
    ];
    for (at, (name, text)) in lists.into_iter().enumerate() {
        farm.drop_part(&format!("{at}/a.stl"), &block(10.0, 12.0, 14.0 + at as f64));
        farm.drop_bytes(&format!("{at}/{name}"), text.as_bytes());
    }
    farm.pass_secs(4.0);
    assert!(farm.parts(PartState::Waiting).is_empty() && farm.has_alert(AlertKind::Incomplete));
    let reason = farm.folder("error").join("0/order.json.reason.txt");
    farm.pass_until("it is refused after the part", |_| reason.exists());
    let refused = farm.parts(PartState::Refused).into_iter().filter(|part| part.name == "a.stl").count();
    assert_eq!((refused, farm.parts(PartState::Waiting).len()), (4, 0));
    assert!(fs::read_to_string(reason).unwrap().contains("Save it as XLSX or CSV"));
}

#[test]
fn a_file_that_is_put_back_with_its_time_is_asked_about_and_a_new_drop_is_not() {
    let mut farm = farm();
    let bytes = stl(&block(10.0, 12.0, 14.0));
    let dropped = SystemTime::now() - Duration::from_secs(3600);
    let whole_secs = UNIX_EPOCH + Duration::from_secs(dropped.duration_since(UNIX_EPOCH).unwrap().as_secs());
    let put_back_at = |farm: &HandDrivenFarm, name: &str, time: SystemTime| {
        let (outside, inside) = (farm.root().join("sent"), farm.folder("inbox").join(name));
        fs::create_dir_all(inside.parent().unwrap()).unwrap();
        fs::write(&outside, &bytes).unwrap();
        fs::File::options().write(true).open(&outside).unwrap().set_modified(time).unwrap();
        fs::rename(outside, inside).unwrap();
    };
    let put_back = |farm: &HandDrivenFarm, name: &str| put_back_at(farm, name, dropped);
    put_back(&farm, "kit/a_x3.stl");
    farm.wait_for_parts(PartState::Waiting, 1);
    // Programs that copy files round their times.
    put_back_at(&farm, "kit/a_x3.stl", whole_secs);
    let parts = farm.wait_for_parts(PartState::Waiting, 2);
    assert_eq!(parts[0].owed.question, "");
    assert!(parts[1].owed.question.contains(&format!("part {}", parts[0].id)), "{}", parts[1].owed.question);
    farm.order(CommandKind::Flush, None);
    let queued = farm.wait_for_queued(1);
    assert_eq!(build_file::read_build(&queued[0], &build_file::ReadLimits::default()).unwrap().len(), 3);
    farm.pass_secs(1.0);
    // In another order, under another name or with another time it is wanted.
    put_back(&farm, "other/a_x3.stl");
    put_back(&farm, "kit/b_x3.stl");
    farm.drop_bytes("kit/a_x3.stl", &bytes);
    farm.wait_for_parts(PartState::Waiting, 4);
    assert_eq!(asked(&farm).0, ["a_x3.stl"]);
    // What was refused was put back by a person.
    let asked = farm.parts(PartState::Waiting).into_iter().find(|part| !part.owed.question.is_empty()).unwrap();
    assert_eq!(farm.order_and_wait(CommandKind::Cancel, Some(asked.id)).state, CommandState::Done);
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn folders_of_the_past_are_asked_about_and_recycle_bins_stay_and_are_told() {
    let mut farm = farm();
    let past = ["old/a.stl", "kit/Sicherung/b.stl", "alt/1042/c.stl"];
    let left =
        ["Papierkorb/d.stl", "kit/Recycle Bin/e.stl", "Backups.backupdb/f.stl", ".Trashes/g.stl", "lost+found/h.stl"];
    for (at, name) in past.iter().chain(&left).enumerate() {
        farm.drop_part(name, &block(10.0, 12.0, 14.0 + at as f64));
    }
    farm.drop_bytes("old/order.csv", b"file,copies\na.stl,3\n");
    farm.drop_part("1043/good.stl", &block(10.0, 12.0, 9.0));
    let waiting = farm.wait_for_parts(PartState::Waiting, past.len() + 1);
    assert_eq!(asked(&farm), (["a.stl", "b.stl", "c.stl"].map(str::to_owned).to_vec(), vec!["good.stl".to_owned()]));
    let part = waiting.into_iter().find(|part| part.name == "a.stl").unwrap();
    assert!(part.owed.question.contains("folder called old"), "{}", part.owed.question);
    farm.pass_until("the bins are told", |farm| farm.has_alert(AlertKind::FolderUnseen));
    assert!(left.iter().all(|name| farm.folder("inbox").join(name).exists()));
    assert_eq!(farm.order_and_wait(CommandKind::Confirm, Some(part.id)).state, CommandState::Done);
}

#[test]
fn backups_are_asked_about_and_numbered_files_where_their_original_is() {
    let mut farm = farm();
    let doubtful = ["o.stl.1", "o_1.stl", "q~1.stl", "r-backup.stl", "s.bak.stl", "t_old.stl"];
    let clear = ["o.stl", "p_1.stl", "t.stl", "u_old.stl"];
    for (at, name) in doubtful.iter().chain(&clear).enumerate() {
        farm.drop_part(&format!("kit/{name}"), &block(10.0, 12.0, 14.0 + at as f64));
    }
    farm.wait_for_parts(PartState::Waiting, doubtful.len() + clear.len());
    assert_eq!(asked(&farm), (doubtful.map(str::to_owned).to_vec(), clear.map(str::to_owned).to_vec()));
}
