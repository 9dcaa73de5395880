//! Collects problems with values, each with the file and line of the value.

use std::{
    fmt::Display,
    ops::RangeInclusive,
    path::{Path, PathBuf},
};

use super::fragment::ConfigFragment;
use crate::ConfigProblem;

/// Collects problems and locates the values concerned in the files.
#[derive(Debug)]
pub(crate) struct ConfigValidator<'a> {
    /// Fragments with the prefix of their keys. A value comes from the first fragment that has its key.
    sources: Vec<(&'a ConfigFragment<'a>, &'static str)>,
    /// The problems found.
    pub problems: Vec<ConfigProblem>,
}

impl<'a> ConfigValidator<'a> {
    /// Creates a validator for values from these fragments, in order of precedence.
    pub fn new(places: Vec<(&'a ConfigFragment<'a>, &'static str)>) -> Self {
        Self { sources: places, problems: Vec::new() }
    }

    /// File and line of the value of `key`. If no file sets it: the first file, without a line.
    pub fn locate_key(&self, key: &str) -> (PathBuf, Option<usize>) {
        let given = self
            .sources
            .iter()
            .find_map(|(fragment, before)| Some((fragment, fragment.line_of_key(&format!("{before}{key}"))?)));
        match given {
            Some((fragment, line)) => (fragment.file.clone(), Some(line)),
            None => (self.sources.first().map(|(fragment, _)| fragment.file.clone()).unwrap_or_default(), None),
        }
    }

    /// Reports a problem with `key`.
    pub fn report_problem(&mut self, key: &str, text: String, remedy: impl Into<String>) {
        let (file, line) = self.locate_key(key);
        self.problems.push(ConfigProblem { file, line, text, remedy: remedy.into() });
    }

    /// Reports a problem if `value` is outside `range` or is not a number.
    pub fn require_within<T: PartialOrd + Display>(&mut self, key: &str, value: T, range: RangeInclusive<T>) {
        if !range.contains(&value) {
            let remedy = format!("give a number from {} to {}", range.start(), range.end());
            self.report_problem(key, format!("{key} = {value} makes no sense"), remedy);
        }
    }
    /// Reports surprising paths: an empty path means the folder above, and `~` is only known to shells.
    pub fn require_path(&mut self, key: &str, path: &Path) {
        if path.as_os_str().is_empty() {
            self.report_problem(key, format!("{key} is empty"), "name a folder or leave the option out");
        } else if path.starts_with("~") {
            self.report_problem(key, format!("{key}: \"~\" means nothing in a configuration"), "write the whole path");
        }
    }
}
