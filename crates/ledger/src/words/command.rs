//! Commands from users to the daemon. The daemon answers in the row, so commands work from another server too.

use serde::{Deserialize, Serialize};

use crate::{
    CommandId, EventKind, Ledger, LedgerError, PartEdit, PartId, PartRow, PartState, UtcTimestamp,
    base::{
        error::Result,
        sql::{self, sql_row},
        text_column::own_word,
    },
    store::change::LedgerChange,
};

/// Kind of command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CommandKind {
    /// Nest and publish the waiting parts of a machine now.
    Flush,
    /// Start no batch of a machine until it is resumed.
    Pause,
    /// Let a machine start batches again.
    Resume,
    /// Retry a refused part.
    Retry,
    /// Refuse a waiting part.
    Cancel,
    /// Scan the hot folders now.
    Scan,
    /// Change what was asked with a part.
    Edit,
    /// Move a part to another machine.
    Move,
    /// Print a part as it is.
    Confirm,
}

own_word!(CommandKind);

/// State of a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CommandState {
    /// Not answered yet.
    Asked,
    /// Done.
    Done,
    /// Refused. The answer says why.
    Refused,
}

own_word!(CommandState);

/// Why a machine is paused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PauseCause {
    /// A person paused it.
    #[default]
    Person,
    /// The daemon paused it after a build failed, until a person resumes it.
    BuildFailed,
}

own_word!(PauseCause);

/// What a command says beyond its kind and its part. Stored as JSON.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CommandArgument {
    /// Number of copies to cancel; `None` = all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub copies: Option<u32>,
    /// Changes of an edit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub edit: Option<PartEdit>,
    /// Whether the mesh of a part that is taken back may be mended.
    #[serde(skip_serializing_if = "is_false")]
    pub mend: bool,
}

fn is_false(flag: &bool) -> bool {
    !flag
}

impl CommandArgument {
    fn to_json(&self) -> String {
        match *self == Self::default() {
            true => String::new(),
            false => serde_json::to_string(self).unwrap_or_default(),
        }
    }
}

/// A command to submit.
#[derive(Debug, Clone, PartialEq)]
pub struct NewCommand {
    /// Kind of command.
    pub kind: CommandKind,
    /// Machine of flush, pause and resume, "" otherwise.
    pub machine: String,
    /// Part of retry, cancel, edit, move and confirm.
    pub part: Option<PartId>,
    /// Changes of an edit, copies to cancel.
    pub argument: CommandArgument,
    /// user@host.
    pub asked_by: String,
}

/// A command with its current state.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct CommandRow {
    /// Its number.
    pub id: CommandId,
    /// Kind of command.
    pub kind: CommandKind,
    /// Machine, "" = none.
    pub machine: String,
    /// Part of retry, cancel, edit, move and confirm.
    pub part_id: Option<PartId>,
    /// What it says as JSON, "" = nothing.
    pub argument: String,
    /// user@host.
    pub asked_by: String,
    /// When it was submitted.
    pub asked_at: UtcTimestamp,
    /// Current state.
    pub state: CommandState,
    /// Answer of the daemon.
    pub answer: String,
    /// When the daemon answered.
    pub answered_at: Option<UtcTimestamp>,
}

sql_row!(CommandRow { id, kind, machine, part_id, argument, asked_by, asked_at, state, answer, answered_at });

impl CommandRow {
    /// Whether its answer is there: what is done through [`Ledger::for_command`] is done a moment before.
    pub fn is_answered(&self) -> bool {
        match self.state {
            CommandState::Asked => false,
            CommandState::Done => !self.answer.is_empty(),
            CommandState::Refused => true,
        }
    }

    /// What it says beyond its kind and its part; `None` = another version wrote it, and this one cannot read it.
    pub fn read_argument(&self) -> Option<CommandArgument> {
        match self.argument.as_str() {
            "" => Some(CommandArgument::default()),
            argument => serde_json::from_str(argument).ok(),
        }
    }
}

impl Ledger {
    /// Submits a command to the daemon.
    pub async fn submit_command(&self, command: &NewCommand) -> Result<CommandId> {
        let mut change = self.begin_change().await?;
        if let Some(part) = command.part {
            change.require_part(part).await?;
        }
        let id = change.insert_command(command).await?;
        change.commit().await?;
        Ok(id)
    }

    /// The machine whose node carries a command out: that of its part, else the one that it names; "" = none.
    pub async fn machine_of_command(&self, part: Option<PartId>, machine: &str) -> Result<String> {
        match part {
            Some(part) => Ok(self.find_part(part).await?.map(|part| part.machine).unwrap_or_default()),
            None => Ok(machine.to_owned()),
        }
    }

