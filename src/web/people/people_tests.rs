//! Who may ask what, as people and as hostile clients; and that who did something is who was signed in.

use access::{PasswordHash, Role, hash_token};
use axum::{
    extract::ConnectInfo,
    http::{HeaderMap, Method, request::Builder},
};

use super::*;
use crate::web::{
    base::{client_gate::ProxyHeader, connection_limits::RequestInProgress},
    doors::{api_route::is_path_of, api_routes},
    pages::live::is_stream_of_changes,
    serve::page_routes,
};

#[path = "account_tests.rs"]
mod account_tests;

const PASSWORD: &str = "correct horse battery";
const FORM: &str = "application/x-www-form-urlencoded";

struct Answer {
    status: StatusCode,
    headers: HeaderMap,
    text: String,
}

impl Answer {
    /// The token in the cookie that it sets; "" = it takes the cookie away.
    fn token(&self) -> String {
        let cookies = self.headers.get_all("set-cookie").iter().map(|value| value.to_str().unwrap());
        let cookie = cookies.into_iter().find(|cookie| cookie.starts_with("nestd_session=")).expect("a session");
        assert!(
            cookie.contains("; HttpOnly") && cookie.contains("; SameSite=Lax") && cookie.contains("; Path=/"),
            "{cookie}"
        );
        cookie.split(['=', ';']).nth(1).unwrap().to_owned()
    }

    fn has_token(&self) -> bool {
        self.headers.contains_key("set-cookie")
    }

    fn location(&self) -> &str {
        self.headers.get("location").map_or("", |to| to.to_str().unwrap())
    }
}

impl TestDashboard {
    /// A farm with a person of each role, named like it; each has a session with the token of that name.
    async fn with_people(change: impl FnOnce(&mut DashboardState)) -> Self {
        let dashboard = Self::new(change).await;
        for role in Role::ALL {
            let name = role.as_str();
            dashboard.ledger.add_person(name, role, &PasswordHash::default(), "op@host").await.unwrap();
            dashboard.ledger.open_session(&hash_token(name), name, false, "").await.unwrap();
        }
        dashboard
    }

    /// Gives a person a password, and perhaps a PIN.
    async fn give_secrets(&self, name: &str, pin: Option<&str>) {
        let password = ledger::PersonChange::Password(PasswordHash::of(PASSWORD).unwrap());
        self.ledger.change_person(name, &password, "op@host").await.unwrap();
        if let Some(pin) = pin {
            let pin = ledger::PersonChange::Pin(PasswordHash::of(pin).unwrap());
            self.ledger.change_person(name, &pin, "op@host").await.unwrap();
        }
    }

    async fn answer(&self, request: Builder, token: &str, from: &str, body: &str) -> Answer {
        let request = request.header("host", "localhost").header("content-type", FORM);
        let request =
            if token.is_empty() { request } else { request.header("cookie", format!("nestd_session={token}")) };
        let mut request = request.body(Body::from(self.with_key(body))).unwrap();
        request.extensions_mut().insert(ConnectInfo(RequestInProgress::of_client(from)));
        let is_endless = is_stream_of_changes(request.uri().path());
        let answer = build_router(self.web.clone()).oneshot(request).await.unwrap();
        let (status, headers) = (answer.status(), answer.headers().clone());
        let bytes =
            if is_endless { Default::default() } else { to_bytes(answer.into_body(), usize::MAX).await.unwrap() };
        Answer { status, headers, text: String::from_utf8_lossy(&bytes).into_owned() }
    }

    async fn page(&self, path: &str, token: &str) -> Answer {
        self.answer(Request::get(path), token, "10.0.0.7", "").await
    }

    async fn post_as(&self, path: &str, token: &str, body: &str) -> Answer {
        self.answer(Request::post(path), token, "10.0.0.7", body).await
    }

    async fn sign_in(&self, name: &str, password: &str, former: &str) -> Answer {
        let password = password.replace(' ', "+");
        self.post_as("/sign-in", former, &format!("name={name}&password={password}&to=/orders")).await
    }
}

/// Every address with its method and the role that it needs: from the tables of which the router is made.
fn all_addresses() -> Vec<(Method, String, Option<Role>)> {
    let pages = page_routes::PAGES.iter().map(|route| (route.method, route.path, route.role));
    let doors = api_routes::all_routes().map(|route| (route.method, route.path, Some(route.role)));
    let all = pages.chain(doors).chain([("GET", "/api/v1/openapi.json", Some(Role::Read))]);
    let filled = |step: &str| match step {
        "{build}" | "{part}" | "{line}" => "1".to_owned(),
        "{machine}" => "cube".to_owned(),
        "{hash}" => "0".repeat(64),
        step => step.trim_matches(['{', '}']).to_owned(),
    };
    all.map(|(method, path, role)| {
        let path = path.split('/').map(filled).collect::<Vec<_>>().join("/");
        (Method::from_bytes(method.as_bytes()).unwrap(), path, role)
    })
    .collect()
}

