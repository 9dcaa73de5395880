//! Tests of the language of pages: which one a browser gets, and that all that pages say comes from the catalogs.

use std::collections::BTreeSet;

use language::unsaid_words;
use ledger::RefusalCause;

use super::*;

impl TestDashboard {
    /// A page, for a browser that asks for these languages.
    async fn get_in(&self, languages: &str, path: &str) -> TestResponse {
        let request = Request::get(path).header("host", "localhost:7878").header("accept-language", languages);
        self.send(request.body(Body::empty()).unwrap()).await
    }
}

#[tokio::test]
async fn a_page_is_in_the_language_of_its_browser_and_what_programs_read_is_english() {
    let dashboard = with_a_build("bracket.stl").await;
    for (asked, tag) in
        [("de-AT,de;q=0.9,en;q=0.5", "de"), ("nl,fr;q=0.4", "fr"), ("ja", "ja"), ("nl", "en"), ("en,de;q=0.9", "en")]
    {
        for page in ["/", "/builds/1/pick", "/told/none"] {
            let text = dashboard.get_in(asked, page).await.text;
            assert!(text.contains(&format!("<html lang=\"{tag}\">")), "{asked} {page}");
        }
    }
    assert!(dashboard.get_in("art-x-marked", "/").await.text.contains("<h1>⟦Farm⟧"));
    for path in ["/api/v1/status", "/api/v1/plan", "/history.csv", "/month.json", "/metrics", "/api/v1/parts/99"] {
        let text = dashboard.get_in("art-x-marked", path).await.text;
        assert!(!text.contains('⟦'), "{path}: {text}");
    }
    let request = Request::get("/").header("host", "localhost").header("accept-encoding", "gzip");
    let answer = build_router(dashboard.web.clone()).oneshot(request.body(Body::empty()).unwrap()).await.unwrap();
    let vary: Vec<_> = answer.headers().get_all("vary").iter().map(|value| value.to_str().unwrap()).collect();
    assert_eq!(vary, ["accept-encoding", "accept-language"]);
}

/// Elements whose content is no text of ours: commands, scripts, and what is marked as such.
const NOT_SAID: [&str; 4] = ["<code", "<script", "<style", "<svg"];

/// The spoken attributes of a page and, as one, all its text, without what is marked as not to be translated. A text of the catalogs may
/// have elements in it.
fn texts_of(page: &str) -> Vec<String> {
    let (mut texts, mut skipped, mut all) = (Vec::new(), Vec::new(), String::new());
    for piece in page.split('<').skip(1) {
        let (tag, text) = piece.split_once('>').unwrap_or((piece, ""));
        let name = tag.split([' ', '\n', '/']).next().unwrap_or_default();
        match tag.strip_prefix('/') {
            Some(closed) => {
                if skipped.last().is_some_and(|open| open == closed) {
                    skipped.pop();
                }
            }
            None => {
                let is_skipped = NOT_SAID.contains(&format!("<{name}").as_str())
                    || tag.contains("translate=\"no\"")
                    || tag.contains("lang=\"en\"") && name != "html";
                // Of what is skipped, elements of the same name are counted.
                if is_skipped || skipped.last().is_some_and(|open: &String| open == name) {
                    skipped.push(name.to_owned());
                }
                if skipped.is_empty() {
                    for attribute in ["aria-label=", "title=", "alt=", "placeholder=", "data-of="] {
                        let said = tag.split(&format!(" {attribute}\"")).nth(1).and_then(|rest| rest.split('"').next());
                        texts.extend(said.map(str::to_owned));
                    }
                }
            }
        }
        if skipped.is_empty() {
            all += text;
            all.push(' ');
        }
    }
    texts.push(all);
    let plain =
        |text: &String| text.replace("&quot;", "\"").replace("&amp;", "&").replace("&lt;", "<").replace("&gt;", ">");
    texts.iter().map(plain).collect()
}

/// What is no text of ours: names, units, formats, and durations such as `3h`.
fn is_data(word: &str) -> bool {
    const DATA: &[&str] = &[
        "nestd",
        "cube",
        "bracket.stl",
        "plate.stl",
        "Brandt",
        "A-7",
        "ann",
        "ann@vm",
        "host",
        "mm",
        "mm³",
        "cm3",
        "EUR",
        "kB",
        "kg",
        "h",
        "s",
        "l",
        "UTC",
        "b1182",
        "P-17",
        "none",
        "paper-200",
        "x",
        "y",
        "bracket",
        "A4",
        "US",
        "Letter",
        "Avery",
        "CSV",
        "JSON",
        "STL",
    ];
    let is_hash = word.len() == 64 && word.bytes().all(|letter| letter.is_ascii_hexdigit());
    let is_span = word.ends_with(['d', 'h', 'm', 's']) && word[..word.len() - 1].bytes().all(|b| b.is_ascii_digit());
    let is_name = [".stl", ".3mf", ".csv", ".toml", "bracketx4", "max_triangles", "@", "/srv/"]
        .iter()
        .any(|end| word.contains(end));
    DATA.contains(&word) || is_span || is_name || is_hash
}

