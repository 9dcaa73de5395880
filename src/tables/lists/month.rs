//! What a machine made in a month: builds, height, hours, litres, and how much of it was good.

use std::collections::{BTreeMap, BTreeSet};

use farm::{MM3_PER_LITRE, cake_litres};
use language::say;
use ledger::{BadCopies, BuildState, HistoryRow};
use schemars::JsonSchema;
use serde::Serialize;

use crate::tables::{columns::table_column::TableColumn, fields};

/// What a machine made in a span of time.
#[derive(Debug, Clone, PartialEq, Default, Serialize, JsonSchema)]
pub struct MachineOutput {
    /// Machine; "all machines" for their sum.
    pub machine: String,
    /// Published builds.
    pub builds: u32,
    /// Published builds whose print failed or was interrupted.
    pub failed_builds: u32,
    /// Sum of the heights of published builds, mm.
    pub height_mm: f64,
    /// Hours that printing them takes, by the machine's `print_hours_per_mm`; `None` = the machine is not configured any more.
    pub print_hours: Option<f64>,
    /// Volume of the parts in them, litres.
    pub part_litres: f64,
    /// Volume of their cakes, parts and powder up to the height, litres.
    pub cake_litres: f64,
    /// Fresh powder that they took, kg; `None` = not known of all of them.
    pub powder_kg: Option<f64>,
    /// Copies in them.
    pub copies: u32,
    /// Copies in prints that were told complete, without the bad ones.
    pub good_copies: u32,
    /// Copies that were printed badly.
    pub bad_copies: u32,
    /// Good copies among those of which somebody said how they came out, 0..1.
    pub yield_share: Option<f64>,
}

/// The columns of a month.
pub const MONTH_COLUMNS: &[TableColumn<MachineOutput>] = &[
    TableColumn::new("machine", fields::MACHINE, |row| (&row.machine).into()),
    TableColumn::new("builds", fields::BUILDS, |row| row.builds.into()),
    TableColumn::new("failed_builds", fields::FAILED_BUILDS, |row| row.failed_builds.into()),
    TableColumn::new("height_mm", fields::HEIGHT_SUM, |row| row.height_mm.into()),
    TableColumn::new("print_hours", fields::PRINT_HOURS, |row| row.print_hours.into()),
    TableColumn::new("part_litres", fields::PART_LITRES, |row| row.part_litres.into()),
    TableColumn::new("cake_litres", fields::CAKE_LITRES, |row| row.cake_litres.into()),
    TableColumn::new("powder_kg", fields::POWDER.unless_zero(), |row| row.powder_kg.into()),
    TableColumn::new("copies", fields::COPIES, |row| row.copies.into()),
    TableColumn::new("good_copies", fields::COPIES_GOOD, |row| row.good_copies.into()),
    TableColumn::new("bad_copies", fields::COPIES_BAD, |row| row.bad_copies.into()),
    TableColumn::new("yield_share", fields::YIELD, |row| row.yield_share.into()),
];

impl MachineOutput {
    /// What each machine made according to the history of a span of time, by name, and their sum if there are several.
    /// `hours_per_mm` says how long a machine prints for a mm of height; machines that it names are there without a build, too.
    /// `powder_kg` says what each took.
    pub fn of_history(
        rows: &[HistoryRow],
        bad: &[BadCopies],
        hours_per_mm: &BTreeMap<String, f64>,
        powder_kg: &BTreeMap<String, Option<f64>>,
    ) -> Vec<Self> {
        let names: BTreeSet<&String> = rows.iter().map(|row| &row.machine).chain(hours_per_mm.keys()).collect();
        let mut all: Vec<Self> = names
            .into_iter()
            .map(|name| {
                let own = rows.iter().filter(|row| row.machine == *name && row.is_published());
                let powder_kg = powder_kg.get(name).copied().unwrap_or(Some(0.0));
                let empty = Self { machine: name.clone(), powder_kg, ..Self::default() };
                own.fold(empty, |sum, row| sum.with_build(row, bad)).with_shares(hours_per_mm.get(name).copied())
            })
            .collect();
        if all.len() > 1 {
            all.push(Self::total_of(&all));
        }
        all
    }

    fn with_build(mut self, row: &HistoryRow, bad: &[BadCopies]) -> Self {
        let bad = bad.iter().find(|counted| counted.build == row.build).map_or(0, |counted| counted.copies);
        let (copies, measures) = (row.measures.copies.unwrap_or(0), &row.measures);
        let volume_mm3 = measures.part_volume_mm3.unwrap_or(0.0);
        self.builds += 1;
        self.failed_builds += u32::from(matches!(row.state, BuildState::Failed | BuildState::Interrupted));
        self.height_mm += measures.height_mm.unwrap_or(0.0);
        self.part_litres += volume_mm3 / MM3_PER_LITRE;
        self.cake_litres += cake_litres(volume_mm3, measures.density).unwrap_or(0.0);
        self.copies += copies;
        self.bad_copies += bad;
        if row.state == BuildState::Complete {
            self.good_copies += copies.saturating_sub(bad);
        }
        self
    }

    fn with_shares(mut self, hours_per_mm: Option<f64>) -> Self {
        let told = self.good_copies + self.bad_copies;
        self.yield_share = (told > 0).then(|| f64::from(self.good_copies) / f64::from(told));
        self.print_hours = hours_per_mm.map(|hours| hours * self.height_mm).or(self.print_hours);
        self
    }

    /// The sum over machines. A machine whose hours are not known counts as none.
    fn total_of(all: &[Self]) -> Self {
        let empty = Self { machine: say!("all-machines"), powder_kg: Some(0.0), ..Self::default() };
        let sum = all.iter().fold(empty, |sum, one| Self {
            builds: sum.builds + one.builds,
            failed_builds: sum.failed_builds + one.failed_builds,
            height_mm: sum.height_mm + one.height_mm,
            print_hours: Some(sum.print_hours.unwrap_or(0.0) + one.print_hours.unwrap_or(0.0)),
            part_litres: sum.part_litres + one.part_litres,
            cake_litres: sum.cake_litres + one.cake_litres,
            powder_kg: sum.powder_kg.zip(one.powder_kg).map(|(kg, more)| kg + more),
            copies: sum.copies + one.copies,
            good_copies: sum.good_copies + one.good_copies,
            bad_copies: sum.bad_copies + one.bad_copies,
            ..sum
        });
        sum.with_shares(None)
    }
}
