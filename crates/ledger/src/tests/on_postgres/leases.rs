//! The right to serve a ledger on a server: one daemon has it, and a change of one that has lost it is refused.

use std::{collections::BTreeMap, time::Duration};

use super::*;

fn node(owner: &str, lease: Duration) -> ServingNode {
    ServingNode { right: ServingRight::Node("print1".to_owned()), owner: owner.to_owned(), lease }
}

const LONG: Duration = Duration::from_secs(60);

async fn set(ledger: &Ledger, text: &'static str) {
    let mut change = ledger.begin_change().await.unwrap();
    sql::query(text).execute(change.db()).await.unwrap();
    change.commit().await.unwrap();
}

#[tokio::test]
async fn a_second_daemon_is_refused_and_told_who_the_first_is() {
    let address = fresh_address().await;
    let first = Ledger::open_to_serve(&address, &node("first", LONG)).await.unwrap();
    let refused = Ledger::open_to_serve(&address, &node("second", LONG)).await.unwrap_err();
    assert!(
        matches!(&refused, LedgerError::Server(ServerError::ServedByOther { owner, .. }) if owner == "first"),
        "{refused}"
    );
    assert!(refused.to_string().contains("can start in"), "{refused}");
    let viewer = Ledger::open_existing(&address).await.unwrap();
    assert!(viewer.is_served().await.unwrap());
    first.close().await;
    assert!(!viewer.is_served().await.unwrap());
    let second = Ledger::open_to_serve(&address, &node("second", LONG)).await.unwrap();
    waiting(&second, "a", 1).await;
    second.close().await;
}

#[tokio::test]
async fn a_daemon_takes_its_own_lease_again_at_once() {
    let address = fresh_address().await;
    // It is dropped without being closed, as when its process is killed.
    let killed = Ledger::open_to_serve(&address, &node("same", LONG)).await.unwrap();
    let again = Ledger::open_to_serve(&address, &node("same", LONG)).await.unwrap();
    waiting(&again, "a", 1).await;
    let late = killed.record_claim(&new_part("late", 1)).await.unwrap_err();
    assert!(matches!(late, LedgerError::Server(ServerError::TakenOver)), "{late}");
    assert_eq!(killed.service_state(), ServiceState::TakenOver);
}

#[tokio::test]
async fn a_daemon_whose_lease_has_lapsed_changes_nothing_once_another_has_it() {
    let address = fresh_address().await;
    let slow = Ledger::open_to_serve(&address, &node("slow", LONG)).await.unwrap();
    let viewer = Ledger::open_existing(&address).await.unwrap();
    set(&viewer, "UPDATE lease SET until = clock_timestamp()").await;
    // Nobody else has it: the change is its own.
    waiting(&slow, "before", 1).await;
    let quick = Ledger::open_to_serve(&address, &node("quick", LONG)).await.unwrap();
    let late = slow.write_event(EventKind::Paused, "", None, None, "").await.unwrap_err();
    assert!(matches!(late, LedgerError::Server(ServerError::TakenOver)), "{late}");
    assert!(slow.ensure_served().is_err());
    assert_eq!(quick.service_state(), ServiceState::Held);
    // Giving back what it has lost changes nothing.
    slow.close().await;
    assert!(viewer.is_served().await.unwrap());
}

#[tokio::test]
async fn a_daemon_sees_that_the_database_has_lost_its_last_changes() {
    for lost in [
        "UPDATE lease_change SET changes = changes - 1",
        "DELETE FROM lease_change",
        "UPDATE lease SET epoch = epoch - 1 WHERE epoch > 1",
        "DELETE FROM lease",
    ] {
        let address = fresh_address().await;
        Ledger::open_to_serve(&address, &node("same", LONG)).await.unwrap().close().await;
        let daemon = Ledger::open_to_serve(&address, &node("same", LONG)).await.unwrap();
        waiting(&daemon, "a", 1).await;
        let viewer = Ledger::open_existing(&address).await.unwrap();
        waiting(&viewer, "of nobody", 1).await;
        waiting(&daemon, "b", 1).await;
        set(&viewer, lost).await;
        let refused = daemon.record_claim(&new_part("late", 1)).await.unwrap_err();
        assert!(matches!(refused, LedgerError::Server(ServerError::Behind)), "{lost}: {refused}");
        assert_eq!(daemon.service_state(), ServiceState::Behind, "{lost}");
        let again = daemon.record_claim(&new_part("later", 1)).await.unwrap_err();
        assert!(matches!(again, LedgerError::Server(ServerError::Behind)), "{lost}: {again}");
    }
}

