//! What goes wrong in a farm of several nodes.

use std::time::{Duration, Instant};

use rand::RngExt;
use rustix::process::Signal;

use super::{NODES, NodesFarm, farm_node::machine_name, server_link::LinkState};
use crate::support::{TestFarm, signal};

/// Parts that are dropped together, so that some are claimed when the node is killed.
const PARTS_AT_ONCE: usize = 8;
/// A machine that left the configuration of one node is taken up by another one within this time.
const MOVES_WITHIN: Duration = Duration::from_secs(20);

/// What goes wrong.
#[derive(Debug, Clone, Copy)]
enum NodeFault {
    Killed,
    /// Stopped for longer than a lease, and continued.
    Slept,
    EndedInOrder,
    /// Killed, and its machines adopted by another node before it comes back.
    Adopted,
    /// Killed while files are claimed, adopted, started again; then the heir is killed while files are claimed, and the machine comes back.
    AdoptedBack,
    /// A machine is taken out of the configuration of the node that serves it while files are claimed, and another one takes it up.
    MovedInOrder,
    /// The connection to the server is slow, says nothing, or breaks, for up to longer than a lease.
    LinkFails,
    /// The node without machines is killed, or stopped for longer than a lease.
    SpareKilled,
    SpareSlept,
    ServerRestarted,
    ServerCrashed,
    /// A standby that lacks the last changes takes the place of the server.
    StandbyPromoted,
    /// The disk of the state folder is full for a while.
    DiskFull,
}

impl NodesFarm {
    /// Lets something go wrong, and waits until it is over.
    pub(super) fn inject_fault(&mut self) {
        use NodeFault::{
            Adopted, AdoptedBack, DiskFull, EndedInOrder, Killed, LinkFails, MovedInOrder, ServerCrashed,
            ServerRestarted, Slept, SpareKilled, SpareSlept, StandbyPromoted,
        };
        let faults = [
            Killed,
            Killed,
            Slept,
            EndedInOrder,
            Adopted,
            AdoptedBack,
            AdoptedBack,
            MovedInOrder,
            MovedInOrder,
            LinkFails,
            LinkFails,
            LinkFails,
            SpareKilled,
            SpareSlept,
            ServerRestarted,
            ServerCrashed,
            StandbyPromoted,
            DiskFull,
        ];
        let fault = faults[self.rng.random_range(0..faults.len())];
        let number = self.rng.random_range(0..NODES);
        self.story.push(format!("{}: {fault:?} {number}", self.operations));
        self.faults += 1;
        let short = Duration::from_millis(self.rng.random_range(0..1_500));
        match fault {
            Killed => {
                self.nodes[number].farm.kill();
                std::thread::sleep(short / 3);
                self.nodes[number].start();
            }
            Slept => {
                signal(self.nodes[number].farm.pid(), Signal::STOP);
                std::thread::sleep(Duration::from_secs(3) + short);
                signal(self.nodes[number].farm.pid(), Signal::CONT);
            }
            EndedInOrder => {
                signal(self.nodes[number].farm.pid(), Signal::TERM);
                std::thread::sleep(short);
                self.nodes[number].farm.kill();
                self.nodes[number].start();
            }
            Adopted => {
                self.have_adopted(number, short);
            }
            AdoptedBack => {
                self.drop_until_claimed(number);
                let heir = self.have_adopted(number, short);
                self.drop_until_claimed(number);
                self.have_adopted(heir, short);
            }
            MovedInOrder => {
                self.drop_until_claimed(number);
                self.move_in_order(number);
            }
            LinkFails => {
                let slow = LinkState::Slow(short / 2);
                let state = [slow, LinkState::Silent, LinkState::Broken][self.rng.random_range(0..3)];
                self.story.push(format!("  {state:?}"));
                self.nodes[number].link.set(state);
                std::thread::sleep(short * 4);
                self.nodes[number].link.set(LinkState::Clear);
            }
            SpareKilled => {
                self.spare.farm.kill();
                std::thread::sleep(short);
                self.spare.start();
            }
            SpareSlept => {
                signal(self.spare.farm.pid(), Signal::STOP);
                std::thread::sleep(Duration::from_secs(3) + short);
                signal(self.spare.farm.pid(), Signal::CONT);
            }
            ServerRestarted => {
                self.server.stop_server();
                self.start_server_after(short);
            }
            ServerCrashed => {
                self.server.crash_server();
                self.start_server_after(short);
            }
            StandbyPromoted => {
                self.server.keep_standby();
                self.wait_for_server();
                for _ in 0..self.rng.random_range(2..16) {
                    self.run_operation();
                }
                std::thread::sleep(short);
                self.server.promote_standby();
                self.wait_for_server();
                // Within a lease each node has renewed it, and has seen what is missing.
                std::thread::sleep(Duration::from_secs(3));
            }
            DiskFull => {
                if let Some(disk) = &self.nodes[number].disk {
                    disk.fill();
                    std::thread::sleep(short * 2);
                    disk.free();
                }
            }
        }
        // A daemon that lost its right ends nothing by itself: the service manager's watchdog or a person starts it again.
        self.start_ended_nodes();
    }

