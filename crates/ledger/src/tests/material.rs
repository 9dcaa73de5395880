//! Material: no build holds two, and a part of a material that is not loaded waits.

use std::collections::BTreeMap;

use super::*;

const MACHINE: &str = "paper-200";

/// A waiting part of a material, of two copies.
async fn part_of(ledger: &Ledger, claim: &str, material: &str) -> PartId {
    let part = asked(new_part(claim, 2), |terms| terms.material = material.to_owned());
    let id = ledger.record_claim(&part).await.unwrap().id;
    ledger.accept_solids(id, &[solid(0, 2)]).await.unwrap();
    id
}

async fn load(ledger: &Ledger, material: &str) -> String {
    load_lot(ledger, material, "").await
}

async fn load_lot(ledger: &Ledger, material: &str, lot: &str) -> String {
    let (material, lot) = (material.to_owned(), lot.to_owned());
    let word = OperatorWord::Load { machine: MACHINE.to_owned(), material, lot };
    ledger.carry_out(&word, "ann@farm", &SeenFiles::new(), false).await.unwrap().sentences.join(" ")
}

/// The parts that can be in the next build.
async fn candidates(ledger: &Ledger) -> Vec<PartId> {
    ledger.waiting_copies(MACHINE).await.unwrap().into_iter().map(|waiting| waiting.part.id).collect()
}

async fn awaits(ledger: &Ledger, part: PartId) -> bool {
    ledger.find_part(part).await.unwrap().unwrap().owed.awaits_material
}

#[test]
fn case_spaces_hyphens_and_underscores_make_no_difference() {
    for word in ["PA12", "pa 12", "PA-12", " Pa_12 "] {
        assert_eq!(material_key(word), "pa12", "{word:?}");
    }
    assert_ne!(material_key("PA 11"), material_key("PA12"));
    assert_eq!(material_key("ＰＡ12　粉"), "ｐａ12粉");
    assert_eq!(material_key(" - "), "");
}

#[tokio::test]
async fn a_part_goes_only_where_its_material_is_loaded_and_one_without_goes_anywhere() {
    let ledger = fresh().await;
    let (twelve, eleven, any) =
        (part_of(&ledger, "a", "PA12").await, part_of(&ledger, "b", "PA11").await, part_of(&ledger, "c", "").await);
    assert_eq!(candidates(&ledger).await, [any], "nothing is said of the machine");
    let said = load(&ledger, "pa 12").await;
    assert!(said.contains("1 part there waits for another material"), "{said}");
    assert_eq!(candidates(&ledger).await, [twelve, any]);
    let (open, both) = (ledger.open_build(MACHINE).await.unwrap().id, [(twelve, 0), (eleven, 0)]);
    let refused = ledger.begin_nesting(open, "flush", &both).await;
    assert!(matches!(refused, Err(LedgerError::Material(MaterialError::NotLoaded { part, .. })) if part == eleven));
    let build = nesting(&ledger, &[(twelve, 0), (any, 0)]).await;
    assert_eq!(ledger.find_build(build).await.unwrap().unwrap().material, "pa 12");
    let said = load(&ledger, "PA11").await;
    assert!(said.contains(&format!("Build {build} fired before and is of pa 12")), "{said}");
    assert_eq!(candidates(&ledger).await, [eleven, any], "the other copies of a part that is being built wait, too");
    assert!(awaits(&ledger, twelve).await);
    ledger.fail_build(build, "no").await.unwrap();
    assert_eq!(candidates(&ledger).await, [eleven, any]);
    assert_eq!(load(&ledger, "PA11").await, "PA11 was loaded on paper-200 before.");
    load(&ledger, "").await;
    assert_eq!(candidates(&ledger).await, [any]);
    let status = MachineStatus::of_machine(&ledger.machine_statuses().await.unwrap(), MACHINE);
    let awaiting: Vec<_> = status.awaiting.iter().map(|of| (of.material.as_str(), of.parts, of.copies)).collect();
    assert_eq!(
        (awaiting, status.waiting_copies, status.collecting_copies),
        (vec![("PA11", 1, 2), ("PA12", 1, 2)], 6, 2)
    );
    let kinds = ledger.parts_with_questions(9).await.unwrap();
    assert!(kinds.iter().all(|asked| asked.kind == QuestionKind::Material && asked.total == 2), "{kinds:?}");
}

