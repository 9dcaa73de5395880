//! Tests of the JSON interface: every response matches its description and contains the same data as the pages.

use ledger::{NightState, OpenLayout};

use super::*;
use crate::{
    tables::{HEIGHT_SUM_COLUMNS, HISTORY_COLUMNS, ORDER_COLUMNS, PART_COLUMNS, TableColumn},
    web::doors::openapi::described,
};

/// Checks a value against a schema of the description, and adds each mismatch with its path to `faults`.
pub(super) fn unlike(
    schema: &serde_json::Value,
    value: &serde_json::Value,
    all: &serde_json::Value,
    path: &str,
    faults: &mut Vec<String>,
) {
    if let Some(name) = schema.get("$ref").and_then(|r| r.as_str()) {
        let target = name.rsplit('/').next().unwrap();
        return unlike(&all["components"]["schemas"][target], value, all, path, faults);
    }
    if let Some(choices) = ["anyOf", "oneOf"].iter().find_map(|of| schema.get(of)?.as_array()) {
        let faults_of = |choice| {
            let mut faults = Vec::new();
            unlike(choice, value, all, path, &mut faults);
            faults
        };
        match choices.iter().map(faults_of).find(Vec::is_empty) {
            Some(_) => return,
            None => return faults.extend(faults_of(&choices[0])),
        }
    }
    let words = schema.get("enum").and_then(|words| words.as_array()).cloned();
    if words.or(schema.get("const").map(|word| vec![word.clone()])).is_some_and(|words| !words.contains(value)) {
        return faults.push(format!("{path}: {value} is no word of {schema}"));
    }
    let kinds: Vec<&str> = match &schema["type"] {
        serde_json::Value::String(kind) => vec![kind],
        serde_json::Value::Array(kinds) => kinds.iter().filter_map(|k| k.as_str()).collect(),
        _ => return faults.push(format!("{path}: no type in the description")),
    };
    let kind = match value {
        serde_json::Value::Null => "null",
        serde_json::Value::Bool(_) => "boolean",
        serde_json::Value::Number(n) if n.is_f64() => "number",
        serde_json::Value::Number(_) => "integer",
        serde_json::Value::String(_) => "string",
        serde_json::Value::Array(_) => "array",
        serde_json::Value::Object(_) => "object",
    };
    if !(kinds.contains(&kind) || kind == "integer" && kinds.contains(&"number")) {
        return faults.push(format!("{path}: {kind} is none of {kinds:?}"));
    }
    if let Some(list) = value.as_array() {
        list.iter().for_each(|one| unlike(&schema["items"], one, all, &format!("{path}[]"), faults));
    }
    if let Some(object) = value.as_object() {
        let properties = schema["properties"].as_object().unwrap();
        for (name, one) in object {
            match properties.get(name) {
                Some(schema) => unlike(schema, one, all, &format!("{path}.{name}"), faults),
                None => faults.push(format!("{path}.{name} is not described")),
            }
        }
        for name in schema["required"].as_array().into_iter().flatten().filter_map(|n| n.as_str()) {
            if !object.contains_key(name) {
                faults.push(format!("{path}.{name} is described and not there"));
            }
        }
    }
}

/// The keys that an object of a JSON text holds twice.
#[derive(Debug, Default)]
struct TwiceNamed(Vec<String>);

impl<'de> serde::Deserialize<'de> for TwiceNamed {
    fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Walk;
        impl<'de> serde::de::Visitor<'de> for Walk {
            type Value = TwiceNamed;
            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("JSON")
            }
            fn visit_bool<E>(self, _: bool) -> Result<TwiceNamed, E> {
                Ok(TwiceNamed::default())
            }
            fn visit_i64<E>(self, _: i64) -> Result<TwiceNamed, E> {
                Ok(TwiceNamed::default())
            }
            fn visit_u64<E>(self, _: u64) -> Result<TwiceNamed, E> {
                Ok(TwiceNamed::default())
            }
            fn visit_f64<E>(self, _: f64) -> Result<TwiceNamed, E> {
                Ok(TwiceNamed::default())
            }
            fn visit_str<E>(self, _: &str) -> Result<TwiceNamed, E> {
                Ok(TwiceNamed::default())
            }
            fn visit_unit<E>(self) -> Result<TwiceNamed, E> {
                Ok(TwiceNamed::default())
            }
            fn visit_seq<A: serde::de::SeqAccess<'de>>(self, mut list: A) -> Result<TwiceNamed, A::Error> {
                let mut twice = TwiceNamed::default();
                while let Some(TwiceNamed(more)) = list.next_element()? {
                    twice.0.extend(more);
                }
                Ok(twice)
            }
            fn visit_map<A: serde::de::MapAccess<'de>>(self, mut object: A) -> Result<TwiceNamed, A::Error> {
                let (mut twice, mut keys) = (TwiceNamed::default(), std::collections::HashSet::new());
                while let Some((key, TwiceNamed(more))) = object.next_entry::<String, _>()? {
                    twice.0.extend(more);
                    if !keys.insert(key.clone()) {
                        twice.0.push(key);
                    }
                }
                Ok(twice)
            }
        }
        from.deserialize_any(Walk)
    }
}

