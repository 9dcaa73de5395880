//! The chapters of the book, and where links between them lead.

use std::path::Path;

/// A file of the book.
#[derive(Debug)]
pub(super) struct Chapter {
    /// The last step of its address.
    pub(super) name: &'static str,
    /// Its file in the repository.
    pub(super) file: &'static str,
    /// What stands in it, Markdown.
    pub(super) text: &'static str,
}

/// A chapter by its name and its file.
macro_rules! chapter {
    ($name:literal, $file:literal) => {
        Chapter { name: $name, file: $file, text: include_str!(concat!("../../../", $file)) }
    };
}

/// All chapters, in the order of the contents.
pub(super) const CHAPTERS: [Chapter; 14] = [
    chapter!("technician", "docs/technician.md"),
    chapter!("operator", "docs/operator.md"),
    chapter!("planner", "docs/planner.md"),
    chapter!("integrator", "docs/integrator.md"),
    chapter!("install", "systemd/README.md"),
    chapter!("administrator", "docs/administrator.md"),
    chapter!("servers", "docs/servers.md"),
    chapter!("monitoring", "docs/monitoring.md"),
    chapter!("symptoms", "docs/symptoms.md"),
    chapter!("commands", "docs/commands.md"),
    Chapter { name: "settings", file: "docs/settings.md", text: super::SETTINGS_CHAPTER },
    chapter!("measurements", "docs/measurements.md"),
    chapter!("benchmark", "docs/benchmark.md"),
    chapter!("reliability", "docs/reliability.md"),
];

/// The address of a chapter.
pub(super) fn chapter_address(name: &str) -> String {
    format!("/help/{name}")
}

/// The file that a link in a file means, relative to the repository.
pub(super) fn linked_file(from: &str, link: &str) -> String {
    let mut steps: Vec<&str> = Vec::new();
    let folder = Path::new(from).parent().and_then(Path::to_str).unwrap_or_default();
    for step in folder.split('/').chain(link.split('/')) {
        match step {
            "" | "." => {}
            ".." => drop(steps.pop()),
            step => steps.push(step),
        }
    }
    steps.join("/")
}

/// Where a link of a chapter leads below `/help`; `None` = to a file that is not in the binary.
pub(super) fn link_address(from: &str, link: &str) -> Option<String> {
    if link.starts_with("https://") || link.starts_with("http://") || link.starts_with('#') {
        return Some(link.to_owned());
    }
    let (path, anchor) = link.split_once('#').map_or((link, String::new()), |(path, at)| (path, format!("#{at}")));
    let file = linked_file(from, path);
    let chapter = CHAPTERS.iter().find(|chapter| chapter.file == file)?;
    Some(chapter_address(chapter.name) + &anchor)
}
