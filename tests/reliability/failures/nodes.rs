//! Three nodes with machines and one without as one farm on a PostgreSQL server, all as processes: parts are dropped, flushed and moved
//! between the nodes, while nodes are killed, stopped for longer than a lease, ended in
//! order, have their machines adopted or their connections cut, and the server is restarted, crashes, or is replaced by a standby that lacks
//! the last changes. One node with machines and the one without have clocks that are wrong by hours, where libfaketime is installed. At the end each dropped
//! part must be printed in exactly the copies that were asked for: the build files tell, not the ledger.

mod farm_node;
mod node_fault;
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::PathBuf,
    process::{Child, Stdio},
    time::{Duration, Instant},
};

use farm::{InvariantExpectations, check_invariants};
use farm_node::{FarmNode, PROFILE, can_set_clocks, configured_node, configured_spare, machine_name};
use ledger::{PartRow, PartState};
use ledger_fixtures::postgres_cluster::{PostgresCluster, find_programs};
use ledger_fixtures::server_link;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{
    harness::{SectionBudget, SectionResult, seed},
    support::farm_files::{block, drop_file, list_build_files, stl},
};

const NODES: usize = 3;
/// Parts and faults of a long run; a short run ends when its time is over.
const PARTS: usize = 1_000;
const FAULTS: u64 = 200;
/// Operations for each fault.
const OPERATIONS_PER_FAULT: u64 = 8;
/// Time budget of a short run, and the time in which a farm comes to rest, seconds.
const SHORT_SECS: f64 = 20.0;
const REST_SECS: u64 = 240;
const PAUSE: Duration = Duration::from_millis(60);

pub fn run(budget: &SectionBudget) -> SectionResult {
    if find_programs().is_none() {
        return SectionResult { note: "not run: no PostgreSQL is installed".to_owned(), ..SectionResult::default() };
    }
    let mut farm = NodesFarm::new(seed());
    farm.run_operations(&budget.at_least(SHORT_SECS));
    farm.finish()
}

/// The nodes, and what the test knows.
struct NodesFarm {
    nodes: Vec<FarmNode>,
    /// A node without machines, which keeps second copies.
    spare: FarmNode,
    server: PostgresCluster,
    rng: ChaCha8Rng,
    seed: u64,
    /// Number of parts that are dropped.
    parts: usize,
    /// Wanted copies and bytes by name.
    dropped: BTreeMap<String, (u32, Vec<u8>)>,
    /// Name by BLAKE3.
    names: BTreeMap<String, String>,
    taken: Vec<PathBuf>,
    running: Vec<Child>,
    operations: u64,
    faults: u64,
    story: Vec<String>,
}

impl NodesFarm {
    fn new(seed: u64) -> Self {
        let server = PostgresCluster::start();
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        let database = runtime.block_on(server.make_database(None));
        let mut nodes: Vec<FarmNode> = (0..NODES).map(|number| configured_node(number, &server, &database)).collect();
        let mut spare = configured_spare(&server, &database);
        for node in nodes.iter_mut().chain([&mut spare]) {
            node.start();
            let is_open = || node.farm.log().contains("The farm is open");
            crate::support::wait_until("the node has its machine", 60.0, is_open);
        }
        // From now on each node could serve each machine.
        for number in 0..NODES {
            let folders = ["inbox", "queue", "error", "archive"]
                .map(|kind| format!("{kind} = {:?}\n", nodes[number].farm.folder(kind)))
                .concat();
            for other in (0..NODES).filter(|&other| other != number) {
                nodes[other].farm.write_profile(&machine_name(number), &format!("{PROFILE}[folders]\n{folders}"));
            }
        }
        nodes.iter().for_each(|node| node.farm.reload());
        Self {
            nodes,
            spare,
            server,
            rng: ChaCha8Rng::seed_from_u64(seed),
            seed,
            parts: 0,
            dropped: BTreeMap::new(),
            names: BTreeMap::new(),
            taken: Vec::new(),
            running: Vec::new(),
            operations: 0,
            faults: 0,
            story: Vec::new(),
        }
    }
}

/// Whether a part was left to another nestd, which no node may do: there is no other one than these, and each thinks that of the others.
fn is_given_up(part: &PartRow) -> bool {
    part.state == PartState::Refused && part.refused.reason.starts_with("Another nestd has taken over")
}

impl NodesFarm {
    fn run_operations(&mut self, budget: &SectionBudget) {
        let faults = budget.pick(6, FAULTS);
        self.parts = budget.pick(40, PARTS);
        while (self.dropped.len() < self.parts || self.faults < faults) && !budget.is_spent() {
            self.run_operation();
            if self.operations.is_multiple_of(OPERATIONS_PER_FAULT) && self.faults < faults {
                self.inject_fault();
            }
        }
    }

