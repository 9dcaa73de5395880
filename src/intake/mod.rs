//! The hot folder: what stands in it, what has settled, and how it is claimed.
//!
//! The plot: [`Inbox::scan`] lists, [`Settler::observe`] says what may be taken, [`claim`] takes it by rename into
//! `.claimed/`, [`Store::put`] copies it to the store, and once its row is committed [`release`] lets the original go.
//! What cannot be printed goes to the error folder by [`refuse`] or [`refuse_path`], always beside a reason.
//! [`Watcher`] only says "look". After a crash [`claims`] finds what was being taken.

mod adopt;
mod archive;
mod beside;
mod cells;
mod claim;
mod claim_folder;
mod claimed;
mod code_page;
mod columns;
mod copies;
mod disk;
mod dropped;
mod given;
mod given_back;
mod ignore;
mod left_folders;
mod list_end;
mod listed;
mod marks;
mod name;
mod note;
mod order_list;
mod ready;
mod recover;
mod refuse;
mod said;
mod same_name;
mod scan;
mod seen;
mod settle;
mod status;
mod store;
mod stray;
#[cfg(test)]
mod test_inbox;
#[cfg(test)]
mod tests;
mod ticket;
#[cfg(test)]
mod tricks_tests;
mod watch;

pub use adopt::{adopt, foreign, not_let_go, taken_over};
pub use archive::{archive, purge};
pub use claim::{Released, claim, claim_as, give_back, release};
pub use claim_folder::{claim_dir, claim_id};
pub use claimed::{Claim, ClaimError};
pub use copies::copies_in_name;
pub use disk::{files_below, hash_file, read_start, write_by_rename};
pub use dropped::{open_dropped, read_reason};
pub use given::{Given, Source, TicketSource};
pub use ignore::is_ignored;
pub use left_folders::LeftFolders;
pub use list_end::{ListEnd, end_list};
pub use listed::{Judged, ListRules, Lists, Unlisted};
pub use name::{display_name, raw_name};
pub use note::Kept;
pub use order_list::{OrderList, Row};
pub use ready::Ready;
pub use recover::{Work, claims, work};
pub use refuse::{RefuseError, refuse, refuse_copy, refuse_path, rewrite_reason};
pub use said::Said;
pub use scan::{Inbox, Listing, ScanError, ScanLimits, scan};
pub use seen::{Kind, Seen};
pub use settle::{SettleRules, Settler};
pub use status::write_status;
pub use store::{Store, StoreError, Stored};
pub use stray::stray;
pub use ticket::{Due, Ticket, TicketError};
pub use watch::{WatchError, Watcher};
