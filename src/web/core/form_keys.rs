//! Keys of forms: each names one form of one page that this daemon made.

/// Makes the keys of forms, and knows those that it made: no other site can make one.
pub(crate) struct FormKeys([u8; 32]);

impl Default for FormKeys {
    fn default() -> Self {
        Self(rand::random())
    }
}

impl FormKeys {
    /// A key for one form: its number, and the proof that it comes from here.
    pub(crate) fn make_key(&self) -> String {
        let number = format!("{:032x}", rand::random::<u128>());
        format!("{number}-{}", self.proof_of(&number))
    }

    fn proof_of(&self, number: &str) -> blake3::Hash {
        blake3::keyed_hash(&self.0, number.as_bytes())
    }

    /// Whether this daemon made a key.
    pub(crate) fn is_own(&self, key: &str) -> bool {
        let proof = key.split_once('-').and_then(|(_, proof)| blake3::Hash::from_hex(proof).ok());
        proof.is_some_and(|proof| proof == self.proof_of(number_of(key)))
    }
}

/// The number of a form: what the ledger keeps of its key.
pub(crate) fn number_of(key: &str) -> &str {
    key.split('-').next().unwrap_or_default()
}