#[tokio::test]
async fn every_address_answers_the_roles_that_may_ask_and_no_other() {
    // Nothing is carried out, so that each may be asked for everything.
    let dashboard = TestDashboard::with_people(|web| web.orders = false).await;
    let addresses = all_addresses();
    assert!(addresses.len() > 80 && addresses.iter().filter(|(_, _, role)| role.is_none()).count() == 6);
    for (method, path, needed) in &addresses {
        let request = || Request::builder().method(method.clone()).uri(path);
        for role in Role::ALL {
            // One of the addresses signs out.
            let hash = hash_token(role.as_str());
            dashboard.ledger.open_session(&hash, role.as_str(), false, &hash).await.unwrap();
            let answer = dashboard.answer(request(), role.as_str(), "10.0.0.7", "").await;
            let is_refused =
                answer.status == StatusCode::FORBIDDEN && answer.text.to_lowercase().contains("this needs the role");
            let may = needed.is_none_or(|needed| role >= needed);
            assert_eq!(is_refused, !may, "{method} {path} as {role:?}: {} {}", answer.status, answer.text);
            assert!(answer.status != StatusCode::UNAUTHORIZED, "{method} {path} as {role:?}");
        }
        for token in ["", "nonsense"] {
            let answer = dashboard.answer(request(), token, "10.0.0.7", "").await;
            assert_eq!(answer.status == StatusCode::UNAUTHORIZED, needed.is_some(), "{method} {path} as nobody");
            // The form leads back to what was asked for.
            let told = answer.text.replace(path.as_str(), "");
            assert!(!told.contains("cube"), "{method} {path} tells nobody anything: {told}");
        }
    }
    let program = dashboard.page("/api/v1/farm", "").await;
    assert!(program.text.contains("you are not signed in") && program.headers["www-authenticate"] == "Bearer");
    let page = dashboard.page("/orders?customer=x", "").await;
    assert!(
        page.text.contains("action=\"/sign-in\"") && page.text.contains("value=\"/orders?customer=x\""),
        "{}",
        page.text
    );
    let form = dashboard.post_as("/commands", "", "key=key&kind=flush&machine=cube").await;
    assert!(form.status == StatusCode::UNAUTHORIZED && !form.text.contains("action=\"/sign-in\""));
}

#[tokio::test]
async fn without_people_nobody_is_asked_and_with_sign_in_set_everybody_is() {
    let dashboard = TestDashboard::new(|_| ()).await;
    let page = dashboard.page("/", "").await;
    assert!(
        page.status == StatusCode::OK && !page.text.contains("/sign-in") && !page.text.contains("/you"),
        "{}",
        page.text
    );
    assert_eq!(
        dashboard.page("/people", "").await.status,
        StatusCode::FORBIDDEN,
        "the first one is added on the server"
    );
    assert_eq!(dashboard.sign_in("anna", PASSWORD, "").await.status, StatusCode::FORBIDDEN);
    let closed = TestDashboard::new(|web| web.clients.sign_in = true).await;
    let page = closed.page("/", "").await;
    assert!(page.status == StatusCode::UNAUTHORIZED && page.text.contains("nestd people add NAME --role admin"));
    let seen = TestDashboard::with_people(|web| web.clients.without_token = Some(Role::Read)).await;
    let page = seen.page("/", "").await;
    assert!(page.status == StatusCode::OK && page.text.contains("href=\"/sign-in\""), "{}", page.text);
    assert_eq!(seen.post_as("/commands", "", "key=key&kind=flush&machine=cube").await.status, StatusCode::FORBIDDEN);
}

