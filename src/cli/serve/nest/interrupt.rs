//! Ctrl-C while a search runs: its best layout is still proved and written.

use anyhow::{Context, Result};
use nester::SearchBudget;
use tokio::signal::unix::{SignalKind, signal};

use crate::cli::terminal::table::print_to_stderr;

/// Exit code of a program that Ctrl-C has ended.
const INTERRUPTED: i32 = 130;

/// Ends the search of a budget on SIGINT or SIGTERM, and the program on a second one.
pub(super) fn end_on_signal(budget: &SearchBudget) -> Result<()> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().context("cannot start")?;
    let context = runtime.enter();
    let listen = |kind| signal(kind).context("listening to signals");
    let (mut interrupt, mut terminate) = (listen(SignalKind::interrupt())?, listen(SignalKind::terminate())?);
    drop(context);
    let budget = budget.clone();
    std::thread::spawn(move || {
        runtime.block_on(async {
            loop {
                tokio::select! { _ = interrupt.recv() => (), _ = terminate.recv() => () }
                if budget.is_cancelled() {
                    std::process::exit(INTERRUPTED);
                }
                budget.cancel();
                print_to_stderr("the search ends; what it has found is proved and written");
            }
        });
    });
    Ok(())
}
