//! Which requests the dashboard answers.

use access::Role;
use axum::http::{HeaderMap, HeaderName, HeaderValue};
use farm::ServicePhase;

use super::*;
use crate::web::clients::client::{ON_BEHALF, RequestClient, SignInWay, SignedIn};

#[tokio::test]
async fn another_name_of_this_machine_is_not_answered_to_unless_it_is_configured() {
    let dashboard = TestDashboard::new(|web| web.hosts = vec!["farm.example.org".to_owned()]).await;
    let ask = async |host: &str| {
        let request = Request::get("/").header("host", host).body(Body::empty()).unwrap();
        dashboard.send(request).await.status
    };
    assert_eq!(ask("evil.example.com").await, StatusCode::MISDIRECTED_REQUEST);
    assert_eq!(ask("localhost.evil.example.com:7878").await, StatusCode::MISDIRECTED_REQUEST);
    for own in
        ["localhost", "LocalHost:80", "127.0.0.1:7878", "[::1]", "[::1]:7878", "farm.example.org", "Farm.Example.Org:1"]
    {
        assert_eq!(ask(own).await, StatusCode::OK, "{own}");
    }
    let hostile = [
        "",
        ":",
        ":80",
        "[::1].evil",
        "[::1].evil:7878",
        "[::1]evil",
        "[::1]:evil",
        "[::1]:80:80",
        "[::1",
        "::1",
        "[localhost.evil]",
        "[]",
        "localhost:evil.example.com",
        "localhost:",
        "localhost:80:80",
        "localhost:-1",
        "localhost:+80",
        "localhost:65536",
        "localhost.evil",
        "evil@localhost",
        "localhost@evil",
        "localhost/evil",
        "localhost,evil",
        "localhost evil",
        "localhost.",
        "127.0.0.1.evil",
        "127.1",
        "2130706433",
        "0",
        "0.0.0.0",
        "[::]",
        "[::ffff:127.0.0.1]",
        "farm.example.org.evil",
        "xfarm.example.org",
    ];
    for host in hostile {
        assert_eq!(ask(host).await, StatusCode::MISDIRECTED_REQUEST, "{host:?}");
    }
    for second in ["evil.example.com", "localhost"] {
        let twice = Request::get("/").header("host", "localhost").header("host", second).body(Body::empty()).unwrap();
        assert_eq!(dashboard.send(twice).await.status, StatusCode::MISDIRECTED_REQUEST, "two hosts say nothing");
    }
    let none = Request::get("/").body(Body::empty()).unwrap();
    assert_eq!(dashboard.send(none).await.status, StatusCode::MISDIRECTED_REQUEST);
}

#[tokio::test]
async fn with_a_token_nothing_but_the_sign_of_life_is_shown_without_it() {
    let dashboard = TestDashboard::new(|web| web.clients.token = Some("a-token-of-some-length".to_owned())).await;
    let ask = async |given: &str| {
        let request = Request::get("/").header("host", "farm").header("authorization", given);
        dashboard.send(request.body(Body::empty()).unwrap()).await.status
    };
    assert_eq!(ask("Bearer a-token-of-some-lengtH").await, StatusCode::UNAUTHORIZED);
    assert_eq!(ask("Basic x").await, StatusCode::UNAUTHORIZED);
    assert_eq!(ask("Bearer a-token-of-some-length").await, StatusCode::OK);
    for path in ["/metrics", "/help", "/help/symptoms"] {
        assert_eq!(dashboard.get(path).await.status, StatusCode::UNAUTHORIZED, "{path}");
    }
    assert_eq!(dashboard.get("/healthz").await.status, StatusCode::OK);
}

