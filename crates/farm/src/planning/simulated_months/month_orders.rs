//! What customers ask in simulated months. The same seed gives the same orders.

use std::sync::Arc;

use jiff::{SignedDuration, Timestamp};
use ledger::{PartId, PartRow};
use ledger_fixtures::part_row;
use rand::{RngExt, seq::IndexedRandom};
use rand_chacha::ChaCha8Rng;

use super::month_size::MonthSize;

/// Median volume of a part, mm3; one part in six has e times that, or more.
const MEDIAN_MM3: f64 = 2.4e4;
/// Share of its box that a part fills.
const FILLED: f64 = 0.2;
/// Days of a month.
pub const MONTH_DAYS: u32 = 30;

/// An order.
#[derive(Debug, Clone)]
pub struct MonthOrder {
    /// When it comes.
    pub arrives_at: Timestamp,
    /// When its customer wants it.
    pub wished_at: Timestamp,
    /// Number of the hot folder that it would be dropped into, if each printer had one.
    pub folder: usize,
    /// Its parts, without due dates.
    pub parts: Vec<Arc<PartRow>>,
    /// A word that is said late, of one of its lines: when, and how many copies more; none = so many less as can be.
    pub late_word: Option<(Timestamp, usize, Option<u32>)>,
}

/// The time this many hours later.
pub fn add_hours(at: Timestamp, hours: f64) -> Timestamp {
    at.checked_add(SignedDuration::from_secs_f64(3600.0 * hours)).unwrap()
}

/// A number of a normal distribution (G. E. P. Box, M. E. Muller, "A note on the generation of random normal deviates", 1958).
pub fn draw_normal(rng: &mut ChaCha8Rng) -> f64 {
    let (one, other): (f64, f64) = (rng.random_range(f64::MIN_POSITIVE..1.0), rng.random());
    (-2.0 * one.ln()).sqrt() * (std::f64::consts::TAU * other).cos()
}

/// The orders of all months, in the sequence in which they come: on working days, from 08:00 to 18:00.
pub fn draw_orders(rng: &mut ChaCha8Rng, start: Timestamp, size: &MonthSize) -> Vec<MonthOrder> {
    let mut drawn = Vec::new();
    let mut id = 0;
    for month in 0..size.months {
        for _ in 0..size.orders {
            let day = loop {
                let day = month * MONTH_DAYS + rng.random_range(0..MONTH_DAYS);
                // The start is a Monday.
                if day % 7 < 5 {
                    break day;
                }
            };
            let arrives_at = add_hours(start, f64::from(24 * day) + rng.random_range(8.0..18.0));
            let parts: Vec<Arc<PartRow>> =
                (0..size.lines).map(|_| Arc::new(draw_part(rng, &mut id, size.volume, arrives_at))).collect();
            let late_word = rng.random_bool(0.3).then(|| {
                let said_at = add_hours(arrives_at, rng.random_range(0.3..24.0));
                let more = rng.random_bool(0.5).then(|| rng.random_range(1..3));
                (said_at, rng.random_range(0..size.lines), more)
            });
            let wished_at = add_hours(arrives_at, rng.random_range(size.wish_hours.0..size.wish_hours.1));
            drawn.push(MonthOrder {
                arrives_at,
                wished_at,
                folder: rng.random_range(0..size.printers),
                parts,
                late_word,
            });
        }
    }
    drawn.sort_by_key(|order| order.arrives_at);
    drawn
}

fn draw_part(rng: &mut ChaCha8Rng, id: &mut i64, volume: f64, arrives_at: Timestamp) -> PartRow {
    *id += 1;
    let copies = *[1, 1, 1, 2, 2, 4].choose(rng).unwrap();
    let volume_mm3 = (volume * MEDIAN_MM3 * draw_normal(rng).exp()).min(1e6);
    let edge_mm = (volume_mm3 / FILLED).cbrt();
    let mut part = part_row(PartId(*id), copies, arrives_at);
    part.measures.volume_mm3 = Some(volume_mm3);
    (part.measures.size_x_mm, part.measures.size_y_mm) = (Some(1.5 * edge_mm), Some(edge_mm));
    part.measures.size_z_mm = Some(edge_mm / 1.5);
    part
}
