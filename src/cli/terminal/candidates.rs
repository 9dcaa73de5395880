//! What a shell offers for the next word: the machines, builds, parts and orders of the farm that a command would work on. A farm that
//! cannot be read offers nothing; a shell shows no errors while somebody types.

use std::{ffi::OsStr, path::PathBuf};

use clap::builder::StyledStr;
use clap_complete::engine::{ArgValueCompleter, CompletionCandidate};
use farm::{DatedBuild, said_state};
use jiff::Timestamp;
use ledger::{HistoryQuery, OrderQuery, PartQuery, PartState};
use settings::Settings;

use super::farm_context::run_with_ledger;
use crate::cli::CommonArgs;

/// Most words of a kind.
const MAX_WORDS: u32 = 200;

/// Offers machines.
pub fn of_machines() -> ArgValueCompleter {
    ArgValueCompleter::new(|typed: &OsStr| {
        let settings = typed_settings();
        let names = settings.iter().flat_map(|settings| settings.profiles.keys().cloned());
        matching(names.map(|name| (name, String::new())), typed)
    })
}

/// Offers published builds, the newest first.
pub fn of_builds() -> ArgValueCompleter {
    ArgValueCompleter::new(|typed: &OsStr| matching(read_builds().into_iter(), typed))
}

/// Offers parts that are not printed yet, and open orders.
pub fn of_parts() -> ArgValueCompleter {
    ArgValueCompleter::new(|typed: &OsStr| matching(read_parts(None).into_iter().chain(read_orders()), typed))
}

/// Offers orders that are not over.
pub fn of_orders() -> ArgValueCompleter {
    ArgValueCompleter::new(|typed: &OsStr| matching(read_orders().into_iter(), typed))
}

/// Offers refused parts.
pub fn of_refused_parts() -> ArgValueCompleter {
    ArgValueCompleter::new(|typed: &OsStr| matching(read_parts(Some(PartState::Refused)).into_iter(), typed))
}

/// Offers builds, parts and orders.
pub fn of_everything() -> ArgValueCompleter {
    ArgValueCompleter::new(|typed: &OsStr| {
        matching(read_builds().into_iter().chain(read_parts(None)).chain(read_orders()), typed)
    })
}

/// The words that begin with what is typed, each with what it means.
fn matching(words: impl Iterator<Item = (String, String)>, typed: &OsStr) -> Vec<CompletionCandidate> {
    let typed = typed.to_string_lossy();
    let candidate = |(word, meaning): (String, String)| {
        let help = (!meaning.is_empty()).then(|| StyledStr::from(meaning));
        CompletionCandidate::new(word).help(help)
    };
    words.filter(|(word, _)| word.starts_with(typed.as_ref())).map(candidate).collect()
}

/// The settings that the typed command line names; without an error.
fn typed_settings() -> Option<Settings> {
    let words: Vec<String> = std::env::args_os().map(|word| word.to_string_lossy().into_owned()).collect();
    let after = |names: [&str; 2]| {
        let at = words.iter().rposition(|word| names.contains(&word.as_str()))?;
        words.get(at + 1).map(PathBuf::from)
    };
    let root = after(["--root", "--root"]).or_else(|| std::env::var_os("NESTD_ROOT").map(PathBuf::from));
    let common = CommonArgs { config: after(["-c", "--config"]), root };
    settings::load_for_viewing(common.config.as_deref(), common.root.as_deref()).ok().map(|(settings, _)| settings)
}

fn read_builds() -> Vec<(String, String)> {
    let read = run_with_ledger_of(async |settings, ledger| {
        let query = HistoryQuery { limit: Some(MAX_WORDS), ..HistoryQuery::default() };
        let rows = ledger.read_history(&query).await?;
        DatedBuild::of_rows(ledger, settings.profiles.values(), rows, Timestamp::now()).await
    });
    let meaning = |dated: &DatedBuild| format!("{}, {}", dated.row.machine, said_state(&dated.fact.word));
    read.unwrap_or_default().iter().map(|dated| (format!("b{}", dated.row.build), meaning(dated))).collect()
}

/// The newest parts in a state; without one those that are not built yet.
fn read_parts(state: Option<PartState>) -> Vec<(String, String)> {
    let read = run_with_ledger_of(async |_, ledger| {
        Ok(ledger.list_parts(&PartQuery { state, limit: MAX_WORDS, ..PartQuery::default() }).await?)
    });
    let is_offered = |part: &&ledger::PartRow| state.is_some() || part.state != PartState::Refused;
    let word = |part: &ledger::PartRow| {
        (format!("p{}", part.id), format!("{}, {}", part.full_name(), said_state(&part.state.to_string())))
    };
    read.unwrap_or_default().iter().filter(is_offered).map(word).collect()
}

fn read_orders() -> Vec<(String, String)> {
    let read = run_with_ledger_of(async |_, ledger| {
        let query = OrderQuery { is_asking: true, limit: MAX_WORDS, ..OrderQuery::default() };
        Ok(ledger.list_orders(&query).await?)
    });
    read.unwrap_or_default().into_iter().map(|order| (order.name, "order".to_owned())).collect()
}

fn run_with_ledger_of<T>(work: impl AsyncFnOnce(&Settings, &ledger::Ledger) -> anyhow::Result<T>) -> Option<T> {
    run_with_ledger(typed_settings()?, async |settings, ledger| work(settings, ledger).await).ok()
}
