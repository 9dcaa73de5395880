//! What a person can say of builds, printers and orders, what was seen of the files that it is about, and what becomes of it (`operator_word`).

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{BuildId, ReprintTarget, ToldOutcome};

/// A word of a person about builds, printers and orders.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum OperatorWord {
    /// How the print of a build ended.
    Outcome(BuildId, ToldOutcome),
    /// Printed copies are printed again.
    Reprint(ReprintTarget),
    /// The same proved build is issued once more.
    Requeue(BuildId),
    /// Something was said of each copy of its cake.
    BreakOut(BuildId),
    /// It was not printed, and its copies wait again; why.
    Withdraw(BuildId, String),
    /// A proved build may be published.
    Release {
        /// The build.
        build: BuildId,
        /// BLAKE3 of the build file that the person was shown; `None` = of whichever there is.
        seen: Option<String>,
    },
    /// An order is closed as it is.
    CloseOrder(String),
    /// Somebody has seen to its failed print, or to a second file of it.
    SeenTo(BuildId),
    /// A material was loaded in a machine.
    Load {
        /// The machine.
        machine: String,
        /// The material, "" = nothing is loaded.
        material: String,
        /// The lot of its powder, "" = not said.
        lot: String,
    },
    /// A printer takes no builds any more.
    PrinterDown {
        /// Its machine.
        machine: String,
        /// The printer.
        printer: String,
        /// Why.
        reason: String,
    },
    /// A printer takes builds again.
    PrinterUp {
        /// Its machine.
        machine: String,
        /// The printer.
        printer: String,
    },
}

/// What became of a word.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct WordAnswer {
    /// What was done or noted, in sentences for people.
    pub sentences: Vec<String>,
    /// The builds for which it is carried out once their files are taken back.
    pub noted: Vec<BuildId>,
}

/// Where the file of a build is that a word is about, as far as whoever says it could see. Where nothing is known, it may lie in a queue.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SeenFile {
    /// In no queue folder, and it comes into none.
    OutOfQueue,
    /// Where it was published, as it was proved.
    Untouched {
        /// The printer.
        printer: String,
    },
    /// What lies under its name at this printer is not what was proved.
    Altered {
        /// The printer.
        printer: String,
    },
    /// In a queue folder under another name, or a second time.
    Copied {
        /// The printer at whose queue it lies under its own name.
        own: Option<String>,
        /// Whether it was seen there before: what lies there now is a second one.
        is_second: bool,
        /// All other places, as `job.3mf at left`.
        others: Vec<String>,
    },
    /// A second one was seen in a queue folder that cannot be looked into now: it may lie there.
    SecondUnseen {
        /// Where, as `job.3mf at left`.
        places: Vec<String>,
    },
    /// Where it was published, while a second one that lay in a queue is gone.
    SecondGone {
        /// The printer at whose queue it lies.
        printer: String,
        /// Where the others were seen, as `job.3mf at left`.
        places: Vec<String>,
    },
}

/// What was seen of the files of builds.
pub type SeenFiles = BTreeMap<BuildId, SeenFile>;

impl From<String> for WordAnswer {
    fn from(sentence: String) -> Self {
        Self { sentences: vec![sentence], noted: Vec::new() }
    }
}
