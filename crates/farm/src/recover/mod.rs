//! May this daemon act on its ledger; a ledger is put back, or moved to another database.

pub(super) mod ledger_copy;
pub(super) mod ledger_service;
pub(super) mod restore;
