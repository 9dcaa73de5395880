//! How much is played in simulated months, and by which rules.

/// How much is played.
#[derive(Debug, Clone, Copy)]
pub struct MonthSize {
    /// Seed of everything.
    pub seed: u64,
    /// Number of months.
    pub months: u32,
    /// Orders of each month.
    pub orders: usize,
    /// Printers alike.
    pub printers: usize,
    /// Lines of an order.
    pub lines: usize,
    /// Volume of the parts, 1 = so much that the printers are used for half of the time.
    pub volume: f64,
    /// From when until when after its arrival an order is wished for, hours.
    pub wish_hours: (f64, f64),
}

/// How the farm decides.
#[derive(Debug, Clone, Copy)]
pub struct MonthRules {
    /// Its name in the table.
    pub name: &'static str,
    /// Whether due dates fire builds; otherwise they fire when full, or after a day.
    pub has_due_trigger: bool,
    /// Days that a part waits at most.
    pub max_wait_days: f64,
    /// Hours before a print would have to begin; `None` = the default.
    pub margin_hours: Option<f64>,
    /// Whether nothing fires before a printer can begin it at once.
    pub awaits_printer: bool,
    /// Whether each printer has a hot folder of its own.
    pub is_split: bool,
    /// Whether customers get quoted dates, and tickets the dates that keep them.
    pub has_quotes: bool,
}

impl MonthRules {
    /// The earliest due first until the build is full, or a day has passed.
    pub const SIMPLE: Self = Self {
        name: "simple: earliest due first until full, or a week old",
        has_due_trigger: false,
        max_wait_days: 7.0,
        margin_hours: None,
        awaits_printer: false,
        is_split: false,
        has_quotes: false,
    };
    /// As the farm does it, and as it is planned.
    pub const HOUSE: Self = Self { name: "plan's rule", has_due_trigger: true, max_wait_days: 1.0, ..Self::SIMPLE };

    /// The same with quotes.
    pub const fn with_quotes(self) -> Self {
        Self { has_quotes: true, ..self }
    }
}
