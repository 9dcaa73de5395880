//! A ledger that cannot be changed for a while, as on a full disk.

use ledger::{CommandKind, Ledger, NightState, PartState};

use crate::{
    AlertKind,
    driven_tests::{
        HandDrivenFarm, MACHINE, QUICK, block,
        nested::night::{drop_mixed, go_on_with_round, lowering, rest},
    },
};

/// A ledger in which certain changes fail until they are allowed again.
pub struct RefusedChanges(sqlx::SqlitePool);

impl RefusedChanges {
    pub fn of(farm: &HandDrivenFarm, change: &str) -> Self {
        let pool = farm.ask(async |ledger| {
            let file = ledger.file().unwrap().display().to_string();
            let pool = sqlx::SqlitePool::connect(&format!("sqlite://{file}")).await.unwrap();
            let trigger = format!("CREATE TRIGGER refused BEFORE {change} BEGIN SELECT RAISE(ABORT, 'refused'); END");
            sqlx::query(sqlx::AssertSqlSafe(trigger)).execute(&pool).await.unwrap();
            pool
        });
        Self(pool)
    }

    pub fn allow(self, farm: &HandDrivenFarm) {
        farm.ask(async |_| {
            sqlx::query("DROP TRIGGER refused").execute(&self.0).await.unwrap();
            self.0.close().await;
        });
    }
}

#[test]
fn a_search_whose_end_the_ledger_refuses_goes_on_later() {
    let mut farm = HandDrivenFarm::open(&lowering(60.0));
    drop_mixed(&mut farm, 6);
    rest(&mut farm);
    for end in ["UPDATE OF layout, cpu_secs ON build", "INSERT ON night_search WHEN NEW.starts = 0"] {
        let begun = go_on_with_round(&mut farm, MACHINE, 0);
        let refused = RefusedChanges::of(&farm, end);
        farm.pass_secs(5.0);
        refused.allow(&farm);
        let row = rest(&mut farm);
        assert_eq!((row.state, row.starts), (NightState::StandsStill, 0), "{end}");
        assert!(row.cpu_secs > begun.cpu_secs, "{end}");
    }
}

#[test]
fn an_arrival_whose_layout_the_ledger_refuses_is_searched_again() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a_x6.stl", &block(50.0, 22.0, 13.0));
    farm.pass_until("the first stand in the open build", |farm| farm.open_copies().len() == 6);
    let kept =
        |farm: &HandDrivenFarm| farm.ask(async |ledger| ledger.open_build(MACHINE).await.unwrap().measures.copies);
    for (change, copies) in [("UPDATE OF layout ON build", 7), ("UPDATE OF searches ON build WHEN NEW.searches = 0", 8)]
    {
        let refused = RefusedChanges::of(&farm, change);
        farm.drop_part(&format!("late{copies}.stl"), &block(20.0, 15.0, 8.0));
        farm.wait_for_parts(PartState::Waiting, copies - 5);
        farm.pass_secs(3.0);
        assert_eq!(kept(&farm), Some(copies as u32 - 1));
        refused.allow(&farm);
        farm.pass_until("the arrival is in the kept layout", |farm| kept(farm) == Some(copies as u32));
    }
}

#[test]
fn a_configuration_that_the_ledger_cannot_take_in_applies_as_a_whole_later() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.write_profile("going", QUICK);
    farm.reload();
    let before = farm.profiles().clone();
    std::fs::remove_file(farm.root().join("config/profiles/going.toml")).unwrap();
    farm.write_profile("coming", QUICK);
    let refused = RefusedChanges::of(&farm, "INSERT ON build");
    farm.reload();
    farm.pass_secs(20.0);
    assert_eq!(farm.profiles(), &before);
    assert!(!farm.has_alert(AlertKind::ConfigurationWrong), "nothing is wrong with it");
    let told = farm.alert_text(AlertKind::StepFails);
    assert!(told.contains("the new configuration (nothing of it applies before that)"), "{told}");
    refused.allow(&farm);
    farm.pass_until("it is in force", |farm| farm.profiles().contains_key("coming"));
    farm.pass_until("it is not told any more", |farm| !farm.has_alert(AlertKind::StepFails));
    assert!(!farm.profiles().contains_key("going"));
}

