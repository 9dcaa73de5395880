//! The link to the database server falls silent: nothing is refused, and nothing comes through. No end of it is told.

use ledger::PartState;
use ledger_fixtures::{
    postgres_cluster::PostgresCluster,
    server_link::{LinkState, ServerLink},
};

use super::test_node::TestNode;
use crate::support::{block, wait_until_or};

#[test]
fn a_node_says_that_its_link_is_silent_and_goes_on_with_new_connections() {
    let server = PostgresCluster::start();
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let database = runtime.block_on(server.make_database(None));
    let link = ServerLink::to_server(server.folder());
    let mut node = TestNode::started(1, &PostgresCluster::url_in(link.folder(), &database));
    let told = || node.farm.log().matches("The server of the ledger cannot be reached").count();
    node.farm.drop_part("part 0.stl", &block(20.0, 20.0, 10.0));
    node.farm.wait_for_parts(PartState::Waiting, 1);
    for (number, state) in [LinkState::Silent, LinkState::Forgotten].into_iter().enumerate() {
        link.set(state);
        node.farm.drop_part(&format!("while it is {state:?}.stl"), &block(20.0, 20.0, 12.0 + number as f64));
        if state == LinkState::Silent {
            // Before its service manager would take it for dead.
            wait_until_or("it is told", 30.0, || node.farm.log(), || told() > 0);
            link.set(LinkState::Clear);
        }
        node.farm.wait_for_parts(PartState::Waiting, number + 2);
    }
    // Its folders may still be compared with the ledger when the answer is due; what is noted is carried out then.
    let told = node.farm.nestd(&["flush", "machine-1"]);
    assert!(told.status.success() || String::from_utf8_lossy(&told.stdout).contains("is noted"), "{told:?}");
    node.farm.wait_for_queued(1);
    crate::support::farm_files::assert_each_copy_once(&node.farm.queued(), 3);
    node.farm.stop();
}
