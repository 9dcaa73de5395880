//! The dashboard in a real Chromium, on a farm that the real daemon serves. Needs `NESTD_BROWSER=<chromium>`, node
//! and npm, which fetches playwright-core and axe-core.

use std::{
    fs,
    net::TcpListener,
    path::{Path, PathBuf},
    process::Command,
    sync::LazyLock,
};

use ledger::{PartRow, PartState};
use ledger_fixtures::postgres_cluster::PostgresCluster;

use crate::{
    quiet,
    support::{self, TestFarm, balancer::balance, stl, wait_until_or},
};

pub const MACHINE: &str = "mjf-5200";
const PROFILE: &str = "volume_mm = [200, 160, 220]\nclearance_mm = 3.0\nlayer_mm = 0.08\nsettle_secs = 0.3\nunfinished_secs = 2\n\
                       final_secs = 4\narrival_secs = 1\n";
/// Names that would do harm if they were not treated as text.
const NASTY: [&str; 3] =
    ["<img src=x onerror=alert(1)>.stl", "<script>alert(1)<script>.stl", "=HYPERLINK(\"http:x\").stl"];

pub fn browser() -> PathBuf {
    std::env::var_os("NESTD_BROWSER").unwrap().into()
}

/// Names as people give them, of 60 letters and more.
const LONG: (&str, &str) = (
    "Maschinenbau_Friedrich_Oberhausen_und_Soehne_GmbH_Auftrag_4711",
    "replacement_gearbox_housing_left_hand_variant_rev_C_2026-11.stl",
);

/// A farm with its own machine, besides the machine of the other tests.
pub struct BrowserDashboard {
    pub farm: TestFarm,
    pub base: String,
    /// Further nodes of the farm, and the server of its ledger.
    _others: Option<(Vec<TestFarm>, PostgresCluster)>,
}

/// How many nodes serve a farm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Nodes {
    One,
    /// Three, behind a load balancer that leads each connection to the next.
    Three,
}

impl BrowserDashboard {
    pub fn start() -> Self {
        Self::start_on(Nodes::One)
    }

    pub fn start_on(nodes: Nodes) -> Self {
        let farm = TestFarm::new(support::QUICK);
        farm.write_profile(MACHINE, PROFILE);
        Self::serve_on(nodes, farm)
    }

    /// Serves a farm and its pages.
    pub fn serve(farm: TestFarm) -> Self {
        Self::serve_on(Nodes::One, farm)
    }

    pub fn serve_on(nodes: Nodes, mut farm: TestFarm) -> Self {
        if nodes == Nodes::One {
            let base = start_serving(&mut farm, "");
            return Self { farm, base, _others: None };
        }
        let server = PostgresCluster::start();
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        let ledger = server.url(&runtime.block_on(server.make_database(None)));
        let start = |farm: &mut TestFarm, name: &str| {
            let node = format!("[folders]\nledger = {ledger:?}\n[node]\nname = {name:?}\naddress = \"ADDRESS\"\n");
            start_serving(farm, &node)
        };
        let mut bases = vec![start(&mut farm, "print1")];
        let others = ["print2", "print3"].map(|name| {
            let mut other = TestFarm::new(support::QUICK);
            fs::remove_file(other.profile(support::MACHINE)).unwrap();
            bases.push(start(&mut other, name));
            other
        });
        let dashboard = Self { farm, base: balance(&bases), _others: Some((others.into(), server)) };
        let knows = |base: &String| {
            let farm = Command::new("curl").args(["-s", &format!("{base}/api/v1/farm")]).output().unwrap();
            String::from_utf8_lossy(&farm.stdout).contains("\"available\":true")
        };
        wait_until_or("all nodes know the machines", 60.0, || dashboard.farm.log(), || bases.iter().all(knows));
        dashboard
    }

    fn folder(&self, kind: &str) -> PathBuf {
        self.farm.root().join(kind).join(MACHINE)
    }

    /// Drops a file into the machine's hot folder, in the folder of its order if `order` is not empty.
    pub fn drop(&self, order: &str, name: &str, bytes: &[u8]) {
        let outside = self.farm.root().join("sending");
        fs::write(&outside, bytes).unwrap();
        let folder = self.folder("inbox").join(order);
        fs::create_dir_all(&folder).unwrap();
        fs::rename(outside, folder.join(name)).unwrap();
    }

    fn parts(&self, state: PartState) -> Vec<PartRow> {
        self.farm.parts(state)
    }

