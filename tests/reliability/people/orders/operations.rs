//! Random operations of people: drops, late tickets, revisions, changes, control files, an archive that somebody empties.

use std::{
    collections::BTreeSet,
    fs,
    process::{Command, Stdio},
};

use ledger::{PartRow, PartState};
use rand::{RngExt, seq::IndexedRandom};

use super::{
    OTHER, OrdersFarm,
    asked::{Asked, DroppedLine, worker},
};
use crate::support::{MACHINE, block, farm_files::drop_file, stl};

/// Commands that run at the same time, at most.
const COMMANDS_AT_ONCE: usize = 6;
/// On one farm of so many, people empty the archive: the originals that they removed are asked for.
const EMPTIES_ARCHIVE: u64 = 4;

impl OrdersFarm {
    pub fn run_random_operation(&mut self) {
        match self.rng.random_range(0..40) {
            0..=6 => self.drop_single_part(),
            7..=9 => self.drop_order(),
            10..=11 => self.drop_revision(),
            12..=13 => self.drop_late_ticket(),
            14..=17 => self.edit_copies(),
            18..=20 => self.edit_terms(),
            21..=23 => self.cancel_copies(),
            24 => self.cancel_parts(),
            25..=26 => self.retry_part(),
            27 => self.confirm_part(),
            28 => self.move_part(),
            29..=31 => self.tell_random_outcome(),
            32..=33 => self.reprint_at_random(),
            34 => self.requeue_at_random(),
            35 => self.drop_control_file(),
            36..=37 => self.flush(),
            38 => {
                self.begin_operation(Asked::Other, "the printer takes builds");
                self.take_builds();
            }
            _ if self.seed.is_multiple_of(EMPTIES_ARCHIVE) => self.empty_archive_folder(),
            _ => self.cancel_copies(),
        }
    }

    /// A file that no other one is like; a speck must not be printed unasked.
    fn new_part(&mut self, folder: &str, said: Option<u32>) -> DroppedLine {
        let number = self.lines.len() as u32;
        let is_speck = self.rng.random_bool(0.06);
        let scale = if is_speck { 0.3 } else { 1.0 };
        let size_mm = 3.0 + f64::from(number) * 0.003;
        let bytes = stl(&block(size_mm * scale, scale * self.rng.random_range(15..25) as f64 / 10.0, 1.5 * scale));
        let name = match said {
            Some(copies) if self.rng.random_bool(0.5) => format!("part{number}_x{copies}.stl"),
            _ => format!("part{number}.stl"),
        };
        DroppedLine {
            name,
            folder: folder.to_owned(),
            bytes,
            said,
            size_mm: size_mm * scale,
            is_speck,
            late_ticket: None,
            is_revised: false,
        }
    }

    fn remember(&mut self, line: DroppedLine) {
        self.lines.insert(blake3::hash(&line.bytes).to_hex().to_string(), line);
    }

    fn new_order(&mut self) -> String {
        format!("order-{}", self.operations.len())
    }

    fn drop_single_part(&mut self) {
        let folder = if self.rng.random_bool(0.4) { format!("{}/", self.new_order()) } else { String::new() };
        let said = self.rng.random_bool(0.7).then(|| self.rng.random_range(1..5));
        let line = self.new_part(folder.trim_end_matches('/'), said);
        if let Some(copies) = said.filter(|_| !line.name.contains("_x")) {
            self.farm.drop_bytes(&format!("{folder}{}.toml", line.name), format!("copies = {copies}\n").as_bytes());
        }
        self.farm.drop_bytes(&format!("{folder}{}", line.name), &line.bytes);
        self.begin_operation(Asked::Other, &format!("drop {folder}{} ({said:?})", line.name));
        self.remember(line);
    }

    /// An order folder whose list comes first.
    fn drop_order(&mut self) {
        let (order, mut list, mut lines) = (self.new_order(), "file,copies\n".to_owned(), Vec::new());
        for _ in 0..self.rng.random_range(1..4) {
            let copies = self.rng.random_range(1..5);
            let mut line = self.new_part(&order, None);
            line.said = Some(copies);
            list += &format!("{},{copies}\n", line.name);
            self.remember(line.clone());
            lines.push(line);
        }
        self.farm.drop_bytes(&format!("{order}/order.csv"), list.as_bytes());
        lines.iter().for_each(|line| self.farm.drop_bytes(&format!("{order}/{}", line.name), &line.bytes));
        self.begin_operation(Asked::Other, &format!("drop {order}: {list:?}"));
    }