/// What no generator of clients and no validator takes, with its place.
fn unclear(all: &serde_json::Value, value: &serde_json::Value, path: &str, faults: &mut Vec<String>) {
    if let Some(list) = value.as_array() {
        list.iter().enumerate().for_each(|(at, one)| unclear(all, one, &format!("{path}/{at}"), faults));
    }
    let Some(object) = value.as_object() else { return };
    if let Some(required) = object.get("required").and_then(|names| names.as_array()) {
        let mut names: Vec<String> = required.iter().map(ToString::to_string).collect();
        names.sort();
        names.dedup();
        if names.len() < required.len() {
            faults.push(format!("{path}: a field is required twice in {required:?}"));
        }
    }
    if let Some(default) = object.get("default").filter(|default| !default.is_object() && object.contains_key("type")) {
        unlike(value, default, all, &format!("{path}, default"), faults);
    }
    for key in ["items", "schema", "additionalProperties"] {
        if object.get(key).is_some_and(|schema| *schema == true || *schema == serde_json::json!({})) {
            faults.push(format!("{path}/{key} says nothing"));
        }
    }
    object.iter().for_each(|(key, one)| unclear(all, one, &format!("{path}/{key}"), faults));
}

#[tokio::test]
async fn the_description_is_one_that_validators_and_generators_of_clients_take() {
    let all = described();
    let mut faults = Vec::new();
    unclear(&all, &all, "", &mut faults);
    assert!(faults.is_empty(), "{faults:#?}");
    let asked = &all["components"]["schemas"];
    assert_eq!(asked["OrderRequest"]["required"], serde_json::json!(["machine", "lines"]));
    assert_eq!(asked["OutcomeRequest"]["required"], serde_json::json!(["outcome"]), "the rest may be left out");
}

#[tokio::test]
async fn what_is_described_is_served_and_nothing_else_is() {
    let dashboard = with_a_build("bracket.stl").await;
    for (path, operations) in described()["paths"].as_object().unwrap() {
        let asked = path.split(['{', '}']).enumerate().map(|(at, step)| if at % 2 == 1 { "1" } else { step });
        let asked: String = asked.collect();
        for method in ["get", "put", "post", "patch", "delete"] {
            let request =
                Request::builder().method(method.to_uppercase().as_str()).uri(&asked).header("host", "localhost");
            let answer = dashboard.send(request.body(Body::empty()).unwrap()).await;
            let is_served =
                answer.status != StatusCode::METHOD_NOT_ALLOWED && !answer.text.contains("page of that address");
            assert_eq!(
                is_served,
                operations.get(method).is_some(),
                "{method} {path}: {} {}",
                answer.status,
                answer.text
            );
        }
    }
    let by_hand = include_str!("serve/server.rs").matches("\"/api/").count();
    assert_eq!(
        by_hand, 1,
        "the document itself; every other address is a row of api_routes, which has its description"
    );
}