    /// Kills a node, has all machines that it serves adopted by the next one, and starts it again. Returns the number of the heir.
    fn have_adopted(&mut self, number: usize, pause: Duration) -> usize {
        self.nodes[number].farm.kill();
        let heir = (number + 1) % NODES;
        for machine in (0..NODES).map(machine_name) {
            // Refused while the lease lasts; the machine then stays where it is.
            std::thread::sleep(pause);
            let adopt = self.nodes[heir].command(&["adopt", &machine]).output().unwrap();
            self.story.push(format!("  adopt {machine}: {}", adopt.status.success()));
        }
        self.nodes[number].start();
        heir
    }

    /// Drops parts for a machine until some of them are claimed, or for a moment.
    fn drop_until_claimed(&mut self, machine: usize) {
        let claimed = self.nodes[machine].farm.folder("inbox").join(".claimed");
        let is_claim = |entry: std::io::Result<std::fs::DirEntry>| {
            entry.is_ok_and(|entry| !entry.file_name().to_string_lossy().starts_with('.'))
        };
        for _ in 0..PARTS_AT_ONCE.min(self.parts.saturating_sub(self.dropped.len())) {
            self.drop_part_for(machine);
        }
        for _ in 0..100 {
            if std::fs::read_dir(&claimed).is_ok_and(|mut entries| entries.any(is_claim)) {
                return;
            }
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// Takes a machine out of the configuration of the node that serves it, and puts the file back once another one has taken it up.
    fn move_in_order(&mut self, machine: usize) {
        let name = machine_name(machine);
        let node_of = |farm: &TestFarm| {
            farm.query_ledger(async |ledger| ledger.node_of_machine(&name).await.unwrap().unwrap_or_default())
        };
        let before = node_of(&self.nodes[0].farm);
        let Some(serving) = self.nodes.iter().find(|node| node.name == before) else { return };
        let file = serving.farm.root().join(format!("config/profiles/{name}.toml"));
        let text = std::fs::read(&file).unwrap();
        std::fs::remove_file(&file).unwrap();
        serving.farm.reload();
        let began = Instant::now();
        while [before.as_str(), ""].contains(&node_of(&self.nodes[0].farm).as_str()) && began.elapsed() < MOVES_WITHIN {
            std::thread::sleep(Duration::from_millis(200));
        }
        self.story.push(format!("  {name} went from {before} to {}", node_of(&self.nodes[0].farm)));
        std::fs::write(&file, text).unwrap();
        serving.farm.reload();
    }

    /// Starts again what has ended by itself, or has lost its right and does nothing more. Where the ledger has lost changes, a person
    /// has it repaired before.
    pub(super) fn start_ended_nodes(&mut self) {
        for node in self.nodes.iter_mut().chain([&mut self.spare]) {
            let is_behind = node.sees_lost_changes();
            if node.farm.has_ended() || node.is_halted() || is_behind {
                node.farm.kill();
                if is_behind {
                    let repaired = node.command(&["check", "--deep", "--repair"]).output().unwrap();
                    let told = String::from_utf8_lossy(&repaired.stdout).into_owned();
                    let told: Vec<&str> = told.lines().filter(|line| line.contains("repair")).collect();
                    self.story.push(format!("  {} was repaired: {told:?}", node.name));
                }
                node.start();
            }
        }
    }

    fn start_server_after(&self, pause: Duration) {
        std::thread::sleep(pause);
        self.server.start_server();
        self.wait_for_server();
    }

    fn wait_for_server(&self) {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(self.server.connect("postgres"));
    }
}
