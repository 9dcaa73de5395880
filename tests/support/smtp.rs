//! A mail server on loopback that holds real SMTP conversations, and reads the mails that it gets.
#![allow(dead_code)] // no test program uses all of it

use std::{
    io::{self, BufRead, BufReader, Read, Write},
    net::{TcpListener, TcpStream},
    sync::{Arc, Mutex},
    thread,
    time::{Duration, Instant},
};

use base64::{Engine, prelude::BASE64_STANDARD};
use rustls::{
    ServerConfig, ServerConnection, StreamOwned,
    pki_types::{CertificateDer, PrivateKeyDer, pem::PemObject},
};

/// Certificate and key of `localhost`, for tests alone.
pub const CERTIFICATE: &str = "\
-----BEGIN CERTIFICATE-----
MIIBkjCCATigAwIBAgIUeG0LKArbmRFqevAq1oYkB31YNjgwCgYIKoZIzj0EAwIw
FDESMBAGA1UEAwwJbG9jYWxob3N0MCAXDTIwMDEwMTAwMDAwMFoYDzIxMTkxMjA4
MDAwMDAwWjAUMRIwEAYDVQQDDAlsb2NhbGhvc3QwWTATBgcqhkjOPQIBBggqhkjO
PQMBBwNCAASi9eU8fdvYAoyOhw3YUFdiz74hJwF3ZdhapyK+gkBwA5u0V91ilrGA
gmc1zWUAVjnglIUxdbO5aPZRxA7jTtEao2YwZDAdBgNVHQ4EFgQUSe2U1npKNNt+
8HhP1fqS22uBzfQwHwYDVR0jBBgwFoAUSe2U1npKNNt+8HhP1fqS22uBzfQwFAYD
VR0RBA0wC4IJbG9jYWxob3N0MAwGA1UdEwEB/wQCMAAwCgYIKoZIzj0EAwIDSAAw
RQIgHOEwJl5bgR+H2qTz2kYlDvsckuC2ZI8S9usnEE/JoXQCIQDj2/xB2Cy778o1
vUTLfP3EF1r4hh2KlJulAJo4B6fE8w==
-----END CERTIFICATE-----
";
const KEY: &str = "\
-----BEGIN PRIVATE KEY-----
MIGHAgEAMBMGByqGSM49AgEGCCqGSM49AwEHBG0wawIBAQQgQWvA04ObEuZylYHf
IXcnI2xGIuBApr4HPskra1mVe1ahRANCAASi9eU8fdvYAoyOhw3YUFdiz74hJwF3
ZdhapyK+gkBwA5u0V91ilrGAgmc1zWUAVjnglIUxdbO5aPZRxA7jTtEa
-----END PRIVATE KEY-----
";

/// How the server speaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Speech {
    /// In plain.
    Plain,
    /// In plain until it is told STARTTLS; before that it takes nothing.
    Starttls,
    /// Encrypted from the first byte.
    Tls,
}

/// A connection, encrypted or not.
trait Wire: Read + Write + Send {}
impl<T: Read + Write + Send> Wire for T {}

/// One mail that the server has taken.
#[derive(Debug, Clone, Default)]
pub struct ReceivedMail {
    /// The sender of the envelope.
    pub from: String,
    /// The recipients of the envelope.
    pub to: Vec<String>,
    /// Names in lower case, and values, unfolded and decoded.
    pub headers: Vec<(String, String)>,
    /// The text, decoded.
    pub text: String,
    /// User and password, if somebody signed in.
    pub login: Option<(String, String)>,
}

impl ReceivedMail {
    pub fn header(&self, name: &str) -> &str {
        self.headers.iter().find(|(n, _)| n == name).map(|(_, value)| value.as_str()).unwrap_or_default()
    }
}

#[derive(Default)]
struct MailState {
    taken: Vec<ReceivedMail>,
    /// The next answers to a recipient, last first; then 250.
    answers: Vec<u16>,
    /// Recipients that are refused for ever.
    unknown: Vec<String>,
    refusals: usize,
}

/// The server; it runs until the test ends.
#[derive(Clone)]
pub struct TestMailServer {
    inner: Arc<Mutex<MailState>>,
    /// `127.0.0.1:port`.
    pub address: String,
}

impl TestMailServer {
    /// A server that answers recipients with these codes in order, and then takes them, save the unknown ones.
    pub fn with_answers(answers: &[u16], unknown: &[&str]) -> Self {
        Self::speaking(Speech::Plain, answers, unknown)
    }

