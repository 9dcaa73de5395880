//! A ledger that is opened when somebody first needs it.

use std::sync::Arc;

use tokio::sync::OnceCell;

use crate::{Ledger, LedgerAddress, LedgerUser, base::error::Result};

/// A ledger that is opened when it is first needed. Clones share its connections.
#[derive(Clone)]
pub struct LedgerOnDemand {
    user: LedgerUser,
    opened: Arc<OnceCell<Ledger>>,
}

impl LedgerOnDemand {
    /// Nothing is opened yet.
    pub fn for_user(user: LedgerUser) -> Self {
        Self { user, opened: Arc::default() }
    }

    /// The ledger at `at`, which is the same each time.
    ///
    /// # Errors
    /// As [`Ledger::open_existing`]; it is tried again the next time.
    pub async fn get(&self, at: &LedgerAddress) -> Result<Ledger> {
        Ok(self.opened.get_or_try_init(|| Ledger::open_existing_for(at, self.user)).await?.clone())
    }
}
