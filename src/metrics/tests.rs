//! The numbers of a real ledger, as Prometheus reads them.

use std::{
    collections::BTreeMap,
    io::Write,
    process::{Command, Stdio},
    sync::{Arc, RwLock},
    time::Duration,
};

use ledger::{
    EventKind, NewPartRow, NightState, NodeHeartbeat, ObservedMachine, OpenLayout, RefusalCause, UtcTimestamp,
};
use ledger_fixtures as fixtures;
use settings::{Settings, SharedSettings};

use super::*;

/// A farm of the machines `cube` and `idle`; `more` is of its configuration.
fn farm(folder: &std::path::Path, more: &str) -> Settings {
    std::fs::create_dir_all(folder.join("profiles")).unwrap();
    std::fs::create_dir_all(folder.join("state")).unwrap();
    std::fs::write(folder.join("nestd.toml"), more).unwrap();
    for name in ["cube", "idle"] {
        std::fs::write(folder.join(format!("profiles/{name}.toml")), "volume_mm = [200, 200, 200]\n").unwrap();
    }
    settings::load_settings(Some(&folder.join("nestd.toml")), Some(folder)).unwrap()
}

fn part(claim: &str, copies: u32) -> NewPartRow {
    NewPartRow { machine: "cube".to_owned(), ..fixtures::new_part(claim, copies) }
}

/// A ledger in which everything that is counted has happened at least once.
async fn lively() -> fixtures::TestLedger {
    let ledger = fixtures::fresh().await;
    let built = ledger.record_claim(&part("a", 2)).await.unwrap().id;
    ledger.accept_solids(built, &[fixtures::solid(0, 2)]).await.unwrap();
    let build = ledger.open_build("cube").await.unwrap().id;
    ledger.begin_nesting(build, "flush", &[(built, 0), (built, 1)]).await.unwrap();
    ledger.write_event(EventKind::ProofFailed, "cube", None, Some(build), "why").await.unwrap();
    let placed = fixtures::placed(&[(built, 0), (built, 1)]);
    ledger.verify_build(build, &fixtures::verified(build, 2), &placed).await.unwrap();
    ledger.publish_build(build).await.unwrap();
    let torn = ledger.record_claim(&part("b", 1)).await.unwrap().id;
    ledger.refuse_claim(torn, RefusalCause::NotClosed, "torn").await.unwrap();
    ledger.record_file_refusal("cube", RefusalCause::Ticket, "order.csv: no").await.unwrap();
    let due = fixtures::asked(part("c", 3), |terms| terms.due_at = Some(jiff::Timestamp::now()));
    let waits = ledger.record_claim(&due).await.unwrap().id;
    ledger.accept_solids(waits, &[fixtures::solid(0, 3), fixtures::solid(1, 3)]).await.unwrap();
    let layout =
        OpenLayout { layout: "[]".to_owned(), height_mm: 10.0, density: 0.1, copies: 6, part_volume_mm3: 6000.0 };
    let open = ledger.open_build("cube").await.unwrap().id;
    ledger.save_layout(open, &layout).await.unwrap();
    ledger.save_night_search(open, &fixtures::night_search(NightState::GoesOn)).await.unwrap();
    ledger
}

async fn record_heartbeat(ledger: &fixtures::TestLedger, trouble: &str) {
    let now = jiff::Timestamp::now();
    let seen = |machine: &str, trouble: &str| ObservedMachine {
        profile: String::new(),
        machine: machine.to_owned(),
        scanned_at: Some(UtcTimestamp(now)),
        is_inbox_there: true,
        is_queue_writable: trouble.is_empty(),
        trouble: Some(trouble.to_owned()),
    };
    let heartbeat = NodeHeartbeat {
        pid: std::process::id(),
        machines: vec![seen("cube", trouble), seen("idle", "")],
        configured: Vec::new(),
        ..fixtures::heartbeat()
    };
    ledger.write_heartbeat(&heartbeat).await.unwrap();
}