    /// Same as [`TestMailServer::with_answers`], encrypted or not.
    pub fn speaking(speech: Speech, answers: &[u16], unknown: &[&str]) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let state = MailState {
            answers: answers.iter().rev().copied().collect(),
            unknown: unknown.iter().map(|one| (*one).to_owned()).collect(),
            ..MailState::default()
        };
        let server = Self { inner: Arc::new(Mutex::new(state)), address };
        let inner = server.inner.clone();
        thread::spawn(move || {
            for stream in listener.incoming().map_while(Result::ok) {
                let inner = inner.clone();
                thread::spawn(move || _ = converse(stream, speech, &inner));
            }
        });
        server
    }

    /// The settings that send mails here.
    pub fn settings(&self, more: &str) -> String {
        let (address, from) = (&self.address, "Print farm <farm@example.org>");
        format!("[notify.email]\nserver = \"{address}\"\nencryption = \"none\"\nfrom = \"{from}\"\n{more}\n")
    }

    pub fn taken(&self) -> Vec<ReceivedMail> {
        self.inner.lock().unwrap().taken.clone()
    }

    /// Number of recipients that were refused.
    pub fn refusals(&self) -> usize {
        self.inner.lock().unwrap().refusals
    }

    /// Waits until it has taken so many mails.
    pub fn wait_for(&self, count: usize) -> Vec<ReceivedMail> {
        let began = Instant::now();
        while self.taken().len() < count {
            assert!(began.elapsed() < Duration::from_secs(40), "{count} mails: {:#?}", self.taken());
            thread::sleep(Duration::from_millis(10));
        }
        self.taken()
    }
}

/// Encrypts a connection as a server.
fn encrypted(stream: TcpStream) -> BufReader<Box<dyn Wire>> {
    let certificate = CertificateDer::from_pem_slice(CERTIFICATE.as_bytes()).unwrap();
    let key = PrivateKeyDer::from_pem_slice(KEY.as_bytes()).unwrap();
    let config = ServerConfig::builder_with_provider(rustls::crypto::ring::default_provider().into())
        .with_safe_default_protocol_versions()
        .unwrap();
    let config = config.with_no_client_auth().with_single_cert(vec![certificate], key).unwrap();
    BufReader::new(Box::new(StreamOwned::new(ServerConnection::new(Arc::new(config)).unwrap(), stream)))
}

fn say(wire: &mut BufReader<Box<dyn Wire>>, line: &str) -> io::Result<()> {
    wire.get_mut().write_all(format!("{line}\r\n").as_bytes())?;
    wire.get_mut().flush()
}

fn next_line(wire: &mut BufReader<Box<dyn Wire>>) -> io::Result<String> {
    let mut line = String::new();
    match wire.read_line(&mut line)? {
        0 => Err(io::ErrorKind::UnexpectedEof.into()),
        _ => Ok(line.trim_end_matches(['\r', '\n']).to_owned()),
    }
}

/// One conversation (RFC 5321).
fn converse(stream: TcpStream, speech: Speech, inner: &Mutex<MailState>) -> io::Result<()> {
    let mut wire: BufReader<Box<dyn Wire>> = match speech {
        Speech::Tls => encrypted(stream.try_clone()?),
        _ => BufReader::new(Box::new(stream.try_clone()?)),
    };
    let mut may_encrypt = speech == Speech::Starttls;
    let mut mail = ReceivedMail::default();
    say(&mut wire, "220 test.example ESMTP")?;
    loop {
        let line = next_line(&mut wire)?;
        let (verb, rest) = line.split_once([' ', ':']).unwrap_or((&line, ""));
        let answer = match verb.to_ascii_uppercase().as_str() {
            "EHLO" if may_encrypt => "250-test.example\r\n250 STARTTLS".to_owned(),
            "EHLO" => "250-test.example\r\n250-8BITMIME\r\n250 AUTH PLAIN LOGIN".to_owned(),
            "STARTTLS" if may_encrypt => {
                say(&mut wire, "220 go on")?;
                (wire, may_encrypt) = (encrypted(stream.try_clone()?), false);
                continue;
            }
            _ if may_encrypt => "530 5.7.0 STARTTLS first".to_owned(),
            "AUTH" => sign_in(&mut mail, rest),
            "MAIL" => {
                mail.from = address_in(rest);
                "250 ok".to_owned()
            }
            "RCPT" => add_recipient(&mut mail, address_in(rest), inner),
            "DATA" => {
                say(&mut wire, "354 go on")?;
                let mut data = Vec::new();
                loop {
                    match next_line(&mut wire)? {
                        end if end == "." => break,
                        line => data.push(line),
                    }
                }
                read_mail(&mut mail, &data);
                inner.lock().unwrap().taken.push(std::mem::take(&mut mail));
                "250 taken".to_owned()
            }
            "QUIT" => return say(&mut wire, "221 bye"),
            _ => "502 what?".to_owned(),
        };
        say(&mut wire, &answer)?;
    }
}

