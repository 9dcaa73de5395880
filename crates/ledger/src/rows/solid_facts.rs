//! What reading the file of a part found, and what that file asks for it itself.

use build_file::LengthUnit;
use nester::OrientationRule;

use super::part_row::{PartTerms, RequiredTilts};

/// Data of one solid of a file, found by reading the file.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidFacts {
    /// Index of the solid in the file, from 0. Solid 0 uses the row of the claim itself.
    pub object_index: u32,
    /// Name of the solid inside a 3MF, "" otherwise.
    pub object_name: String,
    /// Copies of this solid in all: those ordered times the build items in the file. A part that is read again keeps its own.
    pub copies: u32,
    /// Copies of it that the file itself holds.
    pub file_copies: u32,
    /// Triangles.
    pub triangles: u64,
    /// Volume, mm3.
    pub volume_mm3: f64,
    /// Bounds as dropped, mm.
    pub size_mm: [f64; 3],
    /// Unit of a file that states none, in which it was read.
    pub read_unit: LengthUnit,
    /// What a person must confirm before it is printed, "" = nothing. It is not asked again once it was confirmed.
    pub question: String,
    /// Name of the file of which its file is a copy, as the name of that says; "" = of none.
    pub copy_of: String,
    /// Warnings, one sentence each, added to those of the claim.
    pub warnings: Vec<String>,
    /// What was done to its mesh; `None` = it is as it was dropped.
    pub mended: Option<MendedFacts>,
    /// What the file asks for it itself; `None` = nothing. Not asked again when it is read once more.
    pub request: Option<RequestedTerms>,
}

/// What was done to a mesh that was mended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MendedFacts {
    /// In words, with measures.
    pub text: String,
    /// BLAKE3 of the mended mesh, 64 hex digits.
    pub hash: String,
}

impl SolidFacts {
    /// Adds to what a person must confirm; "" = nothing.
    pub fn ask(&mut self, doubt: &str) {
        let between = if self.question.is_empty() || doubt.is_empty() { "" } else { "; " };
        self.question.push_str(&format!("{between}{doubt}"));
    }
}

/// What the file of a part asks for it itself, as CAMSPEC packages do. `None` = not said: then the terms of the file's claim hold.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RequestedTerms {
    /// What the customer's own system calls the line.
    pub reference: String,
    /// What it is to be made of.
    pub material: Option<String>,
    /// Priority from 0 to 100.
    pub priority: Option<u8>,
    /// Its own clearance, mm.
    pub clearance_mm: Option<f64>,
    /// Orientation rule.
    pub orientation: Option<OrientationRule>,
    /// Directions that must point nearly straight up, beside those of the claim.
    pub tilts: RequiredTilts,
}

impl PartTerms {
    /// These terms with what the file asks for itself.
    pub fn with_request(mut self, request: &RequestedTerms) -> Self {
        self.reference.clone_from(&request.reference);
        self.priority = request.priority.unwrap_or(self.priority);
        self.material = request.material.clone().unwrap_or(self.material);
        // Nobody asked for less than either.
        self.clearance_mm = request.clearance_mm.into_iter().chain(self.clearance_mm).reduce(f64::max);
        self.orientation = request.orientation.unwrap_or(self.orientation);
        for tilt in &request.tilts.0 {
            if !self.tilts.0.contains(tilt) {
                self.tilts.0.push(*tilt);
            }
        }
        self
    }
}
