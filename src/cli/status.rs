//! `nestd status`: what waits, what is being nested, whether the daemon runs.

use anyhow::Result;
use jiff::Timestamp;
use serde::Serialize;

use super::{
    Common, Exit,
    reach::{age, over, settings_to_look},
    table::{Table, say, say_json},
    watch::watch,
};
use crate::{
    farm::{self, Notice},
    intake,
    ledger::{DaemonRow, Ledger, PartRow, PartState, ProfileStatus},
    settings::Settings,
    tables::{MACHINE_COLUMNS, MachineForecast, MachineNow, PART_COLUMNS, ToldNotice},
};

/// So many rejected parts are listed; `show` finds the older ones.
const REJECTED_LISTED: u32 = 20;

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Also list the parts that are claimed, waiting, batched or rejected, with their numbers
    #[arg(long)]
    parts: bool,
    /// Redraw in place every 2 s on a terminal; Ctrl-C ends it
    #[arg(long, conflicts_with = "json")]
    watch: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// A farm as it stands.
#[derive(Debug, Serialize)]
pub struct FarmStatus {
    /// The daemon that serves or served the ledger.
    daemon: Option<DaemonRow>,
    /// Whether a daemon holds the ledger, also one that has not written into it yet.
    #[serde(skip)]
    is_served: bool,
    /// What a person must see to.
    #[serde(serialize_with = "attention_as_json")]
    attention: Vec<Notice>,
    /// Machines, by name.
    profiles: Vec<Machine>,
    /// The parts that were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    parts: Option<Vec<PartRow>>,
}

/// A machine as it stands.
#[derive(Debug, Serialize)]
struct Machine {
    /// Whether the configuration knows it (still).
    configured: bool,
    #[serde(flatten)]
    forecast: MachineForecast,
}

/// Runs the command.
pub fn run(common: &Common, args: &Args) -> Result<Exit> {
    let settings = settings_to_look(common)?;
    if args.watch {
        watch(|columns| {
            let attention = farm::kept_notices(&settings.state_dir);
            let status = looked(settings.clone(), args.parts);
            // The ledger itself may be what needs a person.
            let status = status.map_err(|error| match attention_text(&attention) {
                text if text.is_empty() => error,
                text => anyhow::anyhow!("{error:#}\n\n{text}"),
            })?;
            Ok(FarmStatus { attention, ..status }.print(Timestamp::now(), columns))
        })?;
        return Ok(Exit::Success);
    }
    let attention = farm::kept_notices(&settings.state_dir);
    let status = match looked(settings, args.parts) {
        Ok(status) => FarmStatus { attention, ..status },
        Err(error) => {
            // The ledger itself may be what needs a person.
            match (attention.is_empty(), args.json) {
                (true, _) => {}
                (_, true) => say_json(&serde_json::json!({ "attention": attention_json(&attention) }))?,
                (_, false) => say(&attention_text(&attention))?,
            }
            return Err(error);
        }
    };
    match args.json {
        true => say_json(&status)?,
        false => say(&status.print(Timestamp::now(), usize::MAX))?,
    }
    Ok(Exit::Success)
}

/// Asks the ledger of a farm.
fn looked(settings: Settings, with_parts: bool) -> Result<FarmStatus> {
    over(settings, async |settings, ledger| {
        let names: Vec<&str> = settings.profiles.keys().map(String::as_str).collect();
        let mut status = look(ledger, &names, with_parts).await?;
        for machine in &mut status.profiles {
            let profile = settings.profiles.get(&machine.forecast.status.profile);
            machine.forecast = MachineForecast::new(machine.forecast.status.clone(), profile);
        }
        Ok(status)
    })
}

