//! Reads the configuration again, and takes over all of it or nothing. What can fail comes first: reading it, and what the ledger must
//! say of its machines.

use anyhow::{Result, bail};
use settings::Settings;
use tracing::{info, warn};

use super::{
    machine_setup::{self, MachineRows},
    status,
};
use crate::{
    alerts::alert::AlertKind,
    core::farm::Farm,
    nodes::{folder_comparison, watching},
    process::systemd,
};

/// Reads the configuration again. One that is wrong changes nothing, and an alert says why. One that is right changes nothing before the
/// ledger can be asked for its machines.
pub(crate) async fn reload_configuration(farm: &mut Farm) {
    systemd::notify_reloading();
    let read = read_configuration(farm);
    farm.alerts.clear(AlertKind::ConfigurationWrong, "", "");
    farm.lifecycle.next_settings = None;
    match read {
        Ok(settings) => {
            farm.lifecycle.next_settings = Some(settings);
            take_over_configuration(farm).await;
        }
        Err(failure) => {
            let detail = format!("nothing of it applies: {failure:#}").replace('\n', " ");
            farm.alerts.raise(AlertKind::ConfigurationWrong, "", "", &detail);
        }
    }
    // Machines may have been added or removed: the status is updated at once.
    farm.display.updated_at = None;
    farm.run_step("status", async |farm| status::update_status(&mut farm.desk()).await).await;
    systemd::notify_ready(&farm.display.status_line);
}

/// Takes over the configuration that was read, if one is due.
pub(crate) async fn take_over_configuration(farm: &mut Farm) {
    if let Some(settings) = farm.lifecycle.next_settings.clone() {
        let what = "taking over the new configuration (nothing of it applies before that)";
        farm.run_step(what, async |farm| take_over(farm, settings).await).await;
    }
}

async fn take_over(farm: &mut Farm, settings: Settings) -> Result<()> {
    let rows = MachineRows::read(&farm.ledger, &settings).await?;
    // From here on nothing fails.
    farm.lifecycle.next_settings = None;
    settings.files.apply_to_process();
    farm.lifecycle.services.adopt_settings(&settings);
    let (new, first) = (&settings.interfaces, &farm.lifecycle.started_with);
    for (section, is_new) in [("[web]", new.web != first.web), ("[log]", new.log != first.log)] {
        if is_new {
            warn!("The new values in {section} take effect at the next start.");
        }
    }
    farm.settings = settings;
    machine_setup::set_up_machines(&mut farm.desk(), rows);
    watching::create_missing_folders(&mut farm.machines, &mut farm.jobs);
    watching::start_watcher(&mut farm.desk());
    folder_comparison::start_folder_comparison(&mut farm.desk());
    info!(machines = farm.machines.len(), "The configuration was read again.");
    Ok(())
}

/// Reads the configuration, and refuses what a running daemon cannot change.
fn read_configuration(farm: &Farm) -> Result<Settings> {
    let settings = (farm.lifecycle.load)()?;
    let (new, old) = (&settings, &farm.settings);
    let fixed = [
        ("the state folder", new.state_dir != old.state_dir),
        ("the ledger", new.ledger != old.ledger),
        ("node.name", new.node.name != old.node.name),
    ];
    if let Some((what, _)) = fixed.iter().find(|(_, is_other)| *is_other) {
        bail!("{what} cannot change while the daemon runs: put the old value back, or stop nestd and start it again");
    }
    settings.files.ensure_assignable()?;
    Ok(settings)
}
