//! Printers of a machine.

use super::*;

const TWO: &str =
    "[[printer]]\nname = \"left\"\nqueue = \"/mnt/left\"\n[[printer]]\nname = \"right\"\nhours = \"Mon 6-7\"\n";

#[test]
fn a_machine_without_printers_is_one_of_its_own_name() {
    let machine = format!("{CUBE}[folders]\nqueue = \"/jobs\"\n");
    let settings = TestConfig::new("root = \"/farm\"\n", &[("a.toml", &machine)]).load().unwrap();
    let profile = &settings.profiles["a"];
    let printer = &profile.printers[0];
    assert_eq!(
        (profile.printers.len(), printer.name.as_str(), printer.queue.folder()),
        (1, "a", Some(Path::new("/jobs")))
    );
    assert!(!profile.has_named_printers());
}

#[test]
fn each_printer_has_its_folder_and_its_hours_or_those_of_its_machine() {
    let machine = format!("{CUBE}hours = \"Sat 8-12\"\n{TWO}");
    let settings = TestConfig::new("root = \"/farm\"\n", &[("a.toml", &machine)]).load().unwrap();
    let profile = &settings.profiles["a"];
    let [left, right] = &profile.printers[..] else { panic!("{:?}", profile.printers) };
    assert_eq!(
        [left, right].map(|printer| printer.queue.folder().unwrap()),
        [Path::new("/mnt/left"), Path::new("/farm/queue/right")]
    );
    assert_eq!(Some(&*profile.folders.queue), left.queue.folder());
    let friday = "2026-11-27T12:00:00Z".parse().unwrap();
    let opens = |printer: &PrinterRules| printer.begins_at(friday, &jiff::tz::TimeZone::UTC.into()).to_string();
    assert_eq!((opens(left), opens(right)), ("2026-11-28T08:00:00Z".to_owned(), "2026-11-30T06:00:00Z".to_owned()));
    let folders = settings.all_folders();
    assert!(profile.queue_folders().all(|queue| folders.iter().any(|folder| folder == queue)));
}

#[test]
fn names_and_folders_of_printers_are_their_own() {
    let problems_of = |a: &str, b: &str| {
        TestConfig::new("root = \"/farm\"\n", &[("a.toml", &format!("{CUBE}{a}")), ("b.toml", &format!("{CUBE}{b}"))])
            .problems()
    };
    let same = problems_of(TWO, "[[printer]]\nname = \"left\"\n");
    assert!(same.len() == 1 && same[0].contains("the name left of a printer of b is taken"), "{same:?}");
    let machine = problems_of("[[printer]]\nname = \"b\"\nqueue = \"q\"\n", "");
    assert!(machine.len() == 1 && machine[0].contains("the name b of a printer of"), "{machine:?}");
    let folder = problems_of(TWO, "[[printer]]\nname = \"other\"\nqueue = \"/mnt/left\"\n");
    assert!(folder.len() == 1 && folder[0].contains("the queue folder of the printer"), "{folder:?}");
    let twice = problems_of("[[printer]]\nname = \"x\"\nqueue = \"p\"\n[[printer]]\nname = \"x\"\nqueue = \"q\"\n", "");
    assert!(twice.len() == 1 && twice[0].contains("the name x of a printer of a is taken"), "{twice:?}");
}

#[test]
fn a_wrong_calendar_is_blamed_on_the_file_and_line_that_say_it() {
    let farm = "[defaults]\nhours = \"Mon-Fri 6-22\"\n";
    let problem = |machine: &str| {
        let problems = TestConfig::new(farm, &[("a.toml", &format!("{CUBE}{machine}"))]).problems();
        assert_eq!(problems.len(), 1, "{problems:?}");
        problems[0].clone()
    };
    let days = problem("hours = \"Mon-Sat 6-22\"\ndays_off = [\"25.12.\"]\n");
    assert!(days.starts_with("profiles/a.toml:3: days_off: ") && !days.contains("write hours"), "{days}");
    let days = problem("days_off = [\"25.12.\"]\n");
    assert!(days.starts_with("profiles/a.toml:2: days_off: "), "{days}");
    let two = "[[printer]]\nname = \"x\"\n[[printer]]\nname = \"y\"\n";
    let days = problem(&format!("{two}hours = \"always\"\ndays_off = [\"25.12.\"]\n"));
    assert!(days.starts_with("profiles/a.toml:7: days_off: "), "{days}");
    let hours = problem(&format!("{two}hours = \"Mo 6-22\"\n"));
    assert!(hours.starts_with("profiles/a.toml:6: hours: "), "{hours}");
    let farm =
        TestConfig::new("[defaults]\nhours = \"always\"\ndays_off = [\"25.12.\"]\n", &[("a.toml", CUBE)]).problems();
    assert!(farm[0].starts_with("nestd.toml:3: days_off: "), "{farm:?}");
}

#[test]
fn wrong_printers_are_told_with_what_helps() {
    let problem = |machine: &str| {
        let problems = TestConfig::new("", &[("a.toml", &format!("{CUBE}{machine}"))]).problems();
        assert_eq!(problems.len(), 1, "{problems:?}");
        problems[0].clone()
    };
    assert!(problem("hours = \"Mo 6-22\"\n").contains("\"Mo 6-22\" is not understood; write hours as in"));
    assert!(problem("days_off = [\"25.12.\"]\n").contains("\"25.12.\" is no day"));
    assert!(problem("thin = 2\n").contains("thin = 2 makes no sense"));
    assert!(problem("[[printer]]\nname = \"Left 1\"\n").contains("cannot be the name of a printer"));
    let both = format!("[folders]\nqueue = \"/jobs\"\n{TWO}");
    assert!(problem(&both).contains("give each printer its queue instead"), "{}", problem(&both));
    assert!(problem("approve = \"sometimes\"\n").contains("approve"));
    assert!(problem("[[printer]]\nname = \"x\"\ncolour = 1\n").contains("unknown option \"printer.colour\""));
    assert!(problem("[[printer]]\nname = \"x\"\nhours = 6\n").contains("printer.hours"));
    assert!(problem("[[printer]]\nname = \"x\"\nqueue = \"~/jobs\"\n").contains("\"~\" means nothing"));
    assert!(problem("[[printer]]\nname = \"x\"\nqueue = \"\"\n").contains("printer.queue is empty"));
    let once = problem("hours = \"Mo 6-22\"\n[[printer]]\nname = \"x\"\n[[printer]]\nname = \"y\"\n");
    assert!(once.contains("\"Mo 6-22\" is not understood"), "{once}");
    assert!(problem("[[printer]]\nqueue = \"q\"\n").contains("\"\" cannot be the name of a printer"));
    let farm = "[[defaults.printer]]\nname = \"x\"\n";
    let problems = TestConfig::new(farm, &[("a.toml", CUBE)]).problems();
    assert!(problems.iter().any(|problem| problem.contains("printers in [defaults]")), "{problems:?}");
}