#[tokio::test]
async fn another_node_asks_in_the_name_of_a_person_and_nobody_else_can() {
    let (secret, token) = ("the-secret-of-the-nodes", "a-token-of-some-length");
    let dashboard = TestDashboard::new(|web| {
        (web.clients.node_secret, web.clients.token) = (secret.to_owned(), Some(token.to_owned()));
    })
    .await;
    let person = |role: Role| {
        let ann = SignedIn { name: "Änn".to_owned(), way: SignInWay::Password, is_shared: false };
        RequestClient::of_person(ann, role).to_header("Änn@dashboard").unwrap()
    };
    let ask = async |(name, value): (&str, &str), path: &str, named: HeaderValue| {
        let request = Request::get(path).header("host", "farm").header(name, value).header(ON_BEHALF, named);
        dashboard.send(request.body(Body::empty()).unwrap()).await
    };
    assert_eq!(ask(("nestd-node", secret), "/", person(Role::Read)).await.status, StatusCode::OK);
    assert_eq!(ask(("nestd-node", "another"), "/", person(Role::Read)).await.status, StatusCode::UNAUTHORIZED);
    // Not even a node is an admin, and who has the token of the farm is nobody else by it.
    let bearer = format!("Bearer {token}");
    for sender in [("nestd-node", secret), ("authorization", bearer.as_str())] {
        let refused = ask(sender, "/people", person(Role::Admin)).await;
        assert_eq!(refused.status, StatusCode::FORBIDDEN, "{}", refused.text);
    }
    let unknown = HeaderValue::from_static("bm90aGluZw==");
    assert_eq!(ask(("nestd-node", secret), "/", unknown).await.status, StatusCode::BAD_REQUEST);
    let headers = HeaderMap::from_iter([
        (HeaderName::from_static("nestd-node"), HeaderValue::from_static(secret)),
        (ON_BEHALF, person(Role::Order)),
    ]);
    let client = dashboard.web.clients.identify_node(&headers).ok().flatten().unwrap();
    assert_eq!((client.key_name(), client.passed_on_for), ("Änn@dashboard".into(), Some("Änn@dashboard".into())));
}

#[tokio::test]
async fn an_order_is_taken_from_our_own_pages_only() {
    let dashboard = TestDashboard::new(|_| ()).await;
    let flush = "key=key&kind=flush&machine=cube";
    assert_eq!(dashboard.post(flush, "cross-site").await.status, StatusCode::FORBIDDEN);
    assert_eq!(dashboard.post("key=wrong&kind=flush&machine=cube", "same-origin").await.status, StatusCode::FORBIDDEN);
    assert_eq!(dashboard.post("key=key&kind=flush&machine=other", "same-origin").await.status, StatusCode::NOT_FOUND);
    assert!(dashboard.ledger.pending_commands().await.unwrap().is_empty());
    let ledger = (*dashboard.ledger).clone();
    let daemon = tokio::spawn(async move {
        loop {
            if let Some(order) = ledger.pending_commands().await.unwrap().first() {
                ledger.answer_command(order.id, true, "done").await.unwrap();
                return (order.kind, order.machine.clone(), order.asked_by.clone());
            }
            tokio::time::sleep(std::time::Duration::from_millis(5)).await;
        }
    });
    assert_eq!(dashboard.post(flush, "same-origin").await.status, StatusCode::SEE_OTHER);
    let (kind, machine, by) = daemon.await.unwrap();
    assert_eq!((kind, machine.as_str(), by.as_str()), (ledger::CommandKind::Flush, "cube", "dashboard"));
    let silent = TestDashboard::new(|web| web.orders = false).await;
    assert_eq!(silent.post(flush, "same-origin").await.status, StatusCode::FORBIDDEN);
    assert!(!silent.get("/").await.text.contains("<form class=\"order\""), "no buttons where there are no orders");
}

#[tokio::test]
async fn a_command_of_a_page_is_of_the_user_whom_the_proxy_names() {
    let dashboard = TestDashboard::new(|web| {
        let header = "x-remote-user".parse().unwrap();
        web.proxy = Some(crate::web::base::client_gate::ProxyHeader { header, from: Vec::new() });
    })
    .await;
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
    let local = crate::web::base::connection_limits::RequestInProgress::of_client("127.0.0.1");
    let request =
        Request::post("/commands").header("x-remote-user", "ann").extension(axum::extract::ConnectInfo(local));
    let answer = dashboard.send_form(request, "key=key&kind=flush&machine=cube").await;
    assert_eq!(answer.status, StatusCode::SEE_OTHER);
    assert_eq!(daemon.await.unwrap(), "ann@dashboard");
}

#[tokio::test]
async fn over_plain_http_an_order_of_another_sites_page_is_known_by_its_origin() {
    let dashboard = TestDashboard::new(|web| web.hosts = vec!["farm.example.org".to_owned()]).await;
    let ask = async |host: &str, headers: &[(&str, &str)]| {
        let mut request = Request::post("/commands").header("host", host);
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        let form = request.header("content-type", "application/x-www-form-urlencoded");
        // An accepted command names a machine that does not exist.
        let body = Body::from(dashboard.with_key("key=key&kind=flush&machine=other"));
        dashboard.send(form.body(body).unwrap()).await.status
    };
    let (own, here) = ("http://farm.example.org", "farm.example.org");
    for other in ["http://evil.example.com", "null", "http://farm.example.org.evil.com", "http://farm.example.org:81"] {
        assert_eq!(ask(here, &[("origin", other)]).await, StatusCode::FORBIDDEN, "{other}");
    }
    assert_eq!(ask(here, &[("referer", "http://evil.example.com/farm.example.org")]).await, StatusCode::FORBIDDEN);
    assert_eq!(ask("localhost:7878", &[("origin", "http://localhost:3000")]).await, StatusCode::FORBIDDEN);
    for headers in [&[("origin", own)][..], &[("referer", "http://farm.example.org/builds/1?a#b")], &[]] {
        assert_eq!(ask(here, headers).await, StatusCode::NOT_FOUND, "{headers:?}");
    }
    assert_eq!(ask("localhost:7878", &[("origin", "http://localhost:7878")]).await, StatusCode::NOT_FOUND);
    assert_eq!(ask("127.0.0.1:7878", &[("origin", "https://farm.example.org")]).await, StatusCode::NOT_FOUND);
}

