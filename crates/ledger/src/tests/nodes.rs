//! Heartbeats of the nodes.

use super::*;

#[tokio::test]
async fn a_daemon_that_does_not_beat_any_more_is_not_alive() {
    let ledger = fresh().await;
    assert_eq!(ledger.find_node("host").await.unwrap(), None);
    let heartbeat = heartbeat();
    ledger.write_heartbeat(&heartbeat).await.unwrap();
    ledger.write_heartbeat(&NodeHeartbeat { status: "nesting build 3".into(), ..heartbeat.clone() }).await.unwrap();
    let row = ledger.find_node("host").await.unwrap().unwrap();
    assert_eq!((row.pid, row.status.as_str(), row.alive), (4711, "nesting build 3", true));
    let later = ledger.ledger.clone().with_clock(|| Timestamp::now() + jiff::SignedDuration::from_secs(16));
    assert!(!later.find_node("host").await.unwrap().unwrap().alive);
    // On the same server, the process is checked. 2^22 is the highest process id of Linux.
    let here = rustix::system::uname().nodename().to_string_lossy().into_owned();
    for (pid, alive) in [(std::process::id(), true), ((1 << 22) + 1, false)] {
        ledger.write_heartbeat(&NodeHeartbeat { pid, host: here.clone(), ..heartbeat.clone() }).await.unwrap();
        assert_eq!(ledger.find_node("host").await.unwrap().unwrap().alive, alive);
    }
    ledger.record_shutdown("host").await.unwrap();
    assert!(ledger.find_node("host").await.unwrap().is_none_or(|row| !row.alive));
}
