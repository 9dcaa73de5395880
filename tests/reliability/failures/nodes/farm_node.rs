//! A node of the farm, as a process on folders of its own.

use ledger_fixtures::postgres_cluster::PostgresCluster;
use std::{fs, net::TcpListener, path::Path, process::Command};

use super::server_link::ServerLink;
use crate::support::{TestFarm, small_disk::SmallDisk};

/// The file of a machine.
pub const PROFILE: &str = "volume_mm = [60, 60, 60]\nclearance_mm = 1.0\nsettle_secs = 0.05\nunfinished_secs = 0.5\n\
    final_secs = 0.05\narrival_secs = 0.05\nduplicates = \"accept\"\nmax_attempts = 100\n[trigger]\ncopies = 12\n";
const FARM: &str = "scan_secs = 0.3\ncache_bytes = 0\nthreads = 1\n[log]\nfilter = \"info\"\n";
/// The factor by which a lease is shorter than in production.
const HURRY: &str = "10";

/// Size of the file system of a state folder.
const STATE_BYTES: u64 = 64 << 20;
/// Debian's library that gives a process another time of day.
const FAKETIME: &str = "/usr/lib/x86_64-linux-gnu/faketime/libfaketime.so.1";

/// A node, with its machine while nobody adopts that.
pub struct FarmNode {
    pub farm: TestFarm,
    pub name: String,
    /// Its connection to the server.
    pub link: ServerLink,
    /// The file system of its state folder, where one may be mounted.
    pub disk: Option<SmallDisk>,
    /// By how much its wall clock is wrong.
    clock_error: Option<&'static str>,
}

impl FarmNode {
    pub fn command(&self, args: &[&str]) -> Command {
        let mut command = self.farm.command(args);
        command.env("NESTD_TEST_HURRY", HURRY).env("NESTD_TEST_HOST", &self.name);
        if let (Some(error), true) = (self.clock_error, can_set_clocks()) {
            command.env("LD_PRELOAD", FAKETIME).env("FAKETIME", error).env("FAKETIME_DONT_FAKE_MONOTONIC", "1");
        }
        command
    }

    pub fn start(&mut self) {
        self.farm.start_as(self.command(&["run"]));
    }

    /// Whether its daemon has seen that the ledger lacks changes, and does nothing more or does not start.
    pub fn sees_lost_changes(&self) -> bool {
        let log = self.farm.log();
        let since = log.rfind("The farm is open").unwrap_or(0);
        ["has lost the last changes of this nestd", "older than the folders"]
            .iter()
            .any(|words| log[since..].contains(words))
    }

    /// Whether its daemon has lost its right since it was started, and does nothing more.
    pub fn is_halted(&self) -> bool {
        let log = self.farm.log();
        let since = log.rfind("The farm is open").unwrap_or(0);
        log[since..].contains("Another nestd is this node now")
    }
}

/// Whether the clocks of single processes can be set here.
pub fn can_set_clocks() -> bool {
    Path::new(FAKETIME).exists()
}

/// The machine of a node.
pub fn machine_name(number: usize) -> String {
    format!("machine-{number}")
}

/// A node with its own machine.
pub fn configured_node(number: usize, server: &PostgresCluster, database: &str) -> FarmNode {
    let farm = TestFarm::with_machine(&machine_name(number), PROFILE);
    let clock_error = if number == 2 { Some("+7h") } else { None };
    FarmNode { clock_error, ..configure_node(farm, format!("node-{number}"), server, database) }
}

/// A node without machines.
pub fn configured_spare(server: &PostgresCluster, database: &str) -> FarmNode {
    let farm = TestFarm::with_machine("none", "");
    fs::remove_file(farm.root().join("config/profiles/none.toml")).unwrap();
    // The daemon makes none where it has no machine.
    fs::create_dir_all(farm.folder("inbox")).unwrap();
    FarmNode { clock_error: Some("-5h"), ..configure_node(farm, "spare".to_owned(), server, database) }
}

fn configure_node(farm: TestFarm, name: String, server: &PostgresCluster, database: &str) -> FarmNode {
    let link = ServerLink::to_server(server.folder());
    let url = PostgresCluster::url_in(link.folder(), database);
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let config = format!(
        "{FARM}[folders]\nledger = {url:?}\n[node]\nname = {name:?}\naddress = \"http://127.0.0.1:{port}\"\n\
         [web]\nlisten = \"127.0.0.1:{port}\"\n"
    );
    fs::write(farm.config(), config).unwrap();
    let disk = SmallDisk::missing().is_none().then(|| SmallDisk::new(&farm.root().join("state"), STATE_BYTES));
    FarmNode { farm, name, link, disk, clock_error: None }
}
