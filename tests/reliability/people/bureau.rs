//! A month of a bureau: orders as customers send them, in three materials, for four machines, until each of them has ended. Customers send
//! lists in four languages, workbooks, archives, names, tickets, OBJ, broken meshes and requests of programs; people cancel, close, move
//! and mend; copies are bad and printed again; the daemon is killed between the days. At the end the build files that the printers took
//! must hold exactly what was ordered, each copy in its material, and the shares of the orders must sum up to what the builds cost.

mod customer_order;
mod month_end;

use std::{fs, path::PathBuf};

use customer_order::{CustomerOrder, OrderFate};
use ledger::{PartRow, PartState};
use month_end::PrintedBuild;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{
    harness::{ActionCounts, SectionBudget, SectionResult, seed},
    support::{
        TestFarm,
        farm_files::{drop_file, list_build_files},
        http::send_request,
        wait_until_or,
    },
};

/// The machines, and what is loaded in them.
const MACHINES: [(&str, &str); 4] = [("fuse-1", "PA12"), ("fuse-2", "PA12"), ("jet-1", "PA11"), ("binder-1", "316L")];
/// Prices of a copy and of a litre of parts.
const PER_PART: f64 = 1.37;
const PER_LITRE: f64 = 41.5;
const FARM: &str = "scan_secs = 0.2\ncache_bytes = 0\nthreads = 1\norphan_ticket_secs = 20\n[log]\nfilter = \"info\"\n[materials]\n\
    PA12 = [\"PA 12\", \"Nylon 12\", \"PA2200\"]\nPA11 = [\"Rilsan\"]\n316L = [\"1.4404\"]\n";
/// The file of a machine, after its material.
const PROFILE: &str = "volume_mm = [60, 60, 60]\nclearance_mm = 1.0\nsettle_secs = 0.05\nunfinished_secs = 0.5\nfinal_secs = 0.05\n\
    arrival_secs = 0.05\nincomplete_secs = 30\nmax_attempts = 100\n[trigger]\ncopies = 12\n";
/// Orders and days of a month, short and long.
const ORDERS: (usize, usize) = (24, 300);
const DAYS: (usize, usize) = (3, 21);
/// Time for the orders of a day to be taken, and for all orders to end, seconds.
const DAY_SECS: f64 = 120.0;
const END_SECS: f64 = 600.0;

pub fn run(budget: &SectionBudget) -> SectionResult {
    let seed = seed();
    let mut bureau = Bureau::new(seed);
    let (orders, days) = (budget.pick(ORDERS.0, ORDERS.1), budget.pick(DAYS.0, DAYS.1));
    for day in 0..days {
        bureau.live_a_day(orders * (day + 1) / days);
        if bureau.rng.random_bool(0.5) {
            bureau.farm.kill();
            bureau.kills += 1;
            bureau.farm.start();
        }
    }
    bureau.finish(seed)
}

/// The bureau, and what was ordered and printed.
struct Bureau {
    farm: TestFarm,
    rng: ChaCha8Rng,
    orders: Vec<CustomerOrder>,
    taken: Vec<PrintedBuild>,
    /// Told bad, by BLAKE3 of the part.
    bad: Vec<String>,
    kills: u64,
    broken: Vec<String>,
}

impl Bureau {
    fn new(seed: u64) -> Self {
        let profile = |material: &str| {
            let costs = format!("[costs]\nper_part = {PER_PART}\nper_litre = {PER_LITRE}\n");
            format!("material = \"{material}\"\n{PROFILE}{costs}")
        };
        let mut farm = TestFarm::with_machine(MACHINES[0].0, &profile(MACHINES[0].1));
        for (name, material) in &MACHINES[1..] {
            farm.write_profile(name, &profile(material));
        }
        let listen = format!("[web]\nlisten = \"unix:{}\"\n", farm.root().join("web.sock").display());
        fs::write(farm.config(), format!("{FARM}{listen}")).unwrap();
        farm.start();
        let rng = ChaCha8Rng::seed_from_u64(seed);
        Self { farm, rng, orders: Vec::new(), taken: Vec::new(), bad: Vec::new(), kills: 0, broken: Vec::new() }
    }

    fn socket(&self) -> PathBuf {
        self.farm.root().join("web.sock")
    }

    fn inbox(&self, machine: &str) -> PathBuf {
        self.farm.root().join("inbox").join(machine)
    }

    /// Orders come until there are `until` of them; people do what each needs; the printers print.
    fn live_a_day(&mut self, until: usize) {
        let first = self.orders.len();
        while self.orders.len() < until {
            let order = CustomerOrder::think_of(self.orders.len(), &mut self.rng);
            self.send(&order);
            self.orders.push(order);
        }
        let lines: usize = self.orders.iter().map(|order| order.lines.len()).sum();
        let mut parts = Vec::new();
        let settled = |parts: &[PartRow]| parts.iter().filter(|part| part.state != PartState::Claimed).count();
        let farm = &self.farm;
        let missing = || farm.log();
        wait_until_or(&format!("{lines} parts are taken"), DAY_SECS, missing, || {
            parts = farm.all_parts();
            settled(&parts) >= lines
        });
        for number in first..self.orders.len() {
            self.serve(number, &parts);
        }
        self.print();
    }

