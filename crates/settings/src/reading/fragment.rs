//! The first stage: the values of one file with their positions. All values are optional. Unknown values and values of
//! the wrong type are removed and reported, so a single run finds all problems.

use std::{
    fs,
    ops::Range,
    path::{Path, PathBuf},
};

use serde::{Deserialize, de::DeserializeOwned};
use toml::{
    Deserializer, Spanned, Table,
    de::{DeTable, DeValue},
};

use super::problem_text;
use crate::ConfigProblem;

/// Reads a file as text. Errors are added to `problems`.
pub(crate) fn read_config_text(file: &Path, problems: &mut Vec<ConfigProblem>) -> Option<String> {
    let (line, text, remedy) = match fs::read(file).map(String::from_utf8) {
        Ok(Ok(text)) => return Some(text),
        Ok(Err(error)) => {
            let lines = error.as_bytes()[..error.utf8_error().valid_up_to()].iter().filter(|&&b| b == b'\n').count();
            (Some(lines + 1), "is not UTF-8 text".to_owned(), "save it as UTF-8")
        }
        Err(error) => (None, format!("cannot be read: {error}"), "make it a file that nestd's user may read"),
    };
    problems.push(ConfigProblem { file: file.to_owned(), line, text, remedy: remedy.to_owned() });
    None
}

/// The values of a file and their positions.
#[derive(Debug)]
pub(crate) struct ConfigFragment<'t> {
    /// The file.
    pub file: PathBuf,
    text: &'t str,
    table: Spanned<DeTable<'t>>,
    removed_keys: Vec<String>,
}

impl<'t> ConfigFragment<'t> {
    /// Parses `text` as a `T`. `None` if it is not valid TOML. Values that cannot be used are removed. Both kinds of
    /// errors are added to `problems`.
    pub fn parse_toml<T: DeserializeOwned>(
        file: &Path,
        text: &'t str,
        problems: &mut Vec<ConfigProblem>,
    ) -> Option<Self> {
        let (table, errors) = DeTable::parse_recoverable(text);
        let mut fragment = Self { file: file.to_owned(), text, table, removed_keys: Vec::new() };
        for error in &errors {
            let line = error.span().map_or("", |span| text.lines().nth(fragment.line_at(span.start) - 1).unwrap_or(""));
            let problem = fragment.problem_at(error.span(), problem_text::syntax_problem_text(error.message(), line));
            // The parser may stumble over one line more than once.
            if !problems.contains(&problem) {
                problems.push(problem);
            }
        }
        if !errors.is_empty() {
            return None;
        }
        fragment.remove_invalid_values::<T>(problems);
        Some(fragment)
    }

    /// Line of a value, from 1. `key` is its dotted path, as in `trigger.copies`, or `printer.0.queue` of the first `[[printer]]`.
    pub fn line_of_key(&self, key: &str) -> Option<usize> {
        let mut table = self.table.get_ref();
        let mut steps = key.split('.').peekable();
        loop {
            let (name, value) = table.get_key_value(steps.next()?)?;
            if steps.peek().is_none() {
                return Some(self.line_at(name.span().start));
            }
            table = match value.get_ref() {
                DeValue::Array(items) => items.get(steps.next()?.parse::<usize>().ok()?)?.get_ref().as_table()?,
                value => value.as_table()?,
            };
        }
    }

    /// Whether a value was removed because it could not be used.
    pub fn was_removed(&self, key: &str) -> bool {
        self.removed_keys.iter().any(|taken| taken == key)
    }

    /// The values without their positions.
    pub fn to_table(&self) -> Table {
        Table::deserialize(Deserializer::from(self.table.clone())).unwrap_or_default()
    }

    /// Parses the table as `T` and removes the value that causes an error, until there is no error.
    fn remove_invalid_values<T: DeserializeOwned>(&mut self, problems: &mut Vec<ConfigProblem>) {
        while let Err(error) = T::deserialize(Deserializer::from(self.table.clone())) {
            let key = error.span().and_then(|span| remove_entry_at(self.table.get_mut(), &span));
            if key.is_none() {
                self.table.get_mut().clear(); // an error without a position would repeat forever
            }
            let key = key.unwrap_or_default();
            problems.push(self.problem_at(error.span(), problem_text::value_problem_text(&key, error.message())));
            self.removed_keys.push(key);
        }
    }

    fn problem_at(&self, span: Option<Range<usize>>, (text, remedy): (String, String)) -> ConfigProblem {
        ConfigProblem { file: self.file.clone(), line: span.map(|span| self.line_at(span.start)), text, remedy }
    }

    fn line_at(&self, offset: usize) -> usize {
        1 + self.text.bytes().take(offset).filter(|&b| b == b'\n').count()
    }
}

/// Removes the entry whose key or value is at `span`. Returns its dotted path.
fn remove_entry_at(table: &mut DeTable<'_>, span: &Range<usize>) -> Option<String> {
    let mut found = None;
    for (name, value) in table.iter_mut() {
        let at_value = match value.get_ref() {
            DeValue::Table(_) => value.span() == *span,
            // An error in one of its tables may be that of an entry there.
            DeValue::Array(_) => false,
            _ => value.span().contains(&span.start),
        };
        if name.span() == *span || at_value {
            found = Some(name.get_ref().to_string());
            break;
        }
        let inner = match value.get_mut() {
            DeValue::Table(inner) => remove_entry_at(inner, span),
            // The tables of a list, as `[[printer]]` begins each.
            DeValue::Array(items) => items.iter_mut().find_map(|item| match item.get_mut() {
                DeValue::Table(inner) => remove_entry_at(inner, span),
                _ => None,
            }),
            _ => None,
        };
        if let Some(key) = inner {
            return Some(format!("{}.{key}", name.get_ref()));
        }
        if matches!(value.get_ref(), DeValue::Array(_)) && value.span().contains(&span.start) {
            found = Some(name.get_ref().to_string());
            break;
        }
    }
    table.remove(found.as_deref()?);
    found
}
