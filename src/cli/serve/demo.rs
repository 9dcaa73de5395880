//! `nestd demo`: makes a small farm with sample parts, runs the real daemon on it and shows the results.

mod daemon;
mod farm;

use std::{
    fs,
    io::IsTerminal,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use anyhow::{Context, Result, bail};
use build_file::format_count;
use ledger::{Ledger, MachineStatus, PartRow, PartState, PublishedBuild};

use self::{
    daemon::{DemoDaemon, nestd_command},
    farm::{DemoFarm, DroppedFiles, MACHINE, TORN_FILE},
};
use crate::cli::{CommandExit, CommonArgs, UsageError};

/// The demo fails after this time; it takes about twenty seconds on an idle machine.
const TIMEOUT_SECS: u64 = 150;
/// Time between two reads of the ledger.
const POLL_INTERVAL: Duration = Duration::from_millis(250);

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct DemoArgs {
    /// Folder of the demo's farm: a new or empty one, or that of an earlier demo. Nothing in it is deleted
    #[arg(long, value_name = "DIR", default_value = "nestd-demo")]
    pub dir: PathBuf,
    /// Serve the farm until Ctrl-C once it is shown, also where no person sits at a terminal
    #[arg(long)]
    pub stay: bool,
}

/// Runs the command.
pub fn run(common: &CommonArgs, args: &DemoArgs) -> Result<CommandExit> {
    if common.config.is_some() {
        return Err(UsageError("the demo writes a configuration of its own; leave out -c".to_owned()).into());
    }
    let farm = DemoFarm::open_or_make(&args.dir)?;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    match runtime.block_on(play_demo(&farm, args.stay || is_at_terminal())) {
        Ok(()) => Ok(CommandExit::Success),
        Err(error) if error.is::<UsageError>() => Err(error),
        Err(error) => {
            eprintln!("nestd: the demo failed: {error:#}\n\nThe end of {}:", farm.log_file().display());
            eprintln!("{}", DemoDaemon::log_tail(&farm.log_file()));
            Ok(CommandExit::Failure)
        }
    }
}

/// Whether a person reads what is printed, and can end it.
fn is_at_terminal() -> bool {
    std::io::stdin().is_terminal() && std::io::stdout().is_terminal()
}

/// Runs the whole demo. If it stays, the daemon runs on until somebody ends it.
async fn play_demo(farm: &DemoFarm, stays: bool) -> Result<()> {
    expect_no_daemon(farm).await?;
    println!("A demo farm in {}", farm.root.display());
    let mut daemon = DemoDaemon::start(&farm.config_file(), &farm.root, &farm.log_file())?;
    println!("The daemon runs (process {}, log {}).", daemon.process_id(), farm.log_file().display());
    if let Some(page) = farm.page() {
        println!("Its page, as long as it runs: {page}");
    }
    let mut watch = DemoWatcher::wait_for_daemon(farm, &mut daemon).await?;
    let dropped = farm.drop_parts()?;
    println!(
        "Dropped {} into {}.",
        format_count(dropped.files, "file", "files"),
        farm.machine_folder("inbox").display()
    );

    watch.until_all_are_read(dropped).await?;
    watch.until_all_are_built(farm).await?;
    show_results(farm, &watch).await?;
    watch.ledger.close().await;
    if stays {
        println!("\nThe farm runs until you press Ctrl-C. Drop parts of your own on its page, or into its hot folder:");
        print_places(farm);
        daemon.run_until_stopped().await?;
    }
    daemon.stop()?;
    println!(
        "\nThe daemon has stopped. Start it again, look at its page, and drop parts of your own there or into its hot folder:"
    );
    let program = std::env::current_exe().context("cannot find this program")?;
    println!("  {} run{} -c {}", program.display(), root_option(), farm.config_file().display());
    print_places(farm);
    Ok(())
}

/// Where parts can be dropped.
fn print_places(farm: &DemoFarm) {
    println!("  {}", farm.machine_folder("inbox").display());
    farm.page().iter().for_each(|page| println!("  {page}"));
}

/// The option that root needs, for example in a container, to run a daemon by hand.
fn root_option() -> &'static str {
    if rustix::process::geteuid().is_root() { " --allow-root" } else { "" }
}

