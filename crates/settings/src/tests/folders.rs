//! Folders of machines must not meet.

use super::*;

#[test]
fn two_machines_never_share_a_folder() {
    let machine = format!("{CUBE}[folders]\ninbox = \"/in\"\n");
    let problems = TestConfig::new("", &[("a.toml", &machine), ("b.toml", &machine)]).problems();
    let expected = "profiles/b.toml:3: the inbox of b (/in) is also the inbox of a; give each a folder of its own";
    assert_eq!(problems.len(), 1, "{problems:?}");
    assert!(problems[0].starts_with(expected), "{problems:?}");
}

#[test]
fn a_folder_that_is_named_is_blamed_and_not_one_that_follows_from_a_name() {
    let named = format!("{CUBE}[folders]\nqueue = \"/farm/queue/b\"\n");
    let config = TestConfig::new("root = \"/farm\"\n", &[("a.toml", &named), ("b.toml", CUBE)]);
    let expected = "profiles/a.toml:3: the queue folder of b (/farm/queue/b) is also the queue folder of a";
    assert!(config.problems()[0].starts_with(expected), "{:?}", config.problems());
    let printers =
        format!("{CUBE}[[printer]]\nname = \"left\"\n[[printer]]\nname = \"right\"\nqueue = \"/farm/queue/b\"\n");
    for (farm, other) in
        [("root = \"/farm\"\n", "b.toml"), ("root = \"/farm\"\n[folders]\nqueue = \"queue\"\n", "b.toml")]
    {
        let problems = TestConfig::new(farm, &[("a.toml", &printers), (other, CUBE)]).problems();
        assert!(
            problems[0].starts_with("profiles/a.toml:6: the queue folder of b (/farm/queue/b) is also"),
            "{problems:?}"
        );
    }
    let same = format!("{CUBE}[[printer]]\nname = \"left\"\n[[printer]]\nname = \"b\"\n");
    let problems = TestConfig::new("", &[("a.toml", &same), ("b.toml", CUBE)]).problems();
    assert!(problems.iter().any(|one| one.starts_with("profiles/a.toml:5: the name b of a printer")), "{problems:?}");
}

#[test]
fn no_folder_lies_inside_another() {
    let farm = "root = \"/farm\"\n[folders]\nerror = \"inbox/a/refused\"\n";
    let problems = TestConfig::new(farm, &[("a.toml", CUBE)]).problems();
    assert_eq!(problems.len(), 1, "{problems:?}");
    assert!(
        problems[0]
            .starts_with("nestd.toml:3: the error folder of a (/farm/inbox/a/refused/a) lies inside the inbox of a"),
        "{problems:?}"
    );
    let farm = "root = \"/farm\"\n[folders]\nstate = \"queue/a\"\n";
    let problems = TestConfig::new(farm, &[("a.toml", CUBE)]).problems();
    assert!(
        problems[0].starts_with("nestd.toml:3: the state directory (/farm/queue/a) is also the queue folder of a"),
        "{problems:?}"
    );
}

#[test]
fn two_machines_that_share_a_folder_through_a_link_are_refused() {
    let link = std::os::unix::fs::symlink::<PathBuf, PathBuf>;
    for (kind, name) in [("inbox", "the inbox"), ("queue", "the queue folder")] {
        let config = TestConfig::new("", &[("a.toml", CUBE), ("b.toml", CUBE)]);
        fs::write(config.file("nestd.toml"), format!("root = {:?}\n", config.file("farm"))).unwrap();
        config.load().unwrap();
        fs::create_dir_all(config.file("farm").join(kind).join("a")).unwrap();
        link("a".into(), config.file("farm").join(kind).join("b")).unwrap();
        let problems = config.problems();
        let also = format!("{name} of b (farm/{kind}/a) is also {name} of a, through a link or a mount");
        assert!(problems.len() == 1 && problems[0].contains(&also), "{problems:?}");
        // What does not exist yet lies behind a link above it.
        fs::remove_file(config.file("farm").join(kind).join("b")).unwrap();
        link(config.file("farm").join(kind).join("a"), config.file("farm/other")).unwrap();
        fs::write(
            config.file("profiles/b.toml"),
            format!("{CUBE}[folders]\n{kind} = {:?}\n", config.file("farm/other/deep")),
        )
        .unwrap();
        let problems = config.problems();
        assert!(problems[0].contains("lies inside") && problems[0].contains("through a link"), "{problems:?}");
    }
}
