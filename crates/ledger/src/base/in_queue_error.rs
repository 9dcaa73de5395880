//! Why a word about a build is refused whose file may lie in a queue folder (`operator_word`).

use thiserror::Error;

use crate::BuildId;

/// Why a word about a build is refused whose file may lie in a queue.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum InQueueError {
    /// Nobody insisted.
    #[error(
        "the file of build {build} lies untouched in the queue of {printer}, as if nobody had printed it. Look whether the number is \
         right. If it is, insist ({insist}): nestd takes the file out of the queue first, so that nobody prints it a second time"
    )]
    LiesThere {
        /// The build.
        build: BuildId,
        /// Its printer.
        printer: String,
        /// How to insist.
        insist: &'static str,
    },
    /// Some of its copies are to be printed again, and nobody said what became of the others.
    #[error(
        "the file of build {build} lies untouched in the queue, and nobody told how it was printed. If it was not printed, take it back: \
         `nestd withdraw {build}`. If it was, tell its outcome first with the copies that are bad: `nestd outcome {build} complete \
         --bad PART=N`"
    )]
    NotTold {
        /// The build.
        build: BuildId,
    },
    /// Its bytes lie in a queue folder under another name, where nobody can take them back.
    #[error(
        "the file of build {build} lies in the queue under another name, as {name}, and could be printed from there. Take {name} out of the \
         queue{}; then say it again", if *.is_alone { ", or give it its own name back" } else { "" }
    )]
    Copied {
        /// The build.
        build: BuildId,
        /// The name.
        name: String,
        /// Whether its own name is free.
        is_alone: bool,
    },
    /// Its file is between two printers.
    #[error("the file of build {0} is on its way to another printer: say it again when it is there")]
    OnItsWay(BuildId),
    /// Its file is being taken back.
    #[error("the file of build {0} is being taken back out of the queue: `nestd show b{0}` says what became of it")]
    BeingTakenBack(BuildId),
}
