//! Alerts: everything that a person must act on. There are no other errors: what recovers without help is a warning at
//! most.

use jiff::Timestamp;
use serde::{Deserialize, Serialize};

/// A kind of alert. Each is shown with its remedy in `nestd status`, in `STATUS.txt` and in the journal;
/// `docs/symptoms.md` lists them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AlertKind {
    /// The ledger's file is corrupt.
    LedgerDamaged,
    /// The folders hold builds that the ledger does not know.
    LedgerBehind,
    /// The ledger is missing, although its farm has worked before.
    LedgerLost,
    /// The ledger was removed, replaced or overwritten inside its file while the daemon had it open.
    LedgerReplaced,
    /// Another process holds the write lock of the ledger.
    LedgerLocked,
    /// The server of the ledger cannot be reached.
    LedgerUnreachable,
    /// All changes of the ledger wait for one connection.
    ChangesWait,
    /// The ledger has lost changes of other nodes, which must be compared with it first.
    RepairDue,
    /// Another daemon serves the ledger.
    LedgerTakenOver,
    /// A changed configuration was refused.
    ConfigurationWrong,
    /// A hot folder cannot be read.
    HotFolderAway,
    /// A queue folder cannot be used.
    QueueAway,
    /// An archive cannot be used.
    ArchiveAway,
    /// An error folder cannot be used.
    ErrorFolderAway,
    /// Another daemon serves folders of a machine.
    HeldByOther,
    /// Another node of the farm serves a machine.
    OtherNode,
    /// Claims of another farm lie in a hot folder.
    ForeignClaims,
    /// A machine's folders cannot be made.
    FoldersMissing,
    /// Files cannot be taken out of a hot folder.
    TakingFails,
    /// Something in a hot folder is not looked at.
    FolderUnseen,
    /// A claimed file cannot be read.
    ReadingFails,
    /// A stored file differs from the file that was dropped, or no archive holds an original that is needed again.
    FileDamaged,
    /// A refused or claimed file cannot be moved to its place.
    EndingFails,
    /// A build cannot be started.
    NestingFails,
    /// A build was given up, and its machine is paused.
    BuildFailed,
    /// A print failed, and nobody has seen to it.
    PrintFailed,
    /// A proved build waits for a person's yes.
    ReleaseDue,
    /// Parts wait for a person's yes.
    Question,
    /// A proved build cannot be published.
    PublishingFails,
    /// A proved build was staged in a queue folder that is no longer there.
    QueueReplaced,
    /// What lies in a queue folder must not be printed as it is.
    QueueAltered,
    /// A build whose copies were to be printed again could not be taken out of the queue.
    NotTakenBack,
    /// Parts wait for a machine that is not configured.
    MachineGone,
    /// Parts, tickets and order lists do not match, and wait.
    Incomplete,
    /// Refused files lie in an error folder.
    Refused,
    /// Files lie beside the hot folders, where no machine takes them.
    Stray,
    /// The dashboard is not served.
    DashboardDown,
    /// Messages cannot be delivered to a receiver.
    MessagesFail,
    /// Some other step keeps failing.
    StepFails,
}

/// What to do about a damaged stored file.
const DROP_AGAIN: &str = "Drop the same file into the machine's hot folder once more: it is taken in place of the missing one, not as another \
     order. Without it, `nestd cancel PART` ends the part. A file that differs from what was dropped lies in damaged/ of the \
     state folder: then check its disk. An original in no archive is past archive_days, or somebody removed it.";
/// What to do about a connection that all wait for.
const END_CONNECTION: &str = "The database ends a connection that does nothing within 10 s, and nestd goes on by itself; nothing is lost meanwhile. \
     Where this stays, look at the server of that connection; `SELECT pg_terminate_backend(..)` in the database, with the number of the \
     server process, ends it, and nothing is lost by that.";
/// What to do about a folder that cannot be read.
const LET_IT_BE_READ: &str = "The reason names the folder. Let nestd's user read and enter it, or move what is in it into the hot folder itself, \
     on the same file system; the files stay where they are until then. A recycle bin is emptied, or moved elsewhere.";
/// What to do about a missing ledger.
const PUT_BACK: &str = "Put the newest backup back, or the newer copy that nestd saved, with `nestd restore FILE`; without one, \
     `nestd restore --empty` creates a new ledger from the folders.";

