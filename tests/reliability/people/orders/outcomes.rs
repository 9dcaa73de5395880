//! Outcomes, reprints and repeated builds: commands that change the ledger themselves. What they mean for the copies told
//! bad follows from the build files that the printer took.

use std::{
    collections::{BTreeMap, BTreeSet},
    process::Stdio,
    time::Duration,
};

use ledger::{BuildId, BuildState, PlacementRow};
use rand::{RngExt, seq::IndexedRandom};

use super::{
    OrdersFarm,
    asked::{Asked, CopiesByFile},
};

/// Copies told bad, by build and file.
pub type ToldBad = BTreeMap<(i64, String), u32>;

/// How a command ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum CommandEnd {
    Accepted,
    Refused,
    Killed,
}

/// Which copies a command says to be bad.
#[derive(Debug, Clone)]
enum BadClaim {
    /// These more of a build.
    More(i64, CopiesByFile),
    /// Every copy of a build.
    All(i64),
    /// A correction: these, and of those told bad before at most as many as before.
    Anew(i64, CopiesByFile),
    /// So many of a file, in whatever build.
    OfFile(String, u32),
    /// Every copy of these files.
    OfFiles(Vec<String>),
}

impl OrdersFarm {
    /// Tells the outcome of a build, or corrects it.
    pub fn tell_random_outcome(&mut self) {
        let Some((build, rows)) = self.pick_taken_build() else { return };
        let is_correction = self.rng.random_bool(0.25);
        let keep = self.rng.random_bool(0.25);
        let word = *["complete", "complete", "complete", "failed", "interrupted"].choose(&mut self.rng).unwrap();
        let (mut named, mut bad_words) = (CopiesByFile::new(), String::new());
        let live: Vec<&PlacementRow> = rows.iter().filter(|row| is_correction || !row.is_bad).collect();
        if word != "failed"
            && self.rng.random_bool(0.4)
            && let Some(row) = live.choose(&mut self.rng)
        {
            let most = live.iter().filter(|other| other.part_id == row.part_id).count() as u32;
            let copies = self.rng.random_range(1..=most + u32::from(most > 2));
            bad_words = format!("{}={copies}", row.part_id);
            named.insert(self.hash_of(row.part_id.0), copies);
        }
        let mut words = vec!["outcome".to_owned(), build.to_string(), word.to_owned(), "--anyway".to_owned()];
        if !bad_words.is_empty() {
            words.extend(["--bad".to_owned(), bad_words]);
        }
        words.extend(keep.then(|| "--keep".to_owned()));
        words.extend(is_correction.then(|| "--correct".to_owned()));
        let claim = match (word, is_correction) {
            ("failed", _) => BadClaim::All(build),
            (_, true) => BadClaim::Anew(build, named),
            _ => BadClaim::More(build, named),
        };
        let asked = Asked::Outcome { build, newly_bad: CopiesByFile::new(), returned: CopiesByFile::new() };
        self.run_outcome(words, asked, &claim);
    }

    /// Tells every build complete that has no outcome.
    pub fn tell_rest_complete(&mut self) {
        let untold: Vec<i64> = self.farm.query_ledger(async |ledger| {
            let mut builds = ledger.builds_in_state(BuildState::Published).await.unwrap();
            builds.extend(ledger.builds_in_state(BuildState::Printing).await.unwrap());
            builds.into_iter().map(|build| build.id.0).collect()
        });
        for build in untold.into_iter().filter(|build| self.taken.contains_key(build)).collect::<Vec<_>>() {
            let words = ["outcome", &build.to_string(), "complete"].map(str::to_owned).to_vec();
            let asked = Asked::Outcome { build, newly_bad: CopiesByFile::new(), returned: CopiesByFile::new() };
            self.run_outcome(words, asked, &BadClaim::More(build, CopiesByFile::new()));
        }
    }

