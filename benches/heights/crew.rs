//! Searches side by side, each in a process of its own: its CPU seconds and its memory are then its own, too.

use std::{
    collections::VecDeque,
    process::{Command, Stdio},
    sync::{Mutex, mpsc},
};

use anyhow::{Context, Result, ensure};

use super::trial::{Finding, Trial};

/// Runs all trials, `jobs` at a time; each finding is told as soon as it is there, in the order in which they end.
pub fn run(trials: Vec<Trial>, jobs: usize, mut tell: impl FnMut(Finding) -> Result<()>) -> Result<()> {
    let waiting = Mutex::new(VecDeque::from(trials));
    let (send, found) = mpsc::channel();
    std::thread::scope(|scope| {
        for _ in 0..jobs.max(1) {
            let (send, waiting) = (send.clone(), &waiting);
            scope.spawn(move || {
                let next = || waiting.lock().expect("nobody panics with it").pop_front();
                while let Some(trial) = next() {
                    if send.send(in_a_process(&trial)).is_err() {
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

fn in_a_process(trial: &Trial) -> Result<Finding> {
    let text = serde_json::to_string(trial)?;
    let mut command = Command::new(std::env::current_exe()?);
    let out = command.arg("--trial").arg(&text).stderr(Stdio::inherit()).output()?;
    ensure!(out.status.success(), "{text} failed");
    serde_json::from_slice(&out.stdout).with_context(|| format!("what {text} told"))
}
