//! What nodes ask of their database while nothing happens.

use std::{fs, time::Duration};

use ledger::PartState;
use ledger_fixtures::postgres_cluster::PostgresCluster;

use super::test_node::TestNode;
use crate::support::{QUICK, block};

/// Transactions that a database has ended.
fn transactions(server: &PostgresCluster, database: &str) -> i64 {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let mut admin = server.connect("postgres").await;
        let count = "SELECT xact_commit + xact_rollback FROM pg_stat_database WHERE datname = $1";
        sqlx::query_scalar(count).bind(database).fetch_one(&mut admin).await.unwrap()
    })
}

#[test]
fn a_node_at_rest_with_four_machines_asks_its_database_for_little() {
    const SECS: u64 = 30;
    let server = PostgresCluster::start();
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let database = runtime.block_on(server.make_database(None));
    let url = server.url(&database);
    let mut node = TestNode::new(1, &url);
    for number in 2..=4 {
        node.farm.write_profile(&format!("more-{number}"), QUICK);
    }
    // As it is where nothing is said of it.
    let config = fs::read_to_string(node.farm.config()).unwrap().replace("scan_secs = 0.5\n", "");
    fs::write(node.farm.config(), config).unwrap();
    let command = node.farm.command(&["run"]);
    node.farm.start_as(command);
    node.farm.drop_part("a.stl", &block(20.0, 20.0, 10.0));
    node.farm.wait_for_parts(PartState::Waiting, 1);
    std::thread::sleep(Duration::from_secs(20));
    let before = transactions(&server, &database);
    std::thread::sleep(Duration::from_secs(SECS));
    let asked = transactions(&server, &database) - before;
    assert!(asked < 5 * SECS as i64, "{asked} transactions in {SECS} s\n{}", node.farm.log());
    node.farm.stop();
}
