//! Which copy of a build the screen of each device shows while the build is broken out, so that two people do not look for the same one.
//! It is kept in memory alone: after a restart every page asks anew. What is said of a copy is in the ledger, which refuses a press that
//! comes late.

use std::{
    collections::BTreeMap,
    convert::Infallible,
    sync::{
        Mutex, MutexGuard, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

use axum::{
    extract::FromRequestParts,
    http::{HeaderMap, HeaderValue, header, request::Parts},
};

use crate::web::clients::client::cookie_value;

/// How long a copy stays with a screen that does not ask again. An open page asks once a minute.
const SHOWN_FOR: Duration = Duration::from_secs(150);
/// The same until the browser has brought its cookie for the first time, which a page does at once.
const SHOWN_FIRST_FOR: Duration = Duration::from_secs(15);
/// The cookie with the number of a device.
const DEVICE_COOKIE: &str = "nestd_device";
/// How long a device keeps its number: a year, s.
const DEVICE_KEPT_SECS: u32 = 31_536_000;

/// The device that a request comes from.
#[derive(Debug, Clone)]
pub(crate) struct RequestDevice {
    /// A random number, 32 hexadecimal digits.
    number: String,
    /// Whether it did not bring its cookie.
    is_new: bool,
}

impl<S: Sync> FromRequestParts<S> for RequestDevice {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Infallible> {
        let is_number = |text: &String| text.len() == 32 && text.bytes().all(|byte| byte.is_ascii_hexdigit());
        let known = cookie_value(&parts.headers, DEVICE_COOKIE).filter(is_number);
        let is_new = known.is_none();
        let number = known.unwrap_or_else(|| format!("{:032x}", rand::random::<u128>()));
        Ok(Self { number, is_new })
    }
}

impl RequestDevice {
    /// Has a new device keep its number for a year.
    pub(crate) fn headers(&self) -> HeaderMap {
        let mut headers = HeaderMap::new();
        let cookie =
            format!("{DEVICE_COOKIE}={}; Path=/; Max-Age={DEVICE_KEPT_SECS}; SameSite=Lax; HttpOnly", self.number);
        if let Some(value) = HeaderValue::from_str(&cookie).ok().filter(|_| self.is_new) {
            headers.insert(header::SET_COOKIE, value);
        }
        headers
    }
}

/// A look of a device at a build that is broken out.
pub(crate) struct ScreenLook<'l> {
    /// Number of the build.
    pub(crate) build: i64,
    pub(crate) device: &'l RequestDevice,
    pub(crate) user: &'l str,
    pub(crate) now: Instant,
}

/// A copy on a screen.
struct ShownCopy {
    build: i64,
    device: String,
    user: String,
    /// Its position in the list of the build.
    at: usize,
    until: Instant,
}

impl ShownCopy {
    fn is_of(&self, look: &ScreenLook<'_>) -> bool {
        self.build == look.build && self.device == look.device.number
    }
}

/// The copies that are on screens.
#[derive(Default)]
pub(crate) struct ShownCopies {
    shown: Mutex<Vec<ShownCopy>>,
    /// How often a person took a copy from another screen.
    taken: AtomicU64,
}

impl ShownCopies {
    /// The position of the copy to look for: what the screen shows, while it is in the cake; else the next after it, or after `passed`,
    /// that no other screen shows. `open` are the positions of all copies in the cake, in their order. `None` = others show them all.
    pub(crate) fn offer(&self, look: &ScreenLook<'_>, open: &[usize], passed: Option<usize>) -> Option<usize> {
        let mut shown = self.lock(look.now);
        let own = shown.iter().find(|copy| copy.is_of(look)).map(|copy| copy.at);
        let own_open = own.filter(|at| passed != Some(*at) && open.binary_search(at).is_ok());
        let begin = passed.or(own).map_or(0, |at| at + 1);
        let split = open.partition_point(|at| *at < begin);
        let is_free =
            |at: &usize| !shown.iter().any(|copy| copy.build == look.build && copy.at == *at && !copy.is_of(look));
        let next = || open[split..].iter().chain(&open[..split]).copied().find(is_free);
        let at = own_open.or_else(next);
        put(&mut shown, look, at);
        at
    }

    /// Shows a copy that a person chose, unless another screen shows it: then its user is returned. With `take` that screen loses it.
    pub(crate) fn choose(&self, look: &ScreenLook<'_>, at: usize, take: bool) -> Option<String> {
        let mut shown = self.lock(look.now);
        let is_elsewhere = |copy: &ShownCopy| copy.build == look.build && copy.at == at && !copy.is_of(look);
        if take {
            shown.retain(|copy| !is_elsewhere(copy));
            self.taken.fetch_add(1, Ordering::Relaxed);
        }
        let other = shown.iter().find(|copy| is_elsewhere(copy)).map(|copy| copy.user.clone());
        put(&mut shown, look, other.is_none().then_some(at));
        other
    }

    /// The positions of the copies on other screens, with the user of each.
    pub(crate) fn elsewhere(&self, look: &ScreenLook<'_>) -> BTreeMap<usize, String> {
        let shown = self.lock(look.now);
        let others = shown.iter().filter(|copy| copy.build == look.build && !copy.is_of(look));
        others.map(|copy| (copy.at, copy.user.clone())).collect()
    }

    /// A number that grows when a person takes a copy from another screen, which must hear of it.
    pub(crate) fn taken(&self) -> u64 {
        self.taken.load(Ordering::Relaxed)
    }

    /// What is on screens now.
    fn lock(&self, now: Instant) -> MutexGuard<'_, Vec<ShownCopy>> {
        let mut shown = self.shown.lock().unwrap_or_else(PoisonError::into_inner);
        shown.retain(|copy| copy.until > now);
        shown
    }
}

