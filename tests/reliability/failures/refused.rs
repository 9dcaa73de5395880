//! Refused writes: the ledger refuses each change of the reference life-cycle once, by a trigger in its database, as it does on a full
//! disk or while a command of somebody else has its lock too long. What a step had in hand then must not be lost: the daemon goes on,
//! every hot folder is scanned again, and each part is built exactly once.

use std::{
    path::{Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    thread::JoinHandle,
    time::{Duration, Instant},
};

use rand::{SeedableRng, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;
use sqlx::{Connection, SqliteConnection};

use crate::harness::{
    SectionBudget, SectionResult, catch_panic, in_parallel,
    life_cycle::{LifeCycle, ScriptEnd},
    seed,
};

/// Time budget of a short run, seconds.
const SHORT_SECS: f64 = 10.0;
/// One in so many changes is refused; each of them in one life. None is a multiple of the changes of a build that is made again: the same one
/// would be refused each time.
const RATES: [i64; 3] = [5, 7, 11];
/// A change is let through when none was made for so long.
const STUCK: Duration = Duration::from_millis(400);

pub fn run(budget: &SectionBudget) -> SectionResult {
    let (seed, budget) = (seed(), &budget.at_least(SHORT_SECS));
    let mut lives: Vec<(i64, i64)> =
        RATES.into_iter().flat_map(|every| (0..every).map(move |offset| (every, offset))).collect();
    lives.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    let all = lives.len();
    let rows = in_parallel(lives, budget, |(every, offset)| {
        catch_panic(&format!("change {offset} of {every} refused"), || live_with_refusals(every, offset))
    });
    SectionResult {
        note: format!("each change of the ledger refused once; {} of {all} lives; NESTD_SEED={seed}", rows.len()),
        ..SectionResult::sum(&rows)
    }
}

fn live_with_refusals(every: i64, offset: i64) -> SectionResult {
    let mut life = LifeCycle::new();
    life.farm.start();
    life.wait_for_sign_of_life();
    let refused = ChangeRefusals::begin(&life.farm.root().join("state/nestd.db"), every, offset);
    let pid = life.farm.pid();
    let end = life.play(pid, &mut || false);
    let faults = refused.end();
    life.farm.stop();
    match end {
        ScriptEnd::Done => life.check_at_rest(),
        _ => life.broken.push(format!("stands still at {}: {}", life.step_name(), life.farm.log())),
    }
    let broken = life.broken.iter().map(|text| format!("change {offset} of {every} refused: {text}"));
    SectionResult {
        points: 1,
        faults,
        files: life.expectations.dropped.len() as u64,
        builds: life.taken.len() as u64,
        broken: broken.collect(),
        ..SectionResult::default()
    }
}

/// Refuses one in so many changes of a ledger, each until no other was made for a while.
struct ChangeRefusals {
    is_over: Arc<AtomicBool>,
    watch: JoinHandle<u64>,
}

impl ChangeRefusals {
    fn begin(ledger: &Path, every: i64, offset: i64) -> Self {
        let is_over = Arc::new(AtomicBool::new(false));
        let (ledger, over) = (ledger.to_owned(), is_over.clone());
        let watch = std::thread::spawn(move || {
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
            runtime.block_on(refuse_changes(ledger, (every, offset), &over))
        });
        Self { is_over, watch }
    }

    /// Ends it; returns how many changes were refused.
    fn end(self) -> u64 {
        self.is_over.store(true, Ordering::Relaxed);
        self.watch.join().unwrap()
    }
}

async fn refuse_changes(ledger: PathBuf, (every, offset): (i64, i64), is_over: &AtomicBool) -> u64 {
    let mut db = SqliteConnection::connect(&format!("sqlite://{}", ledger.display())).await.unwrap();
    let trigger = format!(
        "CREATE TABLE let_through (upto INTEGER); INSERT INTO let_through VALUES (0); \
         CREATE TRIGGER refused BEFORE UPDATE ON change_count WHEN NEW.changes % {every} = {offset} \
         AND NEW.changes > (SELECT upto FROM let_through) BEGIN SELECT RAISE(ABORT, 'refused by the test'); END"
    );
    sqlx::raw_sql(sqlx::AssertSqlSafe(trigger)).execute(&mut db).await.unwrap();
    let (mut seen, mut since, mut refused) = (0, Instant::now(), 0);
    while !is_over.load(Ordering::Relaxed) {
        let changes: i64 = sqlx::query_scalar("SELECT changes FROM change_count").fetch_one(&mut db).await.unwrap();
        if changes != seen {
            (seen, since) = (changes, Instant::now());
        } else if (changes + 1) % every == offset && since.elapsed() >= STUCK {
            let allow = sqlx::query("UPDATE let_through SET upto = $1 WHERE upto < $1").bind(changes + 1);
            refused += allow.execute(&mut db).await.unwrap().rows_affected();
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    sqlx::raw_sql("DROP TRIGGER refused; DROP TABLE let_through").execute(&mut db).await.unwrap();
    db.close().await.unwrap();
    refused
}
