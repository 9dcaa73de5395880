//! Material: what parts are to be made of, what is loaded in machines, and what builds are made of.
//!
//! A part that says its material goes only into a build of a machine that has it loaded. A part that says none goes into any build. So no
//! build ever holds two materials. `part.awaits_material` says of each waiting part whether it waits for that. It is decided here and
//! nowhere else, and kept up by each change of a part's state, of its material and of what is loaded. `waiting_copies`,
//! `begin_nesting` and all forecasts go by it.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use crate::{
    BuildId, EventKind, Ledger, MaterialError, PartId, PartRow, UtcTimestamp,
    base::{
        error::Result,
        sql::{self, sql_row},
    },
    store::change::LedgerChange,
};

/// What is loaded in a machine.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct LoadedMaterial {
    /// The machine.
    pub machine: String,
    /// What is loaded there.
    pub material: String,
    /// Its lot; "" = not said.
    pub lot: String,
    /// Who said so, user@host; "" = its file.
    pub loaded_by: String,
    /// Since when that is said.
    pub loaded_at: UtcTimestamp,
}

sql_row!(LoadedMaterial { machine, material, lot, loaded_by, loaded_at });

/// By what materials are compared: the word without case, spaces, hyphens and underscores. "" = any.
pub fn material_key(word: &str) -> String {
    word.chars().filter(|c| !c.is_whitespace() && !matches!(c, '-' | '_')).flat_map(char::to_lowercase).collect()
}

impl PartRow {
    /// Fails if it waits for its material.
    pub(crate) fn ensure_material_loaded(&self) -> Result<()> {
        let (material, machine) = (self.terms.material.clone(), self.machine.clone());
        match self.owed.awaits_material {
            true => Err(MaterialError::NotLoaded { part: self.id, material, machine }.into()),
            false => Ok(()),
        }
    }
}

impl Ledger {
    /// What is loaded, by machine. One that has nothing loaded is not among them.
    pub async fn loaded_materials(&self) -> Result<Vec<LoadedMaterial>> {
        let query = sql::select_as("FROM loaded_material WHERE material <> '' ORDER BY machine");
        Ok(query.fetch_all(self.reader()?).await?)
    }

    /// What is loaded in a machine, "" = nothing, or nothing is said of it.
    pub async fn loaded_material(&self, machine: &str) -> Result<String> {
        let query = sql::query_scalar("SELECT material FROM loaded_material WHERE machine = $1").bind(machine);
        Ok(query.fetch_optional(self.reader()?).await?.unwrap_or_default())
    }

    /// A person says what is loaded in a machine, "" = nothing, and of which lot, "" = not said. Returns what follows from that, in
    /// sentences. What no printer has taken yet is printed from this lot.
    pub(crate) async fn load_material(&self, machine: &str, loaded: (&str, &str), by: &str) -> Result<Vec<String>> {
        let (material, lot) = loaded;
        let mut change = self.begin_change().await?;
        let query = sql::query_as("SELECT material, lot FROM loaded_material WHERE machine = $1").bind(machine);
        let before: (String, String) = query.fetch_optional(change.db()).await?.unwrap_or_default();
        let name = if lot.is_empty() { material.to_owned() } else { format!("{material}, lot {lot},") };
        if (before.0.as_str(), before.1.as_str()) == loaded {
            return Ok(vec![match material {
                "" => format!("Nothing was loaded on {machine} before."),
                _ => format!("{name} was loaded on {machine} before."),
            }]);
        }
        change.set_loaded(machine, loaded, by).await?;
        let query = sql::query_scalar("SELECT id FROM part WHERE machine = $1 AND state = 'waiting'").bind(machine);
        for part in query.fetch_all(change.db()).await? {
            change.decide_awaiting(part).await?;
        }
        let mut sentences = vec![match material {
            "" => format!("Nothing is loaded on {machine} now: parts that say their material wait."),
            _ => format!("{name} is loaded on {machine} now: its next build is made of that."),
        }];
        let awaiting: u32 =
            sql::query_scalar("SELECT count(*) FROM part WHERE machine = $1 AND state = 'waiting' AND awaits_material")
                .bind(machine)
                .fetch_one(change.db())
                .await?;
        sentences.extend(match awaiting {
            0 => None,
            1 => Some("1 part there waits for another material; `nestd status` says for which.".to_owned()),
            parts => Some(format!("{parts} parts there wait for another material; `nestd status` says for which.")),
        });
        for (build, of) in change.unprinted_builds(machine).await? {
            if material_key(&of) == material_key(material) {
                let set = sql::query("UPDATE build SET lot = $1 WHERE id = $2").bind(lot).bind(build);
                set.execute(change.db()).await?;
            } else if !of.is_empty() {
                sentences.push(format!("Build {build} fired before and is of {of}: print it first, or withdraw it."));
            }
        }
        change.commit().await?;
        Ok(sentences)
    }

