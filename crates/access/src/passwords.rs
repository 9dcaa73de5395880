//! Passwords and PINs of people: what may be one, and the hash by which one is known again. People choose them, so who reads a hash may try
//! words until one fits: Argon2id makes each try slow. Its parameters are those that OWASP recommends (19 MiB, 2 passes), and stand in the
//! hash.

use std::{fmt, sync::LazyLock};

use argon2::{
    Argon2,
    password_hash::{PasswordHasher, PasswordVerifier},
};

/// Characters of a password: NIST SP 800-63B demands no classes of them, only length.
const PASSWORD_LENGTH: std::ops::RangeInclusive<usize> = 10..=200;
/// Digits of a PIN.
const PIN_LENGTH: std::ops::RangeInclusive<usize> = 4..=8;
/// Longest name of a person, characters.
const MAX_NAME: usize = 64;

/// Whether a text may be the password of a person: long enough, not one letter repeated, and not made of the name.
pub fn is_password(text: &str, name: &str) -> bool {
    let (folded, name) = (text.to_lowercase(), name.to_lowercase());
    let first = text.chars().next();
    let without_name = folded.replace(&name, "");
    PASSWORD_LENGTH.contains(&text.chars().count())
        && text.chars().any(|c| Some(c) != first)
        && without_name.chars().count() * 2 >= folded.chars().count()
}

/// Whether a text may be a PIN: 4 to 8 digits, not all alike and not in order.
pub fn is_pin(text: &str) -> bool {
    let digits: Vec<u8> = text.bytes().collect();
    let is_run = |step: i16| digits.windows(2).all(|pair| i16::from(pair[1]) - i16::from(pair[0]) == step);
    PIN_LENGTH.contains(&digits.len()) && digits.iter().all(u8::is_ascii_digit) && ![0, 1, -1].into_iter().any(is_run)
}

/// Whether a text may be the name of a person: letters, digits, `-`, `_`, `.` and `@`, with single blanks between them.
pub fn is_person_name(text: &str) -> bool {
    let is_letter = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.' | '@');
    let mut words = text.split(' ');
    text.chars().count() <= MAX_NAME && words.all(|word| !word.is_empty() && word.chars().all(is_letter))
}

/// The hash of a password or PIN, as a PHC string; "" = there is none. It is not shown by accident.
#[derive(Clone, Default, PartialEq, Eq)]
pub struct PasswordHash(String);

impl fmt::Debug for PasswordHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_empty() { "none" } else { "hidden" })
    }
}

impl PasswordHash {
    /// Hashes a password with a new salt. `None` when there is no memory for that.
    pub fn of(password: &str) -> Option<Self> {
        let salt: [u8; 16] = rand::random();
        let hash = Argon2::default().hash_password_with_salt(password.as_bytes(), &salt).ok()?;
        Some(Self(hash.to_string()))
    }

    /// As the ledger keeps it.
    pub fn from_stored(text: String) -> Self {
        Self(text)
    }

    /// For the ledger.
    pub fn to_stored(&self) -> &str {
        &self.0
    }

    /// Whether there is no password.
    pub fn is_none(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether it is the hash of this password. It takes as long where there is none, so that time does not tell who is known.
    pub fn is_of(&self, password: &str) -> bool {
        /// That of a password that nobody has.
        static NOBODYS: LazyLock<Option<PasswordHash>> = LazyLock::new(|| PasswordHash::of(&super::random_token()));
        let (known, is_known) = match NOBODYS.as_ref().filter(|_| self.is_none()) {
            Some(nobodys) => (nobodys, false),
            None => (self, !self.is_none()),
        };
        // Longer ones are nobody's: hashing them would only take time.
        let tried = if password.len() <= 4 * *PASSWORD_LENGTH.end() { password } else { "" };
        Argon2::default().verify_password(tried.as_bytes(), known.0.as_str()).is_ok() && is_known
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_password_is_known_by_an_argon2id_hash_of_its_own_that_says_nothing_of_it() {
        let (one, other) = (PasswordHash::of("correct horse").unwrap(), PasswordHash::of("correct horse").unwrap());
        assert!(one.to_stored().starts_with("$argon2id$v=19$m=19456,t=2,p=1$"), "{}", one.to_stored());
        assert!(one != other && one.is_of("correct horse") && other.is_of("correct horse"));
        assert!(!one.is_of("correct horsf") && !one.is_of("") && !one.is_of(&"x".repeat(5000)));
        assert_eq!(format!("{one:?}"), "hidden");
        let read = PasswordHash::from_stored(one.to_stored().to_owned());
        assert!(read.is_of("correct horse") && !PasswordHash::from_stored("nonsense".to_owned()).is_of("nonsense"));
    }

    #[test]
    fn who_has_no_password_is_refused_after_as_long_a_time() {
        let (one, none) = (PasswordHash::of("correct horse").unwrap(), PasswordHash::default());
        assert!(none.is_none() && !none.is_of("") && !none.is_of("correct horse"));
        let time = |hash: &PasswordHash| {
            let began = std::time::Instant::now();
            (0..3).for_each(|_| assert!(!hash.is_of("wrong")));
            began.elapsed().as_secs_f64()
        };
        let (known, unknown) = (time(&one), time(&none));
        assert!(unknown > 0.3 * known, "{unknown} s against {known} s");
    }

    #[test]
    fn passwords_are_long_pins_are_no_rows_of_digits_and_names_no_code() {
        assert!(is_password("correct horse", "anna") && is_password("päßwörter-und-mehr", "anna"));
        for weak in ["", "short", "aaaaaaaaaaaa", "annaannaanna", "Anna-Anna-Anna-A"] {
            assert!(!is_password(weak, "anna"), "{weak}");
        }
        assert!(!is_password(&"ab".repeat(101), "anna"));
        assert!(is_pin("4711") && is_pin("90210817"));
        for weak in ["", "123", "1234", "4321", "7777", "471147114", "47 1", "４７１１"] {
            assert!(!is_pin(weak), "{weak}");
        }
        for name in ["anna", "Jörg Müller", "ann@example.org", "山田"] {
            assert!(is_person_name(name), "{name}");
        }
        for name in ["", " anna", "anna ", "a  b", "a\nb", "<b>", "a\u{200b}b", "\u{202e}x", "a=b", "a;b"] {
            assert!(!is_person_name(name), "{name:?}");
        }
        assert!(!is_person_name(&"a".repeat(65)));
    }
}
