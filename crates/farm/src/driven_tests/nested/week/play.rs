//! Plays a plan: drops what is asked, says what is said late, prints, tells outcomes, and counts what was delivered.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::PathBuf,
    rc::Rc,
    time::{Duration, Instant},
};

use ledger::{
    CommandArgument, CommandId, CommandKind, CommandState, NewCommand, OrderState, PartEdit, PartId, PartState,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{
    plan::{LateWord, PartContent, PlannedWord, WeekPlan, WeekSize},
    printers::{PrintedBuild, PrintedCopy, WeekPrinter},
    table::WeekReport,
};
use crate::{
    FarmReading, MachineWord,
    driven_tests::hand_driven_farm::{HandDrivenFarm, MACHINE, farm_files::drop_file},
};

/// The daemon is started anew so often.
const RESTART_EVERY: Duration = Duration::from_secs(24 * 3600);
/// Time between two looks after all was delivered.
const LAST_STEP: Duration = Duration::from_secs(3600);
/// All must be delivered after this time.
const OVER_AFTER: Duration = Duration::from_secs(28 * 24 * 3600);

/// A line as its customer knows it: the order and the BLAKE3 of the file that is wanted.
type WantedLine = (String, String);

/// Something that was said late, until it is known whether it counts.
enum SaidWord {
    /// A command, and what its success means: this number of copies is wanted.
    Command { command: CommandId, line: WantedLine, copies: u32 },
    /// A ticket: its place in the hot folder, and its place in the error folder if it is refused.
    Ticket { file: PathBuf, reason: PathBuf, line: WantedLine, copies: u32 },
    /// A revision of a part.
    Revision { file: PathBuf, old: (PartId, WantedLine), new: Rc<PartContent> },
}

/// A week that is being played.
struct WeekPlay<'a> {
    size: &'a WeekSize,
    plan: WeekPlan,
    farm: HandDrivenFarm,
    printers: Vec<WeekPrinter>,
    rng: ChaCha8Rng,
    /// Time since the start, and the date then.
    now: Duration,
    started_at: jiff::Timestamp,
    wanted: BTreeMap<WantedLine, u32>,
    /// Good copies.
    delivered: BTreeMap<WantedLine, u32>,
    good: BTreeSet<PrintedCopy>,
    said: Vec<SaidWord>,
    done_after: BTreeMap<String, Duration>,
    volumes_mm3: BTreeMap<String, f64>,
    report: WeekReport,
}

/// Plays a week until everything is delivered, and asserts that each order got exactly what was asked.
pub fn play_week(size: &WeekSize) -> WeekReport {
    let (began, cpu_before) = (Instant::now(), process_cpu_secs());
    let mut play = WeekPlay::begin(size);
    let (mut orders, mut words) = (0, 0);
    let mut restart_at = RESTART_EVERY;
    while orders < play.plan.orders.len() || words < play.plan.words.len() || !play.is_delivered() {
        assert!(play.now < OVER_AFTER, "seed {}: not delivered: {:#?}", size.seed, play.differences());
        orders += play.drop_orders(orders);
        words += play.say_words(words);
        play.pass(size.step);
        if play.now >= restart_at {
            restart_at += RESTART_EVERY;
            play.farm.stop();
            play.farm.start();
        }
    }
    // What would be printed once too often appears now.
    for _ in 0..24 {
        play.pass(LAST_STEP);
    }
    play.assert_as_asked();
    let mut report = play.report;
    report.wall_secs = began.elapsed().as_secs_f64();
    report.cpu_secs = process_cpu_secs() - cpu_before;
    report
}

