//! Drawings and figures: charts, footprints, labels, the pick map, smaller meshes for the view.

pub(super) mod chart;
pub(super) mod footprint;
pub(super) mod labels;
pub(super) mod look_alike;
pub(super) mod mesh_reduction;
pub(super) mod outline;
pub(super) mod pick_map;
pub(super) mod search_report;
