//! `nestd status`: shows the waiting parts, the builds that are being nested and whether the daemon runs.

use anyhow::Result;
use farm::{
    AlertKind, AlertSummary, DateRisk, FarmAlert, FarmReading, MachineFact, PrinterFact, alerts_of_farm, machine_fact,
};
use jiff::Timestamp;
use ledger::{Ledger, MachineStatus, NodeRow, PartRow, PartState};
use serde::Serialize;
use settings::{FarmZone, Settings};

use crate::{
    cli::{
        CommandExit, CommonArgs,
        terminal::{
            farm_context::{format_age, load_settings_leniently, run_with_ledger},
            table::{TextTable, print_fitted, print_json, print_text},
            terminal::output_columns,
            watch::watch_terminal,
        },
    },
    tables::{
        FarmNode, ListedPart, MACHINE_COLUMNS, MachineForecast, MachineNow, NODE_COLUMNS, PART_COLUMNS,
        PRINTER_COLUMNS, TimeView, list_farm_nodes,
    },
};

/// This many refused parts are listed; `nestd show` finds the older ones.
const REFUSED_LISTED: u32 = 20;

/// Arguments of the command.
#[derive(Debug, clap::Args)]
pub struct StatusArgs {
    /// Also list the parts that are claimed, waiting, batched or refused, with their numbers
    #[arg(long)]
    parts: bool,
    /// Redraw in place every 2 s on a terminal; Ctrl-C ends it
    #[arg(long, conflicts_with = "json")]
    watch: bool,
    /// Print all columns, however wide the terminal is
    #[arg(long)]
    wide: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Columns of the machines and of the parts that are left out on a narrow terminal, the first of them first.
const LEAST_COLUMNS: &[&str] = &["last_published", "oldest", "priority", "waiting_parts"];

/// The current state of a farm.
#[derive(Debug, Serialize)]
pub struct FarmStatus {
    /// The daemon of this node.
    daemon: Option<NodeRow>,
    /// All nodes of the farm, with their machines.
    nodes: Vec<FarmNode>,
    /// Whether a daemon holds the ledger, even one that has not written into it yet.
    #[serde(skip)]
    is_served: bool,
    /// What keeps a daemon that runs from writing into the ledger, as far as that is likely.
    #[serde(skip)]
    silence_hint: String,
    /// Who keeps the ledger from being changed.
    #[serde(skip)]
    locked_by: Option<String>,
    /// Problems that a person must solve.
    #[serde(serialize_with = "attention_as_json")]
    attention: Vec<FarmAlert>,
    /// Machines, by name.
    machines: Vec<ListedMachine>,
    /// What is late, or at risk to be, by due date.
    dates_at_risk: Vec<DateRisk>,
    /// The requested parts.
    #[serde(skip_serializing_if = "Option::is_none")]
    parts: Option<Vec<PartRow>>,
}

/// The current state of a machine.
#[derive(Debug, Serialize)]
struct ListedMachine {
    /// Whether the machine is configured (still).
    configured: bool,
    #[serde(flatten)]
    forecast: MachineForecast,
}

/// Runs the command.
pub fn run(common: &CommonArgs, args: &StatusArgs) -> Result<CommandExit> {
    let settings = load_settings_leniently(common)?;
    if args.watch {
        watch_terminal(|columns| {
            let attention = farm::read_stored_alerts(&settings.state_dir);
            let status = read_farm_status(settings.clone(), args.parts);
            // The ledger itself may be what needs a person.
            let status = status.map_err(|error| match attention_text(&attention) {
                text if text.is_empty() => error,
                text => anyhow::anyhow!("{error:#}\n\n{text}"),
            })?;
            Ok(status.to_text(Timestamp::now(), &settings.time_zone, columns))
        })?;
        return Ok(CommandExit::Success);
    }
    let attention = farm::read_stored_alerts(&settings.state_dir);
    let zone = settings.time_zone.clone();
    let status = match read_farm_status(settings, args.parts) {
        Ok(status) => status,
        Err(error) => {
            // The ledger itself may be what needs a person.
            match (attention.is_empty(), args.json) {
                (true, _) => {}
                (_, true) => print_json(&serde_json::json!({ "attention": attention_json(&attention) }))?,
                (_, false) => print_text(&attention_text(&attention))?,
            }
            return Err(error);
        }
    };
    match args.json {
        true => print_json(&status)?,
        false => print_fitted(&status.to_text(Timestamp::now(), &zone, output_columns(args.wide)), args.wide)?,
    }
    Ok(CommandExit::Success)
}

/// Reads the status from a farm's ledger.
fn read_farm_status(settings: Settings, with_parts: bool) -> Result<FarmStatus> {
    run_with_ledger(settings, async |settings, ledger| {
        let names: Vec<&str> = settings.profiles.keys().map(String::as_str).collect();
        let mut status = read_status(ledger, &settings.node.name, &names, with_parts).await?;
        let statuses: Vec<MachineStatus> =
            status.machines.iter().map(|machine| machine.forecast.status.clone()).collect();
        let now = Timestamp::now();
        let reading = FarmReading::read(ledger, settings.profiles.values(), now).await?;
        let mut facts = reading.facts();
        for (machine, of_ledger) in status.machines.iter_mut().zip(statuses) {
            if let Some(place) = facts.iter().position(|fact| fact.machine == of_ledger.machine) {
                let (profile, fact) = (settings.profiles.get(&of_ledger.machine), facts.swap_remove(place));
                machine.forecast = MachineForecast::new(of_ledger, profile, fact, now);
            }
        }
        status.attention = alerts_of_farm(settings, status.nodes.iter().map(|listed| &listed.node));
        status.dates_at_risk = reading.dates_at_risk(ledger).await?;
        Ok(status)
    })
}

/// Reads the status from a ledger; `configured` are the profiles of the settings, and `node` is this one.
pub async fn read_status(ledger: &Ledger, node: &str, configured: &[&str], with_parts: bool) -> Result<FarmStatus> {
    let known = ledger.machine_statuses().await?;
    let machine = |configured: bool, status: MachineStatus| ListedMachine {
        configured,
        forecast: {
            let now = Timestamp::now();
            let fact = machine_fact(&status, None, Vec::new(), &[]);
            MachineForecast::new(status, None, fact, now)
        },
    };
    let mut machines: Vec<ListedMachine> = (configured.iter())
        .filter(|name| !known.iter().any(|k| k.machine == **name))
        .map(|name| MachineStatus::nothing_of(name))
        .map(|status| machine(true, status))
        .collect();
    // A removed machine for which nothing is left to do is history.
    let is_of_interest = |status: &MachineStatus| {
        configured.contains(&status.machine.as_str())
            || status.paused.is_some()
            || status.waiting_parts + status.claimed_parts > 0
            || !status.nesting.is_empty()
    };
    let known = known.into_iter().filter(is_of_interest);
    machines.extend(known.map(|status| machine(configured.contains(&status.machine.as_str()), status)));
    machines.sort_by(|a, b| a.forecast.status.machine.cmp(&b.forecast.status.machine));
    let parts = if with_parts { Some(list_parts(ledger).await?) } else { None };
    let (daemon, is_served) = (ledger.find_node(node).await?, ledger.is_served_by(node).await?);
    let nodes = list_farm_nodes(ledger).await?;
    let (silence_hint, locked_by) = (ledger.silence_hint().await?, ledger.locked_by().await?);
    Ok(FarmStatus {
        daemon,
        nodes,
        is_served,
        silence_hint,
        locked_by,
        attention: Vec::new(),
        machines,
        dates_at_risk: Vec::new(),
        parts,
    })
}

async fn list_parts(ledger: &Ledger) -> Result<Vec<PartRow>> {
    let mut parts = Vec::new();
    for state in PartState::ALL.into_iter().filter(|state| state.is_live()) {
        parts.extend(ledger.parts_in_state(state).await?);
    }
    parts.extend(
        ledger.parts_in_state_between(PartState::Refused, Timestamp::MIN, Timestamp::MAX, REFUSED_LISTED).await?,
    );
    Ok(parts)
}

impl FarmStatus {
    /// The status as text; tables wider than `columns` become lists.
    pub fn to_text(&self, now: Timestamp, zone: &FarmZone, columns: usize) -> String {
        let view = TimeView::at(zone, now);
        let machine = |machine: &ListedMachine| MachineNow {
            forecast: machine.forecast.clone(),
            is_configured: machine.configured,
            other_node: self.other_node_of(&machine.forecast.status.machine),
            view: view.clone(),
        };
        let table = TextTable::of(MACHINE_COLUMNS, &self.machines.iter().map(machine).collect::<Vec<_>>(), &view);
        let attention = attention_text(&self.attention);
        let gap = if attention.is_empty() { "" } else { "\n" };
        let mut text =
            format!("{}\n{gap}{attention}\n{}", self.daemon_line(now), table.fit_essentials(columns, LEAST_COLUMNS));
        let facts = self.machines.iter().map(|machine| &machine.forecast.fact);
        let printers: Vec<PrinterFact> = facts.flat_map(MachineFact::shown_printers).cloned().collect();
        if !printers.is_empty() {
            let table = TextTable::of(PRINTER_COLUMNS, &printers, &view);
            text += &format!("\n{}", table.fit_essentials(columns, &["times", "free_at"]));
        }
        for risk in &self.dates_at_risk {
            text += &format!("\n{}: {}.", risk.subject_text(), risk.in_words(zone, now));
        }
        if !self.dates_at_risk.is_empty() {
            text += "\n";
        }
        if self.nodes.len() > 1 {
            text += &format!(
                "\n{}",
                TextTable::of(NODE_COLUMNS, &self.nodes, &view).fit_essentials(columns, &["version", "host"])
            );
        }
        if let Some(parts) = &self.parts {
            let listed: Vec<ListedPart> = parts.iter().cloned().map(ListedPart::unbuilt).collect();
            text +=
                &format!("\n{}", TextTable::of(PART_COLUMNS, &listed, &view).fit_essentials(columns, LEAST_COLUMNS));
        }
        text
    }

