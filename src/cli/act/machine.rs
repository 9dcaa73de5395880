//! `nestd machine`: writes the file of a new machine, and says what material is loaded in one.

use anyhow::Result;
use ledger::OperatorWord;

use super::{edit::is_none, operate::say};
use crate::cli::{
    CommandExit, CommonArgs,
    serve::new_farm::{MachineArgs, run_machine},
    terminal::candidates,
};

/// What is done with machines.
#[derive(Debug, clap::Subcommand)]
pub enum MachineCommand {
    /// Write the file of a new machine
    New(MachineArgs),
    /// Say what material is loaded; parts of another one wait from then on
    Load {
        /// Machine
        #[arg(add = candidates::of_machines())]
        machine: String,
        /// Its material, as in PA12, or none
        material: String,
        /// The lot of its powder
        #[arg(long, value_name = "LOT", default_value = "", hide_default_value = true)]
        lot: String,
    },
}

/// Runs the command.
pub fn run(common: &CommonArgs, command: &MachineCommand) -> Result<CommandExit> {
    let (machine, material, lot) = match command {
        MachineCommand::New(args) => return run_machine(common, args),
        MachineCommand::Load { machine, material, lot } => (machine.clone(), material.clone(), lot.clone()),
    };
    let material = if is_none(&material) { String::new() } else { material };
    say(common, &[OperatorWord::Load { machine, material, lot }], false)
}
