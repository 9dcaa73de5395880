//! Tests that no query of the farm or its user interfaces scans a whole table that grows without limit, according to
//! SQLite's query plans.

use crate::{base::sql, rows::part_row::term_columns, tests::*};
use std::path::{Path, PathBuf};

/// Tables that grow for as long as the farm runs.
const BIG: [&str; 7] = ["part", "ticket", "build", "placement", "event", "outcome", "command"];
/// Sources whose queries read every row on purpose: the deep check, the totals that the metrics read once a minute, and the search for
/// part of a name, which no index can answer.
const WHOLE: [&str; 4] = ["consistency.rs", "deep_check.rs", "name_search.rs", "totals.rs"];
/// Sources that read whole rows, with statements that are not prepared.
const WHOLE_ROWS: [&str; 2] = ["build_record.rs", "copy.rs"];
/// Queries that are built at run time are tested separately.
const MADE: char = '{';

/// The SQL strings of a Rust source. A line that ends with a backslash continues without its indentation.
fn queries(source: &str) -> Vec<String> {
    let code = source.split("#[cfg(test)]").next().unwrap();
    let lines: Vec<&str> = code.lines().filter(|line| !line.trim_start().starts_with("//")).collect();
    // A list of columns stands in the text of a query that is put together of several.
    let texts = lines.join("\n");
    let pieces =
        texts.split("term_columns!(),").map(|piece| piece.trim().trim_start_matches('"').trim_end_matches("\","));
    let texts = pieces.collect::<Vec<_>>().join(term_columns!());
    let texts = texts.replace("\\\"", "'");
    let texts = texts.split('"').skip(1).step_by(2);
    let joined = texts.map(|text| text.split("\\\n").map(str::trim_start).collect::<String>());
    joined
        .filter(|t| {
            ["SELECT ", "FROM ", "UPDATE ", "DELETE ", "INSERT ", "WITH "].iter().any(|verb| t.starts_with(verb))
        })
        .collect()
}

async fn plan(ledger: &Ledger, query: &str) -> Vec<String> {
    let columns = if query.starts_with("FROM ") { "SELECT * " } else { "" };
    let explain = format!("EXPLAIN QUERY PLAN {columns}{query}");
    let rows = sql::query_as::<(i64, i64, i64, String)>(sqlx::AssertSqlSafe(explain));
    let rows = rows.fetch_all(ledger.reader().unwrap()).await.unwrap_or_else(|error| panic!("{query}: {error}"));
    rows.into_iter().map(|(_, _, _, step)| step).collect()
}

/// The plan steps that scan a big table or one of its indexes completely, except indexes that contain only the
/// requested rows.
fn walks<'a>(plan: &'a [String], aliases: &[(String, String)]) -> Vec<&'a String> {
    let is_big = |name: &str| {
        let table = aliases.iter().find(|(alias, _)| alias == name).map_or(name, |(_, table)| table);
        BIG.contains(&table)
    };
    let is_walk = |step: &&String| {
        // A search without a condition finds the minimum or maximum of an index. This is a full scan unless it is the
        // first column of the index, or the number of the row.
        let seeks =
            |rest: &&str| rest.contains('(') || rest.ends_with("build_by_machine_time") || !rest.contains(" USING ");
        let walk = step.strip_prefix("SCAN ");
        let Some(rest) = walk.or(step.strip_prefix("SEARCH ").filter(|rest| !seeks(rest))) else { return false };
        // These indexes contain only the requested rows: few of them, or rows that the limit cuts off.
        let is_partial = [
            "command_asked",
            "one_open_build",
            "build_by_time",
            "part_to_fetch",
            "part_in_question",
            "part_by_replacement",
            "build_unseen",
            "build_moving",
            "build_word_dropped",
        ]
        .iter()
        .any(|index| rest.ends_with(index));
        is_big(rest.split(' ').next().unwrap_or("")) && !is_partial
    };
    plan.iter().filter(is_walk).collect()
}

/// The table aliases of a query.
fn aliases(query: &str) -> Vec<(String, String)> {
    let words: Vec<&str> = query.split(|c: char| c.is_whitespace() || "(),".contains(c)).collect();
    let pairs = words.windows(2).filter(|pair| BIG.contains(&pair[0]));
    pairs.map(|pair| (pair[1].to_owned(), pair[0].to_owned())).collect()
}