    /// The same name with other content, of a part that may still wait.
    fn drop_revision(&mut self) {
        let is_whole = |line: &&DroppedLine| !line.folder.is_empty() && line.late_ticket.is_none() && !line.is_revised;
        let lines: Vec<DroppedLine> = self.lines.values().filter(is_whole).cloned().collect();
        let recent: Vec<&DroppedLine> = lines.iter().filter(|line| !line.is_speck).collect();
        let Some(&earlier) = recent.choose(&mut self.rng) else { return };
        let earlier_hash = blake3::hash(&earlier.bytes).to_hex().to_string();
        // A list that is still there would count for the newer file too.
        if self.farm.folder("inbox").join(&earlier.folder).join("order.csv").exists() {
            return;
        }
        // A file that is still in the hot folder would be replaced there, and never be seen.
        if !self.parts().iter().any(|part| part.file.content_hash == earlier_hash) {
            return;
        }
        let has_number = earlier.name.contains("_x");
        let said = earlier.said.filter(|_| has_number);
        let mut line = self.new_part(&earlier.folder, said);
        line.name.clone_from(&earlier.name);
        line.is_revised = true;
        self.lines.get_mut(&earlier_hash).unwrap().is_revised = true;
        self.farm.drop_bytes(&format!("{}/{}", line.folder, line.name), &line.bytes);
        self.begin_operation(Asked::Other, &format!("revise {}/{}", line.folder, line.name));
        self.remember(line);
    }

    fn drop_late_ticket(&mut self) {
        let Some(part) = self.pick_part(|_| true) else { return };
        let copies = self.rng.random_range(1..7);
        let number = self.operations.len();
        let Some(line) = self.lines.get_mut(&part.file.content_hash) else { return };
        if line.late_ticket.is_some() || line.is_revised || part.machine != MACHINE {
            return;
        }
        line.late_ticket = Some(number);
        let folder = if line.folder.is_empty() { String::new() } else { format!("{}/", line.folder) };
        let ticket = format!("{folder}{}.toml", line.name);
        self.begin_operation(Asked::LateTicket { copies }, &format!("late ticket {ticket}: {copies}"));
        self.farm.drop_bytes(&ticket, format!("copies = {copies}\npriority = 60\n").as_bytes());
    }

    fn edit_copies(&mut self) {
        let Some(part) = self.pick_part(|_| true) else { return };
        let copies = (part.wanted_copies() + self.rng.random_range(0..4)).saturating_sub(1).max(1);
        let asked = Asked::Edit { part: part.id.0, copies: Some(copies), in_cm: None };
        self.submit(asked, &["edit", &part.id.to_string(), "--copies", &copies.to_string()]);
    }

    fn edit_terms(&mut self) {
        let Some(part) = self.pick_part(|part| part.state == PartState::Waiting) else { return };
        let (id, order) = (part.id.to_string(), self.new_order());
        let options: [&[&str]; 7] = [
            &["--due", "2099-01-01"],
            &["--priority", "80"],
            &["--priority", "100"],
            &["--order", &order],
            &["--unit", "cm"],
            &["--orientation", "upright"],
            &["--note", "with care"],
        ];
        let chosen: &[&str] = options.choose(&mut self.rng).unwrap();
        let in_cm = chosen.contains(&"cm").then(|| part.name.clone());
        let asked = Asked::Edit { part: part.id.0, copies: None, in_cm };
        self.submit(asked, &[&["edit", id.as_str()], chosen].concat());
    }

    fn cancel_copies(&mut self) {
        let Some(part) = self.pick_part(|part| part.state == PartState::Waiting) else { return };
        let copies = self.rng.random_range(1..3);
        let asked = Asked::Cancel { parts: [part.id.0].into(), order: String::new(), copies: Some(copies) };
        self.submit(asked, &["cancel", &format!("{}={copies}", part.id)]);
    }

    fn cancel_parts(&mut self) {
        let Some(part) = self.pick_part(|part| part.state == PartState::Waiting) else { return };
        let order = part.terms.order_name.clone();
        if order.is_empty() || self.rng.random_bool(0.5) {
            let asked = Asked::Cancel { parts: [part.id.0].into(), order: String::new(), copies: None };
            return self.submit(asked, &["cancel", &part.id.to_string()]);
        }
        // Parts that come into the order before the command is read are meant too.
        let parts: BTreeSet<i64> = (self.lines_of_order(&order)).into_iter().chain([part.id.0]).collect();
        let word = format!("order:{order}");
        self.submit(Asked::Cancel { parts, order, copies: None }, &["cancel", &word]);
    }

