//! What may be taken out of the hot folder, or is to be refused.

use super::{Said, Seen};

/// What may be taken out of the hot folder now. It is said again at every scan for as long as the thing stands there.
#[derive(Debug, Clone, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "nearly all are parts, and each is used up at once")]
pub enum Ready {
    /// A part, to be claimed with what belongs to it.
    Part {
        /// The part.
        part: Seen,
        /// Its sidecar tickets (`part.stl.toml`, or `part.toml` where no other part is called so; or `.json`): none or one;
        /// two are refused when they are read.
        tickets: Vec<Seen>,
        /// The `order.csv` of its folder.
        list: Option<Seen>,
        /// What that list says about it, once [`Lists::judge`](super::Lists::judge) has looked.
        said: Option<Said>,
        /// So long it and its list have stood unchanged, seconds.
        still_secs: f64,
        /// Whether it stood still for [`SettleRules::unfinished_secs`](super::SettleRules::unfinished_secs) without its end: probably truncated.
        unfinished: bool,
    },
    /// An `order.csv` that stands still, for [`end_list`](super::end_list).
    List {
        /// The list.
        list: Seen,
        /// So long it has stood unchanged, in an order folder with all that stands beside it, seconds.
        quiet_secs: f64,
    },
    /// No part: to be moved to the error folder by [`refuse_path`](super::refuse_path).
    Refuse {
        /// What stands there.
        seen: Seen,
        /// Why, and what to do, in plain words.
        reason: String,
    },
}
