//! The fields that people see, each with its label, unit and decimals. A field that several tables and fact sheets
//! use is one constant here.

use super::columns::field_definition::FieldDefinition;

/// Number of a build.
pub const BUILD: FieldDefinition = FieldDefinition::whole("Build");
/// Number of a part.
pub const PART: FieldDefinition = FieldDefinition::whole("Part");
/// Machine.
pub const MACHINE: FieldDefinition = FieldDefinition::text("Machine");
/// State of a part or a build.
pub const STATE: FieldDefinition = FieldDefinition::text("State");
/// State of a build as the ledger has it: one that was withdrawn has failed there.
pub const LEDGER_STATE: FieldDefinition = FieldDefinition::text("State in the ledger");
/// When a build was published; before that, when it entered its state.
pub const TIME: FieldDefinition = FieldDefinition::time("Time");
/// What a person must say or do for a part, and how.
pub const QUESTION: FieldDefinition = FieldDefinition::text("Question");
/// Why something failed or was refused.
pub const REASON: FieldDefinition = FieldDefinition::text("Reason");
/// Why a part was refused; otherwise what it waits for and its warnings.
pub const REASON_OR_WARNING: FieldDefinition = FieldDefinition::text("Reason or warning");
/// Note that a person wrote.
pub const NOTE: FieldDefinition = FieldDefinition::text("Note");