    /// The node that serves a machine, unless it is this one.
    fn other_node_of(&self, name: &str) -> Option<String> {
        let serves = |listed: &&FarmNode| listed.machines.iter().any(|machine| machine == name);
        let is_this = |listed: &FarmNode| self.daemon.as_ref().is_some_and(|own| own.name == listed.node.name);
        self.nodes.iter().find(serves).filter(|listed| !is_this(listed)).map(|listed| listed.node.name.clone())
    }

    fn daemon_line(&self, now: Timestamp) -> String {
        let halted = farm::halt_summary(&self.attention).filter(|_| self.is_served);
        match (&self.daemon, halted) {
            // It does not write into the ledger any more, and what is there may be another daemon's.
            (Some(d), Some(halted)) if !d.alive || d.is_silent(now) => format!("A daemon runs: {halted}."),
            (daemon, _) => self.heartbeat_line(daemon.as_ref(), now),
        }
    }

    /// What the last heartbeat tells.
    fn heartbeat_line(&self, daemon: Option<&NodeRow>, now: Timestamp) -> String {
        match daemon {
            None if self.is_served => match self.is_cut_off() || self.locked_by.is_some() {
                true => format!("A daemon waits before it begins. {}", self.silence_reason()),
                false => {
                    "A daemon is starting, or waits for something: its log says for what, and `nestd check` finds most causes."
                        .to_owned()
                }
            },
            None => "The daemon does not run.".to_owned(),
            // Its last sign of life is an earlier daemon's: this one could not write any.
            Some(d) if !d.alive && self.is_served => format!(
                "A daemon runs, but nothing was written into the ledger for {}: this status may be that old. {}",
                format_age(Some(d.beat_at), now),
                self.silence_reason()
            ),
            Some(d) if !d.alive => {
                format!("The daemon does not run; its last sign of life was {} ago.", format_age(Some(d.beat_at), now))
            }
            Some(d) => {
                let since = format_age(Some(d.started_at), now);
                let runs = format!("The daemon runs on {} (process {}, version {}) for {since}", d.host, d.pid, d.version);
                match d.is_silent(now) {
                    true => format!(
                        "{runs}, but has not written into the ledger for {}: this status may be that old. {}",
                        format_age(Some(d.beat_at), now),
                        self.silence_reason()
                    ),
                    false => match self.locked_by.is_some() && !self.is_cut_off() {
                        true => format!("{runs}. {}", self.silence_reason()),
                        false => format!("{runs}: {}.", self.activity_text()),
                    },
                }
            }
        }
    }

