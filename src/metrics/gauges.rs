//! Gauges: what waits, what is in work, and whether machines, folders and the daemon work.

use std::sync::atomic::AtomicU64;

use anyhow::Result;
use farm::{DateRisk, FarmReading, MachineFact, MachineWord, PrinterWord};
use jiff::Timestamp;
use ledger::{Ledger, MachineRow, MachineStatus, NodeRow, UtcTimestamp};
use prometheus_client::{
    metrics::{family::Family, gauge::Gauge},
    registry::Registry,
};
use settings::Settings;

/// A gauge of floating-point values.
pub(super) type FloatGauge = Gauge<f64, AtomicU64>;
/// Label names and values.
pub(super) type LabelPairs = Vec<(&'static str, String)>;

/// The data for the gauges of one farm at one moment.
struct GaugeSnapshot<'a> {
    registry: &'a mut Registry,
    names: Vec<String>,
    status: Vec<MachineStatus>,
    machines: Vec<MachineRow>,
}

/// Registers all gauges.
pub(super) async fn register_gauges(registry: &mut Registry, ledger: &Ledger, settings: &Settings) -> Result<()> {
    let nodes = ledger.list_nodes().await?;
    let reading = FarmReading::read(ledger, settings.profiles.values(), Timestamp::now()).await?;
    let daemon = ledger.find_node(&settings.node.name).await?;
    let is_up = daemon.as_ref().is_some_and(|daemon| daemon.alive);
    // What a stopped daemon last saw of the machines says nothing about them now.
    let machines = if is_up { reading.rows.observed.clone() } else { Vec::new() };
    let names = settings.profiles.keys().cloned().collect();
    let mut snapshot = GaugeSnapshot { registry, names, status: reading.rows.statuses.clone(), machines };
    snapshot.register_waiting();
    snapshot.register_in_work();
    snapshot.register_machines();
    register_printers(registry, ledger, settings).await?;
    register_facts(registry, &reading.facts());
    register_dates(registry, settings.profiles.keys(), &reading.dates_at_risk(ledger).await?);
    register_daemon(registry, daemon.as_ref(), is_up);
    register_nodes(registry, &nodes);
    register_disk_space(registry, settings);
    Ok(())
}

