//! Materials of the farm, and what is loaded in machines.

use super::*;

const NAMES: &str = "[materials]\nPA12 = [\"PA 12\", \"Nylon 12\", \"PA2200\"]\n\"PA12 GB\" = [\"PA 3200\"]\n";

#[test]
fn a_material_is_called_by_its_name_whatever_word_people_use() {
    let machine = format!("{CUBE}material = \"pa-2200\"\n");
    let settings = TestConfig::new(NAMES, &[("a.toml", &machine), ("b.toml", CUBE)]).load().unwrap();
    let loaded = |name: &str| settings.profiles[name].printing.material.clone();
    assert_eq!((loaded("a"), loaded("b")), ("PA12".to_owned(), String::new()));
    let materials = &settings.materials;
    for (word, name) in
        [("nylon_12", "PA12"), (" pa12gb ", "PA12 GB"), ("PA3200", "PA12 GB"), ("PA11", "PA11"), ("", "")]
    {
        assert_eq!(materials.name_of(word), name, "{word:?}");
    }
    assert!(materials.is_known("") && materials.is_known("PA 12") && !materials.is_known("PA11"));
    let unknown = materials.require_name("PA11").unwrap_err().to_string();
    assert!(unknown.contains("does not name 'PA11', only PA12, PA12 GB"), "{unknown}");
    assert!(Materials::default().is_known("PA11"), "where none is named, each word is one");
}

#[test]
fn a_word_for_two_materials_and_a_loaded_one_that_is_none_are_refused() {
    let problems = |farm: &str, machine: &str| {
        TestConfig::new(farm, &[("a.toml", &format!("{CUBE}material = \"{machine}\"\n"))]).problems()
    };
    let twice = problems("[materials]\nPA12 = [\"nylon\"]\nPA11 = [\"Nylon\"]\n", "PA12");
    assert!(twice.len() == 1 && twice[0].contains("means PA11 and PA12"), "{twice:?}");
    let nothing = problems("[materials]\nPA12 = [\" - \"]\n", "PA12");
    assert!(nothing.len() == 1 && nothing[0].contains("is no word for a material"), "{nothing:?}");
    let unknown = problems(NAMES, "PA11");
    let said = "profiles/a.toml:2: material = \"PA11\" is not in [materials]; name one of PA12, PA12 GB";
    assert!(unknown.len() == 1 && unknown[0].contains(said), "{unknown:?}");
}