impl<'a> WeekPlay<'a> {
    fn begin(size: &'a WeekSize) -> Self {
        let mut farm = HandDrivenFarm::closed("");
        fs::remove_file(farm.root().join(format!("config/profiles/{MACHINE}.toml"))).unwrap();
        for (name, profile) in &size.machines {
            farm.write_profile(name, profile);
        }
        farm.start();
        let plan = WeekPlan::draw(size);
        let profiles = farm.profiles();
        let printers = (0..).zip(&size.machines).map(|(machine, (name, _))| {
            let space = &profiles[*name].space;
            WeekPrinter::new(machine, name, space.volume_mm, space.print_hours_per_mm)
        });
        let printers = printers.collect();
        let lines = plan.line_count();
        let report = WeekReport::new(size.seed, plan.orders.len(), lines, plan.words.len(), &size.machines);
        Self {
            rng: ChaCha8Rng::seed_from_u64(size.seed.wrapping_add(1)),
            started_at: farm.date(),
            size,
            plan,
            farm,
            printers,
            now: Duration::ZERO,
            wanted: BTreeMap::new(),
            delivered: BTreeMap::new(),
            good: BTreeSet::new(),
            said: Vec::new(),
            done_after: BTreeMap::new(),
            volumes_mm3: BTreeMap::new(),
            report,
        }
    }

    /// Lets time pass; then printers work, and what was said is looked at.
    fn pass(&mut self, time: Duration) {
        self.farm.jump(time);
        self.now = Duration::try_from(self.farm.date().duration_since(self.started_at)).unwrap();
        self.assert_none_is_said_to_be_free_that_prints();
        let done: Vec<PrintedBuild> =
            self.printers.iter_mut().filter_map(|printer| printer.work(&self.farm, self.now)).collect();
        done.into_iter().for_each(|build| self.tell_outcome(build));
        let said = std::mem::take(&mut self.said);
        for word in said {
            if let Some(open) = self.settle_word(word) {
                self.said.push(open);
            }
        }
        self.note_done_orders();
    }

    /// Whatever a face prints of a machine, it is not that it is free while its printer prints.
    fn assert_none_is_said_to_be_free_that_prints(&self) {
        let (profiles, now) = (self.farm.profiles(), self.farm.date());
        let facts =
            self.farm.ask(async |ledger| FarmReading::read(ledger, profiles.values(), now).await.unwrap().facts());
        for printer in self.printers.iter().filter(|printer| printer.is_printing(self.now)) {
            let fact = facts.iter().find(|fact| fact.machine == printer.name).unwrap();
            let text = self.farm.status_text_of(&fact.machine);
            let is_free =
                fact.state == MachineWord::Free || fact.doing.contains("free now") || text.contains("free now");
            assert!(!is_free, "seed {}, after {:?}: {fact:#?}\n{text}", self.size.seed, self.now);
        }
    }

    /// Drops the orders that are to come by now. Returns their number.
    fn drop_orders(&mut self, from: usize) -> usize {
        let due = self.plan.orders[from..].iter().take_while(|order| order.dropped_after <= self.now).count();
        for order in &self.plan.orders[from..from + due] {
            let folder = self.farm.folder_of("inbox", self.size.machines[order.machine].0).join(&order.name);
            let date = self.started_at + order.due_after;
            let mut list = "file;copies;due\n".to_owned();
            for line in &order.lines {
                if order.has_list {
                    list += &format!("{};{};{date:.0}\n", line.file, line.copies);
                } else {
                    let ticket = format!("copies = {}\ndue = \"{date:.0}\"\n", line.copies);
                    drop_file(self.farm.root(), &folder.join(format!("{}.toml", line.file)), ticket.as_bytes());
                }
                drop_file(self.farm.root(), &folder.join(&line.file), &line.content.bytes);
                self.wanted.insert((order.name.clone(), line.content.hash.clone()), line.copies);
                self.volumes_mm3.insert(line.content.hash.clone(), line.content.volume_mm3);
            }
            if order.has_list {
                drop_file(self.farm.root(), &folder.join("order.csv"), list.as_bytes());
            }
        }
        if due > 0 {
            self.farm.pass_secs(15.0);
        }
        due
    }

    /// Says what is to be said by now. Returns the number of words.
    fn say_words(&mut self, from: usize) -> usize {
        let due: Vec<PlannedWord> =
            self.plan.words[from..].iter().take_while(|word| word.said_after <= self.now).cloned().collect();
        for word in &due {
            self.say_word(word);
        }
        due.len()
    }