    /// Takes over what the settings say: what the files of these machines say is loaded, as long as no person said otherwise, and what
    /// materials are called. `name_of` gives the name for a word that people use.
    pub async fn take_over_materials(
        &self,
        by_file: &BTreeMap<String, String>,
        name_of: &(dyn Fn(&str) -> String + Sync),
    ) -> Result<()> {
        let mut change = self.begin_change().await?;
        let mut is_changed = change.rename_materials(name_of).await?;
        for (machine, material) in by_file {
            let query = sql::query_as("SELECT material, loaded_by FROM loaded_material WHERE machine = $1");
            let known: Option<(String, String)> = query.bind(machine).fetch_optional(change.db()).await?;
            let (loaded, by) = known.unwrap_or_default();
            if by.is_empty() && loaded != *material {
                change.set_loaded(machine, (material, ""), "").await?;
                is_changed = true;
            }
        }
        if is_changed {
            let waiting =
                sql::query_scalar("SELECT id FROM part WHERE state = 'waiting'").fetch_all(change.db()).await?;
            for part in waiting {
                change.decide_awaiting(part).await?;
            }
            change.commit().await?;
        }
        Ok(())
    }
}

impl LedgerChange {
    /// Decides whether a part waits for its material.
    pub(crate) async fn decide_awaiting(&mut self, part: PartId) -> Result<()> {
        let decide = sql::query(
            "UPDATE part SET awaits_material = (state = 'waiting' AND material_key <> '' AND material_key <> \
             coalesce((SELECT l.material_key FROM loaded_material l WHERE l.machine = part.machine), '')) WHERE id = $1",
        );
        decide.bind(part).execute(self.db()).await?;
        Ok(())
    }

    /// Sets what a part is to be made of.
    pub(crate) async fn set_material(&mut self, part: PartId, material: &str) -> Result<()> {
        let set = sql::query("UPDATE part SET material = $1, material_key = $2 WHERE id = $3");
        set.bind(material).bind(material_key(material)).bind(part).execute(self.db()).await?;
        self.decide_awaiting(part).await
    }

    /// Records what is loaded in a machine, and its lot; `by` = "" if its file says so.
    async fn set_loaded(&mut self, machine: &str, (material, lot): (&str, &str), by: &str) -> Result<()> {
        let now = self.now;
        let set = sql::query(
            "INSERT INTO loaded_material (machine, material, material_key, lot, loaded_by, loaded_at) VALUES ($1, $2, $3, $4, $5, $6) \
             ON CONFLICT (machine) DO UPDATE SET material = excluded.material, material_key = excluded.material_key, lot = excluded.lot, \
             loaded_by = excluded.loaded_by, loaded_at = excluded.loaded_at",
        );
        let set = set.bind(machine).bind(material).bind(material_key(material)).bind(lot).bind(by).bind(now);
        set.execute(self.db()).await?;
        let by = if by.is_empty() { "its file" } else { by };
        let what = if material.is_empty() { "nothing" } else { material };
        let what = if lot.is_empty() { what.to_owned() } else { format!("{what} of lot {lot}") };
        self.write_event(EventKind::Loaded, machine, None, None, &format!("{what}, as {by} says")).await
    }

    /// The builds of a machine that fired and that no printer has taken yet, with what they are made of.
    async fn unprinted_builds(&mut self, machine: &str) -> Result<Vec<(BuildId, String)>> {
        let query = sql::query_as(
            "SELECT id, material FROM build WHERE machine = $1 AND state IN ('nesting', 'verified', 'published') \
             AND taken_at IS NULL ORDER BY id",
        );
        Ok(query.bind(machine).fetch_all(self.db()).await?)
    }

    /// Calls the materials of what is not printed by their names. Returns whether one was called otherwise.
    async fn rename_materials(&mut self, name_of: &(dyn Fn(&str) -> String + Sync)) -> Result<bool> {
        let query = sql::query_as(
            "SELECT DISTINCT material, material_key FROM part WHERE state IN ('claimed', 'waiting', 'batched') AND material <> '' \
             UNION SELECT material, material_key FROM loaded_material WHERE material <> ''",
        );
        let known: Vec<(String, String)> = query.fetch_all(self.db()).await?;
        let mut is_changed = false;
        for (word, key) in known {
            let name = name_of(&word);
            if name == word && key == material_key(&name) {
                continue;
            }
            is_changed = true;
            for rename in [
                "UPDATE part SET material = $1, material_key = $2 WHERE material = $3 AND state IN ('claimed', 'waiting', 'batched')",
                "UPDATE loaded_material SET material = $1, material_key = $2 WHERE material = $3",
            ] {
                let rename = sql::query(rename).bind(&name).bind(material_key(&name)).bind(&word);
                rename.execute(self.db()).await?;
            }
            let rename = "UPDATE build SET material = $1 WHERE material = $2 AND state IN ('nesting', 'verified')";
            sql::query(rename).bind(&name).bind(&word).execute(self.db()).await?;
        }
        Ok(is_changed)
    }
}