#[tokio::test]
async fn an_edit_a_move_and_a_print_that_went_wrong_are_judged_by_what_is_loaded_then() {
    let ledger = fresh().await;
    let part = part_of(&ledger, "a", "PA12").await;
    let edit = |material: &str| PartEdit { material: Some(material.to_owned()), ..PartEdit::default() };
    load(&ledger, "PA11").await;
    let edited = ledger.edit_part(part, &edit("PA 11"), "ann@farm").await.unwrap();
    assert_eq!((edited.changes[0].as_str(), awaits(&ledger, part).await), ("material PA 11 instead of PA12", false));
    let build = published(&ledger, &[(part, 0), (part, 1)]).await;
    load(&ledger, "PA12").await;
    let word = OperatorWord::Requeue(build);
    let seen = SeenFiles::from([(build, SeenFile::OutOfQueue)]);
    let refused = ledger.carry_out(&word, "ann@farm", &seen, false).await.unwrap_err().to_string();
    assert!(refused.contains("`nestd machine load paper-200 'PA 11'`"), "{refused}");
    let word = OperatorWord::Reprint(ReprintTarget::Build(build));
    ledger.carry_out(&word, "ann@farm", &seen, false).await.unwrap();
    assert!(awaits(&ledger, part).await, "its copies wait again, and not for this material");
    ledger.move_to_machine(part, "fuse-1", false, "ann@farm").await.unwrap();
    ledger.accept_solids(part, &[solid(0, 2)]).await.unwrap();
    assert!(awaits(&ledger, part).await, "nothing is loaded there");
}

#[tokio::test]
async fn a_file_says_what_is_loaded_until_a_person_does_and_a_new_alias_finds_what_waits() {
    let ledger = fresh().await;
    let by_file = |material: &str| BTreeMap::from([(MACHINE.to_owned(), material.to_owned())]);
    let same = |word: &str| word.to_owned();
    ledger.take_over_materials(&by_file("PA12"), &same).await.unwrap();
    let part = part_of(&ledger, "a", "PA2200").await;
    assert!(awaits(&ledger, part).await);
    let known = |word: &str| if material_key(word) == "pa2200" { "PA12".to_owned() } else { word.to_owned() };
    ledger.take_over_materials(&by_file("PA12"), &known).await.unwrap();
    assert_eq!((candidates(&ledger).await, awaits(&ledger, part).await), (vec![part], false));
    assert_eq!(ledger.find_part(part).await.unwrap().unwrap().terms.material, "PA12");
    ledger.take_over_materials(&by_file("PA11"), &known).await.unwrap();
    assert_eq!(ledger.loaded_material(MACHINE).await.unwrap(), "PA11", "as its file says");
    load(&ledger, "PA12").await;
    ledger.take_over_materials(&by_file("PA11"), &known).await.unwrap();
    let loaded = ledger.loaded_materials().await.unwrap();
    assert_eq!((loaded[0].material.as_str(), loaded[0].loaded_by.as_str()), ("PA12", "ann@farm"));
    let events = ledger.last_event_id().await.unwrap();
    ledger.take_over_materials(&by_file("PA11"), &known).await.unwrap();
    assert_eq!(ledger.last_event_id().await.unwrap(), events, "nothing is written where nothing changes");
}

#[tokio::test]
async fn a_build_has_the_lot_that_was_loaded_when_its_printer_took_it() {
    let ledger = fresh().await;
    let said = load_lot(&ledger, "PA12", "4711").await;
    assert!(said.starts_with("PA12, lot 4711, is loaded on paper-200 now"), "{said}");
    let part = part_of(&ledger, "a", "PA12").await;
    let lot_of = async |build: BuildId| ledger.find_build(build).await.unwrap().unwrap().lot;
    let build = published(&ledger, &[(part, 0)]).await;
    assert_eq!(lot_of(build).await, "4711");
    // The powder was changed before the printer took the file.
    load_lot(&ledger, "PA12", "4712").await;
    assert_eq!(lot_of(build).await, "4712");
    let queue = ledger.find_build(build).await.unwrap().unwrap().staged.queue_id.unwrap();
    ledger.record_taken(build, &queue).await.unwrap();
    let taken = ledger.find_build(build).await.unwrap().unwrap().place.taken_at.is_some();
    let said = load_lot(&ledger, "PA11", "9").await;
    assert!(said.contains("PA11, lot 9,"), "{said}");
    assert_eq!((lot_of(build).await, taken), ("4712".to_owned(), true));
    let loaded = ledger.loaded_materials().await.unwrap();
    assert_eq!((loaded[0].material.as_str(), loaded[0].lot.as_str()), ("PA11", "9"));
    let statuses = ledger.machine_statuses().await.unwrap();
    assert_eq!(MachineStatus::of_machine(&statuses, MACHINE).lot, "9");
}
