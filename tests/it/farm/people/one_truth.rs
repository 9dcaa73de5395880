//! Every face says the same of a machine and of its printer, of a copy and of its build, whatever becomes of them: the pages, the JSON, the
//! command line, `STATUS.txt`, `status.json` and the metrics. A real daemon, asked in each state.

use std::{collections::BTreeMap, fs};

use ledger::{BuildState, PartState};
use serde_json::Value;

use crate::support::{MACHINE, QUICK, TestFarm, block, http::send_request, leaning_block, wait_until_or};

/// Prints of a block of 20 mm take 20 hours, and cool for 10.
const HOURS: &str = "print_hours_per_mm = 1.0\ncool_down_hours = 10\n";
/// Prints take no time, and cool for ten hours.
const COOLS: &str = "print_hours_per_mm = 0.0\ncool_down_hours = 10\n";

fn farm(profile: &str) -> TestFarm {
    let farm = TestFarm::new(&format!("{QUICK}{profile}[trigger]\nmax_wait_secs = \"30h\"\n"));
    let config = fs::read_to_string(farm.config()).unwrap();
    let socket = farm.root().join("web.sock");
    fs::write(farm.config(), format!("{config}[web]\nlisten = \"unix:{}\"\n", socket.display())).unwrap();
    farm
}

fn get(farm: &TestFarm, path: &str) -> String {
    send_request(&farm.root().join("web.sock"), &format!("GET {path}"), b"")
        .map(|answer| answer.body)
        .unwrap_or_default()
}

/// What a face says of the machine and of its printer: their states, and the build of the printer.
type Said = (String, String, String);

fn said_in(machine: &Value) -> Said {
    let printer = &machine["printers"][0];
    let word = |value: &Value| value.as_str().unwrap_or("-").to_owned();
    (word(&machine["state"]), word(&printer["state"]), printer["build"].to_string())
}

/// The one state for which a gauge is 1.
fn gauge_state(metrics: &str, name: &str) -> String {
    let is_on = |line: &&str| line.starts_with(&format!("nestd_{name}{{")) && line.ends_with("} 1.0");
    let on: Vec<&str> = metrics.lines().filter(is_on).collect();
    assert!(on.len() <= 1, "{on:?}");
    let state = |line: &&str| line.split("state=\"").nth(1)?.split('"').next().map(str::to_owned);
    on.first().and_then(state).unwrap_or_default()
}

/// What each face says.
fn ask_faces(farm: &TestFarm) -> BTreeMap<&'static str, Said> {
    let json = |text: &str| serde_json::from_str::<Value>(text).unwrap_or_default();
    let status_file = |name: &str| fs::read_to_string(farm.folder("inbox").join(name)).unwrap_or_default();
    let api = json(&get(farm, "/api/v1/farm"));
    let command = json(&farm.nestd_ok(&["status", "--json"]));
    let printers = json(&farm.nestd_ok(&["printer", "--json"]));
    let metrics = farm.nestd_ok(&["metrics"]);
    let page = get(farm, "/");
    let (text, table) = (status_file("STATUS.txt"), farm.nestd_ok(&["status", "--wide"]));
    let told = said_in(&api["machines"][0]);
    // A face that is prose says the sentence of the JSON.
    let doing = api["machines"][0]["doing"].as_str().unwrap_or("-").to_owned();
    let prose = |text: &str| match text.replace("&#39;", "'").contains(&doing) {
        true => told.clone(),
        false => (text.to_owned(), doing.clone(), String::new()),
    };
    let marked = page.contains(&format!("<i></i>{}</span></h2>", told.0));
    BTreeMap::from([
        ("the JSON", told.clone()),
        ("nestd status --json", said_in(&command["machines"][0])),
        (
            "nestd printer --json",
            (told.0.clone(), said_in(&Value::from_iter([("printers", printers)])).1, told.2.clone()),
        ),
        ("status.json", said_in(&json(&status_file("status.json")))),
        (
            "the metrics",
            (gauge_state(&metrics, "machine_state"), gauge_state(&metrics, "printer_state"), told.2.clone()),
        ),
        ("the farm page", if marked { prose(&page) } else { (page, told.0.clone(), String::new()) }),
        ("nestd status", prose(&table)),
        ("STATUS.txt", prose(&text)),
    ])
}

