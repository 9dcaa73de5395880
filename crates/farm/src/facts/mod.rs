//! What is so in the farm, one function for each fact: what a printer and a machine do and when they are free (`printer_fact`,
//! `machine_fact`), how far a build is (`build_fact`), what became of a copy (`copy_fact`), how far a part is (`part_fact`), how an order stands, when it is done and
//! whether that is late (`order_fact`), what its customer can be told (`customer_note`), why a part waits
//! for its material (`material_fact`), how its copies were made (`part_record`), and what a build costs whom (`cost_fact`). These are functions of the plan, the ledger and the time; `read_facts` reads what they need. Every face prints their answers, and has no
//! opinion of its own: pages, JSON, the command line, `STATUS.txt`, `status.json`, metrics and messages.

pub(super) mod build_fact;
pub(super) mod copy_fact;
pub(super) mod cost_fact;
pub(super) mod customer_note;
#[cfg(test)]
mod fact_tests;
pub(super) mod late_fact;
pub(super) mod machine_fact;
pub(super) mod material_fact;
pub(super) mod order_fact;
#[cfg(test)]
mod order_tests;
pub(super) mod part_fact;
pub(super) mod part_record;
pub(super) mod printer_fact;
pub(super) mod read_facts;
