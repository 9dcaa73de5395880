//! `nestd backup` and `nestd restore`: a copy of the ledger, and back.

use std::path::PathBuf;

use anyhow::{Context, Result};

use super::{
    Common, Exit,
    reach::{look_at_ledger, settings},
    table::say,
};
use crate::farm::{self, Reconciled};

/// Arguments of `nestd backup`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Where to write it; must not be there. Its checksum is written beside it, as FILE.b3
    file: PathBuf,
}

/// Arguments of `nestd restore`.
#[derive(Debug, clap::Args)]
pub struct RestoreArgs {
    /// A backup made by `nestd backup`
    #[arg(required_unless_present = "empty")]
    file: Option<PathBuf>,
    /// There is no backup: begin a new ledger with what the folders tell
    #[arg(long, conflicts_with = "file")]
    empty: bool,
    /// A folder of which it is known that nothing is in it: it is lost for good, or truly new
    #[arg(long, value_name = "DIR")]
    new_folder: Vec<PathBuf>,
}

/// Runs `nestd backup`.
pub fn run(common: &Common, args: &Args) -> Result<Exit> {
    let bytes = look_at_ledger(common, async |_, ledger| Ok(ledger.backup(&args.file).await?))?;
    say(&format!("Wrote {}: {bytes} bytes, every page checked.", args.file.display()))?;
    Ok(Exit::Success)
}

/// Runs `nestd restore`.
pub fn restore(common: &Common, args: &RestoreArgs) -> Result<Exit> {
    let settings = settings(common)?;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().context("cannot start")?;
    let restored = runtime.block_on(farm::restore(&settings, args.file.as_deref(), &args.new_folder))?;
    let mut text = match &args.file {
        Some(file) => format!("{} is the ledger now.\n", file.display()),
        None => "A new ledger was begun.\n".to_owned(),
    };
    if let Some(aside) = &restored.aside {
        text += &format!("The one before is kept as {}.\n", aside.display());
    }
    for line in tell(&restored.reconciled) {
        text += &format!("  {line}\n");
    }
    say(&(text + "Run `nestd check --deep`, then start the daemon."))?;
    Ok(Exit::Success)
}

/// What was taken in, and what a person should look at.
pub fn tell(reconciled: &Reconciled) -> Vec<String> {
    let done = reconciled.done.iter().map(|line| format!("{line}."));
    let doubts = reconciled.doubts.iter().map(|line| format!("LOOK AT: {line}."));
    let mut lines: Vec<String> = done.chain(doubts).collect();
    if lines.is_empty() {
        lines.push("The folders tell nothing that the ledger does not know.".to_owned());
    }
    lines
}
