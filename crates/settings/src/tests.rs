//! Tests of reading a configuration.

use std::{
    fs,
    path::{Path, PathBuf},
};

use super::{machine::profile_inputs::ProfileInputs, service::inputs::FarmInputs, *};

mod chapter;
mod folders;
mod materials;
mod printers;

/// A configuration in its own folder.
struct TestConfig {
    folder: tempfile::TempDir,
}

impl TestConfig {
    fn new(farm: &str, machines: &[(&str, &str)]) -> Self {
        let config = Self { folder: tempfile::tempdir().unwrap() };
        fs::write(config.file("nestd.toml"), farm).unwrap();
        fs::create_dir(config.file("profiles")).unwrap();
        for (name, text) in machines {
            fs::write(config.file("profiles").join(name), text).unwrap();
        }
        config
    }

    fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn load(&self) -> Result<Settings, SettingsError> {
        load_settings(Some(&self.file("nestd.toml")), None)
    }

    /// `file:line: text; remedy` of every problem, without the folder.
    fn problems(&self) -> Vec<String> {
        let problems = match self.load() {
            Err(SettingsError::Invalid(problems)) => problems,
            other => panic!("no problems but {other:?}"),
        };
        let folder = format!("{}/", self.folder.path().display());
        problems.iter().map(|problem| problem.to_string().replace(&folder, "")).collect()
    }
}

const CUBE: &str = "volume_mm = [200, 200, 200]\n";

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config").join(name)
}

/// Every path of keys in a table, with dots.
fn keys(table: &toml::Table, before: &str) -> Vec<String> {
    let deeper = |(key, value): (&String, &toml::Value)| match value {
        toml::Value::Table(table) => keys(table, &format!("{before}{key}.")),
        _ => vec![format!("{before}{key}")],
    };
    let mut keys: Vec<String> = table.iter().flat_map(deeper).collect();
    keys.sort();
    keys
}

#[test]
fn the_shipped_file_holds_every_option_at_its_default() {
    let text = fs::read_to_string(shipped("nestd.toml")).unwrap();
    let inputs: FarmInputs = toml::from_str(&text).unwrap();
    let mut tryout = FarmInputs::default();
    // The shipped file turns the dashboard on for people who try nestd out. The default opens no port.
    tryout.web.listen = "127.0.0.1:7878".to_owned();
    assert_eq!(inputs, tryout);
    let all = toml::Table::try_from(FarmInputs::default()).unwrap();
    assert_eq!(keys(&toml::from_str(&text).unwrap(), ""), keys(&all, ""));
}

#[test]
fn the_shipped_machine_file_shows_the_options_that_have_no_default() {
    let text = fs::read_to_string(shipped("profiles/paper-200.toml")).unwrap();
    let option = |line: &str| line.strip_prefix("# ").filter(|rest| rest.contains(" = \"")).map(str::to_owned);
    let text: Vec<String> = text.lines().map(|line| option(line).unwrap_or_else(|| line.to_owned())).collect();
    let inputs: ProfileInputs = toml::from_str(&text.join("\n")).unwrap();
    let folders = inputs.folders;
    assert!(inputs.space.volume_mm.is_some(), "volume_mm");
    assert!(folders.inbox.is_some() && folders.queue.is_some(), "{folders:?}");
    assert!(folders.error.is_some() && folders.archive.is_some(), "{folders:?}");
}

#[test]
fn a_volume_of_four_lengths_is_reported_and_no_machine_goes_missing_in_silence() {
    let config = TestConfig::new("", &[("cube.toml", "volume_mm = [380, 284, 384, 380]\n")]);
    let problems = config.problems();
    assert!(problems.len() == 1 && problems[0].contains("cube.toml"), "{problems:?}");
}

#[test]
fn a_configuration_without_options_has_the_defaults() {
    let config = TestConfig::new("", &[("cube.toml", CUBE)]);
    let settings = config.load().unwrap();
    assert_eq!(settings.scan_secs, 10.0);
    assert_eq!(settings.limits, build_file::ReadLimits::default());
    let cube = &settings.profiles["cube"];
    assert_eq!(cube.trigger.max_wait_secs, 86_400.0);
    assert_eq!(cube.search.nest, nester::NestingConfig::default());
    assert_eq!(cube.intake.settle_secs, 5.0);
}

