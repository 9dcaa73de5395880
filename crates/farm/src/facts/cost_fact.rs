//! What builds cost, and which order bears which share: the one answer for command line, pages, CSV and programs.
//!
//! A build costs its machine time (height x `print_hours_per_mm`) x `per_hour`, the volume of its parts x `per_litre`, and its copies x
//! `per_part`, at the rates that held when it was made. Machine time and powder are shared by volume, as in a quote; litres and copies are
//! each order's own. The farm bears copies that were told to be bad. A build is rounded to the hundredth, and its shares are rounded so that
//! their sum is the build.

use std::collections::BTreeMap;

use anyhow::Result;
use ledger::{BuildId, CostQuery, CostedBuild, Ledger, OrderedCopies, UtcTimestamp};
use schemars::JsonSchema;
use serde::Serialize;
use settings::{CostRules, MachineProfile, Money, PriceSum};

/// Cubic millimetres of a litre.
pub const MM3_PER_LITRE: f64 = 1e6;

/// What an order bears of a build.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct CostShare {
    /// The build.
    pub build: BuildId,
    /// When it was published.
    pub published_at: UtcTimestamp,
    /// Machine.
    pub machine: String,
    /// What it is made of; "" = not known.
    pub material: String,
    /// Order; "" = copies without one.
    pub order_name: String,
    /// Who it is for; "" = not said.
    pub customer: String,
    /// Whether these copies were told to be bad: the farm bears them, and not the order.
    pub is_bad: bool,
    /// Its copies in the build.
    pub copies: u32,
    /// Their volume, litres.
    pub part_litres: f64,
    /// Its share of the machine time, hours.
    pub print_hours: f64,
    /// Its share of the fresh powder, kg; `None` = the density of the powder or of the build is not known.
    pub powder_kg: Option<f64>,
    /// Its share of the cost.
    pub price: Money,
    /// Currency of the price.
    pub currency: String,
}

/// What an order, or the farm for bad copies, bears of all builds asked for: a line of an invoice.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct OrderCost {
    /// Order; "" = copies without one.
    pub order_name: String,
    /// Who it is for; "" = not said.
    pub customer: String,
    /// What its copies are made of; "" = not known.
    pub material: String,
    /// Whether these copies were told to be bad: the farm bears them, and not the order.
    pub is_bad: bool,
    /// Builds with its copies.
    pub builds: u32,
    /// Its copies in them.
    pub copies: u32,
    /// Their volume, litres.
    pub part_litres: f64,
    /// Its share of the machine time, hours.
    pub print_hours: f64,
    /// Its share of the fresh powder, kg; `None` = not known of all of them.
    pub powder_kg: Option<f64>,
    /// Its share of the cost.
    pub price: Money,
    /// Currency of the price.
    pub currency: String,
}

/// What the builds asked for cost.
#[derive(Debug, Clone, PartialEq, Default, Serialize, JsonSchema)]
pub struct CostReport {
    /// All of it, by currency, without those in which nothing has a price.
    pub totals: Vec<PriceSum>,
    /// Lines of invoices: what each order bears, and last what the farm bears.
    pub orders: Vec<OrderCost>,
    /// What each order bears of each build, the earliest build first.
    pub shares: Vec<CostShare>,
}

impl CostReport {
    /// Reads what the builds that match cost; of an order, its own shares alone. `machines` are the present ones: a build of an earlier nestd has no rates of its own.
    pub async fn read(ledger: &Ledger, query: &CostQuery, machines: &BTreeMap<String, MachineProfile>) -> Result<Self> {
        Ok(Self::of_shares(read_cost_shares(ledger, query, machines).await?))
    }

    fn of_shares(shares: Vec<CostShare>) -> Self {
        Self { totals: price_sums(&shares), orders: OrderCost::of_shares(&shares), shares }
    }

    /// Fresh powder that the builds of each machine took, kg; `None` = not known of all of them.
    pub fn powder_of_machines(&self) -> BTreeMap<String, Option<f64>> {
        let mut powder: BTreeMap<String, Option<f64>> = BTreeMap::new();
        for share in &self.shares {
            let sum = powder.entry(share.machine.clone()).or_insert(Some(0.0));
            *sum = sum.zip(share.powder_kg).map(|(kg, more)| kg + more);
        }
        powder
    }

    /// What one order bears of it, by currency.
    pub fn sums_of_order(&self, order_name: &str) -> Vec<PriceSum> {
        price_sums(self.shares.iter().filter(|share| share.order_name == order_name && !share.is_bad))
    }
}

