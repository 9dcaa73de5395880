//! Reads a file in a separate process with a memory limit. If that process ends early, the file is refused and the farm
//! continues. This file has both sides: the daemon that asks and the process that reads.

use std::{
    fs,
    io::{BufReader, BufWriter, Read, Write},
    os::unix::process::{CommandExt, ExitStatusExt},
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
    sync::{
        Arc,
        mpsc::{self, RecvTimeoutError},
    },
    thread::{self, JoinHandle},
    time::Duration,
};

use anyhow::{Context, Result, ensure};
use build_file::{LengthUnit, PartFileContents, PartFileSolid, ReadLimits, SolidRequest};
use glam::DVec3;
use ledger::RefusalCause;
use rustix::process::{Pid, Resource, Rlimit, Signal};
use serde::{Deserialize, Serialize};
use solids::Mesh;

use crate::alerts::failure::PartReadError;

/// A file is read this many times inside the daemon; further attempts use a separate process.
pub const READS_IN_THE_DAEMON: u32 = 2;
/// The hidden subcommand that reads a part.
pub const SUBCOMMAND: &str = "read-part";
/// This program, even if its file was replaced after the start.
const SELF: &str = "/proc/self/exe";
/// How long the process may take. Within its memory no file takes nearly as long.
const READ_TIMEOUT: Duration = Duration::from_secs(1800);
/// Signals that a person or the service manager sends to end a process: they say nothing about the file.
const STOP_SIGNALS: [Signal; 3] = [Signal::TERM, Signal::INT, Signal::HUP];

/// A request to read a file.
#[derive(Debug, Serialize, Deserialize)]
pub struct PartReadRequest {
    /// Path of the file.
    pub file: PathBuf,
    /// Name of the file when it was dropped.
    pub name: String,
    /// Unit given in the ticket.
    pub unit: Option<LengthUnit>,
    /// Unit of a file that states none: that of the part's row, or its machine's if it is read for the first time.
    pub fixed_unit: LengthUnit,
    /// Limits of the readers.
    pub limits: ReadLimits,
}

/// The response of the process; the numbers of the meshes follow it.
#[derive(Debug, Serialize, Deserialize)]
enum PartReadResponse {
    Read { warnings: Vec<String>, solids: Vec<SolidHeader> },
    Refused(RefusalCause, String),
    Later(String),
}

/// A solid without its mesh.
#[derive(Debug, Serialize, Deserialize)]
struct SolidHeader {
    name: String,
    copies: u32,
    warnings: Vec<String>,
    question: Option<String>,
    coordinate_step_mm: f64,
    #[serde(default)]
    request: Option<Box<SolidRequest>>,
    vertices: usize,
    triangles: usize,
}

impl PartReadRequest {
    /// Reads the file in this process.
    pub fn read_in_process(&self) -> Result<PartFileContents, PartReadError> {
        build_file::read_part_file(&self.file, &self.name, self.unit, self.fixed_unit, &self.limits)
            .map_err(|error| PartReadError::from_read_error(&self.name, &error))
    }

    /// Reads the file in a separate process.
    pub fn read_isolated(&self) -> Result<PartFileContents, PartReadError> {
        let later =
            |failure: anyhow::Error| PartReadError::TryLater(format!("reading {} alone: {failure:#}", self.name));
        let mut child = self.start_reader().map_err(later)?;
        let limit = TimeLimit::start(&child, READ_TIMEOUT);
        let answer = self.receive_response(&mut child);
        // The process cannot end while output that nobody read blocks it.
        drop(child.stdout.take());
        let status = child.wait().context("waiting for it").map_err(later)?;
        if limit.has_ended() {
            return Err(self.refusal_after_timeout());
        }
        match answer {
            Ok(answer) if status.success() => answer,
            _ if status.signal().is_some_and(|signal| STOP_SIGNALS.iter().any(|stop| stop.as_raw() == signal)) => Err(
                PartReadError::TryLater(format!("reading {} in a separate process was ended from outside", self.name)),
            ),
            Err(failure) if status.success() => Err(later(failure)),
            _ => Err(self.refusal_after_crash(status)),
        }
    }

