//! The printer queue folder: how a build file appears in it exactly once.