    pub fn wait_for(&self, state: PartState, count: usize) -> Vec<PartRow> {
        wait_until_or(
            &format!("{count} parts are {state}"),
            60.0,
            || self.farm.log(),
            || self.parts(state).len() == count,
        );
        self.parts(state)
    }

    fn published(&self) -> usize {
        let files = fs::read_dir(self.folder("queue")).unwrap().map(|entry| entry.unwrap().file_name());
        files.filter(|name| name.to_string_lossy().ends_with(".build.3mf")).count()
    }

    /// Publishes the waiting parts.
    pub fn flush(&self) {
        let before = self.published();
        self.farm.nestd(&["flush", MACHINE]);
        wait_until_or("the build is published", 90.0, || self.farm.log(), || self.published() > before);
        wait_until_or("the ledger has it", 30.0, || self.farm.log(), || self.parts(PartState::Batched).is_empty());
    }

    /// The printer takes the file of a build out of its queue, so that its copies may be told bad.
    pub fn printer_takes(&self, build: &str) {
        let name = format!("_{:06}.build.3mf", build.parse::<i64>().unwrap());
        let mut files = fs::read_dir(self.folder("queue")).unwrap().map(|entry| entry.unwrap().path());
        let file = files.find(|path| path.to_string_lossy().ends_with(&name)).expect("its file lies there");
        fs::remove_file(file).unwrap();
    }

    /// Drops some copies of all sample parts except the largest, as one order per customer.
    pub fn drop_samples(&self, skip: usize, customers: &[&str]) -> usize {
        let samples: Vec<_> =
            sample_parts::all_samples().into_iter().filter(|sample| sample.name != "rail").skip(skip).collect();
        for (at, sample) in samples.iter().enumerate() {
            let name = format!("{}_x{}.stl", sample.name, 1 + at % 4);
            self.drop(customers[at % customers.len()], &name, &stl(&sample.mesh));
        }
        samples.len()
    }
}

/// Starts a daemon with its pages, and returns where they are. `more` = further settings, in which `ADDRESS` is that place.
fn start_serving(farm: &mut TestFarm, more: &str) -> String {
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let base = format!("http://127.0.0.1:{port}");
    let config = fs::read_to_string(farm.config()).unwrap() + &more.replace("ADDRESS", &base);
    fs::write(farm.config(), format!("{config}[web]\nlisten = \"127.0.0.1:{port}\"\n")).unwrap();
    farm.start();
    let listens = || std::net::TcpStream::connect(("127.0.0.1", port)).is_ok();
    wait_until_or("the dashboard listens", 20.0, || farm.log(), listens);
    base
}

pub fn every_page_is_what_it_should_be_in_a_real_browser() {
    let (chromium, _quiet) = (browser(), quiet::run_alone());
    let dashboard = BrowserDashboard::start();
    let farm = set_up(&dashboard, &chromium);
    let tools = tools();
    let output = Command::new("node").arg("pages.mjs").arg(farm.to_string()).current_dir(&tools).output().unwrap();
    let output_text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    println!("{output_text}");
    assert!(output.status.success(), "{output_text}\n{}", dashboard.farm.log());
}

/// Time limit to open the 3D view of a large build, s; for an optimised nestd on an idle machine.
const OPENS_WITHIN_SECS: f64 = 3.0;

pub fn the_view_of_700_parts_and_four_million_triangles_opens_in_time() {
    let (chromium, _quiet) = (browser(), quiet::run_alone());
    let dashboard = BrowserDashboard::start();
    let large = "volume_mm = [380, 284, 2000]\nsettle_secs = 0.3\nfinal_secs = 0.5\narrival_secs = 0\n";
    dashboard.farm.write_profile(MACHINE, large);
    dashboard.farm.reload();
    let kinds: Vec<_> =
        sample_parts::all_samples().into_iter().filter(|sample| sample.mesh.triangles().len() > 1500).collect();
    let each = 700 / kinds.len();
    for sample in &kinds {
        dashboard.drop("", &format!("{}.stl.toml", sample.name), format!("copies = {each}").as_bytes());
        dashboard.drop("", &format!("{}.stl", sample.name), &stl(&sample.mesh));
    }
    dashboard.wait_for(PartState::Waiting, kinds.len());
    dashboard.flush();
    let copies = each * kinds.len();
    let triangles: usize = kinds.iter().map(|kind| each * kind.mesh.triangles().len()).sum();
    let asked = serde_json::json!({ "chromium": chromium, "base": dashboard.base, "build": 1, "copies": copies });
    let output = Command::new("node").arg("large.mjs").arg(asked.to_string()).current_dir(tools()).output().unwrap();
    let output_text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    println!("{copies} copies, {triangles} triangles: {output_text}");
    assert!(output.status.success(), "{output_text}\n{}", dashboard.farm.log());
    let opened: serde_json::Value = serde_json::from_str(&output_text).unwrap();
    let secs = opened[0]["secs"].as_f64().unwrap();
    assert!(cfg!(debug_assertions) || secs < OPENS_WITHIN_SECS, "it took {secs:.1} s");
}

