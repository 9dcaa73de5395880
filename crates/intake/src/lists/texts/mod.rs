//! Lists in plain texts: their headers, what stands above them, and texts without a header.

pub(in crate::lists) mod header;
pub(in crate::lists) mod heading;
pub(in crate::lists) mod plain_rows;
