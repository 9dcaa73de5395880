//! A file that takes the place of earlier ones, and one that was put back and takes none.

use std::{
    fs,
    time::{Duration, SystemTime},
};

use build_file::LengthUnit;
use ledger::{CommandKind, CommandState, PartRow, PartState};

use crate::driven_tests::{HandDrivenFarm, QUICK, block, stl};

fn farm() -> HandDrivenFarm {
    HandDrivenFarm::open(&format!("{QUICK}incomplete_secs = 8\n[trigger]\nmax_wait_secs = \"24h\"\n"))
}

/// A mesh with a hole.
fn torn() -> Vec<u8> {
    let mut bytes = stl(&block(0.4, 0.4, 0.5));
    let facets = u32::from_le_bytes(bytes[80..84].try_into().unwrap());
    bytes[80..84].copy_from_slice(&(facets - 1).to_le_bytes());
    bytes.truncate(bytes.len() - 50);
    bytes
}

fn only_waiting(farm: &mut HandDrivenFarm) -> PartRow {
    farm.wait_for_parts(PartState::Waiting, 1).remove(0)
}

/// Drops a file with this time.
fn drop_at(farm: &HandDrivenFarm, name: &str, bytes: &[u8], time: SystemTime) {
    let (outside, inside) = (farm.root().join("sent"), farm.folder("inbox").join(name));
    fs::create_dir_all(inside.parent().unwrap()).unwrap();
    fs::write(&outside, bytes).unwrap();
    fs::File::options().write(true).open(&outside).unwrap().set_modified(time).unwrap();
    fs::rename(outside, inside).unwrap();
}

#[test]
fn what_was_asked_with_a_refused_part_is_asked_with_the_mended_one() {
    let tickets = [
        ("kit/p.stl.toml", "copies = 3\nunit = \"inch\"\npriority = 90\ncustomer = \"Brandt\"\n"),
        ("kit/order.csv", "file,copies,unit,priority,customer\np.stl,3,inch,90,Brandt\n"),
    ];
    for (name, text) in tickets {
        let mut farm = farm();
        farm.drop_bytes("kit/p.stl", &torn());
        farm.drop_bytes(name, text.as_bytes());
        farm.wait_for_parts(PartState::Refused, 1);
        farm.drop_part("kit/p.stl", &block(0.4, 0.4, 0.5));
        let part = only_waiting(&mut farm);
        let asked = (part.owed.copies, part.terms.unit, part.terms.priority, part.terms.customer.as_str());
        assert_eq!(asked, (3, Some(LengthUnit::Inch), 90, "Brandt"), "{name}");
        assert!((part.measures.size_z_mm.unwrap() - 12.7).abs() < 1e-3, "{name}: {:?}", part.size_mm());
        assert_eq!(part.owed.question, "", "{name}");
        farm.assert_ledger_agrees_with_folders();
    }
}

#[test]
fn a_mended_part_whose_copies_were_never_known_is_asked_about() {
    let mut farm = farm();
    farm.drop_part("kit/p.stl", &block(10.0, 12.0, 14.0));
    farm.drop_bytes("kit/order.csv", b"file,copies\np.stl,abc\n");
    farm.wait_for_parts(PartState::Refused, 1);
    farm.pass_until("the list is out", |farm| !farm.folder("inbox").join("kit/order.csv").exists());
    farm.drop_part("kit/p.stl", &block(10.0, 12.0, 15.0));
    let part = only_waiting(&mut farm);
    assert!(part.owed.question.contains("nothing says how many are wanted"), "{}", part.owed.question);
}

