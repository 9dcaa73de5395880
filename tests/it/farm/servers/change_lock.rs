//! A connection that somebody has forgotten in the middle of a change: everybody is told which one it is, and nothing hangs.

use std::{
    process::Output,
    time::{Duration, Instant},
};

use ledger_fixtures::postgres_cluster::PostgresCluster;
use sqlx::Executor;

use super::test_node::TestNode;
use crate::support::wait_until_or;

/// Takes the lock that each change takes, as `ledger/store/postgres/change_lock` does.
const TAKE_CHANGE_LOCK: &str = "SELECT pg_advisory_xact_lock(x'6e6573746400'::bigint)";
/// A command waits for its turn for 20 s.
const ENDS_WITHIN: Duration = Duration::from_secs(45);

fn text_of(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

#[test]
fn what_all_changes_wait_for_is_named_and_every_command_ends() {
    let server = PostgresCluster::start();
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let database = runtime.block_on(server.make_database(None));
    let mut nodes = [1, 2].map(|number| TestNode::new(number, &server.url(&database)));
    nodes[1].configure_machine_of(&nodes[0]);
    nodes.iter_mut().for_each(TestNode::start);
    let mut forgotten = runtime.block_on(server.connect(&database));
    for text in ["SET application_name = 'print9'", "BEGIN", TAKE_CHANGE_LOCK] {
        runtime.block_on(forgotten.execute(text)).unwrap();
    }
    let [first, second] = &nodes;
    for node in &nodes {
        node.says("All changes of the ledger wait for one connection, and so does nestd: print9 (server process");
    }
    for words in [["flush", "machine-2"], ["adopt", "machine-1"]] {
        let began = Instant::now();
        let told = second.command(&words).output().unwrap();
        let text = text_of(&told);
        assert!(!told.status.success() && text.contains("print9") && text.contains("idle in transaction"), "{text}");
        assert!(!text.contains("disk") && began.elapsed() < ENDS_WITHIN, "{words:?}: {:?}: {text}", began.elapsed());
    }
    let told = text_of(&first.command(&["status"]).output().unwrap());
    assert!(told.contains("print9") && !told.contains("free some room"), "{told}");
    runtime.block_on(forgotten.execute("ROLLBACK")).unwrap();
    let is_over = || !text_of(&first.command(&["status"]).output().unwrap()).contains("print9");
    wait_until_or("the alert is over", 60.0, || first.farm.log(), is_over);
    second.farm.flush_machine("machine-2");
    nodes.iter_mut().for_each(|node| node.farm.stop());
}