#[tokio::test]
async fn no_node_goes_on_until_each_that_lost_changes_was_repaired() {
    let address = fresh_address().await;
    let right = |name: &str| ServingRight::Node(name.to_owned());
    let open = async |right: ServingRight| {
        let lease = Duration::from_secs(3);
        Ledger::open_to_serve(&address, &ServingNode { owner: format!("{right}"), right, lease }).await
    };
    let nodes = ["print1", "print2", "print3"];
    let mut ledgers = Vec::new();
    for name in nodes {
        let ledger = open(right(name)).await.unwrap();
        ledger.announce_node(&NodeHeartbeat { name: name.to_owned(), ..heartbeat() }).await.unwrap();
        assert!(ledger.claim_machines(name, &[format!("machine of {name}")]).await.unwrap().is_empty());
        ledgers.push(ledger);
    }
    // One of them does not run when it is seen.
    ledgers.pop().unwrap().close().await;
    let viewer = Ledger::open_existing(&address).await.unwrap();
    set(&viewer, "UPDATE lease_change SET changes = changes - 1 WHERE name = 'node print1'").await;
    assert!(ledgers[0].record_claim(&new_part("late", 1)).await.is_err());
    tokio::time::sleep(Duration::from_millis(1500)).await;
    assert_eq!(ledgers[0].service_state(), ServiceState::Behind);
    let nodes = "print1, print3".to_owned();
    assert_eq!(ledgers[1].service_state(), ServiceState::RepairDue { nodes });
    let refused = ledgers[1].record_claim(&new_part("b", 1)).await.unwrap_err();
    assert!(refused.is_disk_failure() && refused.to_string().contains("of print1, print3:"), "{refused}");
    ledgers.remove(0).close().await;
    assert!(matches!(open(right("print1")).await, Err(LedgerError::Server(ServerError::Behind))));
    for name in ["print1", "print3"] {
        let repaired = open(ServingRight::RepairedNode(name.to_owned())).await.unwrap();
        assert!(open(right(name)).await.is_err(), "its daemon does not run meanwhile");
        waiting(&repaired, name, 1).await;
        repaired.record_repair(name).await.unwrap();
        repaired.close().await;
        open(right(name)).await.unwrap().close().await;
    }
    tokio::time::sleep(Duration::from_millis(1500)).await;
    assert_eq!(ledgers[0].service_state(), ServiceState::Held);
    waiting(&ledgers[0], "b", 1).await;
    // A node that is gone for good is due no more once its machines are another's.
    ledgers[0].mark_repair_due("print2").await.unwrap();
    tokio::time::sleep(Duration::from_millis(1500)).await;
    assert_eq!(viewer.find_repair_due().await.unwrap(), ["print1", "print3"]);
    set(&viewer, "UPDATE lease SET until = clock_timestamp() WHERE name <> 'node print2'").await;
    for name in ["print1", "print3"] {
        viewer.adopt_machine(&format!("machine of {name}"), "print2", "ann").await.unwrap().unwrap();
    }
    assert!(viewer.find_repair_due().await.unwrap().is_empty());
}

#[tokio::test]
async fn an_idle_daemon_sees_it_when_it_renews_its_lease() {
    let address = fresh_address().await;
    let daemon = Ledger::open_to_serve(&address, &node("idle", Duration::from_secs(3))).await.unwrap();
    waiting(&daemon, "a", 1).await;
    set(&Ledger::open_existing(&address).await.unwrap(), "UPDATE lease_change SET changes = changes - 1").await;
    tokio::time::sleep(Duration::from_millis(2500)).await;
    assert_eq!(daemon.service_state(), ServiceState::Behind);
}

