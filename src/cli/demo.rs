//! `nestd demo`: a small farm with sample parts, the real daemon on it, and what comes out.

mod daemon;
mod farm;

use std::{
    fs,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use anyhow::{Context, Result, bail};
use build_file::counted;

use self::{
    daemon::{Daemon, nestd},
    farm::{DemoFarm, Dropped, PROFILE, TORN},
};
use super::{Common, Exit, Usage};
use crate::ledger::{Ledger, PartRow, PartState, ProfileStatus, PublishedBuild};

/// The demo gives up after so long; it takes about twenty seconds on an idle machine.
const PATIENCE_SECS: u64 = 150;
/// How often the ledger is looked at.
const POLL: Duration = Duration::from_millis(250);

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of the demo's farm: a new or empty one, or that of an earlier demo. Nothing in it is deleted
    #[arg(long, value_name = "DIR", default_value = "nestd-demo")]
    pub dir: PathBuf,
}

/// Runs the command.
pub fn run(common: &Common, args: &Args) -> Result<Exit> {
    if common.config.is_some() {
        return Err(Usage("the demo writes a configuration of its own; leave out -c".to_owned()).into());
    }
    let farm = DemoFarm::prepare(&args.dir)?;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    match runtime.block_on(play(&farm)) {
        Ok(()) => Ok(Exit::Success),
        Err(error) if error.is::<Usage>() => Err(error),
        Err(error) => {
            eprintln!("nestd: the demo failed: {error:#}\n\nThe end of {}:", farm.log().display());
            eprintln!("{}", Daemon::log_tail(&farm.log()));
            Ok(Exit::Failure)
        }
    }
}

/// The whole demo.
async fn play(farm: &DemoFarm) -> Result<()> {
    expect_no_daemon(farm).await?;
    println!("A farm for a try-out in {}", farm.root.display());
    let mut daemon = Daemon::start(&farm.config(), &farm.root, &farm.log())?;
    println!("The daemon runs (process {}, log {}).", daemon.pid(), farm.log().display());
    let mut watch = Watch::begin(farm, &mut daemon).await?;
    let dropped = farm.drop_parts()?;
    println!("Dropped {} into {}.", counted(dropped.files, "file", "files"), farm.folder("inbox").display());

    watch.until_all_are_read(dropped).await?;
    watch.until_all_are_built(farm).await?;
    show(farm, &watch).await?;
    watch.ledger.close().await;
    daemon.stop()?;
    println!("\nThe daemon has stopped. Start it again and drop parts of your own into its hot folder:");
    let program = std::env::current_exe().context("cannot find this program")?;
    println!("  {} run{} -c {}", program.display(), as_root(), farm.config().display());
    println!("  {}", farm.folder("inbox").display());
    Ok(())
}

/// What root, as in a container, must say to run a daemon by hand.
fn as_root() -> &'static str {
    if rustix::process::geteuid().is_root() { " --allow-root" } else { "" }
}

/// Two daemons on one farm would hinder each other.
async fn expect_no_daemon(farm: &DemoFarm) -> Result<()> {
    if !farm.ledger().exists() {
        return Ok(());
    }
    let ledger = Ledger::open_existing(&farm.ledger()).await?;
    let served_by = ledger.daemon().await?.filter(|d| d.alive);
    ledger.close().await;
    match served_by {
        Some(daemon) => Err(Usage(format!("a daemon serves this farm already (process {})", daemon.pid)).into()),
        None => Ok(()),
    }
}

/// What the demo waits for, seen through the ledger as an operator sees it.
struct Watch<'d> {
    ledger: Ledger,
    daemon: &'d mut Daemon,
    deadline: Instant,
    /// Parts up to this number are from an earlier demo.
    last_part: i64,
    /// The last build that an earlier demo published.
    last_build: Option<i64>,
    told: String,
}

impl<'d> Watch<'d> {
    /// Waits for the daemon's ledger and its first sign of life.
    async fn begin(farm: &DemoFarm, daemon: &'d mut Daemon) -> Result<Self> {
        let deadline = Instant::now() + Duration::from_secs(PATIENCE_SECS);
        let pid = daemon.pid();
        loop {
            if farm.ledger().exists()
                && let Ok(ledger) = Ledger::open_existing(&farm.ledger()).await
            {
                if ledger.daemon().await.ok().flatten().is_some_and(|d| d.pid == pid) {
                    let mut watch =
                        Self { ledger, daemon, deadline, last_part: 0, last_build: None, told: String::new() };
                    watch.last_part = watch.new_parts().await?.iter().map(|p| p.id.0).max().unwrap_or(0);
                    watch.last_build = watch.published().await?.map(|b| b.build.0);
                    return Ok(watch);
                }
                ledger.close().await;
            }
            daemon.expect_running()?;
            if Instant::now() > deadline {
                bail!("the daemon gave no sign of life");
            }
            tokio::time::sleep(POLL).await;
        }
    }

    async fn new_parts(&self) -> Result<Vec<PartRow>> {
        let mut parts = Vec::new();
        for state in PartState::ALL {
            parts.extend(self.ledger.parts_in_state(state).await?);
        }
        parts.retain(|p| p.id.0 > self.last_part);
        Ok(parts)
    }

    async fn status(&self) -> Result<Option<ProfileStatus>> {
        Ok(self.ledger.status().await?.into_iter().find(|s| s.profile == PROFILE))
    }

