//! What needs a person: each kind with its headline and remedy, raised and cleared in one registry.

pub(super) mod alert;
pub(super) mod alert_registry;
pub(super) mod alert_summary;
pub(super) mod failure;
pub(super) mod service_bridge;
pub(super) mod stored_alerts;