/// All samples of the text, by name and labels. Fails where promtool would complain: a family without help or type, a
/// sample without a family, a unit that is not a base unit, a counter with a wrong name.
fn samples(text: &str) -> BTreeMap<String, f64> {
    let (mut helped, mut kinds, mut samples) = (Vec::new(), BTreeMap::new(), BTreeMap::new());
    for line in text.lines() {
        let words: Vec<&str> = line.splitn(4, ' ').collect();
        match words[..] {
            ["#", "HELP", name, help] if help.len() > 10 => helped.push(name),
            ["#", "TYPE", name, kind] => drop(kinds.insert(name, kind)),
            _ => {
                let (key, value) = line.rsplit_once(' ').unwrap();
                let name = key.split('{').next().unwrap();
                let is_of = |family: &&&str| {
                    let rest = name.strip_prefix(**family).unwrap_or("no");
                    let ends: &[&str] =
                        if kinds[**family] == "histogram" { &["_bucket", "_sum", "_count"] } else { &[""] };
                    ends.contains(&rest)
                };
                let family = kinds.keys().find(is_of).unwrap_or_else(|| panic!("{line}: of no family"));
                assert_eq!(helped.last(), Some(family), "{line}: described elsewhere");
                assert!(family.starts_with("nestd_"), "{line}");
                assert_eq!(kinds[*family] == "counter", family.ends_with("_total"), "{line}");
                assert!(
                    !["_mm", "_ms", "_hours", "_percent", "_millis"].iter().any(|unit| name.contains(unit)),
                    "{line}"
                );
                assert!(samples.insert(key.to_owned(), value.parse().unwrap()).is_none(), "{line}: twice");
            }
        }
    }
    samples
}

