//! A problem of the configuration: where it is, what is wrong, and what to do.

use std::{fmt, path::PathBuf};

use serde::Serialize;

/// One problem of the configuration.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ConfigProblem {
    /// The file concerned.
    pub file: PathBuf,
    /// The line, from 1; `None` if it concerns the whole file or something that is missing.
    pub line: Option<usize>,
    /// What is wrong.
    pub text: String,
    /// What to do.
    pub remedy: String,
}

impl fmt::Display for ConfigProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        write!(f, ": {}; {}", self.text, self.remedy)
    }
}
