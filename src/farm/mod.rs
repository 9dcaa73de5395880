//! The service: one file per step of a part's life, one event loop.
