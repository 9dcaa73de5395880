//! Lists in other folders that may mean a part: they are asked about.

use std::path::Path;

use super::list_tracker::OrderListTracker;
use crate::{
    InboxEntry, ListLookup,
    lists::folder_lists::{is_foreign, shown_name},
    names::name_match::means_file_below,
};

impl OrderListTracker {
    /// A list is for the files of its folder and of the folders below, and one in the hot folder itself only for those beside it. If
    /// another one names a part all the same, or cannot be read, it is asked how many copies are meant, unless its ticket or name
    /// says it.
    pub(super) fn question_of_other_list(&mut self, inbox: &Path, part: &InboxEntry) -> Option<ListLookup> {
        let why = self.question_of_list_above(inbox, part).or_else(|| self.sheet_above(inbox, part));
        why.or_else(|| self.question_of_list_aside(inbox, part))
            .map(|why| ListLookup { question: Some(why), ..ListLookup::default() })
    }

    /// The list of the hot folder itself may name a part in a folder below. Those of order folders speak for what is below them.
    fn question_of_list_above(&mut self, inbox: &Path, part: &InboxEntry) -> Option<String> {
        let list = self.lists.get(inbox)?.clone();
        let relative = part.path.strip_prefix(inbox).ok()?.to_str()?;
        let rows = self.load_list(inbox, &list).ok()?.list.rows().ok()?;
        let is_named = rows.iter().any(|row| means_file_below(&row.file, relative, false));
        let why = "in a folder above names it, but a list is for the files of its own folder";
        is_named.then(|| format!("{} {why}", shown_name(&list)))
    }

    /// A list in another folder of the same order may name the part.
    fn question_of_list_aside(&mut self, inbox: &Path, part: &InboxEntry) -> Option<String> {
        let order = part.path.strip_prefix(inbox).ok()?.parent()?.iter().next()?;
        let (order, name) = (inbox.join(order), part.path.file_name()?.to_str()?.to_owned());
        let mut lists: Vec<InboxEntry> =
            self.lists.values().filter(|list| list.path.starts_with(&order)).cloned().collect();
        lists.sort_by(|a, b| a.path.cmp(&b.path));
        let names_part = |list: &InboxEntry| {
            let rows = self.load_list(inbox, list).ok()?.list.rows().ok()?;
            let last = |said: &str| said.rsplit(['/', '\\']).next().unwrap_or_default().to_owned();
            let is_named = rows.iter().any(|row| means_file_below(&last(&row.file), &name, true));
            let why =
                "in another folder of the order names it, but a list is for the files of its own folder and below";
            is_named.then(|| format!("{} {why}", shown_name(list)))
        };
        lists.iter().find_map(names_part)
    }

    /// A spreadsheet in an order folder above a part may name it.
    fn sheet_above(&self, inbox: &Path, part: &InboxEntry) -> Option<String> {
        let above = part.path.ancestors().skip(2).take_while(|folder| *folder != inbox && folder.starts_with(inbox));
        let mut rivals = above.filter_map(|folder| self.rivals.get(folder)).flat_map(|rivals| &rivals.rivals);
        let sheet = rivals.find(|rival| is_foreign(rival))?;
        Some(format!("{} in a folder above is a list that nestd does not read", shown_name(sheet)))
    }
}