/// Refuses a farm that another daemon serves: two daemons on one farm would disturb each other.
async fn expect_no_daemon(farm: &DemoFarm) -> Result<()> {
    if !farm.ledger_file().exists() {
        return Ok(());
    }
    let ledger = Ledger::open_existing(&farm.ledger_file()).await?;
    let served_by = ledger.find_node("").await?.filter(|d| d.alive);
    ledger.close().await;
    match served_by {
        Some(daemon) => Err(UsageError(format!("a daemon serves this farm already (process {})", daemon.pid)).into()),
        None => Ok(()),
    }
}

/// Watches the farm through the ledger, as an operator does, and waits for its progress.
struct DemoWatcher<'d> {
    ledger: Ledger,
    daemon: &'d mut DemoDaemon,
    deadline: Instant,
    /// Parts up to this number belong to an earlier demo.
    last_part: i64,
    /// The last build that an earlier demo published.
    last_build: Option<i64>,
    last_line: String,
}

impl<'d> DemoWatcher<'d> {
    /// Waits for the daemon's ledger and its first heartbeat.
    async fn wait_for_daemon(farm: &DemoFarm, daemon: &'d mut DemoDaemon) -> Result<Self> {
        let deadline = Instant::now() + Duration::from_secs(TIMEOUT_SECS);
        let pid = daemon.process_id();
        loop {
            if farm.ledger_file().exists()
                && let Ok(ledger) = Ledger::open_existing(&farm.ledger_file()).await
            {
                if ledger.find_node("").await.ok().flatten().is_some_and(|d| d.pid == pid) {
                    let mut watch =
                        Self { ledger, daemon, deadline, last_part: 0, last_build: None, last_line: String::new() };
                    watch.last_part = watch.new_parts().await?.iter().map(|p| p.id.0).max().unwrap_or(0);
                    watch.last_build = watch.newest_build().await?.map(|b| b.build.0);
                    return Ok(watch);
                }
                ledger.close().await;
            }
            daemon.expect_running()?;
            if Instant::now() > deadline {
                bail!("the daemon gave no sign of life");
            }
            tokio::time::sleep(POLL_INTERVAL).await;
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

    async fn machine_status(&self) -> Result<Option<MachineStatus>> {
        Ok(self.ledger.machine_statuses().await?.into_iter().find(|s| s.machine == MACHINE))
    }

    /// The build that was published last, unless it is from an earlier demo.
    async fn newest_build(&self) -> Result<Option<PublishedBuild>> {
        let last = self.machine_status().await?.and_then(|s| s.last_published);
        Ok(last.filter(|b| Some(b.build.0) != self.last_build))
    }

    /// Waits a moment, and prints the status line when it has changed.
    async fn poll_and_print(&mut self, for_what: &str) -> Result<()> {
        self.daemon.expect_running()?;
        if Instant::now() > self.deadline {
            bail!("gave up after {TIMEOUT_SECS} s of waiting for {for_what}");
        }
        if let Some(status) = self.machine_status().await? {
            let line = status_line(&status);
            if line != self.last_line {
                println!("  {line}");
                self.last_line = line;
            }
        }
        tokio::time::sleep(POLL_INTERVAL).await;
        Ok(())
    }

    /// Waits until every dropped file is read: it waits for a build, or is refused.
    async fn until_all_are_read(&mut self, dropped: DroppedFiles) -> Result<()> {
        loop {
            let parts = self.new_parts().await?;
            let claimed = parts.iter().filter(|p| p.state == PartState::Claimed).count();
            if parts.len() >= dropped.files && claimed == 0 {
                let refused = parts.iter().filter(|p| p.state == PartState::Refused).count();
                if refused != dropped.torn {
                    bail!("{refused} parts were refused instead of {}", dropped.torn);
                }
                return Ok(());
            }
            self.poll_and_print("the parts to be read").await?;
        }
    }

    /// Sends `nestd flush`, as an operator does, until no part waits any more.
    async fn until_all_are_built(&mut self, farm: &DemoFarm) -> Result<()> {
        let mut flushed_after = None;
        loop {
            let is_done = |p: &PartRow| matches!(p.state, PartState::Built | PartState::Refused);
            if self.new_parts().await?.iter().all(is_done) {
                return Ok(());
            }
            let published = self.newest_build().await?.map(|b| b.build.0);
            let nesting = self.machine_status().await?.is_some_and(|s| !s.nesting.is_empty());
            // Sent once, and again after a build that had no room for all parts.
            if !nesting && flushed_after != Some(published) {
                flushed_after = Some(published);
                // A daemon that is too busy to answer in time still executes the command, so the demo goes on waiting.
                if run_nestd(farm, &["flush", MACHINE]).is_err() {
                    self.daemon.expect_running()?;
                }
            }
            self.poll_and_print("the build").await?;
        }
    }
}

fn status_line(status: &MachineStatus) -> String {
    if let Some(build) = status.nesting.first() {
        return format!("build {}: {}, {}", build.build.0, format_count(build.copies, "copy", "copies"), build.state);
    }
    let forecast = (status.open.as_ref().and_then(|o| o.height_mm))
        .map_or(String::new(), |height_mm| format!("; the open build is {height_mm:.1} mm high"));
    let (parts, copies) = (status.waiting_parts, status.waiting_copies);
    format!(
        "{}, {}; {} refused{forecast}",
        format_count(parts, "part waits", "parts wait"),
        format_count(copies, "copy", "copies"),
        status.refused_parts
    )
}

/// Runs a command as an operator does, and prints the command and its output.
fn run_nestd(farm: &DemoFarm, arguments: &[&str]) -> Result<()> {
    println!("\n$ nestd {} -c {}", arguments.join(" "), farm.config_file().display());
    let status = nestd_command(&farm.config_file(), &farm.root)?.args(arguments).status();
    let status = status.with_context(|| format!("cannot run nestd {}", arguments.join(" ")))?;
    if !status.success() {
        bail!("nestd {} failed ({status})", arguments.join(" "));
    }
    Ok(())
}

/// Prints status, history, the refused part and where the results are.
async fn show_results(farm: &DemoFarm, watch: &DemoWatcher<'_>) -> Result<()> {
    let build = watch.newest_build().await?.context("no build was published")?;
    run_nestd(farm, &["status"])?;
    run_nestd(farm, &["history", "--limit", "5"])?;
    println!("\nRefused, each file in {} with its reason beside it:", farm.machine_folder("error").display());
    for part in watch.new_parts().await?.iter().filter(|p| p.state == PartState::Refused) {
        println!("  {}: {}", part.name, part.refused.reason);
    }
    if matching_files(&farm.machine_folder("error"), |name| {
        name.starts_with(TORN_FILE) && name.ends_with(".reason.txt")
    })?
    .is_empty()
    {
        bail!("{TORN_FILE} was refused without a reason file");
    }
    let name = build.file_name.context("the build has no file")?;
    let stem = build_file::build_file_stem(&name).unwrap_or(&name).to_owned();
    let made = matching_files(&farm.machine_folder("queue"), |file| file.starts_with(&stem))?;
    if !made.iter().any(|file| file.ends_with(&name)) {
        bail!("{name} is not in {}", farm.machine_folder("queue").display());
    }
    println!("\nIn the printer's queue:");
    made.iter().for_each(|file| println!("  {}", file.display()));
    println!("The ledger, for sqlite3 (try: select * from v_build_history):\n  {}", farm.ledger_file().display());
    Ok(())
}

/// The files of a folder whose names match, sorted.
fn matching_files(folder: &Path, wanted: impl Fn(&str) -> bool) -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder).with_context(|| format!("cannot look into {}", folder.display()))?;
    let mut files: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.retain(|file| file.file_name().is_some_and(|name| wanted(&name.to_string_lossy())));
    files.sort();
    Ok(files)
}

#[cfg(test)]
mod tests;
