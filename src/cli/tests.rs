//! Tests of the commands over a real ledger.

use std::time::Duration;

use farm::DatedOrder;
use jiff::Timestamp;
use ledger::{CommandKind, HistoryQuery, Ledger, NewPartRow, PartId, PrintOutcome, RefusalCause, RequiredTilts};
use ledger_fixtures::*;
use nester::TiltLimit;
use settings::FarmZone;

use super::{
    CommandExit, CommandLine,
    act::command::{self, DaemonCommand},
    command_line,
    look::status,
    terminal::{
        lookup::{self, LookupQuery},
        show_text, table,
    },
};
use crate::tables::{LEAST_ORDER_COLUMNS, ORDER_COLUMNS, TimeView, for_people};

fn kept_view() -> TimeView {
    TimeView::kept(&FarmZone::default())
}

fn words(text: &str) -> Vec<String> {
    text.split(' ').map(str::to_owned).collect()
}

async fn write_heartbeat(ledger: &Ledger) {
    ledger.write_heartbeat(&heartbeat()).await.unwrap();
}

#[test]
fn the_command_line_is_sound() {
    command_line().debug_assert();
}

/// What the chapter of commands must name: each command by its whole name, and each option.
fn names_of(command: &clap::Command, path: &str) -> Vec<String> {
    let shown = command.get_arguments().filter(|option| !option.is_hide_set());
    let options = shown.filter_map(|option| option.get_long()).filter(|long| *long != "help");
    let mut names: Vec<String> = options.map(|long| format!("--{long}")).collect();
    for inner in command.get_subcommands().filter(|inner| !inner.is_hide_set()) {
        let path = format!("{path} {}", inner.get_name());
        names.extend(names_of(inner, &path));
        names.extend((!inner.has_subcommands()).then_some(path));
    }
    names
}

#[test]
fn the_chapter_of_commands_names_every_command_and_every_option() {
    use clap::CommandFactory;
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/commands.md");
    let chapter = std::fs::read_to_string(file).unwrap();
    let names = names_of(&CommandLine::command(), "nestd");
    assert!(names.len() > 60, "{names:?}");
    let ends = |rest: &str| !rest.starts_with(|c: char| c.is_ascii_alphanumeric() || c == '-');
    let is_named =
        |name: &String| chapter.match_indices(name.as_str()).any(|(at, _)| ends(&chapter[at + name.len()..]));
    let missing: Vec<&String> = names.iter().filter(|name| !is_named(name)).collect();
    assert!(missing.is_empty(), "docs/commands.md lacks {missing:?}");
}

#[tokio::test]
async fn an_order_is_noted_while_the_daemon_does_not_run() {
    let ledger = fresh().await;
    let (text, exit) =
        command::send_command(&ledger, &DaemonCommand::Flush("paper-200".into()), Duration::ZERO).await.unwrap();
    assert_eq!(exit, CommandExit::Success);
    assert_eq!(text, "The daemon does not run; flush is noted and will be done when it starts.");
    let asked = ledger.pending_commands().await.unwrap();
    assert_eq!((asked[0].kind, asked[0].machine.as_str()), (CommandKind::Flush, "paper-200"));
    assert!(asked[0].asked_by.contains('@'));
}

#[tokio::test]
async fn the_answer_of_the_daemon_is_printed_and_a_refusal_fails() {
    let ledger = fresh().await;
    write_heartbeat(&ledger).await;
    for (done, exit, expected) in
        [(true, CommandExit::Success, "nothing waits"), (false, CommandExit::Failure, "Refused: nothing waits")]
    {
        let daemon = async {
            while ledger.pending_commands().await.unwrap().is_empty() {
                tokio::time::sleep(Duration::from_millis(5)).await;
            }
            let id = ledger.pending_commands().await.unwrap()[0].id;
            ledger.answer_command(id, done, "nothing waits").await.unwrap();
        };
        let (given, ()) =
            tokio::join!(command::send_command(&ledger, &DaemonCommand::Scan, Duration::from_secs(20)), daemon);
        assert_eq!(given.unwrap(), (expected.to_owned(), exit));
    }
    let (text, exit) = command::send_command(&ledger, &DaemonCommand::Scan, Duration::ZERO).await.unwrap();
    assert!(text.starts_with("scan is noted, but the daemon has not answered yet") && text.contains("`nestd status`"));
    assert_eq!(exit, CommandExit::Failure);
    let unknown =
        command::send_command(&ledger, &DaemonCommand::Retry(ledger::PartId(99)), Duration::ZERO).await.unwrap_err();
    assert_eq!(unknown.to_string(), "there is no part 99");
}

