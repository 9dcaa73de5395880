//! What is so in the farm, one function for each fact: what a printer and a machine do and when they are free (`printer_fact`,
//! `machine_fact`), how far a build is (`build_fact`), when an order is done and whether that is late (`order_fact`). These are
//! functions of the plan, the ledger and the time; `read_facts` reads what they need. Every face prints their answers, and has no
//! opinion of its own: pages, JSON, the command line, `STATUS.txt`, `status.json`, metrics and messages.

pub(super) mod build_fact;
#[cfg(test)]
mod fact_tests;
pub(super) mod machine_fact;
pub(super) mod order_fact;
pub(super) mod printer_fact;
pub(super) mod read_facts;