    fn say_word(&mut self, planned: &PlannedWord) {
        let order = &self.plan.orders[planned.order];
        let line = &order.lines[planned.line];
        let key = (order.name.clone(), line.content.hash.clone());
        let on = self.size.machines[order.machine].0;
        let (inbox, error) = (self.farm.folder_of("inbox", on), self.farm.folder_of("error", on));
        let file = inbox.join(&order.name).join(&line.file);
        let parts = self.farm.ask(async |ledger| ledger.parts_of_order(&order.name).await.unwrap());
        let part = parts.iter().find(|part| part.name == line.file).map(|part| part.id);
        let part = part.unwrap_or_else(|| panic!("{} of {} was not taken", line.file, order.name));
        let copies = self.wanted[&key];
        let command = |kind, argument, on: &str| {
            let (on, asked_by) = (on.to_owned(), "ann@farm".to_owned());
            self.farm.submit_command(&NewCommand { kind, machine: on, part: Some(part), argument, asked_by })
        };
        let said = match &planned.word {
            LateWord::Ticket { copies, has_priority } => {
                let priority = if *has_priority { "priority = 80\n" } else { "" };
                let ticket = inbox.join(&order.name).join(format!("{}.toml", line.file));
                drop_file(self.farm.root(), &ticket, format!("copies = {copies}\n{priority}").as_bytes());
                let reason = error.join(&order.name).join(format!("{}.toml.reason.txt", line.file));
                SaidWord::Ticket { file: ticket, reason, line: key, copies: *copies }
            }
            LateWord::Edit { copies } => {
                let edit = Some(PartEdit { copies: Some(*copies), ..PartEdit::default() });
                let command = command(
                    CommandKind::Edit,
                    CommandArgument { edit, copies: None, ..CommandArgument::default() },
                    "",
                );
                SaidWord::Command { command, line: key, copies: *copies }
            }
            LateWord::Cancel => {
                let argument = CommandArgument { edit: None, copies: Some(1), ..CommandArgument::default() };
                SaidWord::Command { command: command(CommandKind::Cancel, argument, ""), line: key, copies: copies - 1 }
            }
            LateWord::Move { machine } => {
                let to = self.size.machines[*machine].0;
                let command = command(CommandKind::Move, CommandArgument::default(), to);
                SaidWord::Command { command, line: key, copies }
            }
            LateWord::Revision(new) => {
                drop_file(self.farm.root(), &file, &new.bytes);
                self.volumes_mm3.insert(new.hash.clone(), new.volume_mm3);
                SaidWord::Revision { file, old: (part, key), new: new.clone() }
            }
        };
        self.said.push(said);
    }

    /// Whether a word counts, as far as that is known: `None` = it is known, and taken in.
    fn settle_word(&mut self, word: SaidWord) -> Option<SaidWord> {
        match word {
            SaidWord::Command { command, line, copies } => {
                let row = self.farm.ask(async |ledger| ledger.find_command(command).await.unwrap().unwrap());
                match row.state {
                    CommandState::Asked => return Some(SaidWord::Command { command, line, copies }),
                    CommandState::Done => drop(self.wanted.insert(line, copies)),
                    CommandState::Refused => self.report.late_words_refused += 1,
                }
            }
            SaidWord::Ticket { file, reason, line, copies } => {
                if file.exists() {
                    return Some(SaidWord::Ticket { file, reason, line, copies });
                }
                match reason.exists() {
                    true => self.report.late_words_refused += 1,
                    false => drop(self.wanted.insert(line, copies)),
                }
            }
            SaidWord::Revision { file, old, new } => {
                let rows = self.farm.ask(async |ledger| ledger.parts_of_order(&old.1.0).await.unwrap());
                let taken = rows.iter().find(|row| row.file.content_hash == new.hash);
                if taken.is_none_or(|row| row.state == PartState::Claimed) {
                    return Some(SaidWord::Revision { file, old, new });
                }
                let is_replaced = rows.iter().any(|row| row.id == old.0 && row.owed.replaced_by.is_some());
                let copies = if is_replaced { self.wanted.remove(&old.1).unwrap() } else { 1 };
                self.wanted.insert((old.1.0, new.hash.clone()), copies);
            }
        }
        None
    }

