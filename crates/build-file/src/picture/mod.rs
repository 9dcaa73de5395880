//! Pictures of a build, drawn without a graphics card.

pub(super) mod lettering;
pub(super) mod picture;
pub(super) mod raster;
pub(super) mod shade;
