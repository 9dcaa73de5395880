//! `[materials]`: what the materials of the farm are called, and the words that people use for them.

use std::collections::BTreeMap;

use ledger::{MaterialError, material_key};

use crate::reading::validator::ConfigValidator;

/// The materials of the farm. Where none is named, each word is a material.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Materials {
    /// The name for each word, by [`material_key`].
    names: BTreeMap<String, String>,
    /// The names, in the order of the alphabet.
    known: Vec<String>,
}

impl Materials {
    /// The name of a material for which people use this word; a word that is not known stays as it is. "" = any.
    pub fn name_of(&self, word: &str) -> String {
        let word = word.trim();
        self.names.get(&material_key(word)).map_or(word, String::as_str).to_owned()
    }

    /// Whether a word may name a material here.
    pub fn is_known(&self, word: &str) -> bool {
        let key = material_key(word);
        key.is_empty() || self.known.is_empty() || self.names.contains_key(&key)
    }

    /// The names of all materials; "" where none is named.
    pub fn known_text(&self) -> String {
        self.known.join(", ")
    }

    /// The name for a word.
    ///
    /// # Errors
    /// It is not known here.
    pub fn require_name(&self, word: &str) -> Result<String, MaterialError> {
        match self.is_known(word) {
            true => Ok(self.name_of(word)),
            false => Err(MaterialError::Unknown { word: word.trim().to_owned(), known: self.known_text() }),
        }
    }
}

/// Validates the materials of the farm.
pub(crate) fn validate_materials(inputs: &BTreeMap<String, Vec<String>>, validator: &mut ConfigValidator) -> Materials {
    let mut materials = Materials { known: inputs.keys().cloned().collect(), ..Materials::default() };
    for (name, words) in inputs {
        for word in [name].into_iter().chain(words) {
            let key = material_key(word);
            if key.is_empty() {
                let text = format!("materials: \"{}\" of {name} is no word for a material", word.escape_debug());
                validator.report_problem("materials", text, "write a word, as in PA12 = [\"PA 12\", \"Nylon 12\"]");
            } else if let Some(other) = materials.names.insert(key, name.clone()).filter(|other| other != name) {
                let text = format!("materials: \"{}\" means {other} and {name}", word.escape_debug());
                let remedy = "leave it at one of them; case, spaces, hyphens and underscores make no difference";
                validator.report_problem("materials", text, remedy);
            }
        }
    }
    materials
}