/// Every kind of history query.
fn histories() -> Vec<String> {
    let mut all = Vec::new();
    for sort in [HistorySort::Newest, HistorySort::Height, HistorySort::Machine] {
        for machine in [None, Some("m".to_owned())] {
            for after in [None, Some(BuildId(7))] {
                for state in [None, Some(BuildState::Published), Some(BuildState::Failed)] {
                    for part in [None, Some("a.stl".to_owned())] {
                        let machine = machine.clone();
                        let query = HistoryQuery { machine, after, state, part, sort, ..Default::default() };
                        all.push(crate::service::history::history_sql(&query));
                    }
                }
            }
        }
    }
    all
}

/// Every kind of part list query, except the one for all built parts, which scans until it has enough rows.
fn part_lists() -> Vec<String> {
    let mut all = Vec::new();
    for name in [None, Some("a.stl".to_owned())] {
        for state in [None, Some(PartState::Waiting), Some(PartState::Refused), Some(PartState::Built)] {
            for machine in [None, Some("m".to_owned())] {
                for before in [None, Some(PartId(7))] {
                    if state == Some(PartState::Built) && name.is_none() && machine.is_none() {
                        continue;
                    }
                    let query = PartQuery { name: name.clone(), state, machine: machine.clone(), before, limit: 500 };
                    all.push(crate::parts::part_list::part_list_sql(&query));
                }
            }
        }
    }
    all
}

#[tokio::test]
async fn no_query_walks_through_a_table_that_grows() {
    let ledger = fresh().await;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut all = histories();
    all.extend(part_lists());
    let entries =
        |folder: &Path| std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect::<Vec<_>>();
    let folders = entries(&folder).into_iter().filter(|path| path.is_dir() && !path.ends_with("tests"));
    let files: Vec<PathBuf> = folders.flat_map(|folder| entries(&folder)).collect();
    for file in files {
        let name = file.file_name().unwrap().to_str().unwrap();
        if name.ends_with(".rs") && !WHOLE.contains(&name) {
            let found = queries(&std::fs::read_to_string(&file).unwrap());
            // PostgreSQL refuses a prepared statement whose columns have changed since, as a newer node changes them.
            let is_open = |query: &String| query.starts_with("SELECT *") || query.contains("RETURNING *");
            if !WHOLE_ROWS.contains(&name) {
                assert!(
                    !found.iter().any(is_open),
                    "{name} does not name its columns, as `select_as` does: {found:#?}"
                );
            }
            all.extend(found);
        }
    }
    all.retain(|query| !query.contains(MADE));
    assert!(all.len() > 50, "only {} queries were found", all.len());
    let mut found = Vec::new();
    for query in &all {
        // Reads from the end of the table to the first matching row.
        if query.ends_with("ORDER BY id DESC LIMIT 1") {
            continue;
        }
        let plan = plan(&ledger, query).await;
        for step in walks(&plan, &aliases(query)) {
            found.push(format!("{step}: {query}"));
        }
    }
    assert!(found.is_empty(), "these walk through a big table:\n{}", found.join("\n"));
}

#[tokio::test]
async fn the_test_of_the_plans_sees_a_walk() {
    let ledger = fresh().await;
    let query = "SELECT p.id FROM part p WHERE p.note = 'x'";
    assert_eq!(walks(&plan(&ledger, query).await, &aliases(query)).len(), 1);
    assert_eq!(
        queries("let q = \"SELECT a \\\n     FROM b\"; // \"SELECT c\"\n let t = \"text\";"),
        ["SELECT a FROM b", "SELECT c"]
    );
}

#[tokio::test]
async fn the_history_of_any_span_comes_from_its_index_in_order() {
    let ledger = fresh().await;
    for (one, index) in [(None, "build_by_time"), (Some("m".to_owned()), "build_by_machine_time")] {
        for after in [None, Some(BuildId(7))] {
            let query = HistoryQuery { machine: one.clone(), after, ..Default::default() };
            let plan = plan(&ledger, &crate::service::history::history_sql(&query)).await;
            assert!(plan.iter().any(|step| step.contains("SEARCH b") && step.contains(index)), "{plan:?}");
            // Only the rows of the page are sorted.
            let sorts = plan.iter().filter(|step| step.contains("TEMP B-TREE FOR ORDER BY")).count();
            assert!(sorts == 1 && plan.last().unwrap().contains("ORDER BY"), "{plan:?}");
        }
    }
}
