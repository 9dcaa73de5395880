//! The ledger: a million builds, damage at hundreds of places, and backups while the daemon is killed.

use std::{
    fs,
    path::Path,
    process::{Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use ledger::{Ledger, LedgerError, PartState};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::large_ledger;
use crate::{
    harness::{SectionBudget, SectionResult},
    support::{QUICK, TestFarm, block, cpu_secs, stat_fields},
};

/// Builds in the large ledger of a long run.
const MANY: u64 = 1_000_000;
/// Waiting parts in the large ledger.
const WAITING: u64 = 10_000;
/// Most CPU time of a query, ms; for an optimised build of nestd.
const ANSWER_MS: f64 = 100.0;
/// Time limit of checking the whole ledger, s.
const LOOK_SECS: f64 = 120.0;

pub fn run(budget: &SectionBudget) -> SectionResult {
    let mut row = SectionResult::default();
    measure_large_ledger(budget, &mut row);
    damage_ledgers(budget, &mut row);
    backups_while_killed(budget, &mut row);
    row
}

/// CPU milliseconds of a whole process, the least of several runs, so that other work on the machine has little
/// influence.
fn least_cpu_ms(mut command: impl FnMut() -> Command, times: usize) -> f64 {
    let once = || {
        let mut child = command().stdout(Stdio::null()).spawn().unwrap();
        let pid = child.id() as i32;
        while stat_fields(pid)[0] != "Z" {
            thread::sleep(Duration::from_millis(2));
        }
        let cpu_ms = 1000.0 * cpu_secs(pid);
        assert!(child.wait().unwrap().success());
        cpu_ms
    };
    std::iter::repeat_with(once).take(times).fold(f64::INFINITY, f64::min)
}

fn runtime() -> tokio::runtime::Runtime {
    tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap()
}

/// Measures history, status and the check of all pages of a large ledger.
fn measure_large_ledger(budget: &SectionBudget, row: &mut SectionResult) {
    let mut farm = TestFarm::new(QUICK);
    let builds = budget.pick(20_000, MANY);
    let path = farm.root().join("state/nestd.db");
    farm.start();
    farm.stop();
    runtime().block_on(async {
        large_ledger::fill_published(&path, builds).await;
        large_ledger::fill_waiting(&path, budget.pick(500, WAITING)).await;
    });
    fs::remove_file(farm.root().join("state/nestd.db.b3")).unwrap();
    let history = least_cpu_ms(|| farm.command(&["history", "--since", "30d"]), budget.pick(7, 40));
    let status = least_cpu_ms(|| farm.command(&["status"]), budget.pick(7, 40));
    let began = Instant::now();
    let whole = runtime().block_on(async { Ledger::open_existing(&path).await.unwrap().check_integrity().await });
    let look = began.elapsed().as_secs_f64();
    row.points += 3;
    row.note += &format!(
        "{builds} builds: history --since 30d {history:.0} CPU ms, status with {} waiting {status:.0} CPU ms, every page checked in {look:.1} s. ",
        budget.pick(500, WAITING)
    );
    let limit = if cfg!(debug_assertions) { 10.0 * ANSWER_MS } else { ANSWER_MS };
    if history > limit || status > limit || look > LOOK_SECS {
        row.broken.push(format!(
            "a large ledger is slow: history {history:.0} CPU ms, status {status:.0} CPU ms, look {look:.0} s"
        ));
    }
    row.broken.extend(whole.err().map(|error| error.to_string()));
}

/// The result of opening a damaged ledger.
enum LedgerReply {
    Refused,
    /// It was opened, and every query returns the same as before.
    Same,
    /// It was opened, and a query returns something else.
    Other,
}

/// Damages ledgers: bytes flipped, cut or overwritten, a log cut or deleted. Each damage is refused, or changes no
/// result.
fn damage_ledgers(budget: &SectionBudget, row: &mut SectionResult) {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let (sealed, unsealed) = ledgers();
    let (mut refused, mut harmless, mut unseen) = (0, 0, 0);
    let end = Instant::now() + Duration::from_secs_f64(budget.secs * budget.pick(0.2, 0.3));
    let mut tried = 0;
    while Instant::now() < end && tried < 20_000 {
        let is_sealed = tried % 2 == 0;
        let from = if is_sealed { &sealed } else { &unsealed };
        let what = damage_randomly(from.path(), &mut rng);
        match open_again(from.path()) {
            LedgerReply::Refused => refused += 1,
            LedgerReply::Same if is_sealed => row.broken.push(format!("a sealed ledger was opened after this: {what}")),
            LedgerReply::Same => harmless += 1,
            LedgerReply::Other if is_sealed => row.broken.push(format!("a sealed ledger was used after this: {what}")),
            LedgerReply::Other => unseen += 1,
        }
        from.restore_files();
        tried += 1;
    }
    row.points += tried;
    row.faults += tried;
    row.note += &format!(
        "{tried} damages: {refused} refused, {harmless} without effect, {unseen} in texts or numbers of a ledger without a seal, \
         where SQLite keeps no checksums. "
    );
}

/// The files of a ledger, to be damaged and restored.
struct DamagedLedger {
    folder: tempfile::TempDir,
    files: Vec<(String, Vec<u8>)>,
    answer: String,
}

impl DamagedLedger {
    fn path(&self) -> &Path {
        self.folder.path()
    }

    fn restore_files(&self) {
        for entry in fs::read_dir(self.path()).unwrap().map(Result::unwrap) {
            // A connection that has just been closed removes SQLite's own files itself.
            match fs::remove_file(entry.path()) {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => panic!("{error}"),
                _ => {}
            }
        }
        for (name, bytes) in &self.files {
            fs::write(self.path().join(name), bytes).unwrap();
        }
    }
}

/// A ledger as an orderly stop leaves it, and one as a kill leaves it.
fn ledgers() -> (DamagedLedger, DamagedLedger) {
    let mut farm = TestFarm::running(QUICK);
    for n in 0..6 {
        farm.drop_part(&format!("part{n}_x2.stl"), &block(12.0, 12.0, 10.0 + f64::from(n)));
    }
    farm.wait_for_parts(PartState::Waiting, 6);
    farm.flush();
    farm.wait_for_parts(PartState::Built, 6);
    farm.stop();
    let sealed = keep(&farm.root().join("state"));
    farm.start();
    farm.drop_part("late.stl", &block(9.0, 9.0, 9.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.kill();
    (sealed, keep(&farm.root().join("state")))
}

fn keep(state: &Path) -> DamagedLedger {
    let folder = tempfile::tempdir().unwrap();
    let mut files = Vec::new();
    for entry in fs::read_dir(state).unwrap().map(Result::unwrap) {
        let name = entry.file_name().into_string().unwrap();
        if name.starts_with("nestd.db") {
            files.push((name, fs::read(entry.path()).unwrap()));
        }
    }
    let mut spoilt = DamagedLedger { folder, files, answer: String::new() };
    spoilt.restore_files();
    spoilt.answer = runtime().block_on(answers(spoilt.path())).unwrap();
    spoilt.files.push(("answer".to_owned(), spoilt.answer.clone().into_bytes()));
    spoilt.restore_files();
    spoilt
}

/// Damages the ledger in a random way; returns a description.
fn damage_randomly(folder: &Path, rng: &mut ChaCha8Rng) -> String {
    let (db, log) = (folder.join("nestd.db"), folder.join("nestd.db-wal"));
    let has_log = fs::metadata(&log).is_ok_and(|meta| meta.len() > 0);
    let file = if has_log && rng.random_bool(0.4) { &log } else { &db };
    let mut bytes = fs::read(file).unwrap();
    let at = rng.random_range(0..bytes.len());
    let what = match rng.random_range(0..10) {
        0 => {
            bytes.truncate(at);
            format!("cut to {at} bytes")
        }
        1 => {
            let end = bytes.len().min(100);
            bytes[..end].fill(0);
            "its header overwritten".to_owned()
        }
        2 if has_log => {
            fs::remove_file(&log).unwrap();
            return "its log deleted".to_owned();
        }
        3 => {
            let end = bytes.len().min(at + 4096);
            bytes[at..end].fill(rng.random());
            format!("a page overwritten at {at}")
        }
        _ => {
            bytes[at] ^= 1 << rng.random_range(0..8);
            format!("a bit flipped at {at}")
        }
    };
    fs::write(file, bytes).unwrap();
    format!("{}: {what}", file.file_name().unwrap().to_string_lossy())
}

fn open_again(folder: &Path) -> LedgerReply {
    let before = fs::read_to_string(folder.join("answer")).unwrap();
    match runtime().block_on(answers(folder)) {
        Err(error) => {
            let clear = error.is_damage() && error.to_string().contains("nestd restore");
            // A damaged table of migrations gives another error, but the ledger is not used.
            let otherwise =
                matches!(error, LedgerError::Migrate { .. } | LedgerError::Sql(_) | LedgerError::NewerSchema { .. });
            if clear || otherwise { LedgerReply::Refused } else { panic!("{error}") }
        }
        Ok(now) if now == before => LedgerReply::Same,
        Ok(_) => LedgerReply::Other,
    }
}

/// The results of all queries of a ledger, opened as the daemon opens it.
async fn answers(folder: &Path) -> Result<String, LedgerError> {
    let ledger = Ledger::open_checked(&folder.join("nestd.db")).await?;
    let mut text = format!("{:?}", ledger.read_history(&Default::default()).await?);
    for state in PartState::ALL {
        for part in ledger.parts_in_state(state).await? {
            text += &format!("{part:?} {:?}", ledger.placements_of_part(part.id).await?);
        }
    }
    text += &format!("{:?}", ledger.find_inconsistencies().await?);
    ledger.close().await;
    Ok(text)
}

/// Backups beside a daemon that is killed again and again: each backup is complete, or does not exist.
fn backups_while_killed(budget: &SectionBudget, row: &mut SectionResult) {
    let mut farm = TestFarm::new(&format!("{}[trigger]\ncopies = 3\n", QUICK.replace("_secs = 0.5", "_secs = 0.1")));
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    let (mut whole, mut round) = (0_u32, 0_u32);
    while budget.left_secs() > 0.5 && round < 5_000 {
        farm.start();
        farm.drop_part(&format!("p{round}.stl"), &block(10.0, 10.0, 10.0 + f64::from(round % 50) / 10.0));
        let file = farm.root().join(format!("backup-{round}"));
        let mut backup = farm.command(&["backup", file.to_str().unwrap()]).spawn().unwrap();
        thread::sleep(Duration::from_millis(rng.random_range(5..400)));
        if rng.random_bool(0.3) {
            backup.kill().unwrap();
        }
        farm.kill();
        backup.wait().unwrap();
        row.faults += 1;
        if file.exists() {
            match runtime().block_on(ledger::prove_backup(&file)) {
                Ok(()) => whole += 1,
                Err(error) => row.broken.push(format!("a backup that is there is not whole: {error}")),
            }
        }
        for entry in fs::read_dir(farm.root()).unwrap().map(Result::unwrap) {
            if entry.file_name().to_string_lossy().starts_with("backup-") {
                fs::remove_file(entry.path()).unwrap();
            }
        }
        round += 1;
    }
    row.points += u64::from(round);
    row.files += u64::from(round);
    row.note += &format!("{round} kills beside a backup: {whole} backups were there, all whole.");
}
