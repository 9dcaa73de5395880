//! The hot folder: which files it holds, which of them have settled, and how they are claimed.
//!
//! The sequence: [`InboxFolder::scan`] lists the files. [`SettleTracker::observe_scan`] reports which of them may be taken. [`claim_part`]
//! renames a part into `.claimed/`. [`ContentStore::store_file`] copies it to the store. [`release_claim`] removes the original after its
//! row is committed. [`refuse_claim`] and [`refuse_entry`] move everything that cannot be printed to the error folder, always
//! together with a reason. [`InboxWatcher`] only signals that a scan is due. After a crash, [`recover_claims`] finds the claims that
//! were in progress.

mod adopt;
mod archive;
mod claim;
mod claim_folder;
mod claim_notes;
mod claimed_part;
mod code_page;
mod control_file;
mod copies;
mod copies_sizes;
mod copies_words;
mod copy_name;
mod disk;
mod dropped;
mod due_date;
mod emptied_folders;
mod file_role;
mod folder_lists;
#[cfg(test)]
mod folder_lists_tests;
mod given_back;
#[cfg(test)]
mod hostile_files_tests;
mod ignore;
mod inbox_entry;
mod late_ticket;
mod late_writing;
mod list_cells;
mod list_columns;
mod list_end;
mod list_extras;
mod list_lookup;
mod list_tracker;
mod loaded_list;
mod misplaced;
mod name;
mod name_match;
mod order_folders;
mod order_list;
mod ordered_claim;
mod part_spec;
mod put_content;
mod put_upload;
mod recover;
mod refuse;
mod row_state;
mod scan;
mod served_rows;
mod settle;
mod settled_entry;
mod sidecars;
mod status;
mod store;
#[cfg(test)]
mod test_inbox;
#[cfg(test)]
mod tests;
mod ticket;
mod unordered_folder;
mod upload;
mod watch;

pub use adopt::{adopt_claims, foreign_claims, rename_claims, taken_over_claims, unreleased_claims};
pub use archive::{KEPT_BUILDS, archive_file, purge_archive, purge_kept_builds};
pub use claim::{ReleaseOutcome, claim_for_farm, claim_part, give_back_claim, release_claim};
pub use claim_folder::{claim_dir, claim_id};
pub use claim_notes::StoredContent;
pub use claimed_part::{ClaimError, ClaimedPart};
pub use control_file::{ControlFile, ControlKind, finish_control_file};
pub use copies::{CopiesInName, MAX_COPIES, copies_in_name, read_copies_in_name};
pub use copy_name::{CopyKind, CopyName, read_copy_name};
pub use disk::{files_below, hash_file, is_temporary_name, read_start, write_file_atomically};
pub use dropped::{open_dropped_file, read_reason};
pub use due_date::DueDate;
pub use emptied_folders::EmptiedFolders;
pub use ignore::is_ignored;
pub use inbox_entry::{EntryKind, FoundList, InboxEntry};
pub use late_ticket::{LateTicket, LateTicketEnd, NamedPart};
pub use late_writing::LateWriting;
pub use list_cells::parse_due_text;
pub use list_end::{ListOutcome, finish_order_list};
pub use list_lookup::ListLookup;
pub use list_tracker::{OrderListRules, OrderListTracker, TakeDecision, UnlistedPolicy};
pub use misplaced::find_misplaced;
pub use name::{display_name, raw_name};
pub use name_match::fold_name;
pub use order_list::{OrderList, OrderListRow};
pub use ordered_claim::{OrderedFile, ordered_claim_id, ordered_request_id, place_ordered_claim};
pub use part_spec::{
    COPIES_QUESTION, PartSpec, ReceivedTicket, SpecSource, is_copies_question, read_print_question, read_ticket,
};
pub use put_content::{ArrivingContent, PutContents, PutError, is_content_hash};
pub use put_upload::{PutUploads, UPLOAD_KEPT, UploadPart, UploadRecord, UploadState, is_upload_id};
pub use recover::{ClaimsOnDisk, list_claims, recover_claims};
pub use refuse::{RefuseError, copy_to_error_folder, refuse_claim, refuse_entry, rewrite_reason};
pub use scan::{InboxFolder, InboxListing, ScanError, ScanLimits, scan_inbox};
pub use settle::{SettleRules, SettleTracker};
pub use settled_entry::SettledEntry;
pub use status::write_status;
pub use store::{ContentStore, StoreError, StoredFile};
pub use ticket::{Ticket, TicketError};
pub use upload::{UploadError, UploadedFile, check_upload_name, remove_unfinished_uploads};
pub use watch::{InboxWatcher, WatchError};
