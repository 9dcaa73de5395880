//! The fields that people see: each one's label, unit and decimals, once. A field that stands in several tables and sheets is one
//! constant here.

use super::field_definition::FieldDefinition as Field;

/// Number of a build.
pub const BUILD: Field = Field::whole("Build");
/// Number of a part.
pub const PART: Field = Field::whole("Part");
/// Machine profile.
pub const PROFILE: Field = Field::text("Profile");
/// Where a part or a build stands.
pub const STATE: Field = Field::text("State");
/// When a build was published, else when it entered its state.
pub const TIME: Field = Field::time("Time");
/// Why something failed or was refused.
pub const REASON: Field = Field::text("Reason");
/// Why a part was refused, else what was odd about it.
pub const REASON_OR_WARNING: Field = Field::text("Reason or warning");
/// What somebody wrote beside it.
pub const NOTE: Field = Field::text("Note");

/// Build height.
pub const HEIGHT: Field = Field::real("Height", "mm", 2);
/// Height of the machine's volume.
pub const VOLUME_Z: Field = Field::real("Machine height", "mm", 0);
/// No build of these parts can be lower.
pub const LOWER_BOUND: Field = Field::real("Bound", "mm", 2);
/// Part volume / (base area x height).
pub const DENSITY: Field = Field::share("Density");
/// Mean of several densities.
pub const MEAN_DENSITY: Field = Field::share("Mean density");
/// Share of the height of the machine's volume that a build uses.
pub const USED: Field = Field::share("Used");
/// Layers to print.
pub const LAYERS: Field = Field::whole("Layers");
/// Thickness of a layer.
pub const LAYER_THICKNESS: Field = Field::exact("Layer", "mm");
/// Distinct parts.
pub const PARTS: Field = Field::whole("Parts");
/// Copies of parts.
pub const COPIES: Field = Field::whole("Copies");
/// Copies of a part that are in the build that is looked at.
pub const COPIES_HERE: Field = Field::whole("Copies here");
/// Copies of a part that wait.
pub const COPIES_WAITING: Field = Field::whole("Copies waiting");
/// Copies of a part in all.
pub const COPIES_OF: Field = Field::whole("Of");
/// Copies of a part that are in published builds.
pub const COPIES_PUBLISHED: Field = Field::whole("Published");
/// Builds.
pub const BUILDS: Field = Field::whole("Builds");
/// Volume of parts.
pub const PART_VOLUME: Field = Field::real("Volume", "cm3", 2);
/// Volume of parts as programs see it.
pub const PART_VOLUME_MM3: Field = Field::real("Volume", "mm3", 0);
/// Clearance asked.
pub const CLEARANCE: Field = Field::real("Clearance", "mm", 2);
/// Least distance found on the triangles of the written file.
pub const CLEARANCE_PROVED: Field = Field::real("Proved", "mm", 3);
/// CPU time of a search.
pub const CPU: Field = Field::real("CPU", "s", 1);
/// Time of a search on the clock.
pub const WALL: Field = Field::real("Wall time", "s", 1);
/// Evaluations of a search.
pub const EVALUATIONS: Field = Field::whole("Evaluations");
/// Seed of a search.
pub const SEED: Field = Field::whole("Seed");
/// nestd or paper.
pub const METHOD: Field = Field::text("Method");
/// How a build was searched for.
pub const SEARCH: Field = Field::text("Search");
/// Version of nestd.
pub const VERSION: Field = Field::text("Version");
/// Trigger.
pub const FIRED_BY: Field = Field::text("Fired by");
/// When a build was opened.
pub const OPENED: Field = Field::time("Opened");
/// When it fired.
pub const NESTING: Field = Field::time("Nesting");
/// When its file was proved.
pub const VERIFIED: Field = Field::time("Verified");
/// When it came into the queue.
pub const PUBLISHED: Field = Field::time("Published");
/// Name of a build file.
pub const FILE: Field = Field::text("File");
/// Name of a build file, else why there is none.
pub const FILE_OR_REASON: Field = Field::text("File or reason");
/// Size and hash of a file.
pub const CONTENT: Field = Field::text("Content");
/// Machine that a file says it is for.
pub const MACHINE: Field = Field::text("Machine");
/// When a file says it was made.
pub const MADE: Field = Field::text("Made");

/// File name of a part, with the name of its solid.
pub const NAME: Field = Field::text("Name");
/// Order or kit.
pub const ORDER: Field = Field::text("Order");
/// 0 to 100.
pub const PRIORITY: Field = Field::whole("Priority");
/// When a part is due.
pub const DUE: Field = Field::time("Due");
/// When a part was claimed.
pub const CLAIMED: Field = Field::time("Claimed");
/// How a part may be turned.
pub const ORIENTATION: Field = Field::text("Orientation");
/// Bounds of a part as dropped.
pub const SIZE: Field = Field::real("Size", "mm", 2);
/// What was odd about a part.
pub const WARNING: Field = Field::text("Warning");
/// Which builds a part's copies are in.
pub const WHERE: Field = Field::text("Where");
/// A copy of a part, from 1.
pub const COPY: Field = Field::whole("Copy");
/// Where the origin of a mesh is in the cake.
pub const ORIGIN: Field = Field::real("Origin of its mesh in the cake", "mm", 1);

/// When something happened.
pub const EVENT: Field = Field::time("Event");
/// What happened.
pub const KIND: Field = Field::text("Kind");
/// More about it.
pub const DETAIL: Field = Field::text("Detail");
/// When an outcome was told.
pub const TOLD: Field = Field::time("Told");
/// What became of a build.
pub const OUTCOME: Field = Field::text("Outcome");
/// Who told it.
pub const TOLD_BY: Field = Field::text("By");

/// Parts that wait.
pub const WAITING: Field = Field::whole("Waiting");
/// How long the oldest part has waited.
pub const OLDEST: Field = Field::text("Oldest");
/// The forecast of the next build.
pub const NEXT_BUILD: Field = Field::text("Next build");
/// When the next build fires.
pub const FIRES: Field = Field::text("Fires");
/// What a machine does.
pub const NOW: Field = Field::text("Now");
/// Files that are being read.
pub const BEING_READ: Field = Field::whole("Being read");
/// Parts that were refused.
pub const REJECTED: Field = Field::whole("Rejected");
/// The build that was published last.
pub const LAST_PUBLISHED: Field = Field::time("Last published");

/// Place in a pick list.
pub const PICK_NUMBER: Field = Field::whole("No.");
/// Highest point of a copy.
pub const TOP: Field = Field::real("Top", "mm", 1);
/// Lowest point of a copy.
pub const BOTTOM: Field = Field::real("Bottom", "mm", 1);
/// Middle of a copy from the left.
pub const CENTER_X: Field = Field::real("x", "mm", 0);
/// Middle of a copy from the front.
pub const CENTER_Y: Field = Field::real("y", "mm", 0);
/// A part by its name.
pub const PART_NAME: Field = Field::text("Part");
/// Whereto a copy is drawn.
pub const WAY: Field = Field::text("Way");