#[tokio::test]
async fn every_answer_of_the_json_interface_is_as_described() {
    let all = described();
    let dashboard = with_a_build("bracket.stl").await;
    let mut faults = Vec::new();
    for (path, asked) in [
        ("/api/v1/farm", "/api/v1/farm"),
        ("/api/v1/builds", "/api/v1/builds"),
        ("/api/v1/heights", "/api/v1/heights"),
        ("/api/v1/builds/{build}", "/api/v1/builds/1"),
        ("/api/v1/builds/{build}/pick", "/api/v1/builds/1/pick"),
        ("/api/v1/parts", "/api/v1/parts"),
        ("/api/v1/parts", "/api/v1/parts?state=built&machine=cube"),
        ("/api/v1/parts", "/api/v1/parts?name=bracket.stl"),
        ("/api/v1/parts/{part}", "/api/v1/parts/1"),
        ("/api/v1/orders", "/api/v1/orders?find=RACK&state=open&limit=7"),
        ("/api/v1/orders/{order}", "/api/v1/orders/bracket.stl"),
        ("/api/v1/orders/{order}/lines/{line}", "/api/v1/orders/bracket.stl/lines/1"),
        ("/api/v1/events", "/api/v1/events?limit=3"),
    ] {
        let text = dashboard.get(asked).await.text;
        let TwiceNamed(twice) = serde_json::from_str(&text).unwrap();
        assert!(twice.is_empty(), "{asked} names twice: {twice:?}");
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert!(!path.contains("orders") || value != serde_json::json!([]), "{asked} finds nothing");
        let schema = &all["paths"][path]["get"]["responses"]["200"]["content"]["application/json"]["schema"];
        unlike(schema, &value, &all, path, &mut faults);
    }
    for (path, asked, status) in [
        ("/api/v1/orders/{order}/lines/{line}", "/api/v1/orders/bracket.stl/lines/9", StatusCode::NOT_FOUND),
        ("/api/v1/content/{hash}", "/api/v1/content/00", StatusCode::BAD_REQUEST),
        ("/api/v1/uploads/{upload}", "/api/v1/uploads/00", StatusCode::NOT_FOUND),
        ("/api/v1/builds/{build}", "/api/v1/builds/77", StatusCode::NOT_FOUND),
        ("/api/v1/builds/{build}/pick", "/api/v1/builds/one/pick", StatusCode::BAD_REQUEST),
        ("/api/v1/parts", "/api/v1/parts?state=lost", StatusCode::BAD_REQUEST),
        ("/api/v1/heights", "/api/v1/heights?since=today", StatusCode::BAD_REQUEST),
        ("/api/v1/orders", "/api/v1/orders?state=lost", StatusCode::BAD_REQUEST),
        ("/api/v1/orders", "/api/v1/orders?limit=many", StatusCode::BAD_REQUEST),
        ("/api/v1/orders/{order}", "/api/v1/orders/none", StatusCode::NOT_FOUND),
    ] {
        let answer = dashboard.get(asked).await;
        assert_eq!(answer.status, status, "{asked}");
        let value = serde_json::from_str(&answer.text).unwrap_or_else(|_| panic!("{asked}: {}", answer.text));
        let schema =
            &all["paths"][path]["get"]["responses"][status.as_str()]["content"]["application/problem+json"]["schema"];
        unlike(schema, &value, &all, asked, &mut faults);
    }
    assert!(faults.is_empty(), "{faults:#?}");
    let page = dashboard.get("/builds/one").await;
    assert!(page.status == StatusCode::BAD_REQUEST && page.text.contains("</html>"), "a page's error is a page");
}

#[tokio::test]
async fn the_description_says_each_address_each_parameter_and_the_words_of_each_state() {
    let dashboard = with_a_build("bracket.stl").await;
    let document: serde_json::Value = serde_json::from_str(&dashboard.get("/api/v1/openapi.json").await.text).unwrap();
    assert_eq!(document, described());
    let parameters = |path: &str| -> Vec<String> {
        let parameters = document["paths"][path]["get"]["parameters"].as_array().unwrap();
        parameters.iter().map(|parameter| parameter["name"].as_str().unwrap().to_owned()).collect()
    };
    let sorted = |path: &str| {
        let mut names = parameters(path);
        names.sort();
        names
    };
    assert_eq!(sorted("/api/v1/builds"), ["after", "machine", "part", "since", "sort", "state", "until"]);
    assert_eq!(sorted("/api/v1/heights"), ["machine", "part", "since", "state", "until"]);
    assert_eq!(sorted("/api/v1/parts"), ["after", "machine", "name", "state"]);
    assert_eq!(sorted("/api/v1/orders"), ["customer", "find", "limit", "state"]);
    assert_eq!(parameters("/api/v1/parts/{part}"), ["part"]);
    assert_eq!(document["paths"]["/api/v1/orders/{order}"]["get"]["parameters"][0]["schema"]["type"], "string");
    let text = document.to_string();
    for words in [
        ledger::PartState::ALL.map(|state| state.to_string()).to_vec(),
        ledger::BuildState::ALL.map(|state| state.to_string()).to_vec(),
        ["free", "upright", "axis", "fixed", "micron", "millimeter", "inch", "max_wait"].map(str::to_owned).to_vec(),
    ] {
        for word in words {
            assert!(text.contains(&format!("\"{word}\"")), "{word}");
        }
    }
    let unit = &document["components"]["schemas"]["PartResource"]["properties"]["unit"]["enum"];
    assert_eq!(unit, &serde_json::json!(["micron", "millimeter", "centimeter", "inch", "foot", "meter", null]));
    let described = |schema: &serde_json::Value| {
        let fields = schema["properties"].as_object().into_iter().flatten();
        let bare: Vec<&String> =
            fields.filter(|(_, field)| field["description"].is_null()).map(|(name, _)| name).collect();
        assert!(bare.is_empty(), "without a description: {bare:?} in {schema}");
    };
    document["components"]["schemas"].as_object().unwrap().values().for_each(described);
    assert!(!text.contains("`None`") && !text.contains("[`"), "words of Rust");
}