#[tokio::test]
async fn status_shows_every_machine_and_what_it_does() {
    let ledger = fresh().await;
    let (a, b) = (waiting(&ledger, "a", 3).await, waiting(&ledger, "b", 1).await);
    published(&ledger, &[(a, 0)]).await;
    nesting(&ledger, &[(a, 1)]).await;
    ledger.cancel_part(b, RefusalCause::Cancelled, "not\nneeded").await.unwrap();
    ledger.pause_machine("sold", "ann@farm", ledger::PauseCause::Person).await.unwrap();
    let stopped = status::read_status(&ledger, "host", &["fuse-1", "paper-200"], false).await.unwrap().to_text(
        Timestamp::now(),
        &FarmZone::default(),
        usize::MAX,
    );
    assert!(stopped.starts_with("The daemon does not run.\n"), "{stopped}");
    write_heartbeat(&ledger).await;
    let farm = status::read_status(&ledger, "host", &["fuse-1", "paper-200"], true).await.unwrap();
    let text = farm.to_text(Timestamp::now(), &FarmZone::default(), usize::MAX);
    assert!(text.starts_with("The daemon runs on farm (process 4711, version 0.1.0)"), "{text}");
    let line = |name: &str| text.lines().find(|l| l.starts_with(name)).unwrap().split_whitespace().collect::<Vec<_>>();
    assert_eq!(line("fuse-1")[..8], ["fuse-1", "0", "0", "-", "-", "-", "free", "now"]);
    assert_eq!(line("paper-200")[..3], ["paper-200", "1", "1"]);
    assert!(text.contains("build 2 is being searched (1 copy)") && text.contains("build 1, 87.50 mm"), "{text}");
    assert!(text.contains("not configured; paused by ann@farm"), "{text}");
    assert!(text.contains("b.stl  not; needed"), "{text}");
    let json = serde_json::to_value(&farm).unwrap();
    assert_eq!(json["machines"][1]["waiting_copies"], 1);
    assert_eq!(json["machines"][1]["nesting"][0]["state"], "nesting");
    assert_eq!((&json["daemon"]["alive"], json["parts"].as_array().unwrap().len()), (&true.into(), 2));
}

#[tokio::test]
async fn history_is_a_table_json_or_csv_with_the_same_heights() {
    let ledger = fresh().await;
    let id = waiting(&ledger, "a", 2).await;
    published(&ledger, &[(id, 0), (id, 1)]).await;
    let rows = ledger.read_history(&HistoryQuery::default()).await.unwrap();
    let rows = farm::DatedBuild::of_rows(&ledger, [], rows, jiff::Timestamp::now()).await.unwrap();
    let table = table::TextTable::of(crate::tables::HISTORY_COLUMNS, &rows, &kept_view()).to_string();
    assert!(table.lines().nth(1).unwrap().contains("87.50"), "{table}");
    let heads: Vec<String> =
        crate::tables::for_people(crate::tables::HISTORY_COLUMNS).map(|c| c.field.terminal_heading()).collect();
    let printed = table.lines().next().unwrap().split("  ").map(str::trim).filter(|head| !head.is_empty());
    assert_eq!(printed.collect::<Vec<_>>(), heads);
    let csv = crate::tables::csv_of(crate::tables::HISTORY_COLUMNS, &rows).unwrap();
    let json = serde_json::to_value(&rows).unwrap();
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let heads = reader.headers().unwrap().clone();
    let record = reader.records().next().unwrap().unwrap();
    let names: Vec<&String> = json[0].as_object().unwrap().keys().collect();
    assert_eq!(names.len(), heads.len());
    for (head, cell) in heads.iter().zip(&record) {
        match &json[0][head] {
            serde_json::Value::Null => assert_eq!(cell, "", "{head}"),
            serde_json::Value::String(text) => assert_eq!(cell, text, "{head}"),
            number => assert_eq!(cell.parse::<f64>().unwrap(), number.as_f64().unwrap(), "{head}"),
        }
    }
    assert_eq!(
        crate::tables::csv_of(crate::tables::HISTORY_COLUMNS, &[]).unwrap().lines().count(),
        1,
        "headings even when there is no build"
    );
}

