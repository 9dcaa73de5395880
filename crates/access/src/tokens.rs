//! The tokens of programs and people that ask the dashboard: a file with their names, their roles and the BLAKE3 of each token. A token is
//! 256 random bits: who reads its hash cannot guess it, so it needs no slow hash, as passwords do.

use std::{
    fs, io,
    path::{Path, PathBuf},
    time::SystemTime,
};

use serde::{Deserialize, Serialize};

/// What a person, or who has a token, may do. Each role may all that those before it may.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Look at everything.
    Read,
    /// Order parts; change and cancel what waits.
    Order,
    /// Everything that the farm does: flush, pause, outcomes, releases.
    Operate,
    /// Also who else may. It is for people: programs need none of that.
    Admin,
}

impl Role {
    /// All, the least first.
    pub const ALL: [Self; 4] = [Self::Read, Self::Order, Self::Operate, Self::Admin];

    /// Its word.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Order => "order",
            Self::Operate => "operate",
            Self::Admin => "admin",
        }
    }
}

/// A token as the file keeps it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoredToken {
    /// Name for events and limits.
    pub name: String,
    /// What it may.
    pub role: Role,
    /// BLAKE3 of the token, 64 hex digits.
    pub blake3: String,
}

/// The content of the file.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct TokenTable {
    #[serde(default)]
    token: Vec<StoredToken>,
}

/// Why the file of the tokens cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum TokenError {
    /// It cannot be read or written.
    #[error("the tokens in {}: {source}", .file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// It is no list of tokens.
    #[error("the tokens in {} cannot be understood: {why}", .file.display())]
    Broken {
        /// The file.
        file: PathBuf,
        /// Why not.
        why: String,
    },
    /// There is one of this name, or there is none.
    #[error("{0}")]
    Name(String),
}

/// Longest name of a token, characters.
const MAX_NAME: usize = 64;
/// How every token begins, so that people and scanners for secrets know it.
const TOKEN_PREFIX: &str = "nestd_";

/// BLAKE3 of a token, 64 hex digits.
pub fn hash_token(token: &str) -> String {
    blake3::hash(token.as_bytes()).to_hex().to_string()
}

/// 256 random bits, 64 hex digits.
pub fn random_token() -> String {
    let bytes: [u8; 32] = rand::random();
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The tokens of a file; none if it is not there.
///
/// # Errors
/// See [`TokenError`].
pub fn read_tokens(file: &Path) -> Result<Vec<StoredToken>, TokenError> {
    let text = match fs::read_to_string(file) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        other => other.map_err(|source| TokenError::File { file: file.to_owned(), source })?,
    };
    let table: TokenTable = toml::from_str(&text)
        .map_err(|error| TokenError::Broken { file: file.to_owned(), why: error.message().to_owned() })?;
    Ok(table.token)
}

/// Makes a token, and adds its hash to the file. The token itself is kept nowhere.
///
/// # Errors
/// See [`TokenError`].
pub fn add_token(file: &Path, name: &str, role: Role) -> Result<String, TokenError> {
    let is_name = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.');
    if name.is_empty() || name.chars().count() > MAX_NAME || !name.chars().all(is_name) {
        let text = format!("{name:?} is no name of a token: take up to {MAX_NAME} letters, digits, '-', '_' and '.'");
        return Err(TokenError::Name(text));
    }
    if role == Role::Admin {
        let text = "the role admin is for people (nestd people add): a token has read, order or operate";
        return Err(TokenError::Name(text.to_owned()));
    }
    let _only_one = lock_tokens(file)?;
    let mut tokens = read_tokens(file)?;
    if tokens.iter().any(|token| token.name == name) {
        return Err(TokenError::Name(format!("there is a token named {name}: revoke it first, or take another name")));
    }
    let token = format!("{TOKEN_PREFIX}{}", random_token());
    tokens.push(StoredToken { name: name.to_owned(), role, blake3: hash_token(&token) });
    write_tokens(file, tokens)?;
    Ok(token)
}

/// Takes a token out of the file.
///
/// # Errors
/// See [`TokenError`].
pub fn revoke_token(file: &Path, name: &str) -> Result<(), TokenError> {
    let _only_one = lock_tokens(file)?;
    let mut tokens = read_tokens(file)?;
    let before = tokens.len();
    tokens.retain(|token| token.name != name);
    match tokens.len() < before {
        true => write_tokens(file, tokens),
        false => Err(TokenError::Name(format!("there is no token named {name}"))),
    }
}

/// Waits until no other command changes the file. The lock is on its folder, for the file itself is replaced; where folders cannot be
/// locked, nothing is.
fn lock_tokens(file: &Path) -> Result<fs::File, TokenError> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let folder = fs::File::open(folder).map_err(|source| TokenError::File { file: file.to_owned(), source })?;
    _ = folder.lock();
    Ok(folder)
}