    pub fn reprint_at_random(&mut self) {
        let Some((build, rows)) = self.pick_taken_build() else { return };
        let Some(row) = rows.choose(&mut self.rng) else { return };
        let hash = self.hash_of(row.part_id.0);
        let order = self.order_of(row.part_id.0);
        let (word, claim) = match self.rng.random_range(0..6) {
            0 => (format!("b{build}"), BadClaim::All(build)),
            1 if !order.is_empty() => {
                let parts = self.farm.query_ledger(async |ledger| ledger.parts_of_order(&order).await.unwrap());
                let files = parts.into_iter().map(|part| part.file.content_hash).collect();
                (format!("order:{order}"), BadClaim::OfFiles(files))
            }
            _ => {
                let copies = self.rng.random_range(1..3);
                (format!("{}={copies}", row.part_id), BadClaim::OfFile(hash, copies))
            }
        };
        self.run_outcome(vec!["reprint".to_owned(), word, "--anyway".to_owned()], Asked::Other, &claim);
    }

    pub fn requeue_at_random(&mut self) {
        let Some((build, _)) = self.pick_taken_build() else { return };
        self.run_outcome(
            vec!["requeue".to_owned(), build.to_string(), "--anyway".to_owned()],
            Asked::Other,
            &BadClaim::All(build),
        );
    }

    fn pick_taken_build(&mut self) -> Option<(i64, Vec<PlacementRow>)> {
        let builds: Vec<i64> = self.taken.keys().copied().collect();
        let build = *builds.choose(&mut self.rng)?;
        let rows =
            self.farm.query_ledger(async |ledger| ledger.placements_of_build(BuildId(build)).await.unwrap_or_default());
        Some((build, rows))
    }

    /// Runs a command that may be killed on the way, and holds what the ledger then says against what it means.
    fn run_outcome(&mut self, words: Vec<String>, asked: Asked, claim: &BadClaim) {
        self.take_builds();
        let (before, known) = (self.ledger_told_bad(), self.taken.keys().copied().collect());
        let number = self.begin_operation(asked, &words.join(" "));
        let end = self.run_or_kill(number, &words);
        self.take_builds();
        let after = self.ledger_told_bad();
        let is_unchanged = before == after;
        let is_meant = self.is_meant(claim, &known, &before, &after);
        let is_right = match end {
            CommandEnd::Accepted => is_meant,
            CommandEnd::Refused => is_unchanged,
            CommandEnd::Killed => is_unchanged || is_meant,
        };
        if !is_right {
            let changes = differences(&before, &after);
            self.broken
                .push(format!("{} ({number}, {end:?}): told bad became {changes:?}, for {claim:?}", words.join(" ")));
        }
        if let (Asked::Outcome { newly_bad, returned, build }, BadClaim::Anew(_, named)) =
            (&mut self.operations[number], claim)
        {
            // What it names is bad anew; what was bad before and is not any more was printed well after all.
            for (hash, _) in self.taken[&*build].copies.clone() {
                let [was, is] = [&before, &after].map(|told| told.get(&(*build, hash.clone())).copied().unwrap_or(0));
                let named = named.get(&hash).copied().unwrap_or(0);
                newly_bad.insert(hash.clone(), named);
                if !is_unchanged && was + named > is || is_unchanged && was > 0 {
                    returned.insert(hash, (was + named).saturating_sub(is));
                }
            }
        } else if let Asked::Outcome { newly_bad, .. } = &mut self.operations[number] {
            newly_bad.extend(differences(&before, &after).into_iter().map(|((_, hash), more)| (hash, more as u32)));
        }
        self.told_bad = after;
    }