#[test]
fn a_machine_beats_the_farm_and_the_farm_beats_the_default() {
    let farm =
        "[defaults]\nclearance_mm = 4\nsettle_secs = \"1m\"\n[defaults.nest.paper]\npopulation = 10\niterations = 20\n";
    let machine = format!("{CUBE}clearance_mm = 5\n[nest.paper]\npopulation = 30\n");
    let config = TestConfig::new(farm, &[("a.toml", &machine), ("b.toml", CUBE)]);
    let profiles = config.load().unwrap().profiles;
    let of = |name: &str| {
        let p = &profiles[name];
        (
            p.space.clearance_mm,
            p.intake.settle_secs,
            p.search.nest.paper.population,
            p.search.nest.paper.iterations,
            p.search.nest.seed,
        )
    };
    assert_eq!(of("a"), (5.0, 60.0, 30, 20, 1));
    assert_eq!(of("b"), (4.0, 60.0, 10, 20, 1));
}

#[test]
fn folders_are_below_the_root_unless_they_are_absolute() {
    let farm = "root = \"/farm\"\n[folders]\nerror = \"/bad\"\nstate = \"st\"\n";
    let machine = format!("{CUBE}[folders]\nqueue = \"/printer/jobs\"\narchive = \"../old\"\n");
    let config = TestConfig::new(farm, &[("a.toml", &machine)]);
    let settings = config.load().unwrap();
    let folders = &settings.profiles["a"].folders;
    assert_eq!(folders.inbox, Path::new("/farm/inbox/a"));
    assert_eq!(folders.queue, Path::new("/printer/jobs"));
    assert_eq!(folders.error, Path::new("/bad/a"));
    assert_eq!(folders.archive, Path::new("/old"));
    assert_eq!(settings.state_dir, Path::new("/farm/st"));
    assert_eq!(settings.ledger.file().unwrap(), Path::new("/farm/st/nestd.db"));
}

#[test]
fn the_root_of_the_command_line_moves_all_but_absolute_folders() {
    let farm = "root = \"/farm\"\n[folders]\nerror = \"/bad\"\n";
    let config = TestConfig::new(farm, &[("a.toml", CUBE)]);
    let settings = load_settings(Some(&config.file("nestd.toml")), Some(Path::new("elsewhere/./x"))).unwrap();
    let root = std::env::current_dir().unwrap().join("elsewhere/x");
    assert_eq!(settings.root, root);
    assert_eq!(settings.profiles["a"].folders.inbox, root.join("inbox/a"));
    assert_eq!(settings.profiles["a"].folders.error, Path::new("/bad/a"));
    assert_eq!(settings.ledger.file().unwrap(), root.join("state/nestd.db"));
}

#[test]
fn off_switches_a_trigger_off_and_a_value_switches_it_on() {
    let machine = format!(
        "{CUBE}[trigger]\ncopies = 20\nfill_height = 0.9\ndue_margin_secs = \"off\"\nat = [\"17:00\", \"09:30\"]\n"
    );
    let config = TestConfig::new("", &[("a.toml", &machine)]);
    let trigger = &config.load().unwrap().profiles["a"].trigger;
    assert_eq!((trigger.copies, trigger.fill_height, trigger.fill_density), (Some(20), Some(0.9), None));
    assert_eq!(trigger.due_margin_secs, None);
    let times: Vec<String> = trigger.at.iter().map(ToString::to_string).collect();
    assert_eq!(times, ["09:30:00", "17:00:00"]);
}

