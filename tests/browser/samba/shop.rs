//! A farm whose hot folder is behind the server, with a record of the files that were sent to it.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::PathBuf,
    process::{Child, Output},
};

use ledger::{PartQuery, PartRow, PartState};

use super::{
    grid::gridded_box,
    proxy::{self, NetworkLine},
    server::{SambaServer, open_to_its_user},
    support::{TestFarm, wait_until_or},
};

/// The profile: `unfinished_secs` is long, so that a stalled copy is not refused; a client sends a cut copy again.
const PROFILE: &str = "volume_mm = [200, 200, 200]\nclearance_mm = 2.0\nsettle_secs = 0.4\nunfinished_secs = 60\nfinal_secs = 0.5\n\
                       arrival_secs = 0.2\nduplicates = \"accept\"\nmax_attempts = 50\n";

pub struct SambaShop {
    pub farm: TestFarm,
    pub server: SambaServer,
    /// Copies that must be printed, by content.
    wanted: BTreeMap<String, u32>,
    /// Contents that a client itself has overwritten, perhaps before they were taken.
    replaced: BTreeSet<String>,
    made: u32,
}

impl SambaShop {
    pub fn open() -> Self {
        let farm = TestFarm::running(PROFILE);
        open_to_its_user(farm.root(), &farm.folder("inbox"));
        let server = SambaServer::start(&farm.folder("inbox"));
        Self { farm, server, wanted: BTreeMap::new(), replaced: BTreeSet::new(), made: 0 }
    }

    /// A new file on the client's side, different from all others, with `squares` squares along an edge.
    pub fn part(&mut self, squares: usize) -> PathBuf {
        self.made += 1;
        let bytes = gridded_box([12.0, 14.0, 10.0 + f64::from(self.made) * 0.05], squares);
        let file = self.farm.root().join(format!("sent-{}", self.made));
        fs::write(&file, bytes).unwrap();
        file
    }

    /// Expects `copies` printed copies of this file's content.
    pub fn expect_copies(&mut self, file: &PathBuf, copies: u32) {
        *self.wanted.entry(hash(file)).or_default() += copies;
    }

    /// Records that the client has overwritten the content of this file.
    pub fn mark_replaced(&mut self, file: &PathBuf) {
        self.replaced.insert(hash(file));
    }

    /// Runs commands over a good connection; they must succeed.
    pub fn run_client(&self, commands: &str) {
        let output = self.server.run_client(commands);
        assert!(
            output.status.success() && !output_text(&output).contains("NT_STATUS"),
            "{commands}: {}",
            output_text(&output)
        );
    }

    /// Sends a new part of 2 kB under this name, and expects one copy.
    pub fn send_part(&mut self, name: &str) {
        let file = self.part(2);
        self.run_client(&format!("put \"{}\" \"{name}\"", file.display()));
        self.expect_copies(&file, 1);
    }

    /// Starts a client that sends over a bad connection.
    pub fn send_over(&self, line: NetworkLine, commands: &str) -> Child {
        let port = proxy::serve(line, self.server.port());
        self.server.client(port, commands).spawn().unwrap()
    }

    /// The parts that were taken, read in one statement: a part that goes on to its next state is counted once.
    pub fn taken_parts(&self) -> Vec<PartRow> {
        let all = PartQuery { name: Some(String::new()), limit: 10_000, ..PartQuery::default() };
        let parts = self.farm.query_ledger(async |ledger| ledger.list_parts(&all).await.unwrap());
        let is_taken = |part: &PartRow| {
            matches!(part.state, PartState::Claimed | PartState::Waiting | PartState::Batched | PartState::Built)
        };
        parts.into_iter().filter(is_taken).collect()
    }

    pub fn taken(&self) -> usize {
        self.taken_parts().len()
    }

    pub fn wait_until_taken(&self, parts: usize) {
        let describe = || format!("{} taken\n{}", self.taken(), self.farm.log());
        wait_until_or(&format!("{parts} parts are taken"), 60.0, describe, || self.taken() >= parts);
    }

    /// Publishes the waiting parts, and compares the sent, the taken and the printed files.
    pub fn finish_and_compare(mut self) {
        let least: u32 = self.wanted.values().sum();
        let printed = || self.printed().values().sum::<u32>();
        let describe = || format!("{} of {least} are printed\n{}", printed(), self.farm.log());
        wait_until_or("everything is printed", 90.0, describe, || {
            if !self.farm.parts(PartState::Waiting).is_empty() {
                self.farm.flush();
            }
            printed() >= least
        });
        assert_eq!(self.farm.parts(PartState::Refused), [], "something was refused");
        let mut printed = self.printed();
        for hash in self.replaced.iter().filter(|hash| !self.wanted.contains_key(*hash)) {
            assert!(printed.remove(hash).unwrap_or(1) == 1, "what the client replaced was printed twice");
        }
        assert_eq!(printed, self.wanted, "by content: printed, and asked for\n{}", self.farm.log());
        self.farm.assert_nothing_lost_or_doubled();
        self.farm.stop();
    }

    /// Copies in all build files, by content.
    fn printed(&self) -> BTreeMap<String, u32> {
        let mut printed = BTreeMap::new();
        for file in self.farm.queued() {
            for placed in build_file::read_build(&file, &build_file::ReadLimits::default()).unwrap() {
                *printed.entry(placed.source_hash.unwrap()).or_default() += 1;
            }
        }
        printed
    }
}

pub fn output_text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

fn hash(file: &PathBuf) -> String {
    blake3::hash(&fs::read(file).unwrap()).to_hex().to_string()
}