#[test]
fn the_copies_of_several_parts_whose_place_a_file_takes_are_asked_for() {
    let mut farm = farm();
    let bytes = stl(&block(10.0, 12.0, 14.0));
    for wanted in 1..=2 {
        farm.drop_bytes("kit/a.stl.toml", b"copies = 3\ncustomer = \"Brandt\"\n");
        farm.drop_bytes("kit/a.stl", &bytes);
        farm.wait_for_parts(PartState::Waiting, wanted);
    }
    farm.drop_part("kit/a.stl", &block(10.0, 12.0, 15.0));
    farm.pass_until("the earlier ones are out", |farm| farm.parts(PartState::Refused).len() == 2);
    let part = only_waiting(&mut farm);
    assert!(part.owed.question.contains("(3 wanted)"), "{}", part.owed.question);
    assert_eq!(part.terms.customer, "Brandt");
    assert_eq!(farm.order_and_wait(CommandKind::Confirm, Some(part.id)).state, CommandState::Done);
}

#[test]
fn a_file_that_is_put_back_after_a_move_a_cancellation_or_a_revision_is_asked_about() {
    let time = SystemTime::now() - Duration::from_secs(3600);
    let bytes = stl(&block(10.0, 12.0, 14.0));
    for story in ["moved", "cancelled", "revised"] {
        let mut farm = farm();
        farm.write_profile("other", &format!("{QUICK}[trigger]\nmax_wait_secs = \"24h\"\n"));
        farm.reload();
        drop_at(&farm, "kit/a.stl", &bytes, time);
        let part = only_waiting(&mut farm).id;
        match story {
            "moved" => {
                farm.ask(async |ledger| ledger.move_to_machine(part, "other", false, "ann").await.unwrap());
                farm.pass_secs(2.0);
            }
            "cancelled" => {
                farm.order_and_wait(CommandKind::Cancel, Some(part));
                farm.pass_until("it is out", |farm| farm.parts(PartState::Refused).len() == 1);
            }
            _ => {
                drop_at(&farm, "kit/a.stl", &stl(&block(10.0, 12.0, 15.0)), time + Duration::from_secs(99));
                farm.pass_until("the first is out", |farm| farm.parts(PartState::Refused).len() == 1);
            }
        }
        farm.pass_secs(2.0);
        drop_at(&farm, "kit/a.stl", &bytes, time);
        let is_asked = |farm: &HandDrivenFarm| {
            farm.parts(PartState::Waiting).iter().any(|part| part.owed.question.contains("put back"))
        };
        farm.pass_until(story, is_asked);
        let waiting = farm.parts(PartState::Waiting);
        let clear = waiting.iter().filter(|part| part.owed.question.is_empty());
        assert_eq!(clear.count(), usize::from(story != "cancelled"), "{story}: {waiting:?}");
        if story == "revised" {
            let newer = waiting.iter().find(|part| part.owed.question.is_empty()).unwrap();
            assert_eq!(newer.measures.size_z_mm, Some(15.0), "the newer revision stays");
        }
    }
}

#[test]
fn a_revision_that_is_dropped_where_its_part_was_moved_away_from_is_asked_about() {
    let mut farm = farm();
    farm.write_profile("other", &format!("{QUICK}[trigger]\nmax_wait_secs = \"24h\"\n"));
    farm.reload();
    farm.drop_bytes("kit/a.stl.toml", b"copies = 3\n");
    farm.drop_part("kit/a.stl", &block(10.0, 12.0, 14.0));
    let part = only_waiting(&mut farm).id;
    farm.ask(async |ledger| ledger.move_to_machine(part, "other", false, "ann").await.unwrap());
    farm.pass_secs(2.0);
    farm.drop_part("kit/a.stl", &block(10.0, 12.0, 15.0));
    let is_asked = |farm: &HandDrivenFarm| {
        farm.parts(PartState::Waiting).iter().any(|one| one.owed.question.contains("was moved to other"))
    };
    farm.pass_until("it is asked about", is_asked);
    let machines: Vec<String> = farm.parts(PartState::Waiting).into_iter().map(|part| part.machine).collect();
    assert_eq!(machines.len(), 2, "{machines:?}");
}