#[test]
fn every_problem_is_reported_at_once_with_file_line_and_remedy() {
    let farm = "scan_sec = 10\nthreads = \"many\"\n\n[limits]\nmax_bytes = 0\n[defaults]\nsettle_secs = -1\n[node]\nlanes = 2\n";
    let machine = format!("{CUBE}clearance_mm = -2\nunit = \"cubit\"\n[trigger]\nat = [\"25:00\"]\ncopys = 3\n");
    let config = TestConfig::new(
        farm,
        &[("a.toml", &machine), ("b.toml", "volume_mm = [200, 200]\n"), ("c.toml", "layer_mm = 0.1\n")],
    );
    let mut problems = config.problems();
    problems.sort();
    lines_begin(
        &problems,
        &[
            "nestd.toml:1: unknown option \"scan_sec\"; did you mean \"scan_secs\"?",
            "nestd.toml:2: threads cannot be \"many\"; give a whole number, 0 or more",
            "nestd.toml:5: limits.max_bytes = 0 makes no sense; give a number from 1 to 18446744073709551615",
            "nestd.toml:7: settle_secs = -1 makes no sense; give a number from 0 to 86400",
            "nestd.toml:9: unknown option \"node.lanes\"; remove the line, or name one that is known here: \"name\", \"address\"",
            "profiles/a.toml:2: clearance_mm = -2 makes no sense; give a number from 0 to 100",
            "profiles/a.toml:3: unit cannot be \"cubit\"; use one of",
            "profiles/a.toml:5: trigger.at: \"25:00\" is not a time of day; write hours and minutes",
            "profiles/a.toml:6: unknown option \"trigger.copys\"; did you mean \"copies\"?",
            "profiles/b.toml:1: volume_mm cannot have 2 values; give three lengths, as in [200, 200, 200]",
            "profiles/c.toml: there is no volume_mm; add the machine's printable box",
        ],
    );
}

/// Checks that each line begins as expected and that there are no further lines.
fn lines_begin(lines: &[String], beginnings: &[&str]) {
    let same =
        lines.len() == beginnings.len() && lines.iter().zip(beginnings).all(|(line, begin)| line.starts_with(begin));
    assert!(same, "\n{}\n---\n{}", lines.join("\n"), beginnings.join("\n"));
}

#[test]
fn directions_that_are_none_are_refused_with_their_line() {
    let machine = format!(
        "{CUBE}keep_up = [{{ direction = [0, 0, 0], within_deg = 30 }}]\nnot_down = [[0, 0, 1], {{ direction = [1, 0, 0] }}]\n"
    );
    let config = TestConfig::new("", &[("a.toml", &machine)]);
    let problems = config.problems();
    assert!(problems[0].starts_with("profiles/a.toml:2: keep_up: the direction is invalid"), "{problems:?}");
    assert!(problems[1].starts_with("profiles/a.toml:3: not_down: expected a direction like"), "{problems:?}");
    let many = format!("{CUBE}not_down = [{}]\n", "[0, 0, 1],".repeat(17));
    let problems = TestConfig::new("", &[("a.toml", &many)]).problems();
    assert_eq!(problems, ["profiles/a.toml:2: not_down names 17 directions; name 16 at most"]);
}

#[test]
fn values_out_of_range_are_refused_each_by_itself() {
    for (text, key) in [
        ("clearance_mm = nan", "clearance_mm"),
        ("clearance_mm = inf", "clearance_mm"),
        ("layer_mm = 0", "layer_mm"),
        ("layer_area_cap = 0", "layer_area_cap"),
        ("layer_area_cap = 1.1", "layer_area_cap"),
        ("clearance_z_extra_mm = -0.1", "clearance_z_extra_mm"),
        ("wall_margin_mm = 100", "wall margins"),
        ("floor_margin_mm = 150\nlid_margin_mm = 60", "margins of 150 and 60"),
        ("lid_margin_mm = -1", "lid_margin_mm"),
        ("max_attempts = 0", "max_attempts"),
        ("final_secs = \"30d\"", "final_secs"),
        ("settle_secs = \"soon\"", "settle_secs"),
        ("archive_days = 1.5", "archive_days"),
        ("archive_builds_days = 36501", "archive_builds_days"),
        ("[trigger]\nfill_density = 1.5", "trigger.fill_density"),
        ("[trigger]\nfill_height = 0", "trigger.fill_height"),
        ("[trigger]\ncopies = 0", "trigger.copies"),
        ("[trigger]\nmax_wait_secs = \"off\"", "trigger.max_wait_secs"),
        ("[trigger]\ngather_secs = \"2d\"", "trigger.gather_secs"),
        ("[nest.paper]\nswitch_probability = 1.2", "nest.paper.switch_probability"),
        ("[nest.paper]\nlevy_exponent = 2", "nest.paper.levy_exponent"),
        ("[folders]\ninbox = \"\"", "folders.inbox"),
        ("[folders]\ninbox = \"~/in\"", "folders.inbox"),
        ("trigger = 5", "trigger"),
        ("[delivery]\nkind = \"step\"", "use one of \"shared\", \"expanded\", \"stl\", \"parts\""),
        ("instances = \"expanded\"", "say kind = \"shared\" or \"expanded\" in the section [delivery]"),
    ] {
        let problems = TestConfig::new("", &[("a.toml", &format!("{CUBE}{text}\n"))]).problems();
        assert_eq!(problems.len(), 1, "{text}: {problems:?}");
        assert!(problems[0].contains(key) && problems[0].starts_with("profiles/a.toml:"), "{text}: {problems:?}");
    }
}