#[tokio::test]
async fn pages_head_their_columns_as_the_tables_say_and_files_and_json_by_the_same_keys() {
    // A page leaves out what nothing stands in; each head that it has is that of a column.
    fn ensure_heads<Row>(page: &str, table: &str, columns: &[TableColumn<Row>]) {
        let head = page.split(&format!("aria-label=\"{table}\"")).nth(1).and_then(|rest| rest.split("</thead>").next());
        let shown: Vec<&str> = head.unwrap().split("</th>").filter_map(|head| head.rsplit('>').next()).collect();
        let (_, shown) = shown.split_last().unwrap();
        let known: Vec<String> = columns.iter().map(|column| column.field.page_heading()).collect();
        assert!(shown.len() >= 3 && shown.iter().all(|head| known.iter().any(|known| known == head)), "{shown:?}");
    }
    let dashboard = with_a_build("bracket.stl").await;
    let history = dashboard.get("/history").await.text;
    ensure_heads(&history, "Builds", HISTORY_COLUMNS);
    ensure_heads(&history, "Heights", HEIGHT_SUM_COLUMNS);
    ensure_heads(&dashboard.get("/parts?state=built").await.text, "Parts", PART_COLUMNS);
    ensure_heads(&dashboard.get("/orders").await.text, "Orders", ORDER_COLUMNS);
    let csv = dashboard.get("/history.csv").await.text;
    let mut keys: Vec<&str> = csv.lines().next().unwrap().split(',').collect();
    keys.sort_unstable();
    let schemas = described()["components"]["schemas"].clone();
    let fields: Vec<&String> = schemas["DatedBuild"]["properties"].as_object().unwrap().keys().collect();
    assert_eq!(keys, fields);
}

#[tokio::test]
async fn parts_are_listed_newest_first_by_state_machine_name_and_order_and_page_by_page() {
    let dashboard = with_a_build("bracket.stl").await;
    for (claim, machine) in [("b", "cube"), ("c", "cube"), ("d", "other")] {
        let part = ledger::NewPartRow { machine: machine.to_owned(), ..fixtures::new_part(claim, 1) };
        dashboard.ledger.record_claim(&part).await.unwrap();
    }
    let numbers = async |asked: &str| -> Vec<i64> {
        let json = dashboard.get(&format!("/api/v1/parts{asked}")).await.text;
        let parts: Vec<serde_json::Value> = serde_json::from_str(&json).unwrap();
        parts.iter().map(|part| part["part"].as_i64().unwrap()).collect()
    };
    assert_eq!(numbers("").await, [4, 3, 2], "built ones are asked for by state or name");
    assert_eq!(numbers("?state=built").await, [1]);
    assert_eq!(numbers("?machine=cube").await, [3, 2]);
    assert_eq!(numbers("?state=claimed&machine=other&name=").await, [4]);
    assert_eq!(numbers("?name=bracket.stl").await, [1], "by its file and by its order it is the same part");
    assert_eq!(numbers("?name=bracket.stl&state=waiting").await, [0_i64; 0]);
    assert_eq!(numbers("?after=3").await, [2]);
    assert_eq!(dashboard.get("/parts?state=lost").await.status, StatusCode::BAD_REQUEST);
}

