//! The hot folder: what stands in it, what has settled, and how it is claimed.