impl AlertKind {
    /// What is wrong with the ledger, if the farm halts because of it.
    pub(crate) fn ledger_fault(self) -> Option<&'static str> {
        match self {
            Self::LedgerDamaged => Some("is damaged"),
            Self::LedgerBehind => Some("has lost changes"),
            Self::LedgerReplaced => Some("was removed, replaced or overwritten"),
            Self::LedgerTakenOver => Some("is served by another nestd in place of this one"),
            _ => None,
        }
    }

    /// Whether the ledger cannot be reached or changed, until that is over by itself.
    pub(crate) fn cuts_ledger_off(self) -> bool {
        matches!(self, Self::LedgerLocked | Self::LedgerUnreachable | Self::RepairDue)
    }

    /// Whether it is what people do every day, and nothing around the daemon is wrong.
    pub fn is_usual_work(self) -> bool {
        use AlertKind::{Incomplete, PrintFailed, Question, Refused, ReleaseDue, Stray};
        matches!(self, Incomplete | PrintFailed | Question | Refused | ReleaseDue | Stray)
    }

    /// Every kind.
    pub const ALL: [Self; 39] = [
        Self::LedgerDamaged,
        Self::LedgerBehind,
        Self::LedgerLost,
        Self::LedgerReplaced,
        Self::LedgerLocked,
        Self::LedgerUnreachable,
        Self::ChangesWait,
        Self::RepairDue,
        Self::LedgerTakenOver,
        Self::ConfigurationWrong,
        Self::HotFolderAway,
        Self::QueueAway,
        Self::ArchiveAway,
        Self::ErrorFolderAway,
        Self::HeldByOther,
        Self::OtherNode,
        Self::ForeignClaims,
        Self::FoldersMissing,
        Self::TakingFails,
        Self::FolderUnseen,
        Self::ReadingFails,
        Self::FileDamaged,
        Self::EndingFails,
        Self::NestingFails,
        Self::BuildFailed,
        Self::PrintFailed,
        Self::ReleaseDue,
        Self::Question,
        Self::PublishingFails,
        Self::QueueReplaced,
        Self::QueueAltered,
        Self::NotTakenBack,
        Self::MachineGone,
        Self::Incomplete,
        Self::Refused,
        Self::Stray,
        Self::DashboardDown,
        Self::MessagesFail,
        Self::StepFails,
    ];

    /// What is wrong in general; the detail of the alert follows it.
    pub fn headline(self) -> &'static str {
        match self {
            Self::LedgerDamaged => "The ledger is damaged: nestd takes and publishes nothing",
            Self::LedgerBehind => {
                "The ledger is older than the folders: nestd takes and prints nothing, so that no part is printed twice"
            }
            Self::LedgerLost => "The ledger is gone: nestd does not start, for it would forget all that it has taken",
            Self::LedgerReplaced => {
                "The ledger was removed, replaced or overwritten while nestd ran: nestd takes and publishes nothing"
            }
            Self::LedgerLocked => {
                "Another process keeps the ledger from being changed: nestd takes and publishes nothing until it lets go"
            }
            Self::LedgerUnreachable => {
                "The server of the ledger cannot be reached: nestd takes and publishes nothing until it can"
            }
            Self::ChangesWait => "All changes of the ledger wait for one connection, and so does nestd",
            Self::RepairDue => {
                "The ledger has lost the last changes of other nodes: nestd takes and publishes nothing until they are repaired"
            }
            Self::LedgerTakenOver => "Another nestd is this node now: this one takes and publishes nothing more",
            Self::ConfigurationWrong => "The changed configuration was refused; the previous one stays in force",
            Self::HotFolderAway => "The hot folder is unavailable",
            Self::QueueAway => "The queue folder cannot be used",
            Self::ArchiveAway => "The archive cannot be used",
            Self::ErrorFolderAway => "The error folder cannot be used",
            Self::HeldByOther => "Another nestd serves the folders: this one takes and prints nothing there",
            Self::OtherNode => "Another node of the farm serves the machine: this one takes and prints nothing there",
            Self::ForeignClaims => "Another nestd has claimed files in the hot folder, and they are left to it",
            Self::FoldersMissing => "The folders cannot be made",
            Self::TakingFails => "Files cannot be taken out of the hot folder",
            Self::FolderUnseen => "Something in the hot folder is not looked at, and nothing of it is printed",
            Self::ReadingFails => "A file that was taken cannot be read",
            Self::FileDamaged => "The file of a part is damaged or no longer kept, and must be dropped again",
            Self::EndingFails => "A file that was taken cannot be put where it belongs",
            Self::NestingFails => "A build cannot be made now",
            Self::BuildFailed => "A build failed, and its machine is paused",
            Self::PrintFailed => "A print failed, and nobody has seen to it",
            Self::ReleaseDue => "A proved build waits for a yes before it is published",
            Self::Question => "Parts wait for a yes before they are printed",
            Self::PublishingFails => "A proved build cannot be published",
            Self::QueueReplaced => "A proved build was staged in a queue folder that is not there any more",
            Self::QueueAltered => "A file in a queue folder must not be printed as it is",
            Self::NotTakenBack => "A build whose copies were to be printed again could not be taken out of the queue",
            Self::MachineGone => "Parts wait for a machine that is not configured",
            Self::Incomplete => "Parts, tickets and order lists do not fit together, and wait",
            Self::Refused => "Refused files lie in the error folder",
            Self::Stray => "Files lie beside the hot folders, where nobody prints them",
            Self::DashboardDown => "The dashboard is not served; the farm works without it",
            Self::MessagesFail => "Messages cannot be delivered; the farm works without them",
            Self::StepFails => "A step keeps failing",
        }
    }

    /// What to do about it.
    pub fn remedy(self) -> &'static str {
        match self {
            Self::LedgerDamaged => {
                "Stop nestd, keep the ledger's files, check the disk, and put the newest backup back with `nestd restore FILE`."
            }
            Self::LedgerBehind => {
                "Stop nestd, run `nestd check --deep --repair`, which records in the ledger what the folders \
                 hold, act on what it reports, and start nestd."
            }
            Self::LedgerLost => PUT_BACK,
            Self::LedgerReplaced => {
                "Stop nestd. Put the copy back that nestd saved, or else the newest backup, with `nestd restore FILE`, and start \
                 nestd; another ledger that is there now is kept aside."
            }
            Self::LedgerLocked => {
                "Wait until that process has finished its change, or end it; nestd then goes on by itself. Nothing is lost meanwhile. A start waits \
                 for it, too."
            }
            Self::LedgerUnreachable => {
                "Start the PostgreSQL server, or mend the way to it; nestd then goes on by itself. Nothing is lost meanwhile."
            }
            Self::ChangesWait => END_CONNECTION,
            Self::RepairDue => {
                "On each node that is named, stop nestd, run `nestd check --deep --repair`, and start nestd; this one then goes on by \
                 itself. Where a node is gone for good, take its machines over with `nestd adopt MACHINE`."
            }
            Self::LedgerTakenOver => {
                "Another process has this node's name, or its machines were adopted. Where that was meant, start this nestd again: it \
                 goes on with the machines that are left to it. Two servers need two names: node.name."
            }
            Self::ConfigurationWrong => "Run `nestd check`, mend what it names, and reload nestd.",
            Self::HotFolderAway => {
                "Mount it again, and let nestd's user read, write and enter it; `nestd check` says more. If it was replaced on \
                 purpose, accept the folder that is there now: touch its .nestd-owner."
            }
            Self::QueueAway => {
                "Mount it again, and let nestd's user write into it; `nestd check` says more. Builds wait until then. If it was \
                 replaced on purpose, accept the folder that is there now: touch its .nestd-owner."
            }
            Self::ArchiveAway => {
                "Mount it again, and let nestd's user write into it. No build is made or published until then. If it was replaced \
                 on purpose, accept the folder that is there now: touch its .nestd-owner."
            }
            Self::ErrorFolderAway => {
                "Mount it again, and let nestd's user write into it. What is refused stays where it is until then. If it was \
                 replaced on purpose, accept the folder that is there now: touch its .nestd-owner."
            }
            Self::HeldByOther => {
                "Stop one of the two, or give each folders of its own. When the other one has ended, this one goes on by itself \
                 within half a minute, after it has compared the folders with its ledger."
            }
            Self::OtherNode => {
                "Remove the machine's file from profiles/ here or on that node, and reload both. If that node is gone for good, take its \
                 machine over with `nestd adopt MACHINE`."
            }
            Self::ForeignClaims => {
                "If that nestd is still in use, start it: it takes them itself. If it is gone for good, or another one \
                 takes its place, take them over with `nestd adopt MACHINE`."
            }
            Self::FoldersMissing => "Mount or make the folder above them, and let nestd's user write there.",
            Self::TakingFails => {
                "Free some room where the disk is full, and let nestd's user write into hot folder and state folder. The files \
                 stay where they are until then."
            }
            Self::FolderUnseen => LET_IT_BE_READ,
            Self::ReadingFails => "Check the disk of the state folder, and free some room where it is full.",
            Self::FileDamaged => DROP_AGAIN,
            _ => self.remedy_for_builds_and_receivers(),
        }
    }

    /// [`AlertKind::remedy`] of alerts on builds and on receivers of messages.
    fn remedy_for_builds_and_receivers(self) -> &'static str {
        match self {
            Self::EndingFails => {
                "Free some room where the disk is full, and let nestd's user write into the error folder."
            }
            Self::NestingFails => "Free some room where the disk is full; `nestd check` says more.",
            Self::BuildFailed => {
                "See the reason, mend it, then `nestd resume MACHINE`: its parts wait, but for those that were refused since. A part that is \
                 the reason goes with `nestd cancel PART`."
            }
            Self::PrintFailed => {
                "Its copies wait again, unless that was declined: `nestd show BUILD` names them. When the machine is ready, \
                 `nestd dismiss BUILD` ends this."
            }
            Self::ReleaseDue => {
                "`nestd release BUILD` publishes it; `nestd release BUILD --preview` shows first what is in it, what waits \
                 beside it and what would be late. `approve` in the machine's file says which builds wait."
            }
            Self::Question => {
                "Print them as they are with `nestd confirm PART`, or take them out with `nestd cancel PART`. Where their size is \
                 wrong, `nestd edit PART --unit UNIT` has them read again."
            }
            Self::PublishingFails => {
                "Free some room where the disk is full, and let nestd's user write into the queue folder."
            }
            Self::QueueReplaced => {
                "Mount or configure the folder that it was staged in again. Where that is lost for good, docs/administrator.md says \
                 how to settle the build."
            }
            Self::QueueAltered => "Do what is said of each file before somebody prints it.",
            Self::NotTakenBack => "Look whether it was printed, or is, and tell that (`nestd outcome`): it ends this.",
            Self::MachineGone => {
                "Put the machine's file back into profiles/ and reload nestd, or cancel the parts: `nestd status --parts` names \
                 them. Lines that a program ordered are cancelled with DELETE (docs/integrator.md)."
            }
            Self::Incomplete => {
                "Add the rows or files that are missing, but none that is in a build, and leave one list in each folder; what is \
                 left is refused, each with its reason: lists and parts after `incomplete_secs`, tickets without a part after `orphan_ticket_secs`."
            }
            Self::Refused => {
                "Read the .reason.txt beside each; mend the file and drop it again, or take it back with `nestd retry PART`. Then \
                 remove both from there, or run `nestd dismiss MACHINE`: they stay there, without an alert."
            }
            Self::Stray => "Move them into the folder of the machine that they are for.",
            Self::DashboardDown => "Mend what the reason names (`[web]` in the configuration), and restart nestd.",
            Self::MessagesFail => {
                "Mend what the reason names (`[notify]` in the configuration); `nestd notify --test` tries it. \
                 Messages not older than `keep_secs` are delivered then."
            }
            _ => "See the reason; `nestd check` looks for its cause.",
        }
    }

    /// Whether it concerns everybody, not only the users of one machine.
    fn is_farm_wide(self) -> bool {
        let own = [
            Self::Incomplete,
            Self::Refused,
            Self::BuildFailed,
            Self::PrintFailed,
            Self::ReleaseDue,
            Self::Question,
            Self::ReadingFails,
            Self::FileDamaged,
            Self::EndingFails,
            Self::NestingFails,
        ];
        !own.contains(&self)
    }
}

/// An active alert: a person must act.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FarmAlert {
    /// Kind of alert.
    pub kind: AlertKind,
    /// Machine, "" = the farm.
    pub machine: String,
    /// What was found, without a full stop; "" = the headline says everything.
    pub detail: String,
    /// Since when.
    pub since: Timestamp,
}

impl FarmAlert {
    /// What is wrong, as a sentence.
    pub fn alert_text(&self) -> String {
        let of = if self.machine.is_empty() { String::new() } else { format!("{}: ", self.machine) };
        match self.detail.trim_end_matches('.') {
            "" => format!("{of}{}.", self.kind.headline()),
            detail => format!("{of}{}: {detail}.", self.kind.headline()),
        }
    }

    /// Whether it is shown in the hot folder of a machine.
    pub fn is_shown_in(&self, machine: &str) -> bool {
        self.machine == machine || self.kind.is_farm_wide()
    }
}
