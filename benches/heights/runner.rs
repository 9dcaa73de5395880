//! Runs searches in parallel, each in a separate process, so that CPU seconds and memory can be measured for each.

use std::{
    collections::VecDeque,
    process::{Command, Stdio},
    sync::{Mutex, mpsc},
};

use anyhow::{Context, Result, ensure};

use super::trial::{SearchFinding, SearchTrial};

/// Runs all trials, `jobs` at a time. Reports each finding as soon as its trial ends.
pub fn run_trials(
    trials: Vec<SearchTrial>,
    jobs: usize,
    mut tell: impl FnMut(SearchFinding) -> Result<()>,
) -> Result<()> {
    let waiting = Mutex::new(VecDeque::from(trials));
    let (send, found) = mpsc::channel();
    std::thread::scope(|scope| {
        for _ in 0..jobs.max(1) {
            let (send, waiting) = (send.clone(), &waiting);
            scope.spawn(move || {
                let next = || waiting.lock().expect("nobody panics with it").pop_front();
                while let Some(trial) = next() {
                    if send.send(run_in_process(&trial)).is_err() {
                        break;
                    }
                }
            });
        }
        drop(send);
        let told = found.iter().try_for_each(|finding| tell(finding?));
        if told.is_err() {
            waiting.lock().expect("nobody panics with it").clear();
        }
        told
    })
}

fn run_in_process(trial: &SearchTrial) -> Result<SearchFinding> {
    let text = serde_json::to_string(trial)?;
    let mut command = Command::new(std::env::current_exe()?);
    let out = command.arg("--trial").arg(&text).stderr(Stdio::inherit()).output()?;
    ensure!(out.status.success(), "{text} failed");
    serde_json::from_slice(&out.stdout).with_context(|| format!("what {text} told"))
}
