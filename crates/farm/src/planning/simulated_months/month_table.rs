//! What is told of simulated months, as a table of Markdown: means of the months with 95 % intervals.

use jiff::Timestamp;

use super::month_orders::MONTH_DAYS;

/// The head of the table.
pub const TABLE_HEAD: &str = "| rule | late orders, % | after the date wished for, % | builds | mm | printer hours | hours to delivery | \
    hours to the quoted date | quoted after the wish, % |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|";

/// The figures of a month.
#[derive(Debug, Clone, Default, PartialEq)]
struct MonthFigures {
    orders: u32,
    /// Orders done after the date that counts: the promised one, else the one that was wished for.
    late: u32,
    /// Orders done after the date that was wished for.
    after_wish: u32,
    lead_hours: f64,
    quotes_after_wish: u32,
    quoted_hours: f64,
    builds: u32,
    height_mm: f64,
    printer_hours: f64,
}

/// The figures of months.
#[derive(Debug, Clone, PartialEq)]
pub struct MonthReport {
    start: Timestamp,
    months: Vec<MonthFigures>,
}

impl MonthReport {
    /// A report of nothing yet.
    pub fn new(start: Timestamp, months: u32) -> Self {
        Self { start, months: vec![MonthFigures::default(); months as usize] }
    }

    /// The month of a time; what is done after the last one belongs to it.
    fn month_of(&mut self, at: Timestamp) -> &mut MonthFigures {
        let days = at.duration_since(self.start).as_secs_f64() / 86_400.0;
        let last = self.months.len() - 1;
        &mut self.months[((days / f64::from(MONTH_DAYS)) as usize).min(last)]
    }

    /// Adds a build.
    pub fn note_build(&mut self, at: Timestamp, height_mm: f64, hours: f64) {
        let month = self.month_of(at);
        (month.builds, month.height_mm) = (month.builds + 1, month.height_mm + height_mm);
        month.printer_hours += hours;
    }

    /// Adds an order that is done, to the month in which it came.
    pub fn note_order(&mut self, arrived: Timestamp, done: Timestamp, date: Timestamp, wished: Timestamp) {
        let month = self.month_of(arrived);
        month.orders += 1;
        month.late += u32::from(done > date);
        month.after_wish += u32::from(done > wished);
        month.lead_hours += done.duration_since(arrived).as_secs_f64() / 3600.0;
    }

    /// Adds a quote.
    pub fn note_quote(&mut self, at: Timestamp, kept: Timestamp, wished: Timestamp) {
        let month = self.month_of(at);
        month.quotes_after_wish += u32::from(kept > wished);
        month.quoted_hours += kept.duration_since(at).as_secs_f64() / 3600.0;
    }

    /// Orders that are done.
    pub fn orders(&self) -> u32 {
        self.months.iter().map(|month| month.orders).sum()
    }

    /// Share of orders that were done by their date.
    pub fn kept_share(&self) -> f64 {
        1.0 - f64::from(self.months.iter().map(|month| month.late).sum::<u32>()) / f64::from(self.orders())
    }

    /// Mean of the months and half of its 95 % interval.
    fn mean(&self, value: impl Fn(&MonthFigures) -> f64) -> String {
        let values: Vec<f64> = self.months.iter().map(value).collect();
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
        format!("{mean:.1} ± {:.1}", 2.09 * (variance / count).sqrt())
    }

    /// Its row of the table.
    pub fn table_row(&self, name: &str) -> String {
        let percent = |count: u32, of: u32| 100.0 * f64::from(count) / f64::from(of.max(1));
        let cells = [
            self.mean(|month| percent(month.late, month.orders)),
            self.mean(|month| percent(month.after_wish, month.orders)),
            self.mean(|month| f64::from(month.builds)),
            self.mean(|month| month.height_mm),
            self.mean(|month| month.printer_hours),
            self.mean(|month| month.lead_hours / f64::from(month.orders.max(1))),
            self.mean(|month| month.quoted_hours / f64::from(month.orders.max(1))),
            self.mean(|month| percent(month.quotes_after_wish, month.orders)),
        ];
        format!("| {name} | {} |", cells.join(" | "))
    }
}
