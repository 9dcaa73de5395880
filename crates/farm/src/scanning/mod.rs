//! One look into a hot folder or a queue folder, off the loop: what is ready is claimed there (`ready_files`). And whether a proved build still fits its machine.

pub(super) mod arriving_lines;
pub(super) mod hot_folder_scan;
pub(super) mod hot_folder_scanner;
pub(super) mod machine_fit;
pub(super) mod obeyed_controls;
pub(super) mod queue_contents;
pub(super) mod queue_files;
pub(super) mod ready_files;
