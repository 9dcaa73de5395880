//! No question of the farm or its faces walks through a table that grows for ever: SQLite's own plan of every query says so.

use std::path::Path;

use super::*;

/// Tables that grow for as long as the farm runs.
const BIG: [&str; 7] = ["part", "ticket", "build", "placement", "event", "outcome", "command"];
/// Sources whose queries look at every row, and should: the deep check, and the totals that metrics ask for once a minute.
const WHOLE: [&str; 3] = ["truth.rs", "deep.rs", "totals.rs"];
/// What is put together at run time is asked for by itself.
const MADE: char = '{';

/// The texts of a Rust source that are SQL; a line that ends with a backslash goes on without its indent.
fn queries(source: &str) -> Vec<String> {
    let code = source.split("#[cfg(test)]").next().unwrap();
    let lines: Vec<&str> = code.lines().filter(|line| !line.trim_start().starts_with("//")).collect();
    let texts = lines.join("\n");
    let texts = texts.replace("\\\"", "'");
    let texts = texts.split('"').skip(1).step_by(2);
    let joined = texts.map(|text| text.split("\\\n").map(str::trim_start).collect::<String>());
    joined
        .filter(|t| ["SELECT ", "UPDATE ", "DELETE ", "INSERT ", "WITH "].iter().any(|verb| t.starts_with(verb)))
        .collect()
}

async fn plan(ledger: &Ledger, query: &str) -> Vec<String> {
    let explain = format!("EXPLAIN QUERY PLAN {query}");
    let rows = sqlx::query_as::<_, (i64, i64, i64, String)>(sqlx::AssertSqlSafe(explain));
    let rows = rows.fetch_all(ledger.reader().unwrap()).await.unwrap_or_else(|error| panic!("{query}: {error}"));
    rows.into_iter().map(|(_, _, _, step)| step).collect()
}

/// The steps that walk through a big table or a whole index of one, but for those of an index that holds the asked rows only.
fn walks<'a>(plan: &'a [String], aliases: &[(String, String)]) -> Vec<&'a String> {
    let is_big = |name: &str| {
        let table = aliases.iter().find(|(alias, _)| alias == name).map_or(name, |(_, table)| table);
        BIG.contains(&table)
    };
    let is_walk = |step: &&String| {
        // A search without a condition is the least or greatest of an index: a walk, unless it is the first column's.
        let seeks = |rest: &&str| rest.contains('(') || rest.ends_with("build_by_profile_time");
        let walk = step.strip_prefix("SCAN ");
        let Some(rest) = walk.or(step.strip_prefix("SEARCH ").filter(|rest| !seeks(rest))) else { return false };
        // These indexes hold only what is asked for: few rows, or those that the limit ends.
        let is_partial = ["command_asked", "one_open_build", "build_by_time"].iter().any(|index| rest.ends_with(index));
        is_big(rest.split(' ').next().unwrap_or("")) && !is_partial
    };
    plan.iter().filter(is_walk).collect()
}

/// The short names that a query gives to tables.
fn aliases(query: &str) -> Vec<(String, String)> {
    let words: Vec<&str> = query.split(|c: char| c.is_whitespace() || "(),".contains(c)).collect();
    let pairs = words.windows(2).filter(|pair| BIG.contains(&pair[0]));
    pairs.map(|pair| (pair[1].to_owned(), pair[0].to_owned())).collect()
}

/// Every kind of question that is asked of the history.
fn histories() -> Vec<String> {
    let mut all = Vec::new();
    for sort in [HistorySort::Newest, HistorySort::Height, HistorySort::Profile] {
        for profile in [None, Some("m".to_owned())] {
            for after in [None, Some(BuildId(7))] {
                for state in [None, Some(BuildState::Published), Some(BuildState::Failed)] {
                    for part in [None, Some("a.stl".to_owned())] {
                        let profile = profile.clone();
                        let query = HistoryQuery { profile, after, state, part, sort, ..Default::default() };
                        all.push(super::super::history::sql(&query));
                    }
                }
            }
        }
    }
    all
}

/// Every kind of question that is asked for a list of parts, but that for all built ones, which walks until it has as many as are
/// asked for.
fn part_lists() -> Vec<String> {
    let mut all = Vec::new();
    for name in [None, Some("a.stl".to_owned())] {
        for state in [None, Some(PartState::Waiting), Some(PartState::Rejected), Some(PartState::Built)] {
            for profile in [None, Some("m".to_owned())] {
                for before in [None, Some(PartId(7))] {
                    if state == Some(PartState::Built) && name.is_none() && profile.is_none() {
                        continue;
                    }
                    let query = PartQuery { name: name.clone(), state, profile: profile.clone(), before, limit: 500 };
                    all.push(super::super::part_list::sql(&query));
                }
            }
        }
    }
    all
}

#[tokio::test]
async fn no_query_walks_through_a_table_that_grows() {
    let ledger = fresh().await;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/ledger");
    let mut all = histories();
    all.extend(part_lists());
    for entry in std::fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let name = entry.file_name().into_string().unwrap();
        if name.ends_with(".rs") && !WHOLE.contains(&name.as_str()) && !name.contains("fixtures") {
            all.extend(queries(&std::fs::read_to_string(entry.path()).unwrap()));
        }
    }
    all.retain(|query| !query.contains(MADE));
    assert!(all.len() > 50, "only {} queries were found", all.len());
    let mut found = Vec::new();
    for query in &all {
        // From the end of the table to the first that is meant.
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
    for (one, index) in [(None, "build_by_time"), (Some("m".to_owned()), "build_by_profile_time")] {
        for after in [None, Some(BuildId(7))] {
            let query = HistoryQuery { profile: one.clone(), after, ..Default::default() };
            let plan = plan(&ledger, &super::super::history::sql(&query)).await;
            assert!(plan.iter().any(|step| step.contains("SEARCH b") && step.contains(index)), "{plan:?}");
            // Only the rows of the page are sorted.
            let sorts = plan.iter().filter(|step| step.contains("TEMP B-TREE FOR ORDER BY")).count();
            assert!(sorts == 1 && plan.last().unwrap().contains("ORDER BY"), "{plan:?}");
        }
    }
}
