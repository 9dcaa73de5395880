//! PINs at shared devices, what people change for themselves, and what an admin changes for others.

use super::*;

#[tokio::test]
async fn a_pin_is_enough_only_at_a_device_that_is_shared_and_not_to_say_who_else_may() {
    let dashboard = TestDashboard::with_people(|_| ()).await;
    dashboard.give_secrets("operate", None).await;
    dashboard.give_secrets("admin", Some("4711")).await;
    let with_pin =
        async |token: &str, pin: &str| dashboard.post_as("/sign-in/pin", token, &format!("name=admin&pin={pin}")).await;
    let own = dashboard.sign_in("operate", PASSWORD, "").await.token();
    for token in ["", "planted", &own] {
        let answer = with_pin(token, "4711").await;
        assert!(answer.status == StatusCode::FORBIDDEN && !answer.has_token(), "{}", answer.text);
        assert!(
            !dashboard.page("/sign-in", token).await.text.contains("value=\"admin\""),
            "nobody learns who has a PIN"
        );
    }
    let form = "name=operate&password=correct+horse+battery&shared=true";
    let device = dashboard.post_as("/sign-in", &own, form).await.token();
    assert!(dashboard.page("/sign-in", &device).await.text.contains("value=\"admin\""));
    assert_eq!(with_pin(&device, "1234").await.status, StatusCode::FORBIDDEN);
    let handed_on = with_pin(&device, "4711").await;
    assert_eq!(handed_on.status, StatusCode::SEE_OTHER);
    let admin = handed_on.token();
    assert_eq!(dashboard.page("/", &device).await.status, StatusCode::UNAUTHORIZED, "the token is a new one");
    assert_eq!(dashboard.page("/people", &admin).await.status, StatusCode::FORBIDDEN, "a PIN is short");
    assert_eq!(
        dashboard.post_as("/you", &admin, "key=key&what=pin&new=9021&again=9021").await.status,
        StatusCode::BAD_REQUEST
    );
    let nobody = dashboard.post_as("/sign-out", &admin, "").await.token();
    assert!(dashboard.page("/", &nobody).await.status == StatusCode::UNAUTHORIZED && !nobody.is_empty());
    let again = with_pin(&nobody, "4711").await.token();
    for wrong in 1..=5 {
        let answer = with_pin(&again, "0815").await;
        assert!(answer.status == StatusCode::FORBIDDEN, "{wrong}");
    }
    assert_eq!(dashboard.page("/", &again).await.status, StatusCode::UNAUTHORIZED, "the device needs a password again");
}

#[tokio::test]
async fn people_change_their_own_secrets_with_their_password_and_other_devices_are_signed_out() {
    let dashboard = TestDashboard::with_people(|_| ()).await;
    dashboard.give_secrets("order", None).await;
    let (here, there) = (
        dashboard.sign_in("order", PASSWORD, "").await.token(),
        dashboard.sign_in("order", PASSWORD, "").await.token(),
    );
    let new = "another+long+password";
    let change = async |current: &str, again: &str| {
        let body = format!("key=key&what=password&current={current}&new={new}&again={again}");
        dashboard.post_as("/you", &here, &body).await
    };
    assert_eq!(change("wrong", new).await.status, StatusCode::BAD_REQUEST);
    assert_eq!(change("correct+horse+battery", "else").await.status, StatusCode::BAD_REQUEST);
    let changed = change("correct+horse+battery", new).await;
    assert_eq!((changed.status, changed.location()), (StatusCode::SEE_OTHER, "/you?done=password"));
    let renewed = changed.token();
    for token in [&here, &there] {
        assert_eq!(dashboard.page("/", token).await.status, StatusCode::UNAUTHORIZED);
    }
    let page = dashboard.page("/you?done=password", &renewed).await;
    assert!(page.status == StatusCode::OK && page.text.contains("Your password is changed"), "{}", page.text);
    assert_eq!(dashboard.sign_in("order", PASSWORD, "").await.status, StatusCode::FORBIDDEN);
    assert!(dashboard.sign_in("order", "another long password", "").await.has_token());
    let everywhere = dashboard.post_as("/you", &renewed, "key=key&what=everywhere").await.token();
    assert_eq!(dashboard.page("/", &renewed).await.status, StatusCode::UNAUTHORIZED);
    assert_eq!(dashboard.page("/", &everywhere).await.status, StatusCode::OK);
}

#[tokio::test]
async fn an_admin_says_who_may_sign_in_and_locks_not_himself_out() {
    let dashboard = TestDashboard::with_people(|_| ()).await;
    let act = async |body: &str| dashboard.post_as("/people", "admin", &format!("key=key&{body}")).await;
    assert_eq!(act("act=add&name=Jörg+Maier&role=order&password=ein+langes+Wort").await.status, StatusCode::SEE_OTHER);
    let added = dashboard.ledger.find_person("jörg maier").await.unwrap().unwrap();
    assert_eq!((added.role, added.added_by.as_str(), added.has_password), (Role::Order, "admin@dashboard", true));
    for (refused, why) in [
        ("act=add&name=jörg+maier&role=read&password=", "already"),
        ("act=add&name=<b>&role=read&password=", "letters, digits"),
        ("act=add&name=x&role=read&password=short", "10 to 200"),
        ("act=password&name=read&password=", "10 to 200"),
        ("act=role&name=Admin&role=read", "own role"),
        ("act=remove&name=admin", "own role"),
        ("act=remove&name=nobody", "person named nobody"),
    ] {
        let answer = act(refused).await;
        assert!(answer.status.is_client_error() && answer.text.contains(why), "{refused}: {}", answer.text);
    }
    assert_eq!(act("act=role&name=read&role=operate").await.status, StatusCode::SEE_OTHER);
    assert_eq!(dashboard.ledger.find_person("read").await.unwrap().unwrap().role, Role::Operate);
    assert_eq!(act("act=sign-out&name=order").await.status, StatusCode::SEE_OTHER);
    assert_eq!(dashboard.page("/", "order").await.status, StatusCode::UNAUTHORIZED);
    assert_eq!(act("act=remove&name=operate").await.status, StatusCode::SEE_OTHER);
    assert_eq!(dashboard.page("/", "operate").await.status, StatusCode::UNAUTHORIZED);
    let page = dashboard.page("/people", "admin").await.text;
    assert!(page.contains("Jörg Maier") && !page.contains("argon2"), "{page}");
}
