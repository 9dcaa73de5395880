//! What an order list says about one part, as stored in the claim of the part.

use std::{
    io::{self, Write},
    path::Path,
};

use serde::{Deserialize, Serialize};

use super::order_list::MAX_LIST_BYTES;
use crate::folder::{disk, file_role::LIST_NAME};

/// What an order list says about one part. It is stored in the claim of the part.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ListLookup {
    /// The header of the list and the row of the part: a valid list with only this row.
    pub row: Option<String>,
    /// Name of the list, escaped for display; "" = `order.csv`.
    #[serde(default)]
    pub list_name: String,
    /// File name as written in the row.
    pub file: Option<String>,
    /// File names as written in rows that mean the part and cannot be used for it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unused_rows: Vec<String>,
    /// Why the number of copies is unknown.
    pub problem: Option<String>,
    /// Whether the reason is that the list does not name the part.
    #[serde(default)]
    pub is_unlisted: bool,
    /// Warnings for the technician, in whole sentences.
    pub warnings: Vec<String>,
    /// Why the number of copies is asked for, unless a ticket or the name says it.
    #[serde(default)]
    pub question: Option<String>,
    /// The claim of what was taken of the same file before its writer went on. The part takes the place of that one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rewrites: Option<String>,
}

impl ListLookup {
    /// The name of the list.
    pub(crate) fn shown_list_name(&self) -> &str {
        if self.list_name.is_empty() { LIST_NAME } else { &self.list_name }
    }

    /// Writes it into a claim.
    pub(crate) fn save_to(&self, path: &Path) -> io::Result<()> {
        let mut file = disk::create_fresh_file(path)?;
        file.write_all(&serde_json::to_vec(self)?)?;
        file.sync_all()
    }

    /// Reads it from a claim. `None` = there is none, or a crash truncated it.
    pub(crate) fn load_from(path: &Path) -> io::Result<Option<Self>> {
        let bytes = disk::read_start(path, 4 * MAX_LIST_BYTES)?;
        Ok(bytes.and_then(|bytes| serde_json::from_slice(&bytes).ok()))
    }
}