#[test]
fn a_hot_folder_is_scanned_again_after_the_ledger_has_refused_what_a_scan_found() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a.stl", &block(10.0, 12.0, 14.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    // A late ticket, a control file, and a ticket without a part, which is refused.
    let found = [
        ("INSERT ON ticket", "a.stl.toml", "copies = 2\n"),
        ("INSERT ON command", "FLUSH", ""),
        ("INSERT ON event WHEN NEW.kind = 'refused'", "nobody.stl.toml", "copies = 2\n"),
    ];
    for (change, file, text) in found {
        let refused = RefusedChanges::of(&farm, change);
        farm.drop_bytes(file, text.as_bytes());
        farm.pass_secs(9.0);
        refused.allow(&farm);
        let another = format!("after-{}.stl", file.to_lowercase().replace('.', "-"));
        farm.drop_part(&another, &block(5.0, 6.0, 7.0));
        farm.pass_until(&format!("{another} is taken after {change}"), |farm| {
            farm.ask(async |ledger| !ledger.parts_named(&another).await.unwrap().is_empty())
        });
        farm.pass_until(&format!("{file} is seen to"), |farm| !farm.folder("inbox").join(file).exists());
    }
    farm.wait_for_queued(1);
    farm.pass_secs(2.0);
    let refusals = farm.ask(async |ledger| count_events(ledger, "refused").await);
    assert_eq!(refusals, 1, "the refusal of the ticket without a part is told once");
    let ticketed = farm.ask(async |ledger| ledger.parts_named("a.stl").await.unwrap()).remove(0);
    assert_eq!(ticketed.wanted_copies(), 2);
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn a_ticket_whose_part_could_not_be_recorded_yet_is_no_ticket_without_a_part() {
    let mut farm = HandDrivenFarm::open(QUICK);
    let refused = RefusedChanges::of(&farm, "INSERT ON part");
    farm.drop_part("bracket.stl", &block(10.0, 12.0, 14.0));
    farm.pass_until("it is claimed", |farm| !farm.folder("inbox").join("bracket.stl").exists());
    farm.drop_bytes("bracket.stl.toml", b"copies = 9\n");
    for _ in 0..24 {
        farm.pass_secs(0.5);
        assert!(!farm.has_alert(AlertKind::Incomplete), "{}", farm.alert_text(AlertKind::Incomplete));
    }
    refused.allow(&farm);
    farm.pass_until("the ticket is applied", |farm| {
        farm.parts(PartState::Waiting).iter().any(|part| part.wanted_copies() == 9)
    });
    assert!(!farm.folder("error").join("bracket.stl.toml").exists());
}

#[test]
fn files_that_took_the_place_of_damaged_ones_are_no_orders_when_their_claims_are_found_again_together() {
    let mut farm = HandDrivenFarm::open(QUICK);
    let parts = [("a_x2.stl", block(20.0, 15.0, 10.0)), ("b_x3.stl", block(30.0, 20.0, 5.0))];
    parts.iter().for_each(|(name, mesh)| farm.drop_part(name, mesh));
    farm.wait_for_parts(PartState::Waiting, 2);
    farm.stop();
    let stored =
        read_files(&farm.root().join("state/store")).into_iter().filter(|(file, _)| file.extension().is_none());
    stored.for_each(|(file, _)| std::fs::remove_file(file).unwrap());
    farm.start();
    farm.pass_until("both files are asked for", |farm| {
        farm.ask(async |ledger| ledger.damaged_parts().await.unwrap()).len() == 2
    });
    // As a crash leaves it before the originals are removed: what was claimed is there, and what became of it is in the ledger.
    let refused = RefusedChanges::of(&farm, "INSERT ON replacement");
    parts.iter().for_each(|(name, mesh)| farm.drop_part(name, mesh));
    farm.pass_secs(5.0);
    let claims = read_files(&farm.folder("inbox").join(".claimed"));
    assert_eq!(claims.len(), 2, "{claims:?}");
    refused.allow(&farm);
    farm.pass_until("both are taken in their place", |farm| !farm.has_alert(AlertKind::FileDamaged));
    farm.pass_secs(2.0);
    farm.stop();
    for (file, bytes) in claims {
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(file, bytes).unwrap();
    }
    farm.start();
    farm.pass_until("the claims are gone", |farm| read_files(&farm.folder("inbox").join(".claimed")).is_empty());
    farm.order_and_wait(CommandKind::Flush, None);
    farm.wait_for_queued(1);
    farm.pass_secs(2.0);
    assert_eq!(printed_copies(&farm), 5, "neither was an order");
    farm.assert_nothing_lost_or_doubled();
}

