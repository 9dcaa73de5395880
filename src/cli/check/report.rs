//! What was looked at, what was found and what to do.

use std::path::PathBuf;

use anyhow::Result;
use build_file::visible_lines;
use serde::Serialize;

use crate::settings::Problem;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum Level {
    Ok,
    /// Worth knowing, not wrong.
    Note,
    /// Probably not as it was meant, though the daemon can work.
    Warning,
    Problem,
}

/// One thing that was looked at.
#[derive(Debug, Clone, Serialize)]
struct Finding {
    level: Level,
    /// What was looked at, as in "inbox of fuse-1".
    what: String,
    text: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    remedy: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<PathBuf>,
    #[serde(skip_serializing_if = "Option::is_none")]
    line: Option<usize>,
}

/// All findings, in the order of looking.
#[derive(Debug, Default)]
pub struct Report {
    findings: Vec<Finding>,
}

impl Report {
    /// All is well with `what`.
    pub fn ok(&mut self, what: &str, text: impl Into<String>) {
        self.add(Level::Ok, what, text.into(), None);
    }

    /// Something worth knowing that hinders nothing.
    pub fn note(&mut self, what: &str, text: impl Into<String>) {
        self.add(Level::Note, what, text.into(), None);
    }

    /// Something is probably not as it was meant.
    pub fn warning(&mut self, what: &str, text: impl Into<String>, remedy: impl Into<String>) {
        self.add(Level::Warning, what, text.into(), Some(remedy.into()));
    }

    /// Something is wrong.
    pub fn problem(&mut self, what: &str, text: impl Into<String>, remedy: impl Into<String>) {
        self.add(Level::Problem, what, text.into(), Some(remedy.into()));
    }

    /// Something is wrong in a configuration file.
    pub fn configuration_problem(&mut self, problem: Problem) {
        let Problem { file, line, text, remedy } = problem;
        let what = "configuration".to_owned();
        self.findings.push(Finding { level: Level::Problem, what, text, remedy: Some(remedy), file: Some(file), line });
    }

    /// How much is wrong.
    pub fn problems(&self) -> usize {
        self.count(Level::Problem)
    }

    fn count(&self, level: Level) -> usize {
        self.findings.iter().filter(|finding| finding.level == level).count()
    }

    /// Prints it to standard output.
    pub fn print(&self, json: bool) -> Result<()> {
        if json {
            let value = serde_json::json!({ "problems": self.problems(), "findings": self.findings });
            println!("{}", serde_json::to_string_pretty(&value)?);
            return Ok(());
        }
        for finding in &self.findings {
            print_line(finding);
        }
        let warnings = match self.count(Level::Warning) {
            0 => String::new(),
            1 => ", 1 warning".to_owned(),
            several => format!(", {several} warnings"),
        };
        match self.problems() {
            0 => println!("No problem found{warnings}."),
            1 => println!("1 problem found{warnings}."),
            several => println!("{several} problems found{warnings}."),
        }
        Ok(())
    }

    fn add(&mut self, level: Level, what: &str, text: String, remedy: Option<String>) {
        let text = visible_lines(&text);
        self.findings.push(Finding { level, what: what.to_owned(), text, remedy, file: None, line: None });
    }
}

fn print_line(finding: &Finding) {
    let level = match finding.level {
        Level::Ok => "ok",
        Level::Note => "note",
        Level::Warning => "WARNING",
        Level::Problem => "PROBLEM",
    };
    let place = match (&finding.file, finding.line) {
        (Some(file), Some(line)) => format!("{}:{line}", file.display()),
        (Some(file), None) => file.display().to_string(),
        (None, _) => finding.what.clone(),
    };
    println!("{level:<8}{place}: {}", finding.text);
    if let Some(remedy) = &finding.remedy {
        println!("        -> {remedy}");
    }
}