#[tokio::test]
async fn what_stands_in_an_open_build_is_reported_by_its_page_by_its_parts_and_to_machines() {
    let dashboard = TestDashboard::new(|_| ()).await;
    let part = ledger::NewPartRow { machine: "cube".to_owned(), ..fixtures::new_part("a", 3) };
    let id = dashboard.ledger.record_claim(&part).await.unwrap().id;
    dashboard.ledger.accept_solids(id, &[fixtures::solid(0, 3)]).await.unwrap();
    let build = dashboard.ledger.open_build("cube").await.unwrap().id;
    let layout = format!("[[{id},0,[0,0,0,1],[5,5,0]],[{id},2,[0,0,0,1],[45,5,0]]]");
    let layout = OpenLayout { layout, height_mm: 30.0, density: 0.1, copies: 2, part_volume_mm3: 2000.0 };
    dashboard.ledger.save_layout(build, &layout).await.unwrap();
    let page = dashboard.get("/parts/1").await.text;
    assert!(
        page.contains("3 copies wait")
            && page.contains("href=\"/builds/1#part-1\"")
            && page.contains("so far: 2 copies")
    );
    let sheet: serde_json::Value = serde_json::from_str(&dashboard.get("/api/v1/builds/1").await.text).unwrap();
    assert_eq!((sheet["parts"].as_array().unwrap().len(), sheet["placements"].as_array().unwrap().len()), (1, 2));
    assert_eq!(
        (&sheet["placements"][1]["copy"], &sheet["placements"][1]["translation_mm"][0]),
        (&3.into(), &45.0.into())
    );
    assert_eq!((&sheet["build"]["volume_mm"][2], &sheet["build"]["layer_mm"]), (&200.0.into(), &0.1.into()));
    let page = dashboard.get("/builds/1").await.text;
    let facts = page.split("<dl").nth(1).unwrap().split("</dl>").next().unwrap();
    assert!(
        page.contains("300 of 0.1 mm") && !facts.contains('\u{2013}'),
        "no dashes where nothing is known yet: {facts}"
    );
    assert!(dashboard.get("/builds/1/pick").await.text.contains("A forecast"));
    assert!(!dashboard.get("/").await.text.contains("While it waits"));
    dashboard.ledger.save_night_search(build, &fixtures::night_search(NightState::GoesOn)).await.unwrap();
    let card = dashboard.get("/").await.text;
    assert!(card.contains("2.50 mm lower after 64 CPU s since the last arrival, goes on"), "{card}");
    let farm: serde_json::Value = serde_json::from_str(&dashboard.get("/api/v1/farm").await.text).unwrap();
    let text = farm.to_string();
    assert!(text.contains("\"night\":\"goes-on\"") && text.contains("\"night_gain_mm\":2.5"), "{text}");
}

#[tokio::test]
async fn a_parameter_that_an_address_does_not_have_is_refused_by_its_name_and_a_former_one_with_that_of_now() {
    let dashboard = with_a_build("bracket.stl").await;
    let asking = "builds heights parts plan orders month costs events".split(' ').map(|name| format!("/api/v1/{name}"));
    let asking: Vec<String> = asking.collect();
    let pages = ["/history", "/history.csv", "/history.json", "/parts", "/orders", "/month", "/month.csv", "/costs"];
    let pages = pages.iter().chain(&[
        "/month.json",
        "/costs.csv",
        "/costs-by-build.csv",
        "/costs.json",
        "/search",
        "/help",
        "/builds/1/picture",
        "/builds/1/break-out",
    ]);
    let without = ["/api/v1/farm", "/api/v1/builds/1", "/api/v1/orders/bracket.stl"];
    for address in asking.iter().map(String::as_str).chain(pages.copied()).chain(without) {
        assert_eq!(dashboard.get(address).await.status, StatusCode::OK, "{address}");
        for name in ["profile", "machne"] {
            let refused = dashboard.get(&format!("{address}?{name}=cube")).await;
            assert_eq!(refused.status, StatusCode::BAD_REQUEST, "{address}?{name}");
            assert!(refused.text.contains(name), "{address}: {}", refused.text);
        }
    }
    for address in ["/parts", "/history", "/api/v1/plan", "/api/v1/builds"] {
        let refused = dashboard.get(&format!("{address}?profile=cube")).await.text;
        assert!(refused.contains("'machine' now") || refused.contains("&#39;machine&#39; now"), "{address}: {refused}");
    }
    let twice = dashboard.get("/api/v1/plan?machine=a&machine=b").await;
    assert!(twice.status == StatusCode::BAD_REQUEST && twice.text.contains("machine"), "{}", twice.text);
}
