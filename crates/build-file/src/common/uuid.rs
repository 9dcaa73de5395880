//! UUIDs of the production extension. They are derived from content, so that the same build gives the same file.

/// A UUID in the layout of version 5, from the BLAKE3 hash of the words. Each word is followed by a zero byte, so that
/// different lists of words give different UUIDs.
pub(crate) fn derive_uuid(words: &[&str]) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(b"nestd uuid\0");
    for word in words {
        hasher.update(word.as_bytes());
        hasher.update(b"\0");
    }
    let mut bytes: [u8; 16] = hasher.finalize().as_bytes()[..16].try_into().expect("a hash has 32 bytes");
    bytes[6] = bytes[6] & 0x0f | 0x50;
    bytes[8] = bytes[8] & 0x3f | 0x80;
    let hex: String = bytes.iter().map(|b| format!("{b:02x}")).collect();
    format!("{}-{}-{}-{}-{}", &hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..])
}

#[cfg(test)]
mod tests {
    use super::derive_uuid;

    #[test]
    fn a_uuid_depends_on_each_word_and_on_nothing_else() {
        assert_eq!(derive_uuid(&["a", "b"]), derive_uuid(&["a", "b"]));
        assert_ne!(derive_uuid(&["a", "b"]), derive_uuid(&["ab", ""]));
        let text = derive_uuid(&["a"]);
        assert_eq!((text.len(), &text[14..15], text.matches('-').count()), (36, "5", 4));
    }
}
