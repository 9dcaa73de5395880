//! What a printer gets: a build whose file is proved (`build`), and the queue in which that file appears exactly once and from which it is
//! taken back (`queue`). Neither knows of a farm; `nestd nest` and `nestd verify` use the first as the farm does.

#[cfg(test)]
extern crate self as delivery; // fixtures.rs is compiled in tests of nestd, too

pub mod build;
pub mod queue;
