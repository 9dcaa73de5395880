//! A ledger that cannot be changed when a search ends, as on a full disk.

use super::{
    HandDrivenFarm, PROFILE, QUICK, block,
    night::{drop_mixed, go_on_with_round, lowering, rest},
};
use crate::ledger::{NightState, PartState};

/// A ledger in which certain changes fail until they are allowed again.
struct RefusedChanges(sqlx::SqlitePool);

impl RefusedChanges {
    fn of(farm: &HandDrivenFarm, change: &str) -> Self {
        let pool = farm.ask(async |ledger| {
            let file = ledger.file().unwrap().display().to_string();
            let pool = sqlx::SqlitePool::connect(&format!("sqlite://{file}")).await.unwrap();
            let trigger = format!("CREATE TRIGGER refused BEFORE {change} BEGIN SELECT RAISE(ABORT, 'refused'); END");
            sqlx::query(sqlx::AssertSqlSafe(trigger)).execute(&pool).await.unwrap();
            pool
        });
        Self(pool)
    }

    fn allow(self, farm: &HandDrivenFarm) {
        farm.ask(async |_| {
            sqlx::query("DROP TRIGGER refused").execute(&self.0).await.unwrap();
            self.0.close().await;
        });
    }
}

#[test]
fn a_search_whose_end_the_ledger_refuses_goes_on_later() {
    let mut farm = HandDrivenFarm::open(&lowering(60.0));
    drop_mixed(&mut farm, 6);
    rest(&mut farm);
    for end in ["UPDATE OF layout, cpu_secs ON build", "INSERT ON night_search WHEN NEW.starts = 0"] {
        let begun = go_on_with_round(&mut farm, PROFILE, 0);
        let refused = RefusedChanges::of(&farm, end);
        farm.pass_secs(5.0);
        refused.allow(&farm);
        let row = rest(&mut farm);
        assert_eq!((row.state, row.starts), (NightState::StandsStill, 0), "{end}");
        assert!(row.cpu_secs > begun.cpu_secs, "{end}");
    }
}

#[test]
fn an_arrival_whose_layout_the_ledger_refuses_is_searched_again() {
    let mut farm = HandDrivenFarm::open(QUICK);
    farm.drop_part("a_x6.stl", &block(50.0, 22.0, 13.0));
    farm.pass_until("the first stand in the open build", |farm| farm.open_copies().len() == 6);
    let kept =
        |farm: &HandDrivenFarm| farm.ask(async |ledger| ledger.open_build(PROFILE).await.unwrap().measures.copies);
    for (change, copies) in [("UPDATE OF layout ON build", 7), ("UPDATE OF searches ON build WHEN NEW.searches = 0", 8)]
    {
        let refused = RefusedChanges::of(&farm, change);
        farm.drop_part(&format!("late{copies}.stl"), &block(20.0, 15.0, 8.0));
        farm.wait_for_parts(PartState::Waiting, copies - 5);
        farm.pass_secs(3.0);
        assert_eq!(kept(&farm), Some(copies as u32 - 1));
        refused.allow(&farm);
        farm.pass_until("the arrival is in the kept layout", |farm| kept(farm) == Some(copies as u32));
    }
}