    /// Somebody tells what became of a print.
    fn tell_outcome(&mut self, build: PrintedBuild) {
        for (hash, volume_mm3) in &build.volumes_mm3 {
            let difference = (volume_mm3 / self.volumes_mm3[hash] - 1.0).abs();
            assert!(difference < 1e-3, "build {} holds another solid under the hash {hash}", build.build);
        }
        if self.rng.random_bool(self.size.failed_builds) {
            self.report.add_failed(&build);
            return build.tell_failed(&self.farm);
        }
        let mut bad: BTreeMap<i64, u32> = BTreeMap::new();
        for &(part, _) in build.copies.keys() {
            if self.rng.random_bool(self.size.bad_copies) {
                *bad.entry(part).or_default() += 1;
            }
        }
        build.tell_complete(&self.farm, &bad);
        self.report.add_complete(&build, bad.values().sum());
        // Of each part, the last copies are the bad ones.
        let mut left = bad;
        for (&copy, line) in build.copies.iter().rev() {
            match left.get_mut(&copy.0) {
                Some(bad) if *bad > 0 => *bad -= 1,
                _ => {
                    assert!(self.good.insert(copy), "copy {copy:?} was printed well twice");
                    *self.delivered.entry(line.clone()).or_default() += 1;
                }
            }
        }
    }

    /// Lines of which not exactly what is wanted was delivered: wanted and delivered copies.
    fn differences(&self) -> BTreeMap<&WantedLine, (u32, u32)> {
        let lines: BTreeSet<&WantedLine> = self.wanted.keys().chain(self.delivered.keys()).collect();
        let count = |of: &BTreeMap<WantedLine, u32>, line| of.get(line).copied().unwrap_or_default();
        let counts = lines.into_iter().map(|line| (line, (count(&self.wanted, line), count(&self.delivered, line))));
        counts.filter(|(_, (wanted, delivered))| wanted != delivered).collect()
    }

    fn is_delivered(&self) -> bool {
        self.said.is_empty() && self.differences().is_empty()
    }

    fn note_done_orders(&mut self) {
        let open: BTreeSet<String> = self.differences().keys().map(|line| line.0.clone()).collect();
        for order in &self.plan.orders {
            if order.dropped_after < self.now && !open.contains(&order.name) {
                self.done_after.entry(order.name.clone()).or_insert(self.now);
            } else {
                // Somebody asked for more.
                self.done_after.remove(&order.name);
            }
        }
    }

    fn assert_as_asked(&mut self) {
        let seed = self.size.seed;
        assert!(self.differences().is_empty(), "seed {seed}: wanted and delivered: {:#?}", self.differences());
        for state in [PartState::Claimed, PartState::Waiting, PartState::Batched] {
            assert!(self.farm.parts(state).is_empty(), "parts are {state} after all was delivered");
        }
        self.farm.assert_ledger_agrees_with_folders();
        for order in &self.plan.orders {
            let row = self.farm.ask(async |ledger| ledger.find_order(&order.name).await.unwrap().unwrap());
            let lines = || self.farm.ask(async |ledger| ledger.order_lines(&order.name).await.unwrap());
            assert_eq!(row.state, OrderState::Complete, "{} got all that was asked: {:#?}", order.name, lines());
            self.report.orders_complete += 1;
            self.report.dates_kept += u32::from(self.done_after[&order.name] <= order.due_after);
        }
        self.report.copies_delivered = self.delivered.values().sum();
        self.report.days = self.done_after.values().max().unwrap().as_secs_f64() / 86_400.0;
    }
}

/// Processor time of this process, seconds.
fn process_cpu_secs() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 / 1e9
}