    fn start_reader(&self) -> Result<Child> {
        let mut command = Command::new(SELF);
        // No variable of the daemon's environment: the process must not talk to the service manager as the daemon.
        command.arg0("nestd").arg(SUBCOMMAND).env_clear();
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn()?;
        let asked = serde_json::to_vec(self)?;
        if let Some(mut stdin) = child.stdin.take() {
            // If the process has ended already, its exit status says why.
            let _ = stdin.write_all(&asked);
        }
        Ok(child)
    }

    fn receive_response(&self, child: &mut Child) -> Result<Result<PartFileContents, PartReadError>> {
        let mut from = BufReader::new(child.stdout.as_mut().context("it has no output")?);
        let mut length = [0; 8];
        from.read_exact(&mut length)?;
        // Room is made for what comes, not for what is announced.
        let (length, mut head) = (u64::from_le_bytes(length), Vec::new());
        from.by_ref().take(length).read_to_end(&mut head)?;
        ensure!(head.len() as u64 == length, "its answer is cut");
        let (warnings, heads) = match serde_json::from_slice(&head)? {
            PartReadResponse::Read { warnings, solids } => (warnings, solids),
            PartReadResponse::Refused(cause, reason) => return Ok(Err(PartReadError::Refused(cause, reason))),
            PartReadResponse::Later(why) => return Ok(Err(PartReadError::TryLater(why))),
        };
        let solids = heads.into_iter().map(|head| receive_solid(head, &mut from)).collect::<Result<_>>()?;
        Ok(Ok(PartFileContents { solids, warnings }))
    }

    fn refusal_after_timeout(&self) -> PartReadError {
        let reason = format!(
            "{}: reading it ended nestd twice, and then a separate process had not read it after {} minutes. Export it with fewer \
             triangles or pieces and drop it again.",
            self.name,
            READ_TIMEOUT.as_secs() / 60
        );
        PartReadError::Refused(RefusalCause::Limit, reason)
    }

    fn refusal_after_crash(&self, status: ExitStatus) -> PartReadError {
        let how = match (status.signal(), status.code()) {
            (Some(signal), _) => format!("by signal {signal}"),
            (None, code) => format!("with exit code {}", code.unwrap_or_default()),
        };
        let reason = format!(
            "{}: reading it ended nestd twice, and then a separate process with {} bytes of memory \
             (limits.read_memory_bytes) ended {how}. Export it with fewer triangles or pieces and drop it again, or \
             raise that limit and take it back.",
            self.name, self.limits.read_memory_bytes
        );
        PartReadError::Refused(RefusalCause::Limit, reason)
    }
}

/// Ends a process that takes too long.
struct TimeLimit {
    /// Dropped when the process was waited for.
    waited_for: mpsc::Sender<()>,
    watch: JoinHandle<bool>,
}

impl TimeLimit {
    fn start(child: &Child, limit: Duration) -> Self {
        let (waited_for, is_done) = mpsc::channel();
        let process = Pid::from_child(child);
        let watch = thread::spawn(move || {
            let is_late = is_done.recv_timeout(limit) == Err(RecvTimeoutError::Timeout);
            // Nobody has waited for it yet, so the number is still its own.
            is_late && rustix::process::kill_process(process, Signal::KILL).is_ok()
        });
        Self { waited_for, watch }
    }

    /// Whether the process took too long and was ended. Call it once its end is known.
    fn has_ended(self) -> bool {
        drop(self.waited_for);
        self.watch.join().unwrap_or(false)
    }
}