impl GaugeSnapshot<'_> {
    /// Registers a gauge with a value for each machine that has one.
    fn register_status_gauge(
        &mut self,
        name: &str,
        help: &str,
        value: impl Fn(Option<&MachineStatus>, &str) -> Option<f64>,
    ) {
        let family = Family::<LabelPairs, FloatGauge>::default();
        for machine in &self.names {
            let status = self.status.iter().find(|s| s.machine == *machine);
            if let Some(value) = value(status, machine) {
                family.get_or_create(&vec![("machine", machine.clone())]).set(value);
            }
        }
        self.registry.register(name, help, family);
    }

    /// Registers a gauge with a value for each machine that the daemon observes.
    fn register_machine_gauge(&mut self, name: &str, help: &str, value: impl Fn(&MachineRow) -> Option<f64>) {
        let family = Family::<LabelPairs, FloatGauge>::default();
        for machine in self.machines.iter().filter(|s| self.names.contains(&s.machine)) {
            if let Some(value) = value(machine) {
                family.get_or_create(&vec![("machine", machine.machine.clone())]).set(value);
            }
        }
        self.registry.register(name, help, family);
    }

    fn register_waiting(&mut self) {
        let count = |value: u32| Some(f64::from(value));
        self.register_status_gauge("parts_waiting", "Parts with a copy in no build", |s, _| {
            count(s.map_or(0, |s| s.waiting_parts))
        });
        self.register_status_gauge("copies_waiting", "Copies in no build", |s, _| {
            count(s.map_or(0, |s| s.waiting_copies))
        });
        self.register_status_gauge("parts_being_read", "Parts that are taken and not read yet", |s, _| {
            count(s.map_or(0, |s| s.claimed_parts))
        });
        self.register_status_gauge(
            "oldest_waiting_timestamp_seconds",
            "When the oldest waiting part was taken",
            |s, _| Some(unix_seconds(s?.oldest_at?)),
        );
        self.register_status_gauge("next_due_timestamp_seconds", "The nearest due date of what waits", |s, _| {
            Some(unix_seconds(s?.due_at?))
        });
    }

    fn register_in_work(&mut self) {
        self.register_status_gauge("builds_in_work", "Builds that have fired and are not in the queue yet", |s, _| {
            Some(s.map_or(0, |s| s.nesting.len()) as f64)
        });
        self.register_status_gauge("open_build_height_meters", "Height of the open build's layout so far", |s, _| {
            Some(s?.open.as_ref()?.height_mm? / 1000.0)
        });
        self.register_status_gauge(
            "open_build_density_ratio",
            "Part volume over box volume of the open build's layout so far",
            |s, _| s?.open.as_ref()?.density,
        );
        self.register_status_gauge(
            "open_build_night_cpu_seconds",
            "CPU time since the last arrival that lowered the open build while it waited",
            |s, _| s?.open.as_ref()?.night_cpu_secs,
        );
        self.register_status_gauge(
            "open_build_night_gain_meters",
            "What that time gained in height since the last arrival",
            |s, _| Some(s?.open.as_ref()?.night_gain_mm? / 1000.0),
        );
        self.register_status_gauge("paused", "1 while nothing is fired", |s, _| {
            Some(gauge_from_bool(s.is_some_and(|s| s.paused.is_some())))
        });
    }

    fn register_machines(&mut self) {
        self.register_machine_gauge("available", "1 while parts are taken and builds can be put into the queue", |s| {
            Some(gauge_from_bool(s.trouble.is_empty()))
        });
        self.register_machine_gauge("inbox_available", "1 while the hot folder can be used", |s| {
            Some(gauge_from_bool(s.is_inbox_there))
        });
        self.register_machine_gauge("queue_writable", "1 while the queue folder can be written to", |s| {
            Some(gauge_from_bool(s.is_queue_writable))
        });
        self.register_machine_gauge(
            "last_scan_timestamp_seconds",
            "When the hot folder was last looked through",
            |s| Some(unix_seconds(s.scanned_at?)),
        );
    }
}

fn register_daemon(registry: &mut Registry, daemon: Option<&NodeRow>, is_up: bool) {
    let version = Family::<LabelPairs, FloatGauge>::default();
    version.get_or_create(&vec![("version", env!("CARGO_PKG_VERSION").to_owned())]).set(1.0);
    registry.register("version_info", "Version of nestd that gives these metrics", version);
    register_value(registry, "daemon_up", "1 while the daemon writes heartbeats", gauge_from_bool(is_up));
    if let Some(daemon) = daemon {
        register_value(
            registry,
            "last_beat_timestamp_seconds",
            "Last heartbeat of the daemon",
            unix_seconds(daemon.beat_at),
        );
    }
}

/// Registers whether each node of the farm runs.
fn register_nodes(registry: &mut Registry, nodes: &[NodeRow]) {
    let family = Family::<LabelPairs, FloatGauge>::default();
    for node in nodes {
        family.get_or_create(&vec![("node", node.name.clone())]).set(gauge_from_bool(node.alive));
    }
    registry.register("node_up", "1 while this node of the farm writes heartbeats", family);
}