#[tokio::test]
async fn a_lease_is_renewed_as_long_as_it_is_open() {
    let address = fresh_address().await;
    let lease = Duration::from_secs(3);
    let daemon = Ledger::open_to_serve(&address, &node("daemon", lease)).await.unwrap();
    tokio::time::sleep(lease * 2).await;
    assert_eq!(daemon.service_state(), ServiceState::Held);
    assert!(Ledger::open_to_serve(&address, &node("other", lease)).await.is_err());
    // An operation that failed puts it in doubt until the next renewal, which follows at once.
    daemon.doubt_service("no answer");
    assert_eq!(daemon.service_state(), ServiceState::Unsure { why: "no answer".to_owned() });
    tokio::time::sleep(Duration::from_millis(900)).await;
    assert_eq!(daemon.service_state(), ServiceState::Held);
    daemon.close().await;
}

#[tokio::test]
async fn a_database_without_a_ledger_is_told_from_one_with() {
    let server = crate::postgres_cluster::shared();
    let empty = LedgerAddress::parse(&server.url(&server.make_database(None).await), None);
    assert!(Ledger::is_missing(&empty).await.unwrap());
    assert!(matches!(Ledger::open_existing(&empty).await, Err(LedgerError::Missing { .. })));
    assert!(!Ledger::is_missing(&fresh_address().await).await.unwrap());
    let nowhere = LedgerAddress::parse("postgres://nestd:pass-word@localhost/x?host=/nonexistent", None);
    let error = Ledger::open(&nowhere).await.unwrap_err();
    assert!(matches!(error, LedgerError::Server(ServerError::Unreachable(_))), "{error}");
    assert!(error.is_disk_failure() && !error.to_string().contains("pass-word"), "{error}");
}

#[tokio::test]
async fn what_a_node_says_of_its_store_concerns_its_own_machines() {
    let address = fresh_address().await;
    let open = async |name: &str| {
        let right = ServingRight::Node(name.to_owned());
        Ledger::open_to_serve(&address, &ServingNode { right, owner: name.to_owned(), lease: LONG }).await.unwrap()
    };
    let (first, second) = (open("print1").await, open("print2").await);
    for (ledger, name, machine) in [(&first, "print1", "fuse-1"), (&second, "print2", "mjf-5200")] {
        let heartbeat =
            NodeHeartbeat { name: name.to_owned(), pid: std::process::id(), host: name.to_owned(), ..heartbeat() };
        ledger.announce_node(&heartbeat).await.unwrap();
        assert!(ledger.claim_machines(name, &[machine.to_owned()]).await.unwrap().is_empty());
    }
    let taken = second.claim_machines("print2", &["fuse-1".to_owned()]).await.unwrap();
    assert_eq!(taken, BTreeMap::from([("fuse-1".to_owned(), "print1".to_owned())]));
    // The same file on both.
    let of = |machine: &str| NewPartRow { machine: machine.to_owned(), claim: machine.to_owned(), ..new_part("a", 1) };
    let parts = [first.record_claim(&of("fuse-1")).await.unwrap(), second.record_claim(&of("mjf-5200")).await.unwrap()];
    let hash = of("fuse-1").content_hash;
    let damaged = async || first.damaged_parts().await.unwrap().iter().map(|part| part.id).collect::<Vec<_>>();
    second.mark_damaged(&hash, "it is gone").await.unwrap();
    assert_eq!(damaged().await, [parts[1].id]);
    first.mark_whole(&hash).await.unwrap();
    assert_eq!(damaged().await, [parts[1].id], "the store of the other node has it, not this one");
    second.mark_whole(&hash).await.unwrap();
    assert!(damaged().await.is_empty());
    first.close().await;
    // Nobody takes the machine of a node that is only away, and a person does.
    assert_eq!(second.claim_machines("print2", &["fuse-1".to_owned()]).await.unwrap().len(), 1);
    assert_eq!(second.adopt_machine("fuse-1", "print2", "ann").await.unwrap(), Some("print1".to_owned()));
    assert_eq!(second.node_of_machine("fuse-1").await.unwrap(), Some("print2".to_owned()));
    second.close().await;
}
