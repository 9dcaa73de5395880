//! The search for an open build that waits: it is kept, told with its cost and gain, and gone when the build fires.

use super::*;

async fn open_with_layout(ledger: &Ledger, height_mm: f64) -> BuildId {
    let build = ledger.open_build("paper-200").await.unwrap().id;
    let layout = OpenLayout { layout: "[]".to_owned(), height_mm, density: 0.1, copies: 1, part_volume_mm3: 8.0 };
    ledger.save_layout(build, &layout).await.unwrap();
    build
}

#[tokio::test]
async fn what_a_search_has_reached_is_kept_and_told() {
    let ledger = fresh().await;
    let part = waiting(&ledger, "a", 2).await;
    let build = open_with_layout(&ledger, 30.0).await;
    assert_eq!(ledger.find_night_search(build).await.unwrap(), None);
    let open = async || ledger.machine_statuses().await.unwrap()[0].open.clone().unwrap();
    assert_eq!((open().await.night, open().await.night_gain_mm), (None, None));
    for state in [NightState::GoesOn, NightState::StandsStill, NightState::UsedUp, NightState::GivenUp] {
        ledger.save_night_search(build, &night_search(state)).await.unwrap();
        assert_eq!(ledger.find_night_search(build).await.unwrap(), Some(night_search(state)));
        assert_eq!(open().await.night, Some(state));
    }
    assert_eq!((open().await.night_cpu_secs, open().await.night_gain_mm), (Some(63.5), Some(2.5)));
    open_with_layout(&ledger, 70.0).await;
    assert_eq!(open().await.night_gain_mm, Some(0.0), "it never counts what arrivals cost");
    ledger.begin_nesting(build, "flush", &[(part, 0)]).await.unwrap();
    assert_eq!(ledger.find_night_search(build).await.unwrap(), None);
    assert!(matches!(
        ledger.save_night_search(build, &night_search(NightState::GoesOn)).await,
        Err(LedgerError::WrongState { .. })
    ));
}

#[tokio::test]
async fn a_search_that_is_switched_off_and_one_of_a_removed_machine_are_gone() {
    let ledger = fresh().await;
    let build = open_with_layout(&ledger, 30.0).await;
    ledger.save_night_search(build, &night_search(NightState::GoesOn)).await.unwrap();
    ledger.delete_night_search(build).await.unwrap();
    assert_eq!(ledger.find_night_search(build).await.unwrap(), None);
    ledger.save_night_search(build, &night_search(NightState::GoesOn)).await.unwrap();
    ledger.delete_open_build("paper-200").await.unwrap();
    assert_eq!(ledger.find_night_search(build).await.unwrap(), None);
}
