//! What the operations mean for the copies wanted. The events of the ledger tell only which operations took place and in
//! which order; the numbers are those of the test.

use std::collections::BTreeMap;

use ledger::{
    CommandKind, CommandRow, CommandState, EventKind, EventRow, OrderState, OrderSummary, PartRow, PartState,
};

use super::asked::{Asked, CopiesByFile, DroppedLine, TakenBuild, named_operation};

/// What the ledger holds.
#[derive(Debug, Default)]
pub struct LedgerRecord {
    pub parts: Vec<(PartRow, Vec<EventRow>)>,
    pub commands: Vec<CommandRow>,
    pub orders: Vec<OrderSummary>,
}

/// What became of a part according to the operations.
#[derive(Debug, Default, Clone)]
pub struct LineAccount {
    pub wanted: u32,
    /// It was refused last, for this reason.
    pub refused: Option<String>,
    pub is_confirmed: bool,
    /// Copies that a newer revision took over.
    taken_over: u32,
    /// `wanted` after each event that changed it.
    history: Vec<(i64, u32)>,
}

/// Replays operations on all parts.
pub struct OperationReplay<'a> {
    pub lines: &'a BTreeMap<String, DroppedLine>,
    pub operations: &'a [Asked],
    pub taken: &'a BTreeMap<i64, TakenBuild>,
    /// By part.
    pub accounts: BTreeMap<i64, LineAccount>,
    /// How often an operation changed a part.
    pub applied: BTreeMap<(usize, i64), u32>,
    pub broken: Vec<String>,
}

impl<'a> OperationReplay<'a> {
    pub fn new(
        lines: &'a BTreeMap<String, DroppedLine>,
        operations: &'a [Asked],
        taken: &'a BTreeMap<i64, TakenBuild>,
    ) -> Self {
        let (accounts, applied) = (BTreeMap::new(), BTreeMap::new());
        Self { lines, operations, taken, accounts, applied, broken: Vec::new() }
    }

    /// Replays the events of every part, and compares the result with the rows.
    pub fn run(&mut self, record: &LedgerRecord) {
        for (part, events) in &record.parts {
            let Some(line) = self.lines.get(&part.file.content_hash) else {
                self.broken.push(format!("part {} ({}) was never dropped", part.id, part.name));
                continue;
            };
            let mut account = LineAccount { wanted: line.said.unwrap_or(1), ..LineAccount::default() };
            for event in events {
                if let Some(fault) = self.apply(part, line, event, &mut account) {
                    let text = format!("part {} ({}), event {:?}: {fault}", part.id, part.name, event.detail);
                    self.broken.push(text);
                }
                account.history.push((event.id, account.wanted));
            }
            let wanted = part.wanted_copies();
            if wanted != account.wanted {
                let text =
                    format!("part {} ({}): {wanted} wanted, by what was asked {}", part.id, part.name, account.wanted);
                self.broken.push(text);
            }
            self.accounts.insert(part.id.0, account);
        }
        self.compare_commands(&record.commands);
        self.compare_order_states(&record.orders);
    }

    /// Applies an event; returns what is wrong with it.
    fn apply(
        &mut self,
        part: &PartRow,
        line: &DroppedLine,
        event: &EventRow,
        account: &mut LineAccount,
    ) -> Option<String> {
        match event.kind {
            EventKind::Edited => self.apply_edit(part, line, event, account),
            EventKind::CopiesCancelled => self.apply_cancelled(part, event, account),
            EventKind::CopiesWanted if event.detail.ends_with("was printed well after all") => {
                account.wanted += 1;
                let returns = |asked: &Asked| match asked {
                    Asked::Outcome { build, returned, .. } => {
                        Some(*build) == event.build_id.map(|b| b.0) && returned.contains_key(&part.file.content_hash)
                    }
                    _ => false,
                };
                (!self.operations.iter().any(returns)).then(|| "nobody corrected that outcome".to_owned())
            }
            EventKind::Revised => self.apply_revision(event, account),
            EventKind::Refused => {
                account.refused = Some(event.detail.clone());
                if event.detail.starts_with("A newer revision") {
                    // The newer one has taken over what was asked.
                    account.taken_over = std::mem::take(&mut account.wanted);
                }
                let asked = named_operation(&event.detail).map(|number| (number, self.operations.get(number)));
                match asked {
                    Some((number, Some(Asked::Cancel { parts, order, .. })))
                        if parts.contains(&part.id.0) || !order.is_empty() && part.terms.order_name == *order =>
                    {
                        self.count_applied(number, part)
                    }
                    Some(_) => Some("nobody asked for that".to_owned()),
                    None if event.detail.starts_with("A newer revision") && line.is_revised => None,
                    None => Some("it was refused without a cause".to_owned()),
                }
            }
            EventKind::Claimed if event.detail == "taken back" => {
                account.refused = None;
                account.wanted += std::mem::take(&mut account.taken_over);
                let takes_back = |asked: &Asked| matches!(asked, Asked::Retry { part: id } if *id == part.id.0);
                (!self.operations.iter().any(takes_back)).then(|| "nobody took it back".to_owned())
            }
            EventKind::Confirmed => {
                account.is_confirmed = true;
                let confirms = |asked: &Asked| matches!(asked, Asked::Confirm { part: id } if *id == part.id.0);
                (!self.operations.iter().any(confirms)).then(|| "nobody said so".to_owned())
            }
            _ => None,
        }
    }