/// Waits until all faces say that the machine and its printer are in these states, and with which build.
fn all_say(farm: &TestFarm, machine: &str, printer: &str, build: &str) {
    let expected = (machine.to_owned(), printer.to_owned(), build.to_owned());
    let what = format!("all faces say {expected:?}");
    let others = || {
        let said = ask_faces(farm);
        said.into_iter().filter(|(_, said)| *said != expected).collect::<Vec<_>>()
    };
    wait_until_or(&what, 30.0, || format!("{:#?}\n{}", others(), farm.log()), || others().is_empty());
}

fn flush_one(farm: &TestFarm, name: &str) {
    let built = farm.parts(PartState::Built).len();
    farm.drop_part(name, &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.flush();
    farm.wait_for_parts(PartState::Built, built + 1);
}

#[test]
fn every_face_says_the_same_of_a_machine_in_each_of_its_states() {
    let mut farm = farm(HOURS);
    farm.start();
    all_say(&farm, "free", "free", "null");
    farm.drop_part("a.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    all_say(&farm, "collecting", "free", "null");
    farm.nestd_ok(&["pause", MACHINE]);
    all_say(&farm, "paused", "free", "null");
    farm.nestd_ok(&["resume", MACHINE]);
    farm.flush();
    farm.wait_for_queued(1);
    all_say(&farm, "queued", "queued", "1");
    // A person says that it prints, although its file still lies there.
    farm.nestd_ok(&["outcome", "1", "printing"]);
    all_say(&farm, "printing", "printing", "1");
    farm.nestd_ok(&["printer", MACHINE, "down", "--reason", "its laser"]);
    all_say(&farm, "down", "down", "1");
    farm.nestd_ok(&["printer", MACHINE, "up"]);
    farm.nestd_ok(&["outcome", "1", "failed", "--anyway"]);
    let waits = || farm.parts(PartState::Waiting).len() == 1;
    wait_until_or("its copies wait again", 20.0, || farm.log(), waits);
    all_say(&farm, "collecting", "free", "null");
    farm.stop();
}

#[test]
fn a_print_is_taken_to_have_begun_when_its_file_was_taken_and_its_end_is_an_estimate() {
    let mut farm = farm(COOLS);
    farm.start();
    flush_one(&farm, "a.stl");
    for file in farm.queued() {
        fs::remove_file(file).unwrap();
    }
    all_say(&farm, "cooling", "cooling", "1");
    let printers: Value = serde_json::from_str(&farm.nestd_ok(&["printer", "--json"])).unwrap();
    assert_eq!(printers[0]["is_estimated"], true, "{printers}");
    assert!(farm.nestd_ok(&["status", "--wide"]).contains("(estimated)"));
    farm.nestd_ok(&["outcome", "1", "complete"]);
    all_say(&farm, "free", "free", "null");
    farm.stop();
}

#[test]
fn every_face_says_that_a_build_is_searched_and_a_folder_is_away() {
    let mut farm = farm("");
    farm.write_profile(MACHINE, &format!("{}{HOURS}", QUICK.replace("final_secs = 0.5", "final_secs = 12")));
    farm.start();
    farm.drop_part("a.stl", &leaning_block());
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.flush();
    let nests =
        || !farm.query_ledger(async |ledger| ledger.builds_in_state(BuildState::Nesting).await.unwrap()).is_empty();
    wait_until_or("a build is searched", 20.0, || farm.log(), nests);
    all_say(&farm, "nesting", "expecting", "1");
    farm.wait_for_queued(1);
    let (queue, away) = (farm.folder("queue"), farm.root().join("away"));
    fs::rename(&queue, &away).unwrap();
    fs::write(&queue, "").unwrap();
    all_say(&farm, "unavailable", "queued", "1");
    farm.stop();
}

#[test]
fn every_face_says_until_when_a_machine_is_closed_and_that_a_build_waits_for_a_yes() {
    let today = jiff::Zoned::now().date();
    let days = [jiff::Span::new().days(-2), jiff::Span::new().days(2)].map(|days| today.checked_add(days).unwrap());
    let closed = format!("days_off = [\"{}..{}\"]\n", days[0], days[1]);
    let mut farm = farm(&format!("{HOURS}{closed}approve = \"always\"\n"));
    farm.start();
    all_say(&farm, "closed now", "closed now", "null");
    assert!(farm.nestd_ok(&["status", "--wide"]).contains("closed until "));
    farm.drop_part("a DO NOT PRINT.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    all_say(&farm, "closed now", "closed now", "null");
    let asked = "; 1 copy waits for an answer";
    let status = || farm.nestd_ok(&["status", "--wide"]);
    wait_until_or("it is asked about, and not collected", 20.0, status, || status().contains(asked));
    assert!(!status().contains("collecting"), "{}", status());
    farm.drop_part("b.stl", &block(20.0, 20.0, 10.0));
    farm.wait_for_parts(PartState::Waiting, 2);
    all_say(&farm, "collecting", "closed now", "null");
    assert!(status().contains("; collecting 1 copy; 1 copy waits for an answer"), "{}", status());
    farm.flush();
    let proved =
        || !farm.query_ledger(async |ledger| ledger.builds_in_state(BuildState::Verified).await.unwrap()).is_empty();
    wait_until_or("the build is proved", 60.0, || farm.log(), proved);
    all_say(&farm, "waits for a yes", "expecting", "1");
    farm.stop();
}

/// What became of copies, from the fields of a JSON: `2 queued`.
fn counted(copies: &Value) -> String {
    let keys = ["good", "printed", "printing", "queued", "in_builds", "waiting", "refused", "bad", "cancelled"];
    let of = |key: &&str| copies[key].as_u64().filter(|count| *count > 0).map(|count| format!("{count} {key}"));
    keys.iter().filter_map(of).collect::<Vec<_>>().join(", ")
}

/// What each face that does not agree says of the copies of the order "kit", which are part 1: their counts, the same in words, and the word
/// of their build, if they are in one.
fn disagreeing(farm: &TestFarm, counts: &str, words: &str, build: Option<(u32, &str)>) -> Vec<(String, String)> {
    let json = |text: &str| serde_json::from_str::<Value>(text).unwrap_or_default();
    let order = json(&get(farm, "/api/v1/orders/kit"));
    let shown = json(&farm.nestd_ok(&["show", "order", "kit", "--json"]));
    let mut said = vec![
        ("the JSON of the orders", counted(&json(&get(farm, "/api/v1/orders"))[0]), counts),
        ("the JSON of the order", counted(&order), counts),
        ("the JSON of its line", counted(&order["lines"][0]), counts),
        ("the JSON of the part", counted(&json(&get(farm, "/api/v1/parts/1"))["copies_now"]), counts),
        ("nestd orders --json", counted(&json(&farm.nestd_ok(&["orders", "--all", "--json"]))[0]), counts),
        ("nestd show order --json", counted(&shown["order_sheet"]), counts),
        ("nestd show order --json, its part", counted(&shown["order"][0]["copies"]), counts),
        ("the list of orders", get(farm, "/orders"), words),
        ("the page of the order", get(farm, "/orders/kit"), words),
        ("nestd orders", farm.nestd_ok(&["orders", "--all", "--wide"]), words),
        ("nestd show order", farm.nestd_ok(&["show", "order", "kit", "--wide"]), words),
    ];
    if let Some((build, word)) = build {
        let show = |arguments: &[&str]| farm.nestd_ok(&[&["show", &format!("b{build}")], arguments].concat());
        let of = |value: &Value| value["state_word"].as_str().unwrap_or("-").to_owned();
        // A build that was given up has let its copies go.
        let in_order = order["lines"][0]["builds"].as_array().and_then(|builds| builds.last()).map(of);
        said.extend(in_order.map(|said| ("the JSON of the order, its build", said, word)));
        said.extend([
            ("the JSON of the build", of(&json(&get(farm, &format!("/api/v1/builds/{build}")))["build"]), word),
            ("nestd show build --json", of(&json(&show(&["--json"]))["build"]), word),
            ("nestd show build", show(&["--wide"]), word),
            ("the page of the build", get(farm, &format!("/builds/{build}")), word),
            ("the page of the order, its build", get(farm, "/orders/kit"), word),
        ]);
        // The history has builds past nesting alone.
        let listed = json(&get(farm, "/api/v1/builds"));
        let row = listed.as_array().and_then(|rows| rows.iter().find(|row| row["build"] == build));
        if let Some(row) = row {
            let of_row = |text: &str| of(&json(text).as_array().map_or(Value::Null, |rows| rows[0].clone()));
            said.extend([
                ("the JSON of the builds", of(row), word),
                ("the JSON of the history", of_row(&get(farm, "/history.json")), word),
                ("nestd history --json", of_row(&farm.nestd_ok(&["history", "--json"])), word),
                ("nestd history", farm.nestd_ok(&["history", "--wide"]), word),
                ("the CSV of the history", get(farm, "/history.csv"), word),
                ("the page of the history", get(farm, "/history"), word),
                ("a search for the build", get(farm, &format!("/search?q=b{build}")), word),
            ]);
        }
    }
    let differs = |(_, said, expected): &(&str, String, &str)| match expected == &words
        || build.is_some_and(|(_, word)| word == *expected)
    {
        true => !said.contains(expected),
        false => said != expected,
    };
    said.into_iter().filter(differs).map(|(face, said, _)| (face.to_owned(), said)).collect()
}

/// Waits until all faces say how far the part 1 is.
fn all_say_of_the_part(farm: &TestFarm, word: &str) {
    let others = || {
        let heading = farm.nestd_ok(&["show", "p1"]).lines().next().unwrap_or_default().to_owned();
        let faces = [
            ("nestd show", heading.ends_with(&format!(": {word}"))),
            ("the page of the part", get(farm, "/parts/1").contains(&format!("<i></i>{word}</span></h1>"))),
            ("a search for the part", get(farm, "/search?q=p1").contains(&format!(", {word} on "))),
            ("the list of parts", get(farm, "/parts?name=kit").contains(&format!("<i></i>{word}</span></td>"))),
        ];
        faces.into_iter().filter(|(_, said)| !said).map(|(face, _)| face).collect::<Vec<_>>()
    };
    wait_until_or(&format!("all faces say {word}"), 30.0, || format!("{:?}", others()), || others().is_empty());
}

/// Waits until all faces say the same of the copies of the order "kit".
fn all_count(farm: &TestFarm, counts: &str, words: &str, build: Option<(u32, &str)>) {
    let others = || disagreeing(farm, counts, words, build);
    let what = format!("all faces say {counts}, {words}, {build:?}");
    wait_until_or(&what, 30.0, || format!("{:#?}\n{}", others(), farm.log()), || others().is_empty());
}

/// Whether each face says when all of the order "kit", or its build 2, was done, and not about when that should be.
fn faces_of_the_end(farm: &TestFarm) -> Vec<(&'static str, bool)> {
    let order: Value = serde_json::from_str(&get(farm, "/api/v1/orders/kit")).unwrap_or_default();
    let show = farm.nestd_ok(&["show", "order", "kit", "--wide"]);
    let line = show.lines().find(|line| line.trim_start().starts_with("done ")).unwrap_or_default().to_owned();
    let page = get(farm, "/orders/kit");
    vec![
        ("the JSON of the order", order["is_estimated"] == false && order["done_at"].is_string()),
        ("nestd show order", line.contains(':') && !line.contains("about ")),
        ("nestd orders", !farm.nestd_ok(&["orders", "--all", "--wide"]).contains("about ")),
        ("the list of orders", !get(farm, "/orders").contains("about <time")),
        ("the page of the order", page.contains("Done <time") && !page.contains("about <time")),
        ("the page of the part", !get(farm, "/parts/1").contains("about <time")),
        ("the page of the build", !get(farm, "/builds/2").contains("<b>about ")),
        ("nestd show build", !farm.nestd_ok(&["show", "b2"]).contains("about ")),
        ("the farm page", !get(farm, "/").contains("about <time")),
    ]
}

fn take_queued(farm: &TestFarm) {
    for file in farm.wait_for_queued(1) {
        fs::remove_file(file).unwrap();
    }
}

#[test]
fn every_face_says_the_same_of_a_copy_in_each_of_its_states() {
    let mut farm = farm(HOURS);
    farm.start();
    fs::create_dir(farm.folder("inbox").join("kit")).unwrap();
    farm.drop_part("kit/a_x2.stl", &block(20.0, 20.0, 20.0));
    farm.wait_for_parts(PartState::Waiting, 1);
    all_count(&farm, "2 waiting", "2 waiting", None);
    farm.flush();
    farm.wait_for_queued(1);
    all_count(&farm, "2 queued", "2 in the queue", Some((1, "in the queue")));
    all_say_of_the_part(&farm, "in the queue");
    take_queued(&farm);
    all_count(&farm, "2 printing", "2 printing", Some((1, "printing")));
    farm.nestd_ok(&["outcome", "1", "failed"]);
    all_count(&farm, "2 waiting, 2 bad", "2 waiting, 2 bad", Some((1, "failed")));
    // The same, on a machine whose prints take no time: they are over at once, and nobody told how.
    farm.stop();
    farm.write_profile(MACHINE, &format!("{QUICK}{COOLS}"));
    farm.start();
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.flush();
    take_queued(&farm);
    all_count(&farm, "2 printed, 2 bad", "2 should be printed, 2 bad", Some((2, "cooling")));
    assert_eq!(faces_of_the_end(&farm).into_iter().filter(|(_, is_told)| *is_told).collect::<Vec<_>>(), []);
    farm.nestd_ok(&["outcome", "2", "complete"]);
    all_count(&farm, "2 good, 2 bad", "2 good, 2 bad", Some((2, "complete")));
    all_say_of_the_part(&farm, "good");
    assert_eq!(faces_of_the_end(&farm).into_iter().filter(|(_, is_told)| !is_told).collect::<Vec<_>>(), []);
    farm.stop();
}

#[test]
fn every_face_says_that_a_nesting_failed() {
    let profile = format!("{}{HOURS}", QUICK.replace("max_attempts = 50", "max_attempts = 1"));
    let mut farm = farm("");
    farm.write_profile(MACHINE, &profile.replace("final_secs = 0.5", "final_secs = 60"));
    farm.start();
    fs::create_dir(farm.folder("inbox").join("kit")).unwrap();
    farm.drop_part("kit/a.stl", &leaning_block());
    farm.wait_for_parts(PartState::Waiting, 1);
    farm.flush();
    let nests =
        || !farm.query_ledger(async |ledger| ledger.builds_in_state(BuildState::Nesting).await.unwrap()).is_empty();
    wait_until_or("a build is searched", 20.0, || farm.log(), nests);
    all_count(&farm, "1 in_builds", "1 in a build", Some((1, "nesting")));
    farm.kill();
    // The machine has become too small for what is being nested.
    farm.write_profile(MACHINE, &profile.replace("[120, 120, 120]", "[10, 10, 10]"));
    farm.start();
    farm.wait_for_parts(PartState::Refused, 1);
    all_say(&farm, "paused", "free", "null");
    all_count(&farm, "1 refused", "1 refused", Some((1, "failed")));
    let note = farm.nestd_ok(&["show", "order", "kit"]);
    assert!(note.contains("1 part is not made"), "{note}");
    farm.stop();
}
