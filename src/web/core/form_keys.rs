//! Keys of forms: each names one form of one page that a daemon of this farm made.

use ledger::{Ledger, LedgerError};

/// The secret of the keys, in the ledger.
const SECRET: &str = "form keys";

/// Makes the keys of forms, and knows those that were made in this farm, by any of its nodes: no other site can make one.
pub(crate) struct FormKeys([u8; 32]);

impl FormKeys {
    /// Those of the farm with this ledger. The first daemon chooses their secret by chance.
    pub(crate) async fn of_farm(ledger: &Ledger) -> Result<Self, LedgerError> {
        let proposed = blake3::Hash::from_bytes(rand::random());
        let chosen = ledger.farm_secret(SECRET, &proposed.to_hex()).await?;
        Ok(Self(*blake3::Hash::from_hex(&chosen).unwrap_or(proposed).as_bytes()))
    }

    /// A key for one form: its number, and the proof that it comes from here.
    pub(crate) fn make_key(&self) -> String {
        let number = format!("{:032x}", rand::random::<u128>());
        format!("{number}-{}", self.proof_of(&number))
    }

    fn proof_of(&self, number: &str) -> blake3::Hash {
        blake3::keyed_hash(&self.0, number.as_bytes())
    }

    /// Whether a daemon of this farm made a key.
    pub(crate) fn is_own(&self, key: &str) -> bool {
        let proof = key.split_once('-').and_then(|(_, proof)| blake3::Hash::from_hex(proof).ok());
        proof.is_some_and(|proof| proof == self.proof_of(number_of(key)))
    }
}

/// The number of a form: what the ledger keeps of its key.
pub(crate) fn number_of(key: &str) -> &str {
    key.split('-').next().unwrap_or_default()
}