    fn apply_edit(
        &mut self,
        part: &PartRow,
        line: &DroppedLine,
        event: &EventRow,
        account: &mut LineAccount,
    ) -> Option<String> {
        let (by, changes) = event.detail.split_once(": ")?;
        let split = |word| changes.split_once(word);
        let (new, rest) = split(" copies instead of ").or_else(|| split(" copy instead of "))?;
        let old = rest.split(',').next().unwrap_or_default();
        let (Ok(new), Ok(old)) = (new.parse::<u32>(), old.parse::<u32>()) else { return None };
        let before = std::mem::replace(&mut account.wanted, new);
        if before != old {
            return Some(format!("{before} were wanted before"));
        }
        let number = match line.late_ticket {
            Some(number) if by.starts_with(&line.name) => number,
            _ => named_operation(by)?,
        };
        let is_asked = match self.operations.get(number) {
            Some(Asked::Edit { part: id, copies, .. }) => *id == part.id.0 && *copies == Some(new),
            Some(Asked::LateTicket { copies }) => *copies == new,
            _ => false,
        };
        if !is_asked {
            return Some("nobody asked for that".to_owned());
        }
        self.count_applied(number, part)
    }

    fn apply_cancelled(&mut self, part: &PartRow, event: &EventRow, account: &mut LineAccount) -> Option<String> {
        // Edits are taken from their own event.
        let number = named_operation(&event.detail)?;
        let number_of_copies = event.detail.split(' ').next().unwrap_or_default().parse::<u32>().unwrap_or_default();
        let fewer = match self.operations.get(number) {
            Some(Asked::Edit { .. }) => return None,
            Some(Asked::Cancel { parts, copies: Some(copies), .. }) if parts.contains(&part.id.0) => *copies,
            Some(Asked::Outcome { build, newly_bad, .. }) if Some(*build) == event.build_id.map(|b| b.0) => {
                newly_bad.get(&part.file.content_hash).copied().unwrap_or_default()
            }
            _ => return Some("nobody asked for that".to_owned()),
        };
        account.wanted = account.wanted.saturating_sub(fewer);
        if fewer != number_of_copies {
            return Some(format!("{fewer} was asked"));
        }
        self.count_applied(number, part)
    }

    /// A newer file of the same name takes over what was asked with the earlier one.
    fn apply_revision(&mut self, event: &EventRow, account: &mut LineAccount) -> Option<String> {
        if event.detail.ends_with("took its place") {
            // It was refused, and a newer one of the same name is wanted in place of it.
            account.taken_over += std::mem::take(&mut account.wanted);
            return None;
        }
        if !event.detail.ends_with("with all that was asked with it") {
            return None;
        }
        let earlier = event.detail.trim_start_matches("it replaces part ").split(',').next()?.parse::<i64>().ok()?;
        let Some(earlier) = self.accounts.get(&earlier) else { return Some("there is no such part".to_owned()) };
        let before = earlier.history.iter().rev().find(|(id, _)| *id < event.id);
        account.wanted = before.map_or(account.wanted, |(_, wanted)| *wanted);
        None
    }

