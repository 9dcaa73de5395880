//! `nestd man`: the manual pages. Each command's is made from its own description, with examples; `nestd.toml(5)` from the chapter of
//! settings.

use std::{fs, path::Path};

use anyhow::{Context, Result};
use build_file::format_count;
use clap::Command;
use clap_mangen::roff::{Roff, bold, roman};

use crate::{
    cli::{CommandExit, terminal::table::print_text},
    web::SETTINGS_CHAPTER,
};

/// Examples: the page, a command line, what it does.
const EXAMPLES: [(&str, &str, &str); 22] = [
    ("nestd", "nestd init /srv/nestd", "Write the configuration of a new farm."),
    ("nestd", "nestd machine new hp --model mjf-5200", "Add a machine, with what is known of its model."),
    ("nestd", "nestd status --watch", "See what waits, what is being nested, and what needs a person."),
    (
        "nestd-history",
        "nestd history --since 30d --format csv",
        "The builds of the last thirty days, for a spreadsheet.",
    ),
    ("nestd-costs", "nestd costs --order 4711", "What the builds of an order cost, and its share."),
    ("nestd-show", "nestd show bracket.stl", "All about a part, by the name of its file."),
    ("nestd-render", "nestd render b4 --view top -o b4.png", "Draw build 4 from above."),
    ("nestd-report", "nestd report b4 -o b4.html", "Write build 4 as one file to mail."),
    ("nestd-flush", "nestd flush hp", "Print what waits now, although the build is not full."),
    ("nestd-cancel", "nestd cancel 5=2", "Take two of the copies of part 5 out of the farm."),
    ("nestd-edit", "nestd edit 4711 --due 2026-12-24 --priority 80", "Change the date and the priority of an order."),
    ("nestd-move", "nestd move 'bracket*' --to hp2", "Move parts to another machine, by the names of their files."),
    ("nestd-reprint", "nestd reprint b4", "Print all copies of build 4 again."),
    ("nestd-outcome", "nestd outcome b4 complete --bad 5=1", "Build 4 is printed, and one copy of part 5 is bad."),
    (
        "nestd-printer",
        "nestd printer hp down --reason 'lamp broken'",
        "No build is sent to a printer until it is up again.",
    ),
    ("nestd-plan", "nestd plan hp", "The builds to come of a machine, and the dates at risk."),
    ("nestd-quote", "nestd quote hinge.stl=12 --machine hp --due fri", "Whether twelve more can be done by Friday."),
    ("nestd-withdraw", "nestd withdraw b4", "Take a build out of the queue that its printer has not taken."),
    ("nestd-token", "nestd token new shop --role order", "Make a token for a program that orders."),
    ("nestd-backup", "nestd backup /backup/nestd.db", "Copy the ledger while the farm runs."),
    ("nestd-nest", "nestd nest hinge.stl=12 --volume 340x340x600 --clearance 3 -o b.3mf", "Nest without a farm."),
    ("nestd-verify", "nestd verify b.3mf --clearance 3", "Prove a build file."),
];
/// What each command's end says, unless it says so itself.
const EXIT_STATUS: &str = "0 success, 1 the work failed, 2 wrong use or configuration.";

/// Writes the manual pages into a folder.
pub fn write_manual(command: Command, folder: &Path) -> Result<CommandExit> {
    fs::create_dir_all(folder).with_context(|| format!("making {}", folder.display()))?;
    let writing = || format!("writing into {}", folder.display());
    clap_mangen::generate_to(command, folder).with_context(writing)?;
    let mut pages = 1;
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let Some(page) = name.strip_suffix(".1").filter(|page| page.starts_with("nestd")) else { continue };
        let text = fs::read_to_string(&path).with_context(writing)?;
        fs::write(&path, with_status_and_examples(&text, page)).with_context(writing)?;
        pages += 1;
    }
    fs::write(folder.join("nestd.toml.5"), page_of_settings(SETTINGS_CHAPTER).render()).with_context(writing)?;
    let (shown, place) = (format_count(pages, "page", "pages"), folder.display());
    print_text(&format!("{shown} in {place}: man -l {}", folder.join("nestd.1").display()))?;
    Ok(CommandExit::Success)
}

