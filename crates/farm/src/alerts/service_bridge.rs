//! Connects the farm with the other services of the daemon: pages, metrics and messages.

use std::{
    collections::BTreeMap,
    sync::{Arc, Mutex, PoisonError},
};

use settings::{OtherMachine, Settings, SharedSettings};
use tokio::sync::watch;

use super::alert::AlertKind;

/// What is wrong with each service, by alert and name; `None` = it works.
type ServiceReports = BTreeMap<(AlertKind, String), Option<String>>;

/// What the other services of the daemon may do with the ledger.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum ServicePhase {
    /// Nothing yet: the farm has not found it intact.
    #[default]
    Opening,
    /// Use it.
    Open,
    /// Nothing any more, and why, with the remedy: the farm has halted because of it.
    Halted(String),
    /// Nothing any more: the farm closes it.
    Closed,
}

/// Connects the farm with the other services of the daemon; usable from any thread.
#[derive(Debug, Clone, Default)]
pub struct ServiceBridge {
    reports: Arc<Mutex<ServiceReports>>,
    phase: watch::Sender<ServicePhase>,
    /// The settings by which they work: those of this node, with the machines of the others.
    settings: Option<SharedSettings>,
    /// The machines of other nodes.
    others: Arc<Mutex<Vec<OtherMachine>>>,
}

impl ServiceBridge {
    /// A connection to services that work by these settings.
    pub fn to_services_with(settings: SharedSettings) -> Self {
        Self { settings: Some(settings), ..Self::default() }
    }

    /// Has the services work by these settings: they are in force.
    pub fn adopt_settings(&self, settings: &Settings) {
        if let Some(shared) = &self.settings {
            let others = self.others.lock().unwrap_or_else(PoisonError::into_inner);
            *shared.write().unwrap_or_else(PoisonError::into_inner) =
                Arc::new(settings.with_machines_of_others(&others));
        }
    }

    /// Has the services know the machines of other nodes beside those of these settings.
    pub fn adopt_machines_of_others(&self, settings: &Settings, machines: Vec<OtherMachine>) {
        let mut others = self.others.lock().unwrap_or_else(PoisonError::into_inner);
        if *others != machines {
            *others = machines;
            drop(others);
            self.adopt_settings(settings);
        }
    }

    /// Reports that the dashboard is not served, and why.
    pub fn report_dashboard_failure(&self, why: &str) {
        self.store_report(AlertKind::DashboardDown, "", Some(why.to_owned()));
    }

    /// Reports why messages cannot be delivered to a receiver; `None` = they can.
    pub fn report_receiver(&self, name: &str, why: Option<String>) {
        self.store_report(AlertKind::MessagesFail, name, why);
    }

    /// Runs work that uses the ledger: starts it once the farm has found the ledger intact, and stops it when the farm
    /// begins to close the ledger, or halts.
    pub async fn run_while_open(&self, work: impl Future<Output = ()>) {
        self.run_until(|phase| *phase != ServicePhase::Open, work).await;
    }

    /// Same as [`ServiceBridge::run_while_open`] for work that goes on while the farm is halted, and does not use the ledger then.
    pub async fn run_until_closed(&self, work: impl Future<Output = ()>) {
        self.run_until(|phase| *phase == ServicePhase::Closed, work).await;
    }

    async fn run_until(&self, is_over: impl FnMut(&ServicePhase) -> bool, work: impl Future<Output = ()>) {
        let (mut begins, mut ends) = (self.phase.subscribe(), self.phase.subscribe());
        if begins.wait_for(|phase| *phase == ServicePhase::Open).await.is_ok() {
            tokio::select! {
                () = work => {}
                _ = ends.wait_for(is_over) => {}
            }
        }
    }

    /// Tells the services what they may do.
    pub fn set_phase(&self, phase: ServicePhase) {
        self.phase.send_replace(phase);
    }

    /// Why the farm has halted, with the remedy; `None` = it has not.
    pub fn halt_reason(&self) -> Option<String> {
        match &*self.phase.borrow() {
            ServicePhase::Halted(why) => Some(why.clone()),
            _ => None,
        }
    }

    fn store_report(&self, kind: AlertKind, about: &str, why: Option<String>) {
        let mut reports = self.reports.lock().unwrap_or_else(PoisonError::into_inner);
        // A success is stored too, so that an earlier alert is cleared.
        reports.insert((kind, about.to_owned()), why);
    }

    /// What is wrong with each service, as reported; `None` = it works.
    pub fn service_reports(&self) -> ServiceReports {
        self.reports.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}
