//! Test fixtures for the ledger and the modules above it: ledgers in separate folders, parts, builds.

use jiff::Timestamp;
use nester::OrientationRule;
use tempfile::TempDir;

use ledger::*;

use super::postgres_cluster;

/// A ledger in its own folder, with a clock that stays at a fixed time until a test changes it.
pub struct TestLedger {
    _folder: TempDir,
    pub ledger: Ledger,
}

impl std::ops::Deref for TestLedger {
    type Target = Ledger;

    fn deref(&self) -> &Ledger {
        &self.ledger
    }
}

pub async fn fresh() -> TestLedger {
    if std::env::var_os("NESTD_TEST_POSTGRES").is_some() {
        let ledger = fresh_on_server().await;
        return TestLedger { _folder: tempfile::tempdir().unwrap(), ledger };
    }
    fresh_file().await
}

/// An empty ledger on the server of this test program.
pub async fn fresh_on_server() -> Ledger {
    Ledger::open(&fresh_address().await).await.unwrap()
}

/// The address of an empty ledger on the server of this test program.
pub async fn fresh_address() -> LedgerAddress {
    static TEMPLATE: tokio::sync::Mutex<Option<String>> = tokio::sync::Mutex::const_new(None);
    let server = postgres_cluster::shared();
    let mut template = TEMPLATE.lock().await;
    if template.is_none() {
        let name = server.make_database(None).await;
        Ledger::open(LedgerAddress::parse(&server.url(&name), None)).await.unwrap().close().await;
        *template = Some(name);
    }
    LedgerAddress::parse(&server.url(&server.make_database(template.as_deref()).await), None)
}

/// One in SQLite, whatever database the tests run on.
pub async fn fresh_file() -> TestLedger {
    let folder = tempfile::tempdir().unwrap();
    let ledger = Ledger::open(&folder.path().join("nestd.db")).await.unwrap();
    TestLedger { _folder: folder, ledger }
}

/// A heartbeat of the one node of a farm, without machines.
pub fn heartbeat() -> NodeHeartbeat {
    NodeHeartbeat {
        name: "host".to_owned(),
        address: String::new(),
        pid: 4711,
        host: "farm".to_owned(),
        version: "0.1.0".to_owned(),
        started_at: Timestamp::now(),
        status: "idle".to_owned(),
        alerts: "[]".to_owned(),
        machines: Vec::new(),
        configured: Vec::new(),
    }
}

pub fn at(time: &str) -> Timestamp {
    time.parse().unwrap()
}

pub fn new_part(claim: &str, copies: u32) -> NewPartRow {
    NewPartRow {
        claim: claim.to_owned(),
        machine: "paper-200".to_owned(),
        name: format!("{claim}.stl"),
        content_hash: blake3::hash(claim.as_bytes()).to_hex().to_string(),
        bytes: 684,
        copies,
        terms: NewTerms {
            order_name: String::new(),
            customer: String::new(),
            email: String::new(),
            material: String::new(),
            finish: String::new(),
            priority: 50,
            due_at: None,
            due_text: String::new(),
            orientation: OrientationRule::Free,
            tilts: RequiredTilts::default(),
            clearance_mm: None,
            unit: None,
            read_unit: None,
            note: String::new(),
            mend_allowed_by: String::new(),
        },
        warnings: Vec::new(),
        ticket: None,
        dropped: Default::default(),
    }
}

/// A claim of which something else is asked.
pub fn asked(mut part: NewPartRow, change: impl FnOnce(&mut NewTerms)) -> NewPartRow {
    change(&mut part.terms);
    part
}

pub fn solid(object_index: u32, copies: u32) -> SolidFacts {
    SolidFacts {
        read_unit: build_file::LengthUnit::Millimeter,
        request: None,
        mended: None,
        object_index,
        object_name: String::new(),
        copies,
        file_copies: 1,
        triangles: 12,
        volume_mm3: 1000.0,
        size_mm: [10.0, 20.0, 30.0],
        question: String::new(),
        copy_of: String::new(),
        warnings: Vec::new(),
    }
}

/// A waiting part with this number of copies.
pub async fn waiting(ledger: &Ledger, claim: &str, copies: u32) -> PartId {
    let part = ledger.record_claim(&new_part(claim, copies)).await.unwrap();
    ledger.accept_solids(part.id, &[solid(0, copies)]).await.unwrap();
    part.id
}

pub fn verified(build: BuildId, copies: u32) -> Verified {
    Verified {
        file: ProvedFile {
            file_name: format!("20261120T044900Z_paper-200_{build:0>6}.build.3mf"),
            queue_id: "queue".to_owned(),
            file_hash: "0".repeat(64),
            file_bytes: 4321,
            sidecars: vec![("x.png".to_owned(), "1".repeat(64))],
        },
        measures: ProvedMeasures {
            height_mm: 87.5,
            density: 0.21,
            lower_bound_mm: 40.0,
            layers: 875,
            part_volume_mm3: 1000.0 * f64::from(copies),
            copies,
            clearance_mm: 3.0,
            clearance_proved_mm: Some(3.02),
        },
        search: FinalSearch {
            cpu_secs: 10.5,
            wall_secs: 5.25,
            evaluations: 12_345,
            seed: 7,
            method: "nestd".to_owned(),
            version: "0.1.0".to_owned(),
            curve: vec![(0.1, 99.5), (2.5, 87.5)],
        },
        profile_snapshot: "{}".to_owned(),
    }
}

/// How far the search for an open build that waits has come, after 64 CPU seconds.
pub fn night_search(state: NightState) -> NightSearchRow {
    NightSearchRow {
        problem: "ab".repeat(32),
        state,
        round: 2,
        round_cpu_secs: 3.5,
        round_height_mm: 31.0,
        cpu_secs: 63.5,
        first_height_mm: 32.5,
        starts: 1,
        pool: "[[]]".to_owned(),
    }
}

pub fn placed(copies: &[(PartId, u32)]) -> Vec<ProvedPlacement> {
    let pose = |(at, &(part, copy)): (usize, &(PartId, u32))| ProvedPlacement {
        part,
        copy,
        rotation: [0.0, 0.0, 0.0, 1.0],
        translation_mm: [f64::from(copy), 2.0, 3.0],
        removal: Some(RemovalStep { position: at as u32 + 1, direction: [0.0, 0.0, 1.0] }),
    };
    copies.iter().enumerate().map(pose).collect()
}

/// A nesting build with these copies.
pub async fn nesting(ledger: &Ledger, copies: &[(PartId, u32)]) -> BuildId {
    let build = ledger.open_build("paper-200").await.unwrap().id;
    ledger.begin_nesting(build, "flush", copies).await.unwrap();
    build
}

/// A build in the queue with these copies.
pub async fn published(ledger: &Ledger, copies: &[(PartId, u32)]) -> BuildId {
    let build = nesting(ledger, copies).await;
    ledger.verify_build(build, &verified(build, copies.len() as u32), &placed(copies)).await.unwrap();
    ledger.publish_build(build).await.unwrap();
    build
}

pub async fn part_state(ledger: &Ledger, id: PartId) -> PartState {
    ledger.find_part(id).await.unwrap().unwrap().state
}

pub async fn build_state(ledger: &Ledger, id: BuildId) -> BuildState {
    ledger.find_build(id).await.unwrap().unwrap().state
}