/// Details of alerts, as the farm writes them; the tests of the farm see that it does.
const DETAILS: [(&str, &str); 12] = [
    ("refused", "2 files in /srv/error/cube"),
    (
        "incomplete",
        "bracket.stl waits, because order.csv, which is hidden, so nestd does not read it: take away the dot at the start \
                    of its name, or delete it; and 3 more",
    ),
    ("question", "part 2 (plate.stl): it is 0.40 x 0.30 x 0.20 mm, smaller than 1 mm"),
    ("release-due", "build 7: 3 copies, 10.5 of 20 mm high, 12 % dense, about 5 h of printing"),
    ("build-failed", "build 7 gave up after 3 attempts: nestd stopped each time"),
    ("print-failed", "build 7; build 9; and 2 more"),
    ("file-damaged", "part 2 (plate.stl), part 3 (bracket.stl) and 1 more"),
    ("machine-gone", "1 part and 2 builds in work, and 1 line ordered by request"),
    ("foreign-claims", "3 in its .claimed folder"),
    ("stray", "plate.stl and 2 more in /srv/inbox"),
    ("hot-folder-away", "the hot folder /srv/inbox/cube is unavailable: it is not there"),
    ("queue-away", "the queue folder /srv/queue/cube is unavailable: Permission denied (os error 13)"),
];

/// Reasons of refusals, as parts have them.
const REASONS: [(RefusalCause, &str); 6] = [
    (
        RefusalCause::Format,
        "plate.stl: is not valid STL: only 3 of 12 triangles are in the file. Export it again from the CAD program, as \
                            binary STL, 3MF, OBJ or PLY.",
    ),
    (
        RefusalCause::NotClosed,
        "plate.stl: the mesh is not closed (2 open edges, 1 edge of more than two triangles), so it is not known what \
                               is inside. It is not mended, because a hole 12.3 mm wide is too large to know what was there. Repair it, or set \
                               mesh_errors = \"warn\" in the machine cube.",
    ),
    (
        RefusalCause::Mendable,
        "plate.stl: the mesh is not closed (2 open edges), so it is not known what is inside. It can be mended: 2 holes of at most 1.20 mm \
                             closed, 5 triangles added, 1 triangle turned, volume 0.4794 -> 0.4800 cm³, at most 0.30 mm off the surface before. \
                             `nestd mend 7` or the button on its page has it mended and printed.",
    ),
    (
        RefusalCause::Limit,
        "plate.stl: it has too many triangles; at most 5 are allowed (limits.max_triangles). Make it smaller, or drop it in \
                           several files; or raise limits.max_triangles in the configuration, reload nestd and drop the file again.",
    ),
    (
        RefusalCause::Ticket,
        "the ticket plate.toml cannot be read: copies = 0; it must be 1 to 10000. It is not certain what is asked with it, so it is not \
                            printed: mend the ticket and drop both again.",
    ),
    (
        RefusalCause::Duplicate,
        "It is the same file as part 2, and this machine takes no file twice. Where more copies are meant, set \
                               duplicates = \"warn\" in the profile cube, reload nestd and take it back.",
    ),
];

/// A farm with all that makes pages speak: orders, due dates, refused parts, parts that wait for an answer, a build that failed, a failed
/// print and alerts with details.
async fn farm_in_trouble() -> TestDashboard {
    let dashboard = with_a_build_due("bracket.stl", Some("2026-01-01T00:00:00Z".parse().unwrap())).await;
    let asked = fixtures::asked(fixtures::new_part("b", 3), |terms| {
        terms.due_at = Some("2026-01-01T00:00:00Z".parse().unwrap());
        "A-7".clone_into(&mut terms.order_name);
        "Brandt".clone_into(&mut terms.customer);
    });
    let part = ledger::NewPartRow { name: "plate.stl".to_owned(), machine: "cube".to_owned(), ..asked };
    let id = dashboard.ledger.record_claim(&part).await.unwrap().id;
    dashboard.ledger.accept_solids(id, &[fixtures::solid(0, 3)]).await.unwrap();
    for (at, (cause, reason)) in REASONS.into_iter().enumerate() {
        let part = ledger::NewPartRow {
            name: "plate.stl".to_owned(),
            machine: "cube".to_owned(),
            ..fixtures::new_part(&format!("r{at}"), 1)
        };
        let id = dashboard.ledger.record_claim(&part).await.unwrap().id;
        dashboard.ledger.refuse_claim(id, cause, reason).await.unwrap();
    }
    add_doubts_and_failures(&dashboard).await;
    let alerts: Vec<farm::FarmAlert> = farm::AlertKind::ALL
        .into_iter()
        .map(|kind| farm::FarmAlert {
            node: String::new(),
            kind,
            machine: "cube".to_owned(),
            detail: DETAILS.iter().find(|(of, _)| *of == word_of(kind)).map_or("", |(_, detail)| detail).to_owned(),
            since: jiff::Timestamp::now(),
        })
        .collect();
    let state_dir = dashboard.web.current_settings().state_dir.clone();
    std::fs::create_dir_all(&state_dir).unwrap();
    std::fs::write(state_dir.join("attention.json"), serde_json::to_string(&alerts).unwrap()).unwrap();
    dashboard
}