    /// Why the daemon writes nothing: what it has told itself, which stands below, or what it may be.
    fn silence_reason(&self) -> String {
        match self.is_cut_off() {
            true => "It says below why.".to_owned(),
            false => format!("{}; `nestd check` says more.", self.silence_hint),
        }
    }

    /// Whether it has told what keeps it from the ledger.
    fn is_cut_off(&self) -> bool {
        self.attention.iter().any(FarmAlert::cuts_ledger_off)
    }

    /// What the daemon does, according to its alerts and the rows of the table below.
    fn activity_text(&self) -> String {
        if let Some(halted) = farm::halt_summary(&self.attention) {
            return halted;
        }
        // The files name other machines than the daemon serves.
        let is_refused =
            self.attention.iter().any(|alert| alert.kind == AlertKind::ConfigurationWrong && alert.node.is_empty());
        if let Some(daemon) = self.daemon.as_ref().filter(|daemon| is_refused && !daemon.status.is_empty()) {
            return daemon.status.clone();
        }
        let machines = self.machines.iter().filter(|machine| machine.configured).count();
        farm::farm_summary(machines, self.machines.iter().map(|machine| &machine.forecast.status))
    }
}

/// The problems that a person must solve, each with its remedy; empty when there are none.
fn attention_text(notices: &[FarmAlert]) -> String {
    let sentence = |notice: &FarmAlert| intake::display_name(notice.alert_text().as_ref()).replace("\\\\", "\\");
    let lines = notices.iter().map(|n| format!("  {}\n    -> {}\n", sentence(n), n.kind.remedy()));
    match notices {
        [] => String::new(),
        [_] => format!("1 thing needs a person:\n{}", lines.collect::<String>()),
        all => format!("{} things need a person:\n{}", all.len(), lines.collect::<String>()),
    }
}

fn attention_json(notices: &[FarmAlert]) -> Vec<AlertSummary> {
    notices.iter().map(AlertSummary::from).collect()
}

fn attention_as_json<S: serde::Serializer>(notices: &[FarmAlert], serializer: S) -> Result<S::Ok, S::Error> {
    attention_json(notices).serialize(serializer)
}
