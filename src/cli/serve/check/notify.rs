//! Checks the receivers of messages: whether messages could be delivered.

use std::{
    fs,
    net::{TcpStream, ToSocketAddrs},
    os::unix::fs::PermissionsExt,
    time::Duration,
};

use settings::{EmailSettings, Settings, WebhookSettings};

use super::report::CheckReport;

/// A host that does not answer within this time gets a warning.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(3);

/// Checks the receivers that `[notify]` names.
pub fn check_receivers(settings: &Settings, report: &mut CheckReport) {
    if let Some(webhook) = &settings.interfaces.notify.webhook {
        check_secret(webhook, report);
        connect("webhook of [notify]", &host_and_port(&webhook.url), report);
    }
    if let Some(email) = &settings.interfaces.notify.email {
        check_mail_server(email, report);
    }
    if let Some([program, ..]) = settings.interfaces.notify.command.as_deref() {
        let what = "command of [notify]";
        match fs::metadata(program) {
            Ok(meta) if meta.is_file() && meta.permissions().mode() & 0o111 != 0 => report.add_ok(what, program),
            Ok(_) => report.add_problem(what, format!("{program} is no program"), "name a file that may be executed"),
            Err(error) => report.add_problem(what, format!("{program}: {error}"), "name a program that is there"),
        }
    }
}

/// Checks the password of the mail server, and connects to it.
fn check_mail_server(email: &EmailSettings, report: &mut CheckReport) {
    let what = "password of [notify.email]";
    match email.login.as_ref().map(|(_, file)| (file, access::read_password(file))) {
        None => {}
        Some((file, Ok(_))) => report.add_ok(what, file.display().to_string()),
        Some((_, Err(error))) => {
            let remedy = "make it a file that nestd's user may read and others may not, with the password";
            report.add_problem(what, format!("{:#}", anyhow::Error::from(error)), remedy);
        }
    }
    let host = if email.host.contains(':') { format!("[{}]", email.host) } else { email.host.clone() };
    connect("mail server of [notify]", &format!("{host}:{}", email.port), report);
}

fn check_secret(webhook: &WebhookSettings, report: &mut CheckReport) {
    let what = "secret of [notify]";
    match access::read_secret(&webhook.secret_file) {
        Ok(_) => report.add_ok(what, webhook.secret_file.display().to_string()),
        Err(error) => {
            let text = format!("{:#}", anyhow::Error::from(error));
            report.add_problem(
                what,
                text,
                "make it a file that nestd's user may read and others may not, with a long key",
            );
        }
    }
}

/// Connects to a host. One that is down now may be up later, so a failure is only a warning.
fn connect(what: &'static str, address: &str, report: &mut CheckReport) {
    let remedy = "see that the host is up and may be reached from here; under systemd see docs/integrator.md";
    let found = address.to_socket_addrs().map(Iterator::collect::<Vec<_>>);
    let tried =
        found.map(|all| all.iter().map(|one| TcpStream::connect_timeout(one, CONNECT_TIMEOUT)).collect::<Vec<_>>());
    match tried {
        Ok(tried) if tried.iter().any(Result::is_ok) => report.add_ok(what, format!("{address} answers")),
        Ok(tried) => {
            let why = tried.into_iter().find_map(Result::err).map(|error| error.to_string());
            report.add_warning(what, format!("{address} cannot be reached: {}", why.unwrap_or_default()), remedy);
        }
        Err(error) => report.add_warning(what, format!("{address} is not known: {error}"), remedy),
    }
}

/// Host and port of a URL.
fn host_and_port(url: &str) -> String {
    let (rest, port) = match url.strip_prefix("https://") {
        Some(rest) => (rest, 443),
        None => (url.strip_prefix("http://").unwrap_or(url), 80),
    };
    let host = rest.split(['/', '?', '#']).next().unwrap_or_default();
    let host = host.rsplit_once('@').map_or(host, |(_, host)| host);
    let has_port = host.rsplit_once(':').is_some_and(|(_, port)| port.parse::<u16>().is_ok());
    if has_port { host.to_owned() } else { format!("{host}:{port}") }
}

#[test]
fn host_and_port_of_a_webhook_are_found() {
    for (url, is) in [
        ("https://farm.example.org/hook", "farm.example.org:443"),
        ("http://10.0.0.1:8080/x?y", "10.0.0.1:8080"),
        ("http://user:pass@host", "host:80"),
        ("https://[::1]/", "[::1]:443"),
        ("https://[::1]:99/", "[::1]:99"),
    ] {
        assert_eq!(host_and_port(url), is, "{url}");
    }
}