/// The word of a kind of alert.
fn word_of(kind: farm::AlertKind) -> String {
    serde_json::to_value(kind).unwrap().as_str().unwrap().to_owned()
}

/// A part with warnings and questions, and a build that could not be made.
async fn add_doubts_and_failures(dashboard: &TestDashboard) {
    let warnings = [
        "How many copies? Taken as 1 copy, because its name says \"bracketx4\", which is no clear number of copies from 1 to 10000. A ticket \
         with `copies = N` says it.",
        "It was taken without its order list: bracket.stl stands in none of the 3 rows of order.csv.",
        "The mesh is not closed: 1 open edge.",
        "The mesh was mended, as its ticket allows: 1 triangle left out, 2 corners joined, volume 12.30 -> 12.31 cm³, at most 0.02 mm off the surface before.",
    ];
    let warnings = warnings.map(str::to_owned).to_vec();
    let part = ledger::NewPartRow {
        name: "bracket.stl".to_owned(),
        machine: "cube".to_owned(),
        warnings,
        ..fixtures::new_part("w", 2)
    };
    let id = dashboard.ledger.record_claim(&part).await.unwrap().id;
    let question =
        "it is 0.40 x 0.30 x 0.20 mm, smaller than 1 mm; it may be plate.stl (part 2) in another format".to_owned();
    let facts = ledger::SolidFacts { question, ..fixtures::solid(0, 2) };
    dashboard.ledger.accept_solids(id, &[facts]).await.unwrap();
    let other =
        ledger::NewPartRow { name: "plate.stl".to_owned(), machine: "cube".to_owned(), ..fixtures::new_part("f", 1) };
    let id = dashboard.ledger.record_claim(&other).await.unwrap().id;
    dashboard.ledger.accept_solids(id, &[fixtures::solid(0, 1)]).await.unwrap();
    let build = dashboard.ledger.open_build("cube").await.unwrap().id;
    dashboard.ledger.begin_nesting(build, "flush", &[(id, 0)]).await.unwrap();
    dashboard.ledger.begin_attempt(build).await.unwrap();
    dashboard.ledger.fail_build(build, "gave up after 3 attempts: nestd stopped each time").await.unwrap();
}

#[tokio::test]
async fn all_that_pages_say_comes_from_the_catalogs() {
    let mut faults = BTreeSet::new();
    for dashboard in [TestDashboard::new(|_| ()).await, with_a_build("bracket.stl").await, farm_in_trouble().await] {
        for page in PAGES.into_iter().filter(|page| *page != "/components").chain([
            "/orders/A-7",
            "/parts/2",
            "/parts/3",
            "/parts/4",
            "/parts/5",
            "/parts/6",
            "/parts/7",
            "/parts/8",
            "/builds/2",
            "/parts?state=refused",
            "/parts?state=waiting",
            "/nothing",
            "/history?sort=height",
            "/builds/x",
        ]) {
            let asked = dashboard.get_in("art-x-marked", page).await;
            assert!(!asked.text.contains("{$"), "{page}: a value is missing");
            for text in texts_of(&asked.text) {
                // What is searched for is said as it was written.
                let is_told = |word: &String| is_data(word) || page.ends_with(&format!("q={word}"));
                let unsaid: Vec<String> = unsaid_words(&text).into_iter().filter(|word| !is_told(word)).collect();
                faults.extend(unsaid.into_iter().map(|word| format!("{page}: {word}")));
            }
        }
    }
    let faults: Vec<String> = faults.into_iter().collect();
    assert!(faults.is_empty(), "no catalog says: {}", faults.join("\n"));
}