/// Build height.
pub const HEIGHT: FieldDefinition = FieldDefinition::real("Height", "mm", 2);
/// Height of the machine's volume.
pub const VOLUME_Z: FieldDefinition = FieldDefinition::real("Machine height", "mm", 0);
/// Lower bound: no build of these parts can be lower.
pub const LOWER_BOUND: FieldDefinition = FieldDefinition::real("Bound", "mm", 2);
/// Density of a build: part volume / (base area x height).
pub const DENSITY: FieldDefinition = FieldDefinition::share("Density");
/// Mean of several densities.
pub const MEAN_DENSITY: FieldDefinition = FieldDefinition::share("Mean density");
/// Share of the height of the machine's volume that a build uses.
pub const USED: FieldDefinition = FieldDefinition::share("Used");
/// Sum of build heights.
pub const HEIGHT_SUM: FieldDefinition = FieldDefinition::real("Height", "mm", 1);
/// Hours that printing takes.
pub const PRINT_HOURS: FieldDefinition = FieldDefinition::real("Machine time", "h", 1);
/// Volume of parts in litres.
pub const PART_LITRES: FieldDefinition = FieldDefinition::real("Parts", "l", 2);
/// Volume of cakes in litres.
pub const CAKE_LITRES: FieldDefinition = FieldDefinition::real("Cake", "l", 2);
/// Fresh powder that builds took.
pub const POWDER: FieldDefinition = FieldDefinition::real("Powder", "kg", 2);
/// What something costs, in its currency.
pub const PRICE: FieldDefinition = FieldDefinition::real("Price", "", 2);
/// Currency of a price.
pub const CURRENCY: FieldDefinition = FieldDefinition::text("Currency");
/// Builds whose print failed.
pub const FAILED_BUILDS: FieldDefinition = FieldDefinition::whole("Failed").unless_zero();
/// Good copies among those of which somebody told how they came out.
pub const YIELD: FieldDefinition = FieldDefinition::share("Yield");
/// Number of layers of a build.
pub const LAYERS: FieldDefinition = FieldDefinition::whole("Layers");
/// Thickness of a layer.
pub const LAYER_THICKNESS: FieldDefinition = FieldDefinition::exact("Layer", "mm");
/// Number of distinct parts.
pub const PARTS: FieldDefinition = FieldDefinition::whole("Parts");
/// Number of copies.
pub const COPIES: FieldDefinition = FieldDefinition::whole("Copies");
/// Copies of a part that are in the shown build.
pub const COPIES_HERE: FieldDefinition = FieldDefinition::whole("Copies here");
/// Copies of a part that are waiting.
pub const COPIES_WAITING: FieldDefinition = FieldDefinition::whole("Copies waiting");
/// All copies of a part.
pub const COPIES_OF: FieldDefinition = FieldDefinition::whole("Of");
/// Lines of an order.
pub const LINES: FieldDefinition = FieldDefinition::whole("Lines");
/// Copies wanted: = waiting + in builds + printed + good + refused.
pub const COPIES_WANTED: FieldDefinition = FieldDefinition::whole("Wanted");
/// Copies in builds that are being made.
pub const COPIES_IN_BUILDS: FieldDefinition = FieldDefinition::whole("In builds").unless_zero();
/// Copies in builds whose file lies in a queue.
pub const COPIES_QUEUED: FieldDefinition = FieldDefinition::whole("Queued").unless_zero();
/// Copies in builds that are printed.
pub const COPIES_PRINTING: FieldDefinition = FieldDefinition::whole("Printing").unless_zero();
/// What became of copies, in words.
pub const COPIES_NOW: FieldDefinition = FieldDefinition::text("Copies");
/// Copies in builds whose print is over, and of which nobody said that they are good.
pub const COPIES_PRINTED: FieldDefinition = FieldDefinition::whole("Printed").unless_zero();
/// Copies in builds that were told complete.
pub const COPIES_GOOD: FieldDefinition = FieldDefinition::whole("Good").unless_zero();
/// Copies that are wanted and not made, because their part was refused or cancelled.
pub const COPIES_REFUSED: FieldDefinition = FieldDefinition::whole("Refused").unless_zero();
/// Copies that were printed badly.
pub const COPIES_BAD: FieldDefinition = FieldDefinition::whole("Bad").unless_zero();
/// The copies of a part that were printed badly in a build, by their numbers.
pub const BAD_COPIES: FieldDefinition = FieldDefinition::text("Bad copies").unless_zero();
/// Copies that are not wanted any more.
pub const COPIES_CANCELLED: FieldDefinition = FieldDefinition::whole("Cancelled").unless_zero();
/// Number of builds.
pub const BUILDS: FieldDefinition = FieldDefinition::whole("Builds");
/// Volume of parts.
pub const PART_VOLUME: FieldDefinition = FieldDefinition::real("Volume", "cm3", 2);
/// Volume of parts for programs, in mm3.
pub const PART_VOLUME_MM3: FieldDefinition = FieldDefinition::real("Volume", "mm3", 0);
/// Required clearance.
pub const CLEARANCE: FieldDefinition = FieldDefinition::real("Clearance", "mm", 2);
/// Smallest distance between two copies, measured on the triangles of the written file.
pub const CLEARANCE_PROVED: FieldDefinition = FieldDefinition::real("Proved", "mm", 3);
/// CPU time of a search.
pub const CPU: FieldDefinition = FieldDefinition::real("CPU", "s", 1);
/// Wall time of a search.
pub const WALL: FieldDefinition = FieldDefinition::real("Wall time", "s", 1);
/// Evaluations of a search.
pub const EVALUATIONS: FieldDefinition = FieldDefinition::whole("Evaluations");
/// Seed of a search.
pub const SEED: FieldDefinition = FieldDefinition::whole("Seed");
/// Search method: nestd or paper.
pub const METHOD: FieldDefinition = FieldDefinition::text("Method");
/// Method and effort of the search.
pub const SEARCH: FieldDefinition = FieldDefinition::text("Search");
/// Build whose proved layout a build repeats.
pub const REPEATS: FieldDefinition = FieldDefinition::whole("Repeats");
/// Version of nestd.
pub const VERSION: FieldDefinition = FieldDefinition::text("Version");
/// Trigger that fired a build.
pub const FIRED_BY: FieldDefinition = FieldDefinition::text("Fired by");
/// When a build was opened.
pub const OPENED: FieldDefinition = FieldDefinition::time("Opened");
/// When a build fired.
pub const NESTING: FieldDefinition = FieldDefinition::time("Nesting");
/// When the file of a build was proved.
pub const VERIFIED: FieldDefinition = FieldDefinition::time("Verified");
/// When a build file was placed in the queue.
pub const PUBLISHED: FieldDefinition = FieldDefinition::time("Published");
/// Name of a build file.
pub const FILE: FieldDefinition = FieldDefinition::text("File");
/// Name of a build file, or the reason why there is none.
pub const FILE_OR_REASON: FieldDefinition = FieldDefinition::text("File or reason");
/// Size and hash of a file.
pub const CONTENT: FieldDefinition = FieldDefinition::text("Content");
/// Creation time written in a build file.
pub const MADE: FieldDefinition = FieldDefinition::text("Made");