    /// The build that was published last, unless it is from an earlier demo.
    async fn published(&self) -> Result<Option<PublishedBuild>> {
        let last = self.status().await?.and_then(|s| s.last_published);
        Ok(last.filter(|b| Some(b.build.0) != self.last_build))
    }

    /// Waits a little, and says what waits when that has changed.
    async fn tick(&mut self, for_what: &str) -> Result<()> {
        self.daemon.expect_running()?;
        if Instant::now() > self.deadline {
            bail!("waited {PATIENCE_SECS} s in vain for {for_what}");
        }
        if let Some(status) = self.status().await? {
            let line = in_words(&status);
            if line != self.told {
                println!("  {line}");
                self.told = line;
            }
        }
        tokio::time::sleep(POLL).await;
        Ok(())
    }

    /// Until every dropped file waits or is refused.
    async fn until_all_are_read(&mut self, dropped: Dropped) -> Result<()> {
        loop {
            let parts = self.new_parts().await?;
            let claimed = parts.iter().filter(|p| p.state == PartState::Claimed).count();
            if parts.len() >= dropped.files && claimed == 0 {
                let refused = parts.iter().filter(|p| p.state == PartState::Rejected).count();
                if refused != dropped.torn {
                    bail!("{refused} parts were refused instead of {}", dropped.torn);
                }
                return Ok(());
            }
            self.tick("the parts to be read").await?;
        }
    }

    /// Orders what waits to be published, as an operator does, until nothing waits any more.
    async fn until_all_are_built(&mut self, farm: &DemoFarm) -> Result<()> {
        let mut flushed_after = None;
        loop {
            let is_done = |p: &PartRow| matches!(p.state, PartState::Built | PartState::Rejected);
            if self.new_parts().await?.iter().all(is_done) {
                return Ok(());
            }
            let published = self.published().await?.map(|b| b.build.0);
            let nesting = self.status().await?.is_some_and(|s| !s.nesting.is_empty());
            // Once, and again after a build that had no room for all.
            if !nesting && flushed_after != Some(published) {
                flushed_after = Some(published);
                // A daemon that is too busy to answer at once still does it: the build is waited for.
                if operate(farm, &["flush", PROFILE]).is_err() {
                    self.daemon.expect_running()?;
                }
            }
            self.tick("the build").await?;
        }
    }
}

fn in_words(status: &ProfileStatus) -> String {
    if let Some(build) = status.nesting.first() {
        return format!("build {}: {}, {}", build.build.0, counted(build.copies, "copy", "copies"), build.state);
    }
    let forecast = (status.open.as_ref().and_then(|o| o.height_mm))
        .map_or(String::new(), |height_mm| format!("; the open build is {height_mm:.1} mm high"));
    let (parts, copies) = (status.waiting_parts, status.waiting_copies);
    format!(
        "{}, {}; {} refused{forecast}",
        counted(parts, "part waits", "parts wait"),
        counted(copies, "copy", "copies"),
        status.rejected_parts
    )
}

/// Runs a command as an operator would, shown with its output.
fn operate(farm: &DemoFarm, arguments: &[&str]) -> Result<()> {
    println!("\n$ nestd {} -c {}", arguments.join(" "), farm.config().display());
    let status = nestd(&farm.config(), &farm.root)?.args(arguments).status();
    let status = status.with_context(|| format!("cannot run nestd {}", arguments.join(" ")))?;
    if !status.success() {
        bail!("nestd {} failed ({status})", arguments.join(" "));
    }
    Ok(())
}

/// Status, history, the refusal and where to look.
async fn show(farm: &DemoFarm, watch: &Watch<'_>) -> Result<()> {
    let build = watch.published().await?.context("no build was published")?;
    operate(farm, &["status"])?;
    operate(farm, &["history", "--limit", "5"])?;
    println!("\nRefused, each file in {} with its reason beside it:", farm.folder("error").display());
    for part in watch.new_parts().await?.iter().filter(|p| p.state == PartState::Rejected) {
        println!("  {}: {}", part.name, part.reason);
    }
    if files_of(&farm.folder("error"), |name| name.starts_with(TORN) && name.ends_with(".reason.txt"))?.is_empty() {
        bail!("{TORN} was refused without a reason file");
    }
    let name = build.file_name.context("the build has no file")?;
    let stem = name.trim_end_matches(".build.3mf").to_owned();
    let made = files_of(&farm.folder("queue"), |file| file.starts_with(&stem))?;
    if !made.iter().any(|file| file.ends_with(&name)) {
        bail!("{name} is not in {}", farm.folder("queue").display());
    }
    println!("\nIn the printer's queue:");
    made.iter().for_each(|file| println!("  {}", file.display()));
    println!("The ledger, for sqlite3 (try: select * from v_build_history):\n  {}", farm.ledger().display());
    Ok(())
}

/// The files of a folder whose names are wanted, in order.
fn files_of(folder: &Path, wanted: impl Fn(&str) -> bool) -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder).with_context(|| format!("cannot look into {}", folder.display()))?;
    let mut files: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.retain(|file| file.file_name().is_some_and(|name| wanted(&name.to_string_lossy())));
    files.sort();
    Ok(files)
}

#[cfg(test)]
mod tests;