fn write_tokens(file: &Path, token: Vec<StoredToken>) -> Result<(), TokenError> {
    let failed = |source| TokenError::File { file: file.to_owned(), source };
    let text = toml::to_string(&TokenTable { token }).map_err(|error| failed(io::Error::other(error)))?;
    let mut unfinished = file.as_os_str().to_owned();
    unfinished.push(".new");
    let unfinished = PathBuf::from(unfinished);
    fs::write(&unfinished, text).map_err(failed)?;
    // The daemon may run as another user, who owns the file that is there.
    if let Ok(found) = fs::metadata(file) {
        fs::set_permissions(&unfinished, found.permissions()).map_err(failed)?;
        _ = std::os::unix::fs::chown(&unfinished, Some(owner_of(&found).0), Some(owner_of(&found).1));
    }
    fs::File::open(&unfinished).and_then(|written| written.sync_all()).map_err(failed)?;
    fs::rename(&unfinished, file).map_err(failed)
}

fn owner_of(found: &fs::Metadata) -> (u32, u32) {
    use std::os::unix::fs::MetadataExt;
    (found.uid(), found.gid())
}

/// The tokens of a file, read again whenever it changes.
#[derive(Debug, Default)]
pub struct TokenWatch {
    seen: Option<(SystemTime, u64)>,
    tokens: Vec<StoredToken>,
}

impl TokenWatch {
    /// The name and the role of a token; `None` = it is none of the file.
    ///
    /// # Errors
    /// The file cannot be read; then nobody is known.
    pub fn find_token(&mut self, file: &Path, token: &str) -> Result<Option<StoredToken>, TokenError> {
        let found = fs::metadata(file).and_then(|found| Ok((found.modified()?, found.len()))).ok();
        if found.is_none() || found != self.seen {
            self.seen = None;
            self.tokens = read_tokens(file)?;
            self.seen = found;
        }
        let hash = hash_token(token);
        // The hashes tell nothing of the tokens, so it does not matter how long it takes to compare them.
        let known = self.tokens.iter().find(|known| known.blake3 == hash).cloned();
        Ok(known.map(|known| StoredToken { role: known.role.min(Role::Operate), ..known }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_that_are_made_and_revoked_at_the_same_time_are_all_kept_and_all_gone() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("tokens.toml");
        let at_once = |change: &(dyn Fn(&str) + Sync)| {
            std::thread::scope(|scope| {
                for at in 0..16 {
                    scope.spawn(move || change(&format!("t{at}")));
                }
            });
        };
        at_once(&|name| drop(add_token(&file, name, Role::Order).unwrap()));
        assert_eq!(read_tokens(&file).unwrap().len(), 16);
        at_once(&|name| revoke_token(&file, name).unwrap());
        assert_eq!(read_tokens(&file).unwrap(), []);
    }

    #[test]
    fn a_token_is_known_by_its_hash_until_it_is_revoked() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("tokens.toml");
        let mut watch = TokenWatch::default();
        assert_eq!(watch.find_token(&file, "x").unwrap(), None);
        let mes = add_token(&file, "mes", Role::Order).unwrap();
        let hall = add_token(&file, "hall-2", Role::Operate).unwrap();
        let text = fs::read_to_string(&file).unwrap();
        assert!(!text.contains(&mes) && text.contains(&hash_token(&mes)), "{text}");
        assert_eq!(mes.len(), TOKEN_PREFIX.len() + 64);
        let found = watch.find_token(&file, &mes).unwrap().unwrap();
        assert_eq!((found.name.as_str(), found.role), ("mes", Role::Order));
        assert_eq!(watch.find_token(&file, &hall).unwrap().unwrap().role, Role::Operate);
        assert!(watch.find_token(&file, "nestd_").unwrap().is_none() && watch.find_token(&file, "").unwrap().is_none());
        assert!(add_token(&file, "mes", Role::Read).is_err() && add_token(&file, "a b", Role::Read).is_err());
        revoke_token(&file, "mes").unwrap();
        assert!(revoke_token(&file, "mes").is_err() && watch.find_token(&file, &mes).unwrap().is_none());
        assert!(watch.find_token(&file, &hall).unwrap().is_some());
        fs::write(&file, "[[token]]\nname = 3\n").unwrap();
        assert!(matches!(watch.find_token(&file, &hall), Err(TokenError::Broken { .. })));
        assert!(Role::ALL.is_sorted() && add_token(&file, "x", Role::Admin).is_err(), "admins are people");
    }
}
