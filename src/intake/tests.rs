//! The hot folder as people use it: real copies, real clocks, real events.
