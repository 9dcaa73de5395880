//! Tests of the order pages, and of the forms that tell outcomes, print again and change what was asked.

use ledger::{BuildId, BuildState, CommandKind, NewPartRow, PartEdit, PartId};

use super::*;
use crate::web::base::query::order_address;

impl TestDashboard {
    pub(super) async fn post_to(&self, path: &str, fields: &[(&str, &str)]) -> TestResponse {
        let request = Request::post(path).header("sec-fetch-site", "same-origin");
        self.send_form(request, &serde_urlencoded::to_string(fields).unwrap()).await
    }

    /// Tells something of build 1.
    async fn tell(&self, fields: &[(&str, &str)]) -> TestResponse {
        self.printer_takes_it().await;
        let all: Vec<_> = [("key", "key")].into_iter().chain(fields.iter().copied()).collect();
        self.post_to("/builds/1/told", &all).await
    }

    async fn claim(&self, claim: &str, order: &str) -> PartId {
        let part = NewPartRow {
            machine: "cube".to_owned(),
            ..fixtures::asked(fixtures::new_part(claim, 1), |terms| terms.order_name = order.to_owned())
        };
        let id = self.ledger.record_claim(&part).await.unwrap().id;
        self.ledger.accept_solids(id, &[fixtures::solid(0, 1)]).await.unwrap();
        id
    }

    async fn json(&self, path: &str) -> serde_json::Value {
        serde_json::from_str(&self.get(path).await.text).unwrap()
    }
}

#[tokio::test]
async fn a_month_sums_up_what_each_machine_made_and_says_what_failed_and_what_was_late() {
    let dashboard = with_a_build("bracket.stl").await;
    let row = dashboard.ledger.read_history(&Default::default()).await.unwrap().remove(0);
    let zone = dashboard.web.current_settings().time_zone.clone();
    let month = row.at.0.to_zoned(zone.time_zone().clone()).strftime("%Y-%m").to_string();
    let late = ledger::NewPartRow {
        machine: "cube".to_owned(),
        ..fixtures::asked(fixtures::new_part("late", 1), |terms| {
            (terms.order_name, terms.due_at) = ("L1".to_owned(), Some(row.at.0 - jiff::SignedDuration::from_secs(1)));
        })
    };
    let id = dashboard.ledger.record_claim(&late).await.unwrap().id;
    dashboard.ledger.accept_solids(id, &[fixtures::solid(0, 1)]).await.unwrap();
    assert_eq!(dashboard.tell(&[("act", "complete"), ("bad", "1=1")]).await.status, StatusCode::SEE_OTHER);
    let report = dashboard.json(&format!("/api/v1/month?at={month}")).await;
    let cube = &report["machines"][0];
    let figures = ["builds", "copies", "good_copies", "bad_copies"].map(|key| cube[key].as_u64().unwrap());
    assert_eq!(figures, [1, 2, 1, 1], "{report}");
    assert_eq!((cube["height_mm"].as_f64(), cube["yield_share"].as_f64()), (Some(87.5), Some(0.5)));
    assert!(
        (cube["print_hours"].as_f64().unwrap() - 8.75).abs() < 1e-9
            && (cube["part_litres"].as_f64().unwrap() - 0.002).abs() < 1e-9
    );
    assert!((cube["cake_litres"].as_f64().unwrap() - 0.002 / 0.21).abs() < 1e-9, "{cube}");
    assert_eq!(report["before"][0]["builds"], 0);
    assert_eq!((report["late"][0]["order_name"].as_str(), report["late"].as_array().unwrap().len()), (Some("L1"), 1));
    dashboard.tell(&[("act", "failed"), ("correct", "yes"), ("note", "bed moved")]).await;
    let page = dashboard.get(&format!("/month?at={month}")).await.text;
    assert!(
        page.contains("bed moved") && page.contains("href=\"/orders/L1\"") && page.contains("<rect class=\"bar c0\""),
        "{page}"
    );
    let csv = dashboard.get(&format!("/month.csv?at={month}")).await.text;
    assert!(csv.starts_with("machine,builds,failed_builds,height_mm") && csv.contains("cube,1,1,87.5"), "{csv}");
    assert_eq!(dashboard.get("/month?at=1999-12").await.status, StatusCode::OK);
    for wrong in ["2026-13", "soon", "2026", "2026-1", "99999-01"] {
        assert_eq!(dashboard.get(&format!("/month?at={wrong}")).await.status, StatusCode::BAD_REQUEST, "{wrong}");
    }
}

