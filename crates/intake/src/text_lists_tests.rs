//! Tests of texts that name the files beside them.

use super::{
    order_tree_tests::{HELD, OVER, taken, waits},
    test_inbox::TestInbox,
};

#[test]
fn a_text_with_a_file_and_a_number_in_each_line_is_the_list() {
    for text in [
        "a.stl 5\nb.stl 3",
        "a.stl: 5\nb.stl: 3\n",
        "a.stl - 5 pcs\nb.stl - 3 Stk",
        "a.stl x5\r\n\r\nb.stl\t3x",
        "a.stl = 5 pieces\nB.STL = 3",
    ] {
        for name in ["readme.txt", "parts.txt", "quantities.txt"] {
            let farm = TestInbox::new();
            for part in ["k/a.stl", "k/b.stl"] {
                farm.drop_file(part, "solid");
            }
            farm.drop_file(&format!("k/{name}"), text);
            let copies: Vec<_> = taken(&farm, HELD).into_iter().map(|(_, copies, _)| copies).collect();
            assert_eq!(copies, [Ok(Some(5)), Ok(Some(3))], "{name}: {text}");
        }
    }
}

#[test]
fn a_text_that_names_a_file_beside_it_and_is_no_list_holds_the_parts() {
    let mail = "Hi,\nplease print b.stl 5 times and c.stl twice.\nThanks";
    let table = "# Order\n\n| File | Qty |\n|---|---|\n| b.stl | 5 |\n| c.stl | 2 |\n\nThanks b.stl";
    for (name, text) in [
        ("mail.txt", mail),
        ("mail.eml", mail),
        ("Nachricht.HTML", mail),
        ("mail.rtf", mail),
        ("README.md", table),
        ("readme.txt", "b.stl 5\nc.stl three"),
        ("readme.txt", "b.stl 1.5"),
    ] {
        let farm = TestInbox::new();
        for part in ["k/b.stl", "k/c.stl"] {
            farm.drop_file(part, "solid");
        }
        farm.drop_file(&format!("k/{name}"), text);
        assert_eq!(taken(&farm, HELD), [], "{name}: {text}");
        let why = waits(&farm);
        assert!(why.iter().any(|why| why.starts_with("k/b.stl stands beside")), "{name}: {why:?}");
        let refused = taken(&farm, OVER);
        assert!(refused.len() == 2 && refused.iter().all(|(_, copies, _)| copies.is_err()), "{name}: {refused:?}");
    }
    for (name, text) in [
        ("readme.txt", "print soon"),
        ("license.md", "see lib.stl"),
        ("mail.eml", "thanks"),
        ("b.stl.reason.txt", "b.stl: 5"),
    ] {
        let farm = TestInbox::new();
        farm.drop_file("k/b.stl", "solid");
        farm.drop_file(&format!("k/{name}"), text);
        assert!(taken(&farm, HELD).contains(&("k/b.stl".to_owned(), Ok(None), false)), "{name}");
    }
}
