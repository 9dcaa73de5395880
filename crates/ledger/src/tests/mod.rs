//! Tests of the ledger, on real SQLite files.

mod closed_orders;
mod lifecycle;
mod material;
mod night_search;
mod nodes;
mod on_postgres;
mod order_requests;
mod orders;
mod people;
mod pick;
mod printers;
mod put_back;
mod store;
mod told_words;
mod withdrawals;

use jiff::Timestamp;
use nester::{OrientationRule, TiltLimit};

use super::{fixtures::*, *};