    fn count_applied(&mut self, number: usize, part: &PartRow) -> Option<String> {
        let applied = self.applied.entry((number, part.id.0)).or_default();
        *applied += 1;
        (*applied > 1).then(|| format!("operation {number} was carried out {applied} times"))
    }

    /// What was answered is what was done.
    fn compare_commands(&mut self, commands: &[CommandRow]) {
        for command in commands {
            let (Some(part), Some(number)) = (command.part_id, named_operation(&command.asked_by)) else { continue };
            let applied = self.applied.get(&(number, part.0)).copied().unwrap_or_default();
            let changes_copies = match self.operations.get(number) {
                Some(Asked::Edit { copies, .. }) => copies.is_some(),
                Some(Asked::Cancel { .. }) => true,
                _ => false,
            };
            let (is_done, is_refused) = (command.state == CommandState::Done, command.state == CommandState::Refused);
            let was_so = command.answer.contains("these values already");
            let fault = match applied {
                0 if is_done && changes_copies && !was_so => "was answered as done, and nothing happened",
                1.. if is_refused => "was refused, and was carried out all the same",
                _ => continue,
            };
            let CommandRow { kind, id, .. } = command;
            self.broken.push(format!("{kind} of part {part} (command {id}) {fault}: {}", command.answer));
        }
        let retried = commands.iter().filter(|c| c.kind == CommandKind::Retry && c.state == CommandState::Done).count();
        let asked = self.operations.iter().filter(|asked| matches!(asked, Asked::Retry { .. })).count();
        if retried > asked {
            self.broken.push(format!("{asked} retries were asked for, {retried} were carried out"));
        }
    }

    fn compare_order_states(&mut self, orders: &[OrderSummary]) {
        for order in orders {
            let (state, by_lines): (OrderState, OrderState) = (order.order.state, OrderState::of_copies(&order.copies));
            if state != by_lines {
                self.broken.push(format!("order {} is {state}, by its lines {by_lines}", order.order.name));
            }
        }
    }

    /// What must hold of each part besides the sums; `told_bad` = the copies told bad.
    pub fn compare_parts(&mut self, record: &LedgerRecord, told_bad: &CopiesByFile) {
        for (part, _) in &record.parts {
            let (id, hash) = (part.id, &part.file.content_hash);
            let (Some(account), Some(line)) = (self.accounts.get(&id.0), self.lines.get(hash)) else { continue };
            let printed: u32 = self.taken.values().filter_map(|build| build.copies.get(hash)).sum();
            let is_printed_well = printed > told_bad.get(hash).copied().unwrap_or_default();
            let is_refused = part.state == PartState::Refused;
            let was_replaced = account.refused.as_ref().is_some_and(|reason| reason.starts_with("A newer revision"));
            let fault = if is_refused != account.refused.is_some() {
                format!("it is {}, and was refused last: {:?}", part.state, account.refused)
            } else if line.is_speck && !account.is_confirmed && !self.was_enlarged(&part.name) && printed > 0 {
                format!("{printed} copies were printed, and nobody said yes")
            } else if was_replaced && is_printed_well && !self.was_taken_back(id.0) && !self.was_returned(hash) {
                format!("{printed} copies were printed, and a newer revision took its place")
            } else {
                continue;
            };
            self.broken.push(format!("part {id} ({}): {fault}", part.name));
        }
    }

    fn was_taken_back(&self, part: i64) -> bool {
        self.operations.iter().any(|asked| matches!(asked, Asked::Retry { part: id } if *id == part))
    }

    /// A corrected outcome made copies good after all, perhaps after a newer revision had replaced them.
    fn was_returned(&self, hash: &str) -> bool {
        let returns = |asked: &Asked| matches!(asked, Asked::Outcome { returned, .. } if returned.contains_key(hash));
        self.operations.iter().any(returns)
    }

    fn was_enlarged(&self, name: &str) -> bool {
        self.operations.iter().any(|asked| matches!(asked, Asked::Edit { in_cm: Some(of), .. } if of == name))
    }

    /// Copies wanted, by file.
    pub fn wanted(&self, record: &LedgerRecord) -> CopiesByFile {
        let mut wanted = CopiesByFile::new();
        for (part, _) in &record.parts {
            let copies = self.accounts.get(&part.id.0).map_or(0, |account| account.wanted);
            *wanted.entry(part.file.content_hash.clone()).or_default() += copies;
        }
        wanted
    }
}
