//! The pages, one file each. A page decides nothing: what it shows comes from the ledger or the farm.

pub(super) mod build;
pub(super) mod costs;
pub(super) mod downloads;
pub(super) mod farm;
pub(super) mod flush;
pub(super) mod history;
pub(super) mod live;
pub(super) mod month;
pub(super) mod needs;
pub(super) mod order;
pub(super) mod part;
pub(super) mod pick_page;
pub(super) mod report;
pub(super) mod search;