/// File name of a part, with the name of its solid.
pub const NAME: FieldDefinition = FieldDefinition::text("Name");
/// Order or kit.
pub const ORDER: FieldDefinition = FieldDefinition::text("Order");
/// Who an order or a part is for.
pub const CUSTOMER: FieldDefinition = FieldDefinition::text("Customer");
/// Where a customer gets e-mail.
pub const EMAIL: FieldDefinition = FieldDefinition::text("E-mail");
/// What a part or a build is made of.
pub const MATERIAL: FieldDefinition = FieldDefinition::text("Material");
/// Finishing steps of a part after the print.
pub const FINISH: FieldDefinition = FieldDefinition::text("Finishing");
/// Lot of the powder of a build.
pub const LOT: FieldDefinition = FieldDefinition::text("Lot");
/// What is loaded in a machine.
pub const LOADED: FieldDefinition = FieldDefinition::text("Loaded");
/// Priority, 0 to 100.
pub const PRIORITY: FieldDefinition = FieldDefinition::whole("Priority");
/// When a part is due.
pub const DUE: FieldDefinition = FieldDefinition::time("Due");
/// When a part was claimed.
pub const CLAIMED: FieldDefinition = FieldDefinition::time("Claimed");
/// Allowed orientations of a part.
pub const ORIENTATION: FieldDefinition = FieldDefinition::text("Orientation");
/// Size of a part in the orientation of the dropped file.
pub const SIZE: FieldDefinition = FieldDefinition::real("Size", "mm", 2);
/// Warnings about a part.
pub const WARNING: FieldDefinition = FieldDefinition::text("Warning");
/// The builds that contain copies of a part.
pub const WHERE: FieldDefinition = FieldDefinition::text("Where");
/// Where the origin of the file of a copy stood in its machine.
pub const ORIGIN_AT: FieldDefinition = FieldDefinition::text("Origin of the file at");
/// How a copy was turned from its file to its build.
pub const TURN: FieldDefinition = FieldDefinition::text("Turned");
/// What was said of a copy when its build was broken out.
pub const BREAK_OUT: FieldDefinition = FieldDefinition::text("Break-out");
/// What was done to a mesh that was not closed, and who allowed it.
pub const MENDED: FieldDefinition = FieldDefinition::text("Mended");
/// Number of a copy of a part, from 1.
pub const COPY: FieldDefinition = FieldDefinition::whole("Copy");

/// When something happened.
pub const EVENT: FieldDefinition = FieldDefinition::time("When");
/// What happened.
pub const KIND: FieldDefinition = FieldDefinition::text("Kind");
/// Details of an event.
pub const DETAIL: FieldDefinition = FieldDefinition::text("Detail");
/// When an outcome was recorded.
pub const OUTCOME_RECORDED: FieldDefinition = FieldDefinition::time("Told");
/// Outcome of a build's print.
pub const OUTCOME: FieldDefinition = FieldDefinition::text("Outcome");
/// Who recorded the outcome.
pub const OUTCOME_BY: FieldDefinition = FieldDefinition::text("By");