#[tokio::test]
async fn every_sign_in_makes_a_new_token_and_one_that_was_planted_or_stands_in_a_link_is_worth_nothing() {
    let dashboard = TestDashboard::with_people(|_| ()).await;
    dashboard.give_secrets("operate", None).await;
    let first = dashboard.sign_in("Operate", PASSWORD, "planted").await;
    assert_eq!((first.status, first.location()), (StatusCode::SEE_OTHER, "/orders"));
    let token = first.token();
    assert!(token.len() == 64 && token != "planted");
    assert_eq!(dashboard.page("/", "planted").await.status, StatusCode::UNAUTHORIZED);
    let page = dashboard.page("/", &token).await;
    assert!(page.status == StatusCode::OK && page.text.contains("href=\"/you\""), "{}", page.text);
    let second = dashboard.sign_in("operate", PASSWORD, &token).await.token();
    assert_eq!(dashboard.page("/", &token).await.status, StatusCode::UNAUTHORIZED, "the browser has the new one");
    for link in [format!("/?nestd_session={second}"), format!("/?token={second}"), format!("/?access_token={second}")] {
        assert_eq!(dashboard.page(&link, "").await.status, StatusCode::UNAUTHORIZED, "{link}");
    }
    let bearer = Request::get("/").header("authorization", format!("Bearer {second}"));
    assert_eq!(dashboard.answer(bearer, "", "10.0.0.7", "").await.status, StatusCode::UNAUTHORIZED);
    let hash = hash_token(&second);
    assert_eq!(dashboard.page("/", &hash).await.status, StatusCode::UNAUTHORIZED, "who read the ledger has no token");
    for to in
        ["//evil.example.com", "https://evil.example.com/", "/%5Cevil.example.com", "/%09/evil.example.com", "orders"]
    {
        let answer =
            dashboard.post_as("/sign-in", "", &format!("name=operate&password=correct+horse+battery&to={to}")).await;
        assert_eq!((answer.status, answer.location()), (StatusCode::SEE_OTHER, "/"), "{to}");
    }
    let encrypted = Request::post("/sign-in").header("origin", "https://localhost");
    let answer = dashboard.answer(encrypted, "", "10.0.0.7", "name=operate&password=correct+horse+battery").await;
    assert!(answer.headers["set-cookie"].to_str().unwrap().ends_with("; Secure"));
    let out = dashboard.post_as("/sign-out", &second, "").await;
    assert!(out.token().is_empty() && out.location() == "/sign-in");
    assert_eq!(dashboard.page("/", &second).await.status, StatusCode::UNAUTHORIZED);
}

#[tokio::test]
async fn pages_of_other_sites_sign_nobody_in_or_out() {
    let dashboard = TestDashboard::with_people(|_| ()).await;
    dashboard.give_secrets("read", None).await;
    for (name, value) in [("origin", "http://evil.example.com"), ("sec-fetch-site", "cross-site"), ("origin", "null")] {
        for (path, body) in
            [("/sign-in", "name=read&password=correct+horse+battery"), ("/sign-out", ""), ("/sign-in/pin", "")]
        {
            let answer = dashboard.answer(Request::post(path).header(name, value), "admin", "10.0.0.7", body).await;
            assert!(answer.status == StatusCode::FORBIDDEN && !answer.has_token(), "{path} {name}: {value}");
        }
    }
    assert_eq!(dashboard.page("/people", "admin").await.status, StatusCode::OK);
    let add = "act=add&name=mallory&role=admin&password=mallorys+password";
    for body in [add.to_owned(), format!("key=planted&{add}")] {
        assert_eq!(dashboard.post_as("/people", "admin", &body).await.status, StatusCode::FORBIDDEN, "{body}");
    }
    assert_eq!(dashboard.post_as("/people", "operate", &format!("key=key&{add}")).await.status, StatusCode::FORBIDDEN);
    assert!(dashboard.ledger.find_person("mallory").await.unwrap().is_none());
}

#[tokio::test]
async fn wrong_passwords_are_answered_alike_and_soon_not_at_all() {
    let dashboard = TestDashboard::with_people(|_| ()).await;
    dashboard.give_secrets("operate", None).await;
    let (known, unknown) = (dashboard.sign_in("order", "x", "").await, dashboard.sign_in("nobody", "x", "").await);
    let said = |answer: &Answer| answer.text.split("<main").nth(1).unwrap().replace("order", "").replace("nobody", "");
    assert_eq!((known.status, said(&known).len()), (StatusCode::FORBIDDEN, said(&unknown).len()));
    assert!(known.text.contains("Name or password is wrong.") && !known.has_token());
    for _ in 0..5 {
        assert_eq!(dashboard.sign_in("operate", "wrong", "").await.status, StatusCode::FORBIDDEN);
    }
    let right = dashboard.sign_in("OPERATE", PASSWORD, "").await;
    assert_eq!(right.status, StatusCode::TOO_MANY_REQUESTS, "in whatever case the name is written");
    assert!(
        right.text.contains("wait 15 minutes")
            && right.headers["retry-after"].to_str().unwrap().parse::<u32>().unwrap() > 800
    );
    assert_eq!(dashboard.page("/", "order").await.status, StatusCode::OK, "who is signed in does not notice");
}