    /// The commands that are not answered yet, oldest first.
    pub async fn pending_commands(&self) -> Result<Vec<CommandRow>> {
        let query = sql::select_as("FROM command WHERE state = 'asked' ORDER BY id");
        Ok(query.fetch_all(self.reader()?).await?)
    }

    /// Answers a command. A command can be answered only once. One that is done through [`Ledger::for_command`] has no answer
    /// yet.
    pub async fn answer_command(&self, id: CommandId, done: bool, answer: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        let state = if done { CommandState::Done } else { CommandState::Refused };
        let now = change.now;
        let answered = sql::query(
            "UPDATE command SET state = $1, answer = $2, answered_at = $3 \
             WHERE id = $4 AND (state = 'asked' OR state = 'done' AND $1 = 'done' AND answer = '')",
        )
        .bind(state)
        .bind(answer)
        .bind(now)
        .bind(id)
        .execute(change.db())
        .await?;
        if answered == 0 {
            return Err(LedgerError::UnknownCommand(id));
        }
        change.commit().await
    }

    /// Finds a command by its number.
    pub async fn find_command(&self, id: CommandId) -> Result<Option<CommandRow>> {
        let query = sql::select_as("FROM command WHERE id = $1").bind(id);
        Ok(query.fetch_optional(self.reader()?).await?)
    }

    /// Pauses a machine. Returns `false` if it was paused already.
    pub async fn pause_machine(&self, machine: &str, by: &str, cause: PauseCause) -> Result<bool> {
        let mut change = self.begin_change().await?;
        let is_new = change.pause_machine(machine, by, cause).await?;
        if is_new {
            change.commit().await?;
        }
        Ok(is_new)
    }

    /// Resumes a machine. Returns `false` if it was not paused.
    pub async fn resume_machine(&self, machine: &str, by: &str) -> Result<bool> {
        let mut change = self.begin_change().await?;
        let lift = sql::query("DELETE FROM pause WHERE machine = $1").bind(machine);
        if lift.execute(change.db()).await? == 0 {
            return Ok(false);
        }
        change.write_event(EventKind::Resumed, machine, None, None, by).await?;
        change.commit().await?;
        Ok(true)
    }

    /// The paused machines, by name.
    pub async fn paused_machines(&self) -> Result<Vec<String>> {
        let query = sql::query_scalar("SELECT machine FROM pause ORDER BY machine");
        Ok(query.fetch_all(self.reader()?).await?)
    }
}

impl LedgerChange {
    /// Number of copies of a part that can be taken back: they wait, or their file is read again or asked for.
    pub async fn revocable_count(&mut self, part: &PartRow) -> Result<u32> {
        match part.state {
            PartState::Waiting => self.waiting_count(part.id).await,
            PartState::Claimed if part.measures.triangles.is_some() => self.waiting_count(part.id).await,
            _ => Ok(0),
        }
    }

    /// How many copies of a part are to be taken back by commands that are not carried out yet.
    pub async fn copies_asked_back(&mut self, id: PartId) -> Result<u32> {
        let asked: Vec<CommandRow> =
            sql::select_as("FROM command WHERE part_id = $1 AND state = 'asked' AND kind = 'cancel'")
                .bind(id)
                .fetch_all(self.db())
                .await?;
        // One without a number takes all of them back.
        Ok(asked
            .iter()
            .map(|row| row.read_argument().and_then(|said| said.copies).unwrap_or(u32::MAX))
            .fold(0, u32::saturating_add))
    }

    /// Inserts the row of a command.
    pub(super) async fn insert_command(&mut self, command: &NewCommand) -> Result<CommandId> {
        let now = self.now;
        let insert = sql::query_scalar(
            "INSERT INTO command (kind, machine, part_id, argument, asked_by, asked_at, state) \
             VALUES ($1, $2, $3, $4, $5, $6, 'asked') RETURNING id",
        );
        let insert = insert.bind(command.kind).bind(&command.machine).bind(command.part);
        let insert = insert.bind(command.argument.to_json()).bind(&command.asked_by).bind(now);
        let id = insert.fetch_one(self.db()).await?;
        let machine = match command.part {
            Some(part) => self.require_part(part).await?.machine,
            None => command.machine.clone(),
        };
        self.tell_node_of(&machine);
        Ok(id)
    }

    /// Pauses a machine. Returns `false` if it was paused.
    pub async fn pause_machine(&mut self, machine: &str, by: &str, cause: PauseCause) -> Result<bool> {
        let now = self.now;
        let insert =
            "INSERT INTO pause (machine, paused_by, cause, paused_at) VALUES ($1, $2, $3, $4) ON CONFLICT DO NOTHING";
        let paused = sql::query(insert).bind(machine).bind(by).bind(cause).bind(now).execute(self.db()).await?;
        if paused == 0 {
            return Ok(false);
        }
        self.write_event(EventKind::Paused, machine, None, None, by).await?;
        Ok(true)
    }
}
