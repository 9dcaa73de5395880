//! The actions of Samba clients, one test each.

use std::{fs, time::Duration};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{
    proxy::NetworkLine,
    shop::{SambaShop, output_text},
};

/// The name of a test, and the test.
type ShareCase = (&'static str, fn());

#[rustfmt::skip]
pub const CASES: [ShareCase; 8] = [
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
    let mut shop = SambaShop::open();
    shop.send_part("plain.stl");
    shop.send_part("with blanks & (brackets) 100%.stl");
    shop.run_client("mkdir order-7");
    shop.send_part("order-7/in an order.stl");
    // Copies in the name, and copies in a ticket.
    let file = shop.part(2);
    shop.run_client(&format!("put {} bracket_x3.stl", file.display()));
    shop.expect_copies(&file, 3);
    let ticket = shop.farm.root().join("ticket");
    fs::write(&ticket, "copies = 2\n").unwrap();
    let file = shop.part(2);
    shop.run_client(&format!("put {} told.stl.toml; put {} told.stl", ticket.display(), file.display()));
    shop.expect_copies(&file, 2);
    // A file that is renamed at the end, as careful senders do; and a file that is renamed shortly after it was sent.
    for (first, last) in [("a.stl.filepart", "a.stl"), ("b.tmp", "b.stl"), ("c.stl", "d.stl")] {
        let file = shop.part(2);
        shop.run_client(&format!("put {} {first}; rename {first} {last}", file.display()));
        shop.expect_copies(&file, 1);
    }
    // The hidden files that a Mac adds are no parts.
    let leavings = shop.farm.root().join("ticket");
    shop.run_client(&format!("put {0} ._plain.stl; put {0} .DS_Store", leavings.display()));
    shop.wait_until_taken(8);
    // The same name again is another revision, the same bytes again are more copies.
    let file = shop.part(2);
    shop.run_client(&format!("put {} plain.stl", file.display()));
    shop.wait_until_taken(9);
    shop.run_client(&format!("put {} plain.stl", file.display()));
    shop.expect_copies(&file, 2);
    shop.wait_until_taken(10);
    shop.finish_and_compare();
}

fn slow() {
    let mut shop = SambaShop::open();
    let file = shop.part(LARGE);
    let line = NetworkLine { rate: 200_000, at: BYTES / 2, stall: Some(Duration::from_millis(2500)) };
    let client = shop.send_over(line, &format!("put {} slow.stl", file.display()));
    std::thread::sleep(Duration::from_millis(2500));
    assert!(shop.farm.folder("inbox").join("slow.stl").exists(), "it is under way");
    assert_eq!(shop.taken(), 0, "half a file was taken");
    shop.send_part("meanwhile.stl");
    shop.wait_until_taken(1);
    let output = client.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", output_text(&output));
    shop.expect_copies(&file, 1);
    shop.wait_until_taken(2);
    shop.finish_and_compare();
}

fn cut() {
    let mut shop = SambaShop::open();
    for (n, at) in [3_000, 90_000, BYTES / 2, BYTES - 20_000].into_iter().enumerate() {
        let file = shop.part(LARGE);
        let line = NetworkLine { rate: 2_000_000, at, stall: None };
        let put = format!("put {} cut-{n}.stl", file.display());
        let output = shop.send_over(line, &put).wait_with_output().unwrap();
        assert!(
            !output.status.success() || output_text(&output).contains("NT_STATUS"),
            "it was not cut: {}",
            output_text(&output)
        );
        std::thread::sleep(Duration::from_millis(1200));
        let taken = shop.taken_parts();
        assert_eq!(taken.len(), n, "a cut file was taken: {taken:#?}\n{}", shop.farm.log());
        shop.run_client(&put);
        shop.expect_copies(&file, 1);
        shop.wait_until_taken(n + 1);
    }
    shop.finish_and_compare();
}

fn killed() {
    let mut shop = SambaShop::open();
    for n in 0..4 {
        let file = shop.part(LARGE);
        let put = format!("put {} again-{n}.stl", file.display());
        let line = NetworkLine { rate: 400_000, at: usize::MAX, stall: None };
        let client = shop.send_over(line, &put);
        std::thread::sleep(Duration::from_millis(500 + 300 * n));
        shop.server.restart();
        let output = client.wait_with_output().unwrap();
        if output.status.success() && !output_text(&output).contains("NT_STATUS") {
            shop.expect_copies(&file, 1); // the file had arrived before the cut
            continue;
        }
        shop.send_part(&format!("between-{n}.stl"));
        shop.run_client(&put);
        shop.expect_copies(&file, 1);
    }
    shop.finish_and_compare();
}

fn case_collisions() {
    let mut shop = SambaShop::open();
    // Sent one after the other: two files.
    shop.send_part("part.stl");
    shop.wait_until_taken(1);
    shop.send_part("PART.STL");
    shop.wait_until_taken(2);
    // Sent at once: the server treats both names as one file, and overwrites it.
    let (first, second) = (shop.part(2), shop.part(2));
    shop.run_client(&format!("put {} Cover.stl; put {} COVER.stl", first.display(), second.display()));
    shop.mark_replaced(&first);
    shop.expect_copies(&second, 1);
    // A user on the server itself makes both names, which a client cannot distinguish.
    let (one, two) = (shop.part(2), shop.part(2));
    for (file, name) in [(&one, "lid.stl"), (&two, "Lid.stl")] {
        fs::copy(file, shop.farm.root().join("sending")).unwrap();
        fs::rename(shop.farm.root().join("sending"), shop.farm.folder("inbox").join(name)).unwrap();
        shop.expect_copies(file, 1);
    }
    shop.run_client("mkdir Order; mkdir order-b");
    shop.send_part("ORDER/x.stl");
    shop.finish_and_compare();
}

fn decomposed() {
    let mut shop = SambaShop::open();
    let (apart, joined) = ("Geha\u{308}use u\u{308}.stl", "Geh\u{e4}use \u{fc}.stl");
    shop.send_part(apart);
    shop.send_part(joined);
    let ticket = shop.farm.root().join("ticket");
    fs::write(&ticket, "copies = 4\n").unwrap();
    let (name, file) = ("Tu\u{308}r.stl", shop.part(2));
    shop.run_client(&format!("put {} \"{name}.toml\"; put {} \"{name}\"", ticket.display(), file.display()));
    shop.expect_copies(&file, 4);
    shop.run_client("mkdir \"Auftrag Mu\u{308}ller\"");
    shop.send_part("Auftrag Mu\u{308}ller/\u{65e5}\u{672c}.stl");
    shop.wait_until_taken(4);
    shop.finish_and_compare();
}

fn held_open() {
    let mut shop = SambaShop::open();
    // All bytes have arrived but the client keeps the file open; then it closes it.
    let file = shop.part(LARGE);
    let line = NetworkLine { rate: 4_000_000, at: BYTES + 2_000, stall: Some(Duration::from_secs(4)) };
    let client = shop.send_over(line, &format!("put {} held.stl; rename held.stl later.stl", file.display()));
    shop.expect_copies(&file, 1);
    shop.wait_until_taken(1);
    drop(client.wait_with_output().unwrap()); // its own rename may come too late
    // While one client writes, another renames, deletes and overwrites the file.
    let (file, other) = (shop.part(LARGE), shop.part(2));
    let line = NetworkLine { rate: 300_000, at: usize::MAX, stall: None };
    let client = shop.send_over(line, &format!("put {} busy.stl", file.display()));
    std::thread::sleep(Duration::from_millis(900));
    for commands in ["rename busy.stl moved.stl", "del busy.stl"] {
        let output = output_text(&shop.server.run_client(commands));
        assert!(output.contains("NT_STATUS_SHARING_VIOLATION"), "{commands}: {output}");
    }
    // The file is renamed on the server's disk: the client continues to write into it.
    let inbox = shop.farm.folder("inbox");
    fs::rename(inbox.join("busy.stl"), inbox.join("renamed.stl")).unwrap();
    shop.run_client(&format!("put {} busy.stl", other.display()));
    shop.expect_copies(&other, 1);
    assert!(client.wait_with_output().unwrap().status.success());
    shop.expect_copies(&file, 1);
    shop.wait_until_taken(3);
    shop.finish_and_compare();
}

fn at_random() {
    let seed = std::env::var("NESTD_SEED").ok().and_then(|seed| seed.parse().ok()).unwrap_or_else(rand::random);
    println!("many_clients_doing_all_of_it_at_random_are_served: NESTD_SEED={seed}");
    let (mut rng, mut shop) = (ChaCha8Rng::seed_from_u64(seed), SambaShop::open());
    for n in 0..30 {
        let (file, name) = (shop.part(*[2, 9, LARGE].get(rng.random_range(0..3)).unwrap()), format!("part-{n}.stl"));
        let size = fs::metadata(&file).unwrap().len() as usize;
        let put = match rng.random_range(0..3) {
            0 => format!("put {} {name}.filepart; rename {name}.filepart {name}", file.display()),
            _ => format!("put {} {name}", file.display()),
        };
        let line = NetworkLine {
            rate: rng.random_range(200_000..3_000_000),
            at: rng.random_range(500..size + 4_000),
            stall: rng.random_bool(0.5).then(|| Duration::from_millis(rng.random_range(0..1500))),
        };
        let client = shop.send_over(line, &put);
        if rng.random_bool(0.15) {
            std::thread::sleep(Duration::from_millis(rng.random_range(0..800)));
            shop.server.restart();
        }
        let output = client.wait_with_output().unwrap();
        if rng.random_bool(0.15) {
            shop.farm.kill();
            shop.farm.start();
        }
        shop.expect_copies(&file, 1);
        let is_through = output.status.success() && !output_text(&output).contains("NT_STATUS");
        if !is_through && !is_taken_by_now(&shop, &file, &name) {
            shop.run_client(&format!("put {} {name}", file.display()));
        }
    }
    shop.finish_and_compare();
}

/// Whether a file has arrived. A client whose connection was cut at the very end cannot know this; a careful client
/// checks before it sends the file again.
fn is_taken_by_now(shop: &SambaShop, file: &std::path::Path, name: &str) -> bool {
    let hash = blake3::hash(&fs::read(file).unwrap()).to_hex().to_string();
    std::thread::sleep(Duration::from_millis(1500));
    let is_taken = shop.farm.query_ledger(async |ledger| !ledger.parts_with_content(&hash).await.unwrap().is_empty());
    is_taken || fs::read(shop.farm.folder("inbox").join(name)).is_ok_and(|bytes| bytes == fs::read(file).unwrap())
}
