//! `nestd people`: who may sign in to the dashboard, and what each may do there.

use access::{PasswordHash, Role, is_password, is_person_name, is_pin};
use anyhow::{Context, Result};
use language::say;
use ledger::{Ledger, PersonChange};
use settings::Settings;

use super::secret_input::read_secret;
use crate::{
    cli::{
        CommandExit, CommonArgs, UsageError,
        terminal::{
            farm_context::{user_at_host, with_ledger, with_ledger_to_read},
            table::{TextTable, print_json, print_text},
            terminal::output_columns,
            values::parse_word,
        },
    },
    tables::{PEOPLE_COLUMNS, TimeView},
};

/// What is done with people.
#[derive(Debug, clap::Subcommand)]
pub enum PeopleCommand {
    /// Add a person; asks for a password, or reads it from standard input
    Add {
        /// The name with which the person signs in, as events have it
        name: String,
        /// What the person may: read, order (and read), operate (and order) or admin (also who else may)
        #[arg(long, value_parser = parse_word::<Role>)]
        role: Role,
        /// The person signs in at the reverse proxy (web.user_header) only
        #[arg(long)]
        no_password: bool,
    },
    /// List the people, their roles, and when each last signed in
    List {
        /// Print JSON
        #[arg(long)]
        json: bool,
    },
    /// Give a person another role, from the next request on
    Role {
        /// The name
        name: String,
        /// read, order, operate or admin
        #[arg(value_parser = parse_word::<Role>)]
        role: Role,
    },
    /// Give a person a new password; all sessions of the person end
    Password {
        /// The name
        name: String,
    },
    /// Give a person a PIN of 4 to 8 digits, to go on at a shared device
    Pin {
        /// The name
        name: String,
        /// Take the PIN away
        #[arg(long)]
        none: bool,
    },
    /// Sign a person out everywhere
    SignOut {
        /// The name
        name: String,
    },
    /// Remove a person; what events say of the person stays
    Remove {
        /// The name
        name: String,
        /// Also the last one, after whom nobody is asked to sign in
        #[arg(long)]
        anyway: bool,
    },
}

/// Runs the command.
pub fn run(common: &CommonArgs, command: &PeopleCommand) -> Result<CommandExit> {
    match command {
        PeopleCommand::List { json } => return list(common, *json),
        PeopleCommand::Add { name, role, no_password } => add(common, name, *role, *no_password)?,
        PeopleCommand::Role { name, role } => change(common, name, async |_, _| Ok(PersonChange::Role(*role)))?,
        PeopleCommand::Password { name } => {
            change(common, name, async |_, name| Ok(PersonChange::Password(new_password(name)?)))?;
        }
        PeopleCommand::Pin { none: true, name } => {
            change(common, name, async |_, _| Ok(PersonChange::Pin(PasswordHash::default())))?;
        }
        PeopleCommand::Pin { name, .. } => change(common, name, async |_, name| new_pin(name))?,
        PeopleCommand::SignOut { name } => change(common, name, async |_, _| Ok(PersonChange::SignedOut))?,
        PeopleCommand::Remove { name, anyway } => {
            let removed = async |ledger: &Ledger, name: &str| -> Result<PersonChange> {
                if !anyway && ledger.list_people().await?.len() == 1 {
                    let text = format!(
                        "{name} is the last one: without people, and unless web.sign_in is set, whoever can connect may do everything. \
                         To remove {name} all the same, say --anyway"
                    );
                    return Err(UsageError(text).into());
                }
                Ok(PersonChange::Removed)
            };
            change(common, name, removed)?;
        }
    }
    Ok(CommandExit::Success)
}

fn list(common: &CommonArgs, is_json: bool) -> Result<CommandExit> {
    let (people, view) = with_ledger_to_read(common, async |settings, ledger| {
        Ok((ledger.list_people().await?, TimeView::current(&settings.time_zone)))
    })?;
    match (is_json, people.is_empty()) {
        (true, _) => print_json(&people)?,
        (false, true) => print_text("There are no people: `nestd people add NAME --role admin` adds one.")?,
        (false, false) => {
            print_text(&TextTable::of(PEOPLE_COLUMNS, &people, &view).fit_columns(output_columns(false)))?
        }
    }
    Ok(CommandExit::Success)
}

fn add(common: &CommonArgs, name: &str, role: Role, no_password: bool) -> Result<()> {
    if !is_person_name(name) {
        return Err(UsageError(say!("person-name-rule")).into());
    }
    let is_first = with_ledger(common, async |settings: &Settings, ledger| {
        if ledger.find_person(name).await?.is_some() {
            return Err(ledger::LedgerError::PersonKnown(name.to_owned()).into());
        }
        let is_first = !ledger.has_people().await?;
        let password = if no_password { PasswordHash::default() } else { new_password(name)? };
        ledger.add_person(name, role, &password, &user_at_host()).await?;
        Ok(is_first && settings.interfaces.web.as_ref().is_none_or(|web| !web.sign_in))
    })?;
    print_text(&format!("{name} may sign in, with the role {}.", role.as_str()))?;
    if is_first {
        print_text("From now on, who has no token has to sign in. Programs without one are refused.")?;
    }
    Ok(())
}

/// Changes something for a person: `what` is asked once it is known that there is one.
fn change(
    common: &CommonArgs,
    name: &str,
    what: impl AsyncFnOnce(&Ledger, &str) -> Result<PersonChange>,
) -> Result<()> {
    let (name, done) = with_ledger(common, async |_, ledger| {
        let unknown = || ledger::LedgerError::UnknownPerson(name.to_owned());
        let person = ledger.find_person(name).await?.ok_or_else(unknown)?;
        let change = what(ledger, &person.name).await?;
        Ok((ledger.change_person(&person.name, &change, &user_at_host()).await?, change))
    })?;
    print_text(&match done {
        PersonChange::Role(role) => format!("{name} has the role {} now.", role.as_str()),
        PersonChange::Password(_) => format!("{name} has a new password, and is signed out everywhere."),
        PersonChange::Pin(pin) if pin.is_none() => format!("{name} has no PIN any more."),
        PersonChange::Pin(_) => format!("{name} has a new PIN."),
        PersonChange::SignedOut => format!("{name} is signed out everywhere."),
        PersonChange::Removed => format!("{name} is removed, and signed out everywhere."),
    })
}

fn new_password(name: &str) -> Result<PasswordHash> {
    let password = read_secret(&format!("password of {name}"))?;
    if !is_password(&password, name) {
        return Err(UsageError(say!("password-rule")).into());
    }
    PasswordHash::of(&password).context("there is no memory to hash a password")
}

fn new_pin(name: &str) -> Result<PersonChange> {
    let pin = read_secret(&format!("PIN of {name}"))?;
    if !is_pin(&pin) {
        return Err(UsageError(say!("pin-rule")).into());
    }
    let hash = PasswordHash::of(&pin).context("there is no memory to hash a PIN")?;
    Ok(PersonChange::Pin(hash))
}
