//! The names that a search for a part of a name looks at: those of parts, orders and build files.
//!
//! The databases compare letters beyond ASCII differently, or not at all without regard to case. So they only leave out what cannot
//! match ([`NamePattern`]), and whoever searches compares what is left.

use serde::Serialize;

use crate::{
    BuildId, BuildState, Ledger, OrderRow, PartId, PartState, UtcTimestamp,
    base::{
        error::Result,
        name_pattern::NamePattern,
        sql::{self, sql_row},
    },
    rows::{build_row::state_word, part_row::name_with_solid},
};

/// A part with the texts by which people know it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct NamedPartRow {
    /// Its number.
    pub id: PartId,
    /// Machine.
    pub machine: String,
    /// File name as dropped.
    pub name: String,
    /// Name of the solid inside a 3MF, "" otherwise.
    pub object_name: String,
    /// Its order, "" = none.
    pub order_name: String,
    /// Who it is for, "" = not said.
    pub customer: String,
    /// What it is to be made of, "" = anything.
    pub material: String,
    /// The note that came with it.
    pub note: String,
    /// Its state.
    pub state: PartState,
}

sql_row!(NamedPartRow { id, machine, name, object_name, order_name, customer, material, note, state });

impl NamedPartRow {
    /// Name of the part together with the name of its solid.
    pub fn full_name(&self) -> String {
        name_with_solid(&self.name, &self.object_name)
    }
}

/// A build with the name of its file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NamedBuildRow {
    /// Its number.
    pub id: BuildId,
    /// Machine.
    pub machine: String,
    /// Its state.
    pub state: BuildState,
    /// When it entered its state.
    pub state_at: UtcTimestamp,
    /// When it was taken back out of the queue.
    pub withdrawn_at: Option<UtcTimestamp>,
    /// When its printer took its file out of the queue, as far as is known.
    #[serde(skip)]
    pub taken_at: Option<UtcTimestamp>,
    /// Name of the build file; `None` = it has none yet.
    pub file_name: Option<String>,
    /// Build height, mm.
    pub height_mm: Option<f64>,
    /// Copies in it.
    pub copies: Option<u32>,
}

sql_row!(NamedBuildRow { id, machine, state, state_at, withdrawn_at, taken_at, file_name, height_mm, copies });

impl NamedBuildRow {
    /// Its state for people, who call a build that was taken back out of the queue withdrawn, and not failed.
    pub fn state_word(&self) -> String {
        state_word(self.state, self.withdrawn_at)
    }
}

impl Ledger {
    /// Hands the parts whose file, solid, order, customer, material or note can match to `take`, newest first, until that returns `false`. It looks at
    /// every part that was ever taken.
    pub async fn parts_resembling(
        &self,
        pattern: &NamePattern,
        take: impl FnMut(NamedPartRow) -> bool + Send,
    ) -> Result<()> {
        let query = sql::select_as(
            "FROM part \
             WHERE lower(name || ' ' || object_name || ' ' || order_name || ' ' || customer || ' ' || material || ' ' || note) \
             LIKE $1 ESCAPE '!' ORDER BY id DESC",
        );
        Ok(query.bind(pattern.text()).for_each_while(self.reader()?, take).await?)
    }

    /// Hands the orders whose name can match to `take`, open ones first, newest first, until that returns `false`.
    pub async fn orders_resembling(
        &self,
        pattern: &NamePattern,
        take: impl FnMut(OrderRow) -> bool + Send,
    ) -> Result<()> {
        let query = sql::select_as(
            "FROM customer_order WHERE lower(name) LIKE $1 ESCAPE '!' \
             ORDER BY state <> 'open', opened_at DESC, name",
        );
        Ok(query.bind(pattern.text()).for_each_while(self.reader()?, take).await?)
    }

    /// Hands the builds whose file name can match to `take`, newest first, until that returns `false`. It looks at every build.
    pub async fn builds_resembling(
        &self,
        pattern: &NamePattern,
        take: impl FnMut(NamedBuildRow) -> bool + Send,
    ) -> Result<()> {
        let query = sql::select_as(
            "FROM build \
             WHERE lower(file_name) LIKE $1 ESCAPE '!' ORDER BY id DESC",
        );
        Ok(query.bind(pattern.text()).for_each_while(self.reader()?, take).await?)
    }

    /// The part with this number, with its names.
    pub async fn named_part(&self, id: PartId) -> Result<Option<NamedPartRow>> {
        let query = sql::select_as("FROM part WHERE id = $1");
        Ok(query.bind(id).fetch_optional(self.reader()?).await?)
    }

    /// The build with this number, with its names.
    pub async fn named_build(&self, id: BuildId) -> Result<Option<NamedBuildRow>> {
        let query = sql::select_as("FROM build WHERE id = $1");
        Ok(query.bind(id).fetch_optional(self.reader()?).await?)
    }
}
