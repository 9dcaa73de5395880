//! Tickets and order lists: their columns, rows and states, and which file a row means.

pub(super) mod folder_lists;
pub(super) mod hidden_sidecar;
pub(super) mod list_cells;
pub(super) mod list_columns;
pub(super) mod list_extras;
pub(super) mod list_lookup;
pub(super) mod loaded_list;
pub(super) mod misnamed_sidecar;
pub(super) mod order_list;
pub(super) mod row_state;
pub(super) mod served_rows;
pub(super) mod sidecars;
pub(super) mod texts;
pub(super) mod ticket;
pub(super) mod workbook;
