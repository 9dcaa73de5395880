//! Delivery to a command: a program of the operator gets the message. It runs without a shell, gets no part of the
//! message as an argument, and shares no pipe with the daemon on which it could block the daemon.

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

use super::EventMessage;

/// Interval of the checks whether the command has ended.
const LOOK_EVERY: Duration = Duration::from_millis(20);
/// Maximum kept length of its standard error, bytes.
const MAX_ERROR_OUTPUT_BYTES: u64 = 500;
/// Variables of the service manager that only the daemon may use; the command does not get them.
const DAEMON_ONLY_VARIABLES: [&str; 6] =
    ["NOTIFY_SOCKET", "WATCHDOG_PID", "WATCHDOG_USEC", "LISTEN_FDS", "LISTEN_PID", "LISTEN_FDNAMES"];

/// Runs the command with the message on standard input. The message counts as delivered only if the command ends with
/// exit code 0 in time.
pub(super) fn run_command(words: &[String], timeout: Duration, message: &EventMessage) -> Result<()> {
    let (program, args) = words.split_first().context("there is no command")?;
    let mut input = tempfile::tempfile().context("writing the message")?;
    input.write_all(message.body.as_bytes()).context("writing the message")?;
    input.seek(SeekFrom::Start(0)).context("writing the message")?;
    let mut complaint = tempfile::tempfile().context("making a file for complaints")?;
    let mut command = Command::new(program);
    command.args(args).stdin(input).stdout(Stdio::null());
    command.stderr(complaint.try_clone().context("making a file for complaints")?);
    for name in DAEMON_ONLY_VARIABLES {
        command.env_remove(name);
    }
    for (name, value) in command_environment(message) {
        command.env(name, value);
    }
    // Its own process group, so that its child processes are killed with it.
    let mut child = command.process_group(0).spawn().with_context(|| format!("starting {program}"))?;
    let ended = wait_with_timeout(&mut child, timeout);
    kill_process_group_of(&child);
    match ended {
        Some(status) if status.success() => Ok(()),
        Some(status) => bail!("{program} {}{}", describe_exit(status), read_error_output(&mut complaint)),
        None => {
            let killed = child.wait().with_context(|| format!("killing {program}"))?;
            ensure!(
                killed.success(),
                "{program} took longer than {timeout:?} and was killed{}",
                read_error_output(&mut complaint)
            );
            Ok(())
        }
    }
}

/// Variables that the command gets in addition to the daemon's environment.
fn command_environment(message: &EventMessage) -> Vec<(&'static str, String)> {
    let number = |of: Option<i64>| of.map(|number| number.to_string()).unwrap_or_default();
    vec![
        ("NESTD_ID", message.id.clone()),
        ("NESTD_EVENT", message.kind.word().to_owned()),
        ("NESTD_MACHINE", message.machine.clone()),
        ("NESTD_PART", number(message.part)),
        ("NESTD_BUILD", number(message.build)),
        // An environment variable cannot hold a zero byte.
        ("NESTD_TEXT", message.text.replace('\0', "")),
    ]
}

/// The exit status; `None` = the timeout passed first.
fn wait_with_timeout(child: &mut Child, timeout: Duration) -> Option<ExitStatus> {
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

/// Kills the command and all of its remaining child processes.
fn kill_process_group_of(child: &Child) {
    if let Some(group) = i32::try_from(child.id()).ok().and_then(Pid::from_raw) {
        // The call fails if the group is empty: all have ended.
        let _ = kill_process_group(group, Signal::KILL);
    }
}

fn describe_exit(status: ExitStatus) -> String {
    match (status.code(), status.signal()) {
        (Some(code), _) => format!("ended with exit code {code}"),
        (None, Some(signal)) => format!("was ended by signal {signal}"),
        (None, None) => "did not end".to_owned(),
    }
}

/// What the command wrote to standard error, on one line.
fn read_error_output(complaint: &mut File) -> String {
    let mut bytes = Vec::new();
    let read =
        complaint.seek(SeekFrom::Start(0)).and_then(|_| complaint.take(MAX_ERROR_OUTPUT_BYTES).read_to_end(&mut bytes));
    let text = String::from_utf8_lossy(&bytes);
    let text: String = text.trim().chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    if read.is_err() || text.is_empty() { String::new() } else { format!(": {text}") }
}
