//! Why a part waits for its material: a function of the part, of what is loaded, and of the materials that the settings name. The ledger
//! decides whether it waits (`ledger/parts/material`).

use language::say;
use ledger::{Ledger, LedgerError, LoadedMaterial, MachineStatus, PartRow, material_key};
use serde_json::json;
use settings::Materials;

use crate::planning::{QuoteError, QuotedPart};

/// What is known of materials at a time, read once.
#[derive(Debug, Clone, Default)]
pub struct MaterialReading {
    loaded: Vec<LoadedMaterial>,
    materials: Materials,
}

/// What is loaded, with its lot where one is said.
pub fn with_lot(material: &str, lot: &str) -> String {
    match lot {
        "" => material.to_owned(),
        lot => say!("material-lot", material = material, lot = lot),
    }
}

impl MaterialReading {
    /// Reads what is loaded. `materials` are those that the settings name.
    ///
    /// # Errors
    /// The ledger cannot be read.
    pub async fn read(ledger: &Ledger, materials: &Materials) -> Result<Self, LedgerError> {
        Ok(Self { loaded: ledger.loaded_materials().await?, materials: materials.clone() })
    }

    /// The machines that have a material loaded.
    fn machines_with(&self, material: &str) -> Vec<&str> {
        let key = material_key(material);
        let with = self.loaded.iter().filter(|loaded| material_key(&loaded.material) == key);
        with.map(|loaded| loaded.machine.as_str()).collect()
    }

    /// Where a material is loaded that is awaited, a sentence.
    fn where_loaded(&self, material: &str) -> String {
        match self.machines_with(material).join(", ") {
            _ if !self.materials.is_known(material) => {
                say!("material-unknown", material = material, known = self.materials.known_text())
            }
            none if none.is_empty() => say!("material-nowhere", material = material),
            machines => say!("material-elsewhere", material = material, machines = machines),
        }
    }

    /// Why a part waits for its material, and what ends that: two sentences each.
    pub fn why_waiting(&self, part: &PartRow) -> (String, String) {
        let (machine, material) = (part.machine.as_str(), part.terms.material.as_str());
        let own = self.loaded.iter().find(|loaded| loaded.machine == machine);
        let waits = match own {
            Some(own) => say!("material-awaited", material = material, machine = machine, loaded = &own.material),
            None => say!("material-awaited-none", material = material, machine = machine),
        };
        let load = load_command(machine, material);
        let remedy = say!("material-remedy", load = load, part = part.id.to_string());
        (format!("{waits} {}", self.where_loaded(material)), remedy)
    }

    /// Whether parts that are quoted could be in a build of their machine.
    ///
    /// # Errors
    /// One of them would wait for its material.
    pub fn ensure_loaded(&self, parts: &[QuotedPart]) -> Result<(), QuoteError> {
        let awaits = |part: &PartRow| {
            let material = part.terms.material.as_str();
            !material.is_empty() && !self.machines_with(material).contains(&part.machine.as_str())
        };
        match parts.iter().map(|part| &*part.row).find(|part| awaits(part)) {
            Some(part) => Err(QuoteError::AwaitsMaterial(format!("{}: {}", part.name, self.why_waiting(part).0))),
            None => Ok(()),
        }
    }

    /// The lines of `STATUS.txt` on what is loaded, and on what waits for another material.
    pub(crate) fn status_lines(&self, row: &MachineStatus) -> String {
        let loaded = (!row.material.is_empty())
            .then(|| say!("status-loaded", material = with_lot(&row.material, &row.lot)) + "\n");
        let awaiting = row.awaiting.iter().map(|awaiting| {
            let waits = say!("copies-await-material", copies = awaiting.copies, material = &awaiting.material);
            format!("{waits}. {}\n", self.where_loaded(&awaiting.material))
        });
        loaded.into_iter().chain(awaiting).collect()
    }

    /// What waits for another material, for `status.json`.
    pub(crate) fn status_json(&self, row: &MachineStatus) -> serde_json::Value {
        let awaiting = row.awaiting.iter().map(|awaiting| {
            json!({
                "material": awaiting.material, "parts": awaiting.parts, "copies": awaiting.copies,
                "loaded_on": self.machines_with(&awaiting.material),
            })
        });
        awaiting.collect()
    }
}

/// The command that says that a material is loaded.
fn load_command(machine: &str, material: &str) -> String {
    let is_plain = material.chars().all(|c| c.is_alphanumeric() || matches!(c, '-' | '_' | '.'));
    let word = if is_plain { material.to_owned() } else { format!("'{}'", material.replace('\'', "'\\''")) };
    format!("nestd machine load {machine} {word}")
}
