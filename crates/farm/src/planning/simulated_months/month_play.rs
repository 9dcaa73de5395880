//! Plays simulated months: orders wait, builds fire by a rule, printers print, and what is bad is printed again.

use std::{collections::VecDeque, sync::Arc};

use jiff::Timestamp;
use ledger::{BuildId, BuildState, PublishedExperience};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{
    super::{
        build_plan::plan_builds,
        date_outlook::EndReserve,
        earliest_date::{plan_earliest, ticket_date, time_held_back},
        packing_experience::{PackingExperience, upper_end},
        plan_facts::PlanLine,
        reprint_odds::ReprintOdds,
    },
    month_machine::{MonthBuild, MonthMachine, PRINT_TIMES},
    month_orders::{MonthOrder, add_hours, draw_normal, draw_orders},
    month_size::{MonthRules, MonthSize},
    month_table::MonthReport,
};

/// How dense builds really are, and how much their heights scatter around that (a standard deviation of the logarithm).
const TRUE_DENSITY: f64 = 0.12;
const HEIGHT_NOISE: f64 = 0.06;
/// How much the time of a print scatters, and the mean time until somebody comes, hours.
const PRINT_NOISE: f64 = 0.04;
const UNATTENDED_HOURS: f64 = 1.0;
/// Shares of failed builds, and of bad copies of the others.
const FAILED_BUILDS: f64 = 0.05;
const BAD_COPIES: f64 = 0.02;
/// An order while it is made.
struct PlayedOrder {
    order: MonthOrder,
    /// The date that counts: what was wished for, or promised.
    date: Timestamp,
    missing: u32,
}

/// Months that are being played.
struct MonthPlay<'r> {
    rules: &'r MonthRules,
    rng: ChaCha8Rng,
    now: Timestamp,
    machines: Vec<MonthMachine>,
    orders: Vec<PlayedOrder>,
    experience: VecDeque<PublishedExperience>,
    packing: PackingExperience,
    excess_hours: VecDeque<f64>,
    report: MonthReport,
}

/// Plays months until everything is delivered.
pub fn play_months(size: &MonthSize, rules: &MonthRules) -> MonthReport {
    let start: Timestamp = "2026-01-05T00:00:00Z".parse().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(size.seed);
    let drawn = draw_orders(&mut rng, start, size);
    let (folders, printers) = if rules.is_split { (size.printers, 1) } else { (1, size.printers) };
    let due_margin = rules.has_due_trigger.then_some(rules.margin_hours);
    let mut machines = (0..folders).map(|_| MonthMachine::new(due_margin, printers, start)).collect::<Vec<_>>();
    machines.iter_mut().for_each(|machine| machine.profile.trigger.max_wait_secs = 86_400.0 * rules.max_wait_days);
    let (experience, excess_hours) = Default::default();
    let packing = PackingExperience::learn(&MonthMachine::new(None, 1, start).profile, &[]);
    let report = MonthReport::new(start, size.months);
    let mut play =
        MonthPlay { rules, rng, now: start, machines, orders: Vec::new(), experience, packing, excess_hours, report };
    let mut coming: VecDeque<MonthOrder> = drawn.into();
    let mut words: Vec<(Timestamp, usize)> = Vec::new();
    let mut wakes: Vec<Timestamp> = Vec::new();
    while let Some(now) =
        coming.front().map(|order| order.arrives_at).into_iter().chain(words.iter().map(|w| w.0)).chain(wakes).min()
    {
        play.now = play.now.max(now);
        while let Some(order) = coming.pop_front_if(|order| order.arrives_at <= play.now) {
            words.extend(order.late_word.map(|(at, _, _)| (at, play.orders.len())));
            play.take_order(order);
        }
        for (_, order) in words.extract_if(.., |(at, _)| *at <= play.now).collect::<Vec<_>>() {
            play.say_word(order);
        }
        wakes = play.work();
    }
    assert!(play.orders.iter().all(|order| order.missing == 0), "all is delivered");
    play.report
}