/// Sets up two published builds (one of them complete), waiting parts in an open build, hostile names and a refused
/// part. Returns the values that the checks need.
fn set_up(dashboard: &BrowserDashboard, chromium: &Path) -> serde_json::Value {
    let read = dashboard.drop_samples(0, &["Acme", "Beta AG", "Müller & Söhne"]);
    dashboard.drop("Acme", NASTY[0], &stl(&sample_parts::cuboid(glam::DVec3::splat(20.0))));
    dashboard.wait_for(PartState::Waiting, read + 1);
    dashboard.flush();
    let built = dashboard.wait_for(PartState::Built, read + 1);
    dashboard.farm.nestd_ok(&["outcome", "1", "complete", "--note", "bed 3"]);
    let second = dashboard.drop_samples(12, &["Gamma"]);
    dashboard.wait_for(PartState::Waiting, second);
    dashboard.flush();
    dashboard.wait_for(PartState::Built, read + 1 + second);
    let third = dashboard.drop_samples(9, &["Delta", "Acme"]);
    for name in &NASTY[1..] {
        dashboard.drop("Delta", name, &stl(&sample_parts::cuboid(glam::DVec3::splat(15.0))));
    }
    dashboard.drop(LONG.0, &format!("{}.toml", LONG.1), b"due = \"2026-01-15\"\n");
    dashboard.drop(LONG.0, LONG.1, &stl(&sample_parts::cuboid(glam::DVec3::new(25.0, 15.0, 11.0))));
    dashboard.wait_for(PartState::Waiting, third + 3);
    dashboard.drop("Delta", "torn.stl", &stl(&sample_parts::cuboid(glam::DVec3::splat(9.0)))[..500]);
    let refused = dashboard.wait_for(PartState::Refused, 1);
    let open = open_build(dashboard);
    let sample = dashboard.farm.root().join("sample.stl");
    fs::write(&sample, stl(&sample_parts::cuboid(glam::DVec3::new(17.0, 12.0, 9.0)))).unwrap();
    let history: serde_json::Value = serde_json::from_str(&dashboard.farm.nestd_ok(&["history", "--json"])).unwrap();
    let copies: u32 = built.iter().map(|part| part.owed.copies).sum();
    serde_json::json!({
        "chromium": chromium, "base": dashboard.base, "machine": MACHINE, "root": dashboard.farm.root(),
        "inbox": dashboard.folder("inbox"), "queue": dashboard.folder("queue"), "sample": sample,
        "build": 1, "second": history[0]["build"], "copies": copies, "open": open, "part": built[0].id, "refused": refused[0].id, "nasty": NASTY[1..],
        "order": built[0].terms.order_name, "history": history,
    })
}

/// The open build, once its layout has a copy.
fn open_build(dashboard: &BrowserDashboard) -> i64 {
    let open = || {
        let status = dashboard.farm.query_ledger(async |ledger| ledger.machine_statuses().await.unwrap());
        let open = status.into_iter().find(|status| status.machine == MACHINE)?.open?;
        (open.copies.unwrap_or(0) > 20).then_some(open.build.0)
    };
    wait_until_or("the open build holds the waiting parts", 60.0, || dashboard.farm.log(), || open().is_some());
    open().unwrap()
}

/// The folder with the checks and their npm packages, made once for all tests.
pub fn tools() -> PathBuf {
    static TOOLS: LazyLock<PathBuf> = LazyLock::new(fetched);
    TOOLS.clone()
}

fn fetched() -> PathBuf {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/browser/scripts");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("browser");
    fs::create_dir_all(&folder).unwrap();
    let is_of_node = |file: &Path| file.extension().is_some_and(|ending| ending == "mjs" || ending == "json");
    for file in fs::read_dir(from).unwrap().map(Result::unwrap).filter(|file| is_of_node(&file.path())) {
        fs::copy(file.path(), folder.join(file.file_name())).unwrap();
    }
    let npm = ["install", "--silent", "--no-audit", "--no-fund", "--no-package-lock", "--ignore-scripts"];
    let status =
        Command::new("npm").args(npm).current_dir(&folder).status().expect("npm is needed for the browser tests");
    assert!(status.success(), "npm install failed");
    folder
}