    /// Sends what a customer sends: files, or a request.
    fn send(&mut self, order: &CustomerOrder) {
        for (name, bytes) in &order.files {
            drop_file(self.farm.root(), &self.inbox(order.folder).join(name), bytes);
        }
        let Some(request) = &order.request else { return };
        let answer = |words: &str, body: &[u8]| {
            let mut answer = None;
            // A daemon that was just started does not listen yet.
            wait_until_or(
                "the door answers",
                20.0,
                || self.farm.log(),
                || {
                    answer = send_request(&self.socket(), words, body);
                    answer.is_some()
                },
            );
            answer.unwrap()
        };
        for (hash, bytes) in &request.contents {
            let put = answer(&format!("PUT /api/v1/content/{hash}"), bytes);
            assert!(matches!(put.status, 200 | 201), "{put:?}");
        }
        let words = format!("POST /api/v1/orders\ncontent-type: application/json\nidempotency-key: {}", order.name);
        let taken = answer(&words, request.document.as_bytes());
        assert_eq!(taken.status, 202, "{taken:?}");
    }

    /// People do what an order needs.
    fn serve(&mut self, number: usize, parts: &[PartRow]) {
        let order = &self.orders[number];
        let own: Vec<&PartRow> = parts.iter().filter(|part| part.terms.order_name == order.name).collect();
        for part in &own {
            if !part.owed.question.is_empty() {
                self.broken.push(format!("{} of {} is asked about: {}", part.name, order.name, part.owed.question));
            }
        }
        if order.is_broken {
            for part in own.iter().filter(|part| part.state == PartState::Refused) {
                if number.is_multiple_of(2) {
                    self.farm.nestd_ok(&["mend", &part.id.to_string()]);
                } else {
                    let words = format!("POST /api/v1/parts/{}/retry\ncontent-type: application/json", part.id);
                    let mended = send_request(&self.socket(), &words, br#"{"mend": true}"#).unwrap();
                    assert!(matches!(mended.status, 200 | 202), "{mended:?}");
                }
            }
        }
        match order.fate {
            OrderFate::Printed => {}
            // Some of it may be in a build already, or all of it: then the command says so.
            OrderFate::Cancelled => drop(self.farm.nestd(&["cancel", &order.name])),
            OrderFate::Closed => drop(self.farm.nestd(&["close", &order.name])),
            OrderFate::Moved => drop(self.farm.nestd_ok(&["move", &order.name, "--to", order.machine])),
        }
    }

    /// The printers take what is in their queues, and people tell what became of it: one copy of some builds is bad.
    fn print(&mut self) {
        for (machine, material) in MACHINES {
            for file in list_build_files(&self.farm.root().join("queue").join(machine)) {
                let name = file.file_name().unwrap().to_string_lossy().into_owned();
                let copies = build_file::read_build(&file, &Default::default()).unwrap();
                let kept = self.farm.root().join("printed").join(&name);
                fs::create_dir_all(kept.parent().unwrap()).unwrap();
                assert!(!kept.exists(), "{name} appears in the queue again");
                fs::rename(&file, &kept).unwrap();
                let number: i64 = name.trim_end_matches(".build.3mf").rsplit('_').next().unwrap().parse().unwrap();
                let hashes: Vec<String> = copies.iter().map(|copy| copy.source_hash.clone().unwrap()).collect();
                let mut words = vec!["outcome".to_owned(), number.to_string(), "complete".to_owned()];
                if self.rng.random_bool(0.2) {
                    let at = self.rng.random_range(0..copies.len());
                    words.extend(["--bad".to_owned(), format!("{}=1", copies[at].part_number.clone().unwrap())]);
                    self.bad.push(hashes[at].clone());
                }
                let words: Vec<&str> = words.iter().map(String::as_str).collect();
                // The file is there a moment before the ledger says that it is published.
                let told = || self.farm.nestd(&words).status.success();
                wait_until_or(&format!("{words:?} is carried out"), 20.0, || self.farm.log(), told);
                self.taken.push(PrintedBuild { number, material, hashes });
            }
        }
    }

    /// Fires and prints until each order has ended, then compares.
    fn finish(mut self, seed: u64) -> SectionResult {
        let mut open = Vec::new();
        let began = std::time::Instant::now();
        while began.elapsed().as_secs_f64() < END_SECS {
            self.print();
            open = self.open_orders();
            if open.is_empty() {
                break;
            }
            for (machine, _) in MACHINES {
                drop(self.farm.nestd(&["flush", machine]));
            }
            std::thread::sleep(std::time::Duration::from_millis(300));
        }
        self.broken.extend(open.iter().map(|order| format!("{order} does not end")));
        self.compare();
        SectionResult {
            points: self.orders.len() as u64,
            faults: self.kills,
            files: self.orders.iter().map(|order| order.lines.len() as u64).sum(),
            builds: self.taken.len() as u64,
            counts: ActionCounts { kills: self.kills, ..ActionCounts::default() },
            broken: self.broken.iter().map(|text| format!("NESTD_SEED={seed}: {text}")).collect(),
            note: format!(
                "{} orders as {} kinds of customers send them, {} copies bad; NESTD_SEED={seed}",
                self.orders.len(),
                customer_order::KINDS.len(),
                self.bad.len()
            ),
            ..SectionResult::default()
        }
    }
}
