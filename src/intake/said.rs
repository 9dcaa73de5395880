//! What an order list says about one part, as it lies in the part's claim.

use std::{
    io::{self, Write},
    path::Path,
};

use serde::{Deserialize, Serialize};

use super::{disk, order_list::MAX_LIST_BYTES};

/// What a list says about one part; it lies in the part's claim.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Said {
    /// The list's header and the part's row: a list of this row alone.
    pub row: Option<String>,
    /// The file as the row calls it.
    pub file: Option<String>,
    /// Why its copies are not known.
    pub problem: Option<String>,
    /// Whether that is because the list does not name it.
    #[serde(default)]
    pub is_unlisted: bool,
    /// For the technician, in whole sentences.
    pub warnings: Vec<String>,
}

impl Said {
    /// Writes it into a claim.
    pub(super) fn save(&self, path: &Path) -> io::Result<()> {
        let mut file = disk::create_anew(path)?;
        file.write_all(&serde_json::to_vec(self)?)?;
        file.sync_all()
    }

    /// Reads it out of a claim; `None` = there is none, or a crash cut it short.
    pub(super) fn load(path: &Path) -> io::Result<Option<Self>> {
        let bytes = disk::read_start(path, 4 * MAX_LIST_BYTES)?;
        Ok(bytes.and_then(|bytes| serde_json::from_slice(&bytes).ok()))
    }
}
