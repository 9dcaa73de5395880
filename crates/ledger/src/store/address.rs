//! Where a ledger is: a SQLite file, or a database of a PostgreSQL server. A password is in no text that this type gives.

use std::{
    fmt,
    path::{Path, PathBuf},
};

/// How the address of a database on a server begins.
const SCHEMES: [&str; 2] = ["postgres://", "postgresql://"];

/// What may stand in the query of an address.
const OPTION_WORDS: [&str; 4] = ["host", "port", "sslmode", "sslrootcert"];

/// How many connections to a server a daemon may have, unless it is said.
pub const DAEMON_CONNECTIONS: u32 = 7;

/// Where a ledger is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LedgerAddress {
    /// A SQLite file.
    File(PathBuf),
    /// A database of a PostgreSQL server.
    Server(ServerAddress),
}

/// A database of a PostgreSQL server: `postgres://user[:password]@host[:port]/database[?sslmode=..]`.
#[derive(Clone, PartialEq, Eq)]
pub struct ServerAddress {
    /// As it was given, perhaps with a password.
    url: String,
    /// A file with the password, which takes precedence over one in the address.
    password_file: Option<PathBuf>,
    /// How many connections a daemon may have.
    connections: u32,
}

impl LedgerAddress {
    /// The address of a database on a server, if the text begins like one.
    pub fn parse_server(text: &str, password_file: Option<&Path>) -> Option<Self> {
        SCHEMES.iter().any(|scheme| text.starts_with(scheme)).then(|| {
            let (url, password_file) = (text.to_owned(), password_file.map(Path::to_owned));
            Self::Server(ServerAddress { url, password_file, connections: DAEMON_CONNECTIONS })
        })
    }

    /// The address that a text of a command names: a server's, or the path of a file.
    pub fn parse(text: &str, password_file: Option<&Path>) -> Self {
        Self::parse_server(text, password_file).unwrap_or_else(|| Self::File(text.into()))
    }

    /// The same address, to which a daemon may have so many connections.
    pub fn with_connections(self, connections: u32) -> Self {
        match self {
            Self::File(file) => Self::File(file),
            Self::Server(server) => Self::Server(ServerAddress { connections, ..server }),
        }
    }

    /// Its file, unless it is on a server.
    pub fn file(&self) -> Option<&Path> {
        match self {
            Self::File(file) => Some(file),
            Self::Server(_) => None,
        }
    }

    /// Why it cannot be used, with the remedy; `None` = it can.
    pub fn find_problem(&self) -> Option<(String, &'static str)> {
        match self {
            Self::File(_) => None,
            Self::Server(server) => server.find_problem(),
        }
    }
}

impl ServerAddress {
    fn find_problem(&self) -> Option<(String, &'static str)> {
        let remedy = "write postgres://user@host/database, with %40 for an @ inside a part";
        // The driver would log a word that it does not know together with what it says, which may be a password.
        if let Some(word) = self.unknown_words().next() {
            let remedy = "only host, port, sslmode and sslrootcert may stand after the ?; a password stands in \
                          folders.ledger_password_file, or in the address as user:password@host";
            return Some((format!("{self} has \"{}\" after the ?", word.escape_debug()), remedy));
        }
        match self.url.parse::<sqlx::postgres::PgConnectOptions>() {
            Ok(options) if options.get_database().is_none_or(str::is_empty) => {
                Some((format!("{self} names no database"), remedy))
            }
            Ok(_) => None,
            // The error of the parser may quote the address.
            Err(_) => Some(("the address of the PostgreSQL database cannot be read".to_owned(), remedy)),
        }
    }

    fn unknown_words(&self) -> impl Iterator<Item = &str> {
        let words = self.url.split_once('?').map_or("", |(_, words)| words).split('&').filter(|word| !word.is_empty());
        words.map(|word| word.split('=').next().unwrap_or_default()).filter(|word| !OPTION_WORDS.contains(word))
    }

    /// The file with the password.
    pub(crate) fn password_file(&self) -> Option<&Path> {
        self.password_file.as_deref()
    }

    /// How many connections a daemon may have.
    pub(crate) fn connections(&self) -> u32 {
        self.connections
    }

