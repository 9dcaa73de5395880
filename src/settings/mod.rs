//! Configuration in three stages: fragments (all optional) -> inputs (merged, defaults) -> [`Settings`] (validated, the
//! only one that the daemon sees).

mod load;
mod logging;
mod problem;
mod profile;
mod settings;

pub use load::{SettingsError, load};
pub use logging::{LogFormat, Logging};
pub use problem::Problem;
pub use profile::{Duplicates, Folders, MeshErrors, Profile, Trigger};
pub use settings::Settings;
