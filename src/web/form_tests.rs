//! Every form of every page, sent twice as browsers send it: a double click, a reload, back and once more.

use ledger::{BuildId, BuildState, Ledger};

use super::*;

/// A form of a page with what a browser sends of it if nobody changes anything.
#[derive(Debug, Clone)]
struct PageForm {
    action: String,
    fields: Vec<(String, String)>,
}

impl PageForm {
    fn body(&self) -> String {
        serde_urlencoded::to_string(&self.fields).unwrap()
    }

    fn says(&self, name: &str, value: &str) -> bool {
        self.fields.iter().any(|(own, said)| own == name && said == value)
    }

    fn set(mut self, name: &str, value: &str) -> Self {
        self.fields.iter_mut().filter(|(own, _)| own == name).for_each(|(_, said)| said.replace_range(.., value));
        self
    }
}

/// The value of an attribute of the tag that a text begins with.
fn attribute(tag: &str, name: &str) -> Option<String> {
    let tag = tag.split('>').next().unwrap();
    let value = tag.split(&format!(" {name}=\"")).nth(1)?.split('"').next().unwrap();
    Some(value.replace("&quot;", "\"").replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&"))
}

/// The forms of a page that change something, but for those with files; a button with a value is a form of its own.
fn forms_of(page: &str) -> Vec<PageForm> {
    let mut forms = Vec::new();
    for form in page.split("<form ").skip(1).map(|rest| rest.split("</form>").next().unwrap()) {
        let tag = format!(" {form}");
        if attribute(&tag, "method").as_deref() != Some("post") || attribute(&tag, "enctype").is_some() {
            continue;
        }
        let (mut fields, mut buttons) = (Vec::new(), Vec::new());
        for tag in form.split('<').skip(1) {
            let named = attribute(tag, "name").map(|name| (name, attribute(tag, "value").unwrap_or_default()));
            match (named, tag.split([' ', '>']).next().unwrap()) {
                (Some(button), "button") => buttons.push(button),
                (Some(field), "input") if attribute(tag, "type").as_deref() != Some("checkbox") => fields.push(field),
                (Some((name, _)), "select") => fields.push((name, String::new())),
                (None, "option") if fields.last().is_some_and(|(_, value)| value.is_empty()) => {
                    fields.last_mut().unwrap().1 = attribute(tag, "value").unwrap_or_default();
                }
                _ => {}
            }
        }
        let action = attribute(&tag, "action").unwrap();
        let form = PageForm { action, fields };
        let with = |button: &(String, String)| PageForm {
            fields: form.fields.iter().cloned().chain([button.clone()]).collect(),
            ..form.clone()
        };
        forms.extend(buttons.iter().map(with));
        if buttons.is_empty() {
            forms.push(form);
        }
    }
    forms
}

impl TestDashboard {
    async fn press(&self, form: &PageForm) -> TestResponse {
        let request = Request::post(&form.action).header("sec-fetch-site", "same-origin");
        self.send_form(request, &form.body()).await
    }

    /// A form of a page.
    async fn form(&self, page: &str, is_meant: impl Fn(&PageForm) -> bool) -> PageForm {
        let text = self.get(page).await.text;
        forms_of(&text).into_iter().find(is_meant).unwrap_or_else(|| panic!("no such form: {text}"))
    }

    /// The newest event, mark and command: whatever a form does makes a newer one.
    async fn done_so_far(&self) -> (String, usize) {
        let picked = self.ledger.last_pick_id().await.unwrap();
        let events = format!("{:?} {picked:?}", self.ledger.last_event_id().await.unwrap());
        let mut commands = 0;
        while self.ledger.find_command(ledger::CommandId(commands as i64 + 1)).await.unwrap().is_some() {
            commands += 1;
        }
        (events, commands)
    }
}

/// Answers commands, as a daemon does.
fn answer_all(ledger: &Ledger) -> tokio::task::JoinHandle<()> {
    let ledger = ledger.clone();
    tokio::spawn(async move {
        loop {
            for command in ledger.pending_commands().await.unwrap() {
                ledger.answer_command(command.id, true, "it is done").await.unwrap();
            }
            tokio::time::sleep(std::time::Duration::from_millis(5)).await;
        }
    })
}

#[tokio::test]
async fn every_form_of_every_page_does_once_what_is_sent_twice() {
    // Who signs in twice is signed in twice.
    let is_form_page = |page: &&str| *page != "/sign-in";
    let pages: Vec<&str> = PAGES.into_iter().filter(is_form_page).chain(["/parts/2", "/orders/kit"]).collect();
    let prepared = async || {
        let dashboard = with_a_build("bracket.stl").await;
        let part = ledger::NewPartRow {
            machine: "cube".to_owned(),
            ..fixtures::asked(fixtures::new_part("b", 2), |terms| terms.order_name = "kit".to_owned())
        };
        let id = dashboard.ledger.record_claim(&part).await.unwrap().id;
        dashboard.ledger.accept_solids(id, &[fixtures::solid(0, 2)]).await.unwrap();
        dashboard.printer_takes_it().await;
        dashboard
    };
    let mut tried = std::collections::BTreeSet::new();
    let first = prepared().await;
    for page in pages {
        for at in 0..forms_of(&first.get(page).await.text).len() {
            let dashboard = prepared().await;
            let daemon = answer_all(&dashboard.ledger);
            let form = forms_of(&dashboard.get(page).await.text).remove(at);
            // A form in which nothing is filled in says so, and changes nothing.
            let form = form.set("priority", "90").set("copies", "2").set("name", "Ann").set("customer", "Ann");
            let once = dashboard.press(&form).await;
            assert_eq!(once.status, StatusCode::SEE_OTHER, "{page} {form:?}: {}", once.text);
            let done = dashboard.done_so_far().await;
            let twice = dashboard.press(&form).await;
            assert_eq!((twice.status, &twice.location), (StatusCode::SEE_OTHER, &once.location), "{page} {form:?}");
            assert_eq!(dashboard.done_so_far().await, done, "{page} {form:?} is carried out twice");
            assert_eq!(dashboard.get(&once.location).await.status, StatusCode::OK, "{page} {form:?} leads nowhere");
            tried.insert(form.action.clone());
            daemon.abort();
        }
    }
    let tried: Vec<&str> = tried.iter().map(String::as_str).collect();
    for path in
        ["/commands", "/name", "/builds/1/told", "/builds/1/break-out", "/builds/1/break-out/all", "/parts/1/reprint"]
    {
        assert!(tried.contains(&path), "{path} is on none of the pages: {tried:?}");
    }
    for path in
        ["/parts/2/edit", "/orders/kit/edit", "/orders/kit/cancel", "/orders/kit/close", "/orders/bracket.stl/reprint"]
    {
        assert!(tried.contains(&path), "{path} is on none of the pages: {tried:?}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn two_clicks_at_the_same_time_issue_one_build_and_lead_to_the_same_page() {
    let dashboard = with_a_build("bracket.stl").await;
    dashboard.printer_takes_it().await;
    let form = dashboard.form("/builds/1", |form| form.says("act", "requeue")).await;
    let (one, two) = tokio::join!(dashboard.press(&form), dashboard.press(&form));
    assert_eq!((one.status, two.status, &one.location), (StatusCode::SEE_OTHER, StatusCode::SEE_OTHER, &two.location));
    assert!(one.text.contains("Build 1 is issued once more as build 2."), "{}", one.text);
    assert!(dashboard.ledger.find_build(BuildId(3)).await.unwrap().is_none(), "one build is issued");
    let another = dashboard.form("/builds/1", |form| form.says("act", "requeue")).await;
    assert_ne!(another.body(), form.body(), "a page that is loaded again has forms of its own");
}

#[tokio::test]
async fn a_form_that_was_sent_before_is_told_from_one_with_something_else_in_it() {
    let dashboard = with_a_build("bracket.stl").await;
    dashboard.printer_takes_it().await;
    let is_outcome = |form: &PageForm| form.says("act", "complete") || form.says("act", "interrupted");
    let form = dashboard.form("/builds/1", is_outcome).await.set("act", "complete");
    // What was refused has used up no key: it is mended, and sent once more.
    let wrong = form.clone().set("bad_1", "seven");
    assert_eq!(dashboard.press(&wrong).await.status, StatusCode::BAD_REQUEST);
    let refused = dashboard.press(&form.clone().set("bad_1", "3")).await;
    assert!(refused.status == StatusCode::SEE_OTHER && refused.text.contains("Refused"), "{}", refused.text);
    let told = dashboard.press(&form.clone().set("bad_1", "1")).await;
    assert!(told.text.contains("Build 1 is complete."), "{}", told.text);
    let other = dashboard.press(&form.clone().set("bad_1", "2")).await;
    assert_eq!(other.status, StatusCode::UNPROCESSABLE_ENTITY);
    assert!(other.text.contains("load its page again"), "{}", other.text);
    assert_eq!(dashboard.ledger.outcomes_of_build(BuildId(1)).await.unwrap().len(), 1);
    let again = dashboard.get(&format!("{}?again=true", told.location)).await.text;
    assert!(again.contains("not carried out a second time") && again.contains("Build 1 is complete."), "{again}");
    assert_eq!(dashboard.get("/told/0").await.status, StatusCode::NOT_FOUND);
}

#[tokio::test]
async fn a_form_of_an_earlier_daemon_is_carried_out_once_and_one_of_another_farm_is_refused() {
    let dashboard = with_a_build("bracket.stl").await;
    dashboard.printer_takes_it().await;
    let requeue = |form: &PageForm| form.says("act", "requeue");
    let (sent, unsent) = (dashboard.form("/builds/1", requeue).await, dashboard.form("/builds/1", requeue).await);
    let ended = dashboard.form("/builds/1", requeue).await;
    dashboard.press(&sent).await;
    // A daemon that ended before it answered: the key is noted, and what became of it is not.
    let key = &ended.fields.iter().find(|(name, _)| name == "key").unwrap().1;
    let client = crate::web::clients::client::RequestClient::nobody();
    let mut asked = blake3::Hasher::new();
    asked.update(ended.action.as_bytes()).update(b"\n").update(ended.body().as_bytes());
    let never = crate::web::serve::sent_form::carry_out_form(
        dashboard.web.clone(),
        &client,
        key,
        asked.finalize().to_hex().to_string(),
        std::future::pending(),
    );
    assert!(tokio::time::timeout(std::time::Duration::from_millis(500), never).await.is_err());
    let keys = FormKeys::of_farm(&dashboard.ledger).await.unwrap();
    let restarted = TestDashboard::new(|web| (web.ledger, web.form_keys) = ((*dashboard.ledger).clone(), keys)).await;
    let again = restarted.press(&sent).await;
    assert!(again.text.contains("Build 1 is issued once more as build 2."), "{}", again.text);
    let foreign = with_a_build("bracket.stl").await.form("/builds/1", requeue).await;
    let unknown = restarted.press(&foreign).await;
    assert_eq!(unknown.status, StatusCode::FORBIDDEN, "{}", unknown.text);
    let ended = restarted.press(&ended).await;
    assert!(ended.text.contains("it is not known whether all of it was done"), "{}", ended.text);
    let build = dashboard.ledger.find_build(BuildId(2)).await.unwrap().unwrap();
    assert_eq!(build.state, BuildState::Nesting);
    assert!(dashboard.ledger.find_build(BuildId(3)).await.unwrap().is_none());
    let late = restarted.press(&unsent).await;
    assert_eq!(late.status, StatusCode::SEE_OTHER, "{}", late.text);
}

#[tokio::test]
async fn what_is_refused_while_a_file_lies_in_the_queue_has_a_button_that_sends_the_same_form_once_more() {
    let dashboard = with_a_build("bracket.stl").await;
    let is_outcome = |form: &PageForm| form.says("act", "complete") || form.says("act", "interrupted");
    let before = dashboard.ledger.find_build(BuildId(1)).await.unwrap();
    for (act, bad) in [("failed", "0"), ("complete", "1"), ("interrupted", "1"), ("reprint", "0"), ("requeue", "0")] {
        let form = dashboard.form("/builds/1", is_outcome).await.set("act", act).set("bad_1", bad);
        let refused = dashboard.press(&form).await;
        assert!(refused.text.contains("Refused") && refused.text.contains("lies untouched"), "{act}: {}", refused.text);
    }
    assert_eq!(dashboard.ledger.find_build(BuildId(1)).await.unwrap(), before);
    let form = dashboard.form("/builds/1", is_outcome).await;
    let form = form.set("act", "complete").set("bad_1", "1").set("note", "warped & \"bent\"");
    let refused = dashboard.press(&form).await;
    let button = forms_of(&refused.text).remove(0);
    let said: Vec<_> = button.fields.iter().filter(|(name, _)| name != "key" && name != "anyway").collect();
    let asked: Vec<_> = form.fields.iter().filter(|(name, _)| name != "key").collect();
    assert_eq!((&button.action, said), (&form.action, asked));
    assert!(button.says("anyway", "yes") && button.fields[0] != form.fields[0], "a key of its own: {button:?}");
}
