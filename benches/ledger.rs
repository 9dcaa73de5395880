//! The ledger on its two databases, side by side: claims, events and status with very many waiting parts.
//!
//! `cargo bench --bench ledger` measures SQLite and, where its server program is installed, PostgreSQL in a private
//! cluster that waits for the disk at each commit, as SQLite does.
#![allow(clippy::print_stdout)] // a bench prints its measurements

use ledger_fixtures::postgres_cluster;

use std::time::{Duration, Instant};

use anyhow::Result;
use clap::Parser;
use ledger::{EventKind, Ledger, LedgerAddress, NewPartRow, NewTerms, RequiredTilts};
use nester::OrientationRule;
use sqlx::Connection;

/// Parts that are recorded in one change while the ledger is filled.
const FILL_CHUNK: u64 = 500;
const MACHINE: &str = "mjf-5200";

/// Measures the ledger with many waiting parts.
#[derive(Debug, Parser)]
struct LedgerBench {
    /// Parts that wait
    #[arg(long, default_value_t = 100_000)]
    parts: u64,
    /// Operations of each kind that are timed
    #[arg(long, default_value_t = 500)]
    operations: u64,
    /// Passed by `cargo bench`
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() -> Result<()> {
    let args = LedgerBench::parse();
    if !args.bench {
        println!("ledger: measures with `cargo bench --bench ledger`");
        return Ok(());
    }
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_all().build()?;
    println!("{} waiting parts; median (95 % of all within) of {} operations, ms\n", args.parts, args.operations);
    println!("| database | filled in, s | claim | event | waiting parts | status |");
    println!("|---|---:|---:|---:|---:|---:|");
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("nestd.db").display().to_string();
    runtime.block_on(measure("SQLite", &file, &args))?;
    if postgres_cluster::find_programs().is_some() {
        let server = postgres_cluster::PostgresCluster::start_with(true);
        let url = server.url(&runtime.block_on(server.make_database(None)));
        runtime.block_on(measure("PostgreSQL", &url, &args))?;
    }
    Ok(())
}

async fn measure(database: &str, place: &str, args: &LedgerBench) -> Result<()> {
    let ledger = Ledger::open(LedgerAddress::parse(place, None)).await?;
    let began = Instant::now();
    for first in (0..args.parts).step_by(FILL_CHUNK as usize) {
        let parts: Vec<NewPartRow> = (first..args.parts.min(first + FILL_CHUNK)).map(part).collect();
        ledger.record_drops(&parts.iter().map(|part| (part, false)).collect::<Vec<_>>()).await?;
    }
    make_all_wait(place).await?;
    let filled = began.elapsed();
    let mut times: [Vec<Duration>; 4] = Default::default();
    for number in 0..args.operations {
        let new = part(args.parts + number);
        times[0].push(time(async || ledger.record_claim(&new).await.map(drop)).await?);
        let event = async || ledger.write_event(EventKind::Paused, MACHINE, None, None, "").await.map(drop);
        times[1].push(time(event).await?);
    }
    // These look at all waiting parts.
    for _ in 0..args.operations.div_ceil(25) {
        times[2].push(time(async || ledger.waiting_copies(MACHINE).await.map(drop)).await?);
        times[3].push(time(async || ledger.machine_statuses().await.map(drop)).await?);
    }
    let cells: Vec<String> = times.iter_mut().map(|times| cell(times)).collect();
    println!("| {database} | {:.1} | {} |", filled.as_secs_f64(), cells.join(" | "));
    ledger.close().await;
    Ok(())
}

async fn time(work: impl AsyncFnOnce() -> Result<(), ledger::LedgerError>) -> Result<Duration> {
    let began = Instant::now();
    work().await?;
    Ok(began.elapsed())
}

fn cell(times: &mut [Duration]) -> String {
    times.sort_unstable();
    let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize].as_secs_f64() * 1e3;
    format!("{:.2} ({:.2})", at(0.5), at(0.95))
}

fn part(number: u64) -> NewPartRow {
    NewPartRow {
        claim: format!("claim-{number:08}"),
        machine: MACHINE.to_owned(),
        name: format!("part-{number}.stl"),
        content_hash: format!("{number:064x}"),
        bytes: 684,
        copies: 2,
        terms: NewTerms {
            order_name: format!("order-{}", number / 12),
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

/// Lets all claimed parts wait, as if they had been read. `place` is a file or the address of a database.
async fn make_all_wait(place: &str) -> Result<()> {
    let wait = "UPDATE part SET state = 'waiting', triangles = 12, volume_mm3 = 1000, size_x_mm = 10, size_y_mm = 10, size_z_mm = 10";
    if place.starts_with("postgres://") {
        let mut db = sqlx::PgConnection::connect(place).await?;
        sqlx::raw_sql(wait).execute(&mut db).await?;
        sqlx::raw_sql("ANALYZE").execute(&mut db).await?;
        return Ok(db.close().await?);
    }
    let mut db = sqlx::SqliteConnection::connect(&format!("sqlite:{place}")).await?;
    sqlx::raw_sql(wait).execute(&mut db).await?;
    Ok(db.close().await?)
}