#[tokio::test]
async fn the_forms_of_an_order_command_every_line_that_waits() {
    let dashboard = TestDashboard::new(|_| ()).await;
    let parts =
        [dashboard.claim("a", "N1").await, dashboard.claim("b", "N1").await, dashboard.claim("c", "other").await];
    let page = dashboard.get("/orders/N1").await.text;
    assert!(page.contains("action=\"/orders/N1/edit\"") && page.contains("For all 2 waiting parts"), "{page}");
    let refused = async |path: &str, fields: &[(&str, &str)]| dashboard.post_to(path, fields).await.status;
    assert_eq!(refused("/orders/N1/edit", &[("key", "guessed"), ("priority", "90")]).await, StatusCode::FORBIDDEN);
    assert_eq!(refused("/orders/N1/edit", &[("key", "key")]).await, StatusCode::BAD_REQUEST);
    assert_eq!(refused("/orders/N1/edit", &[("key", "key"), ("due", "soon")]).await, StatusCode::BAD_REQUEST);
    assert_eq!(refused("/orders/N1/move", &[("key", "key"), ("machine", "gone")]).await, StatusCode::NOT_FOUND);
    assert_eq!(refused("/orders/none/edit", &[("key", "key"), ("priority", "9")]).await, StatusCode::CONFLICT);
    // No daemon answers here: the commands are noted.
    let edited = dashboard.post_to("/orders/N1/edit", &[("key", "key"), ("priority", "90"), ("due", "none")]).await;
    assert!(edited.text.contains("has not answered"), "{}", edited.text);
    let mut asked: Vec<_> =
        dashboard.ledger.pending_commands().await.unwrap().into_iter().map(|row| (row.kind, row.part_id)).collect();
    asked.sort_by_key(|(_, part)| *part);
    assert_eq!(asked, [(CommandKind::Edit, Some(parts[0])), (CommandKind::Edit, Some(parts[1]))]);
}

#[tokio::test]
async fn an_order_is_for_a_customer_who_can_be_changed_also_when_all_of_it_is_built() {
    let dashboard = with_a_build("bracket.stl").await;
    dashboard.claim("b", "bracket.stl").await;
    let form = [
        ("key", "key"),
        ("customer", "Brandt & Co"),
        ("was_customer", ""),
        ("email", "anna@brandt.example"),
        ("was_email", ""),
        ("priority", "90"),
    ];
    dashboard.post_to("/orders/bracket.stl/edit", &form).await;
    let commands = dashboard.ledger.pending_commands().await.unwrap();
    let (customer, email) = (Some("Brandt & Co".to_owned()), Some("anna@brandt.example".to_owned()));
    let asked: Vec<_> =
        commands.iter().map(|command| (command.part_id, command.read_argument().unwrap().edit.unwrap())).collect();
    let address = ledger::PartEdit { customer, email, ..Default::default() };
    assert_eq!(asked[0], (Some(PartId(1)), address.clone()));
    assert_eq!(asked[1].1, ledger::PartEdit { priority: Some(90), ..address });
    for (part, edit) in asked {
        dashboard.ledger.edit_part(part.unwrap(), &edit, "ann@farm").await.unwrap();
    }
    let page = dashboard.get("/orders/bracket.stl").await.text;
    assert!(page.contains("href=\"/orders?customer=Brandt+%26+Co\">Brandt &amp; Co"), "{page}");
    assert!(page.contains("name=\"was_email\" value=\"anna@brandt.example\""), "{page}");
    for (asked, found) in [("brandt", 1), ("müller", 0)] {
        let orders = dashboard.json(&format!("/api/v1/orders?customer={asked}")).await;
        assert_eq!(orders.as_array().unwrap().len(), found, "{asked}");
    }
    assert!(dashboard.get("/search?q=customer+brandt").await.text.contains("/orders?customer=Brandt+%26+Co"));
}

