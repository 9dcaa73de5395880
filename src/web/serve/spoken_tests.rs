//! Tests of the language of pages: which one a browser gets, and that all that pages say comes from the catalogs.

use std::collections::BTreeSet;

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

/// The words of a text that no catalog said.
fn unsaid_words(text: &str) -> Vec<String> {
    let mut outside = String::new();
    let mut depth = 0_i32;
    for letter in text.chars() {
        depth += i32::from(letter == '⟦') - i32::from(letter == '⟧');
        outside.push(if depth == 0 && letter != '⟧' { letter } else { ' ' });
    }
    let words = outside.split(|letter: char| letter.is_whitespace() || ",;:()".contains(letter));
    words.filter(|word| word.chars().any(char::is_alphabetic)).map(|word| word.trim_matches('.').to_owned()).collect()
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
        "kB",
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
    ];
    let is_hash = word.len() == 64 && word.bytes().all(|letter| letter.is_ascii_hexdigit());
    let is_span = word.ends_with(['d', 'h', 'm', 's']) && word[..word.len() - 1].bytes().all(|b| b.is_ascii_digit());
    let is_name = word.contains(".stl") || word.contains(".3mf") || word.contains('@');
    DATA.contains(&word) || is_span || is_name || is_hash
}

/// A farm with all that makes pages speak: orders, due dates, a refused part, a paused machine, a failed print and alerts.
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
    let alerts: Vec<crate::farm::FarmAlert> = crate::farm::AlertKind::ALL
        .into_iter()
        .map(|kind| crate::farm::FarmAlert {
            kind,
            machine: "cube".to_owned(),
            detail: String::new(),
            since: jiff::Timestamp::now(),
        })
        .collect();
    let state_dir = dashboard.web.current_settings().state_dir.clone();
    std::fs::create_dir_all(&state_dir).unwrap();
    std::fs::write(state_dir.join("attention.json"), serde_json::to_string(&alerts).unwrap()).unwrap();
    dashboard
}

#[tokio::test]
async fn all_that_pages_say_comes_from_the_catalogs() {
    let mut faults = BTreeSet::new();
    for dashboard in [TestDashboard::new(|_| ()).await, with_a_build("bracket.stl").await, farm_in_trouble().await] {
        for page in PAGES.into_iter().filter(|page| *page != "/components").chain([
            "/orders/A-7",
            "/parts/2",
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
