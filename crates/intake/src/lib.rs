//! The hot folder: which files it holds, which of them have settled, and how they are claimed.
//!
//! The sequence: [`InboxFolder::scan`] lists the files. [`SettleTracker::observe_scan`] reports which of them may be taken. [`claim_part`]
//! renames a part into `.claimed/`. [`ContentStore::store_file`] copies it to the store. [`release_claim`] removes the original after its
//! row is committed. [`refuse_claim`] and [`refuse_entry`] move everything that cannot be printed to the error folder, always
//! together with a reason. [`InboxWatcher`] only signals that a scan is due. After a crash, [`recover_claims`] finds the claims that
//! were in progress.

mod claim;
mod folder;
#[cfg(test)]
mod folder_lists_tests;
#[cfg(test)]
mod hostile_files_tests;
mod lists;
mod names;
#[cfg(test)]
mod order_tree_tests;
mod put;
mod spec;
#[cfg(test)]
mod test_inbox;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod text_lists_tests;

pub use claim::adopt::{adopt_claims, foreign_claims, rename_claims, taken_over_claims, unreleased_claims};
pub use claim::archive::{
    KEPT_BUILDS, archive_file, archive_material_library, is_material_library, purge_archive, purge_kept_builds,
};
pub use claim::claim::{ReleaseOutcome, claim_for_farm, claim_part, give_back_claim, release_claim};
pub use claim::dropped::{open_dropped_file, read_reason};
pub use claim::late_writing::LateWriting;
pub use claim::recover::{ClaimsOnDisk, list_claims, recover_claims};
pub use claim::refuse::{RefuseError, copy_to_error_folder, refuse_claim, refuse_entry, rewrite_reason};
pub use claim::scan::{InboxFolder, InboxListing, ScanError, ScanLimits, scan_inbox};
pub use claim::settle::{SettleRules, SettleTracker};
pub use claim::settled_entry::SettledEntry;
pub use claim::unpack::{UnpackOutcome, is_order_archive, unpack_archive};
pub use folder::claim_folder::{claim_dir, claim_id, remove_emptied_claims};
pub use folder::claim_notes::StoredContent;
pub use folder::claimed_part::{ClaimError, ClaimedPart};
pub use folder::control_file::{ControlFile, ControlKind, finish_control_file};
pub use folder::disk::{files_below, hash_file, is_temporary_name, read_start, write_file_atomically};
pub use folder::emptied_folders::EmptiedFolders;
pub use folder::file_role::{REASON_SUFFIX, is_reason_file};
pub use folder::ignore::is_ignored;
pub use folder::inbox_entry::{EntryKind, FoundList, InboxEntry};
pub use folder::misplaced::find_misplaced;
pub use folder::status::write_status;
pub use folder::store::{ContentStore, StoreError, StoredFile};
pub use folder::watch::{InboxWatcher, WatchError};
pub use lists::folder_lists::is_document;
pub use lists::list_cells::parse_due_text;
pub use lists::list_lookup::ListLookup;
pub use lists::order_list::{OrderList, OrderListRow};
pub use lists::ticket::{Ticket, TicketError};
pub use names::copies::{CopiesInName, copies_in_name, read_copies_in_name};
pub use names::copy_name::{CopyKind, CopyName, read_copy_name};
pub use names::due_date::DueDate;
pub use names::name::{display_name, raw_name};
pub use names::name_match::fold_name;
pub use put::ordered_claim::{OrderedFile, ordered_claim_id, ordered_request_id, place_ordered_claim};
pub use put::put_content::{ArrivingContent, PutContents, PutError, is_content_hash};
pub use put::put_upload::{PutUploads, UPLOAD_KEPT, UploadPart, UploadRecord, UploadState, is_upload_id};
pub use put::upload::{UploadError, UploadedFile, check_upload_name, remove_unfinished_uploads};
pub use spec::late_ticket::{LateTicket, LateTicketEnd, NamedPart};
pub use spec::list_end::{ListOutcome, finish_order_list};
pub use spec::list_tracker::{OrderListRules, OrderListTracker, TakeDecision, UnlistedPolicy};
pub use spec::part_spec::{PartSpec, ReceivedTicket, SpecSource, read_print_question, read_ticket};
