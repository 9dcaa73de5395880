//! What the scripts of pages say, in the language of the page: a block of JSON, in which values stand in braces for the script to fill.

use language::say;
use maud::{Markup, PreEscaped, html};

/// The texts of a script: the name that it uses, and the text.
pub(crate) type ScriptTexts = fn() -> Vec<(&'static str, String)>;

/// What the script that keeps pages up to date says.
pub(crate) const LIVE: ScriptTexts = || {
    vec![
        ("lost", say!("script-lost", time = "{time}")),
        ("changed", say!("script-changed")),
        ("load_again", say!("script-load-again")),
    ]
};

/// What the script of files that are dropped says.
const DROP: ScriptTexts = || {
    vec![
        ("too_large", say!("script-too-large", name = "{name}", size = "{size}")),
        ("files", say!("count-files", count = "{count}")),
        ("sent_of", say!("script-sent-of", sent = "{sent}", all = "{all}")),
        ("sent", say!("script-sent")),
        ("answers", say!("script-answers", status = "{status}")),
        ("connection_lost", say!("script-connection-lost")),
        ("close", say!("close")),
        ("which_machine", say!("script-which-machine")),
        ("asking", say!("script-asking")),
        ("no_answer", say!("script-no-answer")),
        ("done", say!("script-done", time = "{time}")),
        ("no_date_known", say!("script-no-date-known")),
        ("soonest", say!("script-soonest")),
        ("today", say!("date-today")),
        ("tomorrow", say!("date-tomorrow")),
        ("day_and_clock", say!("date-clock", day = "{day}", clock = "{clock}")),
        ("adds", say!("script-adds", done = "{done}", height = "{height}")),
        ("one_late", say!("script-one-late")),
        ("several_late", say!("script-several-late", count = "{count}")),
    ]
};

/// What the script of a button that copies a text says.
const COPY: ScriptTexts = || vec![("copied", say!("script-copied"))];

/// What the 3D view says.
pub(crate) const VIEW: ScriptTexts = || {
    vec![
        ("no_script", say!("script-no-view-script")),
        ("no_view", say!("script-no-view", why = "{why}")),
        ("hint", say!("view-hint")),
        ("front", say!("script-front")),
        ("no_order", say!("bin-no-order")),
        ("no_date", language::say_word("state", "no date")),
        ("last_out", say!("script-last-out")),
        ("first_out", say!("script-first-out")),
        ("no_proved_order", say!("script-no-proved-order")),
        ("what_has_no_order", say!("script-what-has-no-order")),
        ("part_not_here", say!("script-part-not-here")),
        ("chosen_one", say!("script-chosen", what = "{what}", count = 1)),
        ("chosen", say!("script-chosen", what = "{what}", count = "{count}")),
        ("show_all", say!("script-show-all")),
        ("whole_view", say!("whole-view")),
        ("layer", say!("script-layer", height = "{height}", layer = "{layer}", layers = "{layers}")),
        ("of_order", say!("order-of", order = "{order}")),
        ("due", say!("due-on", due = "{due}")),
        ("copy_from_to", say!("script-copy-from-to", copy = "{copy}", low = "{low}", top = "{top}")),
        ("step", say!("script-step", step = "{step}")),
        ("simplified", say!("script-simplified")),
        ("missing_one", say!("script-missing", missing = "{count}", count = 1)),
        ("missing", say!("script-missing", missing = "{count}", count = "{all}")),
    ]
};

/// What an asset says that a page loads beside the script that keeps it up to date.
pub(crate) fn texts_of_script(script: &str) -> ScriptTexts {
    match script {
        "drop.js" => DROP,
        "copy.js" => COPY,
        "start.js" => VIEW,
        _ => Vec::new,
    }
}

/// The block of these texts.
pub(crate) fn script_texts(scripts: &[ScriptTexts]) -> Markup {
    let texts: serde_json::Map<String, serde_json::Value> =
        scripts.iter().flat_map(|texts| texts()).map(|(name, text)| (name.to_owned(), text.into())).collect();
    // No text ends the element.
    let block = serde_json::Value::Object(texts).to_string().replace('<', "\\u003c");
    html! { script #texts type="application/json" { (PreEscaped(block)) } }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_name_that_a_script_says_has_a_text() {
        let sources = [
            (include_str!("../assets/live.js"), LIVE),
            (include_str!("../assets/drop.js"), DROP),
            (include_str!("../assets/copy.js"), COPY),
            (include_str!("../assets/start.js"), VIEW),
            (include_str!("../view/view.js"), VIEW),
        ];
        for (source, texts) in sources {
            let known: Vec<&str> = texts().into_iter().map(|(name, _)| name).collect();
            let called = |mark: &str, end: char| -> Vec<String> {
                let pieces = source.split(mark).skip(1).filter_map(move |rest| rest.split(end).next());
                pieces.filter(|name| !name.is_empty()).map(str::to_owned).collect()
            };
            for name in called("text(\"", '"') {
                assert!(known.contains(&name.as_str()), "{name}");
            }
        }
    }
}
