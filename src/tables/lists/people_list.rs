//! The people of a farm.

use access::Role;
use language::say;
use ledger::PersonRow;

use crate::tables::{columns::table_column::TableColumn, fields};

/// The people of a farm. Nothing secret is among them.
pub const PEOPLE_COLUMNS: &[TableColumn<PersonRow>] = &[
    TableColumn::new("name", fields::NAME, |row| (&row.name).into()),
    TableColumn::new("role", fields::ROLE, |row| row.role.as_str().to_owned().into()),
    TableColumn::new("signs_in", fields::SIGNS_IN, |row| sign_in_ways(row).into()),
    TableColumn::new("signed_in_at", fields::SIGNED_IN, |row| row.signed_in_at.into()),
    TableColumn::new("added_at", fields::SINCE, |row| row.added_at.into()),
    TableColumn::new("added_by", fields::TOLD_BY, |row| (&row.added_by).into()),
];

/// With what a person signs in.
fn sign_in_ways(person: &PersonRow) -> String {
    let ways = [
        (person.has_password, say!("signs-in-password")),
        (person.has_pin, say!("signs-in-pin")),
        (!person.has_password, say!("signs-in-proxy")),
    ];
    ways.into_iter().filter(|(has, _)| *has).map(|(_, way)| way).collect::<Vec<_>>().join(", ")
}

/// What a role may do beyond the one before it.
pub fn role_text(role: Role) -> String {
    match role {
        Role::Read => say!("role-read"),
        Role::Order => say!("role-order"),
        Role::Operate => say!("role-operate"),
        Role::Admin => say!("role-admin"),
    }
}
