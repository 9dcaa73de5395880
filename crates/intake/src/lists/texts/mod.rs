//! Lists in plain texts.

pub(in crate::lists) mod plain_rows;
