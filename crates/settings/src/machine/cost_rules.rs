//! What the builds of a machine cost: the rates of `[costs]`. A build keeps those that held when it was made.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize, Serializer};

use crate::reading::validator::ConfigValidator;

/// Greatest rate.
const MAX_RATE: f64 = 1e6;
/// Letters and signs of the longest name of a currency.
const MAX_CURRENCY: usize = 8;

/// An amount of money, in hundredths of its currency. Programs get it in the currency.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, JsonSchema)]
#[schemars(with = "f64")]
pub struct Money(pub i64);

impl Money {
    /// Rounds an amount in its currency.
    pub fn rounded(amount: f64) -> Self {
        Self((amount * 100.0).round() as i64)
    }

    /// The amount in its currency.
    pub fn amount(self) -> f64 {
        self.0 as f64 / 100.0
    }
}

impl Serialize for Money {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_f64(self.amount())
    }
}

/// A price in its currency.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct PriceSum {
    /// The price.
    pub price: Money,
    /// Its currency.
    pub currency: String,
}

impl fmt::Display for PriceSum {
    /// In the language that is current: `1234.50 EUR`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", language::decimal(format!("{:.2}", self.price.amount())), self.currency)
    }
}

/// `[costs]` of a machine: what its builds cost, and what they take of powder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CostRules {
    /// Currency of the rates, as people write it.
    pub currency: String,
    /// Price of an hour of machine time.
    pub per_hour: f64,
    /// Price of a litre of parts.
    pub per_litre: f64,
    /// Price of a copy.
    pub per_part: f64,
    /// Density of the powder in the build, kg/l; 0 = not known.
    pub powder_kg_per_litre: f64,
    /// Share of fresh powder in what a build is filled with, 0..1.
    pub refresh: f64,
}

impl Default for CostRules {
    fn default() -> Self {
        Self {
            currency: "EUR".to_owned(),
            per_hour: 0.0,
            per_litre: 0.0,
            per_part: 0.0,
            powder_kg_per_litre: 0.0,
            refresh: 1.0,
        }
    }
}

impl CostRules {
    /// What so many hours of machine time, litres of parts and copies cost, in the currency.
    pub fn price(&self, hours: f64, litres: f64, copies: u32) -> f64 {
        hours * self.per_hour + litres * self.per_litre + f64::from(copies) * self.per_part
    }

    /// Whether anything has a price.
    pub fn has_prices(&self) -> bool {
        self.per_hour > 0.0 || self.per_litre > 0.0 || self.per_part > 0.0
    }

    pub(crate) fn validate(&self, validator: &mut ConfigValidator) {
        for (key, rate) in
            [("costs.per_hour", self.per_hour), ("costs.per_litre", self.per_litre), ("costs.per_part", self.per_part)]
        {
            validator.require_within(key, rate, 0.0..=MAX_RATE);
        }
        validator.require_within("costs.powder_kg_per_litre", self.powder_kg_per_litre, 0.0..=20.0);
        validator.require_within("costs.refresh", self.refresh, 0.0..=1.0);
        let is_word = |c: char| !c.is_control() && !c.is_whitespace();
        if !(1..=MAX_CURRENCY).contains(&self.currency.chars().count()) || !self.currency.chars().all(is_word) {
            let text = format!("costs.currency = \"{}\" is no currency", self.currency.escape_debug());
            validator.report_problem("costs.currency", text, "write it in 1 to 8 letters or signs: \"EUR\", \"$\"");
        }
    }
}
