//! The plan of a machine says beforehand what the farm then does, from the ledger alone.

use super::{
    super::{MachinePlan, PlanStage, RiskCause, plan_machine},
    HandDrivenFarm, PROFILE, block,
    hand_driven_farm::farm_files::list_build_files,
};
use crate::ledger::{CommandKind, PartState};

/// Searches are quick, nothing turns, and a build of 20 mm is printed in two hours.
const MACHINE: &str = "volume_mm = [120, 120, 120]\nclearance_mm = 2.0\nsettle_secs = 0.3\nunfinished_secs = 2\nfinal_secs = 0.2\narrival_secs = 0.1\nimprove_secs = 0\norientation = \"fixed\"\nprint_hours_per_mm = 0.1\n\
    [trigger]\nmax_wait_secs = \"30h\"\ngather_secs = 0\ndue_margin_secs = \"1h\"\n[[printer]]\nname = \"left\"\n[[printer]]\nname = \"right\"\n";

fn plan(farm: &HandDrivenFarm) -> MachinePlan {
    let (profile, now) = (farm.profiles()[PROFILE].clone(), farm.date());
    farm.ask(async |ledger| plan_machine(ledger, &profile, now).await.unwrap())
}

fn due_in(farm: &HandDrivenFarm, hours: i64) -> String {
    farm.date().checked_add(jiff::SignedDuration::from_hours(hours)).unwrap().to_string()
}

#[test]
fn a_plan_says_when_the_open_build_fires_where_it_is_printed_and_what_would_be_late() {
    let mut farm = HandDrivenFarm::open(MACHINE);
    assert!(plan(&farm).builds.is_empty());
    farm.drop_bytes("soon.stl.toml", format!("due = \"{}\"\norder = \"A-1\"\n", due_in(&farm, 1)).as_bytes());
    farm.drop_part("soon.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Built, 1);
    let made = plan(&farm);
    let [build] = &made.builds[..] else { panic!("{made:?}") };
    assert_eq!((build.stage, build.printer.as_deref(), build.copies), (PlanStage::Printing, Some("left"), 1));
    let [risk] = &made.risks[..] else { panic!("{made:?}") };
    assert_eq!((risk.order.as_str(), risk.cause, risk.is_late), ("A-1", RiskCause::TooLong, true));

    farm.drop_bytes("later.stl.toml", format!("due = \"{}\"\ncopies = 3\n", due_in(&farm, 20)).as_bytes());
    farm.drop_part("later.stl", &block(20.0, 20.0, 30.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.pass_secs(10.0);
    let planned = plan(&farm);
    let open = planned.builds.last().unwrap().clone();
    assert_eq!((open.stage, open.copies, open.is_nested), (PlanStage::Open, 3, true), "{planned:?}");
    assert_eq!((open.height_mm, open.printer.as_deref()), (30.0, Some("right")));
    assert_eq!(open.parts[0].name, "later.stl");
    assert_eq!(planned.risks.len(), 1, "the other date is kept: {planned:?}");

    // The farm does as it was planned.
    let fires = open.fires_at.unwrap().0;
    let until = fires.duration_since(farm.date());
    farm.jump(std::time::Duration::try_from(until).unwrap() - std::time::Duration::from_secs(120));
    assert_eq!(farm.parts(PartState::Waiting).len(), 1, "not before");
    farm.jump(std::time::Duration::from_secs(180));
    farm.wait_for_parts(PartState::Built, 2);
    assert_eq!(list_build_files(&farm.folder_of("queue", "right")).len(), 1);
}

#[test]
fn a_plan_changes_nothing_and_says_why_nothing_fires() {
    let mut farm = HandDrivenFarm::open(MACHINE);
    farm.drop_bytes("a.stl.toml", format!("due = \"{}\"\n", due_in(&farm, 2)).as_bytes());
    farm.order_and_wait(CommandKind::Pause, None);
    farm.drop_part("a.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.pass_secs(10.0);
    let last = |farm: &HandDrivenFarm| farm.ask(async |ledger| ledger.last_event_id().await.unwrap());
    let before = last(&farm);
    let paused = plan(&farm);
    assert_eq!(
        (paused.hindered, paused.builds[0].fires_at, paused.builds[0].ends_at),
        (Some(RiskCause::Paused), None, None)
    );
    assert_eq!(paused.risks[0].cause, RiskCause::Paused, "{paused:?}");
    assert_eq!(last(&farm), before);
}
