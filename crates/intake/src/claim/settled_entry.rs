//! Entries of the hot folder that have settled and may be taken or refused.

use std::ffi::OsString;

use crate::{ControlKind, InboxEntry, ListLookup};

/// An entry that has settled. It is reported again at every scan while it is in the hot folder.
#[derive(Debug, Clone, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "nearly all are parts, and each is used up at once")]
pub enum SettledEntry {
    /// A part, to be claimed together with its tickets.
    Part {
        /// The part.
        part: InboxEntry,
        /// Its sidecar tickets: `part.stl.toml`, or `part.toml` if no other part has that short name, or the same with
        /// `.json`. None or one; two are refused when they are read.
        tickets: Vec<InboxEntry>,
        /// The order list of its folder.
        list: Option<InboxEntry>,
        /// What that list says about the part; set by [`OrderListTracker::judge`](crate::OrderListTracker::check_against_list).
        lookup: Option<ListLookup>,
        /// Time that the part and its list have been unchanged, seconds.
        still_secs: f64,
        /// Whether its end is missing and it was unchanged for
        /// [`SettleRules::unfinished_secs`](crate::SettleRules::unfinished_secs): the file is probably truncated.
        unfinished: bool,
    },
    /// A part beside a ticket that cannot be read, or a text that may be meant as one. The part waits;
    /// [`OrderListTracker::check_against_list`](crate::OrderListTracker::check_against_list) refuses it in the end.
    Blocked {
        /// The part.
        part: InboxEntry,
        /// What it waits for: a sentence about the sidecar.
        reason: String,
        /// Time that both, or their whole order folder, have been unchanged, seconds.
        still_secs: f64,
    },
    /// An order list that has settled, for [`end_list`](crate::finish_order_list).
    List {
        /// The list.
        list: InboxEntry,
        /// Time that the list has been unchanged, seconds; in an order folder, time that the whole folder has been
        /// unchanged.
        quiet_secs: f64,
    },
    /// A list beside another one, or a spreadsheet. The parts of its folder wait;
    /// [`OrderListTracker::check_against_list`](crate::OrderListTracker::check_against_list) refuses it in the end.
    RivalList {
        /// The list.
        rival: InboxEntry,
        /// Time that the list, or its whole order folder, has been unchanged, seconds.
        quiet_secs: f64,
    },
    /// A ticket without a part in its folder. Its part may have been taken before, which the ledger knows.
    Orphan {
        /// The ticket.
        ticket: InboxEntry,
        /// The part that it names, perhaps without extension.
        part_name: OsString,
        /// Why it is refused, once it has waited for [`SettleRules::orphan_secs`](crate::SettleRules::orphan_secs).
        expiry_reason: Option<String>,
    },
    /// An empty file that gives a command, such as `FLUSH`.
    Control {
        /// The file.
        file: InboxEntry,
        /// Its command.
        kind: ControlKind,
    },
    /// Not a part: to be moved to the error folder by [`refuse_entry`](crate::refuse_entry).
    Refuse {
        /// The entry.
        seen: InboxEntry,
        /// The reason and the remedy, in plain words.
        reason: String,
    },
}