/// Asks the ledger; `configured` are the profiles of the settings.
pub async fn look(ledger: &Ledger, configured: &[&str], with_parts: bool) -> Result<FarmStatus> {
    let known = ledger.status().await?;
    let machine = |configured: bool, status| Machine { configured, forecast: MachineForecast::new(status, None) };
    let mut profiles: Vec<Machine> = (configured.iter())
        .filter(|name| !known.iter().any(|k| k.profile == **name))
        .map(|name| ProfileStatus { profile: (*name).to_owned(), ..ProfileStatus::default() })
        .map(|status| machine(true, status))
        .collect();
    profiles.extend(known.into_iter().map(|status| machine(configured.contains(&status.profile.as_str()), status)));
    profiles.sort_by(|a, b| a.forecast.status.profile.cmp(&b.forecast.status.profile));
    let parts = if with_parts { Some(parts(ledger).await?) } else { None };
    let (daemon, is_served) = (ledger.daemon().await?, ledger.is_served().await?);
    Ok(FarmStatus { daemon, is_served, attention: Vec::new(), profiles, parts })
}

async fn parts(ledger: &Ledger) -> Result<Vec<PartRow>> {
    let mut parts = Vec::new();
    for state in PartState::ALL.into_iter().filter(|state| state.is_live()) {
        parts.extend(ledger.parts_in_state(state).await?);
    }
    parts.extend(ledger.parts_since(PartState::Rejected, Timestamp::MIN, Timestamp::MAX, REJECTED_LISTED).await?);
    Ok(parts)
}

impl FarmStatus {
    /// For people; tables that are wider than so many columns are lists.
    pub fn print(&self, now: Timestamp, columns: usize) -> String {
        let machine = |machine: &Machine| MachineNow {
            forecast: machine.forecast.clone(),
            is_configured: machine.configured,
            now,
        };
        let table = Table::of(MACHINE_COLUMNS, &self.profiles.iter().map(machine).collect::<Vec<_>>());
        let attention = attention_text(&self.attention);
        let gap = if attention.is_empty() { "" } else { "\n" };
        let mut text = format!("{}\n{gap}{attention}\n{}", self.daemon_line(now), table.within(columns));
        if let Some(parts) = &self.parts {
            text += &format!("\n{}", Table::of(PART_COLUMNS, parts).within(columns));
        }
        text
    }

    fn daemon_line(&self, now: Timestamp) -> String {
        match &self.daemon {
            None if self.is_served => {
                "A daemon is starting, or waits for something: its log says for what, and `nestd check` finds most causes."
                    .to_owned()
            }
            None => "The daemon does not run.".to_owned(),
            Some(d) if !d.alive => {
                format!("The daemon does not run; its last sign of life was {} ago.", age(Some(d.beat_at), now))
            }
            Some(d) => {
                let since = age(Some(d.started_at), now);
                let runs = format!("The daemon runs on {} (process {}, version {}) for {since}", d.host, d.pid, d.version);
                match d.is_silent(now) {
                    true => format!(
                        "{runs}, but has not written into the ledger for {}: what stands here may be as old. Where \
                         the disk of the state folder is full, free some room; `nestd check` says more.",
                        age(Some(d.beat_at), now)
                    ),
                    false => format!("{runs}: {}.", self.does(d)),
                }
            }
        }
    }

    /// What the daemon does, by the same rows as the table below.
    fn does(&self, daemon: &DaemonRow) -> String {
        if daemon.status.starts_with(farm::HALTED) {
            return daemon.status.clone();
        }
        let machines = self.profiles.iter().filter(|machine| machine.configured).count();
        farm::summary(machines, self.profiles.iter().map(|machine| &machine.forecast.status))
    }
}

/// What a person must see to, each with what to do; "" when there is nothing.
fn attention_text(notices: &[Notice]) -> String {
    let sentence = |notice: &Notice| intake::display_name(notice.sentence().as_ref()).replace("\\\\", "\\");
    let lines = notices.iter().map(|n| format!("  {}\n    -> {}\n", sentence(n), n.kind.remedy()));
    match notices {
        [] => String::new(),
        [_] => format!("1 thing needs a person:\n{}", lines.collect::<String>()),
        all => format!("{} things need a person:\n{}", all.len(), lines.collect::<String>()),
    }
}

fn attention_json(notices: &[Notice]) -> Vec<ToldNotice> {
    notices.iter().map(ToldNotice::from).collect()
}

fn attention_as_json<S: serde::Serializer>(notices: &[Notice], serializer: S) -> Result<S::Ok, S::Error> {
    attention_json(notices).serialize(serializer)
}
