//! The fields that people see: each one's label, unit and decimals, once. A field that stands in several tables and sheets is one
//! constant here.

use super::field_definition::FieldDefinition as DistanceFunction;

/// Number of a build.
pub const BUILD: DistanceFunction = DistanceFunction::whole("Build");
/// Number of a part.
pub const PART: DistanceFunction = DistanceFunction::whole("Part");
/// Machine profile.
pub const PROFILE: DistanceFunction = DistanceFunction::text("Profile");
/// Where a part or a build stands.
pub const STATE: DistanceFunction = DistanceFunction::text("State");
/// When a build was published, else when it entered its state.
pub const TIME: DistanceFunction = DistanceFunction::time("Time");
/// Why something failed or was refused.
pub const REASON: DistanceFunction = DistanceFunction::text("Reason");
/// Why a part was refused, else what was odd about it.
pub const REASON_OR_WARNING: DistanceFunction = DistanceFunction::text("Reason or warning");
/// What somebody wrote beside it.
pub const NOTE: DistanceFunction = DistanceFunction::text("Note");

/// Build height.
pub const HEIGHT: DistanceFunction = DistanceFunction::real("Height", "mm", 2);
/// Height of the machine's volume.
pub const VOLUME_Z: DistanceFunction = DistanceFunction::real("Machine height", "mm", 0);
/// No build of these parts can be lower.
pub const LOWER_BOUND: DistanceFunction = DistanceFunction::real("Bound", "mm", 2);
/// Part volume / (base area x height).
pub const DENSITY: DistanceFunction = DistanceFunction::share("Density");
/// Mean of several densities.
pub const MEAN_DENSITY: DistanceFunction = DistanceFunction::share("Mean density");
/// Share of the height of the machine's volume that a build uses.
pub const USED: DistanceFunction = DistanceFunction::share("Used");
/// Layers to print.
pub const LAYERS: DistanceFunction = DistanceFunction::whole("Layers");
/// Thickness of a layer.
pub const LAYER_THICKNESS: DistanceFunction = DistanceFunction::exact("Layer", "mm");
/// Distinct parts.
pub const PARTS: DistanceFunction = DistanceFunction::whole("Parts");
/// Copies of parts.
pub const COPIES: DistanceFunction = DistanceFunction::whole("Copies");
/// Copies of a part that are in the build that is looked at.
pub const COPIES_HERE: DistanceFunction = DistanceFunction::whole("Copies here");
/// Copies of a part that wait.
pub const COPIES_WAITING: DistanceFunction = DistanceFunction::whole("Copies waiting");
/// Copies of a part in all.
pub const COPIES_OF: DistanceFunction = DistanceFunction::whole("Of");
/// Copies of a part that are in published builds.
pub const COPIES_PUBLISHED: DistanceFunction = DistanceFunction::whole("Published");
/// Builds.
pub const BUILDS: DistanceFunction = DistanceFunction::whole("Builds");
/// Volume of parts.
pub const PART_VOLUME: DistanceFunction = DistanceFunction::real("Volume", "cm3", 2);
/// Volume of parts as programs see it.
pub const PART_VOLUME_MM3: DistanceFunction = DistanceFunction::real("Volume", "mm3", 0);
/// Clearance asked.
pub const CLEARANCE: DistanceFunction = DistanceFunction::real("Clearance", "mm", 2);
/// Least distance found on the triangles of the written file.
pub const CLEARANCE_PROVED: DistanceFunction = DistanceFunction::real("Proved", "mm", 3);
/// CPU time of a search.
pub const CPU: DistanceFunction = DistanceFunction::real("CPU", "s", 1);
/// Time of a search on the clock.
pub const WALL: DistanceFunction = DistanceFunction::real("Wall time", "s", 1);
/// Evaluations of a search.
pub const EVALUATIONS: DistanceFunction = DistanceFunction::whole("Evaluations");
/// Seed of a search.
pub const SEED: DistanceFunction = DistanceFunction::whole("Seed");
/// nestd or paper.
pub const METHOD: DistanceFunction = DistanceFunction::text("Method");
/// How a build was searched for.
pub const SEARCH: DistanceFunction = DistanceFunction::text("Search");
/// Version of nestd.
pub const VERSION: DistanceFunction = DistanceFunction::text("Version");
/// Trigger.
pub const FIRED_BY: DistanceFunction = DistanceFunction::text("Fired by");
/// When a build was opened.
pub const OPENED: DistanceFunction = DistanceFunction::time("Opened");
/// When it fired.
pub const NESTING: DistanceFunction = DistanceFunction::time("Nesting");
/// When its file was proved.
pub const VERIFIED: DistanceFunction = DistanceFunction::time("Verified");
/// When it came into the queue.
pub const PUBLISHED: DistanceFunction = DistanceFunction::time("Published");
/// Name of a build file.
pub const FILE: DistanceFunction = DistanceFunction::text("File");
/// Name of a build file, else why there is none.
pub const FILE_OR_REASON: DistanceFunction = DistanceFunction::text("File or reason");
/// Size and hash of a file.
pub const CONTENT: DistanceFunction = DistanceFunction::text("Content");
/// Machine that a file says it is for.
pub const MACHINE: DistanceFunction = DistanceFunction::text("Machine");
/// When a file says it was made.
pub const MADE: DistanceFunction = DistanceFunction::text("Made");