    fn run_operation(&mut self) {
        match self.rng.random_range(0..10) {
            0..6 if self.dropped.len() < self.parts => self.drop_part(),
            6 => self.flush(),
            7 => self.move_part(),
            _ => self.take_builds(),
        }
        self.operations += 1;
        std::thread::sleep(PAUSE);
    }

    fn drop_part(&mut self) {
        let machine = self.rng.random_range(0..NODES);
        self.drop_part_for(machine);
    }

    fn drop_part_for(&mut self, node: usize) {
        let number = self.dropped.len();
        let size = |low: f64, rng: &mut ChaCha8Rng| low + rng.random_range(0.0..8.0);
        let sides = [8.0, 6.0].map(|low| size(low, &mut self.rng));
        // Each part has a size of its own.
        let bytes = stl(&block(sides[0], sides[1], 4.0 + number as f64 * 0.01));
        let copies = self.rng.random_range(1..4);
        let name = format!("part{number}_x{copies}.stl");
        let farm = &self.nodes[node].farm;
        drop_file(farm.root(), &farm.folder("inbox").join(&name), &bytes);
        self.names.insert(blake3::hash(&bytes).to_hex().to_string(), name.clone());
        self.dropped.insert(name, (copies, bytes));
    }

    /// Runs a command on a node that may run, without waiting for its end.
    fn submit(&mut self, words: &[&str]) {
        self.running.retain_mut(|child| child.try_wait().unwrap().is_none());
        let node = self.rng.random_range(0..NODES);
        let mut command = self.nodes[node].command(words);
        self.running.push(command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap());
    }

    fn flush(&mut self) {
        let machine = machine_name(self.rng.random_range(0..NODES));
        self.submit(&["flush", &machine]);
    }

    fn move_part(&mut self) {
        let (part, machine) =
            (self.rng.random_range(0..self.dropped.len().max(1)) + 1, machine_name(self.rng.random_range(0..NODES)));
        self.submit(&["move", &part.to_string(), "--to", &machine]);
    }

    /// The printers take what is in their queues.
    fn take_builds(&mut self) {
        for node in &self.nodes {
            for file in list_build_files(&node.farm.folder("queue")) {
                let taken = node.farm.root().join("printed").join(file.file_name().unwrap());
                fs::create_dir_all(taken.parent().unwrap()).unwrap();
                assert!(!taken.exists(), "{} appears in the queue again", taken.display());
                fs::rename(&file, &taken).unwrap();
                self.taken.push(taken);
            }
        }
    }

    fn parts(&self) -> Vec<PartRow> {
        self.nodes[0].farm.all_parts()
    }

    /// Asks for what is missing until every part is printed. Returns what keeps it from that.
    fn come_to_rest(&mut self) -> Option<String> {
        let deadline = Instant::now() + Duration::from_secs(REST_SECS);
        let mut unrest = String::new();
        while Instant::now() < deadline {
            self.take_builds();
            self.start_ended_nodes();
            let parts = self.parts();
            let open: Vec<String> = (parts.iter().filter(|part| part.state.is_live()))
                .map(|part| format!("part {} ({}) {} in {}", part.id, part.name, part.state, part.machine))
                .collect();
            let is_retried = self.retry_what_was_taken_out(&parts);
            if open.is_empty() && !is_retried && parts.len() >= self.dropped.len() {
                return None;
            }
            unrest = format!("{} of {} parts are known, {open:?}", parts.len(), self.dropped.len());
            self.drop_missing_originals();
            for machine in (0..NODES).map(machine_name) {
                self.submit(&["resume", &machine]);
                self.submit(&["flush", &machine]);
            }
            std::thread::sleep(Duration::from_secs(3));
        }
        let alerts: String = (self.nodes.iter())
            .map(|node| String::from_utf8_lossy(&node.command(&["status"]).output().unwrap().stdout).into_owned())
            .collect();
        Some(format!("the farm does not come to rest: {unrest}\n{alerts}"))
    }

    /// A person takes back what a repair has taken out and asked to look at, where no build file holds it. Returns whether there was any.
    /// What was left to another nestd stays refused: it is lost, and [`NodesFarm::compare_copies`] says so.
    fn retry_what_was_taken_out(&mut self, parts: &[PartRow]) -> bool {
        let printed = self.printed_copies();
        let is_elsewhere = |part: &PartRow| {
            let hash = &part.file.content_hash;
            printed.contains_key(hash) || parts.iter().any(|p| p.file.content_hash == *hash && p.state.is_live())
        };
        let out: Vec<String> = (parts.iter())
            .filter(|part| part.state == PartState::Refused && !is_elsewhere(part) && !is_given_up(part))
            .map(|part| part.id.to_string())
            .collect();
        out.iter().for_each(|part| self.submit(&["retry", part]));
        !out.is_empty()
    }

