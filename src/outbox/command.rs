//! The command: a program of the operator's own is given the message. It gets no shell, no part of the message as an argument,
//! and no pipe of ours that it could hang us with.

use std::{
    fs::File,
    io::{Read, Seek, SeekFrom, Write},
    os::unix::process::{CommandExt, ExitStatusExt},
    process::{Child, Command, ExitStatus, Stdio},
    thread,
    time::{Duration, Instant},
};

use anyhow::{Context, Result, bail, ensure};
use rustix::process::{Pid, Signal, kill_process_group};

use super::Message;

/// Between two looks at whether it has ended.
const LOOK_EVERY: Duration = Duration::from_millis(20);
/// What is kept of its complaints, bytes.
const MOST_COMPLAINT: u64 = 500;
/// What speaks for the daemon is not the command's.
const NOT_ITS: [&str; 6] =
    ["NOTIFY_SOCKET", "WATCHDOG_PID", "WATCHDOG_USEC", "LISTEN_FDS", "LISTEN_PID", "LISTEN_FDNAMES"];

/// Runs the command with the message on its standard input; whatever does not end with exit code 0 in time has not been told.
pub(super) fn run(words: &[String], timeout: Duration, message: &Message) -> Result<()> {
    let (program, args) = words.split_first().context("there is no command")?;
    let mut input = tempfile::tempfile().context("writing the message")?;
    input.write_all(message.body.as_bytes()).context("writing the message")?;
    input.seek(SeekFrom::Start(0)).context("writing the message")?;
    let mut complaint = tempfile::tempfile().context("making a file for complaints")?;
    let mut command = Command::new(program);
    command.args(args).stdin(input).stdout(Stdio::null());
    command.stderr(complaint.try_clone().context("making a file for complaints")?);
    for name in NOT_ITS {
        command.env_remove(name);
    }
    for (name, value) in environment(message) {
        command.env(name, value);
    }
    // A group of its own, so that what it has started is ended with it.
    let mut child = command.process_group(0).spawn().with_context(|| format!("starting {program}"))?;
    let ended = wait(&mut child, timeout);
    end_all(&child);
    match ended {
        Some(status) if status.success() => Ok(()),
        Some(status) => bail!("{program} {}{}", how(status), said(&mut complaint)),
        None => {
            let killed = child.wait().with_context(|| format!("killing {program}"))?;
            ensure!(killed.success(), "{program} took longer than {timeout:?} and was killed{}", said(&mut complaint));
            Ok(())
        }
    }
}

/// What the command finds in its environment beside what the daemon has.
fn environment(message: &Message) -> Vec<(&'static str, String)> {
    let number = |of: Option<i64>| of.map(|number| number.to_string()).unwrap_or_default();
    vec![
        ("NESTD_ID", message.id.clone()),
        ("NESTD_EVENT", message.kind.to_owned()),
        ("NESTD_PROFILE", message.profile.clone()),
        ("NESTD_PART", number(message.part)),
        ("NESTD_BUILD", number(message.build)),
        // No environment holds a zero byte.
        ("NESTD_TEXT", message.text.replace('\0', "")),
    ]
}

/// How it ended; `None` when the time is over before.
fn wait(child: &mut Child, timeout: Duration) -> Option<ExitStatus> {
    let until = Instant::now() + timeout;
    loop {
        if let Ok(Some(status)) = child.try_wait() {
            return Some(status);
        }
        if Instant::now() >= until {
            return None;
        }
        thread::sleep(LOOK_EVERY);
    }
}

/// Ends the command and all that it has started and left behind.
fn end_all(child: &Child) {
    if let Some(group) = i32::try_from(child.id()).ok().and_then(Pid::from_raw) {
        // An empty group has ended by itself.
        let _ = kill_process_group(group, Signal::KILL);
    }
}

fn how(status: ExitStatus) -> String {
    match (status.code(), status.signal()) {
        (Some(code), _) => format!("ended with exit code {code}"),
        (None, Some(signal)) => format!("was ended by signal {signal}"),
        (None, None) => "did not end".to_owned(),
    }
}

/// What it complained of, in one line.
fn said(complaint: &mut File) -> String {
    let mut bytes = Vec::new();
    let read = complaint.seek(SeekFrom::Start(0)).and_then(|_| complaint.take(MOST_COMPLAINT).read_to_end(&mut bytes));
    let text = String::from_utf8_lossy(&bytes);
    let text: String = text.trim().chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    if read.is_err() || text.is_empty() { String::new() } else { format!(": {text}") }
}
