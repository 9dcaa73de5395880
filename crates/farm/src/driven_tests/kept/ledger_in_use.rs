//! What others do to a ledger while a farm uses it: they put a backup back inside its file, or hold its lock.

use ledger::{CommandKind, CommandState, Ledger, LedgerError, NewCommand, PartState, ServiceState};
use sqlx::Connection;

use crate::{
    AlertKind,
    driven_tests::{HandDrivenFarm, MACHINE, QUICK, block},
    records::lost_ledger::ledger_alert,
    run::open::is_transient,
};

/// Writes the rows of a backup over those of the ledger in one change, as SQLite's restore writes its pages: the file stays the same.
fn overwrite(farm: &HandDrivenFarm, backup: &std::path::Path) {
    farm.ask(async |ledger| {
        let pool = sqlx::SqlitePool::connect(&format!("sqlite://{}", ledger.file().unwrap().display())).await.unwrap();
        let mut db = pool.acquire().await.unwrap();
        let attach = format!("PRAGMA foreign_keys = OFF; ATTACH '{}' AS backup", backup.display());
        sqlx::raw_sql(sqlx::AssertSqlSafe(attach)).execute(&mut *db).await.unwrap();
        let tables: Vec<String> = sqlx::query_scalar("SELECT name FROM backup.sqlite_schema WHERE type = 'table'")
            .fetch_all(&mut *db)
            .await
            .unwrap();
        let mut text = "BEGIN IMMEDIATE;".to_owned();
        for table in tables {
            text += &format!("DELETE FROM main.{table}; INSERT INTO main.{table} SELECT * FROM backup.{table};");
        }
        sqlx::raw_sql(sqlx::AssertSqlSafe(text + "COMMIT")).execute(&mut *db).await.unwrap();
        db.close().await.unwrap();
        pool.close().await;
    });
}