#[test]
fn a_bare_number_or_name_may_be_several_things() {
    let json = |text: &str| format!("{:?}", LookupQuery::from_words(&words(text)));
    assert_eq!(json("42"), r#"LookupQuery { build: Some(42), part: Some(42), order: Some("42"), file: Some("42") }"#);
    assert_eq!(json("b42"), r#"LookupQuery { build: Some(42), part: None, order: Some("b42"), file: Some("b42") }"#);
    assert_eq!(json("p7"), r#"LookupQuery { build: None, part: Some(7), order: Some("p7"), file: Some("p7") }"#);
    assert_eq!(json("build 42"), "LookupQuery { build: Some(42), part: None, order: None, file: None }");
    assert_eq!(json("part 7"), "LookupQuery { build: None, part: Some(7), order: None, file: None }");
    assert_eq!(json("order kit 7"), r#"LookupQuery { build: None, part: None, order: Some("kit 7"), file: None }"#);
    assert_eq!(
        json("kit seven"),
        r#"LookupQuery { build: None, part: None, order: Some("kit seven"), file: Some("kit seven") }"#
    );
    assert_eq!(json("part b42"), r#"LookupQuery { build: None, part: None, order: None, file: Some("b42") }"#);
}

async fn look_up(ledger: &ledger::Ledger, words: &[String]) -> lookup::LookupResult {
    lookup::look_up(ledger, &LookupQuery::from_words(words), &[], (&Default::default(), &Default::default()))
        .await
        .unwrap()
}

#[tokio::test]
async fn show_tells_the_whole_story_of_a_build_a_part_and_an_order() {
    let ledger = fresh().await;
    let part = asked(new_part("fan", 3), |terms| {
        (terms.order_name, terms.customer) = ("kit 7".into(), "Brandt".into());
        terms.clearance_mm = Some(4.5);
        terms.tilts = RequiredTilts(vec![TiltLimit::new(glam::DVec3::new(0.0, 1.0, 1.0), 30.0).unwrap()]);
    });
    let claim = NewPartRow { warnings: vec!["odd name".into()], ..part };
    let id = ledger.record_claim(&claim).await.unwrap().id;
    ledger.accept_solids(id, &[solid(0, 3)]).await.unwrap();
    let build = published(&ledger, &[(id, 0), (id, 2)]).await;
    ledger.record_outcome(build, &ledger::ToldOutcome::new(PrintOutcome::Complete, "fine", "ann@farm")).await.unwrap();
    assert_eq!((build.0, id), (1, PartId(1)), "one number, two things");
    let found = look_up(&ledger, &words("1")).await;
    let text = show_text::lookup_text(&found, &kept_view(), usize::MAX);
    for expected in [
        "Build 1 of paper-200: complete",
        "height      87.50 mm",
        "bound       40.00 mm: no build of these parts is lower",
        "3.00 mm asked, 3.020 mm proved",
        "ann@farm  fine",
        "Part 1, fan.stl: waiting",
        "3, 2 in build 1 (good)",
        "10.00 x 20.00 x 30.00 mm, 12 triangles",
        "free, (0, 0.707, 0.707) within 30 degrees of up",
        "warning     odd name",
    ] {
        assert!(text.contains(expected), "'{expected}' is missing in\n{text}");
    }
    let json = serde_json::to_value(&found).unwrap();
    assert_eq!(json["build"]["placements"][1]["tx_mm"], 2.0);
    assert_eq!(json["part"]["part"]["state"], "waiting");
    let order = look_up(&ledger, &words("kit 7")).await;
    let order = show_text::lookup_text(&order, &kept_view(), usize::MAX);
    for expected in [
        "Order kit 7: under way\n",
        "customer    Brandt\n",
        "copies      2 of 3 good, 1 waiting\n",
        "to send     Your order kit 7: 2 of 3 parts are printed, a date for the rest is not known yet.\n",
        "2 in build 1 (good)",
    ] {
        assert!(order.contains(expected), "'{expected}' is missing in\n{order}");
    }
    assert!(!order.contains("BAD") && !order.contains("REFUSED"), "{order}");
    let named = show_text::lookup_text(&look_up(&ledger, &words("fan.stl")).await, &kept_view(), usize::MAX);
    assert!(named.starts_with("Part 1, fan.stl: waiting") && named.contains("clearance   4.50 mm"), "{named}");
    let open = ledger.open_build("paper-200").await.unwrap().id;
    let open = show_text::lookup_text(&look_up(&ledger, &[format!("b{open}")]).await, &kept_view(), usize::MAX);
    assert!(open.contains("0 in the layout so far, 1 wait"), "{open}");
    assert!(open.contains("COPIES WAITING") && open.contains("fan.stl"), "{open}");
    let nothing = look_up(&ledger, &words("build 9")).await;
    assert_eq!(serde_json::to_string(&nothing).unwrap(), "{}");
}

#[tokio::test]
async fn the_list_of_orders_fits_80_columns_and_has_no_column_of_zeros() {
    let ledger = fresh().await;
    let due_at = Some(jiff::Timestamp::now() + jiff::SignedDuration::from_hours(100));
    for (claim, order, customer) in
        [("a", "A-17", "Brandt GmbH"), ("b", "K-2026-11-27-hinges", "M\u{fc}ller & S\u{f6}hne Feinmechanik")]
    {
        let part = asked(new_part(claim, 48), |terms| {
            (terms.order_name, terms.customer, terms.due_at) = (order.to_owned(), customer.to_owned(), due_at);
        });
        let id = ledger.record_claim(&part).await.unwrap().id;
        ledger.accept_solids(id, &[solid(0, 48)]).await.unwrap();
    }
    let query = ledger::OrderQuery { limit: 9, ..Default::default() };
    let now = jiff::Timestamp::now();
    let orders = ledger.order_summaries(&query).await.unwrap().into_iter();
    let mut orders: Vec<DatedOrder> = orders.map(|order| DatedOrder::of_plans(order, &[], now)).collect();
    orders[0].fact.done_at = due_at.map(|due| (due + jiff::SignedDuration::from_hours(28)).into());
    orders[0].fact.missed_at = due_at.map(Into::into);
    let table = table::TextTable::of(ORDER_COLUMNS, &orders, &TimeView::at(&Default::default(), now));
    let narrow = table.fit_essentials(80, LEAST_ORDER_COLUMNS);
    assert!(narrow.lines().all(|line| line.chars().count() <= 80), "{narrow}");
    assert!(narrow.contains("ORDER") && narrow.contains("STATE") && narrow.contains(", 28 h late"), "{narrow}");
    let wide = table.fit_essentials(usize::MAX, LEAST_ORDER_COLUMNS);
    assert!(wide.contains("Brandt GmbH") && wide.contains("48 waiting") && !wide.contains("BAD"), "{wide}");
    assert_eq!(for_people(ORDER_COLUMNS).count(), 6);
}
