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
    /// What lies under its name is not the file that was proved: it is not taken back.
    #[error(
        "what lies in the queue of {printer} as the file of build {build} is not the file that was proved. Take it out of the queue, look \
         whether it was printed, and say it again"
    )]
    Altered {
        /// The build.
        build: BuildId,
        /// The printer.
        printer: String,
    },
    /// Its copies lie in a queue folder under another name, or a second time: nestd takes only the file back that it published.
    #[error(
        "the file of build {build} {}, and could be printed from there. Take {} out of the queue{}; then say it again",
        describe_places(.own.as_deref(), *.is_second, .others),
        join_with_and(.others),
        if .own.is_none() && !.is_second && .others.len() == 1 { ", or give it its own name back" } else { "" }
    )]
    Copied {
        /// The build.
        build: BuildId,
        /// The printer at whose queue it lies under its own name.
        own: Option<String>,
        /// Whether its own file was seen beside the others, and is out of the queue now.
        is_second: bool,
        /// All other places, as `job.3mf at left`.
        others: Vec<String>,
    },
    /// A second file of it was seen in a queue folder that cannot be looked into now.
    #[error(
        "a second file of build {build} was seen in the queue as {}, and nestd cannot look there now. Look yourself: take it out if it lies \
         there. Where nobody printed it, `nestd dismiss b{build}`, and say it again",
        join_with_and(.places)
    )]
    SecondUnseen {
        /// The build.
        build: BuildId,
        /// Where second files were seen, as `job.3mf at left`.
        places: Vec<String>,
    },
    /// A second file of it lay in a queue folder and is gone, while its own lies there: it may be printed from the second one.
    #[error(
        "a second file of build {build} lay in the queue as {}, and is gone. Where that one is or was printed, take the file in the queue \
         of {printer} out and say it again. Where nobody printed it, `nestd dismiss b{build}`, and say it again",
        join_with_and(.places)
    )]
    SecondGone {
        /// The build.
        build: BuildId,
        /// The printer in whose queue its own file lies.
        printer: String,
        /// Where second files were seen, as `job.3mf at left`.
        places: Vec<String>,
    },
    /// Its file is between two printers.
    #[error("the file of build {0} is on its way to another printer: say it again when it is there")]
    OnItsWay(BuildId),
    /// Its file is being taken back.
    #[error("the file of build {0} is being taken back out of the queue: `nestd show b{0}` says what became of it")]
    BeingTakenBack(BuildId),
}

/// Where the copies of a build lie: `lies in the queue of left, and a second time as job.3mf at right`.
fn describe_places(own: Option<&str>, is_second: bool, others: &[String]) -> String {
    let places = join_with_and(others);
    match own {
        Some(printer) => format!("lies in the queue of {printer}, and a second time as {places}"),
        None if is_second => format!("is out of the queue, where a second one lies as {places}"),
        None => format!("lies in the queue under another name, as {places}"),
    }
}

fn join_with_and(texts: &[String]) -> String {
    match texts {
        [first @ .., last] if !first.is_empty() => format!("{} and {last}", first.join(", ")),
        _ => texts.concat(),
    }
}