#[test]
fn a_ledger_that_is_overwritten_inside_its_file_is_used_no_more() {
    let mut farm = HandDrivenFarm::open(&format!("{QUICK}[trigger]\ncopies = 1\n"));
    farm.order_and_wait(CommandKind::Pause, None);
    farm.drop_part("a.stl", &block(10.0, 12.0, 14.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    let backup = farm.write_backup("backup");
    // What another process changes is no loss.
    let other = farm.ask(async |ledger| Ledger::open_existing(ledger.file().unwrap()).await.unwrap());
    let resume = NewCommand {
        kind: CommandKind::Resume,
        machine: MACHINE.to_owned(),
        part: None,
        argument: Default::default(),
        asked_by: "a@test".to_owned(),
    };
    let id = farm.ask(async |_| other.submit_command(&resume).await.unwrap());
    farm.pass_until("the command of another process is carried out", |farm| {
        farm.ask(async |ledger| ledger.find_command(id).await.unwrap().unwrap().state) == CommandState::Done
    });
    let printed = farm.wait_for_queued(1).remove(0);
    std::fs::remove_file(printed).unwrap();
    farm.pass_secs(2.0);
    assert!(!farm.has_alert(AlertKind::LedgerReplaced));
    overwrite(&farm, &backup);
    // Before the farm looks at it, also a process that begins now does not change it.
    let late = farm.ask(async |ledger| {
        let late = Ledger::open_existing(ledger.file().unwrap()).await.unwrap();
        late.submit_command(&resume).await.unwrap_err()
    });
    farm.pass_secs(20.0);
    assert!(farm.has_alert(AlertKind::LedgerReplaced));
    assert!(farm.queued().is_empty(), "what the printer has is printed once more");
    let refused = farm.ask(async |_| other.submit_command(&resume).await.unwrap_err());
    let opened = farm.ask(async |ledger| Ledger::open_existing(ledger.file().unwrap()).await.unwrap_err());
    for refused in [late, refused, opened] {
        assert!(matches!(refused, LedgerError::Overwritten { .. }), "{refused}");
        assert!(refused.to_string().contains("`nestd restore FILE`"), "{refused}");
    }
    let reason = farm.halt_reason();
    assert!(reason.contains("put back to an earlier time") && reason.contains("`nestd restore FILE`"), "{reason}");
    farm.stop();
    for _ in 0..2 {
        let failure = farm.start_failure();
        let (kind, detail) = ledger_alert(&failure).unwrap();
        assert_eq!(kind, AlertKind::LedgerReplaced, "{failure:#}");
        assert!(reason.contains(&detail), "{detail}");
    }
    farm.restore(&backup);
    farm.start();
    farm.pass_secs(20.0);
    assert_eq!(
        (farm.parts(PartState::Built).len(), farm.queued().len()),
        (1, 0),
        "the folders tell that it was printed"
    );
}

/// The write lock of a ledger, held.
struct HeldLedger {
    runtime: tokio::runtime::Runtime,
    db: sqlx::SqliteConnection,
}

impl HeldLedger {
    fn of(farm: &HandDrivenFarm) -> Self {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        let address = format!("sqlite://{}", farm.root().join("state/nestd.db").display());
        let db = runtime.block_on(async {
            let mut db = sqlx::SqliteConnection::connect(&address).await.unwrap();
            sqlx::raw_sql("BEGIN IMMEDIATE").execute(&mut db).await.unwrap();
            db
        });
        Self { runtime, db }
    }

    fn let_go(mut self) {
        self.runtime.block_on(async {
            sqlx::raw_sql("ROLLBACK").execute(&mut self.db).await.unwrap();
            self.db.close().await.unwrap();
        });
    }
}

#[test]
fn a_search_that_ended_while_the_ledger_was_held_is_made_again_soon_after() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a.stl", &block(10.0, 12.0, 14.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.begin_search();
    let held = HeldLedger::of(&farm);
    farm.await_jobs();
    farm.pass_secs(2.0);
    assert!(farm.has_alert(AlertKind::LedgerLocked));
    held.let_go();
    let free_at = farm.date();
    farm.pass_until("it stands in the open build", |farm| farm.open_copies().len() == 1);
    assert!(farm.date().duration_since(free_at).as_secs() < 8, "{}", farm.date().duration_since(free_at));
    farm.order(CommandKind::Flush, None);
    farm.wait_for_queued(1);
    farm.pass_secs(1.0);
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn a_stop_does_not_wait_for_a_process_that_holds_the_ledger_and_loses_nothing() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a.stl", &block(10.0, 12.0, 14.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    let held = HeldLedger::of(&farm);
    let began = std::time::Instant::now();
    farm.stop();
    assert!(began.elapsed().as_secs() < 8, "{:?}", began.elapsed());
    held.let_go();
    farm.start();
    farm.order(CommandKind::Flush, None);
    farm.wait_for_queued(1);
    farm.pass_secs(1.0);
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn a_stop_ends_within_ten_seconds_also_when_neither_a_folder_nor_the_ledger_answers() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a.stl", &block(10.0, 12.0, 14.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    let (held, release) = (HeldLedger::of(&farm), farm.begin_stuck_job());
    let began = std::time::Instant::now();
    farm.stop();
    assert!(began.elapsed().as_secs_f64() < 10.0, "{:?}", began.elapsed());
    drop(release);
    held.let_go();
    farm.start();
    farm.order(CommandKind::Flush, None);
    farm.wait_for_queued(1);
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn a_process_that_holds_the_ledger_is_named_and_the_farm_goes_on_when_it_lets_go() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a.stl", &block(10.0, 12.0, 14.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    let held = HeldLedger::of(&farm);
    farm.drop_part("b.stl", &block(11.0, 12.0, 14.0));
    let began = std::time::Instant::now();
    farm.pass_until("the lock is reported", |farm| farm.has_alert(AlertKind::LedgerLocked));
    assert!(began.elapsed().as_secs() < 25, "only one change waits for the lock: {:?}", began.elapsed());
    let holder = format!("process {}", std::process::id());
    let text = farm.alert_text(AlertKind::LedgerLocked);
    assert!(text.contains(&holder), "{text}");
    let refused = farm.ask(async |ledger| {
        assert!(matches!(ledger.service_state(), ServiceState::Locked { .. }));
        ledger.pause_machine(MACHINE, "ann", ledger::PauseCause::Person).await.unwrap_err().to_string()
    });
    assert!(refused.contains(&holder) && !refused.contains("locked"), "{refused}");
    held.let_go();
    farm.wait_for_parts(PartState::Waiting, 2);
    assert!(!farm.has_alert(AlertKind::LedgerLocked));
    farm.order(CommandKind::Flush, None);
    farm.wait_for_queued(1);
    farm.pass_secs(1.0);
    farm.assert_nothing_lost_or_doubled();
}

#[test]
fn a_start_waits_for_a_process_that_holds_the_ledger_and_names_it() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a.stl", &block(10.0, 12.0, 14.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.stop();
    let held = HeldLedger::of(&farm);
    let failure = farm.start_failure();
    assert!(is_transient(&failure), "it does not end, and is not started again and again: {failure:#}");
    let (kind, detail) = ledger_alert(&failure).unwrap();
    assert_eq!(kind, AlertKind::LedgerLocked, "{failure:#}");
    assert!(detail.contains(&format!("process {}", std::process::id())), "{detail}");
    held.let_go();
    farm.start();
    farm.order(CommandKind::Flush, None);
    farm.wait_for_queued(1);
    farm.pass_secs(1.0);
    farm.assert_nothing_lost_or_doubled();
}
