//! Tests of the search, each on every database that this machine has.

use ledger::{NewPartRow, PartState};
use ledger_fixtures::{asked, fresh_file, new_part, published, solid};

use super::*;

/// The ledgers to search: a file, and a database on a server.
async fn ledgers() -> Vec<(Ledger, Box<dyn std::any::Any>)> {
    let file = fresh_file().await;
    let mut all: Vec<(Ledger, Box<dyn std::any::Any>)> = vec![((*file).clone(), Box::new(file))];
    all.push((ledger_fixtures::fresh_on_server().await, Box::new(())));
    all.truncate(2);
    all
}

async fn drop_part(ledger: &Ledger, name: &str, order: &str, customer: &str) -> PartId {
    let part = NewPartRow {
        name: name.to_owned(),
        ..asked(new_part(name, 1), |terms| (terms.order_name, terms.customer) = (order.to_owned(), customer.to_owned()))
    };
    let id = ledger.record_claim(&part).await.unwrap().id;
    ledger.accept_solids(id, &[solid(0, 1)]).await.unwrap();
    id
}

async fn found(ledger: &Ledger, text: &str) -> FoundNames {
    let (one, other) = ("mjf-5200".to_owned(), "Größe-2".to_owned());
    search_names(ledger, &[&one, &other], text, 3).await.unwrap()
}

#[tokio::test]
async fn all_kinds_are_found_by_part_of_a_name_in_any_case_and_by_number() {
    for (ledger, _kept) in ledgers().await {
        let hinge = drop_part(&ledger, "Türscharnier_50%.stl", "Order 1182", "MÜLLER & Söhne").await;
        let other = drop_part(&ledger, "bracket.stl", "Acme", "").await;
        // The same letters in two characters each, as macOS writes them.
        drop_part(&ledger, "u\u{308}bergang.stl", "", "Müller & söhne").await;
        let build = published(&ledger, &[(hinge, 0)]).await;
        let parts =
            async |text: &str| found(&ledger, text).await.parts.rows.iter().map(|part| part.id).collect::<Vec<_>>();
        for text in [
            "SCHARNIER",
            "TÜRSCHARNIER",
            "türsch",
            "50%",
            "p1",
            "P-1",
            "#1",
            "part 1",
            "file scharnier",
            "order 1182 tür",
            "Teil 1",
            "Datei: scharnier",
            "pièce 1",
            "パーツ 1",
            "パーツ1",
        ] {
            assert_eq!(parts(text).await.first(), Some(&hinge), "{text}");
        }
        assert_eq!(parts("ÜBERGANG").await, [PartId(3)], "{:?}", ledger);
        assert_eq!(parts("Bracket acme").await, [other], "all words, wherever they stand");
        for text in ["50_", "turscharnier", "bracket 1182", "p4", "", "  ", "!", "\0"] {
            assert!(found(&ledger, text).await.is_empty(), "{text:?}");
        }
        for text in ["1182", "order 1182", "Auftrag 1182", "commande 1182", "注文 1182", "ORDER"] {
            assert_eq!(found(&ledger, text).await.orders.rows[0].name, "Order 1182", "{text}");
        }
        let customers = found(&ledger, "customer müller").await.customers;
        assert_eq!((customers.total, customers.rows[0].parts, customers.rows[0].orders.len()), (1, 2, 1));
        for text in ["b1", "B-1", "1", "build 1", "Baujob 1", "plateau 1", "ビルド 1", "ビルド1", "PAPER-200_000001"]
        {
            assert_eq!(found(&ledger, text).await.builds.rows.first().map(|row| row.id), Some(build), "{text}");
        }
        assert_eq!(found(&ledger, "p1").await.builds.total, 0);
        assert_eq!(found(&ledger, "GRÖSSE").await.machines.total, 0, "no letter is another one");
        assert_eq!(found(&ledger, "machine GRÖßE").await.machines.rows, ["Größe-2"]);
        assert_eq!(found(&ledger, "scharnier").await.parts.rows[0].state, PartState::Built);
    }
}

#[tokio::test]
async fn of_many_the_newest_are_shown_and_all_are_counted() {
    for (ledger, _kept) in ledgers().await {
        for n in 0..5 {
            drop_part(&ledger, &format!("hinge-{n}.stl"), &format!("H{n}"), "").await;
        }
        let hinges = found(&ledger, "hinge").await.parts;
        let names: Vec<&str> = hinges.rows.iter().map(|part| part.name.as_str()).collect();
        assert_eq!(
            (names, hinges.total, hinges.is_cut()),
            (vec!["hinge-4.stl", "hinge-3.stl", "hinge-2.stl"], 5, false)
        );
    }
}