/// Runs promtool on the text, if it is installed.
fn promtool(text: &str) -> String {
    let command =
        Command::new("promtool").args(["check", "metrics"]).stdin(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let Ok(mut promtool) = command else { return String::new() };
    promtool.stdin.take().unwrap().write_all(text.as_bytes()).unwrap();
    let output = promtool.wait_with_output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    if output.status.success() { stderr } else { format!("failed: {stderr}") }
}

#[tokio::test]
async fn every_number_has_help_and_counts_what_the_ledger_counts() {
    let folder = tempfile::tempdir().unwrap();
    let settings = farm(folder.path(), "");
    let ledger = lively().await;
    record_heartbeat(&ledger, "cube: The queue folder cannot be used: it is read-only.").await;
    let text = MetricsExporter::default().render_text(&ledger, &settings).await.unwrap();
    assert_eq!(promtool(&text), "");
    let samples = samples(&text);
    let is = |key: &str, value: f64| assert_eq!(samples.get(key), Some(&value), "{key} in\n{text}");
    is("nestd_files_ingested_total{machine=\"cube\"}", 3.0);
    is("nestd_files_refused_total{machine=\"cube\",reason=\"not-closed\"}", 1.0);
    is("nestd_files_refused_total{machine=\"cube\",reason=\"ticket\"}", 1.0);
    is("nestd_files_refused_total{machine=\"cube\",reason=\"cancelled\"}", 0.0);
    is("nestd_files_refused_total{machine=\"idle\",reason=\"format\"}", 0.0);
    is("nestd_parts_waiting{machine=\"cube\"}", 2.0);
    is("nestd_copies_waiting{machine=\"cube\"}", 6.0);
    is("nestd_build_outcomes_total{machine=\"cube\",outcome=\"published\"}", 1.0);
    is("nestd_build_outcomes_total{machine=\"cube\",outcome=\"given_up\"}", 0.0);
    is("nestd_proof_failures_total{machine=\"cube\"}", 1.0);
    is("nestd_build_height_meters_count{machine=\"cube\"}", 1.0);
    is("nestd_build_density_ratio_count{machine=\"cube\"}", 1.0);
    is("nestd_nesting_duration_seconds_count{machine=\"cube\"}", 1.0);
    is("nestd_queue_writable{machine=\"cube\"}", 0.0);
    is("nestd_available{machine=\"cube\"}", 0.0);
    is("nestd_available{machine=\"idle\"}", 1.0);
    is("nestd_paused{machine=\"cube\"}", 0.0);
    is("nestd_open_build_height_meters{machine=\"cube\"}", 0.01);
    is("nestd_open_build_night_cpu_seconds{machine=\"cube\"}", 63.5);
    is("nestd_open_build_night_gain_meters{machine=\"cube\"}", 0.0225);
    is("nestd_daemon_up", 1.0);
    assert!(samples["nestd_disk_free_bytes"] > 0.0 && samples["nestd_disk_size_bytes"] > 0.0);
    let now = jiff::Timestamp::now().as_second() as f64;
    for key in ["oldest_waiting", "last_scan"] {
        let at = samples[&format!("nestd_{key}_timestamp_seconds{{machine=\"cube\"}}")];
        assert!((at - now).abs() < 60.0, "{key} {at}");
    }
}

#[tokio::test]
async fn a_farm_in_which_nothing_happened_yet_has_clean_metrics_too() {
    let folder = tempfile::tempdir().unwrap();
    let (settings, ledger) = (farm(folder.path(), ""), fixtures::fresh().await);
    let text = MetricsExporter::default().render_text(&ledger, &settings).await.unwrap();
    assert_eq!(promtool(&text), "");
    let samples = samples(&text);
    assert_eq!(samples["nestd_daemon_up"], 0.0);
    assert!(!text.contains("nestd_queue_writable{"), "what nobody looked at is not told");
}

#[tokio::test]
async fn reasons_are_few_words_and_a_hostile_text_becomes_no_label() {
    let folder = tempfile::tempdir().unwrap();
    let (settings, ledger) = (farm(folder.path(), ""), fixtures::fresh().await);
    for number in 0..50 {
        let reason = format!("x{number}\"}} 1\nnestd_evil 1");
        ledger.record_file_refusal("cube", RefusalCause::Unreadable, &reason).await.unwrap();
    }
    let text = MetricsExporter::default().render_text(&ledger, &settings).await.unwrap();
    assert!(!text.contains("evil"), "{text}");
    let refused = samples(&text).into_iter().filter(|(key, _)| key.starts_with("nestd_files_refused_total{"));
    assert_eq!(refused.count(), settings.profiles.len() * RefusalCause::ALL.len());
}

#[tokio::test]
async fn that_a_machine_becomes_unavailable_is_an_event_once() {
    let ledger = fixtures::fresh().await;
    for trouble in ["", "away", "away", "still away", "", ""] {
        record_heartbeat(&ledger, trouble).await;
    }
    let ids = ledger.last_event_id().await.unwrap();
    let row = ledger.list_machines().await.unwrap();
    assert_eq!((ids, row[0].trouble.as_str(), row[0].trouble_at), (2, "", None));
}

#[tokio::test]
async fn the_file_is_written_as_a_whole_and_follows_the_settings() {
    let folder = tempfile::tempdir().unwrap();
    let ledger = lively().await;
    let file = folder.path().join("nestd.prom");
    let config = format!("[metrics]\ntextfile = \"{}\"\nevery_secs = 1\n", file.display());
    let settings = Settings { ledger: ledger.file().unwrap().into(), ..farm(folder.path(), &config) };
    let mut without_file = settings.clone();
    without_file.interfaces.metrics = None;
    let shared: SharedSettings = Arc::new(RwLock::new(Arc::new(without_file)));
    let task = tokio::spawn(keep_metrics_file(
        shared.clone(),
        ledger::LedgerOnDemand::for_user(ledger::LedgerUser::Monitoring),
    ));
    tokio::time::sleep(Duration::from_millis(1500)).await;
    assert!(!file.exists(), "it is not asked for yet");
    *shared.write().unwrap() = Arc::new(settings);
    let written = async || {
        for _ in 0..100 {
            if let Ok(text) = std::fs::read_to_string(&file) {
                return text;
            }
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
        panic!("no file");
    };
    let text = written().await;
    assert_eq!(promtool(&text), "");
    assert_eq!(samples(&text)["nestd_files_ingested_total{machine=\"cube\"}"], 3.0);
    std::fs::remove_file(&file).unwrap();
    written().await;
    task.abort();
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert!(!left.iter().any(|name| name.to_string_lossy().starts_with(".nestd-")), "{left:?}");
}

#[test]
fn a_file_that_node_exporter_would_not_read_is_objected_to() {
    for wrong in ["textfile = \"nestd.prom\"", "textfile = \"/tmp/nestd.txt\"", "every_secs = 0.1"] {
        let folder = tempfile::tempdir().unwrap();
        farm(folder.path(), "");
        std::fs::write(folder.path().join("nestd.toml"), format!("[metrics]\n{wrong}\n")).unwrap();
        let refused = settings::load_settings(Some(&folder.path().join("nestd.toml")), None).unwrap_err().to_string();
        assert!(refused.contains("nestd.toml:2: metrics."), "{refused}");
    }
}

/// Every name that begins with nestd_.
fn names_in(document: &str) -> Vec<&str> {
    let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let starts = document.match_indices("nestd_").map(|(at, _)| at);
    let starts = starts.filter(|at| *at == 0 || !document[..*at].ends_with(is_name));
    let names = starts.map(|at| document[at..].split(|c: char| !is_name(c)).next().unwrap_or_default());
    names.filter(|name| *name != "nestd_").collect()
}

#[tokio::test]
async fn dashboard_alerts_and_documentation_name_only_exported_metrics() {
    let folder = tempfile::tempdir().unwrap();
    let settings = farm(folder.path(), "");
    let ledger = lively().await;
    record_heartbeat(&ledger, "").await;
    let text = MetricsExporter::default().render_text(&ledger, &settings).await.unwrap();
    let docs = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let exported: Vec<&str> = names_in(&text);
    for (name, least) in [("grafana.json", 20), ("alerts.yml", 12), ("monitoring.md", 25)] {
        let document = std::fs::read_to_string(docs.join(name)).unwrap();
        let named = names_in(&document);
        assert!(named.len() >= least, "{name} names only {named:?}");
        let unknown: Vec<&&str> = named.iter().filter(|metric| !exported.contains(metric)).collect();
        assert!(unknown.is_empty(), "{name} names {unknown:?}, which nestd does not tell");
    }
    // The reverse: every family is documented.
    let monitoring = std::fs::read_to_string(docs.join("monitoring.md")).unwrap();
    let documented = names_in(&monitoring);
    let families = text.lines().filter_map(|line| line.strip_prefix("# TYPE ")?.split(' ').next());
    let silent: Vec<&str> = families.filter(|family| !documented.contains(family)).collect();
    assert!(silent.is_empty(), "docs/monitoring.md does not tell of {silent:?}");
}

#[test]
fn the_dashboard_has_its_data_source_as_a_variable_and_no_panel_beside_another() {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/grafana.json");
    let dashboard: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    assert_eq!(dashboard["templating"]["list"][0]["type"], "datasource");
    let mut taken = std::collections::BTreeSet::new();
    for panel in dashboard["panels"].as_array().unwrap() {
        assert_eq!(panel["datasource"]["uid"], "${datasource}", "{}", panel["title"]);
        let at = |key: &str| panel["gridPos"][key].as_u64().unwrap();
        for (x, y) in (at("x")..at("x") + at("w")).flat_map(|x| (at("y")..at("y") + at("h")).map(move |y| (x, y))) {
            assert!(x < 24 && taken.insert((x, y)), "{} lies on another", panel["title"]);
        }
    }
}

#[test]
fn the_alert_rules_are_rules_where_promtool_is_installed() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    for words in [["check", "rules", "docs/alerts.yml"], ["test", "rules", "tests/monitoring/alerts_test.yml"]] {
        if let Ok(output) = Command::new("promtool").args(words).current_dir(root).output() {
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        }
    }
}
