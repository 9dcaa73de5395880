//! What stands above the table of a list: `Customer: Meier`, `Delivery date;11.12.2026`. It is said of each row.

use build_file::{check_email, check_name, check_priority, escape_invisible};

use super::header::for_each_record;
use crate::{
    Ticket,
    lists::{
        list_cells::{bare_cell, is_placeholder, parse_due_cell, parse_whole_number},
        list_columns::{ListColumn, meaning_of_label},
    },
};

/// Above this priority, people mean the scale of nestd.
const MAX_SMALL_PRIORITY: u8 = 5;

/// The lines above a table.
#[derive(Debug, Default)]
pub(in crate::lists) struct Heading {
    /// What they say of each row that does not say it itself.
    pub ticket: Ticket,
    /// The lines as received, where they say something, for a list with only one of the rows.
    pub text: String,
    /// Lines with a known word that cannot be read, in whole sentences.
    pub warnings: Vec<String>,
}

impl Heading {
    pub fn read(above: &str, delimiter: u8) -> Self {
        let mut heading = Self::default();
        // Where the lines are no table, nothing is read.
        let _ = for_each_record(above, delimiter, |record, _| {
            let cells: Vec<&str> = record.iter().map(bare_cell).filter(|cell| !cell.is_empty()).collect();
            if let Some((column, values)) = split_label(&cells) {
                let read = match values[..] {
                    [] => return true,
                    [value] if is_placeholder(value) => return true,
                    [value] => read_value(column, value),
                    _ => Err("it has several values".to_owned()),
                };
                match read {
                    Ok(said) => heading.ticket = std::mem::take(&mut heading.ticket).merge_weaker(said),
                    Err(_) => heading.warnings.push(format!(
                        "The line {:?} above the table of its order list was not read.",
                        escape_invisible(&cells.join(" "))
                    )),
                }
            }
            true
        });
        if heading.ticket != Ticket::default() {
            heading.text = format!("{}\n", above.trim_matches(['\r', '\n']));
        }
        heading
    }
}

/// The meaning and the values of a line such as `Customer: Meier`.
fn split_label<'a>(cells: &[&'a str]) -> Option<(ListColumn, Vec<&'a str>)> {
    let (first, rest) = cells.split_first()?;
    let (label, value) = first.split_once([':', '：', '=']).unwrap_or((first, ""));
    let column = meaning_of_label(label)?;
    let values = [value.trim()].into_iter().filter(|value| !value.is_empty()).chain(rest.iter().copied());
    Some((column, values.collect()))
}

fn read_value(column: ListColumn, value: &str) -> Result<Ticket, String> {
    let mut said = Ticket::default();
    match column {
        ListColumn::Due => said.due = Some(parse_due_cell(value)?),
        ListColumn::Order => said.order = Some(check_name("order", value)?),
        ListColumn::Customer => said.customer = Some(check_name("customer", value)?),
        ListColumn::Email => said.email = Some(check_email(value)?),
        ListColumn::Material => said.material = Some(check_name("material", value)?),
        ListColumn::Priority => said.priority = Some(check_priority(parse_whole_number("priority", value)?)?),
        _ => return Err("it is said of each row alone".to_owned()),
    }
    Ok(said)
}

/// Warns where all priorities are as low as those of people for whom 1 is the most urgent.
pub(in crate::lists) fn priority_warning(said: impl Iterator<Item = u8>) -> Option<String> {
    let most = said.max().filter(|most| *most <= MAX_SMALL_PRIORITY)?;
    Some(format!(
        "The highest priority of its order list is {most}, of 100 for the most urgent part: that is below the 50 of a part without \
         a priority. Change the part with `nestd edit PART --priority N` where it is more urgent."
    ))
}
