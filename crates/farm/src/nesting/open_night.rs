//! What an open build knows of the search that lowers it while it waits.

use ledger::NightSearchRow;

use super::layout_search::LayoutSearch;
use crate::decisions::layout::BatchLayout;

/// The search that lowers an open build while it waits.
#[derive(Debug, Default)]
pub struct OpenNight {
    /// Whether the ledger was asked how far it is, and knows it.
    pub is_known: bool,
    /// How far it is; `None` = it has not begun, or is switched off.
    pub row: Option<NightSearchRow>,
    /// The search that runs.
    pub search: Option<LayoutSearch>,
}

impl OpenNight {
    /// Stops the search that runs, because something else needs its thread. It goes on later.
    pub fn stop(&self) {
        if let Some(search) = &self.search {
            search.stop();
        }
    }

    /// Keeps how far it is until the ledger has stored it.
    pub fn keep_unsaved(&mut self, row: NightSearchRow) {
        (self.row, self.is_known) = (Some(row), false);
    }

    /// How far it is, if the ledger could not store it.
    pub fn unsaved_row(&self) -> Option<&NightSearchRow> {
        self.row.as_ref().filter(|_| !self.is_known)
    }

    /// Ends the search for good, because other copies or rules count now. Returns its best layout, if it has found any.
    pub fn end(&mut self) -> Option<BatchLayout> {
        self.stop();
        std::mem::take(self).search?.best_layout()
    }
}
