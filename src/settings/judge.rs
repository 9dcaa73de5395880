//! Collects what is wrong with values, each with the file and line it comes from.

use std::{fmt::Display, ops::RangeInclusive, path::PathBuf};

use super::{Problem, fragment::Fragment};

/// Looks values up in the files they may come from, and takes note of what is wrong with them.
#[derive(Debug)]
pub(super) struct Judge<'a> {
    /// Fragments and what stands before the keys in them; the first that has a key is where its value comes from.
    places: Vec<(&'a Fragment<'a>, &'static str)>,
    /// What was found.
    pub problems: Vec<Problem>,
}

impl<'a> Judge<'a> {
    /// A judge of values that come from these places, the first being asked first.
    pub fn new(places: Vec<(&'a Fragment<'a>, &'static str)>) -> Self {
        Self { places, problems: Vec::new() }
    }

    /// File and line where the value of `key` comes from; the first file when nobody gives it.
    pub fn place(&self, key: &str) -> (PathBuf, Option<usize>) {
        let given = self
            .places
            .iter()
            .find_map(|(fragment, before)| Some((fragment, fragment.line(&format!("{before}{key}"))?)));
        match given {
            Some((fragment, line)) => (fragment.file.clone(), Some(line)),
            None => (self.places.first().map(|(fragment, _)| fragment.file.clone()).unwrap_or_default(), None),
        }
    }

    /// Takes note that something is wrong with `key`.
    pub fn object(&mut self, key: &str, text: String, remedy: impl Into<String>) {
        let (file, line) = self.place(key);
        self.problems.push(Problem { file, line, text, remedy: remedy.into() });
    }

    /// Objects when `value` is outside `range`, or is not a number.
    pub fn within<T: PartialOrd + Display>(&mut self, key: &str, value: T, range: RangeInclusive<T>) {
        if !range.contains(&value) {
            let remedy = format!("give a number from {} to {}", range.start(), range.end());
            self.object(key, format!("{key} = {value} makes no sense"), remedy);
        }
    }
}