async fn read_cost_shares(
    ledger: &Ledger,
    query: &CostQuery,
    machines: &BTreeMap<String, MachineProfile>,
) -> Result<Vec<CostShare>> {
    let (builds, copies) = ledger.cost_basis(query).await?;
    let mut by_build: BTreeMap<BuildId, Vec<OrderedCopies>> = BTreeMap::new();
    for ordered in copies {
        by_build.entry(ordered.build).or_default().push(ordered);
    }
    let mut shares = Vec::new();
    let is_asked = |share: &CostShare| query.order_name.as_ref().is_none_or(|name| *name == share.order_name);
    for build in builds {
        let (name, snapshot) = (&build.machine, build.profile_snapshot.as_deref());
        let made = MachineProfile::from_snapshot(name, snapshot, machines.get(name));
        let copies = by_build.remove(&build.build).unwrap_or_default();
        let all = share_build(&build, &copies, made.space.print_hours_per_mm, &made.costs);
        shares.extend(all.into_iter().filter(is_asked));
    }
    Ok(shares)
}

/// Volume of the cake of a build, parts and powder up to its height, litres: its density is the share that is parts.
pub fn cake_litres(part_volume_mm3: f64, density: Option<f64>) -> Option<f64> {
    density.filter(|density| *density > 0.0).map(|density| part_volume_mm3 / density / MM3_PER_LITRE)
}

/// Shares the cost of a build among the orders in it.
fn share_build(build: &CostedBuild, copies: &[OrderedCopies], hours_per_mm: f64, rules: &CostRules) -> Vec<CostShare> {
    let hours = build.height_mm * hours_per_mm;
    let all_mm3: f64 = copies.iter().map(|ordered| ordered.volume_mm3).sum();
    let share_of = |ordered: &OrderedCopies| if all_mm3 > 0.0 { ordered.volume_mm3 / all_mm3 } else { 0.0 };
    let price_of = |ordered: &OrderedCopies| {
        rules.price(share_of(ordered) * hours, ordered.volume_mm3 / MM3_PER_LITRE, ordered.copies)
    };
    let prices: Vec<f64> = copies.iter().map(price_of).collect();
    let prices = round_to_sum(&prices);
    let cake_litres = cake_litres(build.part_volume_mm3, build.density).filter(|_| rules.powder_kg_per_litre > 0.0);
    let powder_kg = cake_litres.map(|litres| litres * rules.powder_kg_per_litre * rules.refresh);
    let shares = copies.iter().zip(prices).map(|(ordered, price)| CostShare {
        build: build.build,
        published_at: build.published_at,
        machine: build.machine.clone(),
        material: build.material.clone(),
        order_name: ordered.order_name.clone(),
        customer: ordered.customer.clone(),
        is_bad: ordered.is_bad,
        copies: ordered.copies,
        part_litres: ordered.volume_mm3 / MM3_PER_LITRE,
        print_hours: share_of(ordered) * hours,
        powder_kg: powder_kg.map(|kg| share_of(ordered) * kg),
        price,
        currency: rules.currency.clone(),
    });
    shares.collect()
}

/// Rounds amounts to hundredths so that their sum is the rounded sum: those with the largest remainders are rounded up.
fn round_to_sum(amounts: &[f64]) -> Vec<Money> {
    let floor = |amount: f64| (amount * 100.0 + 1e-6).floor();
    let mut rounded: Vec<Money> = amounts.iter().map(|&amount| Money(floor(amount) as i64)).collect();
    let missing = Money::rounded(amounts.iter().sum()).0 - rounded.iter().map(|money| money.0).sum::<i64>();
    let mut by_remainder: Vec<usize> = (0..amounts.len()).collect();
    let remainder = |at: usize| amounts[at] * 100.0 - floor(amounts[at]);
    by_remainder.sort_by(|&a, &b| remainder(b).total_cmp(&remainder(a)));
    for &at in by_remainder.iter().take(usize::try_from(missing).unwrap_or(0)) {
        rounded[at].0 += 1;
    }
    rounded
}

impl OrderCost {
    /// Adds shares up, by order, customer, material and currency; what the farm bears comes last.
    pub fn of_shares(shares: &[CostShare]) -> Vec<Self> {
        let key = |share: &CostShare| {
            let CostShare { is_bad, order_name, customer, material, currency, .. } = share.clone();
            (is_bad, order_name, customer, material, currency)
        };
        let mut sums: BTreeMap<_, Self> = BTreeMap::new();
        for share in shares {
            sums.entry(key(share)).and_modify(|sum| sum.add(share)).or_insert_with(|| Self::of_share(share));
        }
        sums.into_values().collect()
    }

    fn of_share(share: &CostShare) -> Self {
        let CostShare { order_name, customer, material, is_bad, currency, .. } = share.clone();
        let CostShare { copies, part_litres, print_hours, powder_kg, price, .. } = *share;
        Self {
            order_name,
            customer,
            material,
            is_bad,
            builds: 1,
            copies,
            part_litres,
            print_hours,
            powder_kg,
            price,
            currency,
        }
    }

