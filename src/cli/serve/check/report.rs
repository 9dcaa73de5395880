//! The findings of a check: what was checked, what was found, and the remedy.

use std::path::PathBuf;

use anyhow::Result;
use build_file::escape_invisible_lines;
use serde::Serialize;
use settings::ConfigProblem;

use crate::cli::terminal::{
    table::{print_json, print_text},
    terminal::LinePaint,
};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum FindingLevel {
    Ok,
    /// Worth knowing, not wrong.
    Note,
    /// Probably not as intended, but the daemon can work.
    Warning,
    Problem,
}

/// The result of one check.
#[derive(Debug, Clone, Serialize)]
struct CheckFinding {
    level: FindingLevel,
    /// What was checked, as in "inbox of fuse-1".
    what: String,
    text: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    remedy: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<PathBuf>,
    #[serde(skip_serializing_if = "Option::is_none")]
    line: Option<usize>,
}

/// All findings, in the order of the checks.
#[derive(Debug, Default)]
pub struct CheckReport {
    findings: Vec<CheckFinding>,
}

impl CheckReport {
    /// Nothing is wrong with `what`.
    pub fn add_ok(&mut self, what: &str, text: impl Into<String>) {
        self.add_finding(FindingLevel::Ok, what, text.into(), None);
    }

    /// Something worth knowing that is no problem.
    pub fn add_note(&mut self, what: &str, text: impl Into<String>) {
        self.add_finding(FindingLevel::Note, what, text.into(), None);
    }

    /// Something is probably not as intended.
    pub fn add_warning(&mut self, what: &str, text: impl Into<String>, remedy: impl Into<String>) {
        self.add_finding(FindingLevel::Warning, what, text.into(), Some(remedy.into()));
    }

    /// Something is wrong.
    pub fn add_problem(&mut self, what: &str, text: impl Into<String>, remedy: impl Into<String>) {
        self.add_finding(FindingLevel::Problem, what, text.into(), Some(remedy.into()));
    }

    /// Something is wrong in a configuration file.
    pub fn add_configuration_problem(&mut self, problem: ConfigProblem) {
        let ConfigProblem { file, line, text, remedy } = problem;
        let what = "configuration".to_owned();
        self.findings.push(CheckFinding {
            level: FindingLevel::Problem,
            what,
            text,
            remedy: Some(remedy),
            file: Some(file),
            line,
        });
    }

    /// The number of problems.
    pub fn problem_count(&self) -> usize {
        self.count_level(FindingLevel::Problem)
    }

    fn count_level(&self, level: FindingLevel) -> usize {
        self.findings.iter().filter(|finding| finding.level == level).count()
    }

    /// Prints the findings to standard output.
    pub fn print_findings(&self, json: bool) -> Result<()> {
        if json {
            let value = serde_json::json!({ "problems": self.problem_count(), "findings": self.findings });
            return print_json(&value);
        }
        self.findings.iter().try_for_each(print_finding)?;
        let warnings = match self.count_level(FindingLevel::Warning) {
            0 => String::new(),
            1 => ", 1 warning".to_owned(),
            several => format!(", {several} warnings"),
        };
        match self.problem_count() {
            0 => print_text(&format!("No problem found{warnings}.")),
            1 => print_text(&format!("1 problem found{warnings}.")),
            several => print_text(&format!("{several} problems found{warnings}.")),
        }
    }

    fn add_finding(&mut self, level: FindingLevel, what: &str, text: String, remedy: Option<String>) {
        let text = escape_invisible_lines(&text);
        self.findings.push(CheckFinding { level, what: what.to_owned(), text, remedy, file: None, line: None });
    }
}

fn print_finding(finding: &CheckFinding) -> Result<()> {
    let (level, paint) = match finding.level {
        FindingLevel::Ok => ("ok", LinePaint::Good),
        FindingLevel::Note => ("note", LinePaint::Plain),
        FindingLevel::Warning => ("WARNING", LinePaint::Doubtful),
        FindingLevel::Problem => ("PROBLEM", LinePaint::Bad),
    };
    let level = paint.mark(&format!("{level:<8}"));
    let place = match (&finding.file, finding.line) {
        (Some(file), Some(line)) => format!("{}:{line}", file.display()),
        (Some(file), None) => file.display().to_string(),
        (None, _) => finding.what.clone(),
    };
    print_text(&format!("{level}{place}: {}", finding.text))?;
    match &finding.remedy {
        Some(remedy) => print_text(&format!("        -> {remedy}")),
        None => Ok(()),
    }
}