#[test]
fn a_daemon_has_room_for_its_connections_and_leaves_room_for_those_of_others() {
    for connections in [5, 51] {
        let farm = format!("[node]\nconnections = {connections}\n");
        let problems = TestConfig::new(&farm, &[("a.toml", CUBE)]).problems();
        assert!(problems.len() == 1 && problems[0].contains("node.connections"), "{problems:?}");
    }
}

#[test]
fn a_wrong_default_is_reported_once_also_where_every_machine_has_a_value_of_its_own() {
    let farm =
        "[defaults]\nclearance_mm = -1\nlid_margin_mm = -2\nvolume_mm = [0, 1, 1]\n[defaults.trigger]\ncopies = 0\n";
    let own = format!("{CUBE}clearance_mm = 3\nlid_margin_mm = 0\n");
    for trigger in ["[trigger]\ncopies = 5\n", ""] {
        let machine = format!("{own}{trigger}");
        let mut problems = TestConfig::new(farm, &[("a.toml", &machine), ("b.toml", &machine)]).problems();
        problems.sort();
        lines_begin(
            &problems,
            &[
                "nestd.toml:2: clearance_mm = -1 makes no sense; give a number from 0 to 100",
                "nestd.toml:3: lid_margin_mm = -2 makes no sense; give a number from 0",
                "nestd.toml:4: volume_mm = [0, 1, 1] is not a box",
                "nestd.toml:6: trigger.copies = 0 would always fire",
            ],
        );
    }
}

#[test]
fn the_time_zone_of_the_farm_is_that_of_its_machines_and_an_unknown_one_is_refused_with_its_line() {
    let settings = TestConfig::new("time_zone = \"Europe/Berlin\"\n", &[("a.toml", CUBE)]).load().unwrap();
    assert_eq!(
        (settings.time_zone.name(), settings.profiles["a"].time_zone.name()),
        ("Europe/Berlin", "Europe/Berlin")
    );
    let settings = TestConfig::new("", &[("a.toml", CUBE)]).load().unwrap();
    assert_eq!(settings.time_zone, FarmZone::default());
    for wrong in ["Europe/Bärlin", "CEST", "", "Etc/Unknown", "../etc/passwd"] {
        let farm = format!("scan_secs = 1\ntime_zone = \"{wrong}\"\n");
        let problems = TestConfig::new(&farm, &[("a.toml", CUBE), ("b.toml", CUBE)]).problems();
        assert_eq!(problems.len(), 1, "{problems:?}");
        assert!(problems[0].starts_with("nestd.toml:2: time_zone = "), "{problems:?}");
        assert!(problems[0].contains("name a zone as in \"Europe/Berlin\""), "{problems:?}");
    }
}

#[test]
fn a_volume_must_be_a_box() {
    for text in ["[0, 200, 200]", "[200, -1, 200]", "[200, 200, nan]", "[200, 200, 1e9]", "\"200x200x200\"", "200"] {
        let problems = TestConfig::new("", &[("a.toml", &format!("volume_mm = {text}\n"))]).problems();
        assert_eq!(problems.len(), 1, "{text}: {problems:?}");
        assert!(problems[0].starts_with("profiles/a.toml:1: volume_mm"), "{problems:?}");
    }
}