fn receive_solid(head: SolidHeader, from: &mut impl Read) -> Result<PartFileSolid> {
    let mut vertices = Vec::with_capacity(head.vertices);
    let mut place = [[0; 8]; 3];
    for _ in 0..head.vertices {
        place.iter_mut().try_for_each(|number| from.read_exact(number))?;
        vertices.push(DVec3::from_array(place.map(f64::from_le_bytes)));
    }
    let mut triangles = Vec::with_capacity(head.triangles);
    let mut corners = [[0; 4]; 3];
    for _ in 0..head.triangles {
        corners.iter_mut().try_for_each(|number| from.read_exact(number))?;
        triangles.push(corners.map(u32::from_le_bytes));
    }
    let mesh = Arc::new(Mesh::new(vertices, triangles)?);
    Ok(PartFileSolid {
        name: head.name,
        mesh,
        copies: head.copies,
        warnings: head.warnings,
        question: head.question,
        coordinate_step_mm: head.coordinate_step_mm,
        request: head.request,
    })
}

/// Runs in the separate process: reads the request from `asked`, reads the file, and writes the response.
pub fn answer_read_request(asked: impl Read, answer: impl Write) -> Result<()> {
    let errand: PartReadRequest = serde_json::from_reader(asked).context("taking in what to read")?;
    limit_own_process(errand.limits.read_memory_bytes);
    let mut answer = BufWriter::with_capacity(1 << 16, answer);
    let (head, solids) = match errand.read_in_process() {
        Ok(PartFileContents { solids, warnings }) => {
            (PartReadResponse::Read { warnings, solids: solids.iter().map(solid_header).collect() }, solids)
        }
        Err(PartReadError::Refused(cause, reason)) => (PartReadResponse::Refused(cause, reason), Vec::new()),
        Err(PartReadError::TryLater(why)) => (PartReadResponse::Later(why), Vec::new()),
    };
    let head = serde_json::to_vec(&head)?;
    answer.write_all(&(head.len() as u64).to_le_bytes())?;
    answer.write_all(&head)?;
    for solid in &solids {
        for vertex in solid.mesh.vertices() {
            vertex.to_array().iter().try_for_each(|v| answer.write_all(&v.to_le_bytes()))?;
        }
        for corners in solid.mesh.triangles() {
            corners.iter().try_for_each(|v| answer.write_all(&v.to_le_bytes()))?;
        }
    }
    Ok(answer.flush()?)
}

fn solid_header(solid: &PartFileSolid) -> SolidHeader {
    SolidHeader {
        name: solid.name.clone(),
        copies: solid.copies,
        warnings: solid.warnings.clone(),
        question: solid.question.clone(),
        coordinate_step_mm: solid.coordinate_step_mm,
        request: solid.request.clone(),
        vertices: solid.mesh.vertices().len(),
        triangles: solid.mesh.triangles().len(),
    }
}

/// Limits the memory of this process, ends it with the daemon, and lets the kernel kill it first when memory is short.
/// If the system allows none of this, the file is still read outside the daemon.
fn limit_own_process(memory_bytes: u64) {
    let most = rustix::process::getrlimit(Resource::As);
    let wanted = [most.current, most.maximum].into_iter().flatten().fold(memory_bytes, u64::min);
    let _ = rustix::process::setrlimit(Resource::As, Rlimit { current: Some(wanted), maximum: most.maximum });
    let _ = rustix::process::set_parent_process_death_signal(Some(Signal::KILL));
    let _ = fs::write(Path::new("/proc/self/oom_score_adj"), "1000");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_process_that_takes_too_long_is_ended_and_one_that_does_not_is_left_alone() {
        for (secs, millis, is_late) in [("60", 100, true), ("0", 60_000, false)] {
            let mut child = Command::new("sleep").arg(secs).spawn().unwrap();
            let limit = TimeLimit::start(&child, Duration::from_millis(millis));
            let status = child.wait().unwrap();
            assert_eq!((limit.has_ended(), status.success()), (is_late, !is_late));
        }
    }
}
