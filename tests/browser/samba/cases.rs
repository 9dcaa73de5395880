//! What clients do.

use std::{fs, time::Duration};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{
    proxy::Line,
    shop::{Shop, said},
};

/// The name of a test, and the test.
type Case = (&'static str, fn());

#[rustfmt::skip]
pub const CASES: [Case; 8] = [
    ("files_that_are_dropped_and_renamed_in_are_taken_once_and_whole", dropped_and_renamed),
    ("a_slow_copy_that_stalls_is_waited_for", slow),
    ("a_copy_that_is_cut_is_not_taken_and_counts_when_it_is_sent_again", cut),
    ("a_server_that_is_killed_and_restarted_in_the_middle_loses_and_doubles_nothing", killed),
    ("names_that_differ_in_case_only_are_files_of_their_own_where_they_are_two", case_collisions),
    ("decomposed_names_and_their_tickets_are_taken", decomposed),
    ("a_client_that_keeps_its_file_open_has_it_taken_once", held_open),
    ("many_clients_doing_all_of_it_at_random_are_served", at_random),
];

/// Squares along an edge of a file of 614 kB, which takes ten writes.
const LARGE: usize = 32;
const BYTES: usize = 84 + 600 * LARGE * LARGE;

fn dropped_and_renamed() {
    let mut shop = Shop::open();
    shop.sends("plain.stl");
    shop.sends("with blanks & (brackets) 100%.stl");
    shop.does("mkdir order-7");
    shop.sends("order-7/in an order.stl");
    // A copy in the name, and one in a ticket.
    let file = shop.part(2);
    shop.does(&format!("put {} bracket_x3.stl", file.display()));
    shop.wants(&file, 3);
    let ticket = shop.farm.root().join("ticket");
    fs::write(&ticket, "copies = 2\n").unwrap();
    let file = shop.part(2);
    shop.does(&format!("put {} told.stl.toml; put {} told.stl", ticket.display(), file.display()));
    shop.wants(&file, 2);
    // As careful senders do; and a name that was given in haste.
    for (first, last) in [("a.stl.filepart", "a.stl"), ("b.tmp", "b.stl"), ("c.stl", "d.stl")] {
        let file = shop.part(2);
        shop.does(&format!("put {} {first}; rename {first} {last}", file.display()));
        shop.wants(&file, 1);
    }
    // What a Mac leaves beside is nobody's part.
    let leavings = shop.farm.root().join("ticket");
    shop.does(&format!("put {0} ._plain.stl; put {0} .DS_Store", leavings.display()));
    shop.wait_until_taken(8);
    // The same name again is another revision, the same bytes again are more copies.
    let file = shop.part(2);
    shop.does(&format!("put {} plain.stl", file.display()));
    shop.wait_until_taken(9);
    shop.does(&format!("put {} plain.stl", file.display()));
    shop.wants(&file, 2);
    shop.wait_until_taken(10);
    shop.closes();
}

fn slow() {
    let mut shop = Shop::open();
    let file = shop.part(LARGE);
    let line = Line { rate: 200_000, at: BYTES / 2, stall: Some(Duration::from_millis(2500)) };
    let client = shop.sends_over(line, &format!("put {} slow.stl", file.display()));
    std::thread::sleep(Duration::from_millis(2500));
    assert!(shop.farm.folder("inbox").join("slow.stl").exists(), "it is under way");
    assert_eq!(shop.taken(), 0, "half a file was taken");
    shop.sends("meanwhile.stl");
    shop.wait_until_taken(1);
    let output = client.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", said(&output));
    shop.wants(&file, 1);
    shop.wait_until_taken(2);
    shop.closes();
}

fn cut() {
    let mut shop = Shop::open();
    for (n, at) in [3_000, 90_000, BYTES / 2, BYTES - 20_000].into_iter().enumerate() {
        let file = shop.part(LARGE);
        let line = Line { rate: 2_000_000, at, stall: None };
        let put = format!("put {} cut-{n}.stl", file.display());
        let output = shop.sends_over(line, &put).wait_with_output().unwrap();
        assert!(!output.status.success() || said(&output).contains("NT_STATUS"), "it was not cut: {}", said(&output));
        std::thread::sleep(Duration::from_millis(1200));
        assert_eq!(shop.taken(), n, "a cut file was taken");
        shop.does(&put);
        shop.wants(&file, 1);
        shop.wait_until_taken(n + 1);
    }
    shop.closes();
}

fn killed() {
    let mut shop = Shop::open();
    for n in 0..4 {
        let file = shop.part(LARGE);
        let put = format!("put {} again-{n}.stl", file.display());
        let line = Line { rate: 400_000, at: usize::MAX, stall: None };
        let client = shop.sends_over(line, &put);
        std::thread::sleep(Duration::from_millis(500 + 300 * n));
        shop.server.restart();
        let output = client.wait_with_output().unwrap();
        if output.status.success() && !said(&output).contains("NT_STATUS") {
            shop.wants(&file, 1); // it was through before
            continue;
        }
        shop.sends(&format!("between-{n}.stl"));
        shop.does(&put);
        shop.wants(&file, 1);
    }
    shop.closes();
}

fn case_collisions() {
    let mut shop = Shop::open();
    // One after the other: two files.
    shop.sends("part.stl");
    shop.wait_until_taken(1);
    shop.sends("PART.STL");
    shop.wait_until_taken(2);
    // At once: the server takes the second for the first, and writes over it.
    let (first, second) = (shop.part(2), shop.part(2));
    shop.does(&format!("put {} Cover.stl; put {} COVER.stl", first.display(), second.display()));
    shop.is_replaced(&first);
    shop.wants(&second, 1);
    // Somebody on the server itself makes both names, which a client cannot tell apart.
    let (one, two) = (shop.part(2), shop.part(2));
    for (file, name) in [(&one, "lid.stl"), (&two, "Lid.stl")] {
        fs::copy(file, shop.farm.root().join("sending")).unwrap();
        fs::rename(shop.farm.root().join("sending"), shop.farm.folder("inbox").join(name)).unwrap();
        shop.wants(file, 1);
    }
    shop.does("mkdir Order; mkdir order-b");
    shop.sends("ORDER/x.stl");
    shop.closes();
}

fn decomposed() {
    let mut shop = Shop::open();
    let (apart, joined) = ("Geha\u{308}use u\u{308}.stl", "Geh\u{e4}use \u{fc}.stl");
    shop.sends(apart);
    shop.sends(joined);
    let ticket = shop.farm.root().join("ticket");
    fs::write(&ticket, "copies = 4\n").unwrap();
    let (name, file) = ("Tu\u{308}r.stl", shop.part(2));
    shop.does(&format!("put {} \"{name}.toml\"; put {} \"{name}\"", ticket.display(), file.display()));
    shop.wants(&file, 4);
    shop.does("mkdir \"Auftrag Mu\u{308}ller\"");
    shop.sends("Auftrag Mu\u{308}ller/\u{65e5}\u{672c}.stl");
    shop.wait_until_taken(4);
    shop.closes();
}

fn held_open() {
    let mut shop = Shop::open();
    // All bytes are there, and the client does not close; then it does.
    let file = shop.part(LARGE);
    let line = Line { rate: 4_000_000, at: BYTES + 2_000, stall: Some(Duration::from_secs(4)) };
    let client = shop.sends_over(line, &format!("put {} held.stl; rename held.stl later.stl", file.display()));
    shop.wants(&file, 1);
    shop.wait_until_taken(1);
    drop(client.wait_with_output().unwrap()); // its own rename may come too late
    // While one writes, another renames, deletes and writes over it.
    let (file, other) = (shop.part(LARGE), shop.part(2));
    let line = Line { rate: 300_000, at: usize::MAX, stall: None };
    let client = shop.sends_over(line, &format!("put {} busy.stl", file.display()));
    std::thread::sleep(Duration::from_millis(900));
    for commands in ["rename busy.stl moved.stl", "del busy.stl"] {
        let output = said(&shop.server.does(commands));
        assert!(output.contains("NT_STATUS_SHARING_VIOLATION"), "{commands}: {output}");
    }
    // Behind the server's back it can be renamed: the client goes on writing into it.
    let inbox = shop.farm.folder("inbox");
    fs::rename(inbox.join("busy.stl"), inbox.join("renamed.stl")).unwrap();
    shop.does(&format!("put {} busy.stl", other.display()));
    shop.wants(&other, 1);
    assert!(client.wait_with_output().unwrap().status.success());
    shop.wants(&file, 1);
    shop.wait_until_taken(3);
    shop.closes();
}

fn at_random() {
    let seed = std::env::var("NESTD_SEED").ok().and_then(|seed| seed.parse().ok()).unwrap_or_else(rand::random);
    println!("many_clients_doing_all_of_it_at_random_are_served: NESTD_SEED={seed}");
    let (mut rng, mut shop) = (ChaCha8Rng::seed_from_u64(seed), Shop::open());
    for n in 0..30 {
        let (file, name) = (shop.part(*[2, 9, LARGE].get(rng.random_range(0..3)).unwrap()), format!("part-{n}.stl"));
        let size = fs::metadata(&file).unwrap().len() as usize;
        let put = match rng.random_range(0..3) {
            0 => format!("put {} {name}.filepart; rename {name}.filepart {name}", file.display()),
            _ => format!("put {} {name}", file.display()),
        };
        let line = Line {
            rate: rng.random_range(200_000..3_000_000),
            at: rng.random_range(500..size + 4_000),
            stall: rng.random_bool(0.5).then(|| Duration::from_millis(rng.random_range(0..1500))),
        };
        let client = shop.sends_over(line, &put);
        if rng.random_bool(0.15) {
            std::thread::sleep(Duration::from_millis(rng.random_range(0..800)));
            shop.server.restart();
        }
        let output = client.wait_with_output().unwrap();
        if rng.random_bool(0.15) {
            shop.farm.kill();
            shop.farm.start();
        }
        shop.wants(&file, 1);
        let is_through = output.status.success() && !said(&output).contains("NT_STATUS");
        if !is_through && !is_taken_by_now(&shop, &file, &name) {
            shop.does(&format!("put {} {name}", file.display()));
        }
    }
    shop.closes();
}

/// A client whose line was cut at the very end cannot know whether its file arrived; a careful one looks before it sends again.
fn is_taken_by_now(shop: &Shop, file: &std::path::Path, name: &str) -> bool {
    let hash = blake3::hash(&fs::read(file).unwrap()).to_hex().to_string();
    std::thread::sleep(Duration::from_millis(1500));
    let is_taken = shop.farm.ask(async |ledger| !ledger.parts_of_content(&hash).await.unwrap().is_empty());
    is_taken || fs::read(shop.farm.folder("inbox").join(name)).is_ok_and(|bytes| bytes == fs::read(file).unwrap())
}