    fn lines_of_order(&self, order: &str) -> Vec<i64> {
        let in_order = |part: &PartRow| part.terms.order_name == order;
        self.parts().into_iter().filter(in_order).map(|part| part.id.0).collect()
    }

    fn retry_part(&mut self) {
        let Some(part) = self.pick_part(|part| part.state == PartState::Refused) else { return };
        self.submit(Asked::Retry { part: part.id.0 }, &["retry", &part.id.to_string()]);
    }

    fn confirm_part(&mut self) {
        let Some(part) = self.pick_part(|part| !part.owed.question.is_empty()) else { return };
        self.submit(Asked::Confirm { part: part.id.0 }, &["confirm", &part.id.to_string()]);
    }

    fn move_part(&mut self) {
        let Some(part) = self.pick_part(|part| part.state == PartState::Waiting) else { return };
        let to = if part.machine == MACHINE { OTHER } else { MACHINE };
        self.submit(Asked::Other, &["move", &part.id.to_string(), "--to", to]);
    }

    fn flush(&mut self) {
        let machine = *[MACHINE, MACHINE, OTHER].choose(&mut self.rng).unwrap();
        self.submit(Asked::Other, &["flush", machine]);
    }

    fn drop_control_file(&mut self) {
        let name = *["FLUSH", "PAUSE", "RESUME", "flush.txt"].choose(&mut self.rng).unwrap();
        self.farm.drop_bytes(name, b"");
        self.begin_operation(Asked::Other, name);
    }

    /// Somebody tidies up: the originals of a build are removed.
    fn empty_archive_folder(&mut self) {
        let builds: Vec<_> = self.taken.values().map(|build| (build.machine.clone(), build.file.clone())).collect();
        let Some((machine, file)) = builds.choose(&mut self.rng).cloned() else { return };
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        let folder = self.farm.root().join("archive").join(machine).join(name.trim_end_matches(".build.3mf"));
        let originals = intake::files_below(&folder).unwrap_or_default();
        for original in originals.iter().filter(|file| file.extension().is_some_and(|end| end == "stl")) {
            let _ = fs::remove_file(original);
        }
        self.has_emptied_archive = true;
        self.begin_operation(Asked::Other, &format!("empty the archive of {name}"));
    }

    /// Drops the originals again that no archive holds any more, each once, where it is asked for. A second time would be
    /// another order of the same part.
    pub fn drop_missing_originals(&mut self) {
        let damaged = self.farm.query_ledger(async |ledger| ledger.damaged_parts().await.unwrap());
        for part in damaged {
            let Some(line) = self.lines.get(&part.file.content_hash) else { continue };
            let target = self.farm.root().join("inbox").join(&part.machine).join(&line.name);
            if !target.exists() && self.dropped_again.insert(part.id.0) {
                drop_file(self.farm.root(), &target, &line.bytes);
                self.story.push(format!("drop {} again", line.name));
            }
        }
    }

    /// A part that was taken.
    fn pick_part(&mut self, is_meant: impl Fn(&PartRow) -> bool) -> Option<PartRow> {
        let mut parts = self.parts();
        parts.retain(|part| is_meant(part) && self.lines.contains_key(&part.file.content_hash));
        parts.choose(&mut self.rng).cloned()
    }

    /// Writes an operation down, and returns its number.
    pub fn begin_operation(&mut self, asked: Asked, words: &str) -> usize {
        self.story.push(format!("{}: {words}", self.operations.len()));
        self.operations.push(asked);
        self.operations.len() - 1
    }

    /// Runs a command that the daemon carries out, without waiting for its end.
    pub fn submit(&mut self, asked: Asked, words: &[&str]) {
        while self.running.len() >= COMMANDS_AT_ONCE {
            self.await_commands(COMMANDS_AT_ONCE - 1);
        }
        let number = self.begin_operation(asked, &words.join(" "));
        let words: Vec<String> = words.iter().map(|word| (*word).to_owned()).collect();
        let mut command = self.command_of(number, &words);
        self.running.push(command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap());
    }

    /// A command of the worker whose name is the number of the operation.
    pub fn command_of(&self, number: usize, words: &[String]) -> Command {
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let mut command = self.farm.command(&words);
        command.env("SUDO_USER", worker(number));
        command
    }

    /// Waits until at most so many commands run.
    pub fn await_commands(&mut self, most: usize) {
        while self.running.len() > most {
            self.running.retain_mut(|child| child.try_wait().unwrap().is_none());
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
    }
}