#[tokio::test]
async fn a_person_closes_an_order_as_it_is_and_its_page_says_who_did_it() {
    let dashboard = with_a_build("bracket.stl").await;
    let refused = dashboard.claim("b", "bracket.stl").await;
    dashboard.ledger.cancel_part(refused, ledger::RefusalCause::TooLarge, "too large").await.unwrap();
    let page = dashboard.get("/orders/bracket.stl").await.text;
    assert!(page.contains("Accept 2 of 3") && page.contains("Nobody is asked any more for 1 refused copy."), "{page}");
    let needs = async || dashboard.get("/").await.text.contains("href=\"/parts/2\"");
    let closed = dashboard.post_to("/orders/bracket.stl/close", &[("key", "key")]).await.text;
    assert!(closed.contains("Order bracket.stl is closed with 2 of 3 copies."), "{closed}");
    assert!(!needs().await, "nobody is asked for what was refused");
    dashboard.tell(&[("act", "complete")]).await;
    let page = dashboard.get("/orders/bracket.stl").await.text;
    assert!(page.contains("</i>closed</span></h1>") && page.contains(" by dashboard, with 2 of 3 copies."), "{page}");
    assert!(!page.contains("Accept "), "{page}");
    assert!(page.contains("Your order bracket.stl is complete with 2 of 3 parts."), "{page}");
    let again = dashboard.post_to("/orders/bracket.stl/close", &[("key", "key")]).await.text;
    assert!(again.contains("Refused") && again.contains("nothing to close"), "{again}");
    let order = dashboard.json("/api/v1/orders/bracket.stl").await;
    let closing = ["standing", "closed_by", "accepted_copies", "closed_of"].map(|key| order[key].to_string());
    assert_eq!(closing, ["\"closed\"", "\"dashboard\"", "2", "3"]);
}

#[tokio::test]
async fn no_form_of_an_order_begins_with_cancel() {
    let dashboard = TestDashboard::new(|_| ()).await;
    dashboard.claim("a", "N1").await;
    for path in ["/orders/N1", "/parts/1"] {
        let page = dashboard.get(path).await.text;
        let (cancel, edit) = (page.rfind(">Cancel").unwrap(), page.rfind(">Change").unwrap());
        assert!(cancel > edit && page.find(">Cancel").unwrap() > page.find("/edit\"").unwrap(), "{path}: {page}");
    }
}

#[tokio::test]
async fn what_nobody_told_has_no_yield_and_is_late_once_its_print_must_be_over() {
    let hour = jiff::SignedDuration::from_hours(1);
    // A print of 87.5 mm takes 8.75 hours: nobody told that it is over, and it was put into the queue in time.
    let dashboard = with_a_build_due("bracket.stl", Some(jiff::Timestamp::now() + hour)).await;
    let published = dashboard.ledger.read_history(&Default::default()).await.unwrap()[0].at.0;
    let zone = dashboard.web.current_settings().time_zone.clone();
    let month = published.to_zoned(zone.time_zone().clone()).strftime("%Y-%m").to_string();
    let machine = async || dashboard.json(&format!("/api/v1/month?at={month}")).await["machines"][0].clone();
    assert_eq!(machine().await["yield_share"], serde_json::Value::Null);
    let page = dashboard.get(&format!("/month?at={month}")).await.text;
    assert!(page.contains("as many days of "), "{page}");
    let late = async |now: jiff::Timestamp| {
        let settings = dashboard.web.current_settings();
        let plans = farm::read_plans(&dashboard.ledger, settings.profiles.values(), now).await.unwrap();
        let span = (published - hour * 24, published + hour * 24);
        farm::read_late_parts(&dashboard.ledger, &settings.profiles, &plans, span, now).await.unwrap()
    };
    assert!(late(published + hour * 8).await.is_empty(), "it is printed");
    for hours in [9, 40 * 24] {
        let told = late(published + hour * hours).await;
        assert_eq!((told.len(), told[0].is_estimated), (1, true));
        let after = told[0].done_at.unwrap().0.duration_since(published).as_secs();
        assert!((8 * 3600..=9 * 3600).contains(&after), "{after} s after it was put into the queue");
    }
}

