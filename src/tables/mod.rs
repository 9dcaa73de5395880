//! What people and programs see of the farm, defined in one place: the label, unit and format of each field, and the
//! columns of each table with their keys in JSON and CSV. The command line, the pages and the files are made from
//! these lists.

mod build_sheet;
mod cell_value;
mod field_definition;
pub mod fields;
mod history;
mod machine_status;
mod month;
mod node_list;
mod order_list;
mod part_list;
mod part_sheet;
mod pick_list;
mod plan_list;
mod printer_list;
mod table_column;
mod time_view;

pub use build_sheet::{EVENT_COLUMNS, ORDER_EVENT_COLUMNS, OUTCOME_COLUMNS, build_facts, height as height_in_volume};
pub use cell_value::CellValue;
pub use field_definition::{FieldDefinition, SheetFact};
pub use history::{HEIGHT_SUM_COLUMNS, HISTORY_COLUMNS};
pub use machine_status::{MACHINE_COLUMNS, MachineForecast, MachineNow};
pub use month::{MONTH_COLUMNS, MachineOutput};
pub use node_list::{FarmNode, NODE_COLUMNS, list_farm_nodes};
pub use order_list::{BuiltCopies, ORDER_BUILD_COLUMNS, ORDER_COLUMNS, ORDER_LINE_COLUMNS};
pub use part_list::{
    BUILD_PART_COLUMNS, CAKE_PART_COLUMNS, CountedPart, ORDERED_PART_COLUMNS, OrderedPart, PART_COLUMNS,
    PLACEMENT_COLUMNS, WAITING_PART_COLUMNS, whereabouts,
};
pub use part_sheet::part_facts;
pub use pick_list::{PICK_COLUMNS, PickList, PickedCopy, points_down, removal_in_words};
pub use plan_list::{PLAN_COLUMNS, RISK_COLUMNS, plan_notes};
pub use printer_list::PRINTER_COLUMNS;
pub use table_column::{TableColumn, csv_of, for_people};
pub use time_view::{GivenDate, TimeView};

#[cfg(test)]
mod tests;
