//! `nestd token`: the tokens with which programs and people ask the dashboard.

use std::path::PathBuf;

use access::{Role, add_token, read_tokens, revoke_token};
use anyhow::{Context, Result};

use crate::cli::{
    CommandExit, CommonArgs,
    terminal::{
        farm_context::load_settings,
        table::{print_json, print_text},
    },
};

/// What is done with tokens.
#[derive(Debug, clap::Subcommand)]
pub enum TokenCommand {
    /// Make a token, and print it: it is kept nowhere else
    New {
        /// Name of who has it, for events and limits
        name: String,
        /// What it may: read, order (and read) or operate (everything)
        #[arg(long, value_parser = crate::cli::terminal::values::parse_word::<Role>)]
        role: Role,
    },
    /// Take a token back, at once
    Revoke {
        /// Its name
        name: String,
    },
    /// List the names and roles of the tokens
    List {
        /// Print JSON
        #[arg(long)]
        json: bool,
    },
}

/// Runs the command.
pub fn run(common: &CommonArgs, command: &TokenCommand) -> Result<CommandExit> {
    let file = tokens_file(common)?;
    match command {
        TokenCommand::New { name, role } => {
            let token = add_token(&file, name, *role)?;
            print_text(&token)?;
            print_text(&format!(
                "This is the token of {name}, with the role {}. It is not shown again.",
                role.as_str()
            ))?;
        }
        TokenCommand::Revoke { name } => {
            revoke_token(&file, name)?;
            print_text(&format!("The token of {name} is taken back."))?;
        }
        TokenCommand::List { json: true } => print_json(&read_tokens(&file)?)?,
        TokenCommand::List { json: false } => {
            for token in read_tokens(&file)? {
                print_text(&format!("{}: {}", token.name, token.role.as_str()))?;
            }
        }
    }
    Ok(CommandExit::Success)
}

fn tokens_file(common: &CommonArgs) -> Result<PathBuf> {
    let settings = load_settings(common)?;
    let web = settings.interfaces.web.as_ref();
    web.and_then(|web| web.tokens_file.clone()).context("there is no file for tokens: set web.tokens_file first")
}