#[tokio::test]
async fn a_proxy_is_believed_from_its_address_only_and_names_only_who_is_known() {
    let proxy = |from: &[&str]| {
        let from = from.iter().map(|address| address.parse().unwrap()).collect();
        Some(ProxyHeader { header: "x-remote-user".parse().unwrap(), from })
    };
    let named = |names: &[&str]| {
        names.iter().fold(Request::get("/people"), |request, name| request.header("x-remote-user", *name))
    };
    for (trusted, from, other) in [(&[][..], "127.0.0.1", "10.0.0.5"), (&["10.0.0.5"][..], "10.0.0.5", "127.0.0.1")] {
        let dashboard = TestDashboard::with_people(|web| web.proxy = proxy(trusted)).await;
        let ask = async |names: &[&str], from: &str| dashboard.answer(named(names), "", from, "").await.status;
        assert_eq!(ask(&["ADMIN"], from).await, StatusCode::OK);
        assert_eq!(ask(&["operate"], from).await, StatusCode::FORBIDDEN, "the role is that of the person");
        for hostile in [other, "10.0.0.50", "::1%lo", ""] {
            assert_eq!(ask(&["admin"], hostile).await, StatusCode::UNAUTHORIZED, "{hostile}");
        }
        assert_eq!(ask(&["admin", "read"], from).await, StatusCode::UNAUTHORIZED, "one of two may be the client's own");
        let unknown = dashboard.answer(named(&["mallory"]), "", from, "").await;
        assert!(
            unknown.status == StatusCode::FORBIDDEN && unknown.text.contains("nestd people add"),
            "{}",
            unknown.text
        );
    }
}

#[tokio::test]
async fn pages_show_each_person_the_forms_that_the_role_allows() {
    let dashboard = with_a_build("bracket.stl").await;
    let forms = async |path: &str, role: Role| {
        let text = dashboard.page(path, role.as_str()).await.text;
        let posts =
            text.split("<form").skip(1).filter(|form| form.split('>').next().unwrap().contains("method=\"post\""));
        let actions = posts.map(|form| form.split("action=\"").nth(1).unwrap().split('"').next().unwrap().to_owned());
        actions.collect::<Vec<_>>()
    };
    for role in Role::ALL {
        dashboard.ledger.add_person(role.as_str(), role, &PasswordHash::default(), "op@host").await.unwrap();
        dashboard.ledger.open_session(&hash_token(role.as_str()), role.as_str(), false, "").await.unwrap();
    }
    let mut shown = [0; 4];
    for path in PAGES {
        for (at, role) in Role::ALL.into_iter().enumerate() {
            for action in forms(path, role).await {
                let routes = page_routes::PAGES.iter().filter(|route| route.method == "POST");
                let needed = routes.filter(|route| is_path_of(route.path, &action)).find_map(|route| route.role);
                if let Some(needed) = needed {
                    assert!(role >= needed, "{path} shows {role:?} a form for {action}");
                    shown[at] += 1;
                }
            }
        }
    }
    assert!(shown[0] == 0 && shown[1] > 0 && shown[2] > shown[1] && shown[3] == shown[2], "{shown:?}");
}

#[tokio::test]
async fn what_is_done_is_of_the_person_who_is_signed_in_whatever_else_the_browser_says() {
    let dashboard = TestDashboard::with_people(|_| ()).await;
    let ledger = (*dashboard.ledger).clone();
    let daemon = tokio::spawn(async move {
        loop {
            if let Some(order) = ledger.pending_commands().await.unwrap().first() {
                ledger.answer_command(order.id, true, "done").await.unwrap();
                return order.asked_by.clone();
            }
            tokio::time::sleep(std::time::Duration::from_millis(5)).await;
        }
    });
    let request = Request::post("/commands").header("x-remote-user", "mallory").header("cookie", "nestd_name=mallory");
    let answer = dashboard.answer(request, "operate", "127.0.0.1", "key=key&kind=flush&machine=cube").await;
    assert_eq!(answer.status, StatusCode::SEE_OTHER);
    assert_eq!(daemon.await.unwrap(), "operate@dashboard");
}

#[tokio::test]
async fn no_page_and_no_answer_to_a_program_has_anything_secret_in_it() {
    let dashboard = TestDashboard::with_people(|_| ()).await;
    dashboard.give_secrets("operate", Some("4711")).await;
    let token = dashboard.sign_in("operate", PASSWORD, "").await.token();
    let hash = hash_token("admin");
    let of_programs =
        ["/api/v1/events?after=0", "/api/v1/farm", "/api/v1/openapi.json", "/metrics", "/people", "/you", "/sign-in"];
    for path in PAGES.into_iter().chain(of_programs) {
        let text = dashboard.page(path, "admin").await.text;
        for secret in ["argon2id$", hash.as_str(), token.as_str(), PASSWORD] {
            assert!(!text.contains(secret), "{path} has {secret}");
        }
    }
}
