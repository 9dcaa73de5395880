//! A node of a farm: the real binary, with folders and a machine of its own, on a private PostgreSQL server.

use ledger_fixtures::postgres_cluster::PostgresCluster;
use std::{fs, net::TcpListener, process::Command};

use crate::support::{QUICK, TestFarm, wait_until_or};

/// The factor by which a lease is shorter than in production.
const HURRY: &str = "5";

/// A node with one machine.
pub struct TestNode {
    pub farm: TestFarm,
    pub name: String,
    /// Where its pages are.
    pub address: String,
}

impl TestNode {
    pub fn new(number: u32, url: &str) -> Self {
        let (name, machine) = (format!("print{number}"), format!("machine-{number}"));
        let farm = TestFarm::with_machine(&machine, QUICK);
        // The port is free again at once, and nobody else looks for one of this number.
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let config = fs::read_to_string(farm.config()).unwrap();
        let more = format!(
            "{config}[folders]\nledger = {url:?}\n[node]\nname = {name:?}\naddress = \"http://127.0.0.1:{port}\"\n\
             [web]\nlisten = \"127.0.0.1:{port}\"\n"
        );
        fs::write(farm.config(), more).unwrap();
        Self { farm, name, address: format!("http://127.0.0.1:{port}") }
    }

    pub fn started(number: u32, url: &str) -> Self {
        let mut node = Self::new(number, url);
        node.start();
        node
    }

    pub fn start(&mut self) {
        let command = self.command(&["run"]);
        let before = self.farm.log().matches("The farm is open").count();
        self.farm.start_as(command);
        let log = || self.farm.log();
        wait_until_or("the farm is open", 30.0, log, || log().matches("The farm is open").count() > before);
    }

    /// A command as if on a server of its own: a process that is stopped there holds no lock here.
    pub fn command(&self, args: &[&str]) -> Command {
        let mut command = self.farm.command(args);
        command.env("NESTD_TEST_HURRY", HURRY).env("NESTD_TEST_HOST", &self.name);
        command
    }

    /// Adopts a machine as soon as its node has ended.
    pub fn adopt(&self, machine: &str) {
        let adopts = || self.command(&["adopt", machine]).output().unwrap();
        let says = || format!("{:?}\n{}", adopts(), self.farm.log());
        wait_until_or("the machine is adopted", 60.0, says, || adopts().status.success());
    }

    /// Writes the file of a machine on the folders of another node's machine.
    pub fn configure_machine_of(&self, other: &TestNode) {
        let machine = other.machine();
        let folders = ["inbox", "queue", "error", "archive"]
            .map(|kind| format!("{kind} = {:?}\n", other.farm.folder(kind)))
            .concat();
        self.farm.write_profile(&machine, &format!("{QUICK}[folders]\n{folders}"));
    }

    /// Waits until the node has copies of so many files of another one.
    pub fn wait_for_copies(&self, count: usize) {
        let copies = intake::ContentStore::from_dir(self.farm.root().join("state/copies"));
        let has_copies = || copies.list_contents().is_ok_and(|kept| kept.len() == count);
        wait_until_or("files are copied", 60.0, || self.farm.log(), has_copies);
    }

    pub fn machine(&self) -> String {
        self.name.replace("print", "machine-")
    }

    pub fn says(&self, words: &str) {
        wait_until_or(
            &format!("{} says {words:?}", self.name),
            60.0,
            || self.farm.log(),
            || self.farm.log().contains(words),
        );
    }
}

/// The address of an empty database.
pub fn new_database(server: &PostgresCluster) -> String {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    server.url(&runtime.block_on(server.make_database(None)))
}
