//! The project's own sample parts, made by code.
