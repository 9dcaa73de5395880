//! The chapter of settings is made of the shipped file, whose options and defaults are compared with the code.

use std::{fs, path::Path};

use super::{keys, shipped};
use crate::{
    machine::{
        printer::PrinterInputs,
        profile_inputs::{ProfileFolders, ProfileInputs},
    },
    service::inputs::FarmInputs,
};

/// With this variable the test writes the chapter.
const WRITE: &str = "NESTD_WRITE_BOOK";
const FILE: &str = "docs/settings.md";
const HEAD: &str = "\
# Settings

Made of `config/nestd.toml`: `NESTD_WRITE_BOOK=1 cargo test --lib chapter_of_settings` writes this chapter anew.
Each option is shown with its default.

## Farm

";
const MACHINE: &str = "
## A machine's file

Each file in `profiles/` is a machine. It may give every option of `[defaults]`, at its top level or under `[trigger]`, `[delivery]`, `[costs]` and `[nest]`,
and these:

- `volume_mm`: the printable box, as in `[200, 200, 200]`; the only option without a default
- `[folders]` with `inbox`, `queue`, `error` and `archive`: exact folders instead of those below the farm's
- `[[printer]]` with `name`, `queue`, `hours` and `days_off`, once for each of several printers ([Operators](operator.md#several-printers-behind-one-hot-folder))
";

/// The chapter, made of the farm file. A comment stands above or behind its option, or above its section; the first is about the file.
fn chapter_of(farm: &str) -> String {
    let mut chapter = HEAD.to_owned();
    let mut above: Vec<&str> = Vec::new();
    for line in farm.lines().skip_while(|line| !line.is_empty()) {
        let trimmed = line.trim();
        if let Some(comment) = line.strip_prefix("# ") {
            above.push(comment);
        } else if line.starts_with('[') {
            let about = if above.is_empty() { String::new() } else { format!("{}\n\n", escaped(&above)) };
            above.clear();
            chapter.push_str(&format!("\n## {line}\n\n{about}"));
        } else if let Some(comment) = trimmed.strip_prefix("# ") {
            chapter.truncate(chapter.trim_end().len());
            chapter.push_str(&format!(" {}\n", escaped(&[comment])));
        } else if !trimmed.is_empty() {
            let (option, comment) = line.split_once(" # ").unwrap_or((line, ""));
            let (name, value) = option.split_once(" = ").unwrap_or_else(|| panic!("{line}"));
            above.extend(Some(comment.trim()).filter(|comment| !comment.is_empty()));
            chapter.push_str(&format!("- `{}={}`: {}\n", name.trim(), value.trim(), escaped(&above)));
            above.clear();
        }
    }
    chapter + MACHINE
}

fn escaped(lines: &[&str]) -> String {
    lines.join(" ").replace('<', "\\<").replace('*', "\\*")
}

#[test]
fn the_chapter_of_settings_is_made_of_the_shipped_file_and_names_every_option() {
    let chapter = chapter_of(&fs::read_to_string(shipped("nestd.toml")).unwrap());
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(FILE);
    if std::env::var_os(WRITE).is_some() {
        fs::write(&file, &chapter).unwrap();
    }
    assert_eq!(fs::read_to_string(file).unwrap(), chapter, "{WRITE}=1 writes it anew");
    for path in keys(&toml::Table::try_from(FarmInputs::default()).unwrap(), "") {
        let (section, name) = path.rsplit_once('.').unwrap_or(("", &path));
        let section = if section.is_empty() { "## Farm\n".to_owned() } else { format!("## [{section}]\n") };
        let options = chapter.split(&section).nth(1).unwrap_or_else(|| panic!("{section}")).split("\n## ").next();
        assert!(options.is_some_and(|options| options.contains(&format!("- `{name}="))), "{path} is missing");
    }
    let path = || Some("x".into());
    let folders = ProfileFolders { inbox: path(), queue: path(), error: path(), archive: path() };
    let printer = PrinterInputs {
        name: "x".to_owned(),
        queue: path(),
        hours: Some("always".to_owned()),
        days_off: Some(Vec::new()),
    };
    let own = [toml::Table::try_from(folders), toml::Table::try_from(printer)].map(|table| keys(&table.unwrap(), ""));
    for name in own.concat().iter().map(String::as_str).chain(["volume_mm"]) {
        assert!(MACHINE.contains(&format!("`{name}`")), "{name} of a machine's file is missing");
    }
    assert!(ProfileInputs::default().space.volume_mm.is_none(), "volume_mm has no default");
}
