//! Rows are flat in JSON, although their fields are grouped into structs. Scripts read these keys.

use serde::Serialize;

use crate::{fixtures::*, *};

fn keys(row: &impl Serialize) -> Vec<String> {
    let json = serde_json::to_value(row).unwrap();
    json.as_object().unwrap().keys().cloned().collect()
}

/// Asserts that a row has all known keys and no nested objects. It may have more keys.
fn demand_keys(row: &impl Serialize, known: &str) {
    let keys = keys(row);
    let missing: Vec<&str> = known.split_whitespace().filter(|known| !keys.iter().any(|key| key == known)).collect();
    assert!(missing.is_empty(), "{missing:?} of {keys:?}");
    let json = serde_json::to_value(row).unwrap();
    let nested: Vec<&String> =
        json.as_object().unwrap().iter().filter(|(_, v)| v.is_object()).map(|(key, _)| key).collect();
    assert!(nested.is_empty(), "not flat: {nested:?}");
}

#[tokio::test]
async fn rows_of_builds_parts_placements_and_the_history_have_the_keys_that_scripts_know() {
    let ledger = fresh().await;
    let part = waiting(&ledger, "a", 1).await;
    let build = published(&ledger, &[(part, 0)]).await;
    let build_row = ledger.find_build(build).await.unwrap().unwrap();
    let known = "id machine state reason fired_by attempts searches opened_at nesting_at verified_at publishing_at published_at \
        state_at file_name queue_id file_hash file_bytes height_mm density lower_bound_mm layers part_volume_mm3 copies \
        clearance_mm clearance_proved_mm cpu_secs wall_secs evaluations seed method version profile_snapshot";
    demand_keys(&build_row, known);
    let history = ledger.read_history(&HistoryQuery::default()).await.unwrap();
    let known = "build machine state at published_at height_mm volume_z_mm density lower_bound_mm layers parts copies \
        part_volume_mm3 clearance_mm clearance_proved_mm cpu_secs wall_secs evaluations seed method version fired_by \
        file_name reason note";
    demand_keys(&history[0], known);
    let known = "id claim object_index machine name object_name order_name content_hash bytes state reason warnings copies \
        priority due_at orientation tilts clearance_mm unit note triangles volume_mm3 size_x_mm size_y_mm size_z_mm reads \
        claimed_at state_at damaged_at";
    demand_keys(&ledger.find_part(part).await.unwrap().unwrap(), known);
    let placements = ledger.placements_of_build(build).await.unwrap();
    let known = "part_id copy build_id build_state published_at qx qy qz qw tx_mm ty_mm tz_mm drawn way_x way_y way_z";
    demand_keys(&placements[0], known);
}

#[test]
fn what_is_noted_of_a_claim_is_flat_and_is_read_back() {
    let claim = new_part("a", 3);
    let known = "claim machine name order_name content_hash bytes copies priority due_at orientation tilts clearance_mm unit \
        note warnings ticket";
    demand_keys(&claim, known);
    let text = serde_json::to_string(&claim).unwrap();
    assert_eq!(serde_json::from_str::<NewPartRow>(&text).unwrap(), claim);
    let earlier = text.replace("\"machine\":", "\"profile\":");
    assert!(earlier != text && serde_json::from_str::<NewPartRow>(&earlier).unwrap() == claim);
}