    /// Whether the copies told bad changed as a command means it. `known` are the builds that were taken before: another one may have
    /// been published before the command or after it.
    fn is_meant(&self, claim: &BadClaim, known: &BTreeSet<i64>, before: &ToldBad, after: &ToldBad) -> bool {
        let changes = differences(before, after);
        let of_file = |build: i64, hash: &String| self.taken[&build].copies.get(hash).copied().unwrap_or(0);
        let told = |told: &ToldBad, build: i64, hash: &String| told.get(&(build, hash.clone())).copied().unwrap_or(0);
        let only_in = |build: i64| changes.keys().all(|(other, _)| *other == build);
        match claim {
            BadClaim::More(build, named) => {
                let named: BTreeMap<_, _> = named.iter().map(|(h, n)| ((*build, h.clone()), i64::from(*n))).collect();
                changes == named
            }
            BadClaim::All(build) => {
                let files = &self.taken[build].copies;
                only_in(*build) && files.keys().all(|hash| told(after, *build, hash) == of_file(*build, hash))
            }
            BadClaim::Anew(build, named) => {
                only_in(*build)
                    && self.taken[build].copies.keys().all(|hash| {
                        let named = named.get(hash).copied().unwrap_or(0);
                        let is = told(after, *build, hash);
                        named <= is && is <= told(before, *build, hash) + named
                    })
            }
            BadClaim::OfFile(hash, copies) => {
                changes.keys().all(|(_, other)| other == hash) && changes.values().sum::<i64>() == i64::from(*copies)
            }
            BadClaim::OfFiles(hashes) => {
                let all = self.taken.iter().filter(|(build, _)| known.contains(build));
                let all = all.flat_map(|(build, taken)| taken.copies.iter().map(move |c| (*build, c)));
                changes.keys().all(|(_, hash)| hashes.contains(hash))
                    && all
                        .filter(|(_, (hash, _))| hashes.contains(hash))
                        .all(|(build, (hash, copies))| told(after, build, hash) == *copies)
            }
        }
    }

    /// The copies told bad, as the ledger says it.
    pub fn ledger_told_bad(&self) -> ToldBad {
        let builds: Vec<i64> = self.taken.keys().copied().collect();
        self.farm.query_ledger(async |ledger| {
            let mut told = ToldBad::new();
            for build in builds {
                let hashes: BTreeMap<i64, String> = (ledger.parts_of_build(BuildId(build)).await.unwrap().into_iter())
                    .map(|part| (part.id.0, part.file.content_hash))
                    .collect();
                for row in ledger.placements_of_build(BuildId(build)).await.unwrap().iter().filter(|row| row.is_bad) {
                    *told.entry((build, hashes[&row.part_id.0].clone())).or_default() += 1;
                }
            }
            told
        })
    }

    /// Runs a command; sometimes it is killed, and sometimes the daemon beside it.
    fn run_or_kill(&mut self, number: usize, words: &[String]) -> CommandEnd {
        let mut command = self.command_of(number, words);
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        if !self.is_resting && self.rng.random_bool(0.15) {
            std::thread::sleep(Duration::from_micros(self.rng.random_range(500..25_000)));
            let is_killed = child.try_wait().unwrap().is_none();
            let _ = child.kill();
            let ended = child.wait().unwrap();
            if is_killed && ended.code().is_none() {
                self.kills += 1;
                return CommandEnd::Killed;
            }
            return if ended.success() { CommandEnd::Accepted } else { CommandEnd::Refused };
        }
        if !self.is_resting && self.rng.random_bool(0.1) {
            std::thread::sleep(Duration::from_micros(self.rng.random_range(500..25_000)));
            self.kill_daemon();
            let ended = child.wait().unwrap();
            self.farm.start();
            return if ended.success() { CommandEnd::Accepted } else { CommandEnd::Refused };
        }
        if child.wait().unwrap().success() { CommandEnd::Accepted } else { CommandEnd::Refused }
    }
}

/// What is more or less in the second.
fn differences(before: &ToldBad, after: &ToldBad) -> BTreeMap<(i64, String), i64> {
    let keys = before.keys().chain(after.keys());
    let of = |told: &ToldBad, key: &(i64, String)| i64::from(told.get(key).copied().unwrap_or(0));
    keys.map(|key| (key.clone(), of(after, key) - of(before, key))).filter(|(_, change)| *change != 0).collect()
}