/// All files in a folder and below it, with their bytes.
fn read_files(folder: &std::path::Path) -> Vec<(std::path::PathBuf, Vec<u8>)> {
    let files = intake::files_below(folder).unwrap_or_default();
    files.into_iter().map(|file| (file.clone(), std::fs::read(file).unwrap())).collect()
}

/// Copies in all files of the queue.
fn printed_copies(farm: &HandDrivenFarm) -> usize {
    farm.queued().iter().map(|file| build_file::read_build(file, &Default::default()).unwrap().len()).sum()
}

async fn count_events(ledger: &Ledger, kind: &str) -> i64 {
    let pool = sqlx::SqlitePool::connect(&format!("sqlite://{}", ledger.file().unwrap().display())).await.unwrap();
    let count = sqlx::query_scalar("SELECT count(*) FROM event WHERE kind = ?").bind(kind).fetch_one(&pool).await;
    pool.close().await;
    count.unwrap()
}

/// Refuses one in `EVERY` changes of a ledger, each until the farm has done nothing else for a tick.
struct RefusedEach {
    pool: sqlx::SqlitePool,
    seen: i64,
    refused: u32,
}

/// Each run refuses one in so many changes. It is no multiple of the changes of a build that is made again: the same one would be refused
/// each time.
const EVERY: i64 = 7;

impl RefusedEach {
    fn of(farm: &HandDrivenFarm, offset: i64) -> Self {
        let pool = farm.ask(async |ledger| {
            let file = ledger.file().unwrap().display().to_string();
            let pool = sqlx::SqlitePool::connect(&format!("sqlite://{file}")).await.unwrap();
            let trigger = format!(
                "CREATE TABLE let_through (upto INTEGER); INSERT INTO let_through VALUES (0); \
                 CREATE TRIGGER refused BEFORE UPDATE ON change_count WHEN NEW.changes % {EVERY} = {offset} \
                 AND NEW.changes > (SELECT upto FROM let_through) BEGIN SELECT RAISE(ABORT, 'refused'); END"
            );
            sqlx::raw_sql(sqlx::AssertSqlSafe(trigger)).execute(&pool).await.unwrap();
            pool
        });
        Self { pool, seen: -1, refused: 0 }
    }

    /// Lets the next change through if none was made since the last tick.
    fn let_pass_if_stuck(&mut self, farm: &HandDrivenFarm, offset: i64) {
        farm.ask(async |_| {
            let changes: i64 =
                sqlx::query_scalar("SELECT changes FROM change_count").fetch_one(&self.pool).await.unwrap();
            if changes == self.seen && (changes + 1) % EVERY == offset {
                let allow = sqlx::query("UPDATE let_through SET upto = ? WHERE upto < ?1").bind(changes + 1);
                self.refused += u32::from(allow.execute(&self.pool).await.unwrap().rows_affected() > 0);
            }
            self.seen = changes;
        });
    }
}