#[test]
fn broken_toml_and_broken_text_are_reported_with_their_line() {
    let config =
        TestConfig::new("root = \"/x\"\nscan_secs = \n", &[("a.toml", "volume_mm = [1, 2\n"), ("b.toml", CUBE)]);
    fs::write(config.file("profiles/b.toml"), b"layer_mm = 0.1\n# \xff\n").unwrap();
    let mut problems = config.problems();
    problems.sort();
    assert!(problems[0].starts_with("nestd.toml:2: is not valid TOML"), "{problems:?}");
    assert!(
        problems.iter().any(|p| p.starts_with("profiles/a.toml:") && p.contains("is not valid TOML")),
        "{problems:?}"
    );
    assert!(problems.contains(&"profiles/b.toml:2: is not UTF-8 text; save it as UTF-8".into()), "{problems:?}");
}

#[test]
fn a_number_with_a_comma_is_reported_once_with_the_line_as_it_is_to_be() {
    let problems = TestConfig::new("", &[("a.toml", &format!("{CUBE}clearance_mm = 2,5\n"))]).problems();
    let expected = "profiles/a.toml:2: clearance_mm = 2,5 has a comma in a number; write a point: clearance_mm = 2.5";
    assert_eq!(problems, [expected]);
}

#[test]
fn a_file_name_that_cannot_be_a_folder_name_is_refused() {
    for name in ["MJF.toml", "a b.toml", "ä.toml", &format!("{}.toml", "x".repeat(41))] {
        let problems = TestConfig::new("", &[(name, CUBE)]).problems();
        assert!(problems[0].contains("cannot be the name of a machine"), "{problems:?}");
    }
    let config = TestConfig::new("", &[("a.toml", CUBE), (".hidden.toml", "x"), ("notes.txt", "x"), ("b.toml~", "x")]);
    assert_eq!(config.load().unwrap().profiles.len(), 1);
}

#[test]
fn without_a_machine_or_a_file_it_is_said_what_to_do() {
    let problems = TestConfig::new("", &[]).problems();
    assert!(problems[0].contains("there is no machine; put one file per machine here"), "{problems:?}");
    let error = load_settings(Some(Path::new("/nowhere/nestd.toml")), None).unwrap_err().to_string();
    assert!(error.starts_with("no configuration: /nowhere/nestd.toml is not there; name one with -c FILE"), "{error}");
}

#[test]
fn a_directory_is_no_configuration() {
    let config = TestConfig::new("", &[("a.toml", CUBE)]);
    fs::create_dir(config.file("profiles/b.toml")).unwrap();
    let problems = config.problems();
    assert!(problems[0].starts_with("profiles/b.toml: cannot be read"), "{problems:?}");
}

#[test]
fn a_header_names_users_only_where_it_is_known_which_proxy_sends_it() {
    let config = |web: &str| TestConfig::new(&format!("[web]\n{web}\n"), &[("a.toml", CUBE)]);
    let user = "user_header = \"X-Remote-User\"";
    for listen in ["127.0.0.1:7878", "unix:/run/nestd/web.sock"] {
        let settings = config(&format!("listen = \"{listen}\"\n{user}")).load().unwrap();
        assert_eq!(settings.interfaces.web.unwrap().user_header.as_deref(), Some("x-remote-user"), "{listen}");
    }
    let listen = "listen = \"0.0.0.0:7878\"\nsign_in = true";
    let open = config(&format!("{listen}\n{user}")).problems();
    assert!(open.len() == 1 && open[0].contains("no address of web.user_header_from is believed"), "{open:?}");
    let named = config(&format!("{listen}\n{user}\nuser_header_from = [\"10.0.0.5\"]")).load().unwrap();
    assert_eq!(named.interfaces.web.unwrap().user_header_from, ["10.0.0.5".parse::<std::net::IpAddr>().unwrap()]);
    let wrong = config("listen = \"127.0.0.1:7878\"\nuser_header_from = [\"proxy\"]").problems();
    assert!(wrong.len() == 1 && wrong[0].contains("\"proxy\" is no address"), "{wrong:?}");
    let nobody_asked = config("listen = \"0.0.0.0:7878\"").problems();
    assert!(nobody_asked.len() == 1 && nobody_asked[0].contains("sign_in = true"), "{nobody_asked:?}");
    let wrong = config("listen = \"127.0.0.1:7878\"\nuser_header = \"no header\"").problems();
    assert!(wrong.len() == 1 && wrong[0].contains("is no name of a header"), "{wrong:?}");
}
