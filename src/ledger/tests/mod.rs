//! Tests of the ledger, on real SQLite files.

mod life;
mod opening;
mod plans;
mod questions;
mod walk;

use jiff::Timestamp;

use super::{fixtures::*, *};
use crate::nest::{OrientationRule, Tilt};