/// Registers what each machine and each printer does, and when it is free.
fn register_facts(registry: &mut Registry, facts: &[MachineFact]) {
    let [machine_states, machine_free, printer_states, printer_free] =
        [(); 4].map(|()| Family::<LabelPairs, FloatGauge>::default());
    for fact in facts {
        let machine = ("machine", fact.machine.clone());
        for state in MachineWord::ALL {
            let labels = vec![machine.clone(), ("state", state.word().to_owned())];
            machine_states.get_or_create(&labels).set(gauge_from_bool(fact.state == state));
        }
        if let Some(at) = fact.free_at {
            machine_free.get_or_create(&vec![machine.clone()]).set(unix_seconds(at));
        }
        for printer in &fact.printers {
            let labels = vec![machine.clone(), ("printer", printer.printer.clone())];
            for state in PrinterWord::ALL {
                let labels = [&labels[..], &[("state", state.word().to_owned())]].concat();
                printer_states.get_or_create(&labels).set(gauge_from_bool(printer.state == state));
            }
            if let Some(at) = printer.free_at {
                printer_free.get_or_create(&labels).set(unix_seconds(at));
            }
        }
    }
    registry.register("machine_state", "1 for what the machine does, 0 for every other state", machine_states);
    registry.register("printer_state", "1 for what the printer does, 0 for every other state", printer_states);
    let help = "When the next print of one of the machine's printers could begin";
    registry.register("machine_free_timestamp_seconds", help, machine_free);
    registry.register("printer_free_timestamp_seconds", "When the printer's next print could begin", printer_free);
}

/// Registers how many due dates each machine would miss, and how many are at risk.
fn register_dates<'m>(registry: &mut Registry, machines: impl Iterator<Item = &'m String>, risks: &[DateRisk]) {
    let (late, at_risk) = (Family::<LabelPairs, FloatGauge>::default(), Family::<LabelPairs, FloatGauge>::default());
    for machine in machines {
        let (labels, risks) =
            (vec![("machine", machine.clone())], risks.iter().filter(|risk| risk.machine == *machine));
        late.get_or_create(&labels).set(risks.clone().filter(|risk| risk.is_late).count() as f64);
        at_risk.get_or_create(&labels).set(risks.count() as f64);
    }
    registry.register("dates_late", "Due dates of orders, or of parts without one, that are missed or will be", late);
    registry.register(
        "dates_at_risk",
        "Due dates that are late, or have less time left than plans are wrong by",
        at_risk,
    );
}

/// Registers whether each printer is in use, and how many builds lie in its queue folder.
async fn register_printers(registry: &mut Registry, ledger: &Ledger, settings: &Settings) -> Result<()> {
    let (up, queued) = (Family::<LabelPairs, FloatGauge>::default(), Family::<LabelPairs, FloatGauge>::default());
    let down = ledger.down_printers().await?;
    for (name, profile) in &settings.profiles {
        let counts = ledger.queued_counts(name).await?;
        for printer in profile.printers.iter().map(|printer| &printer.name) {
            let is_down = down.iter().any(|down| down.machine == *name && down.printer == *printer);
            let of_printer = counts.iter().find(|(of, _)| of == printer).map_or(0, |(_, count)| *count);
            let labels = vec![("machine", name.clone()), ("printer", printer.clone())];
            up.get_or_create(&labels).set(gauge_from_bool(!is_down));
            queued.get_or_create(&labels).set(of_printer as f64);
        }
    }
    registry.register("printer_up", "1 unless a person took the printer out of use", up);
    registry.register(
        "printer_queued_builds",
        "Builds in the queue folder of the printer that it has not taken",
        queued,
    );
    Ok(())
}

fn register_disk_space(registry: &mut Registry, settings: &Settings) {
    let Ok(stat) = rustix::fs::statvfs(&settings.state_dir) else { return };
    let bytes = |blocks: u64| blocks as f64 * stat.f_frsize as f64;
    register_value(registry, "disk_free_bytes", "Free space of the disk with ledger and store", bytes(stat.f_bavail));
    register_value(registry, "disk_size_bytes", "Size of the disk with ledger and store", bytes(stat.f_blocks));
}

/// Registers a gauge without labels.
fn register_value(registry: &mut Registry, name: &str, help: &str, value: f64) {
    let number = FloatGauge::default();
    number.set(value);
    registry.register(name, help, number);
}

fn gauge_from_bool(is: bool) -> f64 {
    if is { 1.0 } else { 0.0 }
}

fn unix_seconds(at: UtcTimestamp) -> f64 {
    at.0.as_millisecond() as f64 / 1000.0
}
