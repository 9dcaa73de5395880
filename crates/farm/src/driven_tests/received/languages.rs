//! The language of what stands in folders.

use std::fs;

use language::{Language, say};

use crate::driven_tests::{HandDrivenFarm, QUICK};

#[test]
fn status_txt_is_in_the_language_of_the_settings_and_status_json_is_english() {
    let mut farm = HandDrivenFarm::closed(QUICK);
    let config = farm.root().join("config/nestd.toml");
    let text = fs::read_to_string(&config).unwrap();
    fs::write(&config, format!("language = \"de\"\n{text}")).unwrap();
    farm.start();
    farm.pass_until("the status is there", |farm| !farm.status_text().is_empty());
    let said = Language::German.within(|| [say!("nothing-waits"), say!("status-now", doing = say!("free-now"))]);
    assert!(said[0] != say!("nothing-waits"), "{}", said[0]);
    let text = farm.status_text();
    assert!(said.iter().all(|said| text.contains(said)), "{text}");
    assert_eq!(farm.status_json()["doing"], "free now");
}
