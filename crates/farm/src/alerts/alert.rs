//! Alerts: everything that a person must act on. There are no other errors: what recovers without help is a warning at
//! most.

use jiff::Timestamp;
use language::say;
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
    /// A node of the farm does not run, although nobody stopped it.
    NodeGone,
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

impl AlertKind {
    /// What is wrong with the ledger, if the farm halts because of it.
    pub(crate) fn ledger_fault(self) -> Option<String> {
        Some(match self {
            Self::LedgerDamaged => say!("ledger-is-damaged"),
            Self::LedgerBehind => say!("ledger-has-lost"),
            Self::LedgerReplaced => say!("ledger-was-replaced"),
            Self::LedgerTakenOver => say!("ledger-is-taken-over"),
            _ => return None,
        })
    }

    /// Whether the ledger cannot be reached or changed, until that is over by itself.
    pub fn cuts_ledger_off(self) -> bool {
        matches!(self, Self::LedgerLocked | Self::LedgerUnreachable | Self::RepairDue)
    }

    /// Whether it is what people do every day, and nothing around the daemon is wrong.
    pub fn is_usual_work(self) -> bool {
        use AlertKind::{Incomplete, PrintFailed, Question, Refused, ReleaseDue, Stray};
        matches!(self, Incomplete | PrintFailed | Question | Refused | ReleaseDue | Stray)
    }

    /// Whether nothing else that happened tells it: the refusal of a file is an event already.
    pub(crate) fn has_no_other_event(self) -> bool {
        self != Self::Refused
    }

    /// The word in files, events and programs.
    pub(crate) fn word(self) -> String {
        serde_json::to_value(self).ok().and_then(|word| word.as_str().map(str::to_owned)).unwrap_or_default()
    }