#[tokio::test]
async fn pages_that_listen_for_changes_leave_room_for_those_that_ask() {
    let dashboard = TestDashboard::new(|_| ()).await;
    let listening: Vec<_> =
        (0..crate::web::pages::live::MAX_LISTENERS).map(|_| dashboard.web.changes.subscribe()).collect();
    assert_eq!(dashboard.get("/live").await.status, StatusCode::TOO_MANY_REQUESTS);
    drop(listening);
    let request = Request::get("/live").header("host", "localhost").body(Body::empty()).unwrap();
    assert_eq!(build_router(dashboard.web.clone()).oneshot(request).await.unwrap().status(), StatusCode::OK);
}

#[tokio::test]
async fn pages_of_other_sites_get_nothing_but_links_that_a_person_follows() {
    let dashboard = with_a_build("bracket.stl").await;
    let ask = async |method: &str, headers: &[(&str, &str)]| {
        let mut request = Request::builder().method(method).uri("/builds/1/scene").header("host", "localhost:7878");
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        let request = request.body(Body::empty()).unwrap();
        build_router(dashboard.web.clone()).oneshot(request).await.unwrap()
    };
    let link = [("sec-fetch-site", "cross-site"), ("sec-fetch-mode", "navigate"), ("sec-fetch-dest", "document")];
    let program: [(&str, &str); 0] = [];
    let own = [("sec-fetch-site", "same-origin"), ("sec-fetch-mode", "cors"), ("sec-fetch-dest", "empty")];
    for headers in [&program[..], &own, &[("sec-fetch-site", "none")], &link, &link[..2]] {
        let answer = ask("GET", headers).await;
        assert_eq!(answer.status(), StatusCode::OK, "{headers:?}");
        assert_eq!(answer.headers()["cross-origin-resource-policy"], "same-origin");
    }
    for site in ["cross-site", "same-site"] {
        for headers in [
            &[("sec-fetch-mode", "no-cors"), ("sec-fetch-dest", "image")][..],
            &[("sec-fetch-mode", "cors"), ("sec-fetch-dest", "empty")],
            &[("sec-fetch-mode", "navigate"), ("sec-fetch-dest", "iframe")],
            &[("sec-fetch-mode", "navigate"), ("sec-fetch-dest", "document"), ("sec-purpose", "prefetch;prerender")],
            &[],
        ] {
            let headers: Vec<_> = [("sec-fetch-site", site)].into_iter().chain(headers.iter().copied()).collect();
            let answer = ask("GET", &headers).await;
            assert_eq!(answer.status(), StatusCode::FORBIDDEN, "{headers:?}");
            assert_eq!(answer.headers()["cross-origin-resource-policy"], "same-origin");
        }
    }
    assert_eq!(ask("HEAD", &link).await.status(), StatusCode::FORBIDDEN);
    assert_eq!(dashboard.get("/").await.status, StatusCode::OK);
}

#[tokio::test]
async fn of_a_farm_that_has_halted_every_page_says_why_and_takes_nothing() {
    let why = "The ledger was overwritten: put the newest backup back with `nestd restore FILE`.";
    let dashboard = TestDashboard::new(|web| web.farm.set_phase(ServicePhase::Halted(why.to_owned()))).await;
    for path in ["/", "/history", "/orders", "/api/v1/orders", "/readyz", "/metrics"] {
        let answer = dashboard.get(path).await;
        assert_eq!(answer.status, StatusCode::SERVICE_UNAVAILABLE, "{path}");
        assert!(answer.text.contains("put the newest backup back"), "{path}: {}", answer.text);
    }
    // What helps then can be read.
    for path in ["/healthz", "/help", "/help/symptoms"] {
        assert_eq!(dashboard.get(path).await.status, StatusCode::OK, "{path}");
    }
    let pause = dashboard.post("key=key&kind=pause&machine=cube", "same-origin").await;
    assert_eq!(pause.status, StatusCode::SERVICE_UNAVAILABLE);
    assert!(dashboard.ledger.pending_commands().await.unwrap().is_empty());
}
