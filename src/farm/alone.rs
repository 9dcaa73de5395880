//! Reading a file in a process of its own, which may take so much memory and no more: a file on which that process ends is
//! refused, and the farm goes on. Both sides of it are here: who asks, and the process that reads.

use std::{
    fs,
    io::{BufReader, BufWriter, Read, Write},
    os::unix::process::{CommandExt, ExitStatusExt},
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
};

use anyhow::{Context, Result, ensure};
use build_file::{Contents, Limits, Solid, Unit};
use glam::DVec3;
use rustix::process::{Resource, Rlimit, Signal};
use serde::{Deserialize, Serialize};
use solids::Mesh;

use super::failure::Unread;
use crate::ledger::Refusal;

/// The hidden subcommand that reads.
pub const SUBCOMMAND: &str = "read-part";
/// This program, also when its file was replaced since it was started.
const SELF: &str = "/proc/self/exe";
/// Signals by which a person or the service manager ends a process: they say nothing of the file.
const STOPPED: [Signal; 3] = [Signal::TERM, Signal::INT, Signal::HUP];

/// What to read.
#[derive(Debug, Serialize, Deserialize)]
pub struct Errand {
    /// Where the file lies.
    pub file: PathBuf,
    /// The name that it was dropped under.
    pub name: String,
    /// The unit that its ticket says.
    pub unit: Option<Unit>,
    /// The profile's unit.
    pub default_unit: Unit,
    /// Limits of the readers.
    pub limits: Limits,
}

/// What the process answers; the numbers of the meshes follow.
#[derive(Debug, Serialize, Deserialize)]
enum Answer {
    Read { warnings: Vec<String>, solids: Vec<Head> },
    Refused(Refusal, String),
    Later(String),
}

/// A solid without its mesh.
#[derive(Debug, Serialize, Deserialize)]
struct Head {
    name: String,
    copies: u32,
    warnings: Vec<String>,
    vertices: usize,
    triangles: usize,
}

impl Errand {
    /// Reads here, in this process.
    pub fn read(&self) -> Result<Contents, Unread> {
        build_file::read(&self.file, &self.name, self.unit, self.default_unit, &self.limits)
            .map_err(|error| Unread::of(&self.name, &error))
    }

    /// Reads in a process of its own.
    pub fn read_alone(&self) -> Result<Contents, Unread> {
        let later = |failure: anyhow::Error| Unread::Later(format!("reading {} alone: {failure:#}", self.name));
        let mut child = self.start().map_err(later)?;
        let answer = self.answer(&mut child);
        // What was not taken in keeps it from ending.
        drop(child.stdout.take());
        let status = child.wait().context("waiting for it").map_err(later)?;
        match answer {
            Ok(answer) if status.success() => answer,
            _ if status.signal().is_some_and(|signal| STOPPED.iter().any(|stop| stop.as_raw() == signal)) => {
                Err(Unread::Later(format!("reading {} alone was ended by hand", self.name)))
            }
            Err(failure) if status.success() => Err(later(failure)),
            _ => Err(self.refused(status)),
        }
    }

    fn start(&self) -> Result<Child> {
        let mut command = Command::new(SELF);
        // Nothing of the daemon's environment: it must not speak for the daemon.
        command.arg0("nestd").arg(SUBCOMMAND).env_clear();
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn()?;
        let asked = serde_json::to_vec(self)?;
        if let Some(mut stdin) = child.stdin.take() {
            // One that has ended already is told by its status.
            let _ = stdin.write_all(&asked);
        }
        Ok(child)
    }

    fn answer(&self, child: &mut Child) -> Result<Result<Contents, Unread>> {
        let mut from = BufReader::new(child.stdout.as_mut().context("it has no output")?);
        let mut length = [0; 8];
        from.read_exact(&mut length)?;
        // Room is made for what comes, not for what is announced.
        let (length, mut head) = (u64::from_le_bytes(length), Vec::new());
        from.by_ref().take(length).read_to_end(&mut head)?;
        ensure!(head.len() as u64 == length, "its answer is cut");
        let (warnings, heads) = match serde_json::from_slice(&head)? {
            Answer::Read { warnings, solids } => (warnings, solids),
            Answer::Refused(cause, reason) => return Ok(Err(Unread::Refused(cause, reason))),
            Answer::Later(why) => return Ok(Err(Unread::Later(why))),
        };
        let solids = heads.into_iter().map(|head| take_in(head, &mut from)).collect::<Result<_>>()?;
        Ok(Ok(Contents { solids, warnings }))
    }

    fn refused(&self, status: ExitStatus) -> Unread {
        let how = match (status.signal(), status.code()) {
            (Some(signal), _) => format!("by signal {signal}"),
            (None, code) => format!("with exit code {}", code.unwrap_or_default()),
        };
        let reason = format!(
            "{}: reading it ended nestd twice, and then, alone and with {} bytes of memory (limits.read_memory_bytes), a process \
             of its own {how}. Export it with fewer triangles or pieces and drop it again, or let it have more memory and take it \
             back.",
            self.name, self.limits.read_memory_bytes
        );
        Unread::Refused(Refusal::Limit, reason)
    }
}

fn take_in(head: Head, from: &mut impl Read) -> Result<Solid> {
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
    let mesh = Mesh::new(vertices, triangles)?;
    Ok(Solid { name: head.name, mesh, copies: head.copies, warnings: head.warnings })
}

/// The process of its own: reads what `asked` says and answers.
pub fn read_for_the_farm(asked: impl Read, answer: impl Write) -> Result<()> {
    let errand: Errand = serde_json::from_reader(asked).context("taking in what to read")?;
    be_little(errand.limits.read_memory_bytes);
    let mut answer = BufWriter::with_capacity(1 << 16, answer);
    let (head, solids) = match errand.read() {
        Ok(Contents { solids, warnings }) => {
            (Answer::Read { warnings, solids: solids.iter().map(head_of).collect() }, solids)
        }
        Err(Unread::Refused(cause, reason)) => (Answer::Refused(cause, reason), Vec::new()),
        Err(Unread::Later(why)) => (Answer::Later(why), Vec::new()),
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

fn head_of(solid: &Solid) -> Head {
    Head {
        name: solid.name.clone(),
        copies: solid.copies,
        warnings: solid.warnings.clone(),
        vertices: solid.mesh.vertices().len(),
        triangles: solid.mesh.triangles().len(),
    }
}

/// Takes so much memory and no more, ends with the daemon, and is the first to go where memory is short. Where the system
/// allows none of it, it is still another process than the daemon.
fn be_little(memory_bytes: u64) {
    let most = rustix::process::getrlimit(Resource::As);
    let wanted = [most.current, most.maximum].into_iter().flatten().fold(memory_bytes, u64::min);
    let _ = rustix::process::setrlimit(Resource::As, Rlimit { current: Some(wanted), maximum: most.maximum });
    let _ = rustix::process::set_parent_process_death_signal(Some(Signal::KILL));
    let _ = fs::write(Path::new("/proc/self/oom_score_adj"), "1000");
}