/// Name of a printer.
pub const PRINTER: FieldDefinition = FieldDefinition::text("Printer");
/// When the next print of a printer can begin.
pub const FREE: FieldDefinition = FieldDefinition::time("Free from");
/// Since when something is so.
pub const SINCE: FieldDefinition = FieldDefinition::time("Since");
/// What a person may do.
pub const ROLE: FieldDefinition = FieldDefinition::text("Role");
/// With what a person signs in.
pub const SIGNS_IN: FieldDefinition = FieldDefinition::text("Signs in with");
/// When a person last signed in.
pub const SIGNED_IN: FieldDefinition = FieldDefinition::time("Last signed in");
/// Who said something.
pub const TOLD_BY: FieldDefinition = FieldDefinition::text("By");
/// How long prints take.
pub const PRINT_TIMES: FieldDefinition = FieldDefinition::text("Print times");
/// Height of a build, or about how high it will be.
pub const ABOUT_HEIGHT: FieldDefinition = FieldDefinition::real("Height", "mm", 1);
/// When a build fires.
pub const FIRES_AT: FieldDefinition = FieldDefinition::time("Fires");
/// When the print of a build begins.
pub const BEGINS: FieldDefinition = FieldDefinition::time("Begins");
/// When parts can be unpacked, as far as is known.
pub const UNPACKED: FieldDefinition = FieldDefinition::time("Unpacking");
/// How a person closed an order.
pub const CLOSED: FieldDefinition = FieldDefinition::text("Closed");
/// What can be sent to the customer of an order.
pub const CUSTOMER_NOTE: FieldDefinition = FieldDefinition::text("To send");
/// When all of an order is done.
pub const DONE: FieldDefinition = FieldDefinition::time("Done");
/// An order, or a part without one.
pub const ORDER_OR_PART: FieldDefinition = FieldDefinition::text("Order or part");
/// How a due date stands.
pub const RISK: FieldDefinition = FieldDefinition::text("Risk");
/// When the file of a build was taken from its queue folder.
pub const TAKEN: FieldDefinition = FieldDefinition::time("Taken");
/// When a person said that a build may be published.
pub const RELEASED: FieldDefinition = FieldDefinition::text("Released");
/// What the customer's own system calls a line.
pub const REFERENCE: FieldDefinition = FieldDefinition::text("Reference");
/// When the file of a build was taken back out of the queue.
pub const WITHDRAWN: FieldDefinition = FieldDefinition::time("Withdrawn");

/// Number of waiting parts.
pub const WAITING: FieldDefinition = FieldDefinition::whole("Waiting");
/// Waiting time of the oldest part.
pub const OLDEST: FieldDefinition = FieldDefinition::text("Oldest");
/// The forecast of the next build.
pub const NEXT_BUILD: FieldDefinition = FieldDefinition::text("Next build");
/// What the search for an open build has gained and cost since the last arrival.
pub const WHILE_IT_WAITS: FieldDefinition = FieldDefinition::text("While it waits");
/// When the next build fires.
pub const FIRES: FieldDefinition = FieldDefinition::text("Fires");
/// Name of a node: a daemon among those that share one ledger.
pub const NODE: FieldDefinition = FieldDefinition::text("Node");
/// Name of a server.
pub const HOST: FieldDefinition = FieldDefinition::text("Host");
/// Last heartbeat of a node.
pub const LAST_SIGN: FieldDefinition = FieldDefinition::time("Last sign");
/// Address of the dashboard of a node.
pub const ADDRESS: FieldDefinition = FieldDefinition::text("Address");
/// Machines of a node.
pub const MACHINES: FieldDefinition = FieldDefinition::text("Machines");
/// Current activity of a machine.
pub const NOW: FieldDefinition = FieldDefinition::text("Now");
/// Number of files that are being read.
pub const BEING_READ: FieldDefinition = FieldDefinition::whole("Being read");
/// Number of refused parts.
pub const REFUSED: FieldDefinition = FieldDefinition::whole("Refused").unless_zero();
/// The last published build.
pub const LAST_PUBLISHED: FieldDefinition = FieldDefinition::time("Last published");

/// Position in a pick list.
pub const PICK_NUMBER: FieldDefinition = FieldDefinition::whole("No.");
/// Highest point of a copy.
pub const TOP: FieldDefinition = FieldDefinition::real("Top", "mm", 1);
/// Lowest point of a copy.
pub const BOTTOM: FieldDefinition = FieldDefinition::real("Bottom", "mm", 1);
/// Distance of a copy's center from the left side.
pub const CENTER_X: FieldDefinition = FieldDefinition::real("x", "mm", 0);
/// Distance of a copy's center from the front.
pub const CENTER_Y: FieldDefinition = FieldDefinition::real("y", "mm", 0);
/// Name of a part.
pub const PART_NAME: FieldDefinition = FieldDefinition::text("Part");
/// Direction in which a copy is removed.
pub const REMOVAL_DIRECTION: FieldDefinition = FieldDefinition::text("Way");
