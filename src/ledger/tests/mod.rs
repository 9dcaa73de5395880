//! Tests of the ledger, on real SQLite files.

mod backup;
mod lanes;
mod lifecycle;
mod migrations;
mod night_search;
mod nodes;
mod on_postgres;
mod opening;
mod order_requests;
mod orders;
mod pick;
mod printers;
mod queries;
mod query_plans;
mod random_walks;
mod shapes;
mod upgrade;
mod withdrawals;

use jiff::Timestamp;
use nester::{OrientationRule, TiltLimit};

use super::{fixtures::*, *};