    fn add(&mut self, share: &CostShare) {
        self.builds += 1;
        self.copies += share.copies;
        self.part_litres += share.part_litres;
        self.print_hours += share.print_hours;
        self.powder_kg = self.powder_kg.zip(share.powder_kg).map(|(kg, more)| kg + more);
        self.price.0 += share.price.0;
    }
}

fn price_sums<'s>(shares: impl IntoIterator<Item = &'s CostShare>) -> Vec<PriceSum> {
    let mut totals: BTreeMap<&str, Money> = BTreeMap::new();
    for share in shares {
        totals.entry(&share.currency).or_default().0 += share.price.0;
    }
    let priced = totals.into_iter().filter(|(_, sum)| sum.0 != 0);
    priced.map(|(currency, price)| PriceSum { price, currency: currency.to_owned() }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn build(height_mm: f64) -> CostedBuild {
        CostedBuild {
            build: BuildId(7),
            machine: "left".to_owned(),
            published_at: UtcTimestamp(jiff::Timestamp::UNIX_EPOCH),
            material: "PA12".to_owned(),
            height_mm,
            density: Some(0.1),
            part_volume_mm3: 4e6,
            profile_snapshot: None,
        }
    }

    fn copies(order: &str, is_bad: bool, copies: u32, litres: f64) -> OrderedCopies {
        OrderedCopies {
            build: BuildId(7),
            order_name: order.to_owned(),
            customer: String::new(),
            is_bad,
            copies,
            volume_mm3: litres * 1e6,
        }
    }

    fn rules() -> CostRules {
        CostRules { per_hour: 30.0, per_litre: 50.0, per_part: 0.5, powder_kg_per_litre: 0.5, ..CostRules::default() }
    }

    #[test]
    fn hours_and_powder_are_shared_by_volume_and_the_shares_are_the_build_to_the_hundredth() {
        // 100 mm at 0.1 h/mm: 10 h, 300.00. Litres 3 and 1, copies 10 and 2.
        let both = [copies("a", false, 10, 3.0), copies("b", false, 2, 1.0)];
        let shares = share_build(&build(100.0), &both, 0.1, &rules());
        assert_eq!((shares[0].price, shares[1].price), (Money(38_000), Money(12_600)));
        assert_eq!((shares[0].print_hours, shares[1].print_hours), (7.5, 2.5));
        // The cake has 40 l, all of fresh powder.
        assert_eq!((shares[0].powder_kg, shares[1].powder_kg), (Some(15.0), Some(5.0)));
        let used = share_build(&build(100.0), &both, 0.1, &CostRules { refresh: 0.5, ..rules() });
        assert_eq!(used[0].powder_kg, Some(7.5));
        let unknown = share_build(&build(100.0), &both, 0.1, &CostRules { powder_kg_per_litre: 0.0, ..rules() });
        assert_eq!(unknown[0].powder_kg, None);
    }

    #[test]
    fn what_is_rounded_off_is_no_money_lost_or_made() {
        for thirds in 1..200 {
            let three: Vec<_> = (0..3).map(|at| copies(&at.to_string(), false, 1, 1.0)).collect();
            let shares = share_build(
                &build(f64::from(thirds)),
                &three,
                0.01,
                &CostRules { per_part: 0.0, per_litre: 0.0, ..rules() },
            );
            let sum: i64 = shares.iter().map(|share| share.price.0).sum();
            assert_eq!(sum, Money::rounded(f64::from(thirds) * 0.3).0, "{thirds}");
            assert!(shares[0].price.0 - shares[2].price.0 <= 1 && shares[0].price >= shares[2].price);
        }
        assert_eq!(round_to_sum(&[]), []);
        assert_eq!(round_to_sum(&[0.0, 0.0]), [Money(0), Money(0)]);
    }

    #[test]
    fn the_farm_bears_what_came_out_bad() {
        let three = [copies("a", false, 1, 1.0), copies("a", true, 1, 1.0), copies("", false, 1, 1.0)];
        let report = CostReport::of_shares(share_build(&build(100.0), &three, 0.1, &rules()));
        assert_eq!(report.totals.iter().map(ToString::to_string).collect::<Vec<_>>(), ["451.50 EUR"]);
        assert_eq!(report.sums_of_order("a")[0].price, Money(15_050));
        let lines: Vec<_> = report.orders.iter().map(|line| (line.order_name.as_str(), line.is_bad)).collect();
        assert_eq!(lines, [("", false), ("a", false), ("a", true)]);
        let free = CostReport::of_shares(share_build(&build(100.0), &three, 0.1, &CostRules::default()));
        assert!(free.totals.is_empty() && free.orders.len() == 3);
        // A cake of 40 l.
        assert_eq!(report.powder_of_machines()["left"].map(f64::round), Some(20.0));
        assert_eq!(free.powder_of_machines()["left"], None);
    }
}