/// Notes what a screen shows from now on; `None` = no copy.
fn put(shown: &mut Vec<ShownCopy>, look: &ScreenLook<'_>, at: Option<usize>) {
    shown.retain(|copy| !copy.is_of(look));
    let until = look.now + if look.device.is_new { SHOWN_FIRST_FOR } else { SHOWN_FOR };
    let (build, device, user) = (look.build, look.device.number.clone(), look.user.to_owned());
    shown.extend(at.map(|at| ShownCopy { build, device, user, at, until }));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn device(number: u8, is_new: bool) -> RequestDevice {
        RequestDevice { number: format!("{number:032x}"), is_new }
    }

    fn look<'l>(device: &'l RequestDevice, user: &'l str, now: Instant) -> ScreenLook<'l> {
        ScreenLook { build: 1, device, user, now }
    }

    #[test]
    fn no_copy_is_on_two_screens_and_each_goes_on_with_the_next_free_one() {
        let (shown, now) = (ShownCopies::default(), Instant::now());
        let (ann, ben, eve) = (device(1, false), device(2, false), device(3, false));
        let [ann, ben, eve] =
            [(&ann, "ann"), (&ben, "ben"), (&eve, "eve")].map(|(device, user)| look(device, user, now));
        assert_eq!(shown.offer(&ann, &[0, 1, 2, 3], None), Some(0));
        assert_eq!(shown.offer(&ben, &[0, 1, 2, 3], None), Some(1));
        assert_eq!(shown.offer(&ann, &[0, 1, 2, 3], None), Some(0), "asked again, it stays");
        assert_eq!(shown.offer(&ann, &[1, 2, 3], Some(0)), Some(2), "she pressed");
        assert_eq!(shown.offer(&ben, &[1, 2, 3], Some(1)), Some(3), "he passed");
        assert_eq!(shown.offer(&ben, &[1, 2, 3], Some(1)), Some(3), "the same page, loaded again, passes no more");
        assert_eq!(shown.offer(&ann, &[1, 3], Some(2)), Some(1), "round to what was passed");
        assert_eq!(shown.elsewhere(&ann), BTreeMap::from([(3, "ben".to_owned())]));
        assert_eq!(shown.offer(&eve, &[1, 3], None), None, "the last copies are on the other screens");
        assert_eq!(shown.offer(&ann, &[3], Some(1)), None);
        let other = ScreenLook { build: 2, ..look(eve.device, "eve", now) };
        assert_eq!(shown.offer(&other, &[1, 3], None), Some(1), "another build");
    }

    #[test]
    fn a_chosen_copy_that_another_screen_shows_stays_there_unless_it_is_taken() {
        let (shown, now) = (ShownCopies::default(), Instant::now());
        let (ann, ben) = (device(1, false), device(2, false));
        let (ann, ben) = (look(&ann, "ann", now), look(&ben, "ben", now));
        assert_eq!(shown.choose(&ann, 2, false), None);
        assert_eq!(shown.choose(&ben, 2, false), Some("ann".to_owned()));
        assert_eq!((shown.elsewhere(&ben).len(), shown.elsewhere(&ann).len(), shown.taken()), (1, 0, 0));
        assert_eq!(shown.choose(&ben, 2, true), None);
        assert_eq!((shown.elsewhere(&ann).get(&2).map(String::as_str), shown.taken()), (Some("ben"), 1));
        assert_eq!(shown.offer(&ann, &[1, 2], None), Some(1));
    }

    #[test]
    fn a_screen_that_does_not_ask_again_gives_its_copy_up() {
        let (shown, now) = (ShownCopies::default(), Instant::now());
        let (ann, ben, probe) = (device(1, false), device(2, false), device(3, true));
        shown.offer(&look(&ann, "ann", now), &[0, 1, 2], None);
        shown.offer(&look(&probe, "", now), &[0, 1, 2], None);
        let ben_after = |wait: Duration| shown.offer(&look(&ben, "ben", now + wait), &[0, 1], None);
        assert_eq!(ben_after(Duration::from_secs(14)), None, "one with each of two others");
        assert_eq!(ben_after(Duration::from_secs(16)), Some(1), "who never brought its cookie keeps nothing for long");
        let much_later = now + SHOWN_FOR;
        assert_eq!(
            shown.offer(&look(&ben, "ben", much_later), &[0], None),
            Some(0),
            "hers, of which she asked no more"
        );
    }

    #[tokio::test]
    async fn a_device_gets_its_number_once() {
        let of = async |cookie: &str| {
            let request = axum::http::Request::get("/").header(header::COOKIE, cookie).body(()).unwrap();
            RequestDevice::from_request_parts(&mut request.into_parts().0, &()).await.unwrap()
        };
        let new = of("nestd_device=x").await;
        let cookie = new.headers()[header::SET_COOKIE].to_str().unwrap().to_owned();
        assert!(new.is_new && cookie.contains("HttpOnly") && cookie.contains("SameSite=Lax"), "{cookie}");
        let known = of(&format!("a=b; {}", cookie.split(';').next().unwrap())).await;
        assert_eq!((known.is_new, &known.number, known.headers().len()), (false, &new.number, 0));
    }
}