/// A page with the sections that a manual has and a description of options has not.
fn with_status_and_examples(page: &str, name: &str) -> String {
    let mut more = Roff::new();
    if !page.contains("\n.SH EXTRA\n") {
        more.control("SH", ["EXIT STATUS"]).text([roman(EXIT_STATUS)]);
    }
    let examples: Vec<_> = EXAMPLES.iter().filter(|(page, ..)| *page == name).collect();
    if !examples.is_empty() {
        more.control("SH", ["EXAMPLES"]);
    }
    for (_, line, meaning) in examples {
        more.control("TP", []).text([bold(*line)]).text([roman(*meaning)]);
    }
    more.control("SH", ["SEE ALSO"])
        .text([roman("nestd(1), nestd.toml(5). The book: /usr/share/doc/nestd, and Help in the dashboard.")]);
    page.replace("\n.SH EXTRA\n", "\n.SH \"EXIT STATUS\"\n") + &more.to_roff()
}

/// The page of the farm file, made of the chapter of settings: headings, paragraphs, and an item for each option.
fn page_of_settings(chapter: &str) -> Roff {
    let mut page = Roff::new();
    page.control("TH", ["nestd.toml", "5", "", concat!("nestd ", env!("CARGO_PKG_VERSION")), ""]);
    page.control("SH", ["NAME"]).text([roman("nestd.toml - the configuration of a nestd farm")]);
    page.control("SH", ["DESCRIPTION"]);
    let mut is_new = true;
    for line in chapter.lines().filter(|line| !line.starts_with("# ") && !line.starts_with("Made of ")) {
        if let Some(heading) = line.strip_prefix("## ") {
            page.control("SH", [heading]);
        } else if let Some((option, about)) = line.strip_prefix("- `").and_then(|item| item.split_once('`')) {
            page.control("TP", []).text([bold(option)]).text([roman(plain(about.trim_start_matches([':', ' '])))]);
        } else if !line.is_empty() {
            // A paragraph may have several lines.
            if is_new {
                page.control("PP", []);
            }
            page.text([roman(plain(line))]);
        }
        is_new = line.is_empty();
    }
    page.control("SH", ["FILES"]).text([roman("/etc/nestd/nestd.toml, /etc/nestd/profiles/MACHINE.toml")]);
    page.control("SH", ["SEE ALSO"]).text([roman("nestd(1), nestd-check(1)")]);
    page
}

/// Markdown without its signs; a link is its text.
fn plain(markdown: &str) -> String {
    let mut text = String::new();
    let mut rest = markdown;
    while let Some((before, after)) = rest.split_once("](") {
        let (head, label) = before.rsplit_once('[').unwrap_or(("", before));
        text.push_str(head);
        text.push_str(label);
        rest = after.split_once(')').map_or("", |(_, rest)| rest);
    }
    (text + rest).replace(['`', '\\'], "")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_of_settings_has_an_item_for_each_option() {
        let options = SETTINGS_CHAPTER.lines().filter(|line| line.starts_with("- `")).count();
        let page = page_of_settings(SETTINGS_CHAPTER).render();
        assert!(options > 60 && page.matches("\n.TP\n").count() == options, "{options}");
        assert!(page.contains("scan_secs=10") && !page.contains('`') && !page.contains("]("), "{page}");
    }

    #[test]
    fn each_example_is_a_command_line_of_its_page() {
        for (page, line, _) in EXAMPLES {
            // What is quoted is one word.
            let words = line.split('\'').enumerate().flat_map(|(at, text)| match at % 2 {
                0 => text.split_whitespace().collect::<Vec<_>>(),
                _ => vec![text],
            });
            let parsed = crate::cli::command_line()
                .try_get_matches_from(words)
                .unwrap_or_else(|wrong| panic!("{line}: {wrong}"));
            let command = parsed.subcommand_name().unwrap().to_owned();
            assert!(page == "nestd" || page == format!("nestd-{command}"), "{line} stands in {page}");
        }
    }

    #[test]
    fn a_page_says_its_exit_status_once_and_its_examples() {
        let own = with_status_and_examples(".SH NAME\nnestd\n.SH EXTRA\nExit code 0 proved.\n", "nestd-verify");
        assert_eq!(own.matches("EXIT STATUS").count(), 1, "{own}");
        assert!(own.contains("nestd verify b.3mf") && !own.contains("EXTRA"), "{own}");
        let usual = with_status_and_examples(".SH NAME\nnestd\n", "nestd-scan");
        assert!(usual.contains("1 the work failed") && !usual.contains("EXAMPLES"), "{usual}");
    }

    #[test]
    fn markdown_becomes_plain_text() {
        assert_eq!(plain("see [Operators](operator.md#x) of `a\\<b>`, [c]"), "see Operators of a<b>, [c]");
    }
}
