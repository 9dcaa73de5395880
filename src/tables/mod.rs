//! What people and programs see of the farm, defined in one place: the label, unit and format of each field, and the
//! columns of each table with their keys in JSON and CSV. The command line, the pages and the files are made from
//! these lists.

mod columns;
pub mod fields;
mod lists;
mod sheets;

pub use columns::cell_value::CellValue;
pub use columns::field_definition::{FieldDefinition, SheetFact};
pub use columns::table_column::{TableColumn, csv_of, for_people, people_columns};
pub use columns::time_view::{GivenDate, PromisedDate, TimeView};
pub use lists::cost_list::{COST_SHARE_COLUMNS, LEAST_COST_COLUMNS, ORDER_COST_COLUMNS};
pub use lists::event_list::gathered_events;
pub use lists::history::{HEIGHT_SUM_COLUMNS, HISTORY_COLUMNS, HISTORY_PAGE_KEYS};
pub use lists::month::{MONTH_COLUMNS, MachineOutput};
pub use lists::node_list::{FarmNode, NODE_COLUMNS, list_farm_nodes};
pub use lists::order_list::{
    BUILD_PAGE_KEYS, BuiltCopies, LEAST_ORDER_COLUMNS, ORDER_BUILD_COLUMNS, ORDER_COLUMNS, ORDER_LINE_COLUMNS,
    closing_text, order_copies_text,
};
pub use lists::part_list::{
    BUILD_PART_COLUMNS, BUILD_PART_PAGE_KEYS, CAKE_PART_COLUMNS, COPY_GROUP_COLUMNS, CopyGroup, CountedPart,
    ListedPart, ORDERED_PART_COLUMNS, OrderedPart, PART_COLUMNS, PART_PAGE_KEYS, PlacedCopy, WAITING_PART_COLUMNS,
    wanted_text, whereabouts,
};
pub use lists::people_list::{PEOPLE_COLUMNS, role_text};
pub use lists::pick_list::{PICK_COLUMNS, PickList, PickedCopy, points_down, removal_in_words};
pub use lists::plan_list::{PLAN_COLUMNS, RISK_COLUMNS, plan_notes};
pub use lists::printer_list::PRINTER_COLUMNS;
pub use sheets::build_sheet::{
    EVENT_COLUMNS, ORDER_EVENT_COLUMNS, OUTCOME_COLUMNS, build_facts, height as height_in_volume,
};
pub use sheets::machine_status::{MACHINE_COLUMNS, MachineForecast, MachineNow};
pub use sheets::part_sheet::part_facts;
pub use sheets::record_sheet::{RECORDED_COPY_COLUMNS, mark_word, record_facts};

#[cfg(test)]
mod tests;
