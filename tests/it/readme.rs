//! The architecture names every room. What the documents link to, and the commands and options that they name, the library tests.

use std::{fs, path::Path};

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn every_room_has_its_place_in_the_architecture() {
    let text = fs::read_to_string(repository().join("ARCHITECTURE.md")).unwrap();
    for floor in ["src", "crates"] {
        for entry in fs::read_dir(repository().join(floor)).unwrap().map(Result::unwrap).filter(|e| e.path().is_dir()) {
            let room = format!("{floor}/{}/", entry.file_name().to_string_lossy());
            assert!(text.contains(&room), "{room} is missing");
        }
    }
}
