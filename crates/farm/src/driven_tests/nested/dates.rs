//! Due dates as people write them, in the time zone of the farm.

use ledger::{PartRow, PartState};

use crate::{
    CakeContents,
    driven_tests::{HandDrivenFarm, QUICK, block},
};

/// The due date of a part: the instant, and the date as it was given.
fn due(part: &PartRow) -> (String, &str) {
    (part.terms.due_at.unwrap().to_string(), &part.terms.due_text)
}

#[test]
fn a_day_is_due_at_its_end_in_the_zone_of_the_farm_and_is_that_day_everywhere() {
    let mut farm = HandDrivenFarm::closed(QUICK);
    farm.write_time_zone("Europe/Berlin");
    farm.start();
    farm.drop_bytes(
        "liste.csv",
        "Datei;St\u{fc}ck;Liefertermin;Bemerkung\na.stl;2;24.12.2098;nicht <strahlen>\n".as_bytes(),
    );
    farm.drop_part("a.stl", &block(10.0, 10.0, 10.0));
    let parts = farm.wait_for_parts(PartState::Waiting, 1);
    assert_eq!(due(&parts[0]), ("2098-12-24T22:59:59.000Z".to_owned(), "2098-12-24"));
    let settings = settings::load_settings(Some(&farm.root().join("config/nestd.toml")), Some(farm.root())).unwrap();
    assert_eq!(settings.time_zone.format_due(parts[0].terms.due_at.unwrap().0, &parts[0].terms.due_text), "2098-12-24");
    farm.order(ledger::CommandKind::Flush, None);
    let file = farm.wait_for_queued(1).remove(0);
    let placed = build_file::read_build(&file, &Default::default()).unwrap();
    let cake = CakeContents::from_placed_meshes(&placed, glam::DVec3::splat(120.0));
    assert_eq!((cake.parts[0].due.as_str(), cake.parts[0].note.as_str()), ("2098-12-24", "nicht _strahlen_"));
    let map = std::fs::read_to_string(
        file.with_file_name(file.file_name().unwrap().to_str().unwrap().replace(".build.3mf", ".parts.csv")),
    );
    let map = map.unwrap();
    assert!(map.lines().next().unwrap().ends_with(",due,note,reference,material"), "{map}");
    assert!(map.lines().nth(1).unwrap().ends_with(",2098-12-24,nicht <strahlen>,,"), "{map}");
}

#[test]
fn a_warning_of_a_due_date_names_the_day_that_was_given() {
    for zone in ["Europe/Berlin", "America/Los_Angeles", "Pacific/Kiritimati"] {
        let mut farm = HandDrivenFarm::closed(QUICK);
        farm.write_time_zone(zone);
        farm.start();
        farm.drop_bytes("a.stl.toml", b"due = 2020-12-24");
        farm.drop_part("a.stl", &block(10.0, 10.0, 10.0));
        let part = farm.wait_for_parts(PartState::Waiting, 1)[0].id;
        farm.pass_secs(5.0);
        let events = farm.ask(async |ledger| ledger.events_of_part(part).await.unwrap());
        let said: Vec<&str> = events.iter().map(|event| event.detail.as_str()).collect();
        assert!(said.contains(&"a.stl is due 2020-12-24: that date has passed."), "{zone}: {said:#?}");
    }
}

#[test]
fn another_time_zone_concerns_the_dates_that_are_given_from_then_on() {
    let mut farm = HandDrivenFarm::closed(QUICK);
    farm.write_time_zone("Europe/Berlin");
    farm.start();
    farm.drop_bytes("a.stl.toml", b"due = 2098-12-24");
    farm.drop_part("a.stl", &block(10.0, 10.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.write_time_zone("Asia/Tokyo");
    farm.reload();
    farm.drop_bytes("b.stl.toml", b"due = 2098-12-24");
    farm.drop_part("b.stl", &block(10.0, 11.0, 10.0));
    let parts = farm.wait_for_parts(PartState::Waiting, 2);
    assert_eq!(due(&parts[0]), ("2098-12-24T22:59:59.000Z".to_owned(), "2098-12-24"));
    assert_eq!(due(&parts[1]), ("2098-12-24T14:59:59.000Z".to_owned(), "2098-12-24"));
}
