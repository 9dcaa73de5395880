//! The printers of a machine: several of one kind behind one hot folder, each with its queue folder. A machine whose file
//! names none is one printer, with the name and the queue folder of the machine.

use std::path::PathBuf;

use delivery::queue::QueueAddress;
use serde::{Deserialize, Serialize};

use crate::{FarmZone, WorkCalendar};

/// A printer of a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct PrinterRules {
    /// Its name, unique in the farm.
    pub name: String,
    /// Where its queue is.
    pub queue: QueueAddress,
    /// When its prints begin.
    pub calendar: WorkCalendar,
}

/// `[[printer]]` of a machine's file.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PrinterInputs {
    #[serde(default)]
    pub name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub queue: Option<PathBuf>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hours: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub days_off: Option<Vec<String>>,
}

/// When a person must release a proved build before it is published.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ApprovalPolicy {
    /// Never.
    #[default]
    Never,
    /// Where the build is thin.
    Thin,
    /// Always.
    Always,
}

/// When nestd takes a published build that its printer has not taken back out of the queue by itself, so that the next build holds
/// its copies and what has arrived since.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum WithdrawalPolicy {
    /// Never.
    #[default]
    Never,
    /// Where copies of the highest priority have arrived.
    Urgent,
    /// Also where any copies have arrived that probably fit into one build with it, while its printer prints for long.
    Always,
}

/// How the machine is used: what a print takes beside its height, and which builds wait for a yes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PrintingRules {
    /// What is loaded as long as no person says otherwise; "" = nothing is said.
    pub material: String,
    /// Hours from the end of a print to the begin of the next one on the same printer: cooling and unpacking.
    pub cool_down_hours: f64,
    /// Which builds wait for a person's yes.
    pub approve: ApprovalPolicy,
    /// A build lower than this share of the volume's height is thin, 0..1.
    pub thin: f64,
    /// Builds that lie in a printer's queue, or are made for it, at most; 0 = any number.
    pub queue_depth: u32,
    /// When published builds are withdrawn.
    pub withdraw: WithdrawalPolicy,
}

impl PrintingRules {
    /// Whether a build of this height waits for a person's yes; `share` = its height / that of the volume.
    pub fn needs_release(&self, share: f64) -> bool {
        match self.approve {
            ApprovalPolicy::Never => false,
            ApprovalPolicy::Thin => share < self.thin,
            ApprovalPolicy::Always => true,
        }
    }
}

impl PrinterRules {
    /// The first moment from `at` on in which a print may begin; the end of all time if the calendar is never open again.
    pub fn begins_at(&self, at: jiff::Timestamp, zone: &FarmZone) -> jiff::Timestamp {
        self.calendar.next_open(at, zone.time_zone()).unwrap_or(jiff::Timestamp::MAX)
    }

    /// The spans between two moments in which no print begins.
    pub fn closed_spans(
        &self,
        from: jiff::Timestamp,
        to: jiff::Timestamp,
        zone: &FarmZone,
    ) -> Vec<(jiff::Timestamp, jiff::Timestamp)> {
        self.calendar.closed_spans(from, to, zone.time_zone())
    }

    /// The last moment up to `at` in which a print may begin, if there is one.
    pub fn begins_by(&self, at: jiff::Timestamp, zone: &FarmZone) -> Option<jiff::Timestamp> {
        self.calendar.last_open(at, zone.time_zone())
    }
}
