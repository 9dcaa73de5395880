//! What a person says of published builds (`nestd outcome|reprint|requeue`) and of orders (`nestd close`), and the wait until a file is taken back.

use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use ledger::{BuildId, BuildRow, Ledger, OperatorWord};
use settings::Settings;

use crate::cli::{
    CommandExit, CommonArgs,
    terminal::{
        farm_context::{user_at_host, with_ledger},
        table::print_text,
    },
};

/// How long the operator waits until the file is taken back.
const TAKEN_BACK_TIMEOUT: Duration = Duration::from_secs(10);
/// Time between two looks.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// Says words, and waits for the files that are taken back for them.
pub fn say(common: &CommonArgs, words: &[OperatorWord], anyway: bool) -> Result<CommandExit> {
    let sentences = with_ledger(common, async |settings, ledger| say_all(settings, ledger, words, anyway).await)?;
    sentences.iter().try_for_each(|sentence| print_text(sentence))?;
    Ok(CommandExit::Success)
}

/// Runs `nestd close`.
pub fn run_close(common: &CommonArgs, orders: &[String]) -> Result<CommandExit> {
    say(common, &orders.iter().cloned().map(OperatorWord::CloseOrder).collect::<Vec<_>>(), false)
}

/// Says words with the ledger that is open, and returns what became of them.
pub async fn say_all(
    settings: &Settings,
    ledger: &Ledger,
    words: &[OperatorWord],
    anyway: bool,
) -> Result<Vec<String>> {
    let (mut sentences, mut noted) = (Vec::new(), Vec::new());
    for word in words {
        let answer = farm::operate(ledger, settings, word, &user_at_host(), anyway).await?;
        sentences.extend(answer.sentences);
        noted.extend(answer.noted);
    }
    for build in noted {
        sentences.push(match wait_for_take_back(ledger, build).await? {
            Some(_) => format!("`nestd show b{build}` says what became of build {build}."),
            None => format!(
                "The file is taken back as soon as the daemon can use the queue folder; `nestd show b{build}` says what became of it."
            ),
        });
    }
    Ok(sentences)
}

/// Waits until the file of a build is out of the queue, or is found to be gone. `None` = not yet.
pub async fn wait_for_take_back(ledger: &Ledger, id: BuildId) -> Result<Option<BuildRow>> {
    let until = Instant::now() + TAKEN_BACK_TIMEOUT;
    loop {
        let build = ledger.find_build(id).await?.with_context(|| format!("there is no build {id}"))?;
        if build.place.withdraw_by.is_none() || build.place.withdrawn_at.is_some() {
            return Ok(Some(build));
        }
        if Instant::now() >= until {
            return Ok(None);
        }
        tokio::time::sleep(POLL_INTERVAL).await;
    }
}
