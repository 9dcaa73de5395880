//! The first stage: one file as it was written, with the place of every value. All of it is optional; what is unknown or of
//! the wrong kind is taken out and reported, so that one reading finds every problem.

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

use super::{Problem, wording};

/// Reads a file as text; what hinders it is told in `problems`.
pub(super) fn read_text(file: &Path, problems: &mut Vec<Problem>) -> Option<String> {
    let (line, text, remedy) = match fs::read(file).map(String::from_utf8) {
        Ok(Ok(text)) => return Some(text),
        Ok(Err(error)) => {
            let lines = error.as_bytes()[..error.utf8_error().valid_up_to()].iter().filter(|&&b| b == b'\n').count();
            (Some(lines + 1), "is not UTF-8 text".to_owned(), "save it as UTF-8")
        }
        Err(error) => (None, format!("cannot be read: {error}"), "make it a file that nestd's user may read"),
    };
    problems.push(Problem { file: file.to_owned(), line, text, remedy: remedy.to_owned() });
    None
}

/// A file's values and their places.
#[derive(Debug)]
pub(super) struct Fragment<'t> {
    /// The file.
    pub file: PathBuf,
    text: &'t str,
    table: Spanned<DeTable<'t>>,
    taken_out: Vec<String>,
}

impl<'t> Fragment<'t> {
    /// Reads `text`, which should hold a `T`. `None` when it is no TOML; values that cannot be used are left out. Both are
    /// told in `problems`.
    pub fn parse<T: DeserializeOwned>(file: &Path, text: &'t str, problems: &mut Vec<Problem>) -> Option<Self> {
        let (table, errors) = DeTable::parse_recoverable(text);
        let mut fragment = Self { file: file.to_owned(), text, table, taken_out: Vec::new() };
        for error in &errors {
            problems.push(fragment.problem(error.span(), wording::of_syntax(error.message())));
        }
        if !errors.is_empty() {
            return None;
        }
        fragment.take_out_what_does_not_fit::<T>(problems);
        Some(fragment)
    }

    /// The line of a value, from 1; `key` is its path with dots, as in `trigger.copies`.
    pub fn line(&self, key: &str) -> Option<usize> {
        let mut table = self.table.get_ref();
        let mut steps = key.split('.').peekable();
        loop {
            let (name, value) = table.get_key_value(steps.next()?)?;
            if steps.peek().is_none() {
                return Some(self.line_at(name.span().start));
            }
            table = value.get_ref().as_table()?;
        }
    }

    /// Whether a value was there but could not be used.
    pub fn was_taken_out(&self, key: &str) -> bool {
        self.taken_out.iter().any(|taken| taken == key)
    }

    /// The values without their places.
    pub fn values(&self) -> Table {
        Table::deserialize(Deserializer::from(self.table.clone())).unwrap_or_default()
    }

    /// Reads the table as `T` and takes out the value that is complained of, until there is no complaint.
    fn take_out_what_does_not_fit<T: DeserializeOwned>(&mut self, problems: &mut Vec<Problem>) {
        while let Err(error) = T::deserialize(Deserializer::from(self.table.clone())) {
            let key = error.span().and_then(|span| take_out(self.table.get_mut(), &span));
            if key.is_none() {
                self.table.get_mut().clear(); // a complaint without a place must not be asked for again
            }
            let key = key.unwrap_or_default();
            problems.push(self.problem(error.span(), wording::of_value(&key, error.message())));
            self.taken_out.push(key);
        }
    }

    fn problem(&self, span: Option<Range<usize>>, (text, remedy): (String, String)) -> Problem {
        Problem { file: self.file.clone(), line: span.map(|span| self.line_at(span.start)), text, remedy }
    }

    fn line_at(&self, offset: usize) -> usize {
        1 + self.text.bytes().take(offset).filter(|&b| b == b'\n').count()
    }
}

/// Removes the entry whose key or value stands at `span`; returns its path.
fn take_out(table: &mut DeTable<'_>, span: &Range<usize>) -> Option<String> {
    let mut found = None;
    for (name, value) in table.iter_mut() {
        let at_value = match value.get_ref() {
            DeValue::Table(_) => value.span() == *span,
            _ => value.span().contains(&span.start),
        };
        if name.span() == *span || at_value {
            found = Some(name.get_ref().to_string());
            break;
        }
        if let DeValue::Table(inner) = value.get_mut()
            && let Some(key) = take_out(inner, span)
        {
            return Some(format!("{}.{key}", name.get_ref()));
        }
    }
    table.remove(found.as_deref()?);
    found
}
