//! Tests of the ledger, on real SQLite files.

mod backup;
mod life;
mod migrations;
mod opening;
mod plans;
mod questions;
mod shapes;
mod walk;

use jiff::Timestamp;
use nester::{OrientationRule, Tilt};

use super::{fixtures::*, *};