/// File name of a part, with the name of its solid.
pub const NAME: DistanceFunction = DistanceFunction::text("Name");
/// Order or kit.
pub const ORDER: DistanceFunction = DistanceFunction::text("Order");
/// 0 to 100.
pub const PRIORITY: DistanceFunction = DistanceFunction::whole("Priority");
/// When a part is due.
pub const DUE: DistanceFunction = DistanceFunction::time("Due");
/// When a part was claimed.
pub const CLAIMED: DistanceFunction = DistanceFunction::time("Claimed");
/// How a part may be turned.
pub const ORIENTATION: DistanceFunction = DistanceFunction::text("Orientation");
/// Bounds of a part as dropped.
pub const SIZE: DistanceFunction = DistanceFunction::real("Size", "mm", 2);
/// What was odd about a part.
pub const WARNING: DistanceFunction = DistanceFunction::text("Warning");
/// Which builds a part's copies are in.
pub const WHERE: DistanceFunction = DistanceFunction::text("Where");
/// A copy of a part, from 1.
pub const COPY: DistanceFunction = DistanceFunction::whole("Copy");
/// Where the origin of a mesh is in the cake.
pub const ORIGIN: DistanceFunction = DistanceFunction::real("Origin of its mesh in the cake", "mm", 1);

/// When something happened.
pub const EVENT: DistanceFunction = DistanceFunction::time("Event");
/// What happened.
pub const KIND: DistanceFunction = DistanceFunction::text("Kind");
/// More about it.
pub const DETAIL: DistanceFunction = DistanceFunction::text("Detail");
/// When an outcome was told.
pub const TOLD: DistanceFunction = DistanceFunction::time("Told");
/// What became of a build.
pub const OUTCOME: DistanceFunction = DistanceFunction::text("Outcome");
/// Who told it.
pub const TOLD_BY: DistanceFunction = DistanceFunction::text("By");

/// Parts that wait.
pub const WAITING: DistanceFunction = DistanceFunction::whole("Waiting");
/// How long the oldest part has waited.
pub const OLDEST: DistanceFunction = DistanceFunction::text("Oldest");
/// The forecast of the next build.
pub const NEXT_BUILD: DistanceFunction = DistanceFunction::text("Next build");
/// When the next build fires.
pub const FIRES: DistanceFunction = DistanceFunction::text("Fires");
/// What a machine does.
pub const NOW: DistanceFunction = DistanceFunction::text("Now");
/// Files that are being read.
pub const BEING_READ: DistanceFunction = DistanceFunction::whole("Being read");
/// Parts that were refused.
pub const REJECTED: DistanceFunction = DistanceFunction::whole("Rejected");
/// The build that was published last.
pub const LAST_PUBLISHED: DistanceFunction = DistanceFunction::time("Last published");

/// Place in a pick list.
pub const PICK_NUMBER: DistanceFunction = DistanceFunction::whole("No.");
/// Highest point of a copy.
pub const TOP: DistanceFunction = DistanceFunction::real("Top", "mm", 1);
/// Lowest point of a copy.
pub const BOTTOM: DistanceFunction = DistanceFunction::real("Bottom", "mm", 1);
/// Middle of a copy from the left.
pub const CENTER_X: DistanceFunction = DistanceFunction::real("x", "mm", 0);
/// Middle of a copy from the front.
pub const CENTER_Y: DistanceFunction = DistanceFunction::real("y", "mm", 0);
/// A part by its name.
pub const PART_NAME: DistanceFunction = DistanceFunction::text("Part");
/// Whereto a copy is drawn.
pub const WAY: DistanceFunction = DistanceFunction::text("Way");
