//! What is wrong with a configuration: where, what, and what to do.

use std::{fmt, path::PathBuf};

use serde::Serialize;

/// One thing that is wrong with a configuration.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Problem {
    /// The file in which it stands.
    pub file: PathBuf,
    /// The line, from 1; `None` when it is about the whole file or about something that is missing.
    pub line: Option<usize>,
    /// What is wrong.
    pub text: String,
    /// What to do.
    pub remedy: String,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        write!(f, ": {}; {}", self.text, self.remedy)
    }
}
