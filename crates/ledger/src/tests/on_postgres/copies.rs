//! Copies of a ledger between a file and a server.

use glam::{DQuat, DVec3};
use proptest::{
    strategy::{Strategy, ValueTree},
    test_runner::{Config, RngAlgorithm, TestRng, TestRunner},
};
use sqlx::AssertSqlSafe;

use super::{
    same_rows::{compare, relations},
    *,
};
use crate::{
    keep::copy::{TABLES, VIEWS},
    tests::store::random_walks::{RandomWalk, step},
};

/// A ledger with rows in every table that a farm without trouble fills.
async fn fill(ledger: &Ledger) {
    let config = Config { failure_persistence: None, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    let mut walk = RandomWalk::default();
    for _ in 0..250 {
        let step = step().new_tree(&mut runner).unwrap().current();
        let _refused = walk.take(ledger, step).await;
    }
    ledger.pause_machine("paper-200", "a@b", PauseCause::Person).await.unwrap();
    ledger.find_or_add_receiver(ReceiverKind::Webhook).await.unwrap();
    let (old, new) = (waiting(ledger, "old", 1).await, waiting(ledger, "new", 1).await);
    let mut change = ledger.begin_change().await.unwrap();
    let refer = sql::query("UPDATE part SET replaced_by = $1 WHERE id = $2").bind(new).bind(old);
    refer.execute(change.db()).await.unwrap();
    change.commit().await.unwrap();
}

#[tokio::test]
async fn every_table_and_view_is_copied() {
    let file = fresh_file().await;
    let known: Vec<_> = TABLES.iter().map(|table| table.name).chain(VIEWS).collect();
    let relations = relations(&file).await;
    assert_eq!(relations.len(), known.len());
    assert!(relations.iter().all(|relation| known.contains(&relation.as_str())), "{relations:?} {known:?}");
}

#[tokio::test]
async fn a_ledger_goes_to_a_server_and_back_and_is_the_same() {
    let (file, server) = both().await;
    let back = fresh_file().await;
    fill(&file).await;
    let there = file.copy_into_ledger(&server, ExistingRows::Refuse).await.unwrap();
    assert!(there.rows > 150 && there.compared == TABLES.len() + VIEWS.len(), "{there:?}");
    assert_eq!(server.copy_into_ledger(&back, ExistingRows::Refuse).await.unwrap(), there);
    compare(&file, &back, &relations(&file).await, "a copy there and back").await;
    for ledger in [&*file, &server, &*back] {
        assert_eq!(ledger.find_inconsistencies().await.unwrap(), Vec::<String>::new());
    }
    // New rows get the numbers that they would have got.
    let mut next = Vec::new();
    for ledger in [&*file, &server, &*back] {
        next.push((waiting(ledger, "after", 2).await, ledger.open_build("other").await.unwrap().id));
    }
    assert!(next.iter().all(|numbers| *numbers == next[0]), "{next:?}");
}

#[tokio::test]
async fn nothing_is_copied_into_a_ledger_that_has_rows_unless_they_shall_go() {
    let (file, server) = both().await;
    fill(&file).await;
    waiting(&server, "mine", 1).await;
    let refused = file.copy_into_ledger(&server, ExistingRows::Refuse).await.unwrap_err();
    assert!(matches!(refused, CopyError::NotEmpty { .. }), "{refused}");
    assert_eq!(server.parts_in_state(PartState::Waiting).await.unwrap().len(), 1);
    file.copy_into_ledger(&server, ExistingRows::Replace).await.unwrap();
    compare_parts(&file, &server).await;
}

async fn compare_parts(one: &Ledger, other: &Ledger) {
    for state in PartState::ALL {
        assert_eq!(one.parts_in_state(state).await.unwrap(), other.parts_in_state(state).await.unwrap());
    }
}

#[tokio::test]
async fn a_backup_of_a_server_is_a_ledger_in_a_file() {
    let (file, server) = both().await;
    fill(&file).await;
    file.copy_into_ledger(&server, ExistingRows::Refuse).await.unwrap();
    let folder = tempfile::tempdir().unwrap();
    let backup = folder.path().join("backup");
    server.write_backup(&backup).await.unwrap();
    prove_backup(&backup).await.unwrap();
    let names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(names.len(), 2, "the backup and its checksum: {names:?}");
    compare_parts(&file, &Ledger::open_checked(&backup).await.unwrap()).await;
}

#[tokio::test]
async fn a_negative_zero_of_a_pose_ends_no_copy_and_none_is_written() {
    let (_, server) = both().await;
    let copies = [(waiting(&server, "turned", 2).await, 0), (waiting(&server, "back", 1).await, 0)];
    let build = nesting(&server, &copies).await;
    // The poses that turning there and back gives.
    let turns = [DQuat::IDENTITY.conjugate(), DQuat::from_rotation_z(1.25).conjugate()];
    let poses: Vec<ProvedPlacement> = (placed(&copies).into_iter().zip(turns))
        .map(|(placed, turn)| ProvedPlacement {
            rotation: turn.to_array(),
            translation_mm: (turn * DVec3::ZERO).to_array().map(|value| -value),
            removal: Some(RemovalStep { position: 1, direction: (turn * -DVec3::Y).to_array() }),
            ..placed
        })
        .collect();
    assert!(poses.iter().all(|pose| pose.rotation[0].is_sign_negative() && pose.rotation[0] == 0.0), "{poses:?}");
    server.verify_build(build, &verified(build, 2), &poses).await.unwrap();
    let count = async |condition: &str| {
        let text = format!("SELECT count(*) FROM placement WHERE {condition}");
        sql::query_scalar::<i64>(AssertSqlSafe(text)).fetch_one(server.reader().unwrap()).await.unwrap()
    };
    let negative =
        "'-0' IN (CAST(qx AS text), CAST(qy AS text), CAST(qz AS text), CAST(tx_mm AS text), CAST(way_x AS text))";
    assert_eq!((count("qx = 0").await, count(negative).await), (2, 0));
    // As an earlier release has written it.
    let mut change = server.begin_change().await.unwrap();
    sql::query("UPDATE placement SET qx = '-0', tx_mm = '-0', way_x = '-0'").execute(change.db()).await.unwrap();
    change.commit().await.unwrap();
    assert_eq!(count(negative).await, 2);
    let folder = tempfile::tempdir().unwrap();
    server.write_backup(&folder.path().join("backup")).await.unwrap();
    let back = fresh_file().await;
    server.copy_into_ledger(&back, ExistingRows::Refuse).await.unwrap();
}

#[tokio::test]
async fn what_a_ledger_does_not_know_is_found_on_both() {
    let (file, server) = both().await;
    let mut found = Vec::new();
    for ledger in [&*file, &server] {
        waiting(ledger, "known", 1).await;
        let asked = ["known".to_owned(), "it's \"new\"".to_owned(), blake3::hash(b"known").to_hex().to_string()];
        found.push([
            ledger.unknown_claims(&asked).await.unwrap(),
            ledger.unknown_contents(&asked).await.unwrap(),
            ledger.unknown_build_files(&asked).await.unwrap(),
        ]);
    }
    assert_eq!(found[0], found[1]);
    assert_eq!(found[0].each_ref().map(Vec::len), [2, 2, 3]);
}