    /// Copies in the build files that the printers took, by content: a server that has lost changes gives numbers of parts again.
    fn printed_copies(&self) -> BTreeMap<String, u32> {
        let mut printed = BTreeMap::new();
        for file in &self.taken {
            for copy in build_file::read_build(file, &Default::default()).unwrap() {
                *printed.entry(copy.source_hash.unwrap()).or_default() += 1;
            }
        }
        printed
    }

    /// Drops the originals again that were on a node whose last machine was adopted. One that still lies in a hot folder, or is claimed there,
    /// is not dropped a second time: that would order its copies once more. Its hot folders are looked at before the ledger, since a claim
    /// ends together with what is missing.
    fn drop_missing_originals(&mut self) {
        let Some(under_way) = self.files_under_way() else { return };
        let damaged = self.nodes[0].farm.query_ledger(async |ledger| ledger.damaged_parts().await.unwrap());
        for part in damaged {
            let Some(name) = self.names.get(&part.file.content_hash) else { continue };
            let number: usize = part.machine.trim_start_matches("machine-").parse().unwrap();
            let farm = &self.nodes[number].farm;
            if !under_way.contains(name) {
                drop_file(farm.root(), &farm.folder("inbox").join(name), &self.dropped[name].1);
            }
        }
    }

    /// Names of the files in all hot folders, with those that are claimed; `None` where a folder was renamed meanwhile.
    fn files_under_way(&self) -> Option<BTreeSet<String>> {
        let mut names = BTreeSet::new();
        let mut folders: Vec<PathBuf> = self.nodes.iter().map(|node| node.farm.folder("inbox")).collect();
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(&folder).ok()?.flatten() {
                names.insert(entry.file_name().to_string_lossy().into_owned());
                folders.extend(entry.path().is_dir().then(|| entry.path()));
            }
        }
        Some(names)
    }

    fn finish(mut self) -> SectionResult {
        let mut broken: Vec<String> = self.come_to_rest().into_iter().collect();
        self.take_builds();
        broken.extend(self.compare_copies());
        for node in &self.nodes {
            let settings = settings::load_settings(Some(&node.farm.config()), Some(node.farm.root())).unwrap();
            let own = node.farm.query_ledger(async |ledger| {
                let rows = ledger.list_machines().await.unwrap();
                let mut settings = settings;
                settings
                    .profiles
                    .retain(|name, _| rows.iter().any(|row| row.machine == *name && row.node == node.name));
                check_invariants(&settings, ledger, &InvariantExpectations::default()).await.unwrap().violations
            });
            broken.extend(own.iter().map(|violation| format!("{}: {violation}", node.name)));
        }
        if !broken.is_empty() {
            broken.push(format!("the story was\n  {}", self.story.join("\n  ")));
        }
        let seed = self.seed;
        SectionResult {
            points: self.operations,
            faults: self.faults,
            files: self.dropped.len() as u64,
            builds: self.taken.len() as u64,
            broken: broken.into_iter().map(|text| format!("NESTD_SEED={seed}: {text}")).collect(),
            note: format!(
                "{NODES} nodes and PostgreSQL, clocks {}; NESTD_SEED={seed}",
                if can_set_clocks() { "off by hours" } else { "right (libfaketime is not installed)" }
            ),
            ..SectionResult::default()
        }
    }

    /// Holds the copies in the build files against what was asked.
    fn compare_copies(&self) -> Vec<String> {
        let mut broken = Vec::new();
        let printed = self.printed_copies();
        let parts = self.parts();
        for (hash, name) in &self.names {
            let own: Vec<&PartRow> = parts.iter().filter(|part| part.file.content_hash == *hash).collect();
            let (found, wanted) = (printed.get(hash).copied().unwrap_or_default(), self.dropped[name].0);
            if found != wanted || own.len() != 1 {
                let what = if found > wanted { "DOUBLED" } else { "LOST" };
                let own: Vec<String> =
                    own.iter().map(|part| format!("part {} {} in {}", part.id, part.state, part.machine)).collect();
                broken.push(format!("{what}: {name}: {found} copies are printed of {wanted}, as {own:?}"));
            }
        }
        let given_up = parts.iter().filter(|part| is_given_up(part));
        broken.extend(given_up.map(|part| format!("LOST: part {} ({}): {}", part.id, part.name, part.refused.reason)));
        broken
    }
}