#[tokio::test]
async fn orders_are_found_by_any_part_of_their_name_and_open_ones_come_first() {
    let dashboard = with_a_build("Old Möbel.stl").await;
    assert_eq!(dashboard.tell(&[("act", "complete")]).await.status, StatusCode::SEE_OTHER);
    let nasty = "A/B + 50 % ü?x=1#y";
    dashboard.claim("b", nasty).await;
    let names = async |asked: &str| -> Vec<String> {
        let orders = dashboard.json(&format!("/api/v1/orders{asked}")).await;
        orders.as_array().unwrap().iter().map(|order| order["name"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(names("").await, [nasty, "Old Möbel.stl"]);
    assert_eq!(names("?find=m%C3%96BEL").await, ["Old Möbel.stl"]);
    assert_eq!(names("?state=open").await, [nasty]);
    assert_eq!(names("?limit=1").await, [nasty]);
    assert_eq!(names("?find=none").await, [""; 0]);
    let page = dashboard.get("/orders?find=MÖB").await;
    assert!(page.status == StatusCode::OK && page.text.contains("1 order<"), "{}", page.text);
    let list = dashboard.get("/orders").await.text;
    assert!(list.contains(&format!("href=\"{}\"", order_address(nasty))), "{list}");
    for path in [order_address(nasty), format!("/api/v1{}", order_address(nasty))] {
        assert_eq!(dashboard.get(&path).await.status, StatusCode::OK, "{path}");
    }
    assert_eq!(dashboard.get("/orders/none").await.status, StatusCode::NOT_FOUND);
}

#[tokio::test]
async fn an_order_shows_each_line_with_its_copies_its_part_and_its_builds() {
    let dashboard = with_a_build("bracket.stl").await;
    let page = dashboard.get("/orders/bracket.stl").await.text;
    assert!(page.contains("href=\"/parts/1\"") && page.contains("href=\"/builds/1#part-1\""), "{page}");
    // No printer was decided, so that it is taken to print; it takes 8.75 hours.
    assert!(page.contains("2 printing; since") && page.contains("Expected about <time"), "{page}");
    let order = dashboard.json("/api/v1/orders/bracket.stl").await;
    assert_eq!(
        (&order["state"], &order["standing"], &order["printing"]),
        (&"open".into(), &"under_way".into(), &2.into())
    );
    let line = &order["lines"][0];
    assert_eq!((&line["part"], &line["wanted"], &line["printing"]), (&1.into(), &2.into(), &2.into()));
    let build = &line["builds"][0];
    assert_eq!((&build["build"], &build["copies"], &build["state_word"]), (&1.into(), &2.into(), &"printing".into()));
    assert!(build["ends_at"].is_string() && build["ends_at"] == order["done_at"], "{order}");
    let note = order["customer_note"].as_str().unwrap();
    assert!(
        note.starts_with("Your order bracket.stl: none of the 2 parts is printed yet, all of it is expected "),
        "{note}"
    );
    assert!(page.contains(note) && page.contains("data-copies=\"customer-note\""), "{page}");
    let heads =
        page.split("<table>").skip(1).map(|table| table.split("</thead>").next().unwrap().matches("<th").count());
    assert!(heads.clone().count() == 3 && heads.clone().all(|columns| columns <= 6), "{:?}", heads.collect::<Vec<_>>());
    for path in ["/parts?state=built", "/parts/1", "/builds/1"] {
        assert!(dashboard.get(path).await.text.contains("href=\"/orders/bracket.stl\""), "{path} links to the order");
    }
}

#[tokio::test]
async fn a_failed_print_stands_out_until_somebody_has_seen_to_it() {
    let dashboard = with_a_build("bracket.stl").await;
    assert!(dashboard.get("/builds/1").await.text.contains("Tell how it printed"));
    let told = dashboard.tell(&[("act", "failed"), ("note", "blade hit it")]).await.text;
    assert!(told.contains("Build 1 is failed.") && told.contains("2 copies of 1 part wait again"), "{told}");
    for path in ["/", "/builds/1"] {
        let page = dashboard.get(path).await.text;
        assert!(page.contains("Nobody has seen to it yet") && page.contains("blade hit it"), "{path}: {page}");
    }
    let outcomes = dashboard.ledger.outcomes_of_build(BuildId(1)).await.unwrap();
    assert_eq!((outcomes[0].told_by.as_str(), outcomes[0].note.as_str()), ("dashboard", "blade hit it"));
    let refused = dashboard.tell(&[("act", "complete")]).await.text;
    assert!(refused.contains("Refused") && refused.contains("is recorded as failed already"), "{refused}");
    assert_eq!(dashboard.tell(&[("act", "seen")]).await.status, StatusCode::SEE_OTHER);
    for path in ["/", "/builds/1"] {
        assert!(!dashboard.get(path).await.text.contains("Nobody has seen to it yet"), "{path}");
    }
    assert!(dashboard.get("/builds/1").await.text.contains("Correct what was told"));
    let corrected = dashboard.tell(&[("act", "complete"), ("correct", "yes")]).await.text;
    assert!(corrected.contains("Counted as printed again"), "{corrected}");
    assert_eq!(dashboard.json("/api/v1/orders/bracket.stl").await["good"], 2);
}

/// The numbers of the bad copies of a build.
fn json_of_bad(build: &serde_json::Value) -> Vec<u64> {
    let bad = build["placements"].as_array().unwrap().iter().filter(|placed| placed["bad"] == true);
    bad.map(|placed| placed["copy"].as_u64().unwrap()).collect()
}

#[tokio::test]
async fn a_number_of_copies_that_is_asked_for_is_shown_as_not_known() {
    let dashboard = TestDashboard::new(|_| ()).await;
    let asked = fixtures::asked(fixtures::new_part("a", 1), |terms| terms.order_name = "kit".to_owned());
    let warnings = vec!["How many copies? Its name has two numbers.".to_owned()];
    let part = NewPartRow { machine: "cube".to_owned(), warnings, ..asked };
    let id = dashboard.ledger.record_claim(&part).await.unwrap().id;
    dashboard.ledger.accept_solids(id, &[fixtures::solid(0, 1)]).await.unwrap();
    let order = dashboard.json("/api/v1/orders/kit").await;
    assert_eq!((&order["lines_without_number"], &order["lines"][0]["is_number_known"]), (&1.into(), &false.into()));
    assert_eq!(dashboard.json(&format!("/api/v1/parts/{id}")).await["part"]["is_number_known"], false);
    for (path, words) in [
        ("/orders".to_owned(), "1 waiting, how many of 1 line is not known"),
        ("/orders/kit".to_owned(), "not known (1 waiting)"),
        ("/parts".to_owned(), ">not known</td>"),
        (format!("/parts/{id}"), "not known, taken as 1"),
    ] {
        let page = dashboard.get(&path).await.text;
        assert!(page.contains(words), "{path}: {page}");
    }
    dashboard.ledger.edit_part(id, &PartEdit { copies: Some(1), ..PartEdit::default() }, "ann@farm").await.unwrap();
    let order = dashboard.json("/api/v1/orders/kit").await;
    assert_eq!((&order["lines_without_number"], &order["lines"][0]["is_number_known"]), (&0.into(), &true.into()));
}

#[tokio::test]
async fn bad_copies_and_whole_builds_are_printed_again_by_form() {
    let dashboard = with_a_build("bracket.stl").await;
    let order = async || dashboard.json("/api/v1/orders/bracket.stl").await;
    assert_eq!(dashboard.tell(&[("act", "complete"), ("bad", "seven")]).await.status, StatusCode::BAD_REQUEST);
    assert!(
        dashboard.tell(&[("act", "complete"), ("bad", "1=3")]).await.text.contains("build 1 holds 2 copies of part 1")
    );
    dashboard.tell(&[("act", "complete"), ("bad_1", "1")]).await;
    assert_eq!((&order().await["good"], &order().await["waiting"]), (&1.into(), &1.into()));
    let page = dashboard.get("/builds/1").await.text;
    let bad = json_of_bad(&dashboard.json("/api/v1/builds/1").await);
    assert!(page.contains("<b>1</b>bad copy</a>") && page.contains(&format!("1 (no. {})", bad[0])), "{bad:?}: {page}");
    assert_eq!(bad.len(), 1);
    let field = page.split("name=\"bad_1\"").nth(1).unwrap().split('>').next().unwrap();
    assert!(field.contains("value=\"1\""), "a correction starts from what was told: {field}");
    let part = dashboard.post_to("/parts/1/reprint", &[("key", "key"), ("copies", "1")]).await;
    assert!(part.text.contains("1 copy of 1 part waits again"), "{}", part.text);
    assert_eq!(order().await["waiting"], 2);
    let nothing = dashboard.post_to("/orders/bracket.stl/reprint", &[("key", "key")]).await.text;
    assert!(nothing.contains("Refused") && nothing.contains("no copy of it counts as printed"), "{nothing}");
    let again = dashboard.tell(&[("act", "requeue")]).await.text;
    assert!(again.contains("Build 1 is issued once more as build 2."), "{again}");
    let build = dashboard.ledger.find_build(BuildId(2)).await.unwrap().unwrap();
    assert_eq!((build.state, build.search.repeats), (BuildState::Nesting, Some(BuildId(1))));
    let other = with_a_build("bracket.stl").await;
    assert!(other.tell(&[("act", "reprint")]).await.text.contains("2 copies of 1 part wait again"));
}

#[tokio::test]
async fn a_form_sends_only_what_a_person_changed_and_shows_why_it_was_refused() {
    let dashboard = TestDashboard::new(|_| ()).await;
    let part = dashboard.claim("a", "kit").await;
    let page = dashboard.get("/parts/1").await.text;
    assert!(page.contains("name=\"was_copies\" value=\"1\"") && page.contains("name=\"due\""), "{page}");
    let ledger = (*dashboard.ledger).clone();
    let daemon = tokio::spawn(async move {
        let mut seen = Vec::new();
        while seen.len() < 2 {
            for command in ledger.pending_commands().await.unwrap() {
                ledger.answer_command(command.id, seen.is_empty(), "it is `being` nested").await.unwrap();
                seen.push((command.kind, command.part_id, command.asked_by.clone(), command.read_argument().unwrap()));
            }
            tokio::time::sleep(std::time::Duration::from_millis(5)).await;
        }
        seen
    });
    let fields = [("key", "key"), ("copies", "4"), ("was_copies", "1"), ("priority", "0"), ("was_priority", "0")];
    assert_eq!(dashboard.post_to("/parts/1/edit", &fields).await.status, StatusCode::SEE_OTHER);
    let refused = dashboard.post_to("/orders/kit/cancel", &[("key", "key")]).await.text;
    assert!(refused.contains("Refused") && refused.contains("it is <code>being</code> nested."), "{refused}");
    let seen = daemon.await.unwrap();
    let edit = ledger::PartEdit { copies: Some(4), ..Default::default() };
    assert_eq!((seen[0].0, seen[0].1, seen[0].2.as_str()), (CommandKind::Edit, Some(part), "dashboard"));
    assert_eq!((seen[0].3.edit.as_ref(), seen[1].0), (Some(&edit), CommandKind::Cancel));
    let wrong = dashboard.post_to("/parts/1/edit", &[("key", "key"), ("due", "soon"), ("was_due", "")]).await;
    assert_eq!(wrong.status, StatusCode::BAD_REQUEST);
}

#[tokio::test]
async fn forms_need_the_key_of_the_page_and_a_farm_that_takes_orders() {
    let (dashboard, silent) = (with_a_build("bracket.stl").await, TestDashboard::new(|web| web.orders = false).await);
    silent.claim("a", "kit").await;
    let forms = [
        "/builds/1/told",
        "/parts/1/edit",
        "/parts/1/reprint",
        "/orders/kit/cancel",
        "/orders/kit/reprint",
        "/orders/kit/close",
    ];
    for path in forms {
        let fields = [("act", "failed"), ("copies", "1")];
        let with_key = |key| [("key", key)].into_iter().chain(fields).collect::<Vec<_>>();
        assert_eq!(dashboard.post_to(path, &with_key("wrong")).await.status, StatusCode::FORBIDDEN, "{path}");
        assert_eq!(silent.post_to(path, &with_key("key")).await.status, StatusCode::FORBIDDEN, "{path}");
    }
    for path in ["/parts/1", "/orders/kit"] {
        assert!(!silent.get(path).await.text.contains("method=\"post\""), "{path}");
    }
    assert!(dashboard.ledger.outcomes_of_build(BuildId(1)).await.unwrap().is_empty());
}