fn sign_in(mail: &mut ReceivedMail, words: &str) -> String {
    let given = BASE64_STANDARD.decode(words.rsplit(' ').next().unwrap()).unwrap();
    let mut words = given.split(|byte| *byte == 0).skip(1);
    let mut next = || String::from_utf8(words.next().unwrap().to_vec()).unwrap();
    mail.login = Some((next(), next()));
    let is_right = mail.login.as_ref().is_some_and(|(_, password)| password == "open sesame");
    if is_right { "235 come in" } else { "535 5.7.8 wrong password" }.to_owned()
}

fn add_recipient(mail: &mut ReceivedMail, to: String, inner: &Mutex<MailState>) -> String {
    let mut state = inner.lock().unwrap();
    let code = if state.unknown.contains(&to) { 550 } else { state.answers.pop().unwrap_or(250) };
    if code == 250 {
        mail.to.push(to);
    } else {
        state.refusals += 1;
    }
    format!("{code} 5.1.1 <that is the answer>")
}

fn address_in(text: &str) -> String {
    text.split(['<', '>']).nth(1).unwrap_or_default().to_owned()
}

/// Takes the lines of a mail apart: headers that may be folded, an empty line, the text.
fn read_mail(mail: &mut ReceivedMail, data: &[String]) {
    let mut lines = data.iter().map(|line| line.strip_prefix('.').filter(|_| line.starts_with("..")).unwrap_or(line));
    for line in lines.by_ref().take_while(|line| !line.is_empty()) {
        match line.strip_prefix([' ', '\t']) {
            Some(more) => {
                let (_, value) = mail.headers.last_mut().unwrap();
                value.push(' ');
                value.push_str(more);
            }
            None => {
                let (name, value) = line.split_once(':').unwrap();
                mail.headers.push((name.to_lowercase(), value.trim().to_owned()));
            }
        }
    }
    mail.headers.iter_mut().for_each(|(_, value)| *value = decoded_words(value));
    let body: Vec<&str> = lines.collect();
    mail.text = match mail.header("content-transfer-encoding") {
        "base64" => String::from_utf8(BASE64_STANDARD.decode(body.concat()).unwrap()).unwrap().replace("\r\n", "\n"),
        "quoted-printable" => unquoted(&body.join("\n").replace("=\n", "")),
        _ => body.join("\n"),
    };
}

/// Encoded words of a header (RFC 2047) in UTF-8. White space between two of them belongs to neither.
fn decoded_words(value: &str) -> String {
    let joined = value.replace("?= =?", "?==?");
    let mut text = String::new();
    let mut rest = joined.as_str();
    while let Some(begin) = rest.find("=?") {
        text.push_str(&rest[..begin]);
        let mut fields = rest[begin + 2..].splitn(4, '?');
        let (charset, kind, coded) = (fields.next().unwrap(), fields.next().unwrap(), fields.next().unwrap());
        assert!(charset.eq_ignore_ascii_case("utf-8"), "{value}");
        text.push_str(&match kind {
            "b" | "B" => String::from_utf8(BASE64_STANDARD.decode(coded).unwrap()).unwrap(),
            _ => unquoted(&coded.replace('_', " ")),
        });
        rest = fields.next().unwrap().strip_prefix('=').unwrap();
    }
    text + rest
}

/// The bytes of `=C3=A4`.
fn unquoted(text: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = text.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        let code = (first == b'=').then(|| std::str::from_utf8(&after[..2]).unwrap());
        bytes.push(code.map_or(first, |code| u8::from_str_radix(code, 16).unwrap()));
        rest = if code.is_some() { &after[2..] } else { after };
    }
    String::from_utf8(bytes).unwrap()
}