/// A farm that gets parts with tickets, late ones, a revision, refused files and control files, while the ledger refuses one in
/// [`EVERY`] changes.
fn live_with_refusals(offset: i64) -> u32 {
    let mut farm = HandDrivenFarm::open(QUICK);
    let mut refused = RefusedEach::of(&farm, offset);
    let mut until = |farm: &mut HandDrivenFarm, what: &str, holds: &dyn Fn(&HandDrivenFarm) -> bool| {
        farm.pass_until(&format!("{what}, with change {offset} of {EVERY} refused"), |farm| {
            refused.let_pass_if_stuck(farm, offset);
            holds(farm)
        });
    };
    let waiting = |names: &'static [&'static str]| {
        move |farm: &HandDrivenFarm| {
            let parts = farm.parts(PartState::Waiting);
            names.iter().all(|name| parts.iter().any(|part| part.name == *name))
        }
    };
    farm.drop_bytes("b.stl.toml", b"copies = 2\n");
    farm.drop_part("b.stl", &block(12.0, 12.0, 14.0));
    farm.drop_part("a.stl", &block(10.0, 12.0, 14.0));
    farm.drop_part("brandt/hinge.stl", &block(11.0, 12.0, 14.0));
    farm.drop_bytes("broken.stl", b"solid nothing\nendsolid nothing\n");
    until(&mut farm, "the parts wait", &waiting(&["a.stl", "b.stl", "hinge.stl"]));
    until(&mut farm, "what is no part is refused", &|farm| farm.folder("error").join("broken.stl").exists());
    farm.drop_bytes("a.stl.toml", b"copies = 3\n");
    farm.drop_bytes("nobody.stl.toml", b"copies = 3\n");
    farm.drop_part("brandt/hinge.stl", &block(11.0, 12.0, 15.0));
    until(&mut farm, "the late ticket is applied", &|farm| {
        farm.parts(PartState::Waiting).iter().any(|part| part.name == "a.stl" && part.wanted_copies() == 3)
    });
    until(&mut farm, "the revision replaces the first", &|farm| {
        farm.parts(PartState::Refused).iter().any(|part| part.name == "hinge.stl") && waiting(&["hinge.stl"])(farm)
    });
    until(&mut farm, "the tickets are gone", &|farm| {
        !farm.folder("inbox").join("a.stl.toml").exists() && !farm.folder("inbox").join("nobody.stl.toml").exists()
    });
    farm.drop_bytes("FLUSH", b"");
    until(&mut farm, "the first build is queued", &|farm| farm.parts(PartState::Built).len() == 3);
    farm.drop_part("c.stl", &block(13.0, 12.0, 14.0));
    until(&mut farm, "the last part waits", &waiting(&["c.stl"]));
    until(&mut farm, "the file is gone", &|farm| !farm.folder("inbox").join("FLUSH").exists());
    farm.drop_bytes("FLUSH", b"");
    until(&mut farm, "all is built", &|farm| farm.parts(PartState::Built).len() == 4);
    let mut ticks = 12;
    farm.pass_until("it rests", |farm| {
        refused.let_pass_if_stuck(farm, offset);
        ticks -= 1;
        ticks == 0
    });
    assert_eq!((farm.queued().len(), printed_copies(&farm)), (2, 3 + 2 + 1 + 1), "change {offset} of {EVERY} refused");
    assert_eq!(farm.parts(PartState::Refused).len(), 2);
    assert_eq!(
        farm.ask(async |ledger| count_events(ledger, "refused").await),
        2 + 1,
        "they, and the ticket without a part"
    );
    farm.assert_nothing_lost_or_doubled();
    farm.ask(async |_| refused.pool.close().await);
    refused.refused
}

#[test]
fn each_change_that_the_ledger_refuses_once_is_made_later_and_every_part_is_built_once() {
    let refused: u32 = (0..EVERY).map(live_with_refusals).sum();
    assert!(refused >= 40, "{refused} changes were refused");
}