impl MonthPlay<'_> {
    /// The machine that an order is dropped into.
    fn machine_of(&self, order: &MonthOrder) -> usize {
        order.folder % self.machines.len()
    }

    /// Quotes an order, if that is the rule, and drops it.
    fn take_order(&mut self, order: MonthOrder) {
        let at = self.machine_of(&order);
        let copies: u32 = order.parts.iter().map(|part| part.owed.copies).sum();
        let (mut date, mut ticket) = (order.wished_at, order.wished_at);
        if self.rules.has_quotes {
            let machine = &self.machines[at];
            let facts = machine.facts(self.packing, self.now);
            let plan = plan_earliest(&machine.profile, &facts, &order.parts, false, self.now);
            let (earliest, place) = plan.done.unwrap();
            let reserve = EndReserve { print_hours: upper_end(self.excess_hours.iter().copied().collect()).max(1.0) };
            let odds = ReprintOdds::learn(self.experience.make_contiguous());
            let build = (&plan.builds[place], copies);
            let held_secs = time_held_back(&machine.profile, &facts, build, (reserve, &odds), self.now);
            let kept = add_hours(earliest, held_secs / 3600.0);
            date = kept.max(order.wished_at);
            ticket = ticket_date(earliest, held_secs, Some(date));
            self.report.note_quote(self.now, kept, order.wished_at);
        }
        for part in &order.parts {
            let mut part = (**part).clone();
            part.terms.due_at = Some(ticket.into());
            part.terms.order_name = self.orders.len().to_string();
            let copies = part.owed.copies;
            self.machines[at].add_waiting(Arc::new(part), copies);
        }
        self.orders.push(PlayedOrder { order, date, missing: copies });
    }

    /// Something is said late of an order: more copies of a line, or fewer as far as they are not built.
    fn say_word(&mut self, number: usize) {
        let Some((_, line, more)) = self.orders[number].order.late_word else { return };
        let at = self.machine_of(&self.orders[number].order);
        let part = self.orders[number].order.parts[line].clone();
        match more {
            Some(more) if self.orders[number].missing > 0 => {
                let mut part = (*part).clone();
                part.times.state_at = self.now.into();
                part.terms.due_at = Some(self.orders[number].date.into());
                part.terms.order_name = number.to_string();
                self.machines[at].add_waiting(Arc::new(part), more);
                self.orders[number].missing += more;
            }
            Some(_) => {}
            None => {
                let mut waiting = self.machines[at].lines.iter_mut();
                if let Some(line) = waiting.find(|line| line.part.id == part.id) {
                    self.orders[number].missing -= line.copies - 1;
                    line.copies = 1;
                }
            }
        }
    }

    /// Ends and begins prints, and fires builds. Returns when there is something to do again.
    fn work(&mut self) -> Vec<Timestamp> {
        let mut wakes = Vec::new();
        for at in 0..self.machines.len() {
            for place in 0..self.machines[at].printers.len() {
                let now = self.now;
                if let Some((build, begun, _)) =
                    self.machines[at].printers[place].prints.take_if(|(.., ends)| *ends <= now)
                {
                    self.tell_outcome(at, build, begun);
                }
            }
            wakes.extend(self.fire_builds(at));
            for place in 0..self.machines[at].printers.len() {
                wakes.extend(self.begin_print(at, place));
            }
        }
        wakes
    }

    /// Fires what its rule fires by now. Returns when the next build fires.
    fn fire_builds(&mut self, at: usize) -> Option<Timestamp> {
        loop {
            let machine = &self.machines[at];
            let facts = machine.facts(self.packing, self.now);
            let first = plan_builds(&machine.profile, &facts, self.now).into_iter().next()?;
            let (fires_at, _) = first.fires?;
            if fires_at > self.now {
                return Some(fires_at);
            }
            if self.rules.awaits_printer && !machine.has_idle_printer(self.now) {
                let opens =
                    machine.profile.printers.iter().map(|rules| rules.begins_at(self.now, &machine.profile.time_zone));
                return opens.min().filter(|opens| *opens > self.now);
            }
            self.publish(at, first.lines, first.print?.place);
            for place in 0..self.machines[at].printers.len() {
                self.begin_print(at, place);
            }
        }
    }

    /// Makes a build of these lines; what does not fit after all goes on waiting.
    fn publish(&mut self, at: usize, mut lines: Vec<PlanLine>, place: usize) {
        let size_mm = self.machines[at].profile.build_volume().size_mm;
        let noise = (HEIGHT_NOISE * draw_normal(&mut self.rng)).exp();
        let height = |lines: &[PlanLine]| {
            let volume_mm3: f64 = lines.iter().map(|line| f64::from(line.copies) * line.each_mm3).sum();
            let least_mm = lines.iter().map(|line| line.least_mm).fold(0.0, f64::max);
            (noise * volume_mm3 / (TRUE_DENSITY * size_mm.x * size_mm.y)).max(least_mm)
        };
        while height(&lines) > size_mm.z && lines.len() > 1 {
            lines.pop();
        }
        let machine = &mut self.machines[at];
        for taken in &lines {
            let waits = machine.lines.iter().position(|line| Arc::ptr_eq(&line.part, &taken.part)).unwrap();
            machine.lines[waits].copies -= taken.copies;
            if machine.lines[waits].copies == 0 {
                machine.lines.remove(waits);
            }
        }
        let height_mm = height(&lines).min(size_mm.z);
        let hours = PRINT_TIMES.occupied(height_mm).as_secs_f64() / 3600.0;
        self.report.note_build(self.now, height_mm, hours);
        machine.printers[place].queue.push_back(MonthBuild { lines, height_mm, published_at: self.now });
    }

    /// Begins the next print of a printer. Returns when it ends, or when it may begin.
    fn begin_print(&mut self, at: usize, place: usize) -> Option<Timestamp> {
        let machine = &mut self.machines[at];
        if let Some((_, _, ends_at)) = &machine.printers[place].prints {
            return Some(*ends_at);
        }
        machine.printers[place].queue.front()?;
        let opens = machine.profile.printers[place].begins_at(self.now, &machine.profile.time_zone);
        if opens > self.now {
            return Some(opens);
        }
        let build = machine.printers[place].queue.pop_front()?;
        let hours = PRINT_TIMES.occupied(build.height_mm).as_secs_f64() / 3600.0;
        let unattended = -UNATTENDED_HOURS * self.rng.random_range(f64::MIN_POSITIVE..1.0_f64).ln();
        let took = hours * (PRINT_NOISE * draw_normal(&mut self.rng)).exp() + unattended;
        let ends_at = add_hours(self.now, took);
        machine.printers[place].prints = Some((build, self.now, ends_at));
        Some(ends_at)
    }

    /// Somebody tells what became of a print: it failed, or some copies are bad; those wait again.
    fn tell_outcome(&mut self, at: usize, build: MonthBuild, begun: Timestamp) {
        let has_failed = self.rng.random_bool(FAILED_BUILDS);
        let (mut bad_copies, mut copies, mut volume_mm3) = (0, 0, 0.0);
        for line in &build.lines {
            let bad = (0..line.copies).filter(|_| has_failed || self.rng.random_bool(BAD_COPIES)).count() as u32;
            let number: usize = line.part.terms.order_name.parse().unwrap();
            let order = &mut self.orders[number];
            order.missing -= line.copies - bad;
            if order.missing == 0 {
                self.report.note_order(order.order.arrives_at, self.now, order.date, order.order.wished_at);
            }
            if bad > 0 {
                let mut part = (*line.part).clone();
                part.owed.put_back_at = Some(self.now.into());
                self.machines[at].add_waiting(Arc::new(part), bad);
            }
            (bad_copies, copies) = (bad_copies + bad, copies + line.copies);
            volume_mm3 += f64::from(line.copies) * line.each_mm3;
        }
        if !has_failed {
            let took = self.now.duration_since(begun).as_secs_f64() / 3600.0;
            self.excess_hours.push_front(took - PRINT_TIMES.occupied(build.height_mm).as_secs_f64() / 3600.0);
            self.excess_hours.truncate(40);
        }
        self.experience.push_front(PublishedExperience {
            build: BuildId(1),
            state: if has_failed { BuildState::Failed } else { BuildState::Complete },
            height_mm: build.height_mm,
            part_volume_mm3: volume_mm3,
            copies,
            bad_copies: if has_failed { 0 } else { bad_copies },
            published_at: build.published_at.into(),
            state_at: self.now.into(),
        });
        self.experience.truncate(60);
        self.packing = PackingExperience::learn(&self.machines[at].profile, self.experience.make_contiguous());
    }
}
