//! `nestd backup` and `nestd restore`: writes a copy of the ledger, and puts it back.

use std::path::PathBuf;

use anyhow::{Context, Result};
use farm::ReconcileReport;

use crate::cli::{
    CommandExit, CommonArgs,
    terminal::{
        farm_context::{load_settings, with_ledger_to_read},
        table::print_text,
    },
};

/// Arguments of `nestd backup`.
#[derive(Debug, clap::Args)]
pub struct BackupArgs {
    /// The file to write; it must not exist. Its checksum is written beside it, as FILE.b3
    file: PathBuf,
}

/// Arguments of `nestd restore`.
#[derive(Debug, clap::Args)]
pub struct RestoreArgs {
    /// A backup made by `nestd backup`
    #[arg(required_unless_present = "empty")]
    file: Option<PathBuf>,
    /// There is no backup: begin a new ledger from the contents of the folders
    #[arg(long, conflicts_with = "file")]
    empty: bool,
    /// A folder that is known to be empty, because its contents are lost for good or because it is new
    #[arg(long, value_name = "DIR")]
    new_folder: Vec<PathBuf>,
}

/// Runs `nestd backup`.
pub fn run(common: &CommonArgs, args: &BackupArgs) -> Result<CommandExit> {
    let (bytes, has_people) = with_ledger_to_read(common, async |_, ledger| {
        Ok((ledger.write_backup(&args.file).await?, ledger.has_people().await?))
    })?;
    print_text(&format!("Wrote {}: {bytes} bytes, every page checked.", args.file.display()))?;
    if has_people {
        print_text("It holds the hashes of people's passwords: keep it as a secret.")?;
    }
    Ok(CommandExit::Success)
}

/// Runs `nestd restore`.
pub fn run_restore(common: &CommonArgs, args: &RestoreArgs) -> Result<CommandExit> {
    let settings = load_settings(common)?;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().context("cannot start")?;
    let restored = runtime.block_on(farm::restore_ledger(&settings, args.file.as_deref(), &args.new_folder))?;
    let mut text = match &args.file {
        Some(file) => format!("{} is the ledger now.\n", file.display()),
        None => "A new ledger was begun.\n".to_owned(),
    };
    if let Some(aside) = &restored.aside {
        text += &format!("The one before is kept as {}.\n", aside.display());
    }
    for line in reconciliation_lines(&restored.reconciled) {
        text += &format!("  {line}\n");
    }
    print_text(&(text + "Run `nestd check --deep`, then start the daemon."))?;
    Ok(CommandExit::Success)
}

/// The changes that were made to the ledger, and the doubts that a person should check.
pub fn reconciliation_lines(reconciled: &ReconcileReport) -> Vec<String> {
    let done = reconciled.done.iter().map(|line| format!("{line}."));
    let doubts = reconciled.doubts.iter().map(|line| format!("LOOK AT: {line}."));
    let mut lines: Vec<String> = done.chain(doubts).collect();
    if lines.is_empty() {
        lines.push("The folders tell nothing that the ledger does not know.".to_owned());
    }
    lines
}