    /// Every kind.
    pub const ALL: [Self; 40] = [
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
        Self::NodeGone,
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
    pub fn headline(self) -> String {
        match self {
            Self::LedgerDamaged => say!("alert-ledger-damaged-headline"),
            Self::LedgerBehind => say!("alert-ledger-behind-headline"),
            Self::LedgerLost => say!("alert-ledger-lost-headline"),
            Self::LedgerReplaced => say!("alert-ledger-replaced-headline"),
            Self::LedgerLocked => say!("alert-ledger-locked-headline"),
            Self::LedgerUnreachable => say!("alert-ledger-unreachable-headline"),
            Self::ChangesWait => say!("alert-changes-wait-headline"),
            Self::RepairDue => say!("alert-repair-due-headline"),
            Self::LedgerTakenOver => say!("alert-ledger-taken-over-headline"),
            Self::ConfigurationWrong => say!("alert-configuration-wrong-headline"),
            Self::HotFolderAway => say!("alert-hot-folder-away-headline"),
            Self::QueueAway => say!("alert-queue-away-headline"),
            Self::ArchiveAway => say!("alert-archive-away-headline"),
            Self::ErrorFolderAway => say!("alert-error-folder-away-headline"),
            Self::HeldByOther => say!("alert-held-by-other-headline"),
            Self::OtherNode => say!("alert-other-node-headline"),
            Self::NodeGone => say!("alert-node-gone-headline"),
            Self::ForeignClaims => say!("alert-foreign-claims-headline"),
            Self::FoldersMissing => say!("alert-folders-missing-headline"),
            Self::TakingFails => say!("alert-taking-fails-headline"),
            Self::FolderUnseen => say!("alert-folder-unseen-headline"),
            Self::ReadingFails => say!("alert-reading-fails-headline"),
            Self::FileDamaged => say!("alert-file-damaged-headline"),
            Self::EndingFails => say!("alert-ending-fails-headline"),
            Self::NestingFails => say!("alert-nesting-fails-headline"),
            Self::BuildFailed => say!("alert-build-failed-headline"),
            Self::PrintFailed => say!("alert-print-failed-headline"),
            Self::ReleaseDue => say!("alert-release-due-headline"),
            Self::Question => say!("alert-question-headline"),
            Self::PublishingFails => say!("alert-publishing-fails-headline"),
            Self::QueueReplaced => say!("alert-queue-replaced-headline"),
            Self::QueueAltered => say!("alert-queue-altered-headline"),
            Self::NotTakenBack => say!("alert-not-taken-back-headline"),
            Self::MachineGone => say!("alert-machine-gone-headline"),
            Self::Incomplete => say!("alert-incomplete-headline"),
            Self::Refused => say!("alert-refused-headline"),
            Self::Stray => say!("alert-stray-headline"),
            Self::DashboardDown => say!("alert-dashboard-down-headline"),
            Self::MessagesFail => say!("alert-messages-fail-headline"),
            Self::StepFails => say!("alert-step-fails-headline"),
        }
    }

    /// What to do about it.
    pub fn remedy(self) -> String {
        match self {
            Self::LedgerDamaged => say!("alert-ledger-damaged-remedy"),
            Self::LedgerBehind => say!("alert-ledger-behind-remedy"),
            Self::LedgerLost => say!("alert-ledger-lost-remedy"),
            Self::LedgerReplaced => say!("alert-ledger-replaced-remedy"),
            Self::LedgerLocked => say!("alert-ledger-locked-remedy"),
            Self::LedgerUnreachable => say!("alert-ledger-unreachable-remedy"),
            Self::ChangesWait => say!("alert-changes-wait-remedy"),
            Self::RepairDue => say!("alert-repair-due-remedy"),
            Self::LedgerTakenOver => say!("alert-ledger-taken-over-remedy"),
            Self::ConfigurationWrong => say!("alert-configuration-wrong-remedy"),
            Self::HotFolderAway => say!("alert-hot-folder-away-remedy"),
            Self::QueueAway => say!("alert-queue-away-remedy"),
            Self::ArchiveAway => say!("alert-archive-away-remedy"),
            Self::ErrorFolderAway => say!("alert-error-folder-away-remedy"),
            Self::HeldByOther => say!("alert-held-by-other-remedy"),
            Self::OtherNode => say!("alert-other-node-remedy"),
            Self::NodeGone => say!("alert-node-gone-remedy"),
            Self::ForeignClaims => say!("alert-foreign-claims-remedy"),
            Self::FoldersMissing => say!("alert-folders-missing-remedy"),
            Self::TakingFails => say!("alert-taking-fails-remedy"),
            Self::FolderUnseen => say!("alert-folder-unseen-remedy"),
            Self::ReadingFails => say!("alert-reading-fails-remedy"),
            Self::FileDamaged => say!("alert-file-damaged-remedy"),
            _ => self.remedy_for_builds_and_receivers(),
        }
    }

    /// [`AlertKind::remedy`] of alerts on builds and on receivers of messages.
    fn remedy_for_builds_and_receivers(self) -> String {
        match self {
            Self::EndingFails => say!("alert-ending-fails-remedy"),
            Self::NestingFails => say!("alert-nesting-fails-remedy"),
            Self::BuildFailed => say!("alert-build-failed-remedy"),
            Self::PrintFailed => say!("alert-print-failed-remedy"),
            Self::ReleaseDue => say!("alert-release-due-remedy"),
            Self::Question => say!("alert-question-remedy"),
            Self::PublishingFails => say!("alert-publishing-fails-remedy"),
            Self::QueueReplaced => say!("alert-queue-replaced-remedy"),
            Self::QueueAltered => say!("alert-queue-altered-remedy"),
            Self::NotTakenBack => say!("alert-not-taken-back-remedy"),
            Self::MachineGone => say!("alert-machine-gone-remedy"),
            Self::Incomplete => say!("alert-incomplete-remedy"),
            Self::Refused => say!("alert-refused-remedy"),
            Self::Stray => say!("alert-stray-remedy"),
            Self::DashboardDown => say!("alert-dashboard-down-remedy"),
            Self::MessagesFail => say!("alert-messages-fail-remedy"),
            _ => say!("alert-step-fails-remedy"),
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
    /// The other node that asks for it; "" = this one.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub node: String,
}

impl FarmAlert {
    /// What is wrong, as a sentence in the language that is current. A detail that the catalogs do not know is quoted in English.
    pub fn alert_text(&self) -> String {
        let (headline, detail) = (self.kind.headline(), self.detail.trim_end_matches('.'));
        let what = match (detail, language::retold(detail)) {
            ("", _) => say!("alert-alone", headline = headline),
            (_, Some(detail)) => say!("alert-detailed", headline = headline, detail = detail),
            (detail, None) => say!("alert-quoted", headline = headline, detail = detail),
        };
        match [&self.machine, &self.node].into_iter().find(|of| !of.is_empty()) {
            None => what,
            Some(of) => say!("alert-of", machine = of, what = what),
        }
    }

    /// Whether this node cannot reach or change the ledger, until that is over by itself.
    pub fn cuts_ledger_off(&self) -> bool {
        self.node.is_empty() && self.kind.cuts_ledger_off()
    }

    /// Whether it is shown in the hot folder of a machine.
    pub fn is_shown_in(&self, machine: &str) -> bool {
        self.machine == machine || self.kind.is_farm_wide()
    }
}
