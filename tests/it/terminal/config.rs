//! The shipped configurations: the one for trying nestd out and the one for a server.

use std::{
    fs,
    path::{Path, PathBuf},
};

use glam::{DVec3, dvec3};
use settings::load_settings;

const MACHINES: [(&str, DVec3, f64); 4] = [
    ("fuse-1", dvec3(165.0, 165.0, 300.0), 2.0),
    ("mjf-5200", dvec3(356.0, 280.0, 356.0), 3.0),
    ("p396", dvec3(340.0, 340.0, 600.0), 3.0),
    ("paper-200", dvec3(200.0, 200.0, 200.0), 3.0),
];

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("config").join(name)
}

#[test]
fn the_shipped_machines_have_their_volumes_and_clearances() {
    let settings = load_settings(Some(&shipped("nestd.toml")), None).unwrap();
    let machines: Vec<_> =
        settings.profiles.values().map(|p| (p.name.as_str(), p.build_volume().size_mm, p.space.clearance_mm)).collect();
    assert_eq!(machines, MACHINES);
}

#[test]
fn the_try_out_is_in_a_farm_folder_of_the_working_directory() {
    let settings = load_settings(Some(&shipped("nestd.toml")), None).unwrap();
    let farm = std::env::current_dir().unwrap().join("farm");
    assert_eq!(settings.profiles["p396"].folders.inbox, farm.join("inbox/p396"));
    assert_eq!(settings.ledger.file().unwrap(), farm.join("state/nestd.db"));
}

#[test]
fn the_servers_farm_is_in_srv_and_its_state_in_var_lib() {
    let etc = tempfile::tempdir().unwrap();
    fs::copy(shipped("server/nestd.toml"), etc.path().join("nestd.toml")).unwrap();
    fs::create_dir(etc.path().join("profiles")).unwrap();
    for (name, ..) in MACHINES {
        let file = format!("profiles/{name}.toml");
        fs::copy(shipped(&file), etc.path().join(&file)).unwrap();
    }
    let settings = load_settings(Some(&etc.path().join("nestd.toml")), None).unwrap();
    assert_eq!(settings.profiles["fuse-1"].folders.queue, Path::new("/srv/nestd/queue/fuse-1"));
    assert_eq!(settings.ledger.file().unwrap(), Path::new("/var/lib/nestd/nestd.db"));
    assert_eq!(settings.profiles.len(), MACHINES.len());
}