    /// How to connect, with the password.
    ///
    /// The address or the file with the password cannot be read.
    pub(crate) fn connect_options(&self) -> crate::base::error::Result<sqlx::postgres::PgConnectOptions> {
        let failed = |what: String| crate::ServerError::Unusable { ledger: self.to_string(), what };
        let options: sqlx::postgres::PgConnectOptions =
            self.url.parse().map_err(|_| failed("its address cannot be read".to_owned()))?;
        match &self.password_file {
            None => Ok(options),
            Some(file) => {
                let password = access::read_secret(file).map_err(|error| failed(error.to_string()))?;
                Ok(options.password(&password))
            }
        }
    }
}

/// Without a password: neither between the user and the host nor in the query, where anything might stand.
impl fmt::Display for ServerAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let scheme = SCHEMES.iter().find(|scheme| self.url.starts_with(**scheme)).copied().unwrap_or_default();
        let rest = self.url[scheme.len()..].split(['?', '#']).next().unwrap_or_default();
        match rest.rsplit_once('@') {
            // A password with a ? that is not coded: nothing after the user is certain.
            None if self.url.contains('@') => write!(f, "{scheme}{}@..", rest.split(':').next().unwrap_or_default()),
            None => write!(f, "{scheme}{rest}"),
            Some((who, place)) => write!(f, "{scheme}{}@{place}", who.split(':').next().unwrap_or_default()),
        }
    }
}

impl fmt::Debug for ServerAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl fmt::Display for LedgerAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(file) => file.display().fmt(f),
            Self::Server(server) => server.fmt(f),
        }
    }
}

impl From<&Path> for LedgerAddress {
    fn from(file: &Path) -> Self {
        Self::File(file.to_owned())
    }
}

impl From<&PathBuf> for LedgerAddress {
    fn from(file: &PathBuf) -> Self {
        Self::File(file.clone())
    }
}

impl From<&LedgerAddress> for LedgerAddress {
    fn from(address: &LedgerAddress) -> Self {
        address.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_text_of_an_address_holds_its_password() {
        let secret = "s3cret:@/?x";
        let coded = "s3cret%3A%40%2F%3Fx";
        for url in [
            format!("postgres://farm:{coded}@db.example.org:5433/nestd?sslmode=require"),
            format!("postgresql://farm:{coded}@localhost/nestd?host=/run/postgresql"),
            format!("postgres://farm@db/nestd?password={coded}"),
            "postgres://farm:two@ats@db/nestd".to_owned(),
            "postgres://farm:two?ats@db/nestd".to_owned(),
        ] {
            let address = LedgerAddress::parse(&url, Some(Path::new("/etc/nestd/db-password")));
            for text in [address.to_string(), format!("{address:?}"), format!("{address:#?}")] {
                assert!(!text.contains("s3cret") && !text.contains(secret) && !text.contains("two"), "{text}");
                assert!(text.contains("farm@"), "{text}");
            }
        }
    }

    #[test]
    fn a_path_is_a_file_and_an_address_is_a_server() {
        assert_eq!(LedgerAddress::parse("state/nestd.db", None).file(), Some(Path::new("state/nestd.db")));
        assert_eq!(LedgerAddress::parse("postgres://a@b/c", None).file(), None);
        assert_eq!(LedgerAddress::parse("postgres.db", None).find_problem(), None);
    }

    #[test]
    fn an_address_that_cannot_be_used_is_refused_without_its_password() {
        for right in ["?sslmode=disable", "?sslmode=verify-full&sslrootcert=/etc/nestd/db-ca.crt"] {
            assert_eq!(LedgerAddress::parse(&format!("postgres://farm:pw@db/nestd{right}"), None).find_problem(), None);
        }
        for wrong in [
            "postgres://farm:pw@db:port/nestd",
            "postgres://farm:pw@db",
            "postgres://farm@db/x?password=pw",
            "postgres://farm:pw@db/x?sslmode=perhaps",
        ] {
            let (text, remedy) = LedgerAddress::parse(wrong, None).find_problem().unwrap();
            assert!(!text.contains("pw") && remedy.contains("host"), "{text}");
        }
    }
}
